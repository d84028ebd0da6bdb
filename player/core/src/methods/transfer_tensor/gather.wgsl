// All that vertices receive, in the columns of the spaces of their materials: direct light, and what spherical harmonics and light from everywhere give,
// as `relume_formats::evaluate::transfer_tensor::shown` begins.

#import frame
#import harmonics
#import invocation
#import places
#import tables

// [columns, vertices of the band]; the fourth component is unused.
@group(0) @binding(2) var<storage, read> direct: array<vec4<f32>>;
// [17, vertices of the band]: 16 harmonics, and irradiance over π after two reflections; the fourth component is unused.
@group(0) @binding(3) var<storage, read> arriving: array<vec4<f32>>;
// [columns, vertices of the band]; the fourth component is unused.
@group(0) @binding(4) var<storage, read_write> received: array<vec4<f32>>;

@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let vertex = invocation(group, groups, 64u, lane);
    if vertex >= look.vertices {
        return;
    }
    let place = places[look.first_vertex + vertex];
    let lobes = lobes_of(place.material);
    if lobes.space >= NO_SPACE {
        return;
    }
    let space = known.spaces[lobes.space];
    let frame = frame_about(place.normal);
    var once: array<vec3<f32>, 16>;
    for (var index = 0u; index < 16u; index += 1u) {
        once[index] = arriving[index * look.vertices + vertex].rgb;
    }
    // What was reflected twice is taken to come evenly from all directions.
    let twice = arriving[16u * look.vertices + vertex].rgb;
    var towards: array<vec3<f32>, 16>;
    for (var index = 0u; index < 16u; index += 1u) {
        let direction = world_from_frame(frame, row(known.directions + index).xyz);
        towards[index] = radiance_of(&once, direction, vec4<f32>(1.0)) + twice;
    }
    for (var column = 0u; column < space.columns; column += 1u) {
        let at = column * look.vertices + vertex;
        var sum = direct[at].rgb;
        for (var index = 0u; index < 16u; index += 1u) {
            sum += row(space.harmonics + index * space.columns + column).x * towards[index];
        }
        received[at] = vec4<f32>(sum, 0.0);
    }
}
