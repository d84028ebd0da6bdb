//! What the samples of a pixel add up to, class by class.

use super::tiles::{Tile, TileFragment};
use crate::filter::Seen;
use crate::filter::seen::half_of;
use crate::trace::gather::{Gather, GatherPath};

/// What the samples of one pixel add up to, by class, the fixed one last.
pub struct PixelRecords(Vec<PixelRecord>);

/// What the samples of one class in a pixel add up to.
#[derive(Clone, Default)]
pub struct PixelRecord {
    /// Their number.
    pub count: u32,
    /// What is seen beside its channels; what anything emits is with the fixed class.
    pub seen: Seen,
    /// By channel.
    pub sums: Vec<f32>,
}

impl PixelRecords {
    /// Nothing yet, of so many materials that vary; their fragments have so many channels, and fixed ones so many.
    pub fn new(materials: usize, [editable, fixed]: [usize; 2]) -> Self {
        let of = |channels| PixelRecord { sums: vec![0.0; channels], ..PixelRecord::default() };
        Self((0..materials).map(|_| of(editable)).chain([of(fixed)]).collect())
    }

    /// That of a class.
    pub fn of(&mut self, class: usize) -> &mut PixelRecord {
        &mut self.0[class]
    }

    /// Hands over every class that was met or emits, and forgets them.
    fn drain(&mut self, mut each: impl FnMut(usize, &PixelRecord)) {
        for (class, record) in self.0.iter_mut().enumerate() {
            if record.count > 0 || record.seen != Seen::default() {
                each(class, record);
                (record.count, record.seen) = (0, Seen::default());
                record.sums.fill(0.0);
            }
        }
    }
}

/// The fragments of some pixels of a film of so many `samples`, `records` being empty. `add` is given every path, with
/// the half of the samples that it is of, 0 or 1.
pub fn trace(
    pixels: impl Iterator<Item = u32>,
    samples: u32,
    gather: &Gather<'_>,
    mut records: PixelRecords,
    add: impl Fn(&GatherPath, usize, &mut PixelRecords),
) -> Tile {
    let mut tile = Tile::default();
    for pixel in pixels {
        let (mut number, samples) = (0, gather.samples(pixel, samples));
        gather.pixel(pixel, samples, |path| {
            add(path, half_of(number, samples), &mut records);
            number += 1;
        });
        records.drain(|class, record| {
            let PixelRecord { count, seen, .. } = *record;
            tile.fragments.push(TileFragment { pixel, class: class as u16, count, seen });
            tile.values.extend_from_slice(&record.sums);
        });
    }
    tile
}
