// Adds up the fragments of pixels that have several, in their order.

#import invocation

struct SharedPixel {
    // Of the band.
    pixel: u32,
    // Its fragments among the sums.
    first: u32,
    end: u32,
}

@group(0) @binding(0) var<storage, read> shared_pixels: array<SharedPixel>;
@group(0) @binding(1) var<storage, read> shared_sums: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> film: array<vec4<f32>>;

@compute @workgroup_size(64)
fn merge(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = invocation(group, groups, 64u, lane);
    if number >= arrayLength(&shared_pixels) {
        return;
    }
    let ours = shared_pixels[number];
    var sum = vec3<f32>(0.0);
    for (var at = ours.first; at < ours.end; at += 1u) {
        sum += shared_sums[at].rgb;
    }
    film[ours.pixel] = vec4<f32>(sum, 0.0);
}
