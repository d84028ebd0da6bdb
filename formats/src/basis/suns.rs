//! The suns of an environment map: its few small bright clusters, told apart from the rest of it.
//!
//! A wavelet basis needs hundreds of terms for a light of one texel and still blurs the edge of its shadow; a
//! shadow map needs neither. So a map is split: what a cluster sends above its surroundings is a [`Sun`], a disc
//! of even radiance, and the *rest* is the map without that. Both together send what the map sends: the irradiance
//! of a surface that faces a sun changes by rounding only.
//!
//! A map is the function of direction that [`EquirectMap::sample`] makes of its texels, linear between their
//! centres; integrals over it are closed forms. Of the excess E over the surroundings, ∫E dω and the vector ∫E·ω
//! dω tell all of a sun: its direction is the vector's, its irradiance the vector's length, and its size that of
//! the even disc whose two integrals are in the same ratio, (1 + cos radius)/2.

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

/// For a texel of row `y`: ∫dω, ∫ω dω along Y, and away from it, of the function that is 1 at its centre and falls
/// to 0 at its neighbours'; beyond the centres of the first and last row it stays.
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
mod tests;
