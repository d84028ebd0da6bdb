//! What the user has set: the selected material, edits, the animation and its time. Knows nothing of windows or the GPU.
//!
//! A look is made of three layers, the later over the earlier: the scene's defaults with the state the player was started with; edits; the
//! animation, in the leaves that it drives. What is edited by hand while an animation drives it stays as edited until the animation is
//! played again, or until it is reset. [`HOLD_RULE`] says so to the user.

mod display;
mod settings;
mod state;

pub use display::Metering;
pub use settings::Settings;

use super::{legal, orbit};
use relume_formats::kinds::scene::{self, EnvironmentLook, StoredMaterial, StoredShape};
use relume_formats::state::{Animation, Brdf, Camera, CameraState, EnvironmentState, MaterialState, ShapeState, State};
use relume_playback::Surfaces;
use relume_playback::{Controls, Look, Scope};
use std::collections::BTreeSet;

/// The rule for editing what an animation moves.
pub const HOLD_RULE: &str = "Editing what the animation moves pauses it, and the edit holds until you press play or reset.";

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
    /// Whether a leaf of a state belongs to it.
    fn owns(&self, leaf: &[String]) -> bool {
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
}

/// Puts `new` among `animations`, which are in the order of their names: whichever plays at the start, the list looks the same. Returns its index.
fn insert_by_name(animations: &mut Vec<Animation>, new: &Animation) -> usize {
    let index = animations.partition_point(|animation| animation.name < new.name);
    animations.insert(index, new.clone());
    index
}

/// What the user has set.
#[derive(Debug, Clone)]
pub struct Editor {
    scope: Scope,
    /// The look without the animation.
    base: Look,
    /// What the animation must leave alone.
    held: BTreeSet<Part>,
    animations: Vec<Animation>,
    active: Option<usize>,
    playing: bool,
    time_s: f64,
    selected: Option<String>,
    /// Whether the exposure is to be set by the picture.
    metering: Option<Metering>,
}

impl Editor {
    /// The settings that the player starts with. An animation asked for is playing.
    pub fn new(controls: &Controls) -> Self {
        let (first, others) = controls.animations();
        let mut animations: Vec<Animation> = others.cloned().collect();
        let active = first.map(|first| insert_by_name(&mut animations, first));
        Self {
            scope: controls.scope().clone(),
            base: controls.base().clone(),
            held: BTreeSet::new(),
            animations,
            active,
            playing: active.is_some(),
            time_s: 0.0,
            selected: None,
            metering: None,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &scene::Meta {
        &self.scope.scene
    }

    /// What may be set.
    pub fn scope(&self) -> &Scope {
        &self.scope
    }

    /// The materials that may be edited, in the order of the scene.
    pub fn materials(&self) -> impl Iterator<Item = &StoredMaterial> {
        self.scope.materials()
    }

    /// The selected material.
    pub fn selected(&self) -> Option<&StoredMaterial> {
        let name = self.selected.as_deref()?;
        self.materials().find(|material| material.name == name)
    }

    /// Selects the material `name`, if it may be edited; anything else selects nothing.
    pub fn select(&mut self, name: Option<&str>) {
        self.selected = name.filter(|name| self.materials().any(|material| material.name == *name)).map(str::to_owned);
    }

    /// How everything looks now.
    pub fn look(&self) -> Look {
        let mut look = self.base.clone();
        let Some(state) = self.animated() else { return look };
        for material in self.materials().filter(|material| !self.is_held(&Part::Material(material.name.clone()))) {
            if let (Some(brdf), Some(change)) = (look.materials.get(&material.name), state.materials.get(&material.name)) {
                let brdf = legal::apply(material, *brdf, change);
                look.materials.set(&material.name, brdf);
            }
        }
        for shape in self.scene().shapes.iter().filter(|shape| !self.is_held(&Part::Shape(shape.object.clone()))) {
            let Some(change) = state.shapes.get(&shape.object) else { continue };
            match legal::shape(shape, look.shapes.get(&shape.object), change) {
                Some(posed) => look.shapes.insert(shape.object.clone(), posed),
                None => look.shapes.remove(&shape.object),
            };
        }
        look.tonemap = self.unheld_tonemap(&state).unwrap_or(look.tonemap);
        look.camera = legal::camera(look.camera, &self.unheld_camera(&state.camera.unwrap_or_default()));
        look.environment =
            look.environment.map(|light| legal::environment(light, &self.unheld_light(state.environment.unwrap_or_default())));
        look
    }

    /// What of a change of the camera no edit holds against.
    fn unheld_camera(&self, change: &CameraState) -> CameraState {
        let exposure_ev = change.exposure_ev.filter(|_| !self.is_held(&Part::Exposure));
        let view = if self.is_held(&Part::View) { CameraState::default() } else { change.clone() };
        CameraState { exposure_ev, ..view }
    }

    /// What of a change of the environment no edit holds against.
    fn unheld_light(&self, change: EnvironmentState) -> EnvironmentState {
        EnvironmentState {
            map: change.map.filter(|_| !self.is_held(&Part::Light("map"))),
            rotation_deg: change.rotation_deg.filter(|_| !self.is_held(&Part::Light("rotation_deg"))),
            gain: change.gain.filter(|_| !self.is_held(&Part::Light("gain"))),
        }
    }

    fn animated(&self) -> Option<State> {
        // The animation was sampled at all of its keys before, so it can be sampled now.
        self.animation()?.sample(self.time_s as f32).ok()
    }

    /// How `material` looks now.
    pub fn brdf(&self, material: &StoredMaterial) -> Brdf {
        self.look().materials.get(&material.name).copied().unwrap_or(material.brdf)
    }

    /// Sets the leaves of `change` on the material `name`, as far as that is legal.
    pub fn edit(&mut self, name: &str, change: &MaterialState) {
        let Some(material) = self.materials().find(|material| material.name == name) else { return };
        let brdf = legal::apply(material, self.brdf(material), change);
        self.hold(Part::Material(name.to_owned()));
        self.base.materials.set(name, brdf);
    }

    /// Gives the material `name` back its parameters from the scene, and to the animation if there is one.
    pub fn reset(&mut self, name: &str) {
        let default = self.materials().find(|material| material.name == name).map(|material| material.brdf);
        if let Some(brdf) = default {
            self.base.materials.set(name, brdf);
            self.held.remove(&Part::Material(name.to_owned()));
        }
    }

    /// Whether the material `name` was changed, by hand or by the state that the player was started with.
    pub fn is_edited(&self, material: &StoredMaterial) -> bool {
        self.base.materials.get(&material.name).is_some_and(|brdf| *brdf != material.brdf)
            || self.is_held(&Part::Material(material.name.clone()))
    }

    /// Whether an edit by hand keeps the animation from `part`.
    pub fn is_held(&self, part: &Part) -> bool {
        self.held.contains(part)
    }

    /// Whether the animation moves `part`.
    pub fn drives(&self, part: &Part) -> bool {
        self.animation().is_some_and(|animation| animation.tracks.iter().any(|track| part.owns(&track.leaf)))
    }

    /// Keeps the animation from `part`, if it moves that, and pauses it.
    fn hold(&mut self, part: Part) {
        if self.drives(&part) {
            self.held.insert(part);
            self.playing = false;
        }
    }

    /// Moves the camera by hand, if it may move; it stops before `surfaces`.
    pub fn move_camera(&mut self, motion: orbit::Motion, surfaces: &Surfaces) {
        if self.scope.varies().camera {
            let camera = orbit::moved(self.look().camera, motion, self.scene().camera, surfaces);
            self.hold(Part::View);
            self.base.camera = Camera { exposure_ev: self.base.camera.exposure_ev, ..camera };
        }
    }

    /// Gives the camera back its place from the scene, and to the animation if there is one.
    pub fn reset_view(&mut self) {
        self.base.camera = Camera { exposure_ev: self.base.camera.exposure_ev, ..self.scene().camera };
        self.held.remove(&Part::View);
    }

    /// Sets the leaves of `change` on the environment, as far as it may change and as that is legal.
    pub fn edit_light(&mut self, change: &EnvironmentState) {
        let known = change.map.as_ref().is_none_or(|map| self.scope.maps.contains(map));
        let Some(now) = self.look().environment.filter(|_| known && self.scope.varies().environment) else { return };
        let leaves = [("map", change.map.is_some()), ("rotation_deg", change.rotation_deg.is_some()), ("gain", change.gain.is_some())];
        leaves.into_iter().filter(|(_, set)| *set).for_each(|(leaf, _)| self.hold(Part::Light(leaf)));
        // What no edit holds stays with the animation.
        let new = legal::environment(now, change);
        if let Some(base) = &mut self.base.environment {
            *base = EnvironmentLook {
                map: change.map.as_ref().map_or_else(|| base.map.clone(), |_| new.map),
                rotation_deg: change.rotation_deg.map_or(base.rotation_deg, |_| new.rotation_deg),
                gain: change.gain.map_or(base.gain, |_| new.gain),
            };
        }
    }

    /// Offers the environment map `name`, too.
    pub fn add_map(&mut self, name: &str) {
        if !self.scope.maps.iter().any(|map| map == name) {
            self.scope.maps.push(name.to_owned());
        }
    }

    /// Gives the environment back what the scene says, and to the animation if there is one.
    pub fn reset_light(&mut self) {
        self.base.environment = self.scene().environment.clone();
        self.held.retain(|part| !matches!(part, Part::Light(_)));
    }

    /// The objects that deform, as far as they may.
    pub fn shapes(&self) -> impl Iterator<Item = &StoredShape> {
        let varying = self.scope.varies().shapes;
        self.scene().shapes.iter().filter(move |shape| varying.contains(&shape.object.as_str()))
    }

    /// Sets the leaves of `change` on what the object `name` shows, as far as it may change and as that is legal.
    pub fn edit_shape(&mut self, name: &str, change: &ShapeState) {
        let Some(shape) = self.shapes().find(|shape| shape.object == name) else { return };
        let Some(posed) = legal::shape(shape, self.look().shapes.get(name), change) else { return };
        self.hold(Part::Shape(name.to_owned()));
        self.base.shapes.insert(name.to_owned(), posed);
    }

    /// Brings the object `name` back to rest, and gives it to the animation if there is one.
    pub fn reset_shape(&mut self, name: &str) {
        self.base.shapes.remove(name);
        self.held.remove(&Part::Shape(name.to_owned()));
    }

    /// All animations, in the order of their names.
    pub fn animations(&self) -> &[Animation] {
        &self.animations
    }

    /// The chosen animation.
    pub fn animation(&self) -> Option<&Animation> {
        self.animations.get(self.active?)
    }

    /// Index of the chosen animation.
    pub fn active(&self) -> Option<usize> {
        self.active
    }

    /// Chooses an animation and plays it from its start, or chooses none.
    pub fn choose(&mut self, index: Option<usize>) {
        self.active = index.filter(|index| *index < self.animations.len());
        self.time_s = 0.0;
        self.playing = false;
        self.play_or_pause();
    }

    /// Whether time passes.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// Pauses, or plays on. An animation that has ended starts again.
    pub fn play_or_pause(&mut self) {
        let Some(animation) = self.animation() else { return };
        let (duration_s, looping) = (f64::from(animation.duration_s), animation.looping);
        self.playing = !self.playing;
        if self.playing {
            self.held.clear();
            if !looping && self.time_s >= duration_s {
                self.time_s = 0.0;
            }
        }
    }

    /// Where in the animation it stands, in seconds.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Goes to `time_s`, within the animation, and pauses there.
    pub fn scrub(&mut self, time_s: f64) {
        let Some(duration_s) = self.animation().map(|animation| f64::from(animation.duration_s)) else { return };
        self.playing = false;
        if !time_s.is_nan() {
            self.time_s = time_s.clamp(0.0, duration_s);
        }
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f64) {
        let Some(animation) = self.animation().filter(|_| self.playing) else { return };
        let (duration_s, looping) = (f64::from(animation.duration_s), animation.looping);
        let time_s = self.time_s + seconds;
        self.playing = looping || time_s < duration_s;
        self.time_s = if looping { time_s.rem_euclid(duration_s) } else { time_s.min(duration_s) };
    }
}
