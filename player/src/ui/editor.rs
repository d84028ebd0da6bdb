//! What the user has set: the selected material, edits, the animation and its time. Knows nothing of windows
//! or the GPU.
//!
//! A look is made of three layers, the later over the earlier: the scene's defaults with the state the player
//! was started with; edits; the animation, in the leaves that it drives. What is edited by hand while an
//! animation drives it stays as edited until it is reset, whatever plays. [`HOLD_RULE`] says so to the user.
//! Every edit is a change that goes through [`Look::apply`], and can be undone: [`history`].

mod display;
mod files;
mod history;
mod kept;
mod part;
mod settings;
mod transport;

pub use display::Metering;
pub use kept::Kept;
pub use part::Part;
pub use settings::Settings;

use super::{legal, orbit};
use history::History;
use relume_formats::Place;
use relume_formats::kinds::scene::{self, StoredMaterial, StoredShape};
use relume_formats::state::{
    Animation, Brdf, CameraState, EnvironmentState, MaterialState, Pose, ShapeState, State,
};
use relume_playback::Surfaces;
use relume_playback::{Controls, Look, Scope};
use std::collections::BTreeSet;

/// The rule for editing what an animation moves.
pub const HOLD_RULE: &str =
    "Editing what the animation moves pauses it. The edit holds while it plays on, until you reset it.";

/// Puts `new` among `animations`, which are in the order of their names: whichever plays at the start, the
/// list looks the same. Returns its index.
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
    /// What animations must leave alone.
    held: BTreeSet<Part>,
    animations: Vec<Animation>,
    active: Option<usize>,
    playing: bool,
    time_s: f64,
    selected: Option<String>,
    history: History,
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
            history: History::new(controls.base(), active),
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
        self.selected =
            name.filter(|name| self.materials().any(|material| material.name == *name)).map(str::to_owned);
    }

    /// How everything looks now.
    pub fn look(&self) -> Look {
        let mut look = self.base.clone();
        if let Some(mut state) = self.animated() {
            self.held.iter().for_each(|part| part.take_from(&mut state));
            apply_legal(&mut look, &state, &self.scope);
            // What moves gives way to what is held where the two share a range.
            let mut held = self.base.difference(&look);
            let parts: Vec<Part> = Part::of(&held).filter(|part| !self.held.contains(part)).collect();
            parts.iter().for_each(|part| part.take_from(&mut held));
            apply_legal(&mut look, &held, &self.scope);
        }
        look
    }

    /// The look as a state: what differs from the scene.
    pub fn state(&self) -> State {
        self.look().difference(&Look::default_of(self.scene()))
    }

    fn animated(&self) -> Option<State> {
        // The animation was sampled at all of its keys before, so it can be sampled now.
        self.animation()?.sample(self.time_s as f32).ok()
    }

    /// How `material` looks now.
    pub fn brdf(&self, material: &StoredMaterial) -> Brdf {
        self.look().materials.get(&material.name).copied().unwrap_or(material.brdf)
    }

    /// Sets the leaves that `change` names, as far as they may vary and as that is legal; what the animation
    /// moves of it is held, and the animation pauses.
    pub fn set(&mut self, change: &State) {
        let mut legal = legal::within(&self.look(), &self.scope, change);
        // That names whole materials: what was not asked for stays the animation's.
        let asked: BTreeSet<Part> = Part::of(change).collect();
        let others: Vec<Part> = Part::of(&legal).filter(|part| !asked.contains(part)).collect();
        others.iter().for_each(|part| part.take_from(&mut legal));
        Part::of(&legal).for_each(|part| self.hold(part));
        apply_legal(&mut self.base, &legal, &self.scope);
    }

    /// Brings the leaves that `change` names to its values, and gives `parts` to the animation if there is
    /// one.
    fn give_back(&mut self, change: &State, parts: &[Part]) {
        apply(&mut self.base, change, &self.scope);
        parts.iter().for_each(|part| {
            self.held.remove(part);
        });
    }

    /// Sets the leaves of `change` on the material `name`, as far as that is legal.
    pub fn edit(&mut self, name: &str, change: &MaterialState) {
        self.set(&State { materials: [(name.to_owned(), change.clone())].into(), ..State::default() });
    }

    /// Gives the material `name` back its parameters from the scene, and to the animation if there is one.
    pub fn reset(&mut self, name: &str) {
        let default = self.materials().find(|material| material.name == name).map(|material| material.brdf);
        if let Some(brdf) = default {
            let change = State {
                materials: [(name.to_owned(), MaterialState::from(brdf))].into(),
                ..State::default()
            };
            self.give_back(&change, &Part::of_material(name));
        }
    }

    /// Whether the material `name` was changed, by hand or by the state that the player was started with.
    pub fn is_edited(&self, material: &StoredMaterial) -> bool {
        self.base.materials.get(&material.name).is_some_and(|brdf| *brdf != material.brdf)
            || Part::of_material(&material.name).iter().any(|part| self.is_held(part))
    }

    /// Whether an edit by hand keeps the animation from `part`.
    pub fn is_held(&self, part: &Part) -> bool {
        self.held.contains(part) && self.concerns(part)
    }

    /// Whether the animation moves `part`.
    pub fn drives(&self, part: &Part) -> bool {
        self.animation().is_some_and(|animation| animation.tracks.iter().any(|track| part.owns(&track.leaf)))
    }

    /// Whether the animation moves `part`, or what shares its range.
    fn concerns(&self, part: &Part) -> bool {
        self.drives(part) || part.rival().is_some_and(|rival| self.drives(&rival))
    }

    /// Keeps the animation from `part`, if it concerns that, and pauses it.
    fn hold(&mut self, part: Part) {
        if self.concerns(&part) {
            self.held.insert(part);
            self.playing = false;
        }
    }

    /// What was edited before the animation was chosen that now moves it: the animation covers these edits,
    /// and they come back when it goes.
    pub fn covered(&self) -> Vec<Part> {
        let edited = Part::between(&self.base, self.history.start());
        edited.filter(|part| self.drives(part) && !self.held.contains(part)).collect()
    }

    /// Moves the camera by hand, if it may move; it stops before `surfaces`.
    pub fn move_camera(&mut self, motion: orbit::Motion, surfaces: &Surfaces) {
        if self.scope.varies().camera {
            let to = orbit::moved(self.look().camera, motion, self.scene().camera, surfaces);
            let (position, target, fov_deg) = (Some(to.position), Some(to.target), Some(to.fov_deg));
            self.set_camera(CameraState { position, target, fov_deg, exposure_ev: None });
        }
    }

    fn set_camera(&mut self, change: CameraState) {
        self.set(&State { camera: Some(change), ..State::default() });
    }

    /// Gives the camera back its place from the scene, and to the animation if there is one.
    pub fn reset_view(&mut self) {
        let home = self.scene().camera;
        let (position, target, fov_deg) = (Some(home.position), Some(home.target), Some(home.fov_deg));
        let change = CameraState { position, target, fov_deg, exposure_ev: None };
        self.give_back(&State { camera: Some(change), ..State::default() }, &[Part::View]);
    }

    /// Sets the leaves of `change` on the environment, as far as it may change and as that is legal.
    pub fn edit_light(&mut self, change: &EnvironmentState) {
        self.set(&State { environment: Some(change.clone()), ..State::default() });
    }

    /// Offers the environment map `name`, too.
    pub fn add_map(&mut self, name: &str) {
        if !self.scope.maps.iter().any(|map| map == name) {
            self.scope.maps.push(name.to_owned());
        }
    }

    /// Gives the environment back what the scene says, and to the animation if there is one.
    pub fn reset_light(&mut self) {
        let whole = self.scene().environment.clone().map(|home| EnvironmentState {
            map: Some(home.map),
            rotation_deg: Some(home.rotation_deg),
            gain: Some(home.gain),
        });
        self.give_back(&State { environment: whole, ..State::default() }, &Part::LIGHT);
    }

    /// The objects that deform, as far as they may.
    pub fn shapes(&self) -> impl Iterator<Item = &StoredShape> {
        let varying = self.scope.varies().shapes;
        self.scene().shapes.iter().filter(move |shape| varying.contains(&shape.object.as_str()))
    }

    /// Sets the leaves of `change` on what the object `name` shows, as far as it may change and as that is
    /// legal.
    pub fn edit_shape(&mut self, name: &str, change: &ShapeState) {
        self.set(&State { shapes: [(name.to_owned(), change.clone())].into(), ..State::default() });
    }

    /// Brings the object `name` back to rest, and gives it to the animation if there is one.
    pub fn reset_shape(&mut self, name: &str) {
        let rest = ShapeState { pose: Some(Pose::Rest), ..ShapeState::default() };
        let change = State { shapes: [(name.to_owned(), rest)].into(), ..State::default() };
        self.give_back(&change, &[Part::Shape(name.to_owned())]);
    }

    /// Gives everything back what the scene says, and to the animation if there is one.
    pub fn reset_all(&mut self) {
        let change = Look::default_of(self.scene()).difference(&self.base);
        apply(&mut self.base, &change, &self.scope);
        self.metering = None;
        self.held.clear();
    }

    /// Whether there is anything for [`Editor::reset_all`] to do.
    pub fn is_anything_edited(&self) -> bool {
        !self.held.is_empty() || self.base != Look::default_of(self.scene())
    }
}

/// Makes a change that is known to be legal: what it is made of was checked leaf by leaf, or is a look that
/// there was.
fn apply(look: &mut Look, change: &State, scope: &Scope) {
    let applied = look.apply(change, scope, &Place::file("edit"));
    debug_assert!(applied.is_ok(), "{applied:?}");
}

/// Makes of a change what is legal.
fn apply_legal(look: &mut Look, change: &State, scope: &Scope) {
    let legal = legal::within(look, scope, change);
    apply(look, &legal, scope);
}
