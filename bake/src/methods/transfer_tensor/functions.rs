//! How materials reflect: evenly, and by functions of the angles that tables are made of
//! ([`LobeTable`](super::LobeTable)), each with its share in the columns of a class.

use super::BASES;
use crate::brdf::blinn_phong;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::basis::microfacet::{self, Facets};
use relume_formats::kinds::BrdfBasis;
use relume_formats::state::{
    BlinnPhong, Brdf, CookTorrance, Ggx, Model, ROUGHNESS_MIN, Rgb, SHININESS_MAX, SLOPE_MIN,
};
use std::f32::consts::FRAC_1_PI;

/// Most functions of one material.
pub const MOST: usize = 8;
/// Most columns of one material.
pub const COLUMNS: usize = BASES + 2;
/// Most shares of functions in columns: three functions in three channels.
const SHARES: usize = 9;

/// Functions that change with directions, sr⁻¹. Fixed materials that are sharper than those that may vary are
/// taken to be as sharp as these: a texel of a light of 6×8×8 is wider.
#[derive(Debug, Clone, PartialEq)]
pub enum Functions {
    /// Those of a basis, from the given one on.
    Basis(Box<BrdfBasis>, usize),
    /// The unit lobe of an exponent.
    BlinnPhong(f32),
    /// The diffuse lobe beside a highlight, and the highlight's part at f₀ = 1 without Schlick's weight and
    /// with it, of a roughness.
    Ggx(f32),
    /// The unit lobe of a reflectance at normal incidence and a slope.
    CookTorrance(f32, f32),
}

impl Functions {
    /// Those of `basis` that are not the same everywhere.
    pub fn of_basis(basis: &BrdfBasis) -> Self {
        let first = usize::from(Self::is_diffuse_even(basis.functions.model()));
        Self::Basis(Box::new(basis.clone()), first)
    }

    /// Those of a fixed material, if it has any.
    pub fn of_fixed(brdf: &Brdf) -> Option<Self> {
        match brdf {
            _ if !brdf.has_highlight() => None,
            Brdf::BlinnPhong(brdf) => Some(Self::BlinnPhong(brdf.shininess.min(SHININESS_MAX))),
            Brdf::Ggx(brdf) => Some(Self::Ggx(brdf.roughness.max(ROUGHNESS_MIN))),
            Brdf::CookTorrance(brdf) => Some(Self::CookTorrance(brdf.fresnel, brdf.roughness.max(SLOPE_MIN))),
        }
    }

    /// GGX's diffuse function leaves out what highlights reflect; the others' is Lambert's.
    pub fn is_diffuse_even(model: Model) -> bool {
        model != Model::Ggx
    }

    /// How many there are, at most [`MOST`].
    pub fn count(&self) -> usize {
        match self {
            Self::Basis(basis, first) => basis.bases() - first,
            Self::BlinnPhong(_) | Self::CookTorrance(..) => 1,
            Self::Ggx(_) => 3,
        }
    }

    /// Their values; those beyond [`Functions::count`] are 0.
    pub fn evaluate(&self, angles: &Angles) -> [f32; MOST] {
        let mut values = [0.0; MOST];
        match self {
            Self::Basis(basis, first) => {
                let mut all = [0.0; MOST + 1];
                basis.evaluate(angles, &mut all[..basis.bases()]);
                let own = &all[*first..basis.bases()];
                values[..own.len()].copy_from_slice(own);
            }
            Self::BlinnPhong(shininess) => {
                let lobe = BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess: *shininess };
                values[0] = blinn_phong::evaluate(&lobe, Vec3A::ZERO, angles.cos_half).x;
            }
            Self::Ggx(roughness) => {
                let (w, lobe) =
                    (microfacet::schlick(angles.cos_difference), Facets::Ggx.lobe(*roughness, angles));
                values[..3].copy_from_slice(&[Facets::Ggx.diffuse(w), (1.0 - w) * lobe, w * lobe]);
            }
            Self::CookTorrance(fresnel, slope) => {
                let reflectance = fresnel + (1.0 - fresnel) * microfacet::schlick(angles.cos_difference);
                values[0] = reflectance * Facets::CookTorrance.lobe(*slope, angles);
            }
        }
        values
    }
}

/// What the columns of a class are made of.
#[derive(Debug, Clone, Copy)]
pub struct Terms {
    /// By column, the value that it has in all directions, sr⁻¹.
    pub even: [f32; COLUMNS],
    shares: [Share; SHARES],
    count: usize,
}

/// What of a function is in a column.
#[derive(Debug, Clone, Copy, Default)]
pub struct Share {
    /// Among those of the class.
    pub column: usize,
    /// Among those of the material.
    pub function: usize,
    /// Factor.
    pub of: f32,
}

impl Terms {
    /// Of a basis in `columns` columns, its diffuse function coloured by `albedo`, if given, in three of them.
    pub(super) fn varying(columns: usize, even: bool, albedo: Option<Vec3A>) -> Self {
        let mut terms = Self { even: [0.0; COLUMNS], shares: [Share::default(); SHARES], count: 0 };
        let diffuse = if albedo.is_some() { 3 } else { 1 };
        for column in 0..diffuse {
            let of = albedo.map_or(1.0, |albedo| albedo[column]);
            if even {
                terms.even[column] = FRAC_1_PI * of;
            } else {
                terms.add(column, 0, of);
            }
        }
        let first = usize::from(!even);
        (diffuse..columns).for_each(|column| terms.add(column, first + column - diffuse, 1.0));
        terms
    }

    /// Of a fixed material, whose columns are the channels.
    pub(super) fn fixed(brdf: &Brdf, albedo: Vec3A) -> Self {
        let mut terms = Self { even: [0.0; COLUMNS], shares: [Share::default(); SHARES], count: 0 };
        let lambert = |kd: Rgb| (Vec3A::from(kd) * albedo * FRAC_1_PI).to_array();
        match brdf {
            Brdf::BlinnPhong(BlinnPhong { kd, ks, .. }) | Brdf::CookTorrance(CookTorrance { kd, ks, .. }) => {
                terms.even[..3].copy_from_slice(&lambert(*kd));
                if brdf.has_highlight() {
                    (0..3).for_each(|c| terms.add(c, 0, ks[c]));
                }
            }
            Brdf::Ggx(brdf) => {
                let base_color = (Vec3A::from(brdf.base_color) * albedo).to_array();
                let brdf = Ggx { base_color, ..*brdf };
                let (diffuse, f0) = (brdf.diffuse(), brdf.f0());
                for c in 0..3 {
                    [diffuse[c], f0[c], 1.0].into_iter().enumerate().for_each(|(k, of)| terms.add(c, k, of));
                }
            }
        }
        terms
    }

    fn add(&mut self, column: usize, function: usize, of: f32) {
        self.shares[self.count] = Share { column, function, of };
        self.count += 1;
    }

    /// What the columns have of functions.
    pub fn shares(&self) -> &[Share] {
        &self.shares[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf;
    use crate::trace::sampler::PixelSampler;

    /// Functions and shares make the very BRDF, textured or not.
    #[test]
    fn fixed_materials_are_their_brdf() {
        let materials = [
            Brdf::BlinnPhong(BlinnPhong { kd: [0.3, 0.2, 0.1], ks: [0.4, 0.5, 0.6], shininess: 30.0 }),
            Brdf::BlinnPhong(BlinnPhong { kd: [0.3, 0.2, 0.1], ks: [0.0; 3], shininess: 30.0 }),
            Brdf::Ggx(Ggx { base_color: [0.9, 0.5, 0.2], metallic: 0.4, roughness: 0.4 }),
            Brdf::CookTorrance(CookTorrance {
                kd: [0.3, 0.2, 0.1],
                ks: [0.4, 0.5, 0.6],
                fresnel: 0.2,
                roughness: 0.3,
            }),
        ];
        for (number, brdf) in materials.iter().enumerate() {
            let functions = Functions::of_fixed(brdf);
            assert_eq!(functions.is_some(), brdf.has_highlight());
            for k in 0..100 {
                let sample = PixelSampler::new(3, number as u32).sample(k);
                let at = |pair: u32| {
                    let [u, z] = sample.pair(pair);
                    let (sin, phi) = ((1.0 - z * z).sqrt(), std::f32::consts::TAU * u);
                    Vec3A::new(sin * phi.cos(), sin * phi.sin(), z)
                };
                let angles = brdf::angles(at(0), at(1), Vec3A::Z);
                let albedo = Vec3A::new(0.2, 0.9, sample.pair(2)[0]);
                let values = functions.as_ref().map_or([0.0; MOST], |f| f.evaluate(&angles));
                let terms = Terms::fixed(brdf, albedo);
                let mut found = terms.even;
                terms
                    .shares()
                    .iter()
                    .for_each(|share| found[share.column] += share.of * values[share.function]);
                let exact = brdf::evaluate(brdf, albedo, &angles);
                for c in 0..3 {
                    assert!((found[c] - exact[c]).abs() < 2e-6 * (1.0 + exact[c]), "{brdf:?} {angles:?}");
                }
            }
        }
    }
}
