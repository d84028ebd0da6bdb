//! Sampling of an environment map in proportion to what it sends, and to what of it arrives.
//!
//! The map is cut into patches. Which of them is looked at is for the caller to say ([`PatchChances`]): a
//! room sees a map through its windows alone. Within a patch, directions are chosen by brightness.

use super::chances::{pick, running_share, share};
use glam::Vec3A;
use relume_scenes::{Environment, EquirectMap};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::ops::Range;

/// Most bands of latitude that a map is cut into, and most columns.
const PATCHES: [usize; 2] = [8, 16];

/// An environment light prepared for look-ups and importance sampling.
pub struct EnvironmentLight {
    width: usize,
    height: usize,
    /// Bands of latitude, and columns.
    patches: [usize; 2],
    /// The map with its gain.
    map: EquirectMap,
    /// Cosine and sine of the map's rotation about +Y.
    rotation: [f32; 2],
    /// For each column of patches and each row of texels: running sums of the chance to be chosen within the
    /// patch.
    row_cdf: Vec<f32>,
    /// Running sums over the texels of each row within each patch; each ends in 1.
    texel_cdf: Vec<f32>,
    /// The part of all brightness that is in each patch, column by column within bands.
    brightness: Vec<f64>,
}

/// With what chance each patch of a map is looked at.
#[derive(Debug, Clone)]
pub struct PatchChances {
    /// Running sums over bands.
    bands: Vec<f32>,
    /// Running sums over the patches of each band.
    columns: Vec<f32>,
}

impl PatchChances {
    /// In proportion to `weights`, band by band, of which there are `bands`.
    pub fn new(weights: &[f64], bands: usize) -> Self {
        let columns = weights.len() / bands;
        let of_bands: Vec<f64> = weights.chunks(columns).map(|band| band.iter().sum()).collect();
        Self {
            bands: running_share(&of_bands),
            columns: weights.chunks(columns).flat_map(running_share).collect(),
        }
    }

    fn columns_of(&self, band: usize) -> &[f32] {
        let columns = self.columns.len() / self.bands.len();
        &self.columns[band * columns..(band + 1) * columns]
    }

    fn of(&self, band: usize, column: usize) -> f32 {
        share(&self.bands, band) * share(self.columns_of(band), column)
    }
}

impl EnvironmentLight {
    /// Prepares `environment`; `None` if it is black.
    pub fn new(environment: &Environment) -> Option<Self> {
        let map = &environment.map.map;
        let (width, height) = (map.width as usize, map.height as usize);
        let gain = Vec3A::from(environment.gain);
        let texels: Vec<[f32; 3]> = map.texels.iter().map(|t| (Vec3A::from(*t) * gain).to_array()).collect();
        let map = EquirectMap { texels, ..**map };
        let rows = weights_of_rows(&map);
        let patches = [PATCHES[0].min(height), PATCHES[1].min(width)];
        let mut row_cdf = vec![0.0; patches[1] * height];
        let mut brightness = vec![0.0; patches[0] * patches[1]];
        for (patch, total) in brightness.iter_mut().enumerate() {
            let (band, column) = (patch / patches[1], patch % patches[1]);
            let (rows_of, columns) = (part(height, patches[0], band), part(width, patches[1], column));
            let weight = |y: usize| rows[y][columns.clone()].iter().sum::<f64>() * band_of_row(y, height);
            let weights: Vec<f64> = rows_of.clone().map(weight).collect();
            *total = weights.iter().sum();
            let cdf = &mut row_cdf[column * height..(column + 1) * height];
            cdf[rows_of].copy_from_slice(&running_share(&weights));
        }
        let columns = |row: &Vec<f64>| -> Vec<f32> {
            (0..patches[1]).flat_map(|column| running_share(&row[part(width, patches[1], column)])).collect()
        };
        let texel_cdf = rows.iter().flat_map(columns).collect();
        let lit = brightness.iter().sum::<f64>() > 0.0;
        let (sin, cos) = environment.rotation_deg.to_radians().sin_cos();
        lit.then_some(Self {
            width,
            height,
            patches,
            map,
            rotation: [cos, sin],
            row_cdf,
            texel_cdf,
            brightness,
        })
    }

    /// Bands of latitude and columns of patches.
    pub fn patches(&self) -> [usize; 2] {
        self.patches
    }

    /// For each patch, band by band: its part of all that the map sends.
    pub fn brightness_of_patches(&self) -> Vec<f64> {
        let total: f64 = self.brightness.iter().sum();
        self.brightness.iter().map(|b| b / total).collect()
    }

    /// Number of the patch that `direction` lies in.
    pub fn patch_of(&self, direction: Vec3A) -> usize {
        let [x, y] = self.texel(direction);
        let [band, column] = self.patch_of_texel(x, y);
        band * self.patches[1] + column
    }

    /// Radiance from the unit direction `direction`, bilinear between texel centres, W/(sr·m²).
    pub fn radiance(&self, direction: Vec3A) -> Vec3A {
        self.map.sample(self.uv(direction)).into()
    }

    /// A direction chosen by its patch's chance and, within the patch, in proportion to brightness, with its
    /// density per steradian.
    pub fn sample(&self, chances: &PatchChances, [u, v]: [f32; 2]) -> (Vec3A, f32) {
        // What chose a patch is evenly spread within its share and serves again.
        let (band, v) = pick(&chances.bands, v);
        let (column, u) = pick(chances.columns_of(band), u);
        let rows = part(self.height, self.patches[0], band);
        let (y, fy) = pick(&self.rows_of(column)[rows.clone()], v);
        let y = rows.start + y;
        let columns = part(self.width, self.patches[1], column);
        let (x, fx) = pick(&self.texels_of(y)[columns.clone()], u);
        let x = columns.start + x;
        let phi = TAU * ((x as f32 + fx) / self.width as f32 - 0.5);
        // Even over the solid angle within a row: linear in the cosine of the polar angle.
        let top = (PI * y as f32 / self.height as f32).cos();
        let bottom = (PI * (y + 1) as f32 / self.height as f32).cos();
        let cos_theta = top + (bottom - top) * fy;
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let in_map = Vec3A::new(sin_theta * phi.sin(), cos_theta, -sin_theta * phi.cos());
        (self.turn(in_map, 1.0), self.texel_density(chances, x, y))
    }

    /// Density per steradian with which [`EnvironmentLight::sample`] chooses `direction`.
    pub fn density(&self, chances: &PatchChances, direction: Vec3A) -> f32 {
        let [x, y] = self.texel(direction);
        self.texel_density(chances, x, y)
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

    fn texel_density(&self, chances: &PatchChances, x: usize, y: usize) -> f32 {
        let [band, column] = self.patch_of_texel(x, y);
        let (rows, columns) =
            (part(self.height, self.patches[0], band), part(self.width, self.patches[1], column));
        let of_row = share(&self.rows_of(column)[rows.clone()], y - rows.start);
        let of_texel = share(&self.texels_of(y)[columns.clone()], x - columns.start);
        let chance = chances.of(band, column) * of_row * of_texel;
        chance * self.width as f32 / (TAU * band_of_row(y, self.height) as f32)
    }

    fn rows_of(&self, column: usize) -> &[f32] {
        &self.row_cdf[column * self.height..(column + 1) * self.height]
    }

    fn texels_of(&self, y: usize) -> &[f32] {
        &self.texel_cdf[y * self.width..(y + 1) * self.width]
    }

    fn texel(&self, direction: Vec3A) -> [usize; 2] {
        let [u, v] = self.uv(direction);
        [
            ((u * self.width as f32) as usize).min(self.width - 1),
            ((v * self.height as f32) as usize).min(self.height - 1),
        ]
    }

    /// Band and column of the patch that a texel lies in.
    fn patch_of_texel(&self, x: usize, y: usize) -> [usize; 2] {
        // The inverse of `part`.
        let of = |at: usize, whole: usize, parts: usize| ((at + 1) * parts - 1) / whole;
        [of(y, self.height, self.patches[0]), of(x, self.width, self.patches[1])]
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

/// The weight of every texel, row by row.
fn weights_of_rows(map: &EquirectMap) -> Vec<Vec<f64>> {
    let (width, height) = (map.width as usize, map.height as usize);
    let brightness: Vec<f64> = map.texels.iter().map(|t| f64::from(Vec3A::from(*t).element_sum())).collect();
    // Look-ups interpolate, so a dark texel beside a bright one shines too and must stand a chance.
    let blurred = |x: usize, y: usize| -> f64 {
        let columns = [(x + width - 1) % width, x, (x + 1) % width];
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        rows.iter().flat_map(|r| columns.iter().map(move |c| r * width + c)).map(|i| brightness[i]).sum()
    };
    (0..height).map(|y| (0..width).map(|x| blurred(x, y)).collect()).collect()
}

/// Part number `index` of `parts` of 0..whole.
fn part(whole: usize, parts: usize, index: usize) -> Range<usize> {
    index * whole / parts..(index + 1) * whole / parts
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

    /// By brightness, and by chances that have nothing to do with it.
    #[test]
    fn density_is_that_of_the_samples() {
        // A sun among the texels of a row takes nothing from patches beside it.
        let mut sun = vec![[1.0; 3]; 64 * 8];
        sun[64 * 3 + 20] = [1e8; 3];
        let sun = light(64, 8, sun, 0.0);
        let even = vec![1.0; sun.brightness.len()];
        expect_density(&sun, &PatchChances::new(&even, sun.patches()[0]), false);
        let light = patchy(33.0);
        let by_brightness = light.brightness_of_patches();
        let other: Vec<f64> = (1..=by_brightness.len()).map(|patch| (patch * 31 % 17) as f64 + 0.5).collect();
        for weights in [by_brightness, other] {
            expect_density(&light, &PatchChances::new(&weights, light.patches()[0]), true);
        }
    }

    /// Sampling and density agree, and, where `all` directions stand a chance, the density integrates to 1:
    /// E[f/p] for known f.
    fn expect_density(light: &EnvironmentLight, chances: &PatchChances, all: bool) {
        let sampler = crate::trace::sampler::PixelSampler::new(5, 0);
        let n = 1 << 20;
        let mut disagreeing = 0;
        let (mut area, mut first_moment, mut lit) = (0.0f64, glam::DVec3::ZERO, 0.0f64);
        for i in 0..n {
            let (d, p) = light.sample(chances, sampler.sample(i).pair(0));
            assert!((d.length() - 1.0).abs() < 1e-5);
            disagreeing += u32::from((light.density(chances, d) / p - 1.0).abs() > 1e-3);
            area += 1.0 / f64::from(p);
            first_moment += (d / p).as_dvec3();
            lit += f64::from(light.radiance(d).x / p);
        }
        // A direction on the very border of a texel may round into the next.
        assert!(disagreeing < n / 10_000, "{disagreeing} densities differ");
        if !all {
            return;
        }
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

    /// Whatever divides into whatever: every texel lies in the patch that it is counted to.
    #[test]
    fn texels_lie_in_their_patches() {
        for (width, height) in [(8, 4), (64, 32), (37, 19), (1, 1), (16, 9)] {
            let light = light(width, height, vec![[1.0; 3]; (width * height) as usize], 0.0);
            let [bands, columns] = light.patches();
            for (band, column) in (0..bands).flat_map(|b| (0..columns).map(move |c| (b, c))) {
                for (y, x) in part(height as usize, bands, band)
                    .flat_map(|y| part(width as usize, columns, column).map(move |x| (y, x)))
                {
                    assert_eq!(light.patch_of_texel(x, y), [band, column], "{width} {height}");
                }
            }
            assert!((light.brightness_of_patches().iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
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
