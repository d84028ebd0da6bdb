//! Method `transfer-images`: a pixel is the sum over its fragments of image × coefficient (thesis eq. 4-26,
//! 4-27).

use crate::kinds::transfer_images::{FirstReflection, Head, Later, Layout, TransferImages};
use crate::state::Rgb;

/// Factors on the stored halves of every slot for every class of fragment: row-major [materials + 1, slots],
/// the last row for fixed fragments. Scale and, for single-channel slots, the colour of the light are
/// multiplied in.
///
/// `on_bases` holds, for every editable material in the order of the file, its coefficients
/// ([`crate::kinds::BrdfBasis::coefficients_of`]).
pub fn coefficients(head: &Head, layout: &Layout, on_bases: &[Vec<Rgb>]) -> Vec<Rgb> {
    let weights = |later: &Later| {
        let albedos = later.albedos_of(on_bases);
        (later.weights(&albedos), later.lobe_weights(&albedos))
    };
    let (later, lobes) = head.later.as_ref().map(weights).unwrap_or_default();
    let of_first = |first: FirstReflection| match first {
        FirstReflection::None | FirstReflection::Fixed => [1.0; 3],
        FirstReflection::Editable { material, basis } => on_bases[material][basis],
        FirstReflection::Later { node } => later[node],
        FirstReflection::LaterLobe { material, basis, node } => {
            Later::of_lobe(on_bases[material][basis], lobes[node])
        }
    };
    let colour = head.meta.chromaticity.unwrap_or([1.0; 3]);
    let mut table = Vec::with_capacity((layout.materials + 1) * layout.slots.len());
    for class in 0..=layout.materials {
        for (slot, &scale) in layout.slots.iter().zip(&head.scales) {
            let factor = match (on_bases.get(class), slot.fixed) {
                (Some(eye), _) => product(eye[slot.eye_basis], of_first(slot.first)),
                (None, Some(first)) => of_first(first),
                (None, None) => [0.0; 3],
            };
            let colour = if slot.rgb { [1.0; 3] } else { colour };
            table.push(product(factor, colour).map(|c| c * scale));
        }
    }
    table
}

fn product(a: Rgb, b: Rgb) -> Rgb {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// Linear radiance of every pixel, row by row; `on_bases` as for [`coefficients`].
pub fn evaluate(bundle: &TransferImages, on_bases: &[Vec<Rgb>]) -> Vec<Rgb> {
    let head = &bundle.head;
    let layout = head.layout();
    let table = coefficients(head, &layout, on_bases);
    let mut by_slot: Vec<_> = bundle.images.iter().collect();
    by_slot.sort_by_key(|image| image.slot);

    let mut film = vec![[0.0; 3]; head.meta.size[0] as usize * head.meta.size[1] as usize];
    for image in by_slot {
        let slot = &layout.slots[image.slot];
        let fragments = head.fragments_of(slot);
        for fragment in 0..fragments {
            let factor = table[usize::from(head.class[fragment]) * layout.slots.len() + image.slot];
            let pixel = &mut film[head.pixel[fragment] as usize];
            for channel in 0..3 {
                let plane = if slot.rgb { channel } else { 0 };
                pixel[channel] += factor[channel] * image.values[plane * fragments + fragment].to_f32();
            }
        }
    }
    film
}
