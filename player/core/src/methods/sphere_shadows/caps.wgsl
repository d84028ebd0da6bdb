// The texels that spheres block, for every receiver and face: the GPU twin of `relume_formats::evaluate::sphere_shadows::blocked`, by the row spans of
// `relume_formats::basis::cap`, where the formulas are explained.

#import batch
#import invocation

@group(0) @binding(0) var<uniform> batch: Batch;
// [receivers, 3]: metres, world space.
@group(0) @binding(1) var<storage, read> positions: array<f32>;
// [receivers, 3]: unit length.
@group(0) @binding(2) var<storage, read> normals: array<f32>;
// First sphere of a receiver's own set, the one behind its last, and where its row of `near` begins.
@group(0) @binding(3) var<storage, read> owns: array<vec4<u32>>;
// Centre and radius now.
@group(0) @binding(4) var<storage, read> spheres: array<vec4<f32>>;
// Row after row, a bit for each sphere of a set: 1 where it overlaps the sphere of that row at rest.
@group(0) @binding(5) var<storage, read> near: array<u32>;
// [192, count]: row face·32 + y of each receiver of the batch, neighbours beside each other.
@group(0) @binding(6) var<storage, read_write> bitmaps: array<u32>;

const LANES = 64u;
const SIDE = 32u;
// Beyond every texel.
const FAR = 4.0;

// [32, 64]: the rows of a face, each lane its own.
var<workgroup> rows: array<u32, 2048>;

// The axis in the frame of a face.
fn on_face(face: u32, v: vec3<f32>) -> vec3<f32> {
    switch face {
        case 0u: { return vec3<f32>(-v.z, -v.y, v.x); }
        case 1u: { return vec3<f32>(v.z, -v.y, -v.x); }
        case 2u: { return vec3<f32>(v.x, v.z, v.y); }
        case 3u: { return vec3<f32>(v.x, -v.z, -v.y); }
        case 4u: { return vec3<f32>(v.x, -v.y, v.z); }
        default: { return vec3<f32>(-v.x, -v.y, -v.z); }
    }
}

// Where a·s + k ≥ C·√(s² + e).
fn interval(a: f32, k: f32, root: f32, q: f32, one_over_q: f32, conjugate: f32) -> vec2<f32> {
    let ak = abs(a) * k;
    let ahead = k > 0.0;
    let up = select(ak - root, conjugate, ahead);
    let down = select(q, ak + root, ahead);
    let empty = q > 0.0 && !ahead;
    let low = select(up / down, FAR, empty);
    let high = select(FAR, (ak + root) * one_over_q, q > 0.0 && !empty);
    return select(vec2<f32>(low, high), vec2<f32>(-high, -low), a < 0.0);
}

// How many of the 32 texel centres along a line lie below `s`.
fn edge(s: f32) -> u32 {
    let below = 16.0 * s + 16.0;
    // No number is below none, as in the CPU's code.
    return u32(round(min(select(0.0, below, below > 0.0), f32(SIDE))));
}

// All bits from the `first` on.
fn bits_from(first: u32) -> u32 {
    return select(0xffffffffu << (first & 31u), 0u, first > 31u);
}

// Adds the cap about (a, b, g) whose tangents have the squared length c2.
fn add_cap(lane: u32, axis: vec3<f32>, radius: f32, c2: f32) {
    let a = axis.x;
    let b = axis.y;
    let g = axis.z;
    let c = sqrt(c2);
    let q = c2 - a * a;
    let one_over_q = 1.0 / q;
    let p = g * g - radius * radius;
    var reach = interval(b, g, radius * sqrt(max(q, 0.0)), p, 1.0 / p, q - g * g);
    reach = select(vec2<f32>(-FAR, FAR), reach, q > 0.0);
    let end = edge(reach.y + 0.01 / 16.0);
    for (var y = edge(reach.x - 0.01 / 16.0); y < end; y += 1u) {
        let t = f32(2u * y + 1u) / f32(SIDE) - 1.0;
        let e = 1.0 + t * t;
        let k = b * t + g;
        let inside = k * k - q * e;
        if inside >= 0.0 {
            let span = interval(a, k, c * sqrt(inside), q, one_over_q, c2 * e - k * k);
            rows[y * LANES + lane] |= bits_from(edge(span.x)) & ~bits_from(edge(span.y));
        }
    }
}

@compute @workgroup_size(64)
fn block(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, LANES, lane);
    let face = group.z;
    if index >= batch.count {
        return;
    }
    let receiver = batch.first + index;
    let position = vec3<f32>(positions[3u * receiver], positions[3u * receiver + 1u], positions[3u * receiver + 2u]);
    let normal = vec3<f32>(normals[3u * receiver], normals[3u * receiver + 1u], normals[3u * receiver + 2u]);
    let own = owns[receiver];
    for (var y = 0u; y < SIDE; y += 1u) {
        rows[y * LANES + lane] = 0u;
    }
    var everything = 0u;
    for (var s = 0u; s < batch.spheres; s += 1u) {
        let sphere = spheres[s];
        let offset = sphere.xyz - position;
        if !(dot(normal, offset) > -sphere.w) {
            continue;
        }
        let c2 = dot(offset, offset) - sphere.w * sphere.w;
        if s >= own.x && s < own.y {
            let local = s - own.x;
            if c2 <= 0.0 || ((near[own.z + local / 32u] >> (local % 32u)) & 1u) == 1u {
                continue;
            }
        }
        if c2 <= 0.0 {
            everything = 0xffffffffu;
            break;
        }
        let axis = on_face(face, offset);
        let reach = 1.416 * sphere.w;
        if abs(axis.x) - axis.z <= reach && abs(axis.y) - axis.z <= reach {
            add_cap(lane, axis, sphere.w, c2);
        }
    }
    for (var y = 0u; y < SIDE; y += 1u) {
        bitmaps[(face * SIDE + y) * batch.count + index] = rows[y * LANES + lane] | everything;
    }
}
