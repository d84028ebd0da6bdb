// Light and lobes folded into one weight for each lobe and tile of 4 × 4 texels, as `relume_formats::fast::sphere_shadows` does: with both given, the
// sums of the source's loops are linear in the first level of visibility, so what each of its coefficients and means is multiplied with is gathered here,
// and brought to tiles. A workgroup is a face of a lobe.

#import invocation
#import square

// [6·32·32] Haar coefficients of the light; the fourth component is unused here and below.
@group(0) @binding(0) var<storage, read> light: array<vec4<f32>>;
// [6, 341].
@group(0) @binding(1) var<storage, read> light_means: array<vec4<f32>>;
// [6·32·32], with zeros where a term is not kept.
@group(0) @binding(2) var<storage, read> light_kept: array<vec4<f32>>;
// [rows, 6·32·32], with zeros where a term is not kept.
@group(0) @binding(3) var<storage, read> lobes_kept: array<f32>;
// [rows, 6, 341].
@group(0) @binding(4) var<storage, read> lobe_means: array<f32>;
// [rows, 6, 64]: what a visible texel gives in each tile.
@group(0) @binding(5) var<storage, read_write> weights: array<vec4<f32>>;

const LANES = 64u;

// Of the coefficients of the first level.
var<workgroup> of_coefficients: array<vec3<f32>, 64>;
// Of the means over the squares of four levels.
var<workgroup> of_means: array<vec3<f32>, 85>;

// What coefficient `at` of the face is multiplied with.
fn factor(row_face: u32, face: u32, at: u32) -> vec3<f32> {
    let first = face * FACE;
    let lobe = row_face * FACE;
    if at == 0u {
        return lobes_kept[lobe] * light[first].rgb / 32.0;
    }
    let level = firstLeadingBit(at) / 2u;
    let area = 1u << (2u * level);
    let m = at / area;
    let within = at % area;
    let square = (area - 1u) / 3u + within;
    let second = (m % 3u + 1u) * area + within;
    let third = ((m + 1u) % 3u + 1u) * area + within;
    let crossed = lobes_kept[lobe + second] * light[first + third].rgb + lobes_kept[lobe + third] * light[first + second].rgb;
    return lobes_kept[lobe + at] * light_means[face * 341u + square].rgb
        + f32(1u << level) / 32.0 * crossed
        + light_kept[first + at].rgb * lobe_means[row_face * 341u + square];
}

// Lobe times light over the three wavelets of a square.
fn equals(row_face: u32, face: u32, level: u32, within: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var m = 1u; m <= 3u; m += 1u) {
        let at = (m << (2u * level)) + within;
        sum += lobes_kept[row_face * FACE + at] * light[face * FACE + at].rgb;
    }
    return sum;
}

// What the mean over square `s` is multiplied with. Visibility is flat in its finest squares, so their means stand for those of smaller ones.
fn factor_of_mean(row_face: u32, face: u32, s: u32) -> vec3<f32> {
    let level = square(s).level;
    let within = square(s).within;
    var sum = equals(row_face, face, level, within);
    if level == 3u {
        let finer = (within / 8u) * 32u + 2u * (within % 8u);
        sum += equals(row_face, face, 4u, finer) + equals(row_face, face, 4u, finer + 1u);
        sum += equals(row_face, face, 4u, finer + 16u) + equals(row_face, face, 4u, finer + 17u);
    }
    return sum;
}

// Gathers at tile (x, y) what the squares that hold it are multiplied with.
fn at_tile(x: u32, y: u32) -> vec3<f32> {
    var sum = of_coefficients[0] / 32.0;
    for (var l = 0u; l < 4u; l += 1u) {
        let up = 3u - l;
        let area = 1u << (2u * l);
        let within = ((y >> up) << l) + (x >> up);
        sum += of_means[(area - 1u) / 3u + within] * f32(area) / f32(FACE);
        if l < 3u {
            let right = ((x >> (up - 1u)) & 1u) == 1u;
            let lower = ((y >> (up - 1u)) & 1u) == 1u;
            let across = of_coefficients[area + within];
            let down = of_coefficients[2u * area + within];
            let crossed = of_coefficients[3u * area + within];
            let change = select(across, -across, right) + select(down, -down, lower) + select(crossed, -crossed, right != lower);
            sum += f32(1u << l) / 32.0 * change;
        }
    }
    return sum;
}

@compute @workgroup_size(64)
fn fold(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row_face = invocation(group, groups, 1u, 0u);
    let face = row_face % 6u;
    let is_there = row_face < arrayLength(&weights) / LANES;
    if is_there {
        of_coefficients[lane] = factor(row_face, face, lane);
        for (var s = lane; s < 85u; s += LANES) {
            of_means[s] = factor_of_mean(row_face, face, s);
        }
    }
    workgroupBarrier();
    if is_there {
        weights[row_face * LANES + lane] = vec4<f32>(at_tile(lane % 8u, lane / 8u), 0.0);
    }
}
