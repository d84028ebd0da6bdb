// How surfaces are seen, and where the cones of their highlights are then.

#import angle

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

// From a unit vector in the frame of the surface: a triangle may be seen of which a vertex faces away.
fn aspect_of(direction: vec3<f32>) -> Aspect {
    let outgoing = normalize(vec3<f32>(direction.xy, max(direction.z, LEAST_HEIGHT)));
    let sin_theta = length(outgoing.xy);
    let azimuth = select(vec2<f32>(1.0, 0.0), outgoing.xy / sin_theta, sin_theta > 0.0);
    let at = angle_of(sin_theta, outgoing.z) * (2.0 * FRAC_1_PI) * f32(NODES - 1u);
    let node = min(u32(at), NODES - 2u);
    return Aspect(sin_theta, outgoing.z, azimuth, node, at - f32(node));
}

// The middle of one of a cone's Gaussians in the frame, on the `side` 1 or −1: it may point below the surface. `turned` are sines and cosines of what it is
// turned away from the mirror direction, along the plane of incidence, away from the normal, and across it.
fn middle_of(turned: vec4<f32>, aspect: Aspect, side: f32) -> vec3<f32> {
    let sine = aspect.sin_theta * turned.y + aspect.cos_theta * turned.x;
    let cosine = aspect.cos_theta * turned.y - aspect.sin_theta * turned.x;
    let across = side * turned.z * vec3<f32>(aspect.azimuth.y, -aspect.azimuth.x, 0.0);
    return turned.w * vec3<f32>(-sine * aspect.azimuth, cosine) + across;
}
