//! What is edited as one.

use relume_formats::name::plain;
use relume_formats::state::{CameraState, EnvironmentState, MaterialState, State};
use relume_playback::Look;

/// What is edited, and held against an animation, as one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// This leaf of the material of this name.
    Material(String, &'static str),
    /// How bright the display is.
    Exposure,
    /// The curve of the display.
    Tonemap,
    /// Where the camera stands, where it looks, and its field of view.
    View,
    /// This leaf of the environment.
    Light(&'static str),
    /// What the object of this name shows.
    Shape(String),
}

/// The leaves of materials, of all models, with what the panel calls them.
const LEAVES: [(&str, &str); 7] = [
    ("kd", "diffuse"),
    ("ks", "glossy"),
    ("shininess", "shininess"),
    ("fresnel", "fresnel"),
    ("base_color", "base colour"),
    ("metallic", "metallic"),
    ("roughness", "roughness"),
];

impl Part {
    /// All of the environment.
    pub const LIGHT: [Self; 3] = [Self::Light("map"), Self::Light("rotation_deg"), Self::Light("gain")];

    /// All of the material `name`.
    pub fn of_material(name: &str) -> [Self; 7] {
        LEAVES.map(|(leaf, _)| Self::Material(name.to_owned(), leaf))
    }

    /// The parts that `change` names leaves of, those of a material one behind the other.
    pub fn of(change: &State) -> impl Iterator<Item = Self> + use<> {
        let light = change
            .environment
            .as_ref()
            .map(|light| [light.map.is_some(), light.rotation_deg.is_some(), light.gain.is_some()]);
        let light = Self::LIGHT
            .into_iter()
            .zip(light.unwrap_or_default())
            .filter_map(|(part, named)| named.then_some(part));
        let camera = change.camera.clone().unwrap_or_default();
        let exposure = camera.exposure_ev.map(|_| Self::Exposure);
        let tonemap = change.view.as_ref().and_then(|view| view.tonemap).map(|_| Self::Tonemap);
        let view =
            (CameraState { exposure_ev: None, ..camera } != CameraState::default()).then_some(Self::View);
        let materials: Vec<_> = change
            .materials
            .iter()
            .flat_map(|(name, leaves)| {
                let named = move |part: &Self| {
                    matches!(part, Self::Material(_, leaf) if only(leaf, leaves) != MaterialState::default())
                };
                Self::of_material(name).into_iter().filter(named)
            })
            .collect();
        let shapes: Vec<_> = change.shapes.keys().cloned().map(Self::Shape).collect();
        materials.into_iter().chain(light).chain(view).chain(exposure).chain(tonemap).chain(shapes)
    }

    /// The parts in which `now` is not what `was`.
    pub fn between(now: &Look, was: &Look) -> impl Iterator<Item = Self> + use<> {
        let (forth, back) = (now.difference(was), was.difference(now));
        let differs = move |part: &Self| match part {
            // A material that differs is named whole.
            Self::Material(name, leaf) => {
                let leaves = |of: &State| of.materials.get(name).map(|leaves| only(leaf, leaves));
                leaves(&forth) != leaves(&back)
            }
            _ => true,
        };
        Self::of(&now.difference(was)).filter(differs)
    }

    /// Takes its leaves out of `change`, and what is empty then.
    pub fn take_from(&self, change: &mut State) {
        match self {
            Self::Material(name, leaf) => {
                if let Some(leaves) = change.materials.get_mut(name) {
                    *leaves = kept(leaves, |other| *leaf != other);
                }
                change.materials.retain(|_, leaves| *leaves != MaterialState::default());
            }
            Self::Shape(name) => drop(change.shapes.remove(name)),
            Self::Exposure => {
                let without = |camera| CameraState { exposure_ev: None, ..camera };
                change.camera =
                    change.camera.take().map(without).filter(|camera| *camera != CameraState::default());
            }
            Self::Tonemap => change.view = None,
            Self::View => {
                let only_exposure = |camera: CameraState| CameraState {
                    exposure_ev: camera.exposure_ev,
                    ..CameraState::default()
                };
                change.camera = change
                    .camera
                    .take()
                    .map(only_exposure)
                    .filter(|camera| *camera != CameraState::default());
            }
            Self::Light(leaf) => {
                let kept = |other: &str| *leaf != other;
                let without = |light: EnvironmentState| EnvironmentState {
                    map: light.map.filter(|_| kept("map")),
                    rotation_deg: light.rotation_deg.filter(|_| kept("rotation_deg")),
                    gain: light.gain.filter(|_| kept("gain")),
                };
                change.environment = change
                    .environment
                    .take()
                    .map(without)
                    .filter(|light| *light != EnvironmentState::default());
            }
        }
    }

    /// Whether a leaf of a state belongs to it.
    pub fn owns(&self, leaf: &[String]) -> bool {
        let [of, name, ..] = leaf else { return false };
        match self {
            Self::Material(material, own) => {
                of == "materials" && name == material && leaf.get(2).is_some_and(|leaf| leaf == own)
            }
            Self::Exposure => of == "camera" && name == "exposure_ev",
            Self::Tonemap => of == "view" && name == "tonemap",
            Self::View => of == "camera" && name != "exposure_ev",
            Self::Light(leaf) => of == "environment" && name == leaf,
            Self::Shape(object) => of == "shapes" && name == object,
        }
    }

    /// The part that shares one range with it, so that the one gives way to the other.
    pub fn rival(&self) -> Option<Self> {
        match self {
            Self::Material(name, "kd") => Some(Self::Material(name.clone(), "ks")),
            Self::Material(name, "ks") => Some(Self::Material(name.clone(), "kd")),
            _ => None,
        }
    }

    /// What the user calls it, a material as a whole.
    pub fn words(&self) -> String {
        match self {
            Self::Material(name, _) => format!("material {}", plain(name)),
            Self::Exposure => "the exposure".to_owned(),
            Self::Tonemap => "the curve".to_owned(),
            Self::View => "the view".to_owned(),
            Self::Light("map") => "the map".to_owned(),
            Self::Light("rotation_deg") => "the light's rotation".to_owned(),
            Self::Light(_) => "the light's gain".to_owned(),
            Self::Shape(name) => format!("shape {}", plain(name)),
        }
    }

    /// What the user calls `parts`, each once.
    pub fn words_of<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Vec<String> {
        let mut words: Vec<String> = parts.into_iter().map(Self::words).collect();
        // Those of a material are one behind the other.
        words.dedup();
        words
    }

    /// What the panel calls the leaf of a material.
    pub fn label(&self) -> Option<&'static str> {
        let Self::Material(_, own) = self else { return None };
        LEAVES.iter().find(|(leaf, _)| leaf == own).map(|(_, label)| *label)
    }
}

/// The leaves that `keeps` says, and no others.
fn kept(leaves: &MaterialState, keeps: impl Fn(&str) -> bool) -> MaterialState {
    MaterialState {
        kd: leaves.kd.filter(|_| keeps("kd")),
        ks: leaves.ks.filter(|_| keeps("ks")),
        shininess: leaves.shininess.filter(|_| keeps("shininess")),
        fresnel: leaves.fresnel.filter(|_| keeps("fresnel")),
        base_color: leaves.base_color.filter(|_| keeps("base_color")),
        metallic: leaves.metallic.filter(|_| keeps("metallic")),
        roughness: leaves.roughness.filter(|_| keeps("roughness")),
        textures: leaves.textures.clone().into_iter().filter(|(key, _)| keeps(key)).collect(),
    }
}

/// Of `leaves` only this one.
fn only(leaf: &str, leaves: &MaterialState) -> MaterialState {
    kept(leaves, |other| leaf == other)
}
