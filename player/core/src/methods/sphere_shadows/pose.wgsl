// Where a pose leaves the vertices of shapes that deform: the GPU twin of `relume_formats::shape::DeformingMesh::positions`, in single precision.

#import invocation

struct Vertex {
    // Before it is morphed and skinned.
    position: vec3<f32>,
    // Its number in the scene.
    index: u32,
    // Maps that it follows, and how much.
    joints: vec4<u32>,
    weights: vec4<f32>,
    // Its first delta, and the one behind its last.
    first_delta: u32,
    end_delta: u32,
}

struct Delta {
    offset: vec3<f32>,
    morph: u32,
}

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> deltas: array<Delta>;
// How much of each morph target is added now.
@group(0) @binding(2) var<storage, read> morphs: array<f32>;
// The maps of all joints now: a column here is a row of the map to world space.
@group(0) @binding(3) var<storage, read> maps: array<mat3x4<f32>>;
// [vertices of the scene, 3]: metres, world space.
@group(0) @binding(4) var<storage, read_write> positions: array<f32>;

const LANES = 64u;

@compute @workgroup_size(64)
fn pose(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = invocation(group, groups, LANES, lane);
    if number >= arrayLength(&vertices) {
        return;
    }
    let vertex = vertices[number];
    var position = vertex.position;
    for (var k = vertex.first_delta; k < vertex.end_delta; k += 1u) {
        position += morphs[deltas[k].morph] * deltas[k].offset;
    }
    var map = mat3x4<f32>();
    for (var k = 0u; k < 4u; k += 1u) {
        if vertex.weights[k] > 0.0 {
            map += vertex.weights[k] * maps[vertex.joints[k]];
        }
    }
    let placed = vec4<f32>(position, 1.0) * map;
    let at = 3u * vertex.index;
    positions[at] = placed.x;
    positions[at + 1u] = placed.y;
    positions[at + 2u] = placed.z;
}
