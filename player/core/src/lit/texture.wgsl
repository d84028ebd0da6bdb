// The texture of a material: where it is magnified, the GPU twin of `relume_formats::basis::Texture`; where it is
// minified, its mean over what a sample of the picture covers.

#import material

// Red, green and blue as sRGB encodes them, and alpha. All sizes of the texture are on one sheet: software adapters
// take one level of a texture for all of a quad of samples, or more.
@group(1) @binding(0) var sheet: texture_2d<f32>;

// Most look-ups along what a sample covers.
const MOST_TAPS = 8.0;
// More texels than a sample may be taken to step by.
const FARTHEST = vec2<f32>(1e6);

fn linear_from_srgb(encoded: vec3<f32>) -> vec3<f32> {
    let curved = pow((encoded + 0.055) / 1.055, vec3<f32>(2.4));
    return select(curved, encoded / 12.92, encoded <= vec3<f32>(0.04045));
}

fn wrapped(index: i32, count: i32, wrap: u32) -> i32 {
    switch wrap {
        case 0u: { return ((index % count) + count) % count; }
        case 1u: {
            let within = ((index % (2 * count)) + 2 * count) % (2 * count);
            return min(within, 2 * count - 1 - within);
        }
        default: { return clamp(index, 0, count - 1); }
    }
}

// A size of the texture: each side half the last one's, rounded down, but 1 at least.
struct Level {
    // Where it begins on the sheet.
    corner: vec2<i32>,
    size: vec2<i32>,
    sharp: bool,
    // Whether colours count by alpha, and are that many times as bright: of what is cut away nothing is seen.
    weighed: bool,
}

fn level_of(number: u32, material: Material, weighed: bool) -> Level {
    let size = max(material.size >> vec2<u32>(number), vec2<u32>(1u));
    if number == 0u {
        return Level(vec2<i32>(0), vec2<i32>(size), material.nearest == 1u, weighed);
    }
    // To the right of the texture, one below the other: as `mips.rs` lays them out.
    let above = number - 1u;
    let rows = material.size.y;
    let beyond = max(above, firstLeadingBit(rows) + 1u) - firstLeadingBit(rows) - 1u;
    let corner = vec2<u32>(material.size.x, rows - (rows >> above) + beyond);
    return Level(vec2<i32>(corner), vec2<i32>(size), false, weighed);
}

fn texel(column: i32, row: i32, level: Level, wrap: vec2<u32>) -> vec4<f32> {
    let at = vec2<i32>(wrapped(column, level.size.x, wrap.x), wrapped(row, level.size.y, wrap.y));
    let encoded = textureLoad(sheet, level.corner + at, 0);
    return vec4<f32>(linear_from_srgb(encoded.rgb) * select(1.0, encoded.a, level.weighed), encoded.a);
}

// The GPU twin of `relume_formats::basis::Texture::sample`, unless colours are weighed.
fn sample(uv: vec2<f32>, level: Level, wrap: vec2<u32>) -> vec4<f32> {
    // Coordinates so large that they have no fraction left fall somewhere legal.
    let scaled = clamp(uv * vec2<f32>(level.size), vec2<f32>(-1e9), vec2<f32>(1e9));
    if level.sharp {
        let hit = vec2<i32>(floor(scaled));
        return texel(hit.x, hit.y, level, wrap);
    }
    let at = scaled - 0.5;
    let first = floor(at);
    let share = at - first;
    let column = i32(first.x);
    let row = i32(first.y);
    let top = mix(texel(column, row, level, wrap), texel(column + 1, row, level, wrap), share.x);
    let bottom = mix(texel(column, row + 1, level, wrap), texel(column + 1, row + 1, level, wrap), share.x);
    return mix(top, bottom, share.y);
}

// What a sample covers of the texture, in texels: an ellipse.
struct Footprint {
    longer_axis: vec2<f32>,
    longer: f32,
    shorter: f32,
}

// The footprint of a sample from which it is `across` and `down` to the next ones.
fn footprint(across: vec2<f32>, down: vec2<f32>) -> Footprint {
    // A circle becomes an ellipse, whose axes are the eigenvectors of the steps' second moments.
    let xx = across.x * across.x + down.x * down.x;
    let yy = across.y * across.y + down.y * down.y;
    let xy = across.x * across.y + down.x * down.y;
    let half = 0.5 * (xx - yy);
    let square = 0.5 * (xx + yy) + sqrt(half * half + xy * xy);
    let longer = sqrt(square);
    let area = abs(across.x * down.y - across.y * down.x);
    // Of two forms of the same vector, the one that does not vanish; of a circle any will do.
    let along = select(vec2<f32>(xy, square - xx), vec2<f32>(square - yy, xy), xx >= yy);
    return Footprint(along * (longer / max(length(along), 1e-30)), longer, area / max(longer, 1e-30));
}

// The mean colour of the texture over what a sample at `uv` covers, from which it is `across` and `down` to the next ones.
fn mean(uv: vec2<f32>, across: vec2<f32>, down: vec2<f32>, material: Material) -> vec3<f32> {
    let size = vec2<f32>(material.size);
    let covered = footprint(
        clamp(across * size, -FARTHEST, FARTHEST),
        clamp(down * size, -FARTHEST, FARTHEST),
    );
    // What is no number is not minified either.
    if !(covered.longer > 1.0) {
        return sample(uv, level_of(0u, material, false), material.wrap).rgb;
    }
    let taps = clamp(ceil(covered.longer / max(covered.shorter, 1e-30)), 1.0, MOST_TAPS);
    let width = max(covered.shorter, covered.longer / taps);
    let number = clamp(log2(width), 0.0, f32(material.levels) - 1.0);
    let cut_out = material.alpha_cutoff > 0.0;
    let finer = level_of(u32(number), material, cut_out);
    let coarser = level_of(min(u32(number) + 1u, material.levels - 1u), material, cut_out);
    let share = fract(number);
    var sum = vec4<f32>(0.0);
    for (var tap = 0.0; tap < taps; tap += 1.0) {
        let at = uv + ((tap + 0.5) / taps - 0.5) * covered.longer_axis / size;
        var colour = sample(at, finer, material.wrap);
        if share > 0.0 {
            colour = mix(colour, sample(at, coarser, material.wrap), share);
        }
        sum += colour;
    }
    if !cut_out {
        return sum.rgb / taps;
    }
    if sum.a > 0.0 {
        return sum.rgb / sum.a;
    }
    // All taps fell into holes, but this very point was not cut away.
    return sample(uv, level_of(0u, material, false), material.wrap).rgb;
}
