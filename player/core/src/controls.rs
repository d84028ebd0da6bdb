//! What the user sets: a state and an animation on top of the scene's defaults.

use crate::error::{Error, Result};
use relume_formats::bundle::{expect_playable, sets_only};
use relume_formats::state::{Animation, MAX_EXPOSURE_EV, State};
use relume_formats::{Error as FormatError, Place};

pub use relume_formats::bundle::{Look, Scope};

/// A state, and where it came from, for messages.
#[derive(Debug, Clone)]
pub struct PlacedState {
    /// The state.
    pub state: State,
    /// Its file.
    pub place: Place,
}

impl Default for PlacedState {
    /// The scene's defaults.
    fn default() -> Self {
        Self { state: State::default(), place: Place::file("defaults") }
    }
}

/// An animation, and where it came from, for messages.
#[derive(Debug, Clone)]
pub struct PlacedAnimation {
    /// The animation.
    pub animation: Animation,
    /// Its file.
    pub place: Place,
}

/// Turns a time into a look. All it is given is checked when it is made, so playing cannot fail half-way.
#[derive(Debug)]
pub struct Controls {
    base: Look,
    scope: Scope,
    animation: Option<PlacedAnimation>,
    others: Vec<PlacedAnimation>,
}

impl Controls {
    /// Controls within `scope`: the animation to play on top of `state`, and `others` that may be chosen
    /// instead. Of these, the ones that set what does not vary are left out: another method may play them.
    ///
    /// # Errors
    /// If state or animation, at any of its key times, sets something that does not vary or leaves its legal
    /// range. The other animations must be legal on top of the scene's defaults.
    pub fn new(
        scope: Scope,
        state: &PlacedState,
        animation: Option<PlacedAnimation>,
        mut others: Vec<PlacedAnimation>,
    ) -> Result<Self> {
        let defaults = Look::default_of(&scope.scene);
        let base = placed(&defaults, state, &scope)?;
        let varies = scope.varies();
        others.retain(|other| sets_only(&other.animation, &varies));
        let animations = animation
            .iter()
            .map(|placed| (placed, &base))
            .chain(others.iter().map(|placed| (placed, &defaults)));
        for (placed, base) in animations {
            expect_playable(&placed.animation, base, &scope, &placed.place)?;
        }
        Ok(Self { base, scope, animation, others })
    }

    /// The look at `time_s`. A looping animation starts again after its end, any other is held.
    pub fn look_at(&self, time_s: f64) -> Result<Look> {
        let Some(PlacedAnimation { animation, place }) = &self.animation else {
            return Ok(self.base.clone());
        };
        let duration_s = f64::from(animation.duration_s);
        let time_s = if animation.looping { time_s.rem_euclid(duration_s) } else { time_s };
        Ok(self.base.with(&sample(animation, time_s as f32, place)?, &self.scope, place)?)
    }

    /// The look that `state` makes of the scene's defaults, without any animation.
    ///
    /// # Errors
    /// If it sets something that does not vary, or to what is not legal.
    pub fn look_of(&self, state: &PlacedState) -> Result<Look> {
        placed(&Look::default_of(&self.scope.scene), state, &self.scope)
    }

    /// The look without any animation.
    pub fn base(&self) -> &Look {
        &self.base
    }

    /// Starts from another exposure, EV, within the range that exposures have.
    pub fn expose(&mut self, ev: f32) {
        self.base.camera.exposure_ev = ev.clamp(-MAX_EXPOSURE_EV, MAX_EXPOSURE_EV);
    }

    /// What may be set.
    pub fn scope(&self) -> &Scope {
        &self.scope
    }

    pub(crate) fn scope_mut(&mut self) -> &mut Scope {
        &mut self.scope
    }

    /// The animation to play, if any, and those that may be chosen instead.
    pub fn animations(&self) -> (Option<&Animation>, impl Iterator<Item = &Animation>) {
        (
            self.animation.as_ref().map(|placed| &placed.animation),
            self.others.iter().map(|placed| &placed.animation),
        )
    }

    /// How many frames play the animation once, or 1 if there is none.
    pub fn frame_count(&self, fps: f32) -> usize {
        self.animation.as_ref().map_or(1, |a| a.animation.frame_count(fps))
    }
}

/// `defaults` as `state` has them.
fn placed(defaults: &Look, PlacedState { state, place }: &PlacedState, scope: &Scope) -> Result<Look> {
    state.expect_only(&scope.varies(), place)?;
    Ok(defaults.with(state, scope, place)?)
}

fn sample(animation: &Animation, time_s: f32, place: &Place) -> Result<State> {
    animation.sample(time_s).map_err(|reason| Error::Format(FormatError::invalid(place, reason)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;
    use relume_formats::kinds::scene;
    use relume_formats::state::{BlinnPhong, Posed};
    use std::collections::BTreeMap;

    fn controls(state: &str, animation: Option<&str>) -> Result<Controls> {
        let place = Place::file("state.toml");
        let state = PlacedState { state: relume_formats::state::parse_toml(state, &place)?, place };
        let place = Place::file("wave.toml");
        let animation = match animation {
            None => None,
            Some(text) => Some(PlacedAnimation { animation: Animation::parse("wave", text, &place)?, place }),
        };
        Controls::new(support::scope(support::scene_meta()), &state, animation, Vec::new())
    }

    const WAVE: &str = "duration_s = 2.0\nloop = true\n[[key]]\nt_s = 0\nmaterials.a.kd = [0.0, 0.0, 0.0]\ncamera.exposure_ev = 1.0\n\
                        [[key]]\nt_s = 1\nmaterials.a.kd = [0.4, 0.4, 0.4]\n[[key]]\nt_s = 2\nmaterials.a.kd = [0.0, 0.0, 0.0]\n";

    #[test]
    fn defaults_then_state_then_animation() {
        let defaults = controls("", None).unwrap().look_at(0.0).unwrap();
        let controls = controls(
            "camera.exposure_ev = -3.0\nmaterials.a.shininess = 77\nmaterials.b.kd = [0.1, 0.1, 0.1]",
            Some(WAVE),
        )
        .unwrap();
        let look = controls.look_at(0.5).unwrap();
        assert_eq!(
            support::blinn_phong(look.materials["a"]),
            BlinnPhong { kd: [0.2; 3], shininess: 77.0, ..support::blinn_phong(defaults.materials["a"]) }
        );
        assert_eq!((support::blinn_phong(look.materials["b"]).kd, look.camera.exposure_ev), ([0.1; 3], 1.0));
        assert_eq!(controls.look_at(4.5).unwrap(), look, "a loop starts again");
        assert_eq!(controls.frame_count(30.0), 60);
    }

    #[test]
    fn without_loop_the_end_is_held() {
        let once = WAVE
            .replace("loop = true", "loop = false")
            .replace("t_s = 2\nmaterials.a.kd = [0.0, 0.0, 0.0]", "t_s = 2\nmaterials.a.shininess = 9");
        let controls = controls("", Some(&once)).unwrap();
        assert_eq!(support::blinn_phong(controls.look_at(50.0).unwrap().materials["a"]).kd, [0.4; 3]);
    }

    #[test]
    fn a_shape_shows_what_state_and_animation_say_or_rests() {
        use relume_formats::kinds::scene::{StoredClip, StoredShape};
        let clip = |name: &str| StoredClip { name: name.to_owned(), duration_s: 2.0 };
        let shape = StoredShape { object: "thing".to_owned(), clips: ["Walk", "Run"].map(clip).to_vec() };
        let scene = scene::Meta { varies_shape: true, shapes: vec![shape], ..support::scene_meta() };
        let place = Place::file("s.toml");
        let look = |base: &Look, text: &str| {
            base.with(
                &relume_formats::state::parse_toml(text, &place).unwrap(),
                &support::scope(scene.clone()),
                &place,
            )
        };
        let rest = Look::default_of(&scene);
        assert!(rest.shapes.is_empty());
        let walking = look(&rest, "shapes.thing = { clip = 'Walk', time_s = 0.5 }").unwrap();
        let shows = |clip: &str, time_s| {
            BTreeMap::from([("thing".to_owned(), Posed { clip: clip.to_owned(), time_s })])
        };
        assert_eq!(walking.shapes, shows("Walk", 0.5));
        assert_eq!(look(&walking, "shapes.thing.time_s = 7").unwrap().shapes, shows("Walk", 7.0));
        assert_eq!(look(&walking, "shapes.thing.clip = 'Run'").unwrap().shapes, shows("Run", 0.5));
        assert_eq!(look(&walking, "").unwrap().shapes, walking.shapes);
        let message = look(&rest, "shapes.thing.clip = 'Fly'").unwrap_err().to_string();
        assert!(message.contains("s.toml: shape `thing`: no clip `Fly`; it has `Walk`, `Run`"), "{message}");
    }

    #[test]
    fn what_does_not_vary_or_is_out_of_range_is_refused() {
        for (state, animation, part) in [
            ("materials.fixed.kd = [0.1, 0.1, 0.1]", None, "state.toml: sets material `fixed`"),
            ("camera.fov_deg = 20.0", None, "state.toml: sets the camera"),
            ("materials.a.shininess = 300", None, "shininess 300 is outside"),
            ("camera.exposure_ev = 99", None, "exposure_ev 99 is outside"),
            (
                "",
                Some(WAVE.replace("materials.a", "materials.fixed")),
                "wave.toml: at 0 s: sets material `fixed`",
            ),
            (
                "",
                Some(WAVE.replace("[0.4, 0.4, 0.4]", "[0.95, 0.4, 0.4]")),
                "wave.toml: at 1 s: material `a`: kd + ks",
            ),
            (
                "materials.a.ks = [0.7, 0.7, 0.7]\nmaterials.a.kd = [0, 0, 0]",
                Some(WAVE.to_owned()),
                "exceeds 1",
            ),
        ] {
            let error = controls(state, animation.as_deref()).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
            assert!(matches!(&error, Error::Format(error) if error.is_bad_input()), "{error}");
        }
    }
}
