// Adds up value × coefficient of the light over the columns of a band for every vertex: the GPU twin of
// `relume_formats::evaluate::sparse_transfer::radiance`.
//
// Columns stand behind each other, so that neighbouring invocations read neighbouring words; every row of a column starts on a whole word.

#import half
#import invocation

struct Dispatch {
    vertices: u32,
    // Runs of the band that have arrived.
    runs: u32,
    // Values of a term: 1, or 3 for RGB.
    channels: u32,
    // 0 if this is the first band, whose sum starts from nothing; else 1.
    accumulate: u32,
    // What a stored 1 is worth.
    unit: f32,
}

// Consecutive columns of one block. Offsets are in words from the start of the band.
struct Run {
    terms: u32,
    // 1: values are 16-bit integers; 0: bytes.
    wide: u32,
    // [terms, vertices] u16.
    indices: u32,
    // [terms, vertices, channels] i16 or i8, in steps that each vertex has of its own.
    values: u32,
    // [vertices] f16: the steps, in units.
    scales: u32,
}

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> runs: array<Run>;
@group(0) @binding(2) var<storage, read> words: array<u32>;
// The light's coefficients; the fourth component is unused.
@group(0) @binding(3) var<storage, read> light: array<vec4<f32>>;
// By vertex: W/(sr·m²) before the light's gain; the fourth component is unused.
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4<f32>>;

// A number of a row that starts at a whole word: which word of the row, and the bits within it.
struct Place {
    word: u32,
    first_bit: u32,
    bits: u32,
}

// The place of element `index` of a row of elements of 32 >> `shift` bits each.
fn place(index: u32, shift: u32) -> Place {
    let bits = 32u >> shift;
    return Place(index >> shift, bits * (index & ((1u << shift) - 1u)), bits);
}

fn integer_at(row: u32, at: Place) -> f32 {
    return f32(extractBits(bitcast<i32>(words[row + at.word]), at.first_bit, at.bits));
}

fn index_at(row: u32, at: Place) -> u32 {
    return extractBits(words[row + at.word], at.first_bit, at.bits);
}

// Words of a row of `count` elements of 32 >> `shift` bits each.
fn words_of(count: u32, shift: u32) -> u32 {
    return (count + (1u << shift) - 1u) >> shift;
}

// Columns are added one by one in their order, so the sum does not depend on how they are spread over runs and bands.
fn add(before: vec3<f32>, run: Run, vertex: u32) -> vec3<f32> {
    let shift = select(2u, 1u, run.wide == 1u);
    let step = dispatch.unit * half_of(words[run.scales + vertex / 2u], vertex);
    let index = place(vertex, 1u);
    let red = place(dispatch.channels * vertex, shift);
    let green = place(dispatch.channels * vertex + 1u, shift);
    let blue = place(dispatch.channels * vertex + 2u, shift);
    let index_words = words_of(dispatch.vertices, 1u);
    let value_words = words_of(dispatch.vertices * dispatch.channels, shift);
    var index_row = run.indices;
    var value_row = run.values;
    var sum = before;
    for (var term = 0u; term < run.terms; term += 1u) {
        let coefficient = light[index_at(index_row, index)].rgb;
        var value = vec3<f32>(integer_at(value_row, red));
        if dispatch.channels == 3u {
            value = vec3<f32>(value.r, integer_at(value_row, green), integer_at(value_row, blue));
        }
        sum += step * value * coefficient;
        index_row += index_words;
        value_row += value_words;
    }
    return sum;
}

@compute @workgroup_size(64)
fn accumulate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let vertex = invocation(group, groups, 64u, lane);
    if vertex >= dispatch.vertices {
        return;
    }
    var sum = vec3<f32>(0.0);
    if dispatch.accumulate == 1u {
        sum = radiance[vertex].rgb;
    }
    for (var r = 0u; r < dispatch.runs; r += 1u) {
        sum = add(sum, runs[r], vertex);
    }
    radiance[vertex] = vec4<f32>(sum, 0.0);
}
