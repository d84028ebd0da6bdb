//! The light's texels as directions for rays.

use glam::Vec3A;
use relume_formats::basis::cubemap::{self, FACES};

/// Texels along a side of a face that visibility is traced for.
pub const FACE_SIZE: usize = 64;

/// Directions, solid angles and neighbours of all texels of a cube of [`FACE_SIZE`].
pub struct Texels {
    /// Unit direction of each texel's centre.
    pub directions: Vec<Vec3A>,
    /// Solid angle of each texel over π: times the cosine, the transfer of an unblocked one.
    pub weights: Vec<f32>,
    /// The four texels that share a border with each, across the cube's edges too.
    neighbours: Vec<[u16; 4]>,
    /// Directions within each texel, so many per texel, with the share of its solid angle that each stands
    /// for.
    points: Vec<(Vec3A, f32)>,
    points_per_texel: usize,
}

impl Texels {
    /// With `side`² directions within each texel.
    pub fn new(side: usize) -> Self {
        let n = FACE_SIZE;
        let places = || (0..FACES * n * n).map(|i| (i / (n * n), (i % n) as f64, (i / n % n) as f64));
        let towards = |face, x, y| cubemap::direction(face, n, x, y).as_vec3a();
        let solid_angles = cubemap::solid_angles(n);
        let neighbour = |face, x: f64, y: f64| cubemap::texel_of(towards(face, x, y).into(), n) as u16;
        let share = |s: f64, t: f64| (1.0 + s * s + t * t).powf(-1.5);
        let mut points = Vec::with_capacity(FACES * n * n * side * side);
        for (face, x, y) in places() {
            let place = |k: usize| {
                (x + ((k % side) as f64 + 0.5) / side as f64, y + ((k / side) as f64 + 0.5) / side as f64)
            };
            let on_face = |c: f64| 2.0 * c / n as f64 - 1.0;
            let shares = (0..side * side).map(|k| share(on_face(place(k).0), on_face(place(k).1)));
            let total: f64 = shares.clone().sum();
            points.extend(
                shares
                    .enumerate()
                    .map(|(k, share)| (towards(face, place(k).0, place(k).1), (share / total) as f32)),
            );
        }
        Self {
            directions: places().map(|(face, x, y)| towards(face, x + 0.5, y + 0.5)).collect(),
            weights: places()
                .map(|(_, x, y)| (solid_angles[y as usize * n + x as usize] / std::f64::consts::PI) as f32)
                .collect(),
            neighbours: places()
                .map(|(face, x, y)| {
                    [(x - 0.5, y + 0.5), (x + 1.5, y + 0.5), (x + 0.5, y - 0.5), (x + 0.5, y + 1.5)]
                        .map(|(x, y)| neighbour(face, x, y))
                })
                .collect(),
            points,
            points_per_texel: side * side,
        }
    }

    /// Directions within `texel` and their shares of it.
    pub fn points(&self, texel: usize) -> &[(Vec3A, f32)] {
        &self.points[texel * self.points_per_texel..(texel + 1) * self.points_per_texel]
    }

    /// Whether `texel` is refined at all: one direction within is its centre.
    pub fn are_refined(&self) -> bool {
        self.points_per_texel > 1
    }

    /// As many directions as there can be for one receiver.
    pub fn most_points(&self) -> usize {
        self.points.len()
    }

    /// The four texels around `texel`.
    pub fn neighbours(&self, texel: usize) -> [usize; 4] {
        self.neighbours[texel].map(usize::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_near_and_mutual() {
        let texels = Texels::new(1);
        // Diagonally across a texel at the middle of a face, where they are largest.
        let farthest = 2.0 / FACE_SIZE as f32 * std::f32::consts::SQRT_2;
        for (texel, direction) in texels.directions.iter().enumerate() {
            let around = texels.neighbours(texel);
            assert!(!around.contains(&texel));
            for neighbour in around {
                assert!(
                    direction.distance(texels.directions[neighbour]) < farthest,
                    "{texel} and {neighbour}"
                );
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
            for (part, (_, share)) in parts.iter().zip(texels.points(texel)) {
                assert!((part / parts.iter().sum::<f64>() - f64::from(*share)).abs() < 1e-5);
            }
        }
    }
}
