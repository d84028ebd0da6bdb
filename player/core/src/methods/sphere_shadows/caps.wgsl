// The texels that triangles and spheres block, for every receiver and face: the GPU twin of `relume_formats::evaluate::sphere_shadows::blocked`, by the row
// spans of `relume_formats::basis::cap` and `span`, where the formulas are explained.

#import batch
#import invocation
#import rows
#import spans
#import triangle

@group(0) @binding(0) var<uniform> batch: Batch;
// [receivers, 3]: metres, world space.
@group(0) @binding(1) var<storage, read> positions: array<f32>;
// [receivers, 3]: unit length.
@group(0) @binding(2) var<storage, read> normals: array<f32>;
// First sphere of a receiver's own set, the one behind its last, where its row of `near` begins, and its object.
@group(0) @binding(3) var<storage, read> owns: array<vec4<u32>>;
// Centre and radius now.
@group(0) @binding(4) var<storage, read> spheres: array<vec4<f32>>;
// Row after row, a bit for each sphere of a set: 1 where it overlaps the sphere of that row at rest.
@group(0) @binding(5) var<storage, read> near: array<u32>;
// [192, count]: row face·32 + y of each receiver of the batch, neighbours beside each other.
@group(0) @binding(6) var<storage, read_write> bitmaps: array<u32>;
// The triangles that cast shadows, where they are now; one of no area if there are none.
@group(0) @binding(7) var<storage, read> triangles: array<Triangle>;
// The two vertices between which a receiver is on a rim, or itself twice.
@group(0) @binding(8) var<storage, read> beside: array<vec2<u32>>;

const LANES = 64u;
// How far within its surface a receiver on a rim is, in parts of the way to the middle between those beside it.
const SHARE = 1.0 / 64.0;
// Beyond every texel.
const FAR = 4.0;
// Room for roundings in the box around a workgroup's receivers, in parts of the largest coordinate.
const ROUNDING = 1.0 / 1048576.0;

// [32, 64]: the rows of a face, each lane its own.
var<workgroup> rows: array<u32, 2048>;
// The box around the receivers of the workgroup.
var<workgroup> least: array<vec3<f32>, 64>;
var<workgroup> most: array<vec3<f32>, 64>;
// Triangles, of a run of 64, that may be seen on the face by one of the receivers.
var<workgroup> seen: array<u32, 64>;
var<workgroup> count: atomic<u32>;

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
    let end = below(16.0 * reach.y + 16.01);
    for (var y = below(16.0 * reach.x + 15.99); y < end; y += 1u) {
        let t = centre(y);
        let e = 1.0 + t * t;
        let k = b * t + g;
        let inside = k * k - q * e;
        if inside >= 0.0 {
            let span = interval(a, k, c * sqrt(inside), q, one_over_q, c2 * e - k * k);
            rows[y * LANES + lane] |= bits_from(below(16.0 * span.x + 16.0)) & ~bits_from(below(16.0 * span.y + 16.0));
        }
    }
}

struct Receiver {
    position: vec3<f32>,
    normal: vec3<f32>,
    own: vec4<u32>,
}

fn vertex_at(index: u32) -> vec3<f32> {
    let at = 3u * index;
    return vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]);
}

// The rule of `relume_formats::shape::Rims`.
fn received_at(index: u32) -> vec3<f32> {
    let vertex = vertex_at(index);
    let others = beside[index];
    return vertex + 0.5 * SHARE * ((vertex_at(others.x) - vertex) + (vertex_at(others.y) - vertex));
}

fn receiver_at(index: u32) -> Receiver {
    let at = 3u * index;
    return Receiver(
        received_at(index),
        vec3<f32>(normals[at], normals[at + 1u], normals[at + 2u]),
        owns[index],
    );
}

// Leaves the box around all receivers of the workgroup in the first lane's place.
fn gather_box(lane: u32, position: vec3<f32>) {
    least[lane] = position;
    most[lane] = position;
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            least[lane] = min(least[lane], least[lane + half]);
            most[lane] = max(most[lane], most[lane + half]);
        }
    }
    workgroupBarrier();
}

// Whether a triangle may count for a receiver in the box, and be seen on the face.
fn may_be_seen(face: u32, triangle: Triangle) -> bool {
    let middle = 0.5 * (least[0] + most[0]);
    let largest = max(max(abs(least[0]), abs(most[0])), vec3<f32>(0.0));
    let half = 0.5 * (most[0] - least[0]) + vec3<f32>(ROUNDING * max(max(largest.x, largest.y), largest.z));
    let a = triangle.a - middle;
    let reach = dot(abs(triangle.normal), half);
    let height = height_above(triangle, a);
    if height + reach <= min(triangle.own_above, triangle.above) && reach - height <= min(triangle.own_below, triangle.below) {
        return false;
    }
    return may_reach(on_face(face, a), on_face(face, triangle.b - middle), on_face(face, triangle.c - middle), abs(on_face(face, half)));
}

// Adds a triangle to the rows of a lane.
fn add_triangle(lane: u32, face: u32, receiver: Receiver, triangle: Triangle) {
    let a = triangle.a - receiver.position;
    let b = triangle.b - receiver.position;
    let c = triangle.c - receiver.position;
    let height = height_above(triangle, a);
    let is_own = triangle.object == receiver.own.w;
    let counts = height > select(triangle.above, triangle.own_above, is_own) || -height > select(triangle.below, triangle.own_below, is_own);
    let highest = max(max(dot(receiver.normal, a), dot(receiver.normal, b)), dot(receiver.normal, c));
    if !counts || !(highest > 0.0) {
        return;
    }
    let range = rows_of(on_face(face, a), on_face(face, b), on_face(face, c));
    let sign = select(-1.0, 1.0, height > 0.0);
    let edges = array<Edge, 3>(
        edge_of(plane_of(face, a, b, (triangle.turned & 1u) != 0u, sign)),
        edge_of(plane_of(face, b, c, (triangle.turned & 2u) != 0u, sign)),
        edge_of(plane_of(face, c, a, (triangle.turned & 4u) != 0u, sign)),
    );
    for (var y = range.x; y < range.y; y += 1u) {
        rows[y * LANES + lane] |= span_of(edges, centre(y));
    }
}

// Adds all triangles that may be seen from the workgroup's receivers.
fn add_triangles(lane: u32, face: u32, receiver: Receiver) {
    gather_box(lane, receiver.position);
    for (var first = 0u; first < arrayLength(&triangles); first += LANES) {
        if lane == 0u {
            atomicStore(&count, 0u);
        }
        workgroupBarrier();
        if first + lane < arrayLength(&triangles) && may_be_seen(face, triangles[first + lane]) {
            seen[atomicAdd(&count, 1u)] = first + lane;
        }
        workgroupBarrier();
        let found = atomicLoad(&count);
        for (var k = 0u; k < found; k += 1u) {
            add_triangle(lane, face, receiver, triangles[seen[k]]);
        }
        workgroupBarrier();
    }
}

// Adds all spheres; all bits if one holds the receiver.
fn add_spheres(lane: u32, face: u32, receiver: Receiver) -> u32 {
    for (var s = 0u; s < batch.spheres; s += 1u) {
        let sphere = spheres[s];
        let offset = sphere.xyz - receiver.position;
        if !(dot(receiver.normal, offset) > -sphere.w) {
            continue;
        }
        let c2 = dot(offset, offset) - sphere.w * sphere.w;
        if s >= receiver.own.x && s < receiver.own.y {
            let local = s - receiver.own.x;
            if c2 <= 0.0 || ((near[receiver.own.z + local / 32u] >> (local % 32u)) & 1u) == 1u {
                continue;
            }
        }
        if c2 <= 0.0 {
            return 0xffffffffu;
        }
        let axis = on_face(face, offset);
        let reach = 1.416 * sphere.w;
        if abs(axis.x) - axis.z <= reach && abs(axis.y) - axis.z <= reach {
            add_cap(lane, axis, sphere.w, c2);
        }
    }
    return 0u;
}

@compute @workgroup_size(64)
fn block(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, LANES, lane);
    let face = group.z;
    // Lanes beyond the last do its work again and leave nothing.
    let receiver = receiver_at(batch.first + min(index, batch.count - 1u));
    for (var y = 0u; y < SIDE; y += 1u) {
        rows[y * LANES + lane] = 0u;
    }
    add_triangles(lane, face, receiver);
    let everything = add_spheres(lane, face, receiver);
    if index < batch.count {
        for (var y = 0u; y < SIDE; y += 1u) {
            bitmaps[(face * SIDE + y) * batch.count + index] = rows[y * LANES + lane] | everything;
        }
    }
}
