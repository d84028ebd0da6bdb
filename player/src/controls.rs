//! What the user sets: a state and an animation on top of the scene's defaults.

use crate::error::{Error, Result};
use glam::Vec3;
use relume_formats::container::Kind;
use relume_formats::kinds::scene::{self, EnvironmentLook, StoredMaterial};
use relume_formats::near::did_you_mean;
use relume_formats::state::{Animation, Brdf, Camera, Posed, State, Varies};
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

/// What of a scene may be set, and to what.
#[derive(Debug, Clone)]
pub struct Scope {
    /// The scene.
    pub scene: scene::Meta,
    /// Kind of the main file of the method that plays, which decides what varies.
    pub kind: Kind,
    /// The environment maps that there are.
    pub maps: Vec<String>,
}

/// How the scene looks at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Parameters of every material, by name.
    pub materials: BTreeMap<String, Brdf>,
    /// The camera and its exposure.
    pub camera: Camera,
    /// The environment, if the scene has one.
    pub environment: Option<EnvironmentLook>,
    /// What objects that deform show, by name; those that rest are not there.
    pub shapes: BTreeMap<String, Posed>,
}

/// Turns a time into a look. All it is given is checked when it is made, so playing cannot fail half-way.
#[derive(Debug)]
pub struct Controls {
    base: Look,
    scope: Scope,
    animation: Option<PlacedAnimation>,
    others: Vec<PlacedAnimation>,
}

impl Scope {
    /// What may change at playback.
    pub fn varies(&self) -> Varies<'_> {
        self.scene.varies(self.kind)
    }

    /// The materials that may be edited, in the order of the scene.
    pub fn materials(&self) -> impl Iterator<Item = &StoredMaterial> {
        let varying = self.varies().materials;
        self.scene.materials.iter().filter(move |material| varying.contains(&material.name.as_str()))
    }
}

impl Controls {
    /// Controls within `scope`: the animation to play on top of `state`, and `others` that may be chosen instead. Of these, the ones that set what
    /// does not vary are left out: another method may play them.
    ///
    /// # Errors
    /// If state or animation, at any of its key times, sets something that does not vary or leaves its legal range. The other animations
    /// must be legal on top of the scene's defaults.
    pub fn new(scope: Scope, state: &PlacedState, animation: Option<PlacedAnimation>, mut others: Vec<PlacedAnimation>) -> Result<Self> {
        let varies = scope.varies();
        state.state.expect_only(&varies, &state.place)?;
        let defaults = Look::default_of(&scope.scene);
        let base = defaults.with(&state.state, &scope, &state.place)?;
        if let Some(animation) = &animation {
            for time_s in animation.animation.key_times_s() {
                let place = animation.place.part(format!("at {time_s} s"));
                sample(&animation.animation, time_s, &place)?.expect_only(&varies, &place)?;
            }
            check_keys(animation, &base, &scope)?;
        }
        others.retain(|other| sets_only(&other.animation, &varies));
        others.iter().try_for_each(|other| check_keys(other, &defaults, &scope))?;
        Ok(Self { base, scope, animation, others })
    }

    /// The look at `time_s`. A looping animation starts again after its end, any other is held.
    pub fn look_at(&self, time_s: f64) -> Result<Look> {
        let Some(PlacedAnimation { animation, place }) = &self.animation else { return Ok(self.base.clone()) };
        let duration_s = f64::from(animation.duration_s);
        let time_s = if animation.looping { time_s.rem_euclid(duration_s) } else { time_s };
        self.base.with(&sample(animation, time_s as f32, place)?, &self.scope, place)
    }

    /// The look without any animation.
    pub fn base(&self) -> &Look {
        &self.base
    }

    /// What may be set.
    pub fn scope(&self) -> &Scope {
        &self.scope
    }

    /// The animation to play, if any, and those that may be chosen instead.
    pub fn animations(&self) -> (Option<&Animation>, impl Iterator<Item = &Animation>) {
        (self.animation.as_ref().map(|placed| &placed.animation), self.others.iter().map(|placed| &placed.animation))
    }

    /// How many frames play the animation once, or 1 if there is none.
    pub fn frame_count(&self, fps: f32) -> usize {
        self.animation.as_ref().map_or(1, |a| a.animation.frame_count(fps))
    }
}

/// Whether an animation sets nothing but what varies.
fn sets_only(animation: &Animation, varies: &Varies<'_>) -> bool {
    // Every track has a value at any time, so one moment tells.
    animation.sample(0.0).is_ok_and(|state| state.expect_only(varies, &Place::file(&animation.name)).is_ok())
}

/// If the looks at all keys are legal, so is everything between, but for the one thing that is not convex: a camera must not meet its target.
fn check_keys(placed: &PlacedAnimation, base: &Look, scope: &Scope) -> Result<()> {
    let mut last: Option<Camera> = None;
    for time_s in placed.animation.key_times_s() {
        let place = placed.place.part(format!("at {time_s} s"));
        let camera = base.with(&sample(&placed.animation, time_s, &place)?, scope, &place)?.camera;
        if last.is_some_and(|last| passes_its_target(&last, &camera)) {
            let reason = "camera: on the way here the position meets the target; add a key that leads around it";
            return Err(FormatError::invalid(&place, reason).into());
        }
        last = Some(camera);
    }
    Ok(())
}

/// Whether the way from target to position, linear between two moments, comes to nothing in between.
fn passes_its_target(from: &Camera, to: &Camera) -> bool {
    let way = |camera: &Camera| Vec3::from(camera.position) - Vec3::from(camera.target);
    let (from, to) = (way(from), way(to));
    from.dot(to) < 0.0 && from.cross(to).length() <= 1e-5 * from.length() * to.length()
}

fn sample(animation: &Animation, time_s: f32, place: &Place) -> Result<State> {
    animation.sample(time_s).map_err(|reason| Error::Format(FormatError::invalid(place, reason)))
}

impl Look {
    /// How the scene file has it.
    pub fn default_of(scene: &scene::Meta) -> Self {
        let materials = scene.materials.iter().map(|material| (material.name.clone(), material.brdf)).collect();
        Self { materials, camera: scene.camera, environment: scene.environment.clone(), shapes: BTreeMap::new() }
    }

    /// The look at another exposure.
    pub fn exposed(&self, exposure_ev: f32) -> Self {
        Self { camera: Camera { exposure_ev, ..self.camera }, ..self.clone() }
    }

    fn with(&self, state: &State, scope: &Scope, place: &Place) -> Result<Self> {
        let mut look = self.clone();
        for material in &scope.scene.materials {
            if let (Some(brdf), Some(change)) = (look.materials.get_mut(&material.name), state.materials.get(&material.name)) {
                *brdf = material.with(brdf, change, place)?;
            }
        }
        for shape in &scope.scene.shapes {
            let Some(change) = state.shapes.get(&shape.object) else { continue };
            if let Some(posed) = shape.with(self.shapes.get(&shape.object), change, place)? {
                look.shapes.insert(shape.object.clone(), posed);
            }
        }
        if let Some(change) = &state.camera {
            look.camera = self.camera.with(change, place)?;
        }
        if let (Some(environment), Some(change)) = (&mut look.environment, &state.environment) {
            *environment = environment.with(change, place)?;
            if !scope.maps.contains(&environment.map) {
                let meant = did_you_mean(&environment.map, scope.maps.iter().map(String::as_str));
                let reason = format!("environment: no map `{}`; this bundle has: {}{meant}", environment.map, scope.maps.join(", "));
                return Err(FormatError::invalid(place, reason).into());
            }
        }
        Ok(look)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;
    use relume_formats::state::BlinnPhong;

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
        let controls =
            controls("camera.exposure_ev = -3.0\nmaterials.a.shininess = 77\nmaterials.b.kd = [0.1, 0.1, 0.1]", Some(WAVE)).unwrap();
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
            base.with(&relume_formats::state::parse_toml(text, &place).unwrap(), &support::scope(scene.clone()), &place)
        };
        let rest = Look::default_of(&scene);
        assert!(rest.shapes.is_empty());
        let walking = look(&rest, "shapes.thing = { clip = 'Walk', time_s = 0.5 }").unwrap();
        let shows = |clip: &str, time_s| BTreeMap::from([("thing".to_owned(), Posed { clip: clip.to_owned(), time_s })]);
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
