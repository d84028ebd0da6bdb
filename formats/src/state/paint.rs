//! Materials painted over a surface: three textures say at every point what a material says once.

use super::{BlinnPhong, Brdf, CookTorrance, Ggx, Model, Rgb};
use crate::error::{Error, Place, Result};

/// Most texels on a side.
pub const MAX_PAINT_SIDE: u32 = 2048;

/// What of a material a texture says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layer {
    /// kd, or the base colour.
    Colour,
    /// ks, or what part is metal.
    Gloss,
    /// Exponent, roughness or slope.
    Sharpness,
}

impl Layer {
    /// All of them, in the order of a [`Texel`].
    pub const ALL: [Self; 3] = [Self::Colour, Self::Gloss, Self::Sharpness];

    /// The key of a state that it stands for.
    pub fn key(self, model: Model) -> &'static str {
        match (self, model) {
            (Self::Colour, Model::Ggx) => "base_color",
            (Self::Colour, _) => "kd",
            (Self::Gloss, Model::Ggx) => "metallic",
            (Self::Gloss, _) => "ks",
            (Self::Sharpness, Model::BlinnPhong) => "shininess",
            (Self::Sharpness, _) => "roughness",
        }
    }

    /// Whether pictures of 8 or 16 bits hold it as they hold colours, sRGB-encoded; else evenly.
    pub fn is_colour(self, model: Model) -> bool {
        self == Self::Colour || (self == Self::Gloss && model != Model::Ggx)
    }

    /// What black and white of such pictures stand for, after decoding.
    ///
    /// Exponents are spread by their logarithm, as they look: black is 1, and white the `sharpest`.
    pub fn from_unit(self, model: Model, sharpest: f32, unit: f32) -> f32 {
        match (self, model) {
            (Self::Sharpness, Model::BlinnPhong) => sharpest.powf(unit),
            _ => unit,
        }
    }
}

/// What the textures of a material say at one point, by [`Layer`], each for every channel.
pub type Texel = [Rgb; 3];

/// A material over a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Paint {
    /// Says the model, and what no texture says.
    pub brdf: Brdf,
    /// Whether the scene's texture, which multiplies the material's own colour, is left out: another stands in
    /// its place.
    pub replaces_texture: bool,
    /// Texels per row, and rows.
    pub size: [u32; 2],
    /// Row by row from the upper left corner of the square of texture coordinates.
    pub texels: Vec<Texel>,
}

impl Paint {
    /// The same material everywhere, on `size` texels.
    pub fn uniform(brdf: &Brdf, size: [u32; 2]) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self { brdf: *brdf, replaces_texture: false, size, texels: vec![texel_of(brdf); count] }
    }

    /// What the textures say at texture coordinates `uv`: linear between the centres of texels, and beyond the
    /// outer ones as these have it.
    pub fn at(&self, uv: [f32; 2]) -> Texel {
        let texel =
            |x: u32, y: u32| self.texels.get((y * self.size[0] + x) as usize).copied().unwrap_or_default();
        let corners = Corners::at(uv, self.size, texel);
        std::array::from_fn(|layer| corners.mean(|texel| texel[layer]))
    }

    /// Makes the texture of `layer` one of `size` texels, row by row, brought to the size of the paint: linear
    /// between the centres of texels.
    pub fn set(&mut self, layer: Layer, size: [u32; 2], values: &[Rgb]) {
        let [width, height] = self.size;
        let place = layer as usize;
        let at = |x: u32, y: u32| values.get((y * size[0] + x) as usize).copied().unwrap_or_default();
        // By itself no texel is moved by a rounding error.
        let is_as_large = self.size == size;
        for (index, texel) in (0..).zip(&mut self.texels) {
            let (x, y) = (index % width, index / width);
            let middle = [(x, width), (y, height)].map(|(at, count)| (at as f32 + 0.5) / count as f32);
            texel[place] =
                if is_as_large { at(x, y) } else { Corners::at(middle, size, at).mean(|value| *value) };
        }
    }

    /// Checks that every texel is a material that may vary, its lobe no sharper than `sharpest`. `name` is the
    /// material's.
    ///
    /// # Errors
    /// `Invalid` with the first texel that is not.
    pub fn validate(&self, sharpest: f32, name: &str, place: &Place) -> Result<()> {
        let refuse = |reason: String| Err(Error::invalid(place, format!("material `{name}`: {reason}")));
        let [width, height] = self.size;
        if !self.size.iter().all(|side| (1..=MAX_PAINT_SIDE).contains(side))
            || self.texels.len() as u64 != u64::from(width) * u64::from(height)
        {
            return refuse(format!("its textures must be of 1 to {MAX_PAINT_SIDE} texels a side"));
        }
        let checked = |texel: &Texel, place: &Place| {
            self.brdf.channels(texel).iter().try_for_each(|brdf| {
                brdf.validate(name, place)?;
                brdf.validate_varying(false, sharpest, name, place)
            })
        };
        if let Some(index) = self.texels.iter().position(|texel| checked(texel, place).is_err()) {
            let [x, y] = [index % width as usize, index / width as usize];
            return checked(
                &self.texels[index],
                &place.part(format!("texel ({x}, {y}) of {width} × {height}")),
            );
        }
        Ok(())
    }
}

impl Brdf {
    /// This material with what a texel says, for each channel: of the first only the red part is meant, of the
    /// second the green one, and of the third the blue one.
    pub fn channels(&self, [colour, gloss, sharpness]: &Texel) -> [Self; 3] {
        std::array::from_fn(|channel| match *self {
            Self::BlinnPhong(_) => {
                Self::BlinnPhong(BlinnPhong { kd: *colour, ks: *gloss, shininess: sharpness[channel] })
            }
            Self::Ggx(_) => Self::Ggx(Ggx {
                base_color: *colour,
                metallic: gloss[channel],
                roughness: sharpness[channel],
            }),
            Self::CookTorrance(brdf) => Self::CookTorrance(CookTorrance {
                kd: *colour,
                ks: *gloss,
                roughness: sharpness[channel],
                ..brdf
            }),
        })
    }
}

/// The texel that says what `brdf` says.
pub fn texel_of(brdf: &Brdf) -> Texel {
    match *brdf {
        Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) => [kd, ks, [shininess; 3]],
        Brdf::Ggx(Ggx { base_color, metallic, roughness }) => [base_color, [metallic; 3], [roughness; 3]],
        Brdf::CookTorrance(CookTorrance { kd, ks, roughness, .. }) => [kd, ks, [roughness; 3]],
    }
}

/// The four texels around a place, and how far it is from the first to the others along each axis.
struct Corners<T> {
    texels: [T; 4],
    way: [f32; 2],
}

impl<T: Copy> Corners<T> {
    fn at(uv: [f32; 2], size: [u32; 2], texel: impl Fn(u32, u32) -> T) -> Self {
        let [(x0, x1, fx), (y0, y1, fy)] = std::array::from_fn(|axis| neighbours(uv[axis], size[axis]));
        Self { texels: [texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)], way: [fx, fy] }
    }

    /// What `of` texels becomes in between.
    fn mean(&self, of: impl Fn(&T) -> Rgb) -> Rgb {
        let ([fx, fy], values) = (self.way, self.texels.each_ref().map(of));
        std::array::from_fn(|channel| {
            let [a, b, c, d] = values.map(|value| value[channel]);
            let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
            top + (bottom - top) * fy
        })
    }
}

/// The texels on either side of a coordinate, and how far it is from the first to the second.
fn neighbours(coordinate: f32, count: u32) -> (u32, u32, f32) {
    let last = count.saturating_sub(1);
    // What is no number is the first texel.
    let position = (coordinate * count as f32 - 0.5).max(0.0).min(last as f32);
    let first = position as u32;
    (first, (first + 1).min(last), position - first as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BRDF: Brdf =
        Brdf::BlinnPhong(BlinnPhong { kd: [0.1, 0.2, 0.3], ks: [0.4, 0.3, 0.2], shininess: 20.0 });

    #[test]
    fn uniform_paint_says_everywhere_what_its_material_says() {
        let paint = Paint::uniform(&BRDF, [3, 2]);
        for uv in [[0.0, 0.0], [0.3, 0.9], [1.0, 1.0], [-5.0, f32::NAN]] {
            assert_eq!(paint.brdf.channels(&paint.at(uv)), [BRDF; 3]);
        }
    }

    #[test]
    fn texels_flow_into_each_other_and_stay_at_the_edge() {
        let mut paint = Paint::uniform(&BRDF, [2, 1]);
        paint.texels[1][0] = [0.5, 0.6, 0.7];
        assert_eq!(paint.at([0.25, 0.5])[0], [0.1, 0.2, 0.3]);
        assert_eq!(paint.at([0.0, 0.0])[0], [0.1, 0.2, 0.3]);
        assert_eq!(paint.at([1.0, 0.2])[0], [0.5, 0.6, 0.7]);
        let [red, ..] = paint.at([0.5, 0.5])[0];
        assert!((red - 0.3).abs() < 1e-6, "{red}");
    }

    #[test]
    fn channels_have_lobes_of_their_own() {
        let texel = [[0.1; 3], [0.2; 3], [5.0, 50.0, 100.0]];
        let sharpness = BRDF.channels(&texel).map(|brdf| match brdf {
            Brdf::BlinnPhong(brdf) => brdf.shininess,
            _ => 0.0,
        });
        assert_eq!(sharpness, [5.0, 50.0, 100.0]);
    }

    #[test]
    fn a_texel_that_reflects_too_much_is_named() {
        let mut paint = Paint::uniform(&BRDF, [4, 4]);
        paint.texels[6][1] = [0.9; 3];
        let error = paint.validate(200.0, "wall", &Place::file("s.toml")).unwrap_err().to_string();
        assert!(error.contains("texel (2, 1) of 4 × 4") && error.contains("kd + ks"), "{error}");
    }
}
