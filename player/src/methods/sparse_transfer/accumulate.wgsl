// Adds up value × coefficient of the light over the columns of a band for every vertex: the GPU twin of
// `relume_formats::evaluate::sparse_transfer::radiance`.
//
// Columns stand behind each other, so that neighbouring invocations read neighbouring words; every row of a column starts on a whole word.

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
    // 1: values are halves; 0: bytes, in steps that each vertex has of its own.
    halves: u32,
    // [terms, vertices] u16.
    indices: u32,
    // [terms, vertices, channels] f16 or i8.
    values: u32,
    // [vertices] f16, if values are bytes.
    scales: u32,
}

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> runs: array<Run>;
@group(0) @binding(2) var<storage, read> words: array<u32>;
// The light's coefficients; the fourth component is unused.
@group(0) @binding(3) var<storage, read> light: array<vec4<f32>>;
// By vertex: W/(sr·m²) before the light's gain; the fourth component is unused.
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4<f32>>;

fn half_at(row: u32, element: u32) -> f32 {
    let pair = unpack2x16float(words[row + element / 2u]);
    return select(pair.x, pair.y, element % 2u == 1u);
}

fn byte_at(row: u32, element: u32) -> f32 {
    return f32(extractBits(bitcast<i32>(words[row + element / 4u]), 8u * (element % 4u), 8u));
}

fn index_at(row: u32, vertex: u32) -> u32 {
    return extractBits(words[row + vertex / 2u], 16u * (vertex % 2u), 16u);
}

// Columns are added one by one in their order, so the sum does not depend on how they are spread over runs and bands.
fn add_halves(before: vec3<f32>, run: Run, vertex: u32) -> vec3<f32> {
    let index_stride = (dispatch.vertices + 1u) / 2u;
    let value_stride = (dispatch.vertices * dispatch.channels + 1u) / 2u;
    let element = vertex * dispatch.channels;
    var sum = before;
    for (var term = 0u; term < run.terms; term += 1u) {
        let coefficient = light[index_at(run.indices + term * index_stride, vertex)].rgb;
        let row = run.values + term * value_stride;
        if dispatch.channels == 1u {
            sum += dispatch.unit * half_at(row, element) * coefficient;
        } else {
            let value = vec3<f32>(half_at(row, element), half_at(row, element + 1u), half_at(row, element + 2u));
            sum += dispatch.unit * value * coefficient;
        }
    }
    return sum;
}

fn add_bytes(before: vec3<f32>, run: Run, vertex: u32) -> vec3<f32> {
    let index_stride = (dispatch.vertices + 1u) / 2u;
    let value_stride = (dispatch.vertices * dispatch.channels + 3u) / 4u;
    let element = vertex * dispatch.channels;
    let step = dispatch.unit * half_at(run.scales, vertex);
    var sum = before;
    for (var term = 0u; term < run.terms; term += 1u) {
        let coefficient = light[index_at(run.indices + term * index_stride, vertex)].rgb;
        let row = run.values + term * value_stride;
        if dispatch.channels == 1u {
            sum += step * byte_at(row, element) * coefficient;
        } else {
            let value = vec3<f32>(byte_at(row, element), byte_at(row, element + 1u), byte_at(row, element + 2u));
            sum += step * value * coefficient;
        }
    }
    return sum;
}

@compute @workgroup_size(64)
fn accumulate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let vertex = (group.y * groups.x + group.x) * 64u + lane;
    if vertex >= dispatch.vertices {
        return;
    }
    var sum = vec3<f32>(0.0);
    if dispatch.accumulate == 1u {
        sum = radiance[vertex].rgb;
    }
    for (var r = 0u; r < dispatch.runs; r += 1u) {
        let run = runs[r];
        if run.halves == 1u {
            sum = add_halves(sum, run, vertex);
        } else {
            sum = add_bytes(sum, run, vertex);
        }
    }
    radiance[vertex] = vec4<f32>(sum, 0.0);
}
