// The orthonormal Haar transform of the light, a workgroup per face: the GPU twin of `relume_formats::basis::haar::forward_cube`.

// Texels along a side of a face: a power of two, at most 64.
@group(0) @binding(0) var<uniform> face_size: u32;
// Radiance, on 6 faces row by row; the fourth component is unused.
@group(0) @binding(1) var<storage, read> texels: array<vec4<f32>>;
// Coefficients in the order of the basis, face after face; the fourth component is unused.
@group(0) @binding(2) var<storage, read_write> coefficients: array<vec4<f32>>;

// The averages of the last level, row by row: as many bytes as every device has for a workgroup.
var<workgroup> averages: array<vec3<f32>, 1024>;

const LANES = 256u;

struct Split {
    average: vec3<f32>,
    left_right: vec3<f32>,
    up_down: vec3<f32>,
    crossed: vec3<f32>,
}

// Four texels, the upper two first, to one coefficient of each kind.
fn split(t0: vec3<f32>, t1: vec3<f32>, b0: vec3<f32>, b1: vec3<f32>) -> Split {
    let left = t0 + b0;
    let right = t1 + b1;
    let left_drop = t0 - b0;
    let right_drop = t1 - b1;
    return Split(0.5 * (left + right), 0.5 * (left - right), 0.5 * (left_drop + right_drop), 0.5 * (left_drop - right_drop));
}

// Stores the details of square `index` of a level of h × h squares.
fn store_details(first: u32, h: u32, index: u32, details: Split) {
    coefficients[first + h * h + index] = vec4<f32>(details.left_right, 0.0);
    coefficients[first + 2u * h * h + index] = vec4<f32>(details.up_down, 0.0);
    coefficients[first + 3u * h * h + index] = vec4<f32>(details.crossed, 0.0);
}

@compute @workgroup_size(256)
fn transform(@builtin(workgroup_id) face: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let n = face_size;
    let first = face.x * n * n;
    if n == 1u {
        if lane == 0u {
            coefficients[first] = texels[first];
        }
        return;
    }
    let finest = n / 2u;
    for (var i = lane; i < finest * finest; i += LANES) {
        let at = first + 2u * (i / finest * n + i % finest);
        let parts = split(texels[at].rgb, texels[at + 1u].rgb, texels[at + n].rgb, texels[at + n + 1u].rgb);
        store_details(first, finest, i, parts);
        averages[i] = parts.average;
    }
    // From here on a level has no more squares than there are lanes.
    for (var h = n / 4u; h > 0u; h /= 2u) {
        workgroupBarrier();
        let at = 2u * (lane / h * 2u * h + lane % h);
        var parts: Split;
        if lane < h * h {
            parts = split(averages[at], averages[at + 1u], averages[at + 2u * h], averages[at + 2u * h + 1u]);
            store_details(first, h, lane, parts);
        }
        workgroupBarrier();
        if lane < h * h {
            averages[lane] = parts.average;
        }
    }
    workgroupBarrier();
    if lane == 0u {
        coefficients[first] = vec4<f32>(averages[0], 0.0);
    }
}
