//! Sampling of an environment map in proportion to what it sends.

use glam::Vec3A;
use relume_scenes::{Environment, EquirectMap};
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// An environment light prepared for look-ups and importance sampling.
pub struct EnvironmentLight {
    width: usize,
    height: usize,
    /// The map with its gain.
    map: EquirectMap,
    /// Cosine and sine of the map's rotation about +Y.
    rotation: [f32; 2],
    /// Running sums over rows, and over the texels of each row, of the chance to be chosen; each ends in 1.
    row_cdf: Vec<f32>,
    texel_cdf: Vec<f32>,
}

impl EnvironmentLight {
    /// Prepares `environment`; `None` if it is black.
    pub fn new(environment: &Environment) -> Option<Self> {
        let map = &environment.map.map;
        let (width, height) = (map.width as usize, map.height as usize);
        let gain = Vec3A::from(environment.gain);
        let texels: Vec<[f32; 3]> = map.texels.iter().map(|t| (Vec3A::from(*t) * gain).to_array()).collect();
        let brightness: Vec<f64> = texels.iter().map(|t| f64::from(Vec3A::from(*t).element_sum())).collect();
        let map = EquirectMap { texels, ..**map };
        let mut row_sums = Vec::with_capacity(height);
        let mut texel_cdf = Vec::with_capacity(brightness.len());
        for y in 0..height {
            // Look-ups interpolate, so a dark texel beside a bright one shines too and must stand a chance.
            let blurred = |x: usize| -> f64 {
                let columns = [(x + width - 1) % width, x, (x + 1) % width];
                let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
                rows.iter()
                    .flat_map(|r| columns.iter().map(move |c| r * width + c))
                    .map(|i| brightness[i])
                    .sum()
            };
            let row: Vec<f64> = (0..width).map(blurred).collect();
            row_sums.push(row.iter().sum::<f64>() * band_of_row(y, height));
            texel_cdf.extend(running_share(&row));
        }
        let lit = row_sums.iter().sum::<f64>() > 0.0;
        let (sin, cos) = environment.rotation_deg.to_radians().sin_cos();
        lit.then(|| Self {
            width,
            height,
            map,
            rotation: [cos, sin],
            row_cdf: running_share(&row_sums),
            texel_cdf,
        })
    }

    /// Radiance from the unit direction `direction`, bilinear between texel centres, W/(sr·m²).
    pub fn radiance(&self, direction: Vec3A) -> Vec3A {
        self.map.sample(self.uv(direction)).into()
    }

    /// A direction chosen in proportion to brightness, with its density per steradian.
    pub fn sample(&self, [u, v]: [f32; 2]) -> (Vec3A, f32) {
        let (y, fy) = pick(&self.row_cdf, v);
        let (x, fx) = pick(&self.texel_cdf[y * self.width..(y + 1) * self.width], u);
        let phi = TAU * ((x as f32 + fx) / self.width as f32 - 0.5);
        // Even over the solid angle within a row: linear in the cosine of the polar angle.
        let top = (PI * y as f32 / self.height as f32).cos();
        let bottom = (PI * (y + 1) as f32 / self.height as f32).cos();
        let cos_theta = top + (bottom - top) * fy;
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let in_map = Vec3A::new(sin_theta * phi.sin(), cos_theta, -sin_theta * phi.cos());
        (self.turn(in_map, 1.0), self.texel_density(x, y))
    }

    /// Density per steradian with which [`EnvironmentLight::sample`] chooses `direction`.
    pub fn density(&self, direction: Vec3A) -> f32 {
        let [u, v] = self.uv(direction);
        let x = ((u * self.width as f32) as usize).min(self.width - 1);
        let y = ((v * self.height as f32) as usize).min(self.height - 1);
        self.texel_density(x, y)
    }

    /// Irradiance on an absorbing sphere per cross section, Σ L·dω of the largest channel: what power is
    /// compared by.
    pub fn total(&self) -> f32 {
        let solid_angle =
            |i: usize| band_of_row(i / self.width, self.height) * std::f64::consts::TAU / self.width as f64;
        self.map
            .texels
            .iter()
            .enumerate()
            .map(|(i, t)| f64::from(Vec3A::from(*t).max_element()) * solid_angle(i))
            .sum::<f64>() as f32
    }

    fn texel_density(&self, x: usize, y: usize) -> f32 {
        let chance =
            share(&self.row_cdf, y) * share(&self.texel_cdf[y * self.width..(y + 1) * self.width], x);
        chance * self.width as f32 / (TAU * band_of_row(y, self.height) as f32)
    }

    /// Texture coordinates of a direction in world space.
    fn uv(&self, direction: Vec3A) -> [f32; 2] {
        let d = self.turn(direction, -1.0);
        [0.5 + d.x.atan2(-d.z) * (0.5 * FRAC_1_PI), d.x.hypot(d.z).atan2(d.y) * FRAC_1_PI]
    }

    /// Turns counter-clockwise seen from +Y by the map's rotation, or back.
    fn turn(&self, d: Vec3A, sign: f32) -> Vec3A {
        let [cos, sin] = [self.rotation[0], self.rotation[1] * sign];
        Vec3A::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
    }
}

/// cos θ at the top of row `y` minus cos θ at its bottom.
fn band_of_row(y: usize, height: usize) -> f64 {
    let cos = |row: usize| (std::f64::consts::PI * row as f64 / height as f64).cos();
    cos(y) - cos(y + 1)
}

fn running_share(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let mut cdf: Vec<f32> = weights
        .iter()
        .map(|w| {
            sum += w;
            (sum / total.max(f64::MIN_POSITIVE)) as f32
        })
        .collect();
    if let Some(last) = cdf.last_mut() {
        *last = 1.0;
    }
    cdf
}

fn share(cdf: &[f32], index: usize) -> f32 {
    cdf[index] - if index == 0 { 0.0 } else { cdf[index - 1] }
}

/// The interval of `cdf` that `u` falls in and where within it, both ends excluded from intervals of no
/// width.
fn pick(cdf: &[f32], u: f32) -> (usize, f32) {
    let index = cdf.partition_point(|c| *c <= u).min(cdf.len() - 1);
    let start = if index == 0 { 0.0 } else { cdf[index - 1] };
    (index, ((u - start) / (cdf[index] - start)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_scenes::NamedMap;
    use std::sync::Arc;

    fn light(width: u32, height: u32, texels: Vec<[f32; 3]>, rotation_deg: f32) -> EnvironmentLight {
        let map = Arc::new(EquirectMap { width, height, texels });
        let map = NamedMap { name: "map".to_owned(), map };
        EnvironmentLight::new(&Environment { map, others: Vec::new(), gain: [1.0; 3], rotation_deg }).unwrap()
    }

    fn patchy(rotation_deg: f32) -> EnvironmentLight {
        let texels =
            (0..8 * 4).map(|i| [((i * 7919) % 13) as f32 * if i == 11 { 40.0 } else { 0.3 }; 3]).collect();
        light(8, 4, texels, rotation_deg)
    }

    /// Sampling and density agree, and the density integrates to 1: E[f/p] for known f.
    #[test]
    fn density_is_that_of_the_samples() {
        let light = patchy(33.0);
        let sampler = crate::trace::sampler::PixelSampler::new(5, 0);
        let n = 1 << 20;
        let mut disagreeing = 0;
        let (mut area, mut first_moment, mut lit) = (0.0f64, glam::DVec3::ZERO, 0.0f64);
        for i in 0..n {
            let (d, p) = light.sample(sampler.sample(i).pair(0));
            assert!((d.length() - 1.0).abs() < 1e-5);
            disagreeing += u32::from((light.density(d) / p - 1.0).abs() > 1e-3);
            area += 1.0 / f64::from(p);
            first_moment += (d / p).as_dvec3();
            lit += f64::from(light.radiance(d).x / p);
        }
        // A direction on the very border of a texel may round into the next.
        assert!(disagreeing < n / 10_000, "{disagreeing} densities differ");
        let n2 = f64::from(n);
        // Every direction stands a chance here, so ∫ 1 dω = 4π and ∫ ω dω = 0.
        assert!((area / n2 - 4.0 * std::f64::consts::PI).abs() < 0.02, "{}", area / n2);
        assert!(first_moment.length() / n2 < 0.02);
        let by_grid = grid_mean(|d| light.radiance(d).x) * 4.0 * std::f64::consts::PI;
        assert!((lit / n2 / by_grid - 1.0).abs() < 0.01, "{} against {by_grid}", lit / n2);
    }

    fn grid_mean(f: impl Fn(Vec3A) -> f32) -> f64 {
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let y = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
                let phi = TAU * (j as f32 + 0.5) / n as f32;
                let r = (1.0 - y * y).sqrt();
                sum += f64::from(f(Vec3A::new(r * phi.cos(), y, r * phi.sin())));
            }
        }
        sum / f64::from(n * n)
    }

    #[test]
    fn rotation_turns_counter_clockwise_seen_from_above() {
        // The middle column of the map looks to -Z; turned by 90° counter-clockwise seen from +Y, -Z goes to
        // -X.
        let mut texels = vec![[0.0; 3]; 8 * 3];
        texels[8 + 3] = [1.0; 3];
        texels[8 + 4] = [1.0; 3];
        assert!(light(8, 3, texels.clone(), 0.0).radiance(Vec3A::NEG_Z).x > 0.9);
        assert!(light(8, 3, texels.clone(), 90.0).radiance(Vec3A::NEG_X).x > 0.9);
        assert!(light(8, 3, texels, 90.0).radiance(Vec3A::NEG_Z).x < 0.1);
    }
}
