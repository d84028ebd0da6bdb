// Adds up value × coefficient of the light over the blocks that have arrived, for all columns of each vertex: the GPU twin of the direct part of
// `relume_formats::evaluate::transfer_tensor::received`.
//
// A workgroup sums up to twelve columns of a tile of 64 vertices. Four rows of 64 lanes take the terms of a block in turn, so that many loads are under way,
// and a row loads 256 bytes side by side. In the end the rows of lanes are added up in their order.

#import bytes
#import invocation

struct Dispatch {
    // Vertices of the band.
    vertices: u32,
    tiles: u32,
    // Blocks that have arrived.
    blocks: u32,
    // Numbers of a vertex, and words of four of them.
    columns: u32,
    quads: u32,
    // What a stored 1 is worth.
    unit: f32,
}

// Of words: for each two columns, [64 vertices] f16 of what a step is worth in units; for each two terms, [64 vertices] u16 which coefficient each
// multiplies; for each term and four columns, [64 vertices] i8 values. What is not there is 0.
struct Block {
    // Where it begins, for the first tile of the band.
    first: u32,
    // From tile to tile.
    stride: u32,
    terms: u32,
}

const TILE = 64u;
// Rows of lanes.
const ROWS = 4u;
// Words of four columns that a lane sums.
const QUADS = 3u;

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> blocks: array<Block>;
@group(0) @binding(2) var<storage, read> words: array<u32>;
// The light's coefficients; the fourth component is unused.
@group(0) @binding(3) var<storage, read> light: array<vec4<f32>>;
// [columns, vertices of the band] before the light's gain; the fourth component is unused.
@group(0) @binding(4) var<storage, read_write> direct: array<vec4<f32>>;

// [4 columns, ROWS, TILE]
var<workgroup> partial: array<vec3<f32>, 1024>;

fn outer(radiance: vec3<f32>, values: vec4<f32>) -> mat4x3<f32> {
    return mat4x3<f32>(values.x * radiance, values.y * radiance, values.z * radiance, values.w * radiance);
}

// What a step of four columns is worth.
fn steps(at: u32) -> vec4<f32> {
    return dispatch.unit * vec4<f32>(unpack2x16float(words[at]), unpack2x16float(words[at + TILE]));
}

fn scaled(sums: mat4x3<f32>, by: vec4<f32>) -> mat4x3<f32> {
    return mat4x3<f32>(by.x * sums[0], by.y * sums[1], by.z * sums[2], by.w * sums[3]);
}

// Adds up four columns over the rows of lanes and stores them.
fn store(sums: mat4x3<f32>, quad: u32, tile: u32, lane: u32) {
    for (var k = 0u; k < 4u; k += 1u) {
        partial[4u * TILE * k + lane] = sums[k];
    }
    workgroupBarrier();
    let column = 4u * quad + lane / TILE;
    let vertex = tile * TILE + lane % TILE;
    if column < dispatch.columns && vertex < dispatch.vertices {
        var sum = vec3<f32>(0.0);
        for (var row = 0u; row < ROWS; row += 1u) {
            sum += partial[TILE * (ROWS * (lane / TILE) + row) + lane % TILE];
        }
        direct[column * dispatch.vertices + vertex] = vec4<f32>(sum, 0.0);
    }
    workgroupBarrier();
}

@compute @workgroup_size(256)
fn accumulate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let parts = (dispatch.quads + QUADS - 1u) / QUADS;
    let index = invocation(group, groups, 1u, 0u);
    let tile = index / parts;
    if tile >= dispatch.tiles {
        return;
    }
    let quad = index % parts * QUADS;
    let count = min(QUADS, dispatch.quads - quad);
    var first = mat4x3<f32>();
    var second = mat4x3<f32>();
    var third = mat4x3<f32>();
    for (var number = 0u; number < dispatch.blocks; number += 1u) {
        let block = blocks[number];
        let scales = block.first + tile * block.stride + lane % TILE;
        let indices = scales + 2u * dispatch.quads * TILE;
        let values = indices + (block.terms + 1u) / 2u * TILE;
        var a = mat4x3<f32>();
        var b = mat4x3<f32>();
        var c = mat4x3<f32>();
        for (var term = lane / TILE; term < block.terms; term += ROWS) {
            let radiance = light[extractBits(words[indices + term / 2u * TILE], 16u * (term % 2u), 16u)].rgb;
            let at = values + (term * dispatch.quads + quad) * TILE;
            a += outer(radiance, bytes_of(words[at]));
            if count > 1u {
                b += outer(radiance, bytes_of(words[at + TILE]));
            }
            if count > 2u {
                c += outer(radiance, bytes_of(words[at + 2u * TILE]));
            }
        }
        let of_quad = scales + 2u * quad * TILE;
        first += scaled(a, steps(of_quad));
        if count > 1u {
            second += scaled(b, steps(of_quad + 2u * TILE));
        }
        if count > 2u {
            third += scaled(c, steps(of_quad + 4u * TILE));
        }
    }
    store(first, quad, tile, lane);
    if count > 1u {
        store(second, quad + 1u, tile, lane);
    }
    if count > 2u {
        store(third, quad + 2u, tile, lane);
    }
}
