// The light's largest terms, its means over squares, and the tiles in which it has fine terms: one workgroup for all.

#import square

struct Keep {
    // Factor on the light, which decides with its size what is kept.
    gain: vec3<f32>,
    // How many terms are kept.
    terms: u32,
    // 1 if fine terms count, else 0.
    fine: u32,
}

@group(0) @binding(0) var<uniform> keep: Keep;
// [6·32·32] Haar coefficients; the fourth component is unused here and below.
@group(0) @binding(1) var<storage, read> light: array<vec4<f32>>;
// [6, 341]: means over the squares of five levels.
@group(0) @binding(2) var<storage, read_write> means: array<vec4<f32>>;
// `light` with zeros where a term is not kept.
@group(0) @binding(3) var<storage, read_write> kept: array<vec4<f32>>;
// [6, 65]: how many tiles of a face have terms of the finer two levels, and which.
@group(0) @binding(4) var<storage, read_write> tiles: array<u32>;

const LANES = 256u;
// Coefficients that a lane looks at.
const SHARE = 24u;
const INFINITE = 0x7f800000u;

var<workgroup> total: atomic<u32>;
var<workgroup> ties: array<u32, 256>;

// The mean over square `s` of a face: from the whole down to it.
fn mean(face: u32, s: u32) -> vec3<f32> {
    let level = square(s).level;
    let within = square(s).within;
    let x = within & ((1u << level) - 1u);
    let y = within >> level;
    var sum = light[face * FACE].rgb / 32.0;
    for (var l = 0u; l < level; l += 1u) {
        let up = level - l;
        let at = face * FACE + ((y >> up) << l) + (x >> up);
        // 1 in the right and lower halves, where wavelets change their sign.
        let right = ((x >> (up - 1u)) & 1u) == 1u;
        let lower = ((y >> (up - 1u)) & 1u) == 1u;
        let area = 1u << (2u * l);
        let across = select(light[at + area].rgb, -light[at + area].rgb, right);
        let down = select(light[at + 2u * area].rgb, -light[at + 2u * area].rgb, lower);
        let crossed = select(light[at + 3u * area].rgb, -light[at + 3u * area].rgb, right != lower);
        sum += f32(1u << l) / 32.0 * (across + down + crossed);
    }
    return sum;
}

// What terms are ordered by: sizes of floats are in the order of their bits. The scaling functions come first.
fn key(index: u32) -> u32 {
    return select(bitcast<u32>(length(keep.gain * light[index].rgb)), INFINITE, index % FACE == 0u);
}

fn is_fine(face: u32, tile: u32) -> bool {
    let x = tile % 8u;
    let y = tile / 8u;
    var sizes = vec3<f32>(0.0);
    for (var m = 1u; m <= 3u; m += 1u) {
        let fine = face * FACE + m * 256u + 32u * y + 2u * x;
        sizes += abs(kept[face * FACE + m * 64u + tile].rgb) + abs(kept[fine].rgb) + abs(kept[fine + 1u].rgb);
        sizes += abs(kept[fine + 16u].rgb) + abs(kept[fine + 17u].rgb);
    }
    return any(sizes > vec3<f32>(0.0));
}

@compute @workgroup_size(256)
fn prepare(@builtin(local_invocation_index) lane: u32) {
    for (var s = lane; s < 6u * 341u; s += LANES) {
        means[s] = vec4<f32>(mean(s / 341u, s % 341u), 0.0);
    }
    var keys: array<u32, SHARE>;
    for (var k = 0u; k < SHARE; k += 1u) {
        keys[k] = key(lane * SHARE + k);
    }
    // The largest threshold that so many keys reach, bit by bit.
    var threshold = 0u;
    for (var bit = 31u; bit > 0u; bit -= 1u) {
        let candidate = threshold | (1u << (bit - 1u));
        if lane == 0u {
            atomicStore(&total, 0u);
        }
        workgroupBarrier();
        var reached = 0u;
        for (var k = 0u; k < SHARE; k += 1u) {
            reached += select(0u, 1u, keys[k] >= candidate);
        }
        atomicAdd(&total, reached);
        workgroupBarrier();
        if atomicLoad(&total) >= keep.terms {
            threshold = candidate;
        }
        workgroupBarrier();
    }
    // Of those at the threshold the ones of lower index fill what is left.
    var above = 0u;
    var equal = 0u;
    for (var k = 0u; k < SHARE; k += 1u) {
        above += select(0u, 1u, keys[k] > threshold);
        equal += select(0u, 1u, keys[k] == threshold);
    }
    ties[lane] = equal;
    if lane == 0u {
        atomicStore(&total, 0u);
    }
    workgroupBarrier();
    atomicAdd(&total, above);
    workgroupBarrier();
    let room = keep.terms - min(keep.terms, atomicLoad(&total));
    var rank = 0u;
    for (var before = 0u; before < lane; before += 1u) {
        rank += ties[before];
    }
    for (var k = 0u; k < SHARE; k += 1u) {
        let index = lane * SHARE + k;
        let is_tie = keys[k] == threshold;
        let stays = keys[k] > threshold || (is_tie && rank < room);
        kept[index] = select(vec4<f32>(0.0), vec4<f32>(light[index].rgb, 0.0), stays);
        rank += select(0u, 1u, is_tie);
    }
    storageBarrier();
    workgroupBarrier();
    if lane < 6u {
        var count = 0u;
        for (var tile = 0u; tile < 64u * keep.fine; tile += 1u) {
            if is_fine(lane, tile) {
                count += 1u;
                tiles[lane * 65u + count] = tile;
            }
        }
        tiles[lane * 65u] = count;
    }
}
