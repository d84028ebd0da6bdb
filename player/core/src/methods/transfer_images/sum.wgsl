// Adds up image × coefficient over the slots for every fragment of a band: the GPU twin of `relume_formats::evaluate::transfer_images`.
//
// A workgroup sums a tile of 64 fragments of one class, which need one coefficient in each slot. Eight lanes side by side take eight fragments each, so
// that they load 128 bytes in a row, and eight such rows of lanes take the slots in turn, so that many loads are under way. In the end the rows of lanes
// are added up in their order: the sum of a fragment does not depend on how pixels are spread over bands.

#import invocation

struct Dispatch {
    // Tiles of the band.
    tiles: u32,
    // The last class: what is fixed. It has a value in the first slots alone.
    fixed_class: u32,
    fixed_slots: u32,
    // All slots of the bake: the length of a row of `coefficients`.
    slots: u32,
}

// Offsets are in wide words of eight halves, eight of them for each tile.
struct Slot {
    // Where the first plane starts.
    first: u32,
    // From one channel's plane to the next; 0 if one plane serves all three.
    stride: u32,
}

// Of eight fragments.
struct Eight {
    low: vec4<f32>,
    high: vec4<f32>,
}

// Wide words of a tile, one for each of the lanes side by side.
const COLUMNS = 8u;
// Rows of lanes.
const ROWS = 8u;
const TILE = 64u;
// From row to row of `partial`: eight more than three channels of a tile, lest rows of lanes write into the same banks of memory.
const ROW_STRIDE = 200u;

// In targets: the number of a sum, not of a pixel.
const IS_SHARED = 0x80000000u;
// In targets: there is no fragment.
const NOTHING = 0xffffffffu;

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> slots: array<Slot>;
// Row-major [materials + 1, slots]; the fourth component is unused.
@group(0) @binding(2) var<storage, read> coefficients: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> halves: array<vec4<u32>>;
// By tile: the row of `coefficients`.
@group(0) @binding(4) var<storage, read> classes: array<u32>;
// By fragment: the pixel of the band, if it has no other fragment, else where in `shared_sums` its part goes.
@group(0) @binding(5) var<storage, read> targets: array<u32>;
// Linear radiance; the fourth component is unused.
@group(0) @binding(6) var<storage, read_write> film: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> shared_sums: array<vec4<f32>>;

// [ROWS, 3, eight of a lane, COLUMNS]
var<workgroup> partial: array<f32, 1600>;

fn eight_halves(at: u32) -> Eight {
    let word = halves[at];
    return Eight(
        vec4<f32>(unpack2x16float(word.x), unpack2x16float(word.y)),
        vec4<f32>(unpack2x16float(word.z), unpack2x16float(word.w)),
    );
}

fn add(sum: Eight, factor: f32, values: Eight) -> Eight {
    return Eight(sum.low + factor * values.low, sum.high + factor * values.high);
}

fn keep(at: u32, sum: Eight) {
    partial[at] = sum.low.x;
    partial[at + COLUMNS] = sum.low.y;
    partial[at + 2u * COLUMNS] = sum.low.z;
    partial[at + 3u * COLUMNS] = sum.low.w;
    partial[at + 4u * COLUMNS] = sum.high.x;
    partial[at + 5u * COLUMNS] = sum.high.y;
    partial[at + 6u * COLUMNS] = sum.high.z;
    partial[at + 7u * COLUMNS] = sum.high.w;
}

@compute @workgroup_size(64)
fn sum_slots(
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
    let material = classes[tile];
    let end = select(dispatch.slots, dispatch.fixed_slots, material == dispatch.fixed_class);
    var red = Eight();
    var green = Eight();
    var blue = Eight();
    for (var s = row; s < end; s += ROWS) {
        let slot = slots[s];
        let factor = coefficients[material * dispatch.slots + s].rgb;
        let at = slot.first + COLUMNS * tile + column;
        let first = eight_halves(at);
        red = add(red, factor.r, first);
        if slot.stride == 0u {
            green = add(green, factor.g, first);
            blue = add(blue, factor.b, first);
        } else {
            green = add(green, factor.g, eight_halves(at + slot.stride));
            blue = add(blue, factor.b, eight_halves(at + 2u * slot.stride));
        }
    }
    let at = ROW_STRIDE * row + column;
    keep(at, red);
    keep(at + TILE, green);
    keep(at + 2u * TILE, blue);
    workgroupBarrier();
    var sum = vec3<f32>(0.0);
    for (var r = 0u; r < ROWS; r += 1u) {
        let from_row = ROW_STRIDE * r + COLUMNS * (lane % 8u) + lane / 8u;
        sum += vec3<f32>(partial[from_row], partial[from_row + TILE], partial[from_row + 2u * TILE]);
    }
    let goal = targets[TILE * tile + lane];
    if goal < IS_SHARED {
        film[goal] = vec4<f32>(sum, 0.0);
    } else if goal != NOTHING {
        shared_sums[goal - IS_SHARED] = vec4<f32>(sum, 0.0);
    }
}
