// A band of the film from its samples: the mean of two by two for each pixel.

#import invocation

@group(0) @binding(0) var samples: texture_2d<f32>;
// Linear radiance of the band, row by row; the fourth component is unused.
@group(0) @binding(1) var<storage, read_write> film: array<vec4<f32>>;

@compute @workgroup_size(64)
fn average(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, 64u, lane);
    if index >= arrayLength(&film) {
        return;
    }
    let width = textureDimensions(samples).x / 2u;
    let at = 2u * vec2<u32>(index % width, index / width);
    let top = textureLoad(samples, at, 0) + textureLoad(samples, at + vec2<u32>(1u, 0u), 0);
    let bottom = textureLoad(samples, at + vec2<u32>(0u, 1u), 0) + textureLoad(samples, at + vec2<u32>(1u, 1u), 0);
    film[index] = vec4<f32>(0.25 * (top + bottom).rgb, 0.0);
}
