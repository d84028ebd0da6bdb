//! Where the stored halves of every slot lie in the buffer of a band: slot by slot, plane by plane, tile by
//! tile. Planes of slots that have no values of fixed fragments end with the editable tiles.

use super::bands::Band;
use super::gpu_data::Slot;
use half::f16;
use relume_formats::kinds::transfer_images::Layout;

/// Fragments of a tile, as in the shader.
pub(super) const TILE: u32 = 64;
/// Halves of a wide word.
const WORD_HALVES: u32 = 8;
/// Wide words of a tile in a plane.
const TILE_WORDS: u32 = TILE / WORD_HALVES;
/// Bytes of a tile in a plane.
const TILE_BYTES: u64 = TILE as u64 * size_of::<f16>() as u64;

/// How many planes there are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Volume {
    /// That have values of editable fragments: all.
    planes: u64,
    /// That have values of fixed fragments too.
    fixed_planes: u64,
}

impl Volume {
    /// Of all slots.
    pub(super) fn new(layout: &Layout) -> Self {
        let fixed = layout.slots.iter().filter(|slot| slot.fixed.is_some());
        let fixed_planes = fixed.map(|slot| slot.channels()).sum::<usize>() as u64;
        Self { planes: layout.channels() as u64, fixed_planes }
    }

    /// Bytes of the images of a band of `tiles` tiles, the first `editable` ones of editable fragments.
    pub(super) fn bytes(&self, editable: u64, tiles: u64) -> u64 {
        TILE_BYTES * (editable * self.planes + (tiles - editable) * self.fixed_planes)
    }
}

/// Where each slot lies in a band.
pub(super) fn slots(layout: &Layout, band: &Band) -> Vec<Slot> {
    let mut end = 0;
    let place = |slot: &relume_formats::kinds::transfer_images::Slot| {
        let tiles = if slot.fixed.is_some() { band.classes.len() as u32 } else { band.editable_tiles };
        let (first, plane) = (end, TILE_WORDS * tiles);
        end += plane * slot.channels() as u32;
        Slot { first, stride: if slot.rgb { plane } else { 0 } }
    };
    layout.slots.iter().map(place).collect()
}

/// Where in the buffer of a band a slot begins, in bytes.
pub(super) fn offset_bytes(slot: &Slot) -> u64 {
    u64::from(slot.first) * u64::from(WORD_HALVES) * size_of::<f16>() as u64
}

/// The planes of an image as they lie in a band, of `fragments` halves each in the file; `is_fixed` if it has
/// values of fixed fragments too.
pub(super) fn arranged(values: &[f16], fragments: usize, band: &Band, is_fixed: bool) -> Vec<f16> {
    let tiles = if is_fixed { band.classes.len() } else { band.editable_tiles as usize };
    let places = band.fragments.get(..tiles * TILE as usize).unwrap_or_default();
    // Beyond the end is nothing, as behind the end of a class.
    let of_plane = |plane: &[f16]| {
        places.iter().map(|at| plane.get(*at as usize).copied().unwrap_or_default()).collect::<Vec<_>>()
    };
    values.chunks_exact(fragments.max(1)).flat_map(of_plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::transfer_images::bands::{NOTHING, cut};
    use crate::support;

    #[test]
    fn every_half_is_where_the_shader_looks_for_it() {
        for one_colour in [true, false] {
            let images = support::images(one_colour);
            let (head, layout) = (&images.head, images.head.layout());
            let volume = Volume::new(&layout);
            for band in cut(head, &volume, 2 * volume.bytes(2, 3)).unwrap() {
                let bytes = volume.bytes(band.editable_tiles.into(), band.classes.len() as u64);
                let slots = slots(&layout, &band);
                let mut buffer = vec![f16::NAN; bytes as usize / 2];
                for image in &images.images {
                    let (slot, meaning) = (&slots[image.slot], &layout.slots[image.slot]);
                    let fragments = head.fragments_of(meaning);
                    let halves = arranged(&image.values, fragments, &band, meaning.fixed.is_some());
                    let at = offset_bytes(slot) as usize / 2;
                    assert!(buffer[at..][..halves.len()].iter().all(|h| h.is_nan()), "no two overlap");
                    buffer[at..][..halves.len()].copy_from_slice(&halves);
                }
                assert!(buffer.iter().all(|h| !h.is_nan()), "nor is there a gap");
                for image in &images.images {
                    let (slot, meaning) = (&slots[image.slot], &layout.slots[image.slot]);
                    let count = head.fragments_of(meaning);
                    for (place, fragment) in band.fragments.iter().enumerate() {
                        if *fragment == NOTHING || *fragment as usize >= count {
                            continue;
                        }
                        for channel in 0..meaning.channels() {
                            let at = 8 * (slot.first + channel as u32 * slot.stride) as usize + place;
                            let expected = image.values[channel * count + *fragment as usize];
                            assert_eq!(buffer[at], expected);
                        }
                    }
                }
            }
        }
    }
}
