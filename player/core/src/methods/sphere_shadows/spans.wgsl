// The texels that triangles cover: the formulas of `relume_formats::basis::span`, where they are explained.

#import rows
#import triangle

// Beyond every texel, and farther than any edge that passes between some.
const NOWHERE = 1e30;
// The flattest that the plane of an edge stands against a row, in parts of its other coordinates.
const PARALLEL = 1e-12;

// An edge as rows see it: it passes the row at t at slope·t + begin or end texel centres, whichever of the two it is for the inner side.
struct Edge {
    slope: f32,
    begin: f32,
    end: f32,
}

fn edge_of(plane: vec3<f32>) -> Edge {
    let least = PARALLEL * (abs(plane.y) + abs(plane.z));
    let direction = select(plane.z, plane.y, plane.y != 0.0);
    let a = select(select(least, -least, direction < 0.0), plane.x, abs(plane.x) > least);
    let scale = 16.0 / a;
    let start = 16.0 - plane.z * scale;
    return Edge(-plane.y * scale, select(-NOWHERE, start, a > 0.0), select(start, NOWHERE, a > 0.0));
}

// The inward normal of the plane through the receiver and the edge from p to q, on a face.
fn plane_of(face: u32, p: vec3<f32>, q: vec3<f32>, is_turned: bool, sign: f32) -> vec3<f32> {
    let outwards = cross(select(p, q, is_turned), select(q, p, is_turned));
    return on_face(face, select(-sign, sign, is_turned) * outwards);
}

// The texels of the row at t that lie within three edges, a bit each.
fn span_of(edges: array<Edge, 3>, t: f32) -> u32 {
    let begin = max(max(edges[0].slope * t + edges[0].begin, edges[1].slope * t + edges[1].begin), edges[2].slope * t + edges[2].begin);
    let end = min(min(edges[0].slope * t + edges[0].end, edges[1].slope * t + edges[1].end), edges[2].slope * t + edges[2].end);
    return bits_from(below(begin)) & ~bits_from(below(end));
}

// Whether corners on a face, each anywhere within `around` of where it is, may reach into the face's pyramid.
fn may_reach(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, around: vec3<f32>) -> bool {
    let ahead = max(max(a.z, b.z), c.z) > -around.z;
    let most = max(max(a.xy + a.z, b.xy + b.z), c.xy + c.z) + around.xy + around.z;
    let least = min(min(a.xy - a.z, b.xy - b.z), c.xy - c.z) - around.xy - around.z;
    return ahead && all(most >= vec2<f32>(0.0)) && all(least <= vec2<f32>(0.0));
}

// First row that corners on a face may reach, and the one behind the last.
fn rows_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec2<u32> {
    let t = vec3<f32>(a.y / a.z, b.y / b.z, c.y / c.z);
    let in_front = vec3<f32>(a.z, b.z, c.z) > vec3<f32>(0.0);
    let low = select(vec3<f32>(-4.0), t, in_front);
    let high = select(vec3<f32>(4.0), t, in_front);
    // A hundredth of a row more covers roundings.
    let first = 16.0 * min(min(low.x, low.y), low.z) + 16.0 - 0.01;
    let last = 16.0 * max(max(high.x, high.y), high.z) + 16.0 + 0.01;
    return vec2<u32>(below(first), below(last));
}

// How high a receiver is above a triangle's plane, given the first corner from it.
fn height_above(triangle: Triangle, a: vec3<f32>) -> f32 {
    return -dot(triangle.normal, a);
}
