//! The best similarity between two sets of points (Horn 1987, "Closed-form solution of absolute orientation
//! using unit quaternions").

use glam::{DMat3, DQuat, DVec3};

/// How much the unturned, unscaled pose weighs against the points, in parts of what they and their lever arm
/// do. It decides where they leave a turn open, and keeps points that all but coincide from turning a distant
/// centre with their rounding errors.
const PRIOR: f64 = 1e-9;
/// Rounds of Jacobi rotations, each over all pairs; a 4 × 4 matrix needs five or six.
const SWEEPS: usize = 12;

/// Turn, scale and shift.
#[derive(Debug, Clone, Copy)]
pub(super) struct Similarity {
    to: DVec3,
    rotation: DQuat,
    /// Above or equal to 0.
    pub scale: f64,
}

impl Similarity {
    /// The motion from points at `rest`, given from their `centroid`, to where they are `now`; `arm` is the
    /// place, from the centroid, that matters.
    pub fn between(centroid: DVec3, rest: impl Iterator<Item = DVec3>, now: &[DVec3], arm: DVec3) -> Self {
        if now.is_empty() {
            return Self { to: centroid, rotation: DQuat::IDENTITY, scale: 1.0 };
        }
        let to = now.iter().sum::<DVec3>() / now.len() as f64;
        let (mut covariance, mut before, mut after) = (DMat3::ZERO, 0.0, 0.0);
        for (rest, now) in rest.zip(now) {
            let now = *now - to;
            covariance += DMat3::from_cols(rest * now.x, rest * now.y, rest * now.z);
            before += rest.length_squared();
            after += now.length_squared();
        }
        let lever = arm.length_squared() * now.len() as f64;
        let squared = (after + PRIOR * lever) / (before + PRIOR * lever);
        let scale = if squared.is_finite() { squared.sqrt() } else { 1.0 };
        let prior = PRIOR * (before + lever) * scale;
        Self { to, rotation: rotation(&(covariance + DMat3::from_diagonal(DVec3::splat(prior)))), scale }
    }

    /// Where the place `offset` from the centroid goes.
    pub fn apply(&self, offset: DVec3) -> DVec3 {
        self.to + self.rotation * (offset * self.scale)
    }
}

/// The rotation that maximises Σ now · (rotation · rest), of a matrix whose columns are Σ rest · nowₓ, Σ rest
/// · now_y, Σ rest · now_z.
fn rotation(m: &DMat3) -> DQuat {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = m.to_cols_array_2d();
    let (vectors, values) = eigen([
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ]);
    // The first of equal ones: for a zero matrix that is no turn.
    let largest = (1..4).fold(0, |best, k| if values[k] > values[best] { k } else { best });
    let [w, x, y, z] = vectors.map(|row| row[largest]);
    DQuat::from_xyzw(x, y, z, w).normalize()
}

/// Eigenvectors, as columns, and eigenvalues of a symmetric matrix, by cyclic Jacobi rotations (Golub & Van
/// Loan, §8.5).
fn eigen(mut a: [[f64; 4]; 4]) -> ([[f64; 4]; 4], [f64; 4]) {
    let mut vectors: [[f64; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..SWEEPS {
        for p in 0..3 {
            for q in p + 1..4 {
                if a[p][q] == 0.0 {
                    continue;
                }
                let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let tan = tau.signum() / (tau.abs() + tau.hypot(1.0));
                let cos = 1.0 / tan.hypot(1.0);
                let turn = |row: &mut [f64; 4]| {
                    (row[p], row[q]) = (cos * (row[p] - tan * row[q]), cos * (row[q] + tan * row[p]))
                };
                a.iter_mut().for_each(turn);
                (0..4).for_each(|k| {
                    (a[p][k], a[q][k]) = (cos * (a[p][k] - tan * a[q][k]), cos * (a[q][k] + tan * a[p][k]))
                });
                (a[p][q], a[q][p]) = (0.0, 0.0);
                vectors.iter_mut().for_each(turn);
            }
        }
    }
    (vectors, std::array::from_fn(|k| a[k][k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A·v = λ·v, and the vectors are orthonormal: also for equal eigenvalues.
    #[test]
    fn eigenvectors_are_what_they_should_be() {
        let matrices = [
            [[4.0, 1.0, -2.0, 0.5], [1.0, 3.0, 0.25, 1.0], [-2.0, 0.25, -1.0, 2.0], [0.5, 1.0, 2.0, 0.0]],
            [[1.0; 4]; 4],
            [[0.0; 4]; 4],
            [[1e-30, 1e30, 0.0, 0.0], [1e30, 1.0, 0.0, 7.0], [0.0, 0.0, 5.0, 0.0], [0.0, 7.0, 0.0, 5.0]],
        ];
        for a in matrices {
            let (vectors, values) = eigen(a);
            let size = a.as_flattened().iter().fold(0.0f64, |m, v| m.max(v.abs()));
            for k in 0..4 {
                let v = vectors.map(|row| row[k]);
                for row in 0..4 {
                    let product: f64 = (0..4).map(|j| a[row][j] * v[j]).sum();
                    assert!((product - values[k] * v[row]).abs() <= 1e-14 * size, "{a:?}");
                }
                for other in 0..4 {
                    let dot: f64 = vectors.iter().map(|row| row[k] * row[other]).sum();
                    assert!((dot - f64::from(u8::from(k == other))).abs() < 1e-14, "{a:?}");
                }
            }
        }
    }
}
