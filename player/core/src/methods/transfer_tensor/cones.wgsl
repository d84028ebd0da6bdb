// Where the cones of a surface are as it is seen, and what of its tables holds then.

#import angle
#import tables

// What is seen from behind shows what it would from this height above the surface.
const LEAST_HEIGHT = 1e-3;
// Angles that tables are at, 0 to 90° evenly.
const NODES = 31u;

// A direction that a surface is seen from.
struct Aspect {
    // Sine and cosine of the angle to the normal.
    sin_theta: f32,
    cos_theta: f32,
    // Cosine and sine of the azimuth.
    azimuth: vec2<f32>,
    // The node before the angle to the normal, and what share the next one has.
    node: u32,
    between: f32,
}

// One or two Gaussians of the angle.
struct Cone {
    // Sines and cosines of what it is turned away from the mirror direction, along and across the plane of incidence.
    sin_tilt: f32,
    cos_tilt: f32,
    sin_side: f32,
    cos_side: f32,
    // Where the filtered map begins, and its size.
    map: u32,
    width: u32,
    height: u32,
    // Number of Gaussians.
    count: u32,
    // Of the ring of points that stand for it beside its middle, if there is one.
    sin_ring: f32,
    cos_ring: f32,
    points: u32,
    // What each band of harmonics shrinks to.
    shrunk: vec4<f32>,
}

fn cone_of(first: u32) -> Cone {
    let turned = row(first);
    let map = tables[first + 1u];
    let ring = row(first + 2u);
    return Cone(
        turned.x, turned.y, turned.z, turned.w,
        map.x, map.y, map.z, map.w,
        ring.x, ring.y, tables[first + 2u].z,
        row(first + 3u),
    );
}

// From a unit vector in the frame of the surface: a triangle may be seen of which a vertex faces away.
fn aspect_of(direction: vec3<f32>) -> Aspect {
    let outgoing = normalize(vec3<f32>(direction.xy, max(direction.z, LEAST_HEIGHT)));
    let sin_theta = length(outgoing.xy);
    let azimuth = select(vec2<f32>(1.0, 0.0), outgoing.xy / sin_theta, sin_theta > 0.0);
    let at = angle_of(sin_theta, outgoing.z) * (2.0 * FRAC_1_PI) * f32(NODES - 1u);
    let node = min(u32(at), NODES - 2u);
    return Aspect(sin_theta, outgoing.z, azimuth, node, at - f32(node));
}

// Of a table by angle with so many columns.
fn at_angle(aspect: Aspect, table: u32, columns: u32, column: u32) -> vec3<f32> {
    let at = table + aspect.node * columns + column;
    return mix(row(at).rgb, row(at + columns).rgb, aspect.between);
}

// The middle of one of a cone's Gaussians in the frame, on the `side` 1 or −1: it may point below the surface.
fn middle_of(cone: Cone, aspect: Aspect, side: f32) -> vec3<f32> {
    let sin_turned = aspect.sin_theta * cone.cos_tilt + aspect.cos_theta * cone.sin_tilt;
    let cos_turned = aspect.cos_theta * cone.cos_tilt - aspect.sin_theta * cone.sin_tilt;
    let within = vec3<f32>(-sin_turned * aspect.azimuth, cos_turned);
    return cone.cos_side * within + side * cone.sin_side * vec3<f32>(aspect.azimuth.y, -aspect.azimuth.x, 0.0);
}
