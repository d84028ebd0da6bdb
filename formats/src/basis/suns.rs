//! The suns of an environment map: its few small bright clusters, told apart from the rest of it.
//!
//! A wavelet basis needs hundreds of terms for a light of one texel and still blurs the edge of its shadow; a shadow map needs
//! neither. So a map is split: what a cluster sends above its surroundings is a [`Sun`], a disc of even radiance, and the *rest* is the map without
//! that. Both together send what the map sends: the irradiance of a surface that faces a sun changes by rounding only.
//!
//! A map is the function of direction that [`EquirectMap::sample`] makes of its texels, linear between their centres; integrals over it are closed
//! forms. Of the excess E over the surroundings, ∫E dω and the vector ∫E·ω dω tell all of a sun: its direction is the vector's, its irradiance the
//! vector's length, and its size that of the even disc whose two integrals are in the same ratio, (1 + cos radius)/2.

use super::EquirectMap;
use crate::state::Rgb;
use glam::{DVec3, Vec3};
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

/// Most suns of a map. Each takes a shadow map.
pub const MAX_SUNS: usize = 4;
/// Largest radius of a sun, degrees: a larger light's shadows are soft enough for wavelets.
pub const MAX_RADIUS_DEG: f64 = 3.25;
/// Least share of the map's light that is worth a shadow map. Smaller ones cost wavelets no more than what is
/// left of the map does.
const LEAST_SHARE: f64 = 0.03;
/// Texels belong to the core of a cluster down to this part of its peak, both above the surroundings.
const CORE: f32 = 0.4;
/// What a cluster sends is looked for to this many times as far from its centre as its core reaches.
const HALO: f64 = 1.5;
/// Most clusters that are looked at, the brightest first.
const MAX_CLUSTERS: usize = 32;

/// A small light, infinitely far away: a disc of even radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards its centre, in the map's own frame: unturned.
    pub direction: Vec3,
    /// Angular radius, radians.
    pub radius: f32,
    /// Irradiance of a surface that faces it, W/m².
    pub irradiance: Rgb,
}

/// A map as suns and the rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Split<'a> {
    /// The map without what its suns send; without suns the map itself.
    pub rest: Cow<'a, EquirectMap>,
    /// At most [`MAX_SUNS`], the strongest first.
    pub suns: Vec<Sun>,
}

/// Splits `map`. The same map gives the same suns, bit for bit.
pub fn split(map: &EquirectMap) -> Split<'_> {
    let grid = Grid::new(map);
    let clusters = grid.clusters();
    let mut found = grid.suns(&clusters);
    found.retain(|(_, sun)| grid.is_worth_it(sun));
    found.sort_by(|(_, a), (_, b)| b.sum.total_cmp(&a.sum));
    found.truncate(MAX_SUNS);
    if found.is_empty() {
        return Split { rest: Cow::Borrowed(map), suns: Vec::new() };
    }
    // What lay between a sun and a cluster that is none belongs to the sun.
    let clusters: Vec<Cluster> = found.iter().map(|(cluster, _)| *cluster).collect();
    let mut rest = map.clone();
    let suns = grid.suns(&clusters).into_iter().map(|(_, excess)| {
        excess.levels.iter().for_each(|(texel, level)| rest.texels[*texel] = *level);
        excess.sun()
    });
    let suns = suns.collect();
    Split { rest: Cow::Owned(rest), suns }
}

/// A map and the integrals of the functions that are 1 at the centre of one texel and 0 at all others.
struct Grid<'a> {
    map: &'a EquirectMap,
    width: usize,
    height: usize,
    /// By texel: the sum of its channels.
    brightness: Vec<f32>,
    /// By row: ∫dω, and ∫ω dω along Y and away from it.
    rows: Vec<[f64; 3]>,
    /// By column: the unit vector away from Y, which has no Y.
    columns: Vec<DVec3>,
    /// ∫ of the brightness over all directions.
    total: f64,
}

/// Where a sun may be.
#[derive(Debug, Clone, Copy)]
struct Cluster {
    centre: DVec3,
    /// How far from it the cluster reaches, radians.
    reach: f64,
}

/// What a texel is part of, as far as that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Nothing,
    /// A small core, or the foot of any.
    Small,
    /// A core that is too large for a sun.
    Large,
}

/// What a cluster sends above its surroundings.
#[derive(Default)]
struct Excess {
    /// ∫ of its brightness.
    sum: f64,
    /// ∫ of each channel times direction.
    vectors: [DVec3; 3],
    /// What is left of its texels.
    levels: Vec<(usize, Rgb)>,
}

impl Excess {
    fn vector(&self) -> DVec3 {
        self.vectors.iter().sum()
    }

    fn radius(&self) -> f64 {
        (2.0 * self.vector().length() / self.sum - 1.0).clamp(-1.0, 1.0).acos()
    }

    fn sun(&self) -> Sun {
        let direction = self.vector().normalize();
        Sun {
            direction: direction.as_vec3(),
            radius: self.radius() as f32,
            irradiance: self.vectors.map(|vector| vector.dot(direction) as f32),
        }
    }
}

impl<'a> Grid<'a> {
    fn new(map: &'a EquirectMap) -> Self {
        let (width, height) = (map.width as usize, map.height as usize);
        let column = |x: usize| {
            let (sin, cos) = (TAU * ((x as f64 + 0.5) / width as f64 - 0.5)).sin_cos();
            DVec3::new(sin, 0.0, -cos)
        };
        let brightness: Vec<f32> = map.texels.iter().map(|texel| texel.iter().sum()).collect();
        let rows: Vec<[f64; 3]> = (0..height).map(|y| row_integrals(y, width, height)).collect();
        let of_row = |(row, [solid_angle, ..]): (&[f32], &[f64; 3])| {
            row.iter().map(|b| f64::from(*b)).sum::<f64>() * solid_angle
        };
        let total = brightness.chunks_exact(width.max(1)).zip(&rows).map(of_row).sum();
        Self { map, width, height, brightness, rows, columns: (0..width).map(column).collect(), total }
    }

    /// The direction of a texel's centre.
    fn direction(&self, texel: usize) -> DVec3 {
        let (sin, cos) = (PI * ((texel / self.width) as f64 + 0.5) / self.height as f64).sin_cos();
        sin * self.columns[texel % self.width] + DVec3::new(0.0, cos, 0.0)
    }

    /// ∫ω dω of a texel.
    fn vector(&self, texel: usize) -> DVec3 {
        let [_, up, away] = self.rows[texel / self.width];
        away * self.columns[texel % self.width] + DVec3::new(0.0, up, 0.0)
    }

    /// The texels whose centres are within `angle` of `centre`, in their order.
    fn around(&self, centre: DVec3, angle: f64) -> impl Iterator<Item = (usize, f64)> {
        let polar = centre.y.clamp(-1.0, 1.0).acos();
        let row = |polar: f64| (polar / PI * self.height as f64).floor().max(0.0) as usize;
        let rows = row(polar - angle)..(row(polar + angle) + 1).min(self.height);
        let texels = rows.start * self.width..rows.end * self.width;
        texels
            .map(move |texel| (texel, self.direction(texel).dot(centre)))
            .filter(move |(_, dot)| *dot >= angle.cos())
    }

    /// Angle between the centres of neighbours, at most.
    fn step(&self) -> f64 {
        (PI / self.height as f64).max(TAU / self.width as f64)
    }

    /// Clusters that may be suns, the brightest first.
    fn clusters(&self) -> Vec<Cluster> {
        let cap = TAU * (1.0 - MAX_RADIUS_DEG.to_radians().cos());
        let least = (LEAST_SHARE * self.total / cap) as f32;
        let mut seeds: Vec<usize> =
            (0..self.brightness.len()).filter(|t| self.brightness[*t] > least).collect();
        seeds.sort_by(|a, b| self.brightness[*b].total_cmp(&self.brightness[*a]));
        let mut parts = vec![Part::Nothing; self.brightness.len()];
        let mut clusters = Vec::new();
        for seed in seeds {
            if parts[seed] == Part::Nothing && clusters.len() < MAX_CLUSTERS {
                clusters.extend(self.cluster(seed, &mut parts));
            }
        }
        // Beside a large light there are only pieces of it.
        let is_alone =
            |c: &Cluster| self.around(c.centre, c.reach).all(|(texel, _)| parts[texel] != Part::Large);
        clusters.retain(is_alone);
        clusters
    }

    /// Takes the core around the peak `seed`; the cluster if it is small and no foot of one taken before.
    fn cluster(&self, seed: usize, parts: &mut [Part]) -> Option<Cluster> {
        let largest = MAX_RADIUS_DEG.to_radians();
        let peak = self.brightness[seed];
        let level = self.level(self.ring(self.direction(seed), HALO * largest))?.iter().sum::<f32>();
        let floor = level + CORE * (peak - level);
        let (mut core, mut next, mut foot_of) = (vec![seed], 0, None);
        parts[seed] = Part::Small;
        while let Some(texel) = core.get(next).copied() {
            next += 1;
            for neighbour in self.neighbours(texel) {
                if self.brightness[neighbour] > peak {
                    foot_of = foot_of.max(Some(parts[neighbour]));
                }
                if self.brightness[neighbour] >= floor && parts[neighbour] == Part::Nothing {
                    parts[neighbour] = Part::Small;
                    core.push(neighbour);
                }
            }
        }
        let sum: DVec3 = core.iter().map(|t| f64::from(self.brightness[*t]) * self.vector(*t)).sum();
        let centre = sum.normalize();
        let farthest = core.iter().map(|t| self.direction(*t).dot(centre)).fold(1.0, f64::min).acos();
        let is_large = foot_of.map_or(farthest > largest, |part| part == Part::Large);
        if is_large {
            core.iter().for_each(|texel| parts[*texel] = Part::Large);
        }
        let reach = HALO * (farthest + self.step());
        (!is_large && foot_of.is_none()).then_some(Cluster { centre, reach })
    }

    /// The texels around one, which meet at the poles as all others do.
    fn neighbours(&self, texel: usize) -> impl Iterator<Item = usize> {
        let (width, height) = (self.width as isize, self.height as isize);
        let (x, y) = ((texel % self.width) as isize, (texel / self.width) as isize);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).filter(|step| *step != (0, 0));
        around.map(move |(dx, dy)| {
            // Beyond a pole the map goes on half way round.
            let (beyond, turn) = match y + dy {
                -1 => (0, width / 2),
                row if row == height => (height - 1, width / 2),
                row => (row, 0),
            };
            (beyond * width + (x + dx + turn).rem_euclid(width)) as usize
        })
    }

    /// The texels from `reach` around `centre` to as far again.
    fn ring(&self, centre: DVec3, reach: f64) -> impl Iterator<Item = usize> {
        let beside = reach.cos();
        self.around(centre, 2.0 * reach).filter(move |(_, dot)| *dot < beside).map(|(texel, _)| texel)
    }

    /// The median of each channel of some texels; `None` if there are none.
    fn level(&self, texels: impl Iterator<Item = usize>) -> Option<Rgb> {
        let texels: Vec<Rgb> = texels.map(|texel| self.map.texels[texel]).collect();
        let median = |channel: usize| {
            let mut values: Vec<f32> = texels.iter().map(|texel| texel[channel]).collect();
            values.sort_by(f32::total_cmp);
            values.get(values.len().saturating_sub(1) / 2).copied()
        };
        Some([median(0)?, median(1)?, median(2)?])
    }

    /// What is above the surroundings in each of `clusters`, a texel with the nearest one. Those without
    /// surroundings are left out.
    fn suns(&self, clusters: &[Cluster]) -> Vec<(Cluster, Excess)> {
        let holds = |cluster: &Cluster, dot: f64| dot >= cluster.reach.cos();
        let of = |(which, cluster): (usize, &Cluster)| {
            let is_beside = |texel: &usize| {
                let direction = self.direction(*texel);
                !clusters.iter().any(|other| holds(other, other.centre.dot(direction)))
            };
            let level = self.level(self.ring(cluster.centre, cluster.reach).filter(is_beside))?;
            let mut excess = Excess::default();
            for (texel, dot) in self.around(cluster.centre, cluster.reach) {
                let direction = self.direction(texel);
                // Of two that are as near the first has it.
                let is_nearer = |(other, at): (usize, &Cluster)| {
                    let theirs = at.centre.dot(direction);
                    holds(at, theirs) && (theirs > dot || (theirs == dot && other < which))
                };
                if !clusters.iter().enumerate().any(is_nearer) {
                    self.take(texel, level, &mut excess);
                }
            }
            Some((*cluster, excess))
        };
        clusters.iter().enumerate().filter_map(of).collect()
    }

    fn take(&self, texel: usize, level: Rgb, excess: &mut Excess) {
        let value = self.map.texels[texel];
        let rest: Rgb = std::array::from_fn(|c| value[c].min(level[c]));
        let above: [f64; 3] = std::array::from_fn(|c| f64::from(value[c]) - f64::from(rest[c]));
        let vector = self.vector(texel);
        excess.sum += above.iter().sum::<f64>() * self.rows[texel / self.width][0];
        (0..3).for_each(|c| excess.vectors[c] += above[c] * vector);
        if rest != value {
            excess.levels.push((texel, rest));
        }
    }

    fn is_worth_it(&self, excess: &Excess) -> bool {
        excess.sum > LEAST_SHARE * self.total && excess.radius() <= MAX_RADIUS_DEG.to_radians()
    }
}

/// For a texel of row `y`: ∫dω, ∫ω dω along Y, and away from it, of the function that is 1 at its centre and falls to 0 at its neighbours'; beyond the
/// centres of the first and last row it stays.
fn row_integrals(y: usize, width: usize, height: usize) -> [f64; 3] {
    let step = PI / height as f64;
    let (angle, column) = ((y as f64 + 0.5) * step, TAU / width as f64);
    // Each function of the polar angle with its first two antiderivatives.
    let sin: [fn(f64) -> f64; 2] = [|t| -t.cos(), |t| -t.sin()];
    let sin_cos: [fn(f64) -> f64; 2] = [|t| -(2.0 * t).cos() / 4.0, |t| -(2.0 * t).sin() / 8.0];
    let sin_sin: [fn(f64) -> f64; 2] =
        [|t| t / 2.0 - (2.0 * t).sin() / 4.0, |t| t * t / 4.0 + (2.0 * t).cos() / 8.0];
    let integral = |[once, twice]: [fn(f64) -> f64; 2]| {
        let above = if y == 0 { once(0.0) } else { (twice(angle) - twice(angle - step)) / step };
        let below = if y + 1 == height { once(PI) } else { (twice(angle + step) - twice(angle)) / step };
        below - above
    };
    // Away from Y the function's fall to both sides takes from the vector's length.
    let shortened = 2.0 * (1.0 - column.cos()) / (column * column);
    [integral(sin) * column, integral(sin_cos) * column, integral(sin_sin) * column * shortened]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [512, 256];

    /// A smooth sky with even discs of (direction, radius in degrees, radiance) on it, each texel the mean over 8 × 8 directions.
    fn sky(discs: &[(Vec3, f64, Rgb)]) -> EquirectMap {
        let [width, height] = SIZE;
        let points = 8;
        let texel = |i: u32| {
            let mut sum = [0.0; 3];
            for k in 0..points * points {
                let at =
                    |texel: u32, part: u32| f64::from(texel) + (f64::from(part) + 0.5) / f64::from(points);
                let (u, v) = (at(i % width, k % points), at(i / width, k / points));
                let (azimuth, polar) = (TAU * (u / f64::from(width) - 0.5), PI * v / f64::from(height));
                let direction =
                    DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
                for (c, sum) in sum.iter_mut().enumerate() {
                    *sum += 0.5 + 0.2 * direction.y + 0.1 * c as f64;
                    for (towards, radius_deg, radiance) in discs {
                        if direction.dot(towards.as_dvec3()) > radius_deg.to_radians().cos() {
                            *sum += f64::from(radiance[c]);
                        }
                    }
                }
            }
            sum.map(|sum| (sum / f64::from(points * points)) as f32)
        };
        EquirectMap { width, height, texels: (0..width * height).map(texel).collect() }
    }

    fn towards(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
        let ((sin_a, cos_a), (sin_e, cos_e)) =
            (azimuth_deg.to_radians().sin_cos(), elevation_deg.to_radians().sin_cos());
        Vec3::new(cos_e * sin_a, sin_e, -cos_e * cos_a)
    }

    /// ∫L·ω dω of each channel, by adding up the map at four by four points a texel.
    fn vectors(map: &EquirectMap) -> [DVec3; 3] {
        let mut sums = [DVec3::ZERO; 3];
        let (columns, rows) = (4 * map.width, 4 * map.height);
        // Two points of Gauss in each half of a texel, for there interpolation is smooth.
        let point = |k: u32| f64::from(k / 2) + 0.5 + (f64::from(k % 2) - 0.5) / 3.0f64.sqrt();
        for y in 0..rows {
            let polar = PI * 2.0 * point(y) / f64::from(rows);
            let weight = polar.sin() * PI / f64::from(rows) * TAU / f64::from(columns);
            for x in 0..columns {
                let (u, v) = (2.0 * point(x) / f64::from(columns), polar / PI);
                let azimuth = TAU * (u - 0.5);
                let direction =
                    DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
                let radiance = map.sample([u as f32, v as f32]);
                (0..3).for_each(|c| sums[c] += weight * f64::from(radiance[c]) * direction);
            }
        }
        sums
    }

    /// What is known of a disc: irradiance of a surface that faces it is radiance times π sin²; the size that is
    /// found is larger by what texels blur.
    #[track_caller]
    fn expect_disc(sun: &Sun, (direction, radius_deg, radiance): (Vec3, f64, Rgb)) {
        // A tenth of a texel.
        assert!(sun.direction.dot(direction) > 0.07_f32.to_radians().cos(), "{sun:?} {direction}");
        for (radiance, irradiance) in radiance.into_iter().zip(sun.irradiance) {
            let expected = f64::from(radiance) * PI * radius_deg.to_radians().sin().powi(2);
            let found = f64::from(irradiance) / expected;
            // A disc of 1° is known by some 80 points of its texels, as far as these are concerned.
            assert!((found - 1.0).abs() < 0.02, "{found} of the irradiance");
        }
        let size = f64::from(sun.radius).to_degrees();
        let narrow = f64::from(direction.x.hypot(direction.z));
        let expected = radius_deg.hypot(STEP_DEG * (0.5 + 0.5 * narrow * narrow).sqrt());
        assert!((size / expected - 1.0).abs() < 0.05, "radius {size}, expected {expected}");
    }

    /// Height of a texel. The variance of its box and of the tent between centres is 1/12 + 1/6 of its square, and that
    /// of a disc along an axis a quarter of its radius squared: so it blurs like a disc of as large a radius, less
    /// along rows where these are narrow.
    const STEP_DEG: f64 = 180.0 / 256.0;

    #[test]
    fn discs_are_found_as_they_are_wherever_they_stand() {
        // In the middle, where the map's ends meet, at the horizon, below, towards an edge of a cube, and at the pole.
        let places = [(0.0, 30.0), (180.0, 42.0), (-60.0, 0.0), (20.0, -50.0), (45.0, 20.0), (0.0, 89.9)];
        for (azimuth, elevation) in places {
            let disc = (towards(azimuth, elevation), 1.0, [900.0, 700.0, 400.0]);
            let map = sky(&[disc]);
            let Split { rest, suns } = split(&map);
            assert_eq!(suns.len(), 1, "{azimuth} {elevation}");
            // Around a pole a map of rows cannot show a disc as it is.
            if elevation < 80.0 {
                expect_disc(&suns[0], disc);
            }
            assert!(rest.texels.iter().flatten().all(|value| (0.0..1.0).contains(value)));
            // Both together are the map, for surfaces that face the sun, and to a part of its size for others.
            for (c, (whole, left)) in vectors(&map).into_iter().zip(vectors(&rest)).enumerate() {
                let direction = suns[0].direction.as_dvec3();
                let (irradiance, off) = (f64::from(suns[0].irradiance[c]), whole - left);
                assert!((off.dot(direction) / irradiance - 1.0).abs() < 1e-3, "{off} {irradiance}");
                assert!((off - irradiance * direction).length() < 3e-3 * irradiance);
            }
        }
    }

    #[test]
    fn a_sun_of_one_texel_is_as_large_as_what_is_interpolated() {
        let mut map = sky(&[]);
        let texel = 60 * 512 + 300;
        map.texels[texel] = [2e4, 1e4, 5e3];
        let grid = Grid::new(&map);
        let direction = grid.direction(texel);
        let Split { rest, suns } = split(&map);
        assert_eq!(suns.len(), 1);
        assert!(suns[0].direction.as_dvec3().dot(direction) > 1.0 - 1e-6);
        // A pyramid: the mean square of its distance is that of a disc of √(4/3) half its base along the meridian,
        // and as far as it is narrower less along the other axis.
        let (step, narrow) = (STEP_DEG, direction.x.hypot(direction.z));
        let expected = ((1.0 + narrow * narrow) / 3.0_f64).sqrt() * step;
        let size = f64::from(suns[0].radius).to_degrees();
        assert!((size / expected - 1.0).abs() < 0.01, "{size} {expected}");
        let solid_angle = step.to_radians().powi(2) * narrow;
        let expected = 2e4 * solid_angle;
        assert!((f64::from(suns[0].irradiance[0]) / expected - 1.0).abs() < 1e-3);
        assert!(rest.texels.iter().zip(&map.texels).filter(|(a, b)| a != b).count() < 60);
    }

    #[test]
    fn two_suns_are_two_the_stronger_first() {
        let (near, far) = ((towards(30.0, 40.0), 0.9, [800.0; 3]), (towards(35.2, 40.0), 0.9, [500.0; 3]));
        let opposite = (towards(-120.0, 10.0), 1.2, [600.0; 3]);
        let map = sky(&[near, far, opposite]);
        let Split { suns, .. } = split(&map);
        assert_eq!(suns.len(), 3, "{suns:?}");
        expect_disc(&suns[0], opposite);
        expect_disc(&suns[1], near);
        expect_disc(&suns[2], far);
        let many: Vec<_> =
            (0..6).map(|k| (towards(60.0 * k as f32, 30.0), 1.0, [500.0 + 50.0 * k as f32; 3])).collect();
        assert_eq!(split(&sky(&many)).suns.len(), MAX_SUNS);
        assert_eq!(split(&map), split(&map.clone()));
    }

    #[test]
    fn what_is_no_sun_costs_nothing() {
        let large = sky(&[(towards(30.0, 40.0), 4.0, [400.0; 3])]);
        let faint = sky(&[(towards(30.0, 40.0), 0.8, [100.0; 3])]);
        let even = EquirectMap { width: 8, height: 4, texels: vec![[1.0; 3]; 32] };
        let black = EquirectMap { width: 8, height: 4, texels: vec![[0.0; 3]; 32] };
        let one = EquirectMap { width: 1, height: 1, texels: vec![[3.0; 3]] };
        // Too coarse for a sun: a texel measures 22°.
        let mut coarse = EquirectMap { width: 16, height: 8, texels: vec![[1.0; 3]; 128] };
        coarse.texels[40] = [1e6; 3];
        let mut bar = sky(&[]);
        (200..300).for_each(|x| bar.texels[90 * 512 + x] = [900.0; 3]);
        for map in [large, faint, even, black, one, coarse, bar] {
            let Split { rest, suns } = split(&map);
            assert!(suns.is_empty() && matches!(rest, Cow::Borrowed(_)), "{suns:?}");
        }
    }

    #[test]
    fn the_integrals_of_all_texels_are_those_of_the_sphere() {
        for (width, height) in [(1, 1), (7, 2), (64, 32), (512, 256)] {
            let rows: Vec<_> = (0..height).map(|y| row_integrals(y, width, height)).collect();
            let sum = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() * width as f64;
            assert!((sum(0) / (4.0 * PI) - 1.0).abs() < 1e-9 && sum(1).abs() < 1e-9);
            // ∫ sin² dθ = π/2, and columns take turns.
            let column = TAU / width as f64;
            let shortened = 2.0 * (1.0 - column.cos()) / (column * column);
            assert!((sum(2) / (PI * PI * shortened) - 1.0).abs() < 1e-9 || shortened < 1e-9);
        }
    }
}
