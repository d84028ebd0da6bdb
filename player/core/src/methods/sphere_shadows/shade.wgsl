// Radiance from bitmaps and folded weights: the sum over tiles of visible texels × weight, and in the tiles where the light has fine terms what the second
// level of visibility adds. A lane is a face of a receiver.

#import batch
#import invocation
#import lobes

@group(0) @binding(0) var<uniform> batch: Batch;
// [192, count]: blocked texels.
@group(0) @binding(1) var<storage, read> bitmaps: array<u32>;
// [receivers].
@group(0) @binding(2) var<storage, read> receivers: array<Lobes>;
// [rows, 6, 64]: what a visible texel gives in each tile; the fourth component is unused here and below.
@group(0) @binding(3) var<storage, read> weights: array<vec4<f32>>;
// [rows, 6, 341].
@group(0) @binding(4) var<storage, read> lobe_means: array<f32>;
// [6·32·32], with zeros where a term is not kept.
@group(0) @binding(5) var<storage, read> light_kept: array<vec4<f32>>;
// [6, 65]: how many tiles of a face have terms of the finer two levels, and which.
@group(0) @binding(6) var<storage, read> tiles: array<u32>;
// [65536, 2]: 16 halves each, the Haar coefficients of every bitmap of a tile.
@group(0) @binding(7) var<storage, read> table: array<vec4<u32>>;
// By receiver: W/(sr·m²) before the light's gain.
@group(0) @binding(8) var<storage, read_write> radiance: array<vec4<f32>>;

const LANES = 32u;

var<workgroup> sums: array<vec3<f32>, 192>;

fn row_at(face: u32, y: u32, index: u32) -> u32 {
    return bitmaps[(face * 32u + y) * batch.count + index];
}

// Visible texels of a row of tiles: a byte for each with an even number, and for each with an odd one.
fn visible(face: u32, tile_y: u32, index: u32) -> vec2<u32> {
    var counts = vec2<u32>(0x10101010u);
    for (var y = 0u; y < 4u; y += 1u) {
        let row = row_at(face, 4u * tile_y + y, index);
        let pairs = row - ((row >> 1u) & 0x55555555u);
        let fours = (pairs & 0x33333333u) + ((pairs >> 2u) & 0x33333333u);
        counts -= vec2<u32>(fours & 0x0f0f0f0fu, (fours >> 4u) & 0x0f0f0f0fu);
    }
    return counts;
}

fn of_tiles(face: u32, index: u32, lobes: Lobes) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var tile_y = 0u; tile_y < 8u; tile_y += 1u) {
        let counts = visible(face, tile_y, index);
        if all(counts == vec2<u32>(0u)) {
            continue;
        }
        for (var k = 0u; k < 4u; k += 1u) {
            if lobes.weights[k] == 0.0 {
                continue;
            }
            let first = (lobes.rows[k] * 6u + face) * 64u + tile_y * 8u;
            var part = vec3<f32>(0.0);
            for (var x = 0u; x < 4u; x += 1u) {
                let count = vec2<f32>((counts >> vec2<u32>(8u * x)) & vec2<u32>(255u));
                part += count.x * weights[first + 2u * x].rgb + count.y * weights[first + 2u * x + 1u].rgb;
            }
            sum += lobes.weights[k] * part;
        }
    }
    return sum;
}

// Means of the blended lobe over a tile's four quarters and, last, over all of it.
struct Means {
    quarters: vec4<f32>,
    whole: f32,
}

fn means(face: u32, x: u32, y: u32, lobes: Lobes) -> Means {
    var found = Means(vec4<f32>(0.0), 0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        if lobes.weights[k] != 0.0 {
            let first = (lobes.rows[k] * 6u + face) * 341u;
            let quarter = first + 85u + 32u * y + 2u * x;
            let quarters = vec4<f32>(lobe_means[quarter], lobe_means[quarter + 1u], lobe_means[quarter + 16u], lobe_means[quarter + 17u]);
            found.quarters += lobes.weights[k] * quarters;
            found.whole += lobes.weights[k] * lobe_means[first + 21u + 8u * y + x];
        }
    }
    return found;
}

fn of_quarters(first: u32, both: vec4<f32>) -> vec3<f32> {
    let upper = both.x * light_kept[first].rgb + both.y * light_kept[first + 1u].rgb;
    return upper + both.z * light_kept[first + 16u].rgb + both.w * light_kept[first + 17u].rgb;
}

fn of_fine_tile(face: u32, tile: u32, index: u32, lobes: Lobes) -> vec3<f32> {
    let x = tile % 8u;
    let y = tile / 8u;
    var blocked = 0u;
    for (var j = 0u; j < 4u; j += 1u) {
        blocked |= ((row_at(face, 4u * y + j, index) >> (4u * x)) & 15u) << (4u * j);
    }
    // A tile that is all visible or all blocked has no details.
    if blocked == 0u || blocked == 0xffffu {
        return vec3<f32>(0.0);
    }
    let known = means(face, x, y, lobes);
    let low = table[2u * (blocked ^ 0xffffu)];
    let high = table[2u * (blocked ^ 0xffffu) + 1u];
    let whole = known.whole * vec3<f32>(unpack2x16float(low.x).y, unpack2x16float(low.y));
    let at = face * 1024u + tile;
    var sum = whole.x * light_kept[at + 64u].rgb + whole.y * light_kept[at + 128u].rgb + whole.z * light_kept[at + 192u].rgb;
    let quarter = face * 1024u + 32u * y + 2u * x;
    sum += of_quarters(quarter + 256u, known.quarters * vec4<f32>(unpack2x16float(low.z), unpack2x16float(low.w)));
    sum += of_quarters(quarter + 512u, known.quarters * vec4<f32>(unpack2x16float(high.x), unpack2x16float(high.y)));
    sum += of_quarters(quarter + 768u, known.quarters * vec4<f32>(unpack2x16float(high.z), unpack2x16float(high.w)));
    return sum;
}

fn of_face(face: u32, index: u32) -> vec3<f32> {
    let lobes = receivers[batch.first + index];
    var sum = of_tiles(face, index, lobes);
    let count = tiles[face * 65u];
    for (var k = 1u; k <= count; k += 1u) {
        sum += of_fine_tile(face, tiles[face * 65u + k], index, lobes);
    }
    return sum;
}

@compute @workgroup_size(32, 6)
fn shade(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) lane: vec3<u32>,
) {
    let index = invocation(group, groups, LANES, lane.x);
    var sum = vec3<f32>(0.0);
    if index < batch.count {
        sum = of_face(lane.y, index);
    }
    sums[lane.y * LANES + lane.x] = sum;
    workgroupBarrier();
    if lane.y == 0u && index < batch.count {
        for (var face = 1u; face < 6u; face += 1u) {
            sum += sums[face * LANES + lane.x];
        }
        radiance[batch.first + index] = vec4<f32>(sum, 0.0);
    }
}
