// What the vectors of clusters send after two reflections, under this light and by these materials.

#import invocation

struct Vectors {
    // Number of the first vector that is here.
    first: u32,
    count: u32,
    // Pairs of sources.
    pairs: u32,
    // Words of a vector.
    words: u32,
}

// Texels along a side of the light's faces, and along those whose coefficients come first.
const FACE_SIZE = 64u;
const SIDE = 2u;
const COEFFICIENTS = 6u * SIDE * SIDE;
const LANES = 64u;

@group(0) @binding(0) var<uniform> vectors: Vectors;
// By vector [24, pairs] f16, to whole words.
@group(0) @binding(1) var<storage, read> values: array<u32>;
// The light's coefficients without suns, then of the whole; the fourth component is unused.
@group(0) @binding(2) var<storage, read> light: array<vec4<f32>>;
// By pair: what materials make of it.
@group(0) @binding(3) var<storage, read> pair_weights: array<vec4<f32>>;
// By cluster and vector; the fourth component is unused.
@group(0) @binding(4) var<storage, read_write> lit_twice: array<vec4<f32>>;

var<workgroup> sums: array<vec3<f32>, LANES>;

// What element number `index` of a vector is multiplied with.
fn factor(index: u32) -> vec3<f32> {
    let coefficient = index / vectors.pairs;
    if coefficient >= COEFFICIENTS {
        return vec3<f32>(0.0);
    }
    let face = coefficient / (SIDE * SIDE);
    let radiance = light[(6u + face) * FACE_SIZE * FACE_SIZE + coefficient % (SIDE * SIDE)].rgb;
    return radiance * pair_weights[index % vectors.pairs].rgb;
}

@compute @workgroup_size(64)
fn mix_pairs(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let vector = invocation(group, groups, 1u, 0u);
    if vector >= vectors.count {
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var word = lane; word < vectors.words; word += LANES) {
        let pair = unpack2x16float(values[vector * vectors.words + word]);
        sum += pair.x * factor(2u * word) + pair.y * factor(2u * word + 1u);
    }
    sums[lane] = sum;
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
        }
    }
    if lane == 0u {
        // Coefficients of means over larger texels.
        lit_twice[vectors.first + vector] = vec4<f32>(f32(SIDE) / f32(FACE_SIZE) * sums[0], 0.0);
    }
}
