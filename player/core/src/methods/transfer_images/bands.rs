//! Which fragments every pixel has, in bands of pixels that bindings can hold.

use super::gpu_data::Fragment;
use crate::gpu::Film;
use relume_formats::kinds::transfer_images::Head;
use std::ops::Range;

/// Consecutive pixels and their fragments.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Band {
    /// The pixels.
    pub(super) pixels: Range<usize>,
    /// Where the fragments of each pixel start, and the end: one more than there are pixels.
    pub(super) starts: Vec<u32>,
    /// The fragments, pixel by pixel, in the order of the file within each.
    pub(super) fragments: Vec<Fragment>,
}

/// Cuts the film into bands none of whose buffers exceeds `limit` bytes (unless a single pixel does).
pub(super) fn cut(head: &Head, limit: u64) -> Vec<Band> {
    let (starts, fragments) = by_pixel(head);
    let pixels = starts.len() - 1;
    let most_pixels = (limit / Film::PIXEL_BYTES).max(1) as usize;
    let most_fragments = (limit / size_of::<Fragment>() as u64) as u32;
    let mut bands = Vec::new();
    let mut begin = 0;
    while begin < pixels {
        let from = starts[begin];
        // `starts` never decreases, so the pixels that fit are those before the first start that does not.
        let fit =
            starts[begin + 1..].partition_point(|start| start - from <= most_fragments).clamp(1, most_pixels);
        let end = (begin + fit).min(pixels);
        bands.push(Band {
            pixels: begin..end,
            starts: starts[begin..=end].iter().map(|start| start - from).collect(),
            fragments: fragments[from as usize..starts[end] as usize].to_vec(),
        });
        begin = end;
    }
    bands
}

/// A stable counting sort of the fragments by pixel.
fn by_pixel(head: &Head) -> (Vec<u32>, Vec<Fragment>) {
    let pixels = head.meta.size[0] as usize * head.meta.size[1] as usize;
    let mut starts = vec![0_u32; pixels + 1];
    for pixel in &head.pixel {
        starts[*pixel as usize + 1] += 1;
    }
    for pixel in 0..pixels {
        starts[pixel + 1] += starts[pixel];
    }
    let mut next = starts.clone();
    let mut sorted = vec![Fragment { index: 0, material: 0 }; head.pixel.len()];
    for (index, (pixel, class)) in head.pixel.iter().zip(&head.class).enumerate() {
        let place = &mut next[*pixel as usize];
        sorted[*place as usize] = Fragment { index: index as u32, material: u32::from(*class) };
        *place += 1;
    }
    (starts, sorted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;

    /// (pixel, index, material) of every fragment, in the order of the bands.
    fn listed(bands: &[Band]) -> Vec<(usize, u32, u32)> {
        let of_band = |band: &Band| {
            let of_pixel = |p: usize| &band.fragments[band.starts[p] as usize..band.starts[p + 1] as usize];
            let named = |p| of_pixel(p).iter().map(move |f| (band.pixels.start + p, f.index, f.material));
            (0..band.pixels.len()).flat_map(named).collect::<Vec<_>>()
        };
        bands.iter().flat_map(of_band).collect()
    }

    #[test]
    fn every_fragment_is_listed_once_under_its_pixel() {
        let head = support::images(true).head;
        let mut expected: Vec<_> = (0..head.pixel.len())
            .map(|i| (head.pixel[i] as usize, i as u32, u32::from(head.class[i])))
            .collect();
        expected.sort();
        for limit in [1 << 27, 4096, 200, 16, 1] {
            let bands = cut(&head, limit);
            assert_eq!(listed(&bands), expected, "{limit}");
            assert_eq!(
                bands.iter().flat_map(|b| b.pixels.clone()).collect::<Vec<_>>(),
                (0..support::PIXELS).collect::<Vec<_>>()
            );
            let within = |b: &Band| {
                b.pixels.len() == 1
                    || (b.pixels.len() as u64 * Film::PIXEL_BYTES).max(b.fragments.len() as u64 * 8) <= limit
            };
            assert!(bands.iter().all(within), "{limit}");
        }
    }
}
