// What vertices show the eye, but for what their highlights have of the map itself: the GPU twin of `relume_formats::evaluate::transfer_tensor::shown`.

#import aspect
#import filtered
#import frame
#import harmonics
#import hemisphere
#import invocation
#import places
#import tables

// [columns, vertices of the band]; the fourth component is unused.
@group(0) @binding(2) var<storage, read> received: array<vec4<f32>>;
// [17, vertices of the band]: 16 harmonics, and irradiance over π after two reflections; the fourth component is unused.
@group(0) @binding(3) var<storage, read> arriving: array<vec4<f32>>;
// [vertices of the band, 24, 24] u8: how much of each texel of the hemisphere is visible, in 255ths.
@group(0) @binding(4) var<storage, read> seen: array<u32>;
// By vertex of the scene, before the light's gain: what the diffuse part would show if it were white, and what the glossy part shows. The fourth component is
// unused.
@group(0) @binding(5) var<storage, read_write> radiance: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> glossy: array<vec4<f32>>;
// [vertices of the scene, 4] the visible parts of 16 cones.
@group(0) @binding(7) var<storage, read_write> visible: array<vec4<f32>>;

// Sines and cosines of sixths of a turn.
const SIXTHS = array<vec2<f32>, 6>(
    vec2<f32>(0.0, 1.0),
    vec2<f32>(0.8660254, 0.5),
    vec2<f32>(0.8660254, -0.5),
    vec2<f32>(0.0, -1.0),
    vec2<f32>(-0.8660254, -0.5),
    vec2<f32>(-0.8660254, 0.5),
);
// Wide words of the visible parts of a vertex.
const VISIBLE_WORDS = 4u;

// One or two Gaussians of the angle.
struct Cone {
    // How they are turned away from the mirror direction.
    turned: vec4<f32>,
    // The cones that stand for one: its middle and a ring about it, and each of these and a ring about that. Sine and cosine of both.
    rings: vec4<f32>,
    // How many they are, 1 or 7, of each kind; number of Gaussians.
    counts: vec3<u32>,
    // Where the map filtered for them is.
    map: vec3<u32>,
    // What each band of harmonics shrinks to.
    shrunk: vec4<f32>,
}

fn cone_of(first: u32) -> Cone {
    return Cone(row(first), row(first + 1u), tables[first + 2u].xyz, tables[first + 3u].xyz, row(first + 4u));
}

// Of a table by angle with so many columns.
fn at_angle(aspect: Aspect, table: u32, columns: u32, column: u32) -> vec3<f32> {
    let at = table + aspect.node * columns + column;
    return mix(row(at).rgb, row(at + columns).rgb, aspect.between);
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
fn residual(vertex: u32, aspect: Aspect, space: Space, weights: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    var column = 1u;
    for (var profile = 0u; profile < space.profiles; profile += 1u) {
        let order = tables[space.orders + profile].x;
        let turned = multiple(aspect.azimuth, order);
        var value = turned.x * received[column * look.vertices + vertex].rgb;
        column += 1u;
        if order > 0u {
            value += turned.y * received[column * look.vertices + vertex].rgb;
            column += 1u;
        }
        sum += at_angle(aspect, weights, space.profiles, profile) * value;
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

// Place number `number` of a middle and a ring about it, by the ring's sine and cosine.
fn on_ring(middle: vec3<f32>, number: u32, ring: vec2<f32>) -> vec3<f32> {
    if number == 0u {
        return middle;
    }
    let around = frame_about(middle);
    let turn = SIXTHS[number - 1u];
    return ring.y * middle + ring.x * (turn.y * around.tangent + turn.x * around.bitangent);
}

// Of a cone about a unit vector in the frame, which may point below the surface, the part of its light from the map that is visible, of red, green and blue
// together, and the part of it that is above the surface.
fn parts_of(vertex: u32, frame: Frame, cone: Cone, direction: vec3<f32>) -> vec2<f32> {
    let count = cone.counts.x * cone.counts.y;
    // Light, what of it is visible, visible places, and those above.
    var sums = vec4<f32>(0.0);
    for (var number = 0u; number < count; number += 1u) {
        let part = on_ring(direction, number / cone.counts.y, cone.rings.xy);
        let point = on_ring(part, number % cone.counts.y, cone.rings.zw);
        let light = dot(light_towards(cone.map, world_from_frame(frame, point)), vec3<f32>(1.0));
        if point.z > 0.0 {
            let seen_there = visibility(vertex, point);
            sums += vec4<f32>(light, light * seen_there, seen_there, 1.0);
        } else {
            sums.x += light;
        }
    }
    let visible_part = select(sums.z / f32(count), sums.y / sums.x, sums.x > 0.0);
    return vec2<f32>(visible_part, sums.w / f32(count));
}

// What cones have of light that other surfaces reflect; stores their visible parts.
fn reflected(vertex: u32, frame: Frame, aspect: Aspect, space: Space, shares: u32) -> vec3<f32> {
    var once: array<vec3<f32>, 16>;
    for (var index = 0u; index < 16u; index += 1u) {
        once[index] = arriving[index * look.vertices + vertex].rgb;
    }
    let twice = arriving[16u * look.vertices + vertex].rgb;
    var sum = vec3<f32>(0.0);
    for (var word = 0u; word < VISIBLE_WORDS; word += 1u) {
        var of_word = vec4<f32>(0.0);
        for (var k = 0u; k < 4u && 4u * word + k < space.cones; k += 1u) {
            let number = 4u * word + k;
            let cone = cone_of(space.first_cone + 5u * number);
            let share = at_angle(aspect, shares, space.cones, number) / f32(cone.counts.z);
            for (var which = 0u; which < cone.counts.z; which += 1u) {
                let direction = middle_of(cone.turned, aspect, 1.0 - 2.0 * f32(which));
                let parts = parts_of(vertex, frame, cone, direction);
                of_word[k] += parts.x / f32(cone.counts.z);
                if any(share != vec3<f32>(0.0)) {
                    let after_once = radiance_of(&once, world_from_frame(frame, direction), cone.shrunk);
                    sum += share * (after_once + parts.y * twice);
                }
            }
        }
        visible[VISIBLE_WORDS * (look.first_vertex + vertex) + word] = of_word;
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
    let lobes = lobes_of(place.material);
    if lobes.space >= NO_SPACE {
        radiance[number] = vec4<f32>(0.0);
        glossy[number] = vec4<f32>(0.0);
        return;
    }
    let space = known.spaces[lobes.space];
    let frame = frame_about(place.normal);
    let way = look.eye - place.position;
    let far = length(way);
    let aspect = aspect_of(frame_from_world(frame, select(place.normal, way / far, far > 0.0)));
    let even = at_angle(aspect, space.even, 1u, 0u);
    radiance[number] = vec4<f32>(max(even * received[vertex].rgb, vec3<f32>(0.0)), 0.0);
    let rest = residual(vertex, aspect, space, lobes.weights);
    glossy[number] = vec4<f32>(rest + reflected(vertex, frame, aspect, space, lobes.shares), 0.0);
}
