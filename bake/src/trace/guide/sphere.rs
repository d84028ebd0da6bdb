//! An equal-area map between the unit square and the sphere of directions: octahedral, so that no direction
//! is stretched much (Clarberg 2008, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD").

use glam::Vec3A;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_4};

/// The direction at a point of the unit square.
pub fn direction_at(square: [f32; 2]) -> Vec3A {
    let [u, v] = square.map(|s| 2.0 * s - 1.0);
    // How far inside the diamond that is the upper half; negative outside, which is the lower one.
    let inside = 1.0 - (u.abs() + v.abs());
    let r = 1.0 - inside.abs();
    let turn = if r == 0.0 { 1.0 } else { (v.abs() - u.abs()) / r + 1.0 };
    let (sin_phi, cos_phi) = (turn * FRAC_PI_4).sin_cos();
    let across = r * (2.0 - r * r).max(0.0).sqrt();
    Vec3A::new(cos_phi.copysign(u) * across, sin_phi.copysign(v) * across, (1.0 - r * r).copysign(inside))
}

/// The inverse of [`direction_at`], for unit vectors; both coordinates are in [0, 1].
pub fn square_at(direction: Vec3A) -> [f32; 2] {
    let [x, y, z] = direction.abs().to_array();
    let r = (1.0 - z).max(0.0).sqrt();
    let (least, most) = (x.min(y), x.max(y));
    let phi = if most == 0.0 { 0.0 } else { (least / most).atan() * FRAC_2_PI };
    let v = r * if x < y { 1.0 - phi } else { phi };
    let [u, v] = if direction.z < 0.0 { [1.0 - v, 1.0 - (r - v)] } else { [r - v, v] };
    [u.copysign(direction.x), v.copysign(direction.y)].map(|s| 0.5 * s + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_directions_are_each_others() {
        const N: u32 = 251;
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let point = [i, j].map(|k| (k as f32 + 0.5) / N as f32);
            let direction = direction_at(point);
            assert!((direction.length() - 1.0).abs() < 1e-5, "{point:?}");
            let back = square_at(direction);
            // Near the seams and poles rounding of a direction is more than that of a point.
            assert!((0..2).all(|k| (back[k] - point[k]).abs() < 1e-3), "{point:?} {back:?}");
        }
        for axis in [Vec3A::X, Vec3A::Y, Vec3A::Z] {
            for direction in [axis, -axis] {
                assert!(direction_at(square_at(direction)).distance(direction) < 1e-3, "{direction}");
            }
        }
    }

    /// Cells of the square cover the same solid angle: of evenly spread points, each cap around an axis gets
    /// its part of the sphere, (1 − cos θ) / 2.
    #[test]
    fn areas_are_kept() {
        const N: u32 = 512;
        let point = |k: u32| [k % N, k / N].map(|k| (k as f32 + 0.5) / N as f32);
        let directions: Vec<Vec3A> = (0..N * N).map(|k| direction_at(point(k))).collect();
        let axes =
            [Vec3A::X, Vec3A::NEG_Y, Vec3A::Z, Vec3A::new(1.0, -2.0, 3.0), Vec3A::new(-3.0, 2.0, -1.0)];
        for axis in axes.map(Vec3A::normalize) {
            for cosine in [0.98, 0.7, 0.1, -0.5] {
                let inside = directions.iter().filter(|d| d.dot(axis) > cosine).count();
                let (seen, expected) = (inside as f32 / (N * N) as f32, 0.5 * (1.0 - cosine));
                // The edge of a cap passes through less than 1 % of the points' cells, most of which cancel.
                assert!((seen - expected).abs() < 2e-3, "{axis} {cosine}: {seen} for {expected}");
            }
        }
    }
}
