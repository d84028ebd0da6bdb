//! What the user sets: a state and an animation on top of the scene's defaults.

use crate::error::{Error, Result};
use relume_formats::kinds::scene;
use relume_formats::state::{Animation, BlinnPhong, Camera, State, Varies};
use relume_formats::{Error as FormatError, Place};
use std::collections::BTreeMap;

/// A state, and where it came from, for messages.
#[derive(Debug, Clone)]
pub struct PlacedState {
    /// The state.
    pub state: State,
    /// Its file.
    pub place: Place,
}

/// An animation, and where it came from, for messages.
#[derive(Debug, Clone)]
pub struct PlacedAnimation {
    /// The animation.
    pub animation: Animation,
    /// Its file.
    pub place: Place,
}

/// How the scene looks at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Parameters of every material, by name.
    pub materials: BTreeMap<String, BlinnPhong>,
    /// Exposure: the display shows 2^ev times the radiance.
    pub exposure_ev: f32,
}

/// Turns a time into a look. All it is given is checked when it is made, so playing cannot fail half-way.
#[derive(Debug)]
pub struct Controls {
    base: Look,
    camera: Camera,
    animation: Option<PlacedAnimation>,
}

impl Controls {
    /// Controls for the scene `meta`.
    ///
    /// # Errors
    /// If state or animation, at any of its key times, sets something that does not vary or leaves its legal range.
    pub fn new(meta: &scene::Meta, state: &PlacedState, animation: Option<PlacedAnimation>) -> Result<Self> {
        let varies = Varies { materials: meta.materials.iter().filter(|m| m.varies).map(|m| m.name.as_str()).collect() };
        state.state.expect_only(&varies, &state.place)?;
        let defaults =
            Look { materials: meta.materials.iter().map(|m| (m.name.clone(), m.brdf)).collect(), exposure_ev: meta.camera.exposure_ev };
        let base = defaults.with(&state.state, &meta.camera, &state.place)?;
        let controls = Self { base, camera: meta.camera, animation };
        controls.check_keys(&varies)?;
        Ok(controls)
    }

    /// If the states at all keys are legal, so is everything between.
    fn check_keys(&self, varies: &Varies<'_>) -> Result<()> {
        let Some(PlacedAnimation { animation, place }) = &self.animation else { return Ok(()) };
        for time_s in animation.key_times_s() {
            let place = place.part(format!("at {time_s} s"));
            let state = sample(animation, time_s, &place)?;
            state.expect_only(varies, &place)?;
            self.base.with(&state, &self.camera, &place)?;
        }
        Ok(())
    }

    /// The look at `time_s`. A looping animation starts again after its end, any other is held.
    pub fn look_at(&self, time_s: f64) -> Result<Look> {
        let Some(PlacedAnimation { animation, place }) = &self.animation else { return Ok(self.base.clone()) };
        let duration_s = f64::from(animation.duration_s);
        let time_s = if animation.looping { time_s.rem_euclid(duration_s) } else { time_s };
        self.base.with(&sample(animation, time_s as f32, place)?, &self.camera, place)
    }

    /// How many frames play the animation once, or 1 if there is none.
    pub fn frame_count(&self, fps: f32) -> usize {
        self.animation.as_ref().map_or(1, |a| a.animation.frame_count(fps))
    }
}

fn sample(animation: &Animation, time_s: f32, place: &Place) -> Result<State> {
    animation.sample(time_s).map_err(|reason| Error::Format(FormatError::invalid(place, reason)))
}

impl Look {
    fn with(&self, state: &State, camera: &Camera, place: &Place) -> Result<Self> {
        let mut look = self.clone();
        for (name, change) in &state.materials {
            if let Some(material) = look.materials.get_mut(name) {
                *material = material.with(change, name, place)?;
            }
        }
        if let Some(change) = &state.camera {
            let camera = Camera { exposure_ev: self.exposure_ev, ..*camera };
            look.exposure_ev = camera.with(change, place)?.exposure_ev;
        }
        Ok(look)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;

    fn controls(state: &str, animation: Option<&str>) -> Result<Controls> {
        let place = Place::file("state.toml");
        let state = PlacedState { state: relume_formats::state::parse_toml(state, &place)?, place };
        let place = Place::file("wave.toml");
        let animation = match animation {
            None => None,
            Some(text) => Some(PlacedAnimation { animation: Animation::parse("wave", text, &place)?, place }),
        };
        Controls::new(&support::scene_meta(), &state, animation)
    }

    const WAVE: &str = "duration_s = 2.0\nloop = true\n[[key]]\nt_s = 0\nmaterials.a.kd = [0.0, 0.0, 0.0]\ncamera.exposure_ev = 1.0\n\
                        [[key]]\nt_s = 1\nmaterials.a.kd = [0.4, 0.4, 0.4]\n[[key]]\nt_s = 2\nmaterials.a.kd = [0.0, 0.0, 0.0]\n";

    #[test]
    fn defaults_then_state_then_animation() {
        let defaults = controls("", None).unwrap().look_at(0.0).unwrap();
        let controls =
            controls("camera.exposure_ev = -3.0\nmaterials.a.shininess = 77\nmaterials.b.kd = [0.1, 0.1, 0.1]", Some(WAVE)).unwrap();
        let look = controls.look_at(0.5).unwrap();
        assert_eq!(
            (look.materials["a"].kd, look.materials["a"].shininess, look.materials["a"].ks),
            ([0.2; 3], 77.0, defaults.materials["a"].ks)
        );
        assert_eq!((look.materials["b"].kd, look.exposure_ev), ([0.1; 3], 1.0));
        assert_eq!(controls.look_at(4.5).unwrap(), look, "a loop starts again");
        assert_eq!(controls.frame_count(30.0), 60);
    }

    #[test]
    fn without_loop_the_end_is_held() {
        let once = WAVE
            .replace("loop = true", "loop = false")
            .replace("t_s = 2\nmaterials.a.kd = [0.0, 0.0, 0.0]", "t_s = 2\nmaterials.a.shininess = 9");
        let controls = controls("", Some(&once)).unwrap();
        assert_eq!(controls.look_at(50.0).unwrap().materials["a"].kd, [0.4; 3]);
    }

    #[test]
    fn what_does_not_vary_or_is_out_of_range_is_refused() {
        for (state, animation, part) in [
            ("materials.fixed.kd = [0.1, 0.1, 0.1]", None, "state.toml: sets material `fixed`"),
            ("camera.fov_deg = 20.0", None, "state.toml: sets the camera"),
            ("materials.a.shininess = 300", None, "shininess 300 is outside"),
            ("camera.exposure_ev = 99", None, "exposure_ev 99 is outside"),
            ("", Some(WAVE.replace("materials.a", "materials.fixed")), "wave.toml: at 0 s: sets material `fixed`"),
            ("", Some(WAVE.replace("[0.4, 0.4, 0.4]", "[0.95, 0.4, 0.4]")), "wave.toml: at 1 s: material `a`: kd + ks"),
            ("materials.a.ks = [0.7, 0.7, 0.7]\nmaterials.a.kd = [0, 0, 0]", Some(WAVE.to_owned()), "exceeds 1"),
        ] {
            let error = controls(state, animation.as_deref()).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
            assert_eq!(error.exit_code(), 2);
        }
    }
}
