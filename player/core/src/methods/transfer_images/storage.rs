//! Where the stored halves of every slot lie on the GPU.
//!
//! Slots stand in their order, packed into as few chunks as bindings allow; a slot never straddles two. Each
//! channel's plane is padded to an even number of halves, so that planes start on whole words and can be
//! written one by one.

use super::gpu_data::Slot;
use half::f16;
use relume_formats::kinds::transfer_images::{Head, Layout};
use std::ops::Range;

/// Slots that share a storage buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chunk {
    /// The slots.
    pub(super) slots: Range<usize>,
    /// Size of the buffer.
    pub(super) bytes: u64,
}

/// The place of every slot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Storage {
    /// The buffers.
    pub(super) chunks: Vec<Chunk>,
    /// By slot: where it lies in its chunk.
    pub(super) slots: Vec<Slot>,
}

impl Storage {
    /// Places all slots in chunks of at most `limit` bytes, or tells how many bytes the slot needs that fits
    /// in none.
    pub(super) fn arrange(head: &Head, layout: &Layout, limit: u64) -> Result<Self, u64> {
        let mut storage = Self { chunks: Vec::new(), slots: Vec::with_capacity(layout.slots.len()) };
        for (index, slot) in layout.slots.iter().enumerate() {
            let fragments = head.fragments_of(slot) as u32;
            let stride = fragments.next_multiple_of(2);
            let bytes = 2 * u64::from(stride) * slot.channels() as u64;
            if bytes > limit {
                return Err(bytes);
            }
            let offset = (storage.place(index, bytes, limit) / 2) as u32;
            storage.slots.push(Slot { offset, stride, fragments, rgb: u32::from(slot.rgb) });
        }
        Ok(storage)
    }

    /// Makes room for `bytes` of slot `index`, in a new chunk if the last is full. Returns the offset in
    /// bytes.
    fn place(&mut self, index: usize, bytes: u64, limit: u64) -> u64 {
        match self.chunks.last_mut() {
            Some(chunk) if chunk.bytes + bytes <= limit => {
                chunk.slots.end = index + 1;
                chunk.bytes += bytes;
                chunk.bytes - bytes
            }
            _ => {
                self.chunks.push(Chunk { slots: index..index + 1, bytes });
                0
            }
        }
    }
}

/// Planes of `fragments` halves, each padded to an even number of them.
pub(super) fn padded(values: &[f16], fragments: usize) -> Vec<f16> {
    let pad = [f16::ZERO];
    let pad = pad.get(..fragments % 2).unwrap_or_default();
    values.chunks_exact(fragments.max(1)).flat_map(|plane| plane.iter().chain(pad)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;

    #[test]
    fn chunks_are_few_and_never_too_large() {
        let images = support::images(true);
        let layout = images.head.layout();
        let whole = Storage::arrange(&images.head, &layout, 1 << 27).unwrap();
        assert_eq!(whole.chunks.len(), 1);
        let largest = whole.slots.iter().map(|s| u64::from(s.stride) * 6).max().unwrap();
        for limit in [largest, largest + 2, 3 * largest, whole.chunks[0].bytes - 1] {
            let storage = Storage::arrange(&images.head, &layout, limit).unwrap();
            assert!(storage.chunks.iter().all(|c| c.bytes <= limit));
            assert_eq!(
                storage.chunks.iter().flat_map(|c| c.slots.clone()).collect::<Vec<_>>(),
                (0..layout.slots.len()).collect::<Vec<_>>()
            );
            let bytes = |slot: usize| {
                2 * u64::from(storage.slots[slot].stride) * layout.slots[slot].channels() as u64
            };
            let full = |w: &[Chunk]| w[0].bytes + bytes(w[1].slots.start) > limit;
            assert!(storage.chunks.windows(2).all(full), "a chunk ends only when the next slot does not fit");
        }
        assert_eq!(Storage::arrange(&images.head, &layout, largest - 1), Err(largest));
    }

    #[test]
    fn slots_do_not_overlap() {
        let images = support::images(false);
        let layout = images.head.layout();
        let storage = Storage::arrange(&images.head, &layout, 20_000).unwrap();
        for chunk in &storage.chunks {
            let mut end = 0;
            for (slot, meaning) in
                storage.slots[chunk.slots.clone()].iter().zip(&layout.slots[chunk.slots.clone()])
            {
                assert_eq!(
                    (slot.offset, slot.stride % 2, slot.fragments as usize),
                    (end, 0, images.head.fragments_of(meaning))
                );
                end += slot.stride * meaning.channels() as u32;
            }
            assert_eq!(u64::from(end) * 2, chunk.bytes);
        }
    }

    #[test]
    fn odd_planes_are_padded() {
        let h = f16::from_f32;
        let values: Vec<f16> = (1..=6).map(|i| h(i as f32)).collect();
        assert_eq!(padded(&values, 3), [1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 0.0].map(h));
        assert_eq!(padded(&values, 2), values);
        assert_eq!(padded(&[], 0), []);
    }
}
