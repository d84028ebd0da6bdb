// The box around all vertices, and how it is seen from each sun. Largest numbers are the same whatever their order, so that frames repeat.

#import invocation
#import sun

// [vertices, 3]: metres, world space.
@group(0) @binding(0) var<storage, read> positions: array<f32>;
// Keys of the largest x, y and z, and of the largest −x, −y and −z; 0 while there are none.
@group(0) @binding(1) var<storage, read_write> extent: array<atomic<u32>, 6>;
@group(0) @binding(2) var<storage, read_write> suns: Suns;

const LANES = 64u;
// Of the boxes: what filters the edge of a shadow map of 2048 texels looks some texels beyond it.
const MARGIN = 1.0 + 8.0 / 2048.0;
// A scene without extent has a box all the same.
const LEAST = 1e-30;

var<workgroup> most: array<atomic<u32>, 6>;

// Whole numbers in the order of the floats.
fn key(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn value_of(number: u32) -> f32 {
    return bitcast<f32>(select(~number, number & 0x7fffffffu, number >= 0x80000000u));
}

@compute @workgroup_size(64)
fn measure(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = invocation(group, groups, LANES, lane);
    if index < arrayLength(&positions) / 3u {
        for (var axis = 0u; axis < 3u; axis += 1u) {
            let place = positions[3u * index + axis];
            atomicMax(&most[axis], key(place));
            atomicMax(&most[axis + 3u], key(-place));
        }
    }
    workgroupBarrier();
    if lane < 6u {
        atomicMax(&extent[lane], atomicLoad(&most[lane]));
    }
}

// Leaves no extent for the next time.
@compute @workgroup_size(1)
fn fit() {
    var high = vec3<f32>(0.0);
    var low = vec3<f32>(0.0);
    for (var axis = 0u; axis < 3u; axis += 1u) {
        let keys = vec2<u32>(atomicExchange(&extent[axis], 0u), atomicExchange(&extent[axis + 3u], 0u));
        if keys.x != 0u {
            high[axis] = value_of(keys.x);
            low[axis] = -value_of(keys.y);
        }
    }
    let centre = 0.5 * low + 0.5 * high;
    let reach = 0.5 * high - 0.5 * low;
    let least = 1e-3 * max(max(max(reach.x, reach.y), reach.z), LEAST);
    for (var k = 0u; k < suns.count; k += 1u) {
        let axes = mat3x3<f32>(abs(suns.suns[k].right), abs(suns.suns[k].up), abs(suns.suns[k].towards));
        let half = MARGIN * max(reach * axes, vec3<f32>(least));
        suns.suns[k].centre = centre;
        suns.suns[k].half_width = half.x;
        suns.suns[k].half_height = half.y;
        suns.suns[k].half_depth = half.z;
    }
}
