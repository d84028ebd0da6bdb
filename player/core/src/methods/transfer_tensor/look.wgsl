// What vertices show the eye: the GPU twin of `relume_formats::evaluate::transfer_tensor::shown`.

#import frame
#import harmonics
#import hemisphere
#import invocation
#import tables

// [columns, vertices of the band]; the fourth component is unused.
@group(0) @binding(3) var<storage, read> received: array<vec4<f32>>;
// [17, vertices of the band]: 16 harmonics, and irradiance over π after two reflections; the fourth component is unused.
@group(0) @binding(4) var<storage, read> arriving: array<vec4<f32>>;
// [vertices of the band, 24, 24] u8: how much of each texel of the hemisphere is visible, in 255ths.
@group(0) @binding(5) var<storage, read> seen: array<u32>;
// By vertex of the scene, before the light's gain: what the diffuse part would show if it were white, and what the glossy part shows. The fourth component is
// unused.
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> glossy: array<vec4<f32>>;
// The map without suns as cones of each width see it, not turned; the fourth component is unused.
@group(1) @binding(0) var<storage, read> blurred: array<vec4<f32>>;

// What is seen from behind shows what it would from this height above the surface.
const LEAST_HEIGHT = 1e-3;
// Angles that tables are at, 0 to 90° evenly.
const NODES = 31u;
// Sines and cosines of sixths of a turn.
const SIXTHS = array<vec2<f32>, 6>(
    vec2<f32>(0.0, 1.0),
    vec2<f32>(0.8660254, 0.5),
    vec2<f32>(0.8660254, -0.5),
    vec2<f32>(0.0, -1.0),
    vec2<f32>(-0.8660254, -0.5),
    vec2<f32>(-0.8660254, 0.5),
);

// One or two Gaussians of the angle.
struct Cone {
    // Sines and cosines of what it is turned away from the mirror direction, along and across the plane of incidence.
    sin_tilt: f32,
    cos_tilt: f32,
    sin_side: f32,
    cos_side: f32,
    // Where the blurred map begins, and its size.
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

// A vertex as it is seen.
struct Seen {
    // Number in the band.
    vertex: u32,
    frame: Frame,
    // Towards the eye, in the frame.
    outgoing: vec3<f32>,
    // The node before the angle to the normal, and what share the next one has.
    node: u32,
    between: f32,
    twice: vec3<f32>,
}

// Of a table by angle with so many columns.
fn at_angle(seen_from: Seen, table: u32, columns: u32, column: u32) -> vec3<f32> {
    let at = table + seen_from.node * columns + column;
    return mix(row(at).rgb, row(at + columns).rgb, seen_from.between);
}

// The cosine and sine of a multiple of the angle that `turn` has these of.
fn multiple(turn: vec2<f32>, times: u32) -> vec2<f32> {
    var result = vec2<f32>(1.0, 0.0);
    var power = turn;
    for (var left = times; left > 0u; left >>= 1u) {
        if (left & 1u) == 1u {
            result = vec2<f32>(result.x * power.x - result.y * power.y, result.x * power.y + result.y * power.x);
        }
        power = vec2<f32>(power.x * power.x - power.y * power.y, 2.0 * power.x * power.y);
    }
    return result;
}

// What the lobe without cones reflects.
fn residual(seen_from: Seen, space: Space, weights: u32, azimuth: vec2<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    var column = 1u;
    for (var profile = 0u; profile < space.profiles; profile += 1u) {
        let order = tables[space.orders + profile].x;
        let turned = multiple(azimuth, order);
        var value = turned.x * received[column * look.vertices + seen_from.vertex].rgb;
        column += 1u;
        if order > 0u {
            value += turned.y * received[column * look.vertices + seen_from.vertex].rgb;
            column += 1u;
        }
        sum += at_angle(seen_from, weights, space.profiles, profile) * value;
    }
    return sum;
}

fn visible_texel(vertex: u32, index: u32) -> f32 {
    let at = SEEN_SIDE * SEEN_SIDE * vertex + index;
    return f32(extractBits(seen[at / 4u], 8u * (at % 4u), 8u));
}

// How much of what is in a direction in the frame, whose z is above 0, is visible.
fn visibility(vertex: u32, direction: vec3<f32>) -> f32 {
    let last = f32(SEEN_SIDE - 1u);
    let at = clamp(place_in_square(direction) * f32(SEEN_SIDE) - 0.5, vec2<f32>(0.0), vec2<f32>(last));
    let first = min(floor(at), vec2<f32>(last - 1.0));
    let share = at - first;
    let index = u32(first.y) * SEEN_SIDE + u32(first.x);
    let top = mix(visible_texel(vertex, index), visible_texel(vertex, index + 1u), share.x);
    let bottom = mix(visible_texel(vertex, index + SEEN_SIDE), visible_texel(vertex, index + SEEN_SIDE + 1u), share.x);
    return mix(top, bottom, share.y) / 255.0;
}

// The light as a cone sees it in a direction in world space: the GPU twin of `relume_formats::basis::blurred::radiance`.
fn light_towards(cone: Cone, direction: vec3<f32>) -> vec3<f32> {
    let x = look.cos_rotation * direction.x - look.sin_rotation * direction.z;
    let z = look.cos_rotation * direction.z + look.sin_rotation * direction.x;
    let size = vec2<f32>(f32(cone.width), f32(cone.height));
    let uv = vec2<f32>(0.5 + 0.5 * FRAC_1_PI * angle_of(x, -z), FRAC_1_PI * angle_of(length(vec2<f32>(x, z)), direction.y));
    let at = uv * size - 0.5;
    let first = floor(at);
    let share = at - first;
    let left = (u32(i32(first.x) + i32(cone.width))) % cone.width;
    let right = (left + 1u) % cone.width;
    let upper = cone.map + cone.width * u32(clamp(first.y, 0.0, size.y - 1.0));
    let lower = cone.map + cone.width * u32(clamp(first.y + 1.0, 0.0, size.y - 1.0));
    let top = mix(blurred[upper + left].rgb, blurred[upper + right].rgb, share.x);
    let bottom = mix(blurred[lower + left].rgb, blurred[lower + right].rgb, share.x);
    return mix(top, bottom, share.y);
}

// What arrives in a Gaussian of a cone about a unit vector in the frame, which may point below the surface.
fn in_cone(seen_from: Seen, cone: Cone, direction: vec3<f32>, once: ptr<function, array<vec3<f32>, 16>>) -> vec3<f32> {
    let around = frame_about(direction);
    var visible = 0.0;
    var above = 0.0;
    for (var number = 0u; number < cone.points; number += 1u) {
        var point = direction;
        if number > 0u {
            let turn = SIXTHS[number - 1u];
            point = cone.cos_ring * direction + cone.sin_ring * (turn.y * around.tangent + turn.x * around.bitangent);
        }
        if point.z > 0.0 {
            visible += visibility(seen_from.vertex, point);
            above += 1.0;
        }
    }
    let towards = world_from_frame(seen_from.frame, direction);
    let after_once = radiance_of(once, towards, cone.shrunk);
    return (visible * light_towards(cone, towards) + above * seen_from.twice) / f32(cone.points) + after_once;
}

fn cones(seen_from: Seen, space: Space, shares: u32, azimuth: vec2<f32>) -> vec3<f32> {
    var once: array<vec3<f32>, 16>;
    for (var index = 0u; index < 16u; index += 1u) {
        once[index] = arriving[index * look.vertices + seen_from.vertex].rgb;
    }
    let sin_theta = length(seen_from.outgoing.xy);
    var sum = vec3<f32>(0.0);
    for (var number = 0u; number < space.cones; number += 1u) {
        let share = at_angle(seen_from, shares, space.cones, number);
        if all(share == vec3<f32>(0.0)) {
            continue;
        }
        let cone = cone_of(space.first_cone + 4u * number);
        let sin_turned = sin_theta * cone.cos_tilt + seen_from.outgoing.z * cone.sin_tilt;
        let cos_turned = seen_from.outgoing.z * cone.cos_tilt - sin_theta * cone.sin_tilt;
        let middle = cone.cos_side * vec3<f32>(-azimuth * sin_turned, cos_turned);
        let across = cone.sin_side * vec3<f32>(azimuth.y, -azimuth.x, 0.0);
        var arrives = in_cone(seen_from, cone, middle + across, &once);
        if cone.count > 1u {
            arrives = 0.5 * (arrives + in_cone(seen_from, cone, middle - across, &once));
        }
        sum += share * arrives;
    }
    return sum;
}

@compute @workgroup_size(64)
fn show(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let vertex = invocation(group, groups, 64u, lane);
    if vertex >= look.vertices {
        return;
    }
    let number = look.first_vertex + vertex;
    let place = places[number];
    let frame = frame_about(place.normal);
    let way = look.eye - place.position;
    let far = length(way);
    let from_frame = frame_from_world(frame, select(place.normal, way / far, far > 0.0));
    // A triangle may be seen of which a vertex faces away.
    let outgoing = normalize(vec3<f32>(from_frame.xy, max(from_frame.z, LEAST_HEIGHT)));
    let lobes = lobes_of(place.material);
    if lobes.space >= NO_SPACE {
        radiance[number] = vec4<f32>(0.0);
        glossy[number] = vec4<f32>(0.0);
        return;
    }
    let space = look.spaces[lobes.space];
    let flat = length(outgoing.xy);
    let azimuth = select(vec2<f32>(1.0, 0.0), outgoing.xy / flat, flat > 0.0);
    let at = angle_of(flat, outgoing.z) * (2.0 * FRAC_1_PI) * f32(NODES - 1u);
    let node = min(u32(at), NODES - 2u);
    let twice = arriving[16u * look.vertices + vertex].rgb;
    let seen_from = Seen(vertex, frame, outgoing, node, at - f32(node), twice);
    let even = at_angle(seen_from, space.even, 1u, 0u).x;
    radiance[number] = vec4<f32>(max(even * received[vertex].rgb, vec3<f32>(0.0)), 0.0);
    let rest = residual(seen_from, space, lobes.weights, azimuth);
    glossy[number] = vec4<f32>(max(rest + cones(seen_from, space, lobes.shares, azimuth), vec3<f32>(0.0)), 0.0);
}
