//! Directions on a cube: six faces +X −X +Y −Y +Z −Z of n × n texels in the orientation of OpenGL and WebGPU.
//!
//! Texel (x, y) of a face has index (face·n + y)·n + x; y runs down, as the rows of an image do. With s = 2x/n − 1 and t = 2y/n − 1 at the continuous
//! texel coordinates (x, y) in 0..=n, (0.5, 0.5) being the centre of the first texel, the (unnormalised) directions are
//!
//! | face | direction   | | face | direction   |
//! |------|-------------|-|------|-------------|
//! | +X   | (1, −t, −s) | | −X   | (−1, −t, s) |
//! | +Y   | (s, 1, t)   | | −Y   | (s, −1, −t) |
//! | +Z   | (s, −t, 1)  | | −Z   | (−s, −t, −1)|

use super::EquirectMap;
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Faces of a cube.
pub const FACES: usize = 6;

/// The axis and its sign that are s, t and the normal of each face.
pub const FRAMES: [[(usize, f32); 3]; FACES] = [
    [(2, -1.0), (1, -1.0), (0, 1.0)],
    [(2, 1.0), (1, -1.0), (0, -1.0)],
    [(0, 1.0), (2, 1.0), (1, 1.0)],
    [(0, 1.0), (2, -1.0), (1, -1.0)],
    [(0, 1.0), (1, -1.0), (2, 1.0)],
    [(0, -1.0), (1, -1.0), (2, -1.0)],
];

/// The unit direction of the continuous texel coordinates (`x`, `y`), each in 0..=`n`, on `face`.
pub fn direction(face: usize, n: usize, x: f64, y: f64) -> DVec3 {
    let [x, y, z] = on_face(face, 2.0 * x / n as f64 - 1.0, 2.0 * y / n as f64 - 1.0);
    DVec3::new(x, y, z).normalize()
}

/// The point of the cube [−1, 1]³ at (`s`, `t`) on `face`; faces beyond the last are taken for −Z.
pub(crate) fn on_face<T: Copy + std::ops::Neg<Output = T> + From<f32>>(face: usize, s: T, t: T) -> [T; 3] {
    let one = T::from(1.0);
    match face {
        0 => [one, -t, -s],
        1 => [-one, -t, s],
        2 => [s, one, t],
        3 => [s, -one, -t],
        4 => [s, -t, one],
        _ => [-s, -t, -one],
    }
}

/// Index over the whole cube of the texel that `direction`, of any length, points into. On the border of two
/// texels the one to the right or below is taken, on the border of two faces the one whose axis comes first.
pub fn texel_of(direction: Vec3, n: usize) -> usize {
    let (face, [s, t]) = place_of(direction);
    // A cast takes what lies outside to the nearest number, and NaN, which the null vector gives, to 0.
    let texel = |c: f32| (((c + 1.0) * 0.5 * n as f32) as usize).min(n.saturating_sub(1));
    (face * n + texel(t)) * n + texel(s)
}

/// The face that `direction`, of any length, points into, and where on it, s and t in −1..=1; the face whose
/// axis comes first on the border of two. The null vector's place is no number.
pub(crate) fn place_of(direction: Vec3) -> (usize, [f32; 2]) {
    let Vec3 { x, y, z } = direction;
    let [ax, ay, az] = [x.abs(), y.abs(), z.abs()];
    let (face, s, t, axis) = if ax >= ay && ax >= az {
        if x >= 0.0 { (0, -z, -y, ax) } else { (1, z, -y, ax) }
    } else if ay >= az {
        if y >= 0.0 { (2, x, z, ay) } else { (3, x, -z, ay) }
    } else if z >= 0.0 {
        (4, x, -y, az)
    } else {
        (5, -x, -y, az)
    };
    (face, [s / axis, t / axis])
}

/// Solid angles in steradians of the n × n texels of one face, row-major; all faces are alike.
pub fn solid_angles(n: usize) -> Vec<f64> {
    // The solid angle of the rectangle from the middle of a face to (s, t), odd in both.
    let to_corner = |s: f64, t: f64| (s * t).atan2((s * s + t * t + 1.0).sqrt());
    let edge = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let texel = |x: usize, y: usize| {
        let ([left, right], [top, bottom]) = ([edge(x), edge(x + 1)], [edge(y), edge(y + 1)]);
        (to_corner(right, bottom) - to_corner(left, bottom)) - (to_corner(right, top) - to_corner(left, top))
    };
    (0..n * n).map(|i| texel(i % n, i / n)).collect()
}

/// Look-ups along each side of a texel of a cube of `n` texels a side, when a map of `width` columns is
/// resampled to it: a power of two, at least 4 and at least `width`/2n, which is twice the columns that a
/// texel in the middle of a face spans. So no texel of a map twice as wide as high is skipped below 45° of
/// latitude, and none of that size elsewhere; towards the poles a map's texels are narrower than can count.
pub fn subsamples(width: u32, n: usize) -> u32 {
    // At most half of `width`.
    let least = (width as usize).div_ceil(2 * n.max(1)) as u32;
    least.next_power_of_two().max(4)
}

/// Radiance on a cube of `n` texels a side, [6·n·n], of `map` turned by `rotation_deg` about +Y,
/// counter-clockwise seen from above.
///
/// Every step in f32, so that a shader can repeat it: texel (x, y) of `face` is Σ w·L / Σ w over the s × s
/// points i, j in 0..s, s = [`subsamples`]\(width, n\), rows j outside, where
///
/// * a = 2·(x + (i + ½)/s)/n − 1 and b = 2·(y + (j + ½)/s)/n − 1 are the point's place on the face, w = (1 +
///   a² + b²)^(−3/2) its share of the solid angle;
/// * d is the direction of (a, b) on the face, as the module's table has it, not normalised;
/// * e = (cos·d.x − sin·d.z, d.y, cos·d.z + sin·d.x) is d turned back by the map's rotation;
/// * u = ½ + atan2(e.x, −e.z)/2π, v = atan2(√(e.x² + e.z²), e.y)/π;
/// * L is the map's radiance at (u, v), interpolated between texels as [`EquirectMap::sample`] does, so that
///   light changes smoothly as the map turns.
pub fn from_equirect(map: &EquirectMap, rotation_deg: f32, n: usize) -> Vec<[f32; 3]> {
    let points = subsamples(map.width, n) as usize;
    let (sin, cos) = rotation_deg.to_radians().sin_cos();
    let radiance = |[x, y, z]: [f32; 3]| {
        let (x, z) = (cos * x - sin * z, cos * z + sin * x);
        let u = 0.5 + x.atan2(-z) * (0.5 * FRAC_1_PI);
        let v = (x * x + z * z).sqrt().atan2(y) * FRAC_1_PI;
        map.sample([u, v])
    };
    let place = |texel: usize, point: usize| {
        2.0 * (texel as f32 + (point as f32 + 0.5) / points as f32) / n as f32 - 1.0
    };
    let mean = |face: usize, x: usize, y: usize| {
        weighted_mean((0..points * points).map(|k| {
            let (a, b) = (place(x, k % points), place(y, k / points));
            ((1.0 + a * a + b * b).powf(-1.5), radiance(on_face(face, a, b)))
        }))
    };
    (0..FACES * n * n).map(|i| mean(i / (n * n), i % n, i / n % n)).collect()
}

/// The map of `width` × `height` texels that shows a cube of `n` texels a side, [6·n·n]: each texel the mean,
/// weighted by solid angle, of points in it that leave no texel of the cube out.
pub fn to_equirect(cube: &[[f32; 3]], n: usize, width: u32, height: u32) -> EquirectMap {
    // 8n columns are twice as dense as the cube's texels in the middle of a face.
    let points =
        |texels: u32, dense: usize| dense.div_ceil(texels.max(1) as usize).next_power_of_two().max(4);
    let (across, down) = (points(width, 8 * n), points(height, 4 * n));
    let mean = |x: usize, y: usize| {
        weighted_mean((0..across * down).map(|k| {
            let u = (x as f32 + ((k % across) as f32 + 0.5) / across as f32) / width as f32;
            let v = (y as f32 + ((k / across) as f32 + 0.5) / down as f32) / height as f32;
            let ((sin_phi, cos_phi), (sin_theta, cos_theta)) =
                ((TAU * (u - 0.5)).sin_cos(), (PI * v).sin_cos());
            let direction = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
            (sin_theta, cube.get(texel_of(direction, n)).copied().unwrap_or_default())
        }))
    };
    let columns = width as usize;
    let texels = (0..columns * height as usize).map(|i| mean(i % columns, i / columns)).collect();
    EquirectMap { width, height, texels }
}

/// Σ w·L / Σ w, summed in the order given.
fn weighted_mean(samples: impl Iterator<Item = (f32, [f32; 3])>) -> [f32; 3] {
    let mut sum = Vec3::ZERO;
    let mut weight = 0.0;
    for (w, radiance) in samples {
        sum += w * Vec3::from(radiance);
        weight += w;
    }
    (sum / weight).to_array()
}
