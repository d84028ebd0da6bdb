// Shading normals of shapes that deform, and the lobes blended for them: the GPU twin of `relume_formats::shape::ShadingNormals` and of
// `relume_formats::basis::diffuse::blend`. Every vertex sums the triangles at its place by itself, in their order.

#import invocation
#import lobes
#import rows

struct Surrounded {
    // At rest, of unit length.
    normal: vec3<f32>,
    // Number of the vertex in the scene.
    index: u32,
    // Mean normal of the triangles at rest, of unit length, or 0.
    mean: vec3<f32>,
    // Its first triangle, and the one behind its last.
    first: u32,
    end: u32,
}

@group(0) @binding(0) var<storage, read> vertices: array<Surrounded>;
// [triangles, 3]: vertices of the scene.
@group(0) @binding(1) var<storage, read> triangles: array<u32>;
// [vertices of the scene, 3]: metres, world space.
@group(0) @binding(2) var<storage, read> positions: array<f32>;
// [vertices of the scene, 3]: unit length.
@group(0) @binding(3) var<storage, read_write> normals: array<f32>;
// By vertex of the scene.
@group(0) @binding(4) var<storage, read_write> lobes: array<Lobes>;

const LANES = 64u;
// Nodes along a side of a face of the grid of lobes.
const GRID = 8u;
// Squared sums of unit vectors that are this small are of opposite ones.
const OPPOSITE = 2e-12;

fn corner(k: u32) -> vec3<f32> {
    let at = 3u * triangles[k];
    return vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]);
}

// The unit vector along the sum of the area vectors of triangles `first` to `end`; 0 where there is none.
fn mean_normal(first: u32, end: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var t = first; t < end; t += 1u) {
        let a = corner(3u * t);
        sum += cross(corner(3u * t + 1u) - a, corner(3u * t + 2u) - a);
    }
    // Squares of what is very small or large are no numbers any more.
    let size = max(max(abs(sum.x), abs(sum.y)), abs(sum.z));
    if !(size > 0.0) {
        return vec3<f32>(0.0);
    }
    return normalize(sum / size);
}

// `v` after the smallest turn that takes one unit vector to another: by two reflections, which stay exact to roundings where
// the two are nearly opposite.
fn turned(v: vec3<f32>, before: vec3<f32>, after: vec3<f32>) -> vec3<f32> {
    if all(before == vec3<f32>(0.0)) || all(after == vec3<f32>(0.0)) {
        return v;
    }
    let half = before + after;
    let size = dot(half, half);
    if size < OPPOSITE {
        return -v;
    }
    let mirrored = v - 2.0 * dot(before, v) * before;
    return mirrored - 2.0 * dot(half, mirrored) / size * half;
}

fn face_of(v: vec3<f32>) -> u32 {
    let size = abs(v);
    if size.x >= size.y && size.x >= size.z {
        return select(1u, 0u, v.x >= 0.0);
    }
    if size.y >= size.z {
        return select(3u, 2u, v.y >= 0.0);
    }
    return select(5u, 4u, v.z >= 0.0);
}

// The nodes about a normal, and their weights.
fn blend(normal: vec3<f32>) -> Lobes {
    let face = face_of(normal);
    let seen = on_face(face, normal);
    // The null vector gets those of a node.
    let place = select(vec2<f32>(0.0), seen.xy / seen.z, seen.z > 0.0);
    let at = (place + 1.0) * 0.5 * f32(GRID - 1u);
    let cell = min(vec2<u32>(at), vec2<u32>(GRID - 2u));
    let part = at - vec2<f32>(cell);
    var found: Lobes;
    for (var k = 0u; k < 4u; k += 1u) {
        let beyond = vec2<u32>(k & 1u, k >> 1u);
        let node = cell + beyond;
        let on_cube = 2.0 * vec2<f32>(node) / f32(GRID - 1u) - 1.0;
        let share = select(1.0 - part, part, beyond == vec2<u32>(1u));
        found.rows[k] = (face * GRID + node.y) * GRID + node.x;
        found.weights[k] = share.x * share.y * sqrt((1.0 + dot(on_cube, on_cube)) / (1.0 + dot(place, place)));
    }
    return found;
}

@compute @workgroup_size(64)
fn turn(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = invocation(group, groups, LANES, lane);
    if number >= arrayLength(&vertices) {
        return;
    }
    let vertex = vertices[number];
    let normal = turned(vertex.normal, vertex.mean, mean_normal(vertex.first, vertex.end));
    let at = 3u * vertex.index;
    normals[at] = normal.x;
    normals[at + 1u] = normal.y;
    normals[at + 2u] = normal.z;
    lobes[vertex.index] = blend(normal);
}
