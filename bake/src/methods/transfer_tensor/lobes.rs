//! Means of reflectance over texels of a coarse light.
//!
//! A texel of 6×8×8 is 14° wide in the middle of a face, as wide as the sharpest lobe, so that the
//! reflectance at its middle says little. A mean is taken over 1, 2², 4² or 8² points of a texel, the last
//! being those that visibility is found for: as many as keep the half vector's way from point to point below
//! [`STEP`] of the width that lobes have where it is. That way is half as long as the point's divided by the
//! cosine of the angle between half vector and outgoing direction, so that lobes seen along a surface, which
//! are narrow, get more points. Lobes of all sharpnesses make up the functions of a basis; at an angle δ from
//! the peak those count that are some δ/2 wide and wider.

use super::classes::MOST;
use crate::brdf::angles;
use crate::methods::sparse_transfer::texels::FACE_SIZE as FINE;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::basis::cubemap::{FACES, direction, solid_angles};

/// Standard deviation of the half vector of the sharpest lobe that may vary, cos²⁰⁰δ ≈ e^(−δ²/2σ²), radians.
const SHARPEST: f32 = 0.070_7;
/// The farthest from point to point, in standard deviations of the sharpest lobe that counts: the midpoint
/// rule then errs by 0.6²/24 = 1.5 % of the peak of that lobe's share at most.
const STEP: f32 = 0.6;

/// The points of the texels of a light.
pub struct Lobes {
    face_size: usize,
    /// From one point a texel to the finest.
    levels: Vec<Level>,
}

/// As many points for each texel, those of one behind those of another.
struct Level {
    points: usize,
    directions: Vec<Vec3A>,
    solid_angles: Vec<f32>,
}

impl Lobes {
    /// For a light of `face_size`² texels a face, a power of two of at most 64.
    pub fn new(face_size: usize) -> Self {
        let count = (FINE / face_size).trailing_zeros() as usize + 1;
        Self { face_size, levels: (0..count).map(|k| Level::new(face_size, 1 << k)).collect() }
    }

    /// The mean of `evaluate` over what of `texel` is above the horizon of `normal`, weighted with the
    /// cosine. No part of a texel of which the centres of the finest points are below the horizon counts.
    pub fn mean(
        &self,
        texel: usize,
        normal: Vec3A,
        outgoing: Vec3A,
        evaluate: impl Fn(&Angles) -> [f32; MOST],
    ) -> [f32; MOST] {
        let first = self.level(self.levels[0].directions[texel], normal, outgoing);
        // Of a texel at the horizon, coarse points may all be below.
        let means = self.levels[first..].iter().map(|level| level.mean(texel, normal, outgoing, &evaluate));
        means.flatten().next().unwrap_or([0.0; MOST])
    }

    /// The first level that is fine enough.
    fn level(&self, centre: Vec3A, normal: Vec3A, outgoing: Vec3A) -> usize {
        let width = 2.0 / self.face_size as f32;
        let at = angles(centre, outgoing, normal);
        let way = 0.5 * width / at.cos_difference.max(0.05);
        let reach = std::f32::consts::FRAC_1_SQRT_2;
        let from_peak = ((2.0 - 2.0 * at.cos_half).sqrt() - reach * way).max(0.0);
        let wide = SHARPEST.max(0.5 * from_peak);
        let of_lobe = (way / (STEP * wide)).log2().ceil().max(0.0) as usize;
        let of_horizon = if centre.dot(normal) < reach * width { 2 } else { 0 };
        of_lobe.max(of_horizon).min(self.levels.len() - 1)
    }

    /// The mean over the finest points, whatever the lobe.
    #[cfg(test)]
    pub fn finest(
        &self,
        texel: usize,
        normal: Vec3A,
        outgoing: Vec3A,
        evaluate: impl Fn(&Angles) -> [f32; MOST],
    ) -> [f32; MOST] {
        let mean = self.levels.last().and_then(|level| level.mean(texel, normal, outgoing, &evaluate));
        mean.unwrap_or([0.0; MOST])
    }
}

impl Level {
    fn new(face_size: usize, side: usize) -> Self {
        let n = face_size * side;
        let of_face = solid_angles(n);
        let place = |texel: usize, point: usize| {
            let (row, x) = (texel / face_size, texel % face_size);
            (row / face_size, x * side + point % side, row % face_size * side + point / side)
        };
        let places = || {
            (0..FACES * face_size * face_size).flat_map(move |t| (0..side * side).map(move |p| place(t, p)))
        };
        let towards = |(face, x, y)| direction(face, n, x as f64 + 0.5, y as f64 + 0.5).as_vec3a();
        Self {
            points: side * side,
            directions: places().map(towards).collect(),
            solid_angles: places().map(|(_, x, y)| of_face[y * n + x] as f32).collect(),
        }
    }

    /// `None` if no point is above the horizon.
    fn mean(
        &self,
        texel: usize,
        normal: Vec3A,
        outgoing: Vec3A,
        evaluate: &impl Fn(&Angles) -> [f32; MOST],
    ) -> Option<[f32; MOST]> {
        let points = texel * self.points..(texel + 1) * self.points;
        let (mut sums, mut total) = ([0.0; MOST], 0.0);
        for (incoming, solid_angle) in self.directions[points.clone()].iter().zip(&self.solid_angles[points])
        {
            let weight = incoming.dot(normal) * solid_angle;
            if weight > 0.0 {
                let values = evaluate(&angles(*incoming, outgoing, normal));
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
                total += weight;
            }
        }
        (total > 0.0).then(|| sums.map(|sum| sum / total))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::transfer_tensor::FACE_SIZE;
    use crate::trace::sampler::PixelSampler;

    /// Lobes of all sharpnesses and angles against all 64 points of each texel: the whole of what is
    /// reflected, as a norm over texels in parts of the lobe's own. The midpoint rule of the 64 themselves
    /// errs by a 24th of 0.35², half a per cent, where the lobe is sharpest.
    #[test]
    fn means_are_those_of_all_points() {
        let (lobes, normal) = (Lobes::new(FACE_SIZE), Vec3A::new(0.36, 0.48, 0.8));
        let (mut worst, mut mean) = (0.0f64, 0.0);
        for number in 0..60u32 {
            let sample = PixelSampler::new(3, 7).sample(number);
            let ([u, v], [w, _]) = (sample.pair(0), sample.pair(1));
            let (tangent, bitangent) = normal.any_orthonormal_pair();
            let (cos, phi) = (0.05 + 0.95 * u, std::f32::consts::TAU * v);
            let sin = (1.0 - cos * cos).sqrt();
            let outgoing = normal * cos + (tangent * phi.cos() + bitangent * phi.sin()) * sin;
            let exponent = 200.0f32.powf(w);
            let lobe = |at: &Angles| [at.cos_half.powf(exponent), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let (mut off, mut whole) = (0.0, 0.0);
            for texel in 0..FACES * FACE_SIZE * FACE_SIZE {
                let [found, all] = [
                    lobes.mean(texel, normal, outgoing, lobe)[0],
                    lobes.finest(texel, normal, outgoing, lobe)[0],
                ]
                .map(f64::from);
                off += (found - all).powi(2);
                whole += all * all;
            }
            let error = (off / whole).sqrt();
            worst = worst.max(error);
            mean += error / 60.0;
        }
        println!("relative L2 over texels: mean {mean:.5}, worst {worst:.5}");
        assert!(worst < 0.015, "mean {mean}, worst {worst}");
    }

    /// Where all is even a mean is, whatever the number of points.
    #[test]
    fn an_even_function_has_its_value_wherever_a_texel_reaches_above_the_horizon() {
        let lobes = Lobes::new(FACE_SIZE);
        let normal = Vec3A::new(0.1, -0.7, 0.7).normalize();
        let mut lit = 0;
        for texel in 0..FACES * FACE_SIZE * FACE_SIZE {
            let mean = lobes.mean(texel, normal, normal, |_| [2.5; MOST]);
            let points = lobes.levels[3].directions[64 * texel..][..64].iter();
            let is_lit = points.filter(|point| point.dot(normal) > 0.0).count() > 0;
            lit += usize::from(is_lit);
            let expected = if is_lit { 2.5 } else { 0.0 };
            assert!((mean[0] - expected).abs() < 1e-5, "{texel}: {mean:?}");
        }
        assert!((192..240).contains(&lit), "{lit}");
    }
}
