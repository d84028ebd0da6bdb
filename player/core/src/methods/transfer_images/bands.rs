//! Which fragments are summed together, in bands of pixels that bindings can hold.
//!
//! A workgroup sums a tile of fragments of one class. A band has some pixels and all their fragments, class
//! by class, each class filled up to whole tiles; what is fixed comes last, as slots that have no values of it
//! just end earlier.

use super::gpu_data::SharedPixel;
use super::storage::{TILE, Volume};
use crate::gpu::Film;
use relume_formats::kinds::transfer_images::Head;
use std::ops::Range;

/// In [`Band::targets`]: the number of a sum, not of a pixel, as in the shader.
const IS_SHARED: u32 = 1 << 31;
/// In [`Band::targets`] and [`Band::fragments`]: there is no fragment.
pub(super) const NOTHING: u32 = u32::MAX;

/// Consecutive pixels and their fragments.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Band {
    /// The pixels.
    pub(super) pixels: Range<usize>,
    /// The class of each tile, ascending.
    pub(super) classes: Vec<u32>,
    /// Tiles of editable fragments, which come first.
    pub(super) editable_tiles: u32,
    /// By tile and place within it: the fragment, by its number in the file.
    pub(super) fragments: Vec<u32>,
    /// By tile and place within it: where the sum goes, as the shader has it.
    pub(super) targets: Vec<u32>,
    /// The pixels with several fragments.
    pub(super) shared: Vec<SharedPixel>,
}

/// Cuts the film into bands none of whose buffers exceeds `limit` bytes, or tells how many bytes a single
/// pixel needs that fits in none.
pub(super) fn cut(head: &Head, volume: &Volume, limit: u64) -> Result<Vec<Band>, u64> {
    let by_pixel = ByPixel::new(head);
    let pixels = by_pixel.starts.len() - 1;
    let classes = head.meta.materials.len() + 1;
    let mut bands = Vec::new();
    let (mut begin, mut counts) = (0, vec![0; classes]);
    for pixel in 0..pixels {
        by_pixel.count(pixel, &mut counts);
        if bytes(&counts, pixel + 1 - begin, volume) > limit {
            if pixel > begin {
                bands.push(by_pixel.band(begin..pixel, classes));
            }
            (begin, counts) = (pixel, vec![0; classes]);
            by_pixel.count(pixel, &mut counts);
            let alone = bytes(&counts, 1, volume);
            if alone > limit {
                return Err(alone);
            }
        }
    }
    bands.push(by_pixel.band(begin..pixels, classes));
    Ok(bands)
}

/// Bytes of the largest buffer of a band of so many `pixels`, with so many fragments of each class.
fn bytes(counts: &[u32], pixels: usize, volume: &Volume) -> u64 {
    let tiles = |counts: &[u32]| counts.iter().map(|count| u64::from(count.div_ceil(TILE))).sum::<u64>();
    let editable = tiles(&counts[..counts.len() - 1]);
    let all = tiles(counts);
    let sums = all * u64::from(TILE) * Film::PIXEL_BYTES;
    volume.bytes(editable, all).max(sums).max(pixels as u64 * Film::PIXEL_BYTES)
}

/// The fragments of every pixel.
struct ByPixel<'a> {
    head: &'a Head,
    /// Where those of each pixel start, and the end: one more than there are pixels.
    starts: Vec<u32>,
    /// Numbers of fragments, pixel by pixel, in the order of the file within each.
    fragments: Vec<u32>,
}

impl<'a> ByPixel<'a> {
    /// A stable counting sort.
    fn new(head: &'a Head) -> Self {
        let pixels = head.meta.size[0] as usize * head.meta.size[1] as usize;
        let mut starts = vec![0_u32; pixels + 1];
        for pixel in &head.pixel {
            starts[*pixel as usize + 1] += 1;
        }
        for pixel in 0..pixels {
            starts[pixel + 1] += starts[pixel];
        }
        let mut next = starts.clone();
        let mut fragments = vec![0; head.pixel.len()];
        for (pixel, number) in head.pixel.iter().zip(0..) {
            let place = &mut next[*pixel as usize];
            fragments[*place as usize] = number;
            *place += 1;
        }
        Self { head, starts, fragments }
    }

    fn of(&self, pixel: usize) -> &[u32] {
        &self.fragments[self.starts[pixel] as usize..self.starts[pixel + 1] as usize]
    }

    fn class(&self, fragment: u32) -> usize {
        usize::from(self.head.class[fragment as usize])
    }

    /// Adds the fragments of `pixel` to the counts by class.
    fn count(&self, pixel: usize, counts: &mut [u32]) {
        self.of(pixel).iter().for_each(|fragment| counts[self.class(*fragment)] += 1);
    }

    /// The band of these `pixels`.
    fn band(&self, pixels: Range<usize>, classes: usize) -> Band {
        let mut band = Band { pixels: pixels.clone(), ..Band::default() };
        // By class: fragments, and where their sums go.
        let mut lists = vec![(Vec::new(), Vec::new()); classes];
        let mut sums = 0;
        for (pixel, number) in pixels.zip(0..) {
            let fragments = self.of(pixel);
            let is_shared = fragments.len() > 1;
            for (fragment, sum) in fragments.iter().zip(sums..) {
                let (list, targets) = &mut lists[self.class(*fragment)];
                list.push(*fragment);
                targets.push(if is_shared { IS_SHARED | sum } else { number });
            }
            if is_shared {
                let end = sums + fragments.len() as u32;
                band.shared.push(SharedPixel { pixel: number, first: sums, end });
                sums = end;
            }
        }
        for ((fragments, targets), class) in lists.into_iter().zip(0..) {
            let tiles = fragments.len().div_ceil(TILE as usize);
            band.classes.resize(band.classes.len() + tiles, class);
            if class as usize + 1 < classes {
                band.editable_tiles += tiles as u32;
            }
            for (all, more) in [(&mut band.fragments, fragments), (&mut band.targets, targets)] {
                all.extend(more);
                all.resize(band.classes.len() * TILE as usize, NOTHING);
            }
        }
        band
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;

    /// (pixel, fragment) for every fragment of a band, in the order in which they are added up.
    fn listed(band: &Band, head: &Head) -> Vec<(usize, u32)> {
        let mut found = Vec::new();
        for (place, (fragment, target)) in band.fragments.iter().zip(&band.targets).enumerate() {
            assert_eq!(*fragment == NOTHING, *target == NOTHING);
            if *fragment == NOTHING {
                continue;
            }
            let class = u32::from(head.class[*fragment as usize]);
            assert_eq!(band.classes[place / TILE as usize], class);
            assert_eq!((place as u32) < TILE * band.editable_tiles, class < 2);
            let shared = |s: &&SharedPixel| (s.first..s.end).contains(&(target - IS_SHARED));
            let pixel = if *target < IS_SHARED {
                (*target, 0)
            } else {
                (band.shared.iter().find(shared).unwrap().pixel, *target)
            };
            found.push((band.pixels.start + pixel.0 as usize, pixel.1, *fragment));
        }
        found.sort_unstable();
        found.into_iter().map(|(pixel, _, fragment)| (pixel, fragment)).collect()
    }

    #[test]
    fn every_fragment_is_listed_once_under_its_pixel() {
        let head = support::images(true).head;
        let volume = Volume::new(&head.layout());
        let mut expected: Vec<_> =
            (0..head.pixel.len()).map(|i| (head.pixel[i] as usize, i as u32)).collect();
        expected.sort();
        let least = volume.bytes(2, 3);
        for (limit, several) in [(1 << 27, false), (2 * least, true), (least, true)] {
            let bands = cut(&head, &volume, limit).unwrap();
            assert_eq!(bands.len() > 1, several);
            let all: Vec<_> = bands.iter().flat_map(|band| listed(band, &head)).collect();
            assert_eq!(all, expected, "{limit}");
            let pixels: Vec<_> = bands.iter().flat_map(|b| b.pixels.clone()).collect();
            assert_eq!(pixels, (0..support::PIXELS).collect::<Vec<_>>());
            for band in &bands {
                let size = volume.bytes(band.editable_tiles.into(), band.classes.len() as u64);
                assert!(size <= limit && band.fragments.len() == band.classes.len() * TILE as usize);
                assert_eq!(band.targets.len(), band.fragments.len());
            }
        }
        // Some pixel has fragments of all three classes.
        assert_eq!(cut(&head, &volume, least - 1), Err(least));
    }
}
