//! What may change at playback, as one struct that `bake` and `player` share.
//!
//! A [`State`] is partial: it names only what differs from the scene. It is read from a `STATE.toml`, or
//! sampled from an [`Animation`].

mod animation;
mod camera;
mod leaf;
mod light;
mod material;
mod paint;
mod shape;
mod strict_toml;

pub use animation::{Animation, MAX_KEYS, Track, TrackValues};
pub use camera::{Camera, Film, MAX_COORDINATE, MAX_EXPOSURE_EV};
pub use light::{MAX_RADIOMETRIC, expect_radiometric};
pub use material::{
    ASKED_ROUGHNESS_MIN, ASKED_SHININESS_MAX, ASKED_SLOPE_MIN, BlinnPhong, Brdf, CookTorrance, DIELECTRIC_F0,
    FIXED_ROUGHNESS_MIN, FIXED_SHININESS_MAX, FIXED_SLOPE_MIN, Ggx, Model, ROUGHNESS_MIN, SHININESS_MAX,
    SHININESS_MIN, SLOPE_MIN,
};
pub use paint::{Layer, MAX_PAINT_SIDE, Paint, Texel, texel_of};
pub use shape::{Pose, Posed};
pub use strict_toml::{parse as parse_toml, read_text, with_line};

use crate::display::Tonemap;
use crate::error::{Error, Place, Result};
use crate::name::plain;
use crate::near::did_you_mean;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Linear RGB with Rec. 709 primaries.
pub type Rgb = [f32; 3];

/// A partial scene state; absent leaves keep the scene's values.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The environment light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentState>,
    /// The camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraState>,
    /// The display.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<ViewState>,
    /// Lights by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub lights: BTreeMap<String, LightState>,
    /// Materials by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialState>,
    /// Shapes by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub shapes: BTreeMap<String, ShapeState>,
}

/// Changes to the environment light.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentState {
    /// Another equirectangular map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// Counter-clockwise turn seen from +Y, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<f32>,
    /// Factor on the map's radiance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<Rgb>,
}

/// Changes to the camera.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraState {
    /// Eye point in world space, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f32; 3]>,
    /// Point looked at in world space, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f32; 3]>,
    /// Vertical field of view, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_deg: Option<f32>,
    /// Exposure: the display shows 2^ev times the radiance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_ev: Option<f32>,
}

/// Changes to how the display shows radiance; exposure, which comes before, is the camera's.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewState {
    /// The curve from radiance to display values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tonemap: Option<Tonemap>,
}

/// Changes to one light.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightState {
    /// Factor on what the light emits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<Rgb>,
}

/// Changes to one material.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "leaf::Leaves", into = "leaf::Leaves")]
pub struct MaterialState {
    /// Diffuse reflectance, 0..1.
    pub kd: Option<Rgb>,
    /// Glossy reflectance, 0..1; kd + ks must not exceed 1 in any channel.
    pub ks: Option<Rgb>,
    /// Blinn-Phong exponent.
    pub shininess: Option<f32>,
    /// How much of ks Cook-Torrance reflects at normal incidence, 0..1.
    pub fresnel: Option<f32>,
    /// GGX base colour, 0..1.
    pub base_color: Option<Rgb>,
    /// GGX share of metal, 0..1.
    pub metallic: Option<f32>,
    /// Perceptual roughness of GGX, or slope of Cook-Torrance.
    pub roughness: Option<f32>,
    /// Files of textures, by the key that they stand for; paths from the folder of the state.
    pub textures: BTreeMap<&'static str, String>,
}

impl MaterialState {
    /// Name of a leaf that is set but belongs to another model than `model`.
    fn leaf_not_of(&self, model: Model) -> Option<&'static str> {
        use Model::{BlinnPhong, CookTorrance, Ggx};
        let leaves: [(_, &[Model], _); 7] = [
            ("kd", &[BlinnPhong, CookTorrance], self.kd.is_some()),
            ("ks", &[BlinnPhong, CookTorrance], self.ks.is_some()),
            ("shininess", &[BlinnPhong], self.shininess.is_some()),
            ("fresnel", &[CookTorrance], self.fresnel.is_some()),
            ("base_color", &[Ggx], self.base_color.is_some()),
            ("metallic", &[Ggx], self.metallic.is_some()),
            ("roughness", &[Ggx, CookTorrance], self.roughness.is_some()),
        ];
        let sets = |name: &str, set| set || self.textures.contains_key(name);
        leaves
            .into_iter()
            .find_map(|(name, of, set)| (sets(name, set) && !of.contains(&model)).then_some(name))
    }

    /// Fails if it names a texture, where none can be painted on material `name`.
    pub(crate) fn expect_numbers(&self, name: &str, place: &Place) -> Result<()> {
        match self.textures.iter().next() {
            None => Ok(()),
            Some((key, file)) => Err(Error::invalid(
                place,
                format!(
                    "material `{name}`: `{}` is a texture for {key}, but this bundle shows materials as wholes; write {}, \
                     or see it painted by `bake reference`",
                    plain(file),
                    numbers_of(key),
                ),
            )),
        }
    }
}

/// What may be written for `key` of a material instead of a texture.
pub fn numbers_of(key: &str) -> &'static str {
    if ["kd", "ks", "base_color"].contains(&key) { "three numbers" } else { "a number" }
}

/// Changes to one shape.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShapeState {
    /// Name of a clip of the shape. Without a time it begins at 0 s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// Time within the clip, seconds, which repeats. A clip need not be named where the shape has only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f32>,
    /// Whether it shows a clip at all, which it does if a clip or a time is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
}

/// What a bundle lets vary; everything else in a state is refused by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Varies<'a> {
    /// Whether the environment varies.
    pub environment: bool,
    /// Whether the camera does.
    pub camera: bool,
    /// The materials that vary.
    pub materials: Vec<&'a str>,
    /// The objects that deform.
    pub shapes: Vec<&'a str>,
}

impl Varies<'_> {
    /// What varies, for a message: "only the camera, material `bunny` vary".
    fn list(&self) -> String {
        let parts = [(self.environment, "the environment"), (self.camera, "the camera")];
        let parts = parts.into_iter().filter(|(varies, _)| *varies).map(|(_, name)| name.to_owned());
        let named = |what: &'static str, names: &[&str]| {
            names.iter().map(|name| format!("{what} `{name}`")).collect::<Vec<_>>()
        };
        let list: Vec<String> =
            parts.chain(named("material", &self.materials)).chain(named("shape", &self.shapes)).collect();
        match &list[..] {
            [] => "nothing varies".to_owned(),
            [one] => format!("only {one} varies"),
            many => format!("only {} vary", many.join(", ")),
        }
    }
}

impl State {
    /// Reads a `STATE.toml`.
    pub fn read_file(path: &Path) -> Result<Self> {
        let place = Place::file(path);
        parse_toml(&read_text(path)?, &place)
    }

    /// Fails if the state names anything that does not vary. Exposure and tone mapping belong to the display
    /// and may always change.
    pub fn expect_only(&self, varies: &Varies<'_>, place: &Place) -> Result<()> {
        let refuse = |what: &str, meant: &str| {
            let remedy = "remove it, or let it vary: by [vary] in scene.toml, and by a method that can, as `bake plan` tells";
            let can = varies.list();
            let meant = if meant.is_empty() { ";".to_owned() } else { format!("{meant} Else") };
            Err(Error::invalid(
                place,
                format!("sets {what}, which this bundle does not vary ({can}){meant} {remedy}"),
            ))
        };
        if self.environment.is_some() && !varies.environment {
            return refuse("[environment]", "");
        }
        if let Some(camera) = &self.camera
            && !varies.camera
            && (camera.position.is_some() || camera.target.is_some() || camera.fov_deg.is_some())
        {
            return refuse("the camera's position, target or field of view", "");
        }
        self.expect_no_lights(place)?;
        for (what, names, varying) in [
            ("shape", self.shapes.keys().collect::<Vec<_>>(), &varies.shapes),
            ("material", self.materials.keys().collect(), &varies.materials),
        ] {
            if let Some(name) = names.into_iter().find(|name| !varying.contains(&name.as_str())) {
                return refuse(&format!("{what} `{name}`"), &did_you_mean(name, varying.iter().copied()));
            }
        }
        Ok(())
    }

    /// Fails if the state sets a light: a scene's tracer can, but no method lets any vary at playback, so
    /// that there is nothing to add to `[vary]`.
    pub(crate) fn expect_no_lights(&self, place: &Place) -> Result<()> {
        match self.lights.keys().next() {
            None => Ok(()),
            Some(name) => Err(Error::invalid(
                place,
                format!("sets light `{name}`, but no method of this version lets lights vary; remove it"),
            )),
        }
    }
}
