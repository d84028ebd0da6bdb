// Brings the triangles that cast shadows to where their vertices are now.

#import invocation
#import triangle

struct Caster {
    // Corners, vertices of the scene.
    vertices: vec3<u32>,
    object: u32,
    // How far the corners are before these, along their normals, metres.
    offsets: vec3<f32>,
    own_above: f32,
    own_below: f32,
    above: f32,
    below: f32,
}

@group(0) @binding(0) var<storage, read> casters: array<Caster>;
// [vertices, 3]: metres, world space.
@group(0) @binding(1) var<storage, read> positions: array<f32>;
// [vertices, 3]: unit length.
@group(0) @binding(2) var<storage, read> normals: array<f32>;
@group(0) @binding(3) var<storage, read_write> triangles: array<Triangle>;

const LANES = 64u;

fn corner(vertex: u32, offset: f32) -> vec3<f32> {
    let at = 3u * vertex;
    let position = vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]);
    return position + offset * vec3<f32>(normals[at], normals[at + 1u], normals[at + 2u]);
}

@compute @workgroup_size(64)
fn place(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, LANES, lane);
    if index >= arrayLength(&casters) {
        return;
    }
    let caster = casters[index];
    let v = caster.vertices;
    let a = corner(v.x, caster.offsets.x);
    let b = corner(v.y, caster.offsets.y);
    let c = corner(v.z, caster.offsets.z);
    let area = cross(b - a, c - a);
    let size = length(area);
    // What has no area is seen from nowhere: heights above it are 0.
    let normal = select(vec3<f32>(0.0), area / size, size > 0.0);
    let turned = select(0u, 1u, v.x > v.y) | select(0u, 2u, v.y > v.z) | select(0u, 4u, v.z > v.x);
    triangles[index] = Triangle(a, caster.object, b, turned, c, caster.own_above, normal, caster.own_below, caster.above, caster.below);
}
