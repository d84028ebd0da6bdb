// What a point of a picture receives of the suns: the GPU twin of `relume_formats::evaluate::suns`, with the visible share of a sun's disc from its
// shadow map.
//
// First what stands before the disc is looked for, and how far away it is; as far from the edge of its shadow the disc's width there smears it, so
// that shadows are sharp where they begin and soft far from what throws them (Fernando, Percentage-closer soft shadows, 2005). Texels are compared with
// the plane of the surface at their own centre, not with the point itself, so that a surface does not shadow itself however it is turned, and shadows
// begin where things touch.

#import pi
#import sun

@group(2) @binding(0) var<uniform> suns: Suns;
// A layer for each sun.
@group(2) @binding(1) var shadows: texture_depth_2d_array;

// The angle between neighbours of a spiral that fills a disc evenly.
const GOLDEN_ANGLE = 2.39996322972865;
// Looks for what stands before the disc, and most looks at its shadow, from each sample of a pixel; the samples of a pixel look at different places.
const SEARCHES = 16u;
const MOST_LOOKS = 32.0;
const SAMPLES = 4u;
// Of what is beside a point, only what rises above its surface by this part of the least slope of what could stand before the disc counts: a mesh that
// is round rises by less above its facets.
const LEAST_RISE = 0.1;
// How steeply a facet of a round mesh may rise above the next one, 11 degrees: within half a texel of a point it shadows nothing.
const FACET_RISE = 0.2;

// A point of a surface as a sun sees it.
struct Lit {
    layer: u32,
    // Where it is on the shadow map, in texels.
    at: vec2<f32>,
    // Metres for a texel.
    texel: vec2<f32>,
    // Towards the sun from the middle of the box, metres.
    height: f32,
    // How much the surface rises towards the sun for each metre along the map.
    slope: vec2<f32>,
    // Tangent of the sun's radius.
    tangent: f32,
    half_depth: f32,
    // What rounding may raise the surface by, and the next facet of a round mesh within half a texel, metres.
    rounding: f32,
}

// How high above the point's own height what the sun sees at a texel is, and what of that is above the point's surface, metres.
fn rise(lit: Lit, texel: vec2<i32>) -> vec2<f32> {
    let size = vec2<i32>(textureDimensions(shadows));
    if any(texel < vec2<i32>(0)) || any(texel >= size) {
        return vec2<f32>(-1.0);
    }
    let seen = (2.0 * textureLoad(shadows, texel, lit.layer, 0) - 1.0) * lit.half_depth - lit.height;
    let aside = (vec2<f32>(texel) + 0.5 - lit.at) * lit.texel;
    // A texel tells what stands at its middle; up to half of one nearer may be where it ends.
    let beyond = max(length(aside) - 0.5 * max(lit.texel.x, lit.texel.y), 0.0);
    return vec2<f32>(seen, seen - dot(lit.slope, aside) - lit.rounding - LEAST_RISE * beyond / lit.tangent);
}

// The share of the four texels around a place that are shadowed, linear between their centres.
fn shadow(lit: Lit, at: vec2<f32>) -> f32 {
    let first = floor(at - 0.5);
    let share = at - 0.5 - first;
    let texel = vec2<i32>(first);
    let top = mix(blocks(lit, texel), blocks(lit, texel + vec2<i32>(1, 0)), share.x);
    let bottom = mix(blocks(lit, texel + vec2<i32>(0, 1)), blocks(lit, texel + vec2<i32>(1, 1)), share.x);
    return mix(top, bottom, share.y);
}

fn blocks(lit: Lit, texel: vec2<i32>) -> f32 {
    return select(0.0, 1.0, rise(lit, texel).y > 0.0);
}

// Place number `index` of `count` on a disc of radius 1: its distance from the middle is `distance` of its share.
fn on_spiral(index: u32, distance: f32) -> vec2<f32> {
    let angle = GOLDEN_ANGLE * f32(index);
    return distance * vec2<f32>(cos(angle), sin(angle));
}

// Looks as far away as `reach` for what stands before the sun's disc. Its height times how much of the disc it hides, and how much that is, each summed
// over the looks; and how high the highest is that stands above the surface there, before the disc or beside it. Metres.
fn search(lit: Lit, sample: u32, reach: f32) -> vec3<f32> {
    var found = vec3<f32>(0.0);
    for (var k = 0u; k < SEARCHES; k += 1u) {
        // More looks near the middle: what is near casts a small shadow.
        let index = SAMPLES * k + sample;
        let share = (f32(index) + 0.5) / f32(SAMPLES * SEARCHES);
        let distance = reach * share * sqrt(share);
        let texel = vec2<i32>(floor(lit.at + on_spiral(index, distance) / lit.texel));
        let risen = rise(lit, texel);
        if min(risen.x, risen.y) <= 0.0 {
            continue;
        }
        found.z = max(found.z, risen.x);
        let aside = length((vec2<f32>(texel) + 0.5 - lit.at) * lit.texel);
        // To stand before the disc it must be nearer to it, and as steeply above as the disc's edge.
        if aside <= risen.x * lit.tangent + max(lit.texel.x, lit.texel.y) {
            // The part of the disc's plane that a look stands for: its share of the spiral, but a texel at least.
            let area = max(3.0 * PI / f32(SEARCHES) * (reach * share) * (reach * share), lit.texel.x * lit.texel.y);
            // As large as the disc seems there, of which no look hides more than all.
            let radius = risen.x * lit.tangent;
            let hidden = area / max(radius * radius, area * FRAC_1_PI);
            found += vec3<f32>(hidden * risen.x, hidden, 0.0);
        }
    }
    return found;
}

// The mean height of what stands before the sun's disc, by how much of it each thing hides, metres; 0 if nothing does.
fn blocker_height(lit: Lit, sample: u32) -> f32 {
    // As far away as the top of the scene could stand before the disc, and then no farther than what was found there can: those looks are closer.
    let far = search(lit, sample, lit.tangent * (lit.half_depth - lit.height));
    if far.z <= 0.0 {
        return 0.0;
    }
    let sum = far + search(lit, sample, lit.tangent * far.z + max(lit.texel.x, lit.texel.y));
    return select(0.0, sum.x / sum.y, sum.y > 0.0);
}

// The share of the sun's disc that is not shadowed.
fn unshadowed(lit: Lit, sample: u32) -> f32 {
    let height = blocker_height(lit, sample);
    if height <= 0.0 {
        return 1.0 - shadow(lit, lit.at);
    }
    let radius = height * lit.tangent / lit.texel;
    let looks = u32(clamp(2.0 * max(radius.x, radius.y) * max(radius.x, radius.y), 1.0, MOST_LOOKS));
    var sum = 0.0;
    for (var k = 0u; k < looks; k += 1u) {
        let index = SAMPLES * k + sample;
        let distance = sqrt((f32(index) + 0.5) / f32(SAMPLES * looks));
        sum += shadow(lit, lit.at + on_spiral(index, distance) * radius);
    }
    return 1.0 - sum / f32(looks);
}

// The share of a disc that is above a line at `height` radii below its middle.
fn share_above(height: f32) -> f32 {
    let h = clamp(height, -1.0, 1.0);
    return 0.5 + FRAC_1_PI * (h * sqrt(1.0 - h * h) + asin(h));
}

// Radiance that a white diffuse surface shows of sun number `layer`, before the gain. The surface's triangle faces along `facing`, what it reflects goes
// by `normal`; both are unit vectors. `sample` numbers the samples of a pixel.
fn sunlight(layer: u32, point: vec3<f32>, normal: vec3<f32>, facing: vec3<f32>, sample: u32) -> vec3<f32> {
    let sun = suns.suns[layer];
    let cosine = dot(normal, sun.towards);
    let sine = sun.tangent / sqrt(1.0 + sun.tangent * sun.tangent);
    let above = share_above(dot(facing, sun.towards) / sine);
    if cosine <= 0.0 || above <= 0.0 {
        return vec3<f32>(0.0);
    }
    let place = in_box(sun, point);
    let size = vec2<f32>(textureDimensions(shadows));
    let texel = 2.0 * vec2<f32>(sun.half_width, sun.half_height) / size;
    // A surface that the sun hardly reaches is as steep as its disc's edge.
    let least = max(dot(facing, sun.towards), sine);
    // Rows of the map go down.
    let slope = vec2<f32>(-dot(facing, sun.right), dot(facing, sun.up)) / least;
    let at = vec2<f32>(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y) * size;
    // Far from the origin coordinates are rounded more than the scene is deep.
    let largest = max(max(abs(point.x), abs(point.y)), abs(point.z));
    let rounding = 4e-6 * sun.half_depth + 5e-7 * largest + 0.5 * dot(abs(slope) + FACET_RISE, texel);
    let lit = Lit(layer, at, texel, place.z * sun.half_depth, slope, sun.tangent, sun.half_depth, rounding);
    return FRAC_1_PI * cosine * above * unshadowed(lit, sample) * sun.irradiance;
}
