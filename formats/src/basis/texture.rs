//! Textures of surfaces: what multiplies a diffuse colour, and where a surface has holes.

use serde::{Deserialize, Serialize};

/// How a texture goes on beyond its edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Wrap {
    /// It starts again.
    Repeat,
    /// It is mirrored.
    Mirror,
    /// Its edge texels go on.
    Clamp,
}

/// What lies between the centres of texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Filter {
    /// One texel flows into the next.
    Linear,
    /// Every texel is a sharp rectangle of its own colour.
    Nearest,
}

/// An image on a surface. The first row lies at v = 0, as in glTF.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Texels per row, and rows.
    pub size: [u32; 2],
    /// Along u and along v.
    pub wrap: [Wrap; 2],
    /// Between texel centres.
    pub filter: Filter,
    /// Row-major red, green, blue (sRGB-encoded) and alpha (linear).
    pub texels: Vec<[u8; 4]>,
}

impl Texture {
    /// Linear red, green and blue, and alpha, each in 0..=1, at texture coordinates `uv`; between texel
    /// centres as the filter says.
    pub fn sample(&self, uv: [f32; 2]) -> [f32; 4] {
        if self.filter == Filter::Nearest {
            let [x, y] = std::array::from_fn(|axis| nearest(uv[axis], self.size[axis], self.wrap[axis]));
            return self.texel(x, y);
        }
        let [(x0, x1, fx), (y0, y1, fy)] =
            std::array::from_fn(|axis| neighbours(uv[axis], self.size[axis], self.wrap[axis]));
        let [a, b, c, d] = [self.texel(x0, y0), self.texel(x1, y0), self.texel(x0, y1), self.texel(x1, y1)];
        std::array::from_fn(|k| {
            let (top, bottom) = (a[k] + (b[k] - a[k]) * fx, c[k] + (d[k] - c[k]) * fx);
            top + (bottom - top) * fy
        })
    }

    fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let [r, g, b, a] = self.texels.get((y * self.size[0] + x) as usize).copied().unwrap_or([255; 4]);
        [linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), f32::from(a) / 255.0]
    }
}

/// The texel that a coordinate falls on.
fn nearest(coordinate: f32, count: u32, wrap: Wrap) -> u32 {
    wrapped((coordinate * count as f32).floor() as i64, i64::from(count), wrap) as u32
}

/// The texels on either side of a coordinate, and how far it is from the first to the second.
fn neighbours(coordinate: f32, count: u32, wrap: Wrap) -> (u32, u32, f32) {
    // Coordinates that are no numbers, or so large that they have no fraction left, fall somewhere legal.
    let position = coordinate * count as f32 - 0.5;
    let floor = position.floor();
    let texel = |index: f32| wrapped(index as i64, i64::from(count), wrap) as u32;
    let share = if position.is_finite() { position - floor } else { 0.0 };
    (texel(floor), texel(floor + 1.0), share)
}

fn wrapped(index: i64, count: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => index.rem_euclid(count),
        Wrap::Clamp => index.clamp(0, count - 1),
        Wrap::Mirror => {
            let within = index.rem_euclid(2 * count);
            within.min(2 * count - 1 - within)
        }
    }
}

/// One channel, sRGB to linear (IEC 61966-2-1).
pub fn linear_from_srgb(byte: u8) -> f32 {
    static TABLE: std::sync::LazyLock<[f32; 256]> =
        std::sync::LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb_unit(i as f64 / 255.0) as f32));
    TABLE[usize::from(byte)]
}

/// One channel, sRGB from 0 to 1 (IEC 61966-2-1), to linear.
pub fn linear_from_srgb_unit(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// One channel, linear in 0..=1 to sRGB (IEC 61966-2-1), rounded to 8 bits; what is below is 0, what is above
/// 255, and what is no number 0.
pub fn srgb_from_linear(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(wrap: Wrap) -> Texture {
        let texels = (0..8).map(|i| [0, 0, 0, [0, 51, 102, 153, 204, 255, 204, 153][i]]).collect();
        Texture { size: [4, 2], wrap: [wrap, Wrap::Clamp], filter: Filter::Linear, texels }
    }

    #[test]
    fn the_nearest_texel_is_a_sharp_rectangle() {
        for (wrap, beyond) in
            [(Wrap::Clamp, [0.0, 0.6]), (Wrap::Repeat, [0.6, 0.0]), (Wrap::Mirror, [0.0, 0.6])]
        {
            let sharp = Texture { filter: Filter::Nearest, ..ramp(wrap) };
            let alpha = |u, v| sharp.sample([u, v])[3];
            let within = [0.0, 0.01, 0.249, 0.25, 0.499, 0.5, 0.75, 0.999].map(|u| alpha(u, 0.499));
            assert_eq!(within, [0.0, 0.0, 0.0, 0.2, 0.2, 0.4, 0.6, 0.6]);
            assert_eq!([alpha(0.1, 0.5), alpha(0.3, 0.99)], [0.8, 1.0]);
            assert_eq!([alpha(-0.1, 0.25), alpha(1.1, 0.25)], beyond);
        }
    }

    #[test]
    fn texel_centres_are_exact_and_between_them_it_is_linear() {
        let texture = ramp(Wrap::Clamp);
        for (uv, alpha) in [
            ([0.125, 0.25], 0.0),
            ([0.375, 0.25], 0.2),
            ([0.25, 0.25], 0.1),
            ([0.125, 0.75], 0.8),
            ([0.125, 0.5], 0.4),
        ] {
            assert!((texture.sample(uv)[3] - alpha).abs() < 1e-6, "{uv:?}");
        }
    }

    #[test]
    fn beyond_the_edge_it_repeats_mirrors_or_stays() {
        let alpha = |wrap, u| ramp(wrap).sample([u, 0.25])[3];
        for u in [0.125, 0.3, 0.875] {
            assert!((alpha(Wrap::Repeat, u + 3.0) - alpha(Wrap::Repeat, u)).abs() < 1e-5);
            assert!((alpha(Wrap::Mirror, -u) - alpha(Wrap::Mirror, u)).abs() < 1e-5);
            assert!((alpha(Wrap::Mirror, 2.0 - u) - alpha(Wrap::Mirror, u)).abs() < 1e-5);
        }
        assert_eq!([alpha(Wrap::Clamp, -5.0), alpha(Wrap::Clamp, 9.0)], [0.0, 0.6]);
        assert!((alpha(Wrap::Repeat, 0.0) - 0.3).abs() < 1e-6, "half of the last and half of the first");
    }

    #[test]
    fn no_coordinate_is_too_strange() {
        for u in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, f32::MIN_POSITIVE] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                for filter in [Filter::Linear, Filter::Nearest] {
                    let sample = Texture { filter, ..ramp(wrap) }.sample([u, u]);
                    assert!(sample.iter().all(|x| x.is_nan() || (0.0..=1.0).contains(x)));
                }
            }
        }
    }

    #[test]
    fn srgb_meets_its_definition() {
        assert_eq!((linear_from_srgb(0), linear_from_srgb(255)), (0.0, 1.0));
        // 188/255 is middle: sRGB 0.7372549 is 0.5028865 linear.
        assert!((linear_from_srgb(188) - 0.502_886_5).abs() < 1e-6);
    }

    #[test]
    fn known_points_of_the_curve() {
        // 0.5 encodes to 187.5 within a hundredth: 1.055·0.5^(1/2.4) − 0.055 = 0.735357.
        for (linear, expected) in [
            (0.0, 0),
            (1.0, 255),
            (0.5, 188),
            (0.001, 3),
            (0.215_860_5, 128),
            (0.003_130_8, 10),
            (-1.0, 0),
            (2.0, 255),
        ] {
            assert_eq!(srgb_from_linear(linear), expected, "{linear}");
        }
    }

    #[test]
    fn every_8_bit_value_survives_the_way_there_and_back() {
        (0..=255).for_each(|value| assert_eq!(srgb_from_linear(linear_from_srgb(value)), value));
    }
}
