//! `scene.toml` as written: every key, its type and its default. What the values mean is decided by
//! [`crate::loading`].
//!
//! Everything denies unknown keys, so that a misspelt one is an error with its line and a suggestion, never a
//! silent default.

mod object;

pub(crate) use object::{ObjectFile, ShapeName};

use crate::scene::ALL_REFLECTIONS;
use crate::transform::TransformFile;
use relume_formats::display::Tonemap;
use relume_formats::state::{Camera, Rgb};
use serde::de::{self, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;

/// A whole scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneFile {
    #[serde(default)]
    pub vary: VaryFile,
    pub render: RenderFile,
    pub camera: Camera,
    #[serde(default)]
    pub view: ViewFile,
    #[serde(default)]
    pub object: Vec<ObjectFile>,
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialFile>,
    #[serde(default)]
    pub light: Vec<LightFile>,
    pub environment: Option<EnvironmentFile>,
    #[serde(default)]
    pub error: ErrorFile,
}

/// `[vary]`: nothing varies unless said so.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct VaryFile {
    pub light: bool,
    pub view: bool,
    pub shape: bool,
    pub materials: Vec<String>,
    pub painted: Vec<String>,
    pub shininess_max: Option<f32>,
    pub roughness_min: Option<f32>,
}

/// `[render]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderFile {
    pub size: [u32; 2],
    /// `None` if the file says nothing of it.
    #[serde(default)]
    pub reflections: Option<Reflections>,
}

/// A number of reflections, or `"all"`, which is [`ALL_REFLECTIONS`].
#[derive(Clone, Copy)]
pub(crate) struct Reflections(pub u32);

impl<'de> Deserialize<'de> for Reflections {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ReflectionsVisitor)
    }
}

struct ReflectionsVisitor;

impl Visitor<'_> for ReflectionsVisitor {
    type Value = Reflections;

    fn expecting(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        text.write_str("a whole number, or \"all\"")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Reflections, E> {
        match text {
            "all" => Ok(Reflections(ALL_REFLECTIONS)),
            _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Reflections, E> {
        let is_count = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
        // Exact, as a count is.
        is_count
            .then_some(Reflections(number as u32))
            .ok_or_else(|| E::invalid_value(Unexpected::Float(number), &self))
    }
}

/// `[materials.NAME]`: the keys of all models; those of others than its own are refused by name. Without `brdf` it
/// changes the material of that name in a glTF file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialFile {
    pub brdf: Option<BrdfName>,
    pub kd: Option<Rgb>,
    pub ks: Option<Rgb>,
    pub shininess: Option<f32>,
    pub fresnel: Option<f32>,
    pub base_color: Option<Rgb>,
    pub metallic: Option<f32>,
    pub roughness: Option<f32>,
    /// A factor on what the material of a glTF file emits.
    pub emission: Option<f32>,
    pub texture: Option<String>,
    pub alpha_cutoff: Option<f32>,
}

/// The reflectance models that a scene may name.
#[derive(Deserialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum BrdfName {
    BlinnPhong,
    Ggx,
    CookTorrance,
}

/// `[view]`: the display.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ViewFile {
    pub tonemap: Tonemap,
}

/// `[[light]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightFile {
    pub name: String,
    pub kind: LightKind,
    #[serde(default)]
    pub transform: TransformFile,
    pub radiance: Option<Rgb>,
    pub intensity: Option<Rgb>,
    pub irradiance: Option<Rgb>,
}

/// The kinds of light.
#[derive(Deserialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LightKind {
    Area,
    Point,
    Directional,
}

/// `[environment]`; without a file it is evenly white. `others` are further maps that a state may name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EnvironmentFile {
    pub file: Option<String>,
    #[serde(default)]
    pub others: Vec<String>,
    #[serde(default = "unit_gain")]
    pub gain: Rgb,
    #[serde(default)]
    pub rotation_deg: f32,
}

fn unit_gain() -> Rgb {
    [1.0; 3]
}

/// `[error]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ErrorFile {
    pub max: f64,
}

impl Default for ErrorFile {
    fn default() -> Self {
        Self { max: 0.01 }
    }
}
