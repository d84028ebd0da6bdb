//! The light's texels as directions for rays.

use crate::trace::spans::{TexelRays, TexelSet};
use glam::Vec3A;
use relume_formats::basis::cubemap::{self, FACES};

/// Texels along a side of a face that visibility is traced for.
pub const FACE_SIZE: usize = 64;

/// Directions, solid angles and neighbours of all texels of a cube of [`FACE_SIZE`].
pub struct Texels {
    /// Through each texel's centre.
    pub centres: TexelRays,
    /// Solid angle of each texel over π: times the cosine, the transfer of an unblocked one.
    pub weights: Vec<f32>,
    /// The four texels that share a border with each, across the cube's edges too.
    neighbours: Vec<[u16; 4]>,
    /// Directions within the texels, a square of them in each: the centres of a finer cube.
    fine: TexelRays,
    /// What share of its texel's solid angle each of them stands for.
    shares: Vec<f32>,
    /// How many there are along a side of a texel.
    side: usize,
}

impl Texels {
    /// With `side`² directions within each texel.
    pub fn new(side: usize) -> Self {
        let n = FACE_SIZE;
        let places = || (0..FACES * n * n).map(|i| (i / (n * n), (i % n) as f64, (i / n % n) as f64));
        let towards = |face, x, y| cubemap::direction(face, n, x, y).as_vec3a();
        let solid_angles = cubemap::solid_angles(n);
        let neighbour = |face, x: f64, y: f64| cubemap::texel_of(towards(face, x, y).into(), n) as u16;
        let (fine, shares) = finer(side);
        Self {
            centres: TexelRays::centres(n),
            weights: places()
                .map(|(_, x, y)| (solid_angles[y as usize * n + x as usize] / std::f64::consts::PI) as f32)
                .collect(),
            neighbours: places()
                .map(|(face, x, y)| {
                    [(x - 0.5, y + 0.5), (x + 1.5, y + 0.5), (x + 0.5, y - 0.5), (x + 0.5, y + 1.5)]
                        .map(|(x, y)| neighbour(face, x, y))
                })
                .collect(),
            fine,
            shares,
            side,
        }
    }

    /// Directions within all texels.
    pub fn fine(&self) -> &TexelRays {
        &self.fine
    }

    /// The directions within `texel`, row by row: the index of each in [`Texels::fine`].
    pub fn points(&self, texel: usize) -> impl Iterator<Item = usize> + use<> {
        let (n, side) = (FACE_SIZE, self.side);
        let (row, x) = (texel / n, texel % n);
        (0..side * side).map(move |k| (row * side + k / side) * n * side + x * side + k % side)
    }

    /// One of the directions within texels, by its index, and its share of its texel.
    pub fn point(&self, index: usize) -> (Vec3A, f32) {
        (self.fine.directions()[index], self.shares[index])
    }

    /// Whether texels are refined at all: one direction within is the centre.
    pub fn are_refined(&self) -> bool {
        self.side > 1
    }

    /// As many directions as there can be for one receiver.
    pub fn most_points(&self) -> usize {
        self.shares.len()
    }

    /// The four texels around `texel`.
    pub fn neighbours(&self, texel: usize) -> [usize; 4] {
        self.neighbours[texel].map(usize::from)
    }

    /// The texels of which a neighbour is in `set` while they are not, or the other way round.
    pub fn borders(&self, set: &TexelSet) -> TexelSet {
        let (n, words) = (FACE_SIZE, set.words());
        let mut borders = TexelSet::none(n);
        for face in 0..FACES {
            for y in 0..n {
                let row = face * n + y;
                let differ = |other: usize| words[row] ^ words[other];
                let (right, left) = (words[row] ^ words[row] >> 1, words[row] ^ words[row] << 1);
                let inside = right & (u64::MAX >> 1) | left & (u64::MAX << 1);
                let above = if y > 0 { differ(row - 1) } else { 0 };
                let below = if y + 1 < n { differ(row + 1) } else { 0 };
                borders.set_word(row, inside | above | below);
                // What lies beyond the edges of the face.
                let all = if y == 0 || y + 1 == n { 1..n - 1 } else { 0..0 };
                for x in all.chain([0, n - 1]) {
                    let differs = |other: usize| set.has(other / n, other % n) != set.has(row, x);
                    if self.neighbours(row * n + x).into_iter().any(differs) {
                        borders.insert(row, x);
                    }
                }
            }
        }
        borders
    }
}

/// Sums over squares of texels, from `from`² to `to`² of them a face, which divides it.
pub fn summed(row: &[f32], from: usize, to: usize) -> Vec<f32> {
    let step = from / to;
    let mut sums = vec![0.0; FACES * to * to];
    for (texel, value) in row.iter().enumerate() {
        // Rows of all faces follow one another, and a step never goes over a face's end.
        let (row, x) = (texel / from, texel % from);
        sums[row / step * to + x / step] += value;
    }
    sums
}

/// The centres of a cube `side` times as fine, and what share of its texel each stands for.
fn finer(side: usize) -> (TexelRays, Vec<f32>) {
    let (n, fine) = (FACE_SIZE, FACE_SIZE * side);
    // In texels, as their places within these are given.
    let place = |k: usize| (k / side) as f64 + ((k % side) as f64 + 0.5) / side as f64;
    let on_face = |c: f64| 2.0 * c / n as f64 - 1.0;
    let part = |x: usize, y: usize| {
        let (s, t) = (on_face(place(x)), on_face(place(y)));
        (1.0 + s * s + t * t).powf(-1.5)
    };
    let total = |x: usize, y: usize| {
        let (first_x, first_y) = (x / side * side, y / side * side);
        (0..side * side).map(|k| part(first_x + k % side, first_y + k / side)).sum::<f64>()
    };
    let places = || (0..FACES * fine * fine).map(|i| (i / (fine * fine), i % fine, i / fine % fine));
    let totals: Vec<f64> = (0..n * n).map(|i| total(i % n * side, i / n * side)).collect();
    let share = |(_, x, y): (usize, usize, usize)| (part(x, y) / totals[y / side * n + x / side]) as f32;
    let direction = |(face, x, y)| cubemap::direction(face, n, place(x), place(y)).as_vec3a();
    (TexelRays::new(fine, places().map(direction).collect()), places().map(share).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_near_and_mutual() {
        let texels = Texels::new(1);
        // Diagonally across a texel at the middle of a face, where they are largest.
        let farthest = 2.0 / FACE_SIZE as f32 * std::f32::consts::SQRT_2;
        let directions = texels.centres.directions();
        for (texel, direction) in directions.iter().enumerate() {
            let around = texels.neighbours(texel);
            assert!(!around.contains(&texel));
            for neighbour in around {
                assert!(direction.distance(directions[neighbour]) < farthest, "{texel} and {neighbour}");
                assert!(texels.neighbours(neighbour).contains(&texel), "{texel} and {neighbour}");
            }
        }
    }

    #[test]
    fn shares_of_a_texel_are_those_of_its_parts() {
        let texels = Texels::new(2);
        let (n, fine) = (FACE_SIZE, cubemap::solid_angles(2 * FACE_SIZE));
        for texel in [0, 5 * n + 9, n * n - 1] {
            let (x, y) = (texel % n, texel / n);
            let parts = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| fine[(2 * y + j) * 2 * n + 2 * x + i]);
            for (part, point) in parts.iter().zip(texels.points(texel)) {
                let (_, share) = texels.point(point);
                assert!((part / parts.iter().sum::<f64>() - f64::from(share)).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn borders_are_where_a_neighbour_differs() {
        let (n, texels) = (FACE_SIZE, Texels::new(1));
        for seed in 1..6usize {
            // Blocks of texels, from none to many.
            let is_in = |texel: usize| {
                let block = texel / n / (2 * seed) * 97 + texel % n / (3 * seed);
                block.wrapping_mul(2_654_435_761 * seed) >> 7 & 3 == 0
            };
            let borders = texels.borders(&TexelSet::of(n, is_in));
            for texel in 0..FACES * n * n {
                let differs = texels.neighbours(texel).into_iter().any(|other| is_in(other) != is_in(texel));
                assert_eq!(borders.has(texel / n, texel % n), differs, "{texel}");
            }
            assert!((100..FACES * n * n).contains(&borders.count()));
        }
    }
}
