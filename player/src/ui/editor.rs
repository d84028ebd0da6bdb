//! What the user has set: the selected material, edits, the animation and its time. Knows nothing of windows or the GPU.
//!
//! A look is made of three layers, the later over the earlier: the scene's defaults with the state the player was started with; edits; the
//! animation, in the leaves that it drives. What is edited by hand while an animation drives it stays as edited until the animation is
//! played again, or until it is reset. [`HOLD_RULE`] says so to the user.

use super::legal;
use crate::controls::{Controls, Look};
use relume_formats::kinds::scene::{self, StoredMaterial};
use relume_formats::state::{Animation, Brdf, CameraState, MaterialState, State};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// The rule for editing what an animation moves.
pub const HOLD_RULE: &str = "Editing what the animation moves pauses it, and the edit holds until you press play or reset.";

/// How far from the scene's exposure the slider reaches, either way, in EV.
const EXPOSURE_REACH_EV: f32 = 10.0;
/// Exposures that a state may have, either way, in EV.
const EXPOSURE_MAX_EV: f32 = 32.0;

/// What the user has set.
#[derive(Debug, Clone)]
pub struct Editor {
    scene: scene::Meta,
    /// The look without the animation.
    base: Look,
    /// Materials that the animation must leave alone.
    held: BTreeSet<String>,
    exposure_held: bool,
    animations: Vec<Animation>,
    active: Option<usize>,
    playing: bool,
    time_s: f64,
    selected: Option<String>,
}

impl Editor {
    /// The settings that the player starts with. An animation asked for is playing.
    pub fn new(controls: &Controls) -> Self {
        let (first, others) = controls.animations();
        let active = first.map(|_| 0);
        Self {
            scene: controls.scene().clone(),
            base: controls.base().clone(),
            held: BTreeSet::new(),
            exposure_held: false,
            animations: first.into_iter().chain(others).cloned().collect(),
            active,
            playing: active.is_some(),
            time_s: 0.0,
            selected: None,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &scene::Meta {
        &self.scene
    }

    /// The materials that may be edited, in the order of the scene.
    pub fn materials(&self) -> impl Iterator<Item = &StoredMaterial> {
        self.scene.materials.iter().filter(|material| material.varies)
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
        for material in self.materials().filter(|material| !self.held.contains(&material.name)) {
            if let (Some(brdf), Some(change)) = (look.materials.get_mut(&material.name), state.materials.get(&material.name)) {
                *brdf = legal::apply(material, *brdf, change);
            }
        }
        let exposure_ev = state.camera.and_then(|camera| camera.exposure_ev).filter(|_| !self.exposure_held);
        look.exposure_ev = exposure_ev.unwrap_or(look.exposure_ev);
        look
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
        if self.drives(&["materials", name]) {
            self.held.insert(name.to_owned());
            self.playing = false;
        }
        self.base.materials.insert(name.to_owned(), brdf);
    }

    /// Gives the material `name` back its parameters from the scene, and to the animation if there is one.
    pub fn reset(&mut self, name: &str) {
        let default = self.materials().find(|material| material.name == name).map(|material| material.brdf);
        if let Some(brdf) = default {
            self.base.materials.insert(name.to_owned(), brdf);
            self.held.remove(name);
        }
    }

    /// Whether the material `name` was changed, by hand or by the state that the player was started with.
    pub fn is_edited(&self, material: &StoredMaterial) -> bool {
        self.base.materials.get(&material.name).is_some_and(|brdf| *brdf != material.brdf) || self.held.contains(&material.name)
    }

    /// Whether an edit by hand keeps the animation from the material `name`.
    pub fn is_held(&self, name: &str) -> bool {
        self.held.contains(name)
    }

    /// Whether the animation moves a leaf below `path`.
    pub fn drives(&self, path: &[&str]) -> bool {
        self.animation().is_some_and(|animation| animation.tracks.iter().any(|track| starts_with(&track.leaf, path)))
    }

    /// Sets the exposure.
    pub fn set_exposure(&mut self, ev: f32) {
        if ev.is_nan() {
            return;
        }
        if self.drives(&["camera", "exposure_ev"]) {
            self.exposure_held = true;
            self.playing = false;
        }
        self.base.exposure_ev = ev.clamp(-EXPOSURE_MAX_EV, EXPOSURE_MAX_EV);
    }

    /// The exposures to offer.
    pub fn exposure_range(&self) -> RangeInclusive<f32> {
        let middle = self.scene.camera.exposure_ev;
        (middle - EXPOSURE_REACH_EV).max(-EXPOSURE_MAX_EV)..=(middle + EXPOSURE_REACH_EV).min(EXPOSURE_MAX_EV)
    }

    /// Gives the exposure back its value from the scene, and to the animation if there is one.
    pub fn reset_exposure(&mut self) {
        self.base.exposure_ev = self.scene.camera.exposure_ev;
        self.exposure_held = false;
    }

    /// All animations.
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
            self.exposure_held = false;
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

    /// The look as a state: what differs from the scene.
    pub fn state(&self) -> State {
        let look = self.look();
        let differs = |material: &&StoredMaterial| look.materials.get(&material.name).is_some_and(|brdf| *brdf != material.brdf);
        let named = |material: &StoredMaterial| Some((material.name.clone(), leaves(look.materials.get(&material.name)?)));
        let exposure_ev = Some(look.exposure_ev).filter(|ev| *ev != self.scene.camera.exposure_ev);
        State {
            camera: exposure_ev.map(|ev| CameraState { exposure_ev: Some(ev), ..CameraState::default() }),
            materials: self.materials().filter(differs).filter_map(named).collect(),
            ..State::default()
        }
    }
}

fn starts_with(leaf: &[String], path: &[&str]) -> bool {
    leaf.len() >= path.len() && leaf.iter().zip(path).all(|(a, b)| a == b)
}

/// Every leaf of a material.
fn leaves(brdf: &Brdf) -> MaterialState {
    match *brdf {
        Brdf::BlinnPhong(b) => MaterialState { kd: Some(b.kd), ks: Some(b.ks), shininess: Some(b.shininess), ..Default::default() },
        Brdf::Ggx(g) => {
            let (base_color, metallic) = (Some(g.base_color), Some(g.metallic));
            MaterialState { base_color, metallic, roughness: Some(g.roughness), ..Default::default() }
        }
    }
}
