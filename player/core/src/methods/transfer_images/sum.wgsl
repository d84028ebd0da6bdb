// Adds up fragments × slots for every pixel of a band: the GPU twin of `relume_formats::evaluate::transfer_images`.
//
// Slots are added in ascending order and the fragments of a pixel in theirs, exactly as on the CPU, so the sum does not depend on how
// slots are spread over storage chunks or pixels over bands.

#import half
#import invocation

struct Dispatch {
    // Pixels of the band.
    pixels: u32,
    // The slots of the storage chunk: first_slot..end_slot.
    first_slot: u32,
    end_slot: u32,
    // All slots of the bake: the length of a row of `coefficients`.
    slots: u32,
    // 0 if this is the first chunk, whose sum starts from nothing; else 1.
    accumulate: u32,
}

struct Slot {
    // Where the first plane starts in the chunk, in halves.
    offset: u32,
    // From one channel's plane to the next, in halves; even.
    stride: u32,
    // Fragments that have a value here. Editable fragments come first, so slots without fixed fragments just end earlier.
    fragments: u32,
    // 1: planes for R, G and B; 0: one plane for all three.
    rgb: u32,
}

struct Fragment {
    // Position within a plane.
    index: u32,
    // Row of `coefficients`: the material seen.
    material: u32,
}

@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> slots: array<Slot>;
// Row-major [materials + 1, slots]; the fourth component is unused.
@group(0) @binding(2) var<storage, read> coefficients: array<vec4<f32>>;
// Two halves a word, the first in the low bits.
@group(0) @binding(3) var<storage, read> halves: array<u32>;
// The fragments of pixel p are starts[p]..starts[p + 1].
@group(0) @binding(4) var<storage, read> starts: array<u32>;
@group(0) @binding(5) var<storage, read> fragments: array<Fragment>;
// Linear radiance; the fourth component is unused.
@group(0) @binding(6) var<storage, read_write> film: array<vec4<f32>>;

fn half_at(position: u32) -> f32 {
    return half_of(halves[position / 2u], position);
}

fn contribution(slot_index: u32, slot: Slot, fragment: Fragment) -> vec3<f32> {
    if fragment.index >= slot.fragments {
        return vec3<f32>(0.0);
    }
    let factor = coefficients[fragment.material * dispatch.slots + slot_index].rgb;
    let red = slot.offset + fragment.index;
    if slot.rgb == 0u {
        return factor * half_at(red);
    }
    return factor * vec3<f32>(half_at(red), half_at(red + slot.stride), half_at(red + 2u * slot.stride));
}

@compute @workgroup_size(64)
fn sum_slots(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = invocation(group, groups, 64u, lane);
    if pixel >= dispatch.pixels {
        return;
    }
    var sum = vec3<f32>(0.0);
    if dispatch.accumulate == 1u {
        sum = film[pixel].rgb;
    }
    let begin = starts[pixel];
    let end = starts[pixel + 1u];
    if begin < end {
        // Most pixels have one fragment: keep it in registers.
        let first = fragments[begin];
        for (var s = dispatch.first_slot; s < dispatch.end_slot; s += 1u) {
            let slot = slots[s];
            // Slots that serve fixed fragments come first, and editable fragments come before fixed ones: from here on there is nothing for this pixel.
            if first.index >= slot.fragments {
                break;
            }
            sum += contribution(s, slot, first);
            for (var f = begin + 1u; f < end; f += 1u) {
                sum += contribution(s, slot, fragments[f]);
            }
        }
    }
    film[pixel] = vec4<f32>(sum, 0.0);
}
