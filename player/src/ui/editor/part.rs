//! What is edited as one.

use relume_formats::name::plain;
use relume_formats::state::{CameraState, EnvironmentState, State};

/// What is edited, and held against an animation, as one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The material of this name.
    Material(String),
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

impl Part {
    /// All of the environment.
    pub const LIGHT: [Self; 3] = [Self::Light("map"), Self::Light("rotation_deg"), Self::Light("gain")];

    /// The parts that `change` names leaves of.
    pub fn of(change: &State) -> impl Iterator<Item = Self> {
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
        let materials: Vec<_> = change.materials.keys().cloned().map(Self::Material).collect();
        let shapes: Vec<_> = change.shapes.keys().cloned().map(Self::Shape).collect();
        materials.into_iter().chain(light).chain(view).chain(exposure).chain(tonemap).chain(shapes)
    }

    /// Takes its leaves out of `change`, and what is empty then.
    pub fn take_from(&self, change: &mut State) {
        match self {
            Self::Material(name) => drop(change.materials.remove(name)),
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
            Self::Material(material) => of == "materials" && name == material,
            Self::Exposure => of == "camera" && name == "exposure_ev",
            Self::Tonemap => of == "view" && name == "tonemap",
            Self::View => of == "camera" && name != "exposure_ev",
            Self::Light(leaf) => of == "environment" && name == leaf,
            Self::Shape(object) => of == "shapes" && name == object,
        }
    }

    /// What the user calls it.
    pub fn words(&self) -> String {
        match self {
            Self::Material(name) => format!("material {}", plain(name)),
            Self::Exposure => "the exposure".to_owned(),
            Self::Tonemap => "the curve".to_owned(),
            Self::View => "the view".to_owned(),
            Self::Light("map") => "the map".to_owned(),
            Self::Light("rotation_deg") => "the light's rotation".to_owned(),
            Self::Light(_) => "the light's gain".to_owned(),
            Self::Shape(name) => format!("shape {}", plain(name)),
        }
    }
}
