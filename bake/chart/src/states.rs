//! Random states of what a scene varies: the same states for every method and every setting.

use glam::{Quat, Vec3};
use relume_bake::methods::transfer_images::held_out::{self, random_state};
use relume_bake::trace::sampler::PixelSampler;
use relume_formats::container::replace_file;
use relume_formats::state::{CameraState, EnvironmentState, MaterialState, ShapeState, State};
use relume_formats::{Error, Place, Result};
use relume_scenes::Scene;
use std::path::Path;

/// Seed of what is not a material.
const SEED: u64 = 0x7374_6174_6573;

/// State number `number` of `scene`, which names everything that varies: materials of any kind, any of the
/// maps turned anyhow, the camera anywhere on a ring around its target, moments of clips. None of these is
/// one that a bake chooses its settings by.
pub fn random(scene: &Scene, number: u32) -> State {
    let sampler = PixelSampler::new(SEED, number);
    let pair = |pair| sampler.sample(0).pair(pair);
    State {
        environment: scene.vary.light.then(|| environment(scene, pair(0))),
        camera: scene.vary.view.then(|| camera(scene, pair(1), pair(2)[0])),
        materials: materials(scene, number),
        shapes: (3..)
            .zip(clips(scene))
            .map(|(at, (object, clips))| (object.to_owned(), moment(&clips, pair(at))))
            .collect(),
        ..State::default()
    }
}

fn environment(scene: &Scene, [which, turn]: [f32; 2]) -> EnvironmentState {
    let maps: Vec<&str> = scene
        .environment
        .iter()
        .flat_map(|e| [&e.map].into_iter().chain(&e.others))
        .map(|map| map.name.as_str())
        .collect();
    let map = maps.get((which * maps.len() as f32) as usize).map(|name| (*name).to_owned());
    EnvironmentState { map, rotation_deg: Some(360.0 * turn), gain: None }
}

/// Anywhere around the target, up to 1.5 times as high above it and 0.8 to 1.2 times as far.
fn camera(scene: &Scene, [turn, height]: [f32; 2], distance: f32) -> CameraState {
    let target = Vec3::from(scene.camera.target);
    let offset = Vec3::from(scene.camera.position) - target;
    let raised = Vec3::new(offset.x, offset.y * (0.75 + 0.75 * height), offset.z).normalize_or_zero();
    let offset = Quat::from_rotation_y(std::f32::consts::TAU * turn)
        * raised
        * offset.length()
        * (0.8 + 0.4 * distance);
    CameraState {
        position: Some((target + offset).to_array()),
        target: Some(scene.camera.target),
        ..CameraState::default()
    }
}

fn materials(scene: &Scene, number: u32) -> std::collections::BTreeMap<String, MaterialState> {
    let names = scene.vary.materials.iter().map(|index| scene.materials[*index].name.clone());
    names
        .zip(random_state(held_out::STATES + number, scene))
        .map(|(name, brdf)| (name, MaterialState::from(brdf)))
        .collect()
}

/// Objects that deform, with names and durations of their clips.
fn clips(scene: &Scene) -> impl Iterator<Item = (&str, Vec<(&str, f32)>)> {
    let deforming =
        scene.objects.iter().filter_map(|object| Some((object.name.as_str(), object.shape.as_deref()?)));
    let deforming = deforming.filter(|(_, shape)| scene.vary.shape && !shape.clips.is_empty());
    deforming.map(|(name, shape)| {
        (name, shape.clips.iter().map(|clip| (clip.name.as_str(), clip.duration_s)).collect())
    })
}

fn moment(clips: &[(&str, f32)], [which, time]: [f32; 2]) -> ShapeState {
    let clip = clips.get((which * clips.len() as f32) as usize);
    ShapeState {
        clip: clip.map(|(name, _)| (*name).to_owned()),
        time_s: clip.map(|(_, duration_s)| time * duration_s),
        ..ShapeState::default()
    }
}

/// Writes `states` as an animation with state i at i seconds.
///
/// # Errors
/// If the file cannot be written.
pub fn write_animation(states: &[State], path: &Path) -> Result<()> {
    let place = Place::file(path);
    let failed = |e: toml::ser::Error| Error::invalid(&place, e.to_string());
    let key = |(number, state): (usize, &State)| {
        let mut key = toml::Table::try_from(state).map_err(failed)?;
        key.insert("t_s".to_owned(), toml::Value::Float(number as f64));
        Ok(toml::Value::Table(key))
    };
    let keys = states.iter().enumerate().map(key).collect::<Result<Vec<_>>>()?;
    let duration_s = toml::Value::Integer(states.len().max(1) as i64);
    let animation = toml::Table::from_iter([
        ("duration_s".to_owned(), duration_s),
        ("key".to_owned(), toml::Value::Array(keys)),
    ]);
    replace_file(path, toml::to_string(&animation).map_err(failed)?.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::state::Animation;

    fn library(name: &str) -> Scene {
        relume_scenes::load(&relume_scenes::resolve(name).unwrap()).unwrap()
    }

    #[test]
    fn states_name_what_varies_and_nothing_else() {
        for name in ["cornell-knot", "showroom", "knot-outdoors", "knot-twist"] {
            let scene = library(name);
            for number in 0..4 {
                let state = random(&scene, number);
                assert_eq!(state.environment.is_some(), scene.vary.light, "{name}");
                assert_eq!(state.camera.is_some(), scene.vary.view, "{name}");
                assert_eq!(state.materials.len(), scene.vary.materials.len(), "{name}");
                assert_eq!(state.shapes.is_empty(), !scene.vary.shape, "{name}");
                scene.with_state(&state, &Place::file(name)).unwrap();
                assert_ne!(state, random(&scene, number + 1), "{name}");
            }
        }
    }

    #[test]
    fn an_animation_shows_each_state_at_its_second() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["showroom", "knot-twist"] {
            let (scene, path) = (library(name), folder.path().join("states.toml"));
            let states: Vec<State> = (0..5).map(|number| random(&scene, number)).collect();
            write_animation(&states, &path).unwrap();
            let animation = Animation::read_file(&path).unwrap();
            for (number, state) in states.iter().enumerate() {
                assert_eq!(&animation.sample(number as f32).unwrap(), state, "{name} {number}");
            }
        }
    }

    #[test]
    fn cameras_stay_around_their_target_and_above_it() {
        let scene = library("knot-twist");
        let (target, from) = (Vec3::from(scene.camera.target), Vec3::from(scene.camera.position));
        let mut turns = Vec::new();
        for number in 0..64 {
            let offset = Vec3::from(random(&scene, number).camera.unwrap().position.unwrap()) - target;
            let farther = offset.length() / (from - target).length();
            assert!((0.8..1.2 + 1e-5).contains(&farther) && offset.y > 0.0, "{offset}");
            turns.push(offset.z.atan2(offset.x));
        }
        turns.sort_by(f32::total_cmp);
        assert!(turns[0] < -2.5 && turns[63] > 2.5, "all around");
    }
}
