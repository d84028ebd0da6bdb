//! Shadows of spheres by exponentiation: Z. Ren et al., *Real-time soft shadows in dynamic scenes using spherical
//! harmonic exponentiation*, ACM TOG 25(3), 2006.
//!
//! What a sphere lets through is a zonal function; its logarithm is tabulated over the sphere's angular radius.
//! Logarithms of all spheres are turned and added, and the sum is exponentiated: that is the product of what all of
//! them let through, as far as a few bands can tell. Logarithms are those of the matrices that multiply with the
//! functions, eigenvalues below [`LEAST`] raised to it.
//!
//! The exponential is the source's hybrid: the constant part is taken out and exponentiated by itself, what is left
//! is halved until it is short, exp(f) ≈ a + b·f with a and b by the length of f, such that they are best for single
//! spheres, and squared as often as it was halved.

use super::{BAND, BANDS, COUNT, Coefficients, Product, Zonal, basis, basis_of, open_but_for_cap, turned_by};
use glam::Vec3;
use pulp::Arch;
use std::f64::consts::PI;

/// Receivers that go together, a lane each.
const LANES: usize = 16;
/// Coefficients of the functions of some receivers.
type Functions = [[f32; LANES]; COUNT];

/// Entries of tables.
const ENTRIES: usize = 1024;
/// Least eigenvalue that a logarithm is taken of.
const LEAST: f64 = 0.02;
/// The length down to which what is exponentiated is halved.
const SHORT: f32 = 0.25;
/// The coefficient of the function that is 1 everywhere.
const ONE: f64 = 3.544_907_701_811_032;

/// Tables.
pub struct Exponentiation {
    /// Logarithms of what spheres let through, ready to be turned, by the sine of half their angular radius: from 0
    /// to that of a right angle.
    logarithms: Vec<[f32; BANDS]>,
    /// a and b by the length of what is exponentiated, from 0 to [`SHORT`].
    linear: Vec<[f32; 2]>,
    product: Product,
}

impl Default for Exponentiation {
    fn default() -> Self {
        let product = Product::default();
        let angle = |entry: usize| entry as f64 / (ENTRIES - 1) as f64 * (PI / 4.0).sin();
        let open = |entry: usize| open_but_for_cap(1.0 - 2.0 * angle(entry).powi(2));
        let open: Vec<Zonal> = (0..ENTRIES).map(open).collect();
        let logarithms: Vec<Zonal> = open.iter().map(|open| logarithm(open, &product)).collect();
        let linear = linear(&open, &logarithms);
        let logarithms = logarithms.iter().map(|log| turned_by(log).map(|value| value as f32)).collect();
        Self { logarithms, linear, product }
    }
}

/// log g of a zonal function.
fn logarithm(g: &Zonal, product: &Product) -> Zonal {
    let mut whole = [0.0; COUNT];
    (0..BANDS).for_each(|band| whole[zonal(band)] = g[band] as f32);
    let matrix = product.matrix(&whole);
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(matrix[zonal(i)][zonal(j)])));
    let (values, vectors) = eigen(matrix);
    // The function that is 1 has but one coefficient.
    std::array::from_fn(|i| {
        (0..BANDS).map(|k| vectors[i][k] * values[k].max(LEAST).ln() * vectors[0][k] * ONE).sum()
    })
}

/// The index of the zonal function of a band.
fn zonal(band: usize) -> usize {
    band * band + band
}

/// Eigenvalues of a symmetric matrix, and its eigenvectors as columns: Jacobi's rotations.
fn eigen(mut matrix: [[f64; BANDS]; BANDS]) -> (Zonal, [[f64; BANDS]; BANDS]) {
    let mut vectors = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..32 {
        for p in 0..BANDS {
            for q in p + 1..BANDS {
                if matrix[p][q] != 0.0 {
                    rotate(&mut matrix, &mut vectors, p, q);
                }
            }
        }
    }
    (std::array::from_fn(|k| matrix[k][k]), vectors)
}

/// The rotation that makes the element in row `p` and column `q` 0.
fn rotate(matrix: &mut [[f64; BANDS]; BANDS], vectors: &mut [[f64; BANDS]; BANDS], p: usize, q: usize) {
    let angle = 0.5 * (2.0 * matrix[p][q]).atan2(matrix[q][q] - matrix[p][p]);
    let (sin, cos) = angle.sin_cos();
    let turn = |a: f64, b: f64| [cos * a - sin * b, sin * a + cos * b];
    for row in matrix.iter_mut().chain(vectors) {
        [row[p], row[q]] = turn(row[p], row[q]);
    }
    let (above, below) = matrix.split_at_mut(q);
    for (a, b) in above[p].iter_mut().zip(&mut below[0]) {
        [*a, *b] = turn(*a, *b);
    }
}

/// Where exp(f) of a single sphere is `open` and f its logarithm, both without their constant part: the a and b of
/// least squares, by the length of f. A length that several spheres have is that of the smallest.
fn linear(open: &[Zonal], logarithms: &[Zonal]) -> Vec<[f32; 2]> {
    let fit = |(open, log): (&Zonal, &Zonal)| {
        let scale = (-log[0] / ONE).exp();
        let length2: f64 = log[1..].iter().map(|f| f * f).sum();
        let along: f64 = log[1..].iter().zip(&open[1..]).map(|(f, g)| f * g * scale).sum();
        (length2.sqrt(), [open[0] * scale / ONE, along / length2])
    };
    // Nothing is blocked by a sphere of no size: exp(f) = 1 + f.
    let mut fits = vec![(0.0, [1.0, 1.0])];
    for (length, [a, b]) in open.iter().zip(logarithms).skip(1).map(fit) {
        if length > fits[fits.len() - 1].0 {
            fits.push((length, [a, b]));
        }
    }
    let entry = |entry: usize| {
        let length = f64::from(SHORT) * entry as f64 / (ENTRIES - 1) as f64;
        let above = fits.partition_point(|(at, _)| *at < length).clamp(1, fits.len() - 1);
        let ((from, a), (to, b)) = (fits[above - 1], fits[above]);
        let share = ((length - from) / (to - from)).clamp(0.0, 1.0);
        std::array::from_fn(|k| (a[k] + share * (b[k] - a[k])) as f32)
    };
    (0..ENTRIES).map(entry).collect()
}

/// Between the entries of a table, at `place` in 0..=1.
#[inline(always)]
fn look_up<const N: usize>(table: &[[f32; N]], place: f32) -> [f32; N] {
    let at = place.clamp(0.0, 1.0) * (ENTRIES - 1) as f32;
    let first = (at as usize).min(ENTRIES - 2);
    let share = at - first as f32;
    let (from, to) = (&table[first], &table[first + 1]);
    std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
}

impl Exponentiation {
    /// What `spheres`, centre and radius each, let through to each of `positions`.
    pub fn open(&self, positions: &[Vec3], spheres: &[[f32; 4]]) -> Vec<Coefficients> {
        by_groups(positions, |group| self.hybrid(&self.logarithm(group, spheres)))
    }

    /// The sums of the logarithms of `spheres` as seen from each of `positions`.
    pub fn logarithms(&self, positions: &[Vec3], spheres: &[[f32; 4]]) -> Vec<Coefficients> {
        by_groups(positions, |group| self.logarithm(group, spheres))
    }

    /// The sum of the logarithms of `spheres`, centre and radius each, as seen from receivers at `positions`, given
    /// by coordinates. A sphere that a receiver is in blocks all.
    #[inline(always)]
    fn logarithm(&self, positions: &[[f32; LANES]; 3], spheres: &[[f32; 4]]) -> Functions {
        let mut sum = [[0.0; LANES]; COUNT];
        for [x, y, z, radius] in spheres {
            let (mut towards, mut logarithms) = ([[0.0; LANES]; 3], [[0.0; LANES]; BANDS]);
            for lane in 0..LANES {
                let offset: [f32; 3] = std::array::from_fn(|c| [x, y, z][c] - positions[c][lane]);
                let distance2 = offset.iter().map(|c| c * c).sum::<f32>();
                let distance = distance2.sqrt().max(f32::MIN_POSITIVE);
                (0..3).for_each(|c| towards[c][lane] = offset[c] / distance);
                let cos2 = 1.0 - radius * radius / distance2;
                let log = if cos2 > 0.0 {
                    // The sine of half the angle, over that of half a right one.
                    look_up(&self.logarithms, (1.0 - cos2.sqrt()).sqrt())
                } else {
                    [(LEAST.ln() * 4.0 * PI) as f32, 0.0, 0.0, 0.0, 0.0]
                };
                (0..BANDS).for_each(|band| logarithms[band][lane] = log[band]);
            }
            let basis = basis_of(towards);
            for index in 0..COUNT {
                for lane in 0..LANES {
                    sum[index][lane] += logarithms[BAND[index]][lane] * basis[index][lane];
                }
            }
        }
        sum
    }

    /// exp(f) by the source's hybrid.
    #[inline(always)]
    fn hybrid(&self, f: &Functions) -> Functions {
        let mut length2 = [0.0f32; LANES];
        for row in &f[1..] {
            (0..LANES).for_each(|lane| length2[lane] += row[lane] * row[lane]);
        }
        let longest = length2.iter().fold(0.0f32, |most, length| most.max(*length)).sqrt();
        let halvings = (longest / SHORT).log2().ceil().clamp(0.0, 32.0);
        let scale = (-halvings).exp2();
        let (mut a, mut b, mut constant) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            [a[lane], b[lane]] = look_up(&self.linear, scale * length2[lane].sqrt() / SHORT);
            constant[lane] = (f[0][lane] / ONE as f32).exp();
        }
        let mut g = [[0.0; LANES]; COUNT];
        for lane in 0..LANES {
            g[0][lane] = a[lane] * ONE as f32;
            (1..COUNT).for_each(|index| g[index][lane] = scale * b[lane] * f[index][lane]);
        }
        (0..halvings as u32).for_each(|_| g = self.product.square(&g));
        for row in &mut g {
            (0..LANES).for_each(|lane| row[lane] *= constant[lane]);
        }
        g
    }

    /// exp(f) as its series says, each product cut off to the bands that there are: what the hybrid stands for.
    pub fn series(&self, f: &Coefficients) -> Coefficients {
        let mut rest = *f;
        rest[0] = 0.0;
        let matrix = self.product.matrix(&rest);
        let length = rest.iter().map(|f| f * f).sum::<f32>().sqrt();
        // Steps so short that eight terms of the series are exact in single precision.
        let steps = length.ceil().max(1.0);
        let mut g = [0.0; COUNT];
        g[0] = ONE * (f64::from(f[0]) / ONE).exp();
        for _ in 0..steps as usize {
            let mut power = g;
            for k in 1..=12 {
                let divisor = f64::from(steps) * f64::from(k);
                power = std::array::from_fn(|i| {
                    matrix[i].iter().zip(&power).map(|(m, p)| f64::from(*m) * p).sum::<f64>() / divisor
                });
                g.iter_mut().zip(&power).for_each(|(sum, term)| *sum += term);
            }
        }
        g.map(|value| value as f32)
    }
}

/// What is found for groups of positions, in the best vector code that there is, for each of them.
fn by_groups(positions: &[Vec3], of: impl Fn(&[[f32; LANES]; 3]) -> Functions) -> Vec<Coefficients> {
    let mut found = Vec::with_capacity(positions.len());
    Arch::new().dispatch(|| {
        for group in positions.chunks(LANES) {
            // Lanes of the last group that nobody asks for are its last position again.
            let position = |lane: usize| group[lane.min(group.len() - 1)];
            let functions = of(&std::array::from_fn(|c| std::array::from_fn(|lane| position(lane)[c])));
            found.extend((0..group.len()).map(|lane| functions.map(|row| row[lane])));
        }
    });
    found
}

/// What one sphere lets through, projected: about the unit vector `towards` it, with the cosine of its angular radius.
pub fn open_but_for_sphere(towards: Vec3, cos: f64) -> Coefficients {
    let (scale, y) = (turned_by(&open_but_for_cap(cos)), basis(towards));
    std::array::from_fn(|index| (scale[BAND[index]] * f64::from(y[index])) as f32)
}

#[cfg(test)]
mod tests {
    use super::super::tests::directions;
    use super::*;

    fn distance(a: &Coefficients, b: &Coefficients) -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    }

    /// A sphere of angular radius `angle` seen from the origin.
    fn sphere(towards: Vec3, angle: f32) -> [f32; 4] {
        let Vec3 { x, y, z } = 3.0 * towards;
        [x, y, z, 3.0 * angle.sin()]
    }

    #[test]
    fn eigenvectors_make_up_the_matrix() {
        let matrix: [[f64; BANDS]; BANDS] = std::array::from_fn(|i| {
            std::array::from_fn(|j| ((i + 1) * (j + 1) % 7) as f64 - 0.3 * (i + j) as f64)
        });
        let (values, vectors) = eigen(matrix);
        for i in 0..BANDS {
            for j in 0..BANDS {
                let of = |k: usize| vectors[i][k] * values[k] * vectors[j][k];
                assert!(((0..BANDS).map(of).sum::<f64>() - matrix[i][j]).abs() < 1e-12);
            }
        }
    }

    /// Up to 0.67 rad no eigenvalue is below [`LEAST`]: the series gives back what was projected, the hybrid up to what
    /// its a and b leave, at most 0.0013 of a function that is 1. Beyond, what is raised to [`LEAST`] lets that much
    /// through where all is blocked, and the bands' ringing, up to 0.06.
    #[test]
    fn one_sphere_lets_through_what_is_projected_of_it() {
        let exponentiation = Exponentiation::default();
        for (towards, angle) in directions(40).zip((1..=40).map(|k| 0.035 * k as f32)) {
            let spheres = [sphere(towards, angle)];
            let hybrid = exponentiation.open(&[Vec3::ZERO], &spheres)[0];
            let series = exponentiation.series(&exponentiation.logarithms(&[Vec3::ZERO], &spheres)[0]);
            let exact = open_but_for_sphere(towards, f64::from(angle.cos()));
            let bound = if angle < 0.67 { 0.0025 } else { 0.065 };
            for open in [hybrid, series] {
                assert!(distance(&open, &exact) / ONE < bound, "{angle}: {}", distance(&open, &exact) / ONE);
            }
            if angle < 0.55 {
                assert!(
                    distance(&series, &exact) / ONE < 1e-4,
                    "{angle}: {}",
                    distance(&series, &exact) / ONE
                );
            }
        }
    }

    /// a and b are those of single spheres: of many they leave up to 0.018 of a function that is 1.
    #[test]
    fn the_hybrid_stands_for_the_series_with_many_spheres() {
        let exponentiation = Exponentiation::default();
        for seed in 0..10u32 {
            let spheres = directions(200).skip(seed as usize).step_by(10 + seed as usize);
            let spheres: Vec<[f32; 4]> = spheres.map(|d| sphere(d, 0.1 + 0.02 * seed as f32)).collect();
            // More positions than a group has lanes.
            let positions = [Vec3::ZERO; LANES + 3];
            let hybrid = exponentiation.open(&positions, &spheres);
            assert!(hybrid.len() == positions.len() && hybrid.iter().all(|open| *open == hybrid[0]));
            let logarithm = exponentiation.logarithms(&[Vec3::ZERO], &spheres)[0];
            let series = exponentiation.series(&logarithm);
            assert!(series[0] < 0.96 * ONE as f32 && distance(&hybrid[0], &series) / ONE < 0.02, "{seed}");
            // The logarithm is that of each sphere in the direction that it is in, added.
            let alone = spheres.iter().map(|s| exponentiation.logarithms(&[Vec3::ZERO], &[*s])[0]);
            let sum = alone.fold([0.0; COUNT], |sum, log| std::array::from_fn(|k| sum[k] + log[k]));
            assert!(distance(&sum, &logarithm) < 1e-5 * ONE, "{seed}");
        }
    }
}
