// Adds up value × coefficient of the light over the columns that have arrived: the GPU twin of
// `relume_formats::evaluate::sparse_transfer::radiance`.
//
// A workgroup sums the rows of a tile of 64 vertices. Sixteen lanes side by side take four vertices each, so that they load 256 bytes in a row, and
// sixteen such rows of lanes take the units of columns in turn, so that many loads are under way. In the end the rows of lanes are added up in their
// order: the sum of a vertex does not depend on how tiles are spread over bands.

#import bytes
#import invocation

struct Dispatch {
    // All vertices of the bake.
    vertices: u32,
    // The tiles of the band.
    first_tile: u32,
    tiles: u32,
    // Units of the band that have arrived.
    units: u32,
    // Values of a term: 1, or 3 for RGB.
    channels: u32,
    // What a stored 1 is worth.
    unit: f32,
}

// Four consecutive columns of one block. Offsets are in wide words from the start of the band, for its first tile.
struct Unit {
    // [64 vertices] f16: what a step is worth in each row of the block, in units.
    scales: u32,
    // Rows of a wide word for each four vertices. Two rows of indices, u16 by [2 terms][4 vertices]; then for each channel one row of values, i8 by
    // [4 terms][4 vertices], or two, i16 by [2 terms][4 vertices].
    terms: u32,
    // From tile to tile.
    stride: u32,
    // 1: values are 16-bit integers; 0: bytes.
    wide: u32,
}

// Of four vertices.
struct Sums {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

// What the light's coefficients are multiplied with, for four vertices.
struct Values {
    red: vec4<f32>,
    green: vec4<f32>,
    blue: vec4<f32>,
}

// Wide words in a row, one for each of the lanes side by side.
const COLUMNS = 16u;
// Rows of lanes.
const ROWS = 16u;
const TILE = 64u;

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> units: array<Unit>;
@group(0) @binding(2) var<storage, read> words: array<vec4<u32>>;
// The light's coefficients; the fourth component is unused.
@group(0) @binding(3) var<storage, read> light: array<vec4<f32>>;
// [vertices, 4]: W/(sr·m²) before the light's gain; the fourth number of a vertex is unused.
@group(0) @binding(4) var<storage, read_write> radiance: array<f32>;

// [ROWS, 3, TILE]
var<workgroup> partial: array<f32, 3072>;

fn integers_of(pair: vec2<u32>) -> vec4<f32> {
    return vec4<f32>(vec4<i32>(vec4<u32>(pair.x << 16u, pair.x, pair.y << 16u, pair.y)) >> vec4<u32>(16u));
}

fn add_term(sums: ptr<function, Sums>, indices: vec2<u32>, values: Values) {
    let a = light[indices.x & 0xffffu].rgb;
    let b = light[indices.x >> 16u].rgb;
    let c = light[indices.y & 0xffffu].rgb;
    let d = light[indices.y >> 16u].rgb;
    (*sums).a += vec3<f32>(values.red.x, values.green.x, values.blue.x) * a;
    (*sums).b += vec3<f32>(values.red.y, values.green.y, values.blue.y) * b;
    (*sums).c += vec3<f32>(values.red.z, values.green.z, values.blue.z) * c;
    (*sums).d += vec3<f32>(values.red.w, values.green.w, values.blue.w) * d;
}

fn byte_values(steps: vec4<f32>, red: u32, green: u32, blue: u32) -> Values {
    return Values(steps * bytes_of(red), steps * bytes_of(green), steps * bytes_of(blue));
}

fn wide_values(steps: vec4<f32>, red: vec2<u32>, green: vec2<u32>, blue: vec2<u32>) -> Values {
    return Values(steps * integers_of(red), steps * integers_of(green), steps * integers_of(blue));
}

// Adds a unit; all that it loads of the columns is asked for before any of it is used.
fn add_unit(sums: ptr<function, Sums>, unit: Unit, tile: u32, column: u32) {
    let scales = words[unit.scales + tile * unit.stride + column / 2u];
    let at = unit.terms + tile * unit.stride + column;
    let early = words[at];
    let late = words[at + COLUMNS];
    let pair = select(scales.xy, scales.zw, column % 2u == 1u);
    let steps = dispatch.unit * vec4<f32>(unpack2x16float(pair.x), unpack2x16float(pair.y));
    // Grey values stand for all three channels.
    let channel = select(0u, COLUMNS, dispatch.channels == 3u);
    let red_at = at + 2u * COLUMNS;
    if unit.wide == 0u {
        let red = words[red_at];
        let green = words[red_at + channel];
        let blue = words[red_at + 2u * channel];
        add_term(sums, early.xy, byte_values(steps, red.x, green.x, blue.x));
        add_term(sums, early.zw, byte_values(steps, red.y, green.y, blue.y));
        add_term(sums, late.xy, byte_values(steps, red.z, green.z, blue.z));
        add_term(sums, late.zw, byte_values(steps, red.w, green.w, blue.w));
    } else {
        let red = words[red_at];
        let green = words[red_at + 2u * channel];
        let blue = words[red_at + 4u * channel];
        let late_red = words[red_at + COLUMNS];
        let late_green = words[red_at + COLUMNS + 2u * channel];
        let late_blue = words[red_at + COLUMNS + 4u * channel];
        add_term(sums, early.xy, wide_values(steps, red.xy, green.xy, blue.xy));
        add_term(sums, early.zw, wide_values(steps, red.zw, green.zw, blue.zw));
        add_term(sums, late.xy, wide_values(steps, late_red.xy, late_green.xy, late_blue.xy));
        add_term(sums, late.zw, wide_values(steps, late_red.zw, late_green.zw, late_blue.zw));
    }
}

fn keep(row: u32, vertex: u32, sum: vec3<f32>) {
    let at = 3u * TILE * row + vertex;
    partial[at] = sum.r;
    partial[at + TILE] = sum.g;
    partial[at + 2u * TILE] = sum.b;
}

@compute @workgroup_size(256)
fn accumulate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = invocation(group, groups, 1u, 0u);
    if tile >= dispatch.tiles {
        return;
    }
    let column = lane % COLUMNS;
    let row = lane / COLUMNS;
    var sums = Sums();
    for (var u = row; u < dispatch.units; u += ROWS) {
        add_unit(&sums, units[u], tile, column);
    }
    keep(row, 4u * column, sums.a);
    keep(row, 4u * column + 1u, sums.b);
    keep(row, 4u * column + 2u, sums.c);
    keep(row, 4u * column + 3u, sums.d);
    workgroupBarrier();
    let vertex = (dispatch.first_tile + tile) * TILE + lane % TILE;
    let channel = lane / TILE;
    if channel < 3u && vertex < dispatch.vertices {
        var sum = 0.0;
        for (var r = 0u; r < ROWS; r += 1u) {
            sum += partial[TILE * (3u * r + channel) + lane % TILE];
        }
        radiance[4u * vertex + channel] = sum;
    }
}
