// The light that shines, whole, on the functions of clusters: products of rows of 6 × 8 × 8 Haar coefficients with those of the light.

#import invocation

// Texels along a side of the light's faces, and along those whose coefficients come first.
const FACE_SIZE = 64u;
const SIDE = 8u;
// Words of a row, of two coefficients each.
const ROW_WORDS = 192u;
// Lanes that share a row.
const TEAM = 16u;

// Number of the first row's product.
@group(0) @binding(0) var<uniform> first: u32;
// [rows, 384] f16
@group(0) @binding(1) var<storage, read> rows: array<u32>;
// The light's coefficients without suns, then of the whole; the fourth component is unused.
@group(0) @binding(2) var<storage, read> light: array<vec4<f32>>;
// By cluster, source and function of the light; the fourth component is unused.
@group(0) @binding(3) var<storage, read_write> lit: array<vec4<f32>>;

var<workgroup> sums: array<vec3<f32>, 64>;

@compute @workgroup_size(64)
fn project(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = invocation(group, groups, 64u, lane) / TEAM;
    let is_there = row < arrayLength(&rows) / ROW_WORDS;
    var sum = vec3<f32>(0.0);
    if is_there {
        for (var word = lane % TEAM; word < ROW_WORDS; word += TEAM) {
            let pair = unpack2x16float(rows[row * ROW_WORDS + word]);
            let face = word / (SIDE * SIDE / 2u);
            let at = (6u + face) * FACE_SIZE * FACE_SIZE + 2u * word % (SIDE * SIDE);
            sum += pair.x * light[at].rgb + pair.y * light[at + 1u].rgb;
        }
    }
    sums[lane] = sum;
    for (var half = TEAM / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane % TEAM < half {
            sums[lane] += sums[lane + half];
        }
    }
    if is_there && lane % TEAM == 0u {
        // Coefficients of means over larger texels.
        lit[first + row] = vec4<f32>(f32(SIDE) / f32(FACE_SIZE) * sums[lane], 0.0);
    }
}
