// What the functions of clusters send under this light: spherical harmonics in world space of each function of vertices, for each source.

#import invocation

struct Batch {
    // Number of the first function of vertices that is here.
    first: u32,
    count: u32,
    // Functions of vertices, those for which there is room, and functions of the light, of each cluster and source.
    vertex_rank: u32,
    vertex_room: u32,
    light_rank: u32,
}

// Words of 16 harmonics.
const PAIRS = 8u;

@group(0) @binding(0) var<uniform> batch: Batch;
// [clusters, sources, functions of vertices, functions of the light, 16] f16
@group(0) @binding(1) var<storage, read> core: array<u32>;
// [clusters, sources, functions of the light]; the fourth component is unused.
@group(0) @binding(2) var<storage, read> lit: array<vec4<f32>>;
// [clusters, sources, room for functions of vertices, 16]; the fourth component is unused.
@group(0) @binding(3) var<storage, read_write> functions: array<vec4<f32>>;

@compute @workgroup_size(64)
fn mix_light(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, 64u, lane);
    let function = index / PAIRS;
    if function >= batch.count {
        return;
    }
    let pair = index % PAIRS;
    let number = batch.first + function;
    let of_source = number / batch.vertex_rank;
    var even = vec3<f32>(0.0);
    var odd = vec3<f32>(0.0);
    for (var n = 0u; n < batch.light_rank; n += 1u) {
        let values = unpack2x16float(core[(function * batch.light_rank + n) * PAIRS + pair]);
        let radiance = lit[of_source * batch.light_rank + n].rgb;
        even += values.x * radiance;
        odd += values.y * radiance;
    }
    let at = 2u * PAIRS * (of_source * batch.vertex_room + number % batch.vertex_rank) + 2u * pair;
    functions[at] = vec4<f32>(even, 0.0);
    functions[at + 1u] = vec4<f32>(odd, 0.0);
}
