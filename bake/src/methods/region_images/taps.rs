//! Where painted surfaces are in their textures, pixel by pixel: the middles of the quarters of what each pixel shows.

use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::trace::gather::Gather;
use rayon::prelude::*;
use relume_formats::kinds::region_images::{REGIONS, TAPS, Tap};
use relume_scenes::Scene;

/// Side of the square of parts that a pixel has.
const SIDE: usize = 2;
const _: () = assert!(SIDE * SIDE == TAPS);
/// How far apart two points of a pixel's part may be in a texture, by each axis: farther ones are beyond a seam.
const APART: f32 = 1.0 / REGIONS as f32;

/// The samples of a part of a pixel on one material.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    count: u32,
    /// The first, and the sum of those that are near to it.
    first: [f32; 2],
    near: u32,
    sum: [f32; 2],
}

impl Part {
    fn add(&mut self, uv: [f32; 2]) {
        if self.count == 0 {
            self.first = uv;
        }
        self.count += 1;
        if (0..2).all(|k| (uv[k] - self.first[k]).abs() <= APART) {
            self.near += 1;
            (0..2).for_each(|k| self.sum[k] += uv[k]);
        }
    }

    fn tap(&self, all: u32) -> Tap {
        let middle = self.sum.map(|sum| sum / self.near.max(1) as f32);
        let weight = (255.0 * self.count as f32 / all as f32).round() as u8;
        Tap { place: middle.map(|x| (x.clamp(0.0, 1.0) * 65_535.0).round() as u16), weight }
    }
}

/// Those of fragments (pixel, class) of painted materials, by the film samples of `gather`.
///
/// # Errors
/// If the job is interrupted.
pub fn taps(
    scene: &Scene,
    gather: &Gather<'_>,
    samples: u32,
    fragments: &[(u32, u16)],
    job: &Job,
) -> Result<Vec<[Tap; TAPS]>, Interrupted> {
    let progress = job.progress("finding texels", fragments.len() as u64);
    let of = |(pixel, class): &(u32, u16)| {
        progress.check()?;
        let mut parts = [Part::default(); TAPS];
        gather.seen(*pixel, gather.samples(*pixel, samples), |within, spot| {
            if scene.vary.place_of(spot.material) == Some(usize::from(*class)) {
                let [x, y] = within.map(|x| usize::from(x >= 0.5));
                parts[y * SIDE + x].add(spot.uv);
            }
        });
        progress.advance(1);
        let all = parts.iter().map(|part| part.count).sum::<u32>().max(1);
        let mut taps = parts.map(|part| part.tap(all));
        // Of very many samples a few in a part may round to none.
        if taps.iter().all(|tap| tap.weight == 0) {
            taps[0].weight = 1;
        }
        Ok(taps)
    };
    fragments.par_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_across_a_seam_stays_on_one_side() {
        let mut part = Part::default();
        for uv in [[0.50, 0.25], [0.51, 0.25], [0.9, 0.1], [0.52, 0.25]] {
            part.add(uv);
        }
        let tap = part.tap(8);
        assert_eq!(tap.weight, 128);
        let [u, v] = tap.uv();
        assert!((u - 0.51).abs() < 2e-5 && (v - 0.25).abs() < 2e-5, "{u} {v}");
    }
}
