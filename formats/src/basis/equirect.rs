//! Equirectangular maps.

use crate::state::Rgb;
use glam::Vec3;

/// Radiance by direction: (x, y, z) is found at u = 0.5 + atan2(x, −z)/2π, v = acos(y)/π.
#[derive(Debug, Clone, PartialEq)]
pub struct EquirectMap {
    /// Texels per row.
    pub width: u32,
    /// Rows, from +Y down.
    pub height: u32,
    /// Row-major linear RGB radiance, W/(sr·m²), finite and not negative.
    pub texels: Vec<Rgb>,
}

impl EquirectMap {
    /// Radiance at (u, v), each in 0..=1, linear between texel centres; columns go round, rows end at the
    /// poles.
    pub fn sample(&self, [u, v]: [f32; 2]) -> Rgb {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let column = |offset: i64| (x0 as i64 + offset).rem_euclid(i64::from(self.width.max(1))) as usize;
        let row = |offset: i64| (y0 as i64 + offset).clamp(0, i64::from(self.height.max(1)) - 1) as usize;
        let texel = |dx, dy| {
            Vec3::from(
                self.texels.get(row(dy) * self.width as usize + column(dx)).copied().unwrap_or_default(),
            )
        };
        let (top, bottom) = (texel(0, 0).lerp(texel(1, 0), x - x0), texel(0, 1).lerp(texel(1, 1), x - x0));
        top.lerp(bottom, y - y0).to_array()
    }

    /// The map at no more than `max_width` columns: each texel the mean, by solid angle, of the texels that
    /// it replaces.
    pub fn reduced(&self, max_width: u32) -> Self {
        let factor = self.width.div_ceil(max_width.max(1)) as usize;
        if factor <= 1 {
            return self.clone();
        }
        let (width, height) =
            ((self.width as usize).div_ceil(factor), (self.height as usize).div_ceil(factor));
        let band = |row: usize| {
            let cos = |row: usize| (std::f64::consts::PI * row as f64 / f64::from(self.height)).cos();
            (cos(row) - cos(row + 1)) as f32
        };
        let span = |i: usize, count: u32| i * factor..((i + 1) * factor).min(count as usize);
        let texel = |i: usize| {
            let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
            for row in span(i / width, self.height) {
                for column in span(i % width, self.width) {
                    sum += band(row) * Vec3::from(self.texels[row * self.width as usize + column]);
                    weight += band(row);
                }
            }
            (sum / weight).to_array()
        };
        Self { width: width as u32, height: height as u32, texels: (0..width * height).map(texel).collect() }
    }
}
