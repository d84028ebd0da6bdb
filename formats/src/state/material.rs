//! Material parameters and their legal range.

use super::{MaterialState, Rgb};
use crate::error::{Error, Place, Result};
use serde::{Deserialize, Serialize};

/// Smallest exponent of the Blinn-Phong space.
pub const SHININESS_MIN: f32 = 1.0;
/// Largest exponent that a material may be edited to, unless a scene asks for more.
pub const SHININESS_MAX: f32 = 200.0;
/// Largest exponent that a scene may ask for: sharper lobes need more bases than are offered.
pub const ASKED_SHININESS_MAX: f32 = 5_000.0;
/// Largest exponent of a material that does not vary; it meets no basis, and only single precision limits it.
pub const FIXED_SHININESS_MAX: f32 = 10_000.0;
/// Smallest roughness that a material may be edited to, unless a scene asks for less: a lobe about as wide as
/// that of exponent [`SHININESS_MAX`].
pub const ROUGHNESS_MIN: f32 = 0.32;
/// Smallest roughness that a scene may ask for, about as sharp as [`ASKED_SHININESS_MAX`].
pub const ASKED_ROUGHNESS_MIN: f32 = 0.14;
/// Smallest roughness of a material that does not vary, about as sharp as [`FIXED_SHININESS_MAX`].
pub const FIXED_ROUGHNESS_MIN: f32 = 0.12;
/// Smallest slope of Cook-Torrance that a material may be edited to, unless a scene asks for less: a lobe about
/// as wide as that of exponent [`SHININESS_MAX`].
pub const SLOPE_MIN: f32 = 0.1;
/// Smallest slope that a scene may ask for, about as sharp as [`ASKED_SHININESS_MAX`].
pub const ASKED_SLOPE_MIN: f32 = 0.02;
/// Smallest slope of a material that does not vary, about as sharp as [`FIXED_SHININESS_MAX`].
pub const FIXED_SLOPE_MIN: f32 = 0.015;
/// Normal-incidence reflectance of everything that is no metal (glTF 2.0, appendix B).
pub const DIELECTRIC_F0: f32 = 0.04;

/// The reflectance models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// See [`BlinnPhong`].
    BlinnPhong,
    /// See [`Ggx`].
    Ggx,
    /// See [`CookTorrance`].
    CookTorrance,
}

impl Model {
    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::BlinnPhong => "blinn-phong",
            Self::Ggx => "ggx",
            Self::CookTorrance => "cook-torrance",
        }
    }

    /// The sharpest lobe that a material of this model may be edited to where scenes ask for no sharper one: an
    /// exponent, roughness or slope.
    pub fn usual_sharpest(self) -> f32 {
        match self {
            Self::BlinnPhong => SHININESS_MAX,
            Self::Ggx => ROUGHNESS_MIN,
            Self::CookTorrance => SLOPE_MIN,
        }
    }

    /// The sharpest lobe that a scene may ask for.
    pub fn most_sharpest(self) -> f32 {
        match self {
            Self::BlinnPhong => ASKED_SHININESS_MAX,
            Self::Ggx => ASKED_ROUGHNESS_MIN,
            Self::CookTorrance => ASKED_SLOPE_MIN,
        }
    }

    /// What lobes may be edited to, the sharpest being `sharpest`: from the least number to the largest.
    pub fn editable(self, sharpest: f32) -> [f32; 2] {
        match self {
            Self::BlinnPhong => [SHININESS_MIN, sharpest],
            Self::Ggx | Self::CookTorrance => [sharpest, 1.0],
        }
    }

    /// Checks that scenes may ask for lobes as sharp as `sharpest`, but no blunter than they may be without
    /// asking.
    ///
    /// # Errors
    /// The range, in words.
    pub fn expect_sharpest(self, sharpest: f32) -> std::result::Result<(), String> {
        let (usual, most) = (self.usual_sharpest(), self.most_sharpest());
        let (low, high) = (usual.min(most), usual.max(most));
        if (low..=high).contains(&sharpest) {
            return Ok(());
        }
        Err(format!("{sharpest} is outside {low}..{high} of materials that are \"{}\"", self.name()))
    }

    /// The leaves of a state that belong to the model.
    fn leaves(self) -> &'static str {
        match self {
            Self::BlinnPhong => "kd, ks and shininess",
            Self::Ggx => "base_color, metallic and roughness",
            Self::CookTorrance => "kd, ks, fresnel and roughness",
        }
    }
}

/// The parameters of one material, of whichever model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Brdf {
    /// The thesis' model.
    BlinnPhong(BlinnPhong),
    /// glTF's model.
    Ggx(Ggx),
    /// The model of measured materials.
    CookTorrance(CookTorrance),
}

/// The normalised Blinn-Phong BRDF, ρ = kd/π + ks·(s+2)/(2π)·cosˢδ with δ between the half vector and the
/// normal (thesis eq. 4-15).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BlinnPhong {
    /// Diffuse reflectance per channel.
    pub kd: Rgb,
    /// Glossy reflectance per channel.
    pub ks: Rgb,
    /// Exponent s, from [`SHININESS_MIN`] on.
    pub shininess: f32,
}

/// The metallic-roughness BRDF of glTF 2.0 (appendix B.3.5): with α = roughness², the Trowbridge-Reitz
/// distribution D, Smith's height-correlated visibility V, c = base_color·(1 − metallic), f₀ = 0.04·(1 −
/// metallic) + base_color·metallic and w = (1 − v·h)⁵, ρ = (1 − F)·c/π + F·D·V, F = f₀ + (1 − f₀)·w. The
/// appendix prints the separable visibility, which masks and shadows the same facets twice; the correlated
/// one (Heitz 2014) is what reference viewers draw.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ggx {
    /// Reflectance per channel: diffuse where the material is no metal, specular where it is.
    pub base_color: Rgb,
    /// 0 for dielectrics, 1 for metals.
    pub metallic: f32,
    /// Perceptual roughness; α is its square.
    pub roughness: f32,
}

/// The BRDF of Cook and Torrance (1981): ρ = kd/π + ks·F·D·V with F = fresnel + (1 − fresnel)·(1 − v·h)⁵, D
/// Beckmann's distribution of facets and V = G/(4 (n·l)(n·v)), see
/// [`crate::basis::microfacet::beckmann_grooves`].
///
/// The paper, and the thesis after it (eq. 2-12), divide by π where facets that are all counted once ask for
/// 4π (Walter et al. 2007): four times their ks is ours, and no material reflects more than it receives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CookTorrance {
    /// Diffuse reflectance per channel.
    pub kd: Rgb,
    /// Reflectance of the facets at grazing incidence, per channel.
    pub ks: Rgb,
    /// How much of `ks` facets reflect at normal incidence.
    pub fresnel: f32,
    /// Root mean square slope m of the facets.
    pub roughness: f32,
}

impl Brdf {
    /// The model.
    pub fn model(&self) -> Model {
        match self {
            Self::BlinnPhong(_) => Model::BlinnPhong,
            Self::Ggx(_) => Model::Ggx,
            Self::CookTorrance(_) => Model::CookTorrance,
        }
    }

    /// What a Lambert surface that stands in for this material reflects: the diffuse part, highlights left
    /// out.
    pub fn diffuse_albedo(&self) -> Rgb {
        match self {
            Self::BlinnPhong(brdf) => brdf.kd,
            Self::Ggx(brdf) => brdf.diffuse(),
            Self::CookTorrance(brdf) => brdf.kd,
        }
    }

    /// Whether the material reflects anything but its diffuse part.
    pub fn has_highlight(&self) -> bool {
        match self {
            Self::BlinnPhong(brdf) => brdf.ks != [0.0; 3],
            Self::Ggx(_) => true,
            Self::CookTorrance(brdf) => brdf.ks != [0.0; 3],
        }
    }

    /// This material with the leaves that `change` names replaced. `name` is used in messages.
    ///
    /// # Errors
    /// `Invalid` for a leaf of another model, or a value out of its range.
    pub fn with(&self, change: &MaterialState, name: &str, place: &Place) -> Result<Self> {
        let brdf = self.replaced(change, name, place)?;
        brdf.validate(name, place)?;
        Ok(brdf)
    }

    /// [`Brdf::with`] before any range is checked.
    pub(crate) fn replaced(&self, change: &MaterialState, name: &str, place: &Place) -> Result<Self> {
        if let Some(stranger) = change.leaf_not_of(self.model()) {
            let (model, leaves) = (self.model().name(), self.model().leaves());
            return Err(Error::invalid(
                place,
                format!("material `{name}`: is \"{model}\", which has {leaves}, not `{stranger}`"),
            ));
        }
        Ok(match *self {
            Self::BlinnPhong(old) => Self::BlinnPhong(BlinnPhong {
                kd: change.kd.unwrap_or(old.kd),
                ks: change.ks.unwrap_or(old.ks),
                shininess: change.shininess.unwrap_or(old.shininess),
            }),
            Self::Ggx(old) => Self::Ggx(Ggx {
                base_color: change.base_color.unwrap_or(old.base_color),
                metallic: change.metallic.unwrap_or(old.metallic),
                roughness: change.roughness.unwrap_or(old.roughness),
            }),
            Self::CookTorrance(old) => Self::CookTorrance(CookTorrance {
                kd: change.kd.unwrap_or(old.kd),
                ks: change.ks.unwrap_or(old.ks),
                fresnel: change.fresnel.unwrap_or(old.fresnel),
                roughness: change.roughness.unwrap_or(old.roughness),
            }),
        })
    }

    /// What undoes `change` on this material: the leaves that it names, as they are here.
    pub fn inverse(&self, change: &MaterialState) -> MaterialState {
        let now = MaterialState::from(*self);
        MaterialState {
            kd: now.kd.filter(|_| change.kd.is_some()),
            ks: now.ks.filter(|_| change.ks.is_some()),
            shininess: now.shininess.filter(|_| change.shininess.is_some()),
            fresnel: now.fresnel.filter(|_| change.fresnel.is_some()),
            base_color: now.base_color.filter(|_| change.base_color.is_some()),
            metallic: now.metallic.filter(|_| change.metallic.is_some()),
            roughness: now.roughness.filter(|_| change.roughness.is_some()),
            ..now
        }
    }

    /// Checks everything that must hold for any material: for Blinn-Phong and Cook-Torrance kd, ks ≥ 0 and kd +
    /// ks ≤ 1 (thesis eq. 4-16), shares within 0..1, for GGX a colour, too, and lobes no sharper than single
    /// precision can follow.
    pub fn validate(&self, name: &str, place: &Place) -> Result<()> {
        let checked = match self {
            Self::BlinnPhong(brdf) => {
                check_sum(&brdf.kd, &brdf.ks).and_then(|()| SHININESS.check(brdf.shininess))
            }
            Self::Ggx(brdf) => brdf.check().and_then(|()| ROUGHNESS.check(brdf.roughness)),
            Self::CookTorrance(brdf) => brdf.check().and_then(|()| SLOPE.check(brdf.roughness)),
        };
        checked.map_err(|reason| Error::invalid(place, format!("material `{name}`: {reason}")))
    }

    /// Checks what must hold besides for a material that varies: that its lobe is within the range that bases
    /// span, no sharper than `sharpest`. `textured` says that a texture multiplies its diffuse colour.
    pub fn validate_varying(&self, textured: bool, sharpest: f32, name: &str, place: &Place) -> Result<()> {
        let checked = match self {
            Self::BlinnPhong(brdf) => SHININESS.check_varying(brdf.shininess, sharpest),
            Self::Ggx(brdf) if textured && brdf.metallic > 0.0 => Err(format!(
                "metallic {} with a textured base colour, whose product with itself no image of a linear bake holds; set metallic to 0 or remove \
                 the texture",
                brdf.metallic
            )),
            Self::Ggx(brdf) => ROUGHNESS.check_varying(brdf.roughness, sharpest),
            Self::CookTorrance(brdf) => SLOPE.check_varying(brdf.roughness, sharpest),
        };
        checked.map_err(|reason| Error::invalid(place, format!("material `{name}`: {reason}")))
    }
}

/// The state that sets every leaf of a material.
impl From<Brdf> for MaterialState {
    fn from(brdf: Brdf) -> Self {
        match brdf {
            Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) => {
                Self { kd: Some(kd), ks: Some(ks), shininess: Some(shininess), ..Self::default() }
            }
            Brdf::Ggx(Ggx { base_color, metallic, roughness }) => Self {
                base_color: Some(base_color),
                metallic: Some(metallic),
                roughness: Some(roughness),
                ..Self::default()
            },
            Brdf::CookTorrance(CookTorrance { kd, ks, fresnel, roughness }) => Self {
                kd: Some(kd),
                ks: Some(ks),
                fresnel: Some(fresnel),
                roughness: Some(roughness),
                ..Self::default()
            },
        }
    }
}

/// The sharpness of a lobe, and what it may be: bases follow only the blunter ones.
struct Sharpness {
    model: Model,
    key: &'static str,
    /// The key of `[vary]` with which scenes ask for sharper ones.
    asked_by: &'static str,
    /// Of a material that does not vary.
    fixed: [f32; 2],
}

const SHININESS: Sharpness = Sharpness {
    model: Model::BlinnPhong,
    key: "shininess",
    asked_by: "shininess_max",
    fixed: [SHININESS_MIN, FIXED_SHININESS_MAX],
};
const ROUGHNESS: Sharpness = Sharpness {
    model: Model::Ggx,
    key: "roughness",
    asked_by: "roughness_min",
    fixed: [FIXED_ROUGHNESS_MIN, 1.0],
};
const SLOPE: Sharpness = Sharpness {
    model: Model::CookTorrance,
    key: "roughness",
    asked_by: "roughness_min",
    fixed: [FIXED_SLOPE_MIN, 1.0],
};

/// Why materials that vary may not be as sharp as others.
const WHY: &str = "as bases follow no sharper lobe";

/// All ranges are told at once: who corrects a value should not meet the other one next.
impl Sharpness {
    fn check(&self, value: f32) -> std::result::Result<(), String> {
        let ([least, most], [varying_least, varying_most]) =
            (self.fixed, self.model.editable(self.model.usual_sharpest()));
        let key = self.key;
        (least..=most).contains(&value).then_some(()).ok_or_else(|| {
            format!(
                "{key} {value} is outside {least}..{most}; for a material that varies it is {varying_least}..{varying_most}, {WHY}; {}",
                self.asking()
            )
        })
    }

    fn check_varying(&self, value: f32, sharpest: f32) -> std::result::Result<(), String> {
        let ([least, most], [fixed_least, fixed_most]) = (self.model.editable(sharpest), self.fixed);
        if (least..=most).contains(&value) {
            return Ok(());
        }
        let asked = if sharpest == self.model.most_sharpest() {
            String::new()
        } else {
            format!("; {}", self.asking())
        };
        let key = self.key;
        Err(format!(
            "{key} {value} is outside {least}..{most}, {WHY}{asked}; for a material that does not vary it is {fixed_least}..{fixed_most}"
        ))
    }

    /// How scenes ask for sharper ones.
    fn asking(&self) -> String {
        let way = if self.model == Model::BlinnPhong { "up" } else { "down" };
        format!("[vary] {} lets transfer-images go {way} to {}", self.asked_by, self.model.most_sharpest())
    }
}

/// That both parts of a material together reflect no more than arrives.
fn check_sum(all_kd: &Rgb, all_ks: &Rgb) -> std::result::Result<(), String> {
    for (kd, ks) in all_kd.iter().zip(all_ks) {
        if !(kd.is_finite() && ks.is_finite() && *kd >= 0.0 && *ks >= 0.0) {
            return Err(format!("kd {all_kd:?} and ks {all_ks:?} must be numbers of at least 0"));
        }
        // Sums such as 0.3 + 0.7 land a rounding error above 1.
        if kd + ks > 1.0 + 1e-5 {
            return Err(format!(
                "kd + ks = {} exceeds 1, more light than arrives; lower one of them",
                kd + ks
            ));
        }
    }
    Ok(())
}

impl CookTorrance {
    fn check(&self) -> std::result::Result<(), String> {
        check_sum(&self.kd, &self.ks)?;
        if !(0.0..=1.0).contains(&self.fresnel) {
            return Err(format!("fresnel {} must be a number of 0 to 1", self.fresnel));
        }
        Ok(())
    }
}

impl Ggx {
    /// Specular reflectance at normal incidence, f₀.
    pub fn f0(&self) -> Rgb {
        self.base_color.map(|base| DIELECTRIC_F0 * (1.0 - self.metallic) + base * self.metallic)
    }

    /// What of the diffuse lobe is left beside f₀: (1 − f₀)·(1 − metallic)·base_color. Times (1 − w)/π it is
    /// the diffuse part.
    pub fn diffuse(&self) -> Rgb {
        let f0 = self.f0();
        std::array::from_fn(|k| (1.0 - f0[k]) * (1.0 - self.metallic) * self.base_color[k])
    }

    fn check(&self) -> std::result::Result<(), String> {
        let within_unit = |x: &f32| (0.0..=1.0).contains(x);
        if !self.base_color.iter().all(within_unit) || !within_unit(&self.metallic) {
            return Err(format!(
                "base_color {:?} and metallic {} must be numbers of 0 to 1",
                self.base_color, self.metallic
            ));
        }
        Ok(())
    }
}
