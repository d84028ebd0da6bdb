//! Random states of what a scene varies: the same states for every method and every setting.

use glam::{Quat, Vec3, Vec3A};
use relume_bake::brdf;
use relume_bake::methods::transfer_images::held_out::{self, random_state};
use relume_bake::trace::sampler::PixelSampler;
use relume_bake::trace::world::World;
use relume_formats::container::replace_file;
use relume_formats::state::{
    BlinnPhong, Brdf, CameraState, EnvironmentState, MaterialState, ShapeState, State,
};
use relume_formats::{Error, Place, Result};
use relume_scenes::Scene;
use std::f32::consts::{PI, TAU};
use std::path::Path;

/// How many places of the camera are tried.
const PLACES: u32 = 64;
/// Side of the film on which they are judged, pixels.
const LOOKS: u32 = 24;
/// The most that a material of Blinn-Phong reflects of light from everywhere: its lobe, normalised over half
/// vectors, may give twice what it gets, and in a room light would then grow without end.
const MOST_REFLECTED: f32 = 0.9;
/// Pairs of directions by which that is told.
const PAIRS: u32 = 4096;
/// Seed of what is not a material.
const SEED: u64 = 0x7374_6174_6573;

/// State number `number` of `scene`, which names everything that varies: materials of any kind, any of the
/// maps turned anyhow, the camera anywhere around its target where no surface is in its way that turns its
/// back on it, moments of clips. None of these is one that a bake chooses its settings by.
pub fn random(scene: &Scene, number: u32) -> State {
    let sampler = PixelSampler::new(SEED, number);
    let pair = |pair| sampler.sample(0).pair(pair);
    State {
        environment: scene.vary.light.then(|| environment(scene, pair(0))),
        camera: scene.vary.view.then(|| camera(scene, &sampler)),
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

/// The first of some places around the target from which no more surfaces are seen from behind than from
/// where the scene's camera is: rooms are looked into where they are open. Without any, the scene's own.
fn camera(scene: &Scene, sampler: &PixelSampler) -> CameraState {
    let world = World::new(scene);
    let behind = |state: &CameraState| {
        let place = Place::file(&scene.file);
        let placed = scene.with_state(&State { camera: Some(state.clone()), ..State::default() }, &place);
        placed.map_or(usize::MAX, |placed| seen_from_behind(&placed, &world))
    };
    let own = CameraState {
        position: Some(scene.camera.position),
        target: Some(scene.camera.target),
        ..CameraState::default()
    };
    let allowed = behind(&own);
    let places = (0..PLACES).map(|place| {
        let sample = sampler.sample(place);
        somewhere(scene, sample.pair(1), sample.pair(2)[0])
    });
    places.into_iter().find(|state| behind(state) <= allowed).unwrap_or(own)
}

/// On a coarse film, the pixels that show the back of a surface.
fn seen_from_behind(scene: &Scene, world: &World) -> usize {
    let film = scene.camera.film(LOOKS, LOOKS);
    let pixels = (0..LOOKS * LOOKS).map(|pixel| [pixel % LOOKS, pixel / LOOKS].map(|p| p as f32 + 0.5));
    let is_behind = |[x, y]: &[f32; 2]| {
        world.intersect(film.eye_in_world, film.direction(*x, *y)).is_some_and(|surface| !surface.front)
    };
    pixels.filter(is_behind).count()
}

/// Anywhere around the target, up to 1.5 times as high above it and 0.8 to 1.2 times as far.
fn somewhere(scene: &Scene, [turn, height]: [f32; 2], distance: f32) -> CameraState {
    let target = Vec3::from(scene.camera.target);
    let offset = Vec3::from(scene.camera.position) - target;
    let raised = Vec3::new(offset.x, offset.y * (0.75 + 0.75 * height), offset.z).normalize_or_zero();
    let offset = Quat::from_rotation_y(TAU * turn) * raised * offset.length() * (0.8 + 0.4 * distance);
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
        .map(|(name, brdf)| (name, MaterialState::from(dimmed(brdf))))
        .collect()
}

/// `material`, its colours dimmed as far as it reflects more than [`MOST_REFLECTED`].
fn dimmed(material: Brdf) -> Brdf {
    let Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) = material else { return material };
    let share = (MOST_REFLECTED / reflected(&material)).min(1.0);
    let [kd, ks] = [kd, ks].map(|colour| colour.map(|channel| channel * share));
    Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess })
}

/// What a material reflects of light from everywhere to everywhere, in the channel of the most.
fn reflected(material: &Brdf) -> f32 {
    // By the cosine, so that the mean of π times the BRDF is what is sought.
    let direction = |[u, v]: [f32; 2]| {
        let (sin, cos) = (TAU * v).sin_cos();
        Vec3A::new(u.sqrt() * cos, (1.0 - u).sqrt(), u.sqrt() * sin)
    };
    let sampler = PixelSampler::new(SEED, 0);
    let pair = |index| {
        let [incoming, outgoing] = [0, 1].map(|pair| direction(sampler.sample(index).pair(pair)));
        brdf::evaluate(material, Vec3A::ONE, &brdf::angles(incoming, outgoing, Vec3A::Y))
    };
    PI / PAIRS as f32 * (0..PAIRS).map(pair).sum::<Vec3A>().max_element()
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

    /// From behind its walls a room shows nothing that was baked.
    #[test]
    fn rooms_are_looked_into_where_they_are_open() {
        let scene = library("knot-studio");
        let world = World::new(&scene);
        let mut places = std::collections::BTreeSet::new();
        for number in 0..8 {
            let state = State { environment: None, materials: Default::default(), ..random(&scene, number) };
            let placed = scene.with_state(&state, &Place::file("state")).unwrap();
            assert_eq!(seen_from_behind(&placed, &world), 0, "{:?}", placed.camera.position);
            places.insert(placed.camera.position.map(f32::to_bits));
        }
        assert_eq!(places.len(), 8, "the eye moves");
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

    /// A matt material reflects its colour; a lobe of exponent 1 reflects 1.2 of its own
    /// (`tests/later.rs` has that in closed form), and none is left that reflects more than it may.
    #[test]
    fn no_material_makes_light() {
        let of = |kd: f32, ks: f32, shininess| {
            Brdf::BlinnPhong(BlinnPhong { kd: [kd, 0.0, 0.1], ks: [ks, 0.0, 0.0], shininess })
        };
        assert!((reflected(&of(0.7, 0.0, 9.0)) - 0.7).abs() < 1e-3);
        assert!((reflected(&of(0.0, 1.0, 1.0)) - 1.2001).abs() < 0.01);
        assert_eq!(dimmed(of(0.5, 0.1, 5.0)), of(0.5, 0.1, 5.0));
        for bright in [of(1.0, 0.0, 9.0), of(0.0, 1.0, 200.0), of(0.3, 0.7, 30.0)] {
            assert!((reflected(&dimmed(bright)) - MOST_REFLECTED).abs() < 1e-3);
        }
    }
}
