//! Texels of the hemisphere about a normal, of equal solid angle: a square grid on the unit disc by the concentric map
//! (Shirley and Chiu 1997), and the disc on the hemisphere by r² = 1 − cos θ.
//!
//! Texel (x, y) has index y·[`SIDE`] + x. Directions are in the frame of a vertex: its tangent, bitangent and normal.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Texels along a side.
pub const SIDE: usize = 24;
/// Texels.
pub const TEXELS: usize = SIDE * SIDE;

/// The unit vector at the place (`u`, `v`), each in 0..=1, of the square.
pub fn direction(u: f32, v: f32) -> Vec3 {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (r, angle) = if a * a > b * b {
        (a, FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    } else {
        (0.0, 0.0)
    };
    // sin θ over r.
    let rise = (2.0 - r * r).max(0.0).sqrt();
    Vec3::new(rise * r * angle.cos(), rise * r * angle.sin(), 1.0 - r * r)
}

/// The place of a unit vector whose z is not below 0, each coordinate in 0..=1.
pub fn place(direction: Vec3) -> Vec2 {
    let Vec3 { x, y, z } = direction;
    let r = (1.0 - z).clamp(0.0, 1.0).sqrt();
    let angle = y.atan2(x);
    let (a, b) = if x.abs() >= y.abs() {
        // Around ±x: the angle from the axis, in eighths of a turn.
        let turned = if x >= 0.0 { angle } else { y.atan2(-x) };
        (r.copysign(x), r * turned / FRAC_PI_4)
    } else {
        (r * x.atan2(y.abs()) / FRAC_PI_4, r.copysign(y))
    };
    Vec2::new(0.5 * a + 0.5, 0.5 * b + 0.5)
}

/// The value at a unit vector whose z is not below 0 of `texels`, row by row, linear between their middles, and beyond
/// those of the edge what they have.
pub fn sample(texels: &[u8], direction: Vec3) -> f32 {
    let last = SIDE as f32 - 1.0;
    let at = (place(direction) * SIDE as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat(last));
    let first = at.floor().min(Vec2::splat(last - 1.0));
    let (share, [x, y]) = (at - first, [first.x as usize, first.y as usize]);
    let texel = |dx: usize, dy: usize| texels.get((y + dy) * SIDE + x + dx).copied().map_or(0.0, f32::from);
    let row = |dy: usize| texel(0, dy) + (texel(1, dy) - texel(0, dy)) * share.x;
    (row(0) + (row(1) - row(0)) * share.y) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn places_and_directions_are_inverse() {
        for step in 0..5000 {
            let [u, v] = [0.618_034, 0.414_214].map(|g: f32| (step as f32 * g + 0.01).fract());
            let towards = direction(u, v);
            assert!((towards.length() - 1.0).abs() < 1e-5 && towards.z >= 0.0);
            let back = place(towards);
            // Near the middle angles are those of short vectors; places are not, but √(1 − z) loses digits there.
            assert!((back - Vec2::new(u, v)).length() < 1e-3, "{u} {v} {back}");
        }
    }

    /// The solid angle of a texel by its four corners' triangles is 2π/576, to what their sagitta takes off.
    #[test]
    fn texels_are_of_equal_solid_angle() {
        let (fine, mut sums) = (16, vec![0.0f32; TEXELS]);
        let n = SIDE * fine;
        for point in 0..n * n {
            let [x, y] = [point % n, point / n];
            let corner =
                |dx: usize, dy: usize| direction((x + dx) as f32 / n as f32, (y + dy) as f32 / n as f32);
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            sums[y / fine * SIDE + x / fine] +=
                0.5 * ((b - a).cross(c - a).length() + (c - a).cross(d - a).length());
        }
        let even = TAU / TEXELS as f32;
        let worst = sums.iter().map(|sum| (sum / even - 1.0).abs()).fold(0.0, f32::max);
        assert!(worst < 0.004, "{worst}");
    }

    #[test]
    fn samples_are_linear_between_texels() {
        let texels: Vec<u8> = (0..TEXELS).map(|t| (10 * (t % SIDE)) as u8).collect();
        for (u, expected) in [(0.5 / 24.0, 0.0), (1.0 / 24.0, 5.0), (12.0 / 24.0, 115.0), (1.0, 230.0)] {
            let found = 255.0 * sample(&texels, direction(u, 0.3));
            assert!((found - expected).abs() < 0.01, "{u}: {found}");
        }
    }
}
