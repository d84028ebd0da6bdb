//! What a change makes of a look, and how it is undone.

use crate::support::samples::Random;
use crate::support::scenes;
use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::bundle::{Look, Scope};
use relume_formats::display::Tonemap;
use relume_formats::kinds::scene::Meta;
use relume_formats::method::SPHERE_SHADOWS;
use relume_formats::state::{
    Brdf, CameraState, EnvironmentState, LightState, MaterialState, Model, Pose, ShapeState, State,
    ViewState, parse_toml,
};
use std::collections::BTreeMap;

fn place() -> Place {
    Place::file("s.toml")
}

fn state(text: &str) -> State {
    parse_toml(text, &place()).unwrap()
}

/// Of a scene with deforming objects of one clip and of two, where the seed is even.
fn scope(seed: u64) -> Scope {
    let mut scene = scenes::scene(seed).meta;
    scene.shapes.iter_mut().skip(1).step_by(2).for_each(|shape| shape.clips.truncate(1));
    Scope { scene, card: &SPHERE_SHADOWS, maps: ["sky.exr", "other.exr"].map(str::to_owned).to_vec() }
}

/// A value, once in a while.
fn some<T>(random: &mut Random, value: impl FnOnce(&mut Random) -> T) -> Option<T> {
    let named = random.below(2) == 0;
    named.then(|| value(random))
}

/// Now and then -0, which is equal to 0 and yet another.
fn number(random: &mut Random) -> f32 {
    if random.below(4) == 0 { -0.0 } else { random.unit() }
}

fn colour(random: &mut Random) -> [f32; 3] {
    [(); 3].map(|()| number(random) * 0.6)
}

fn material(random: &mut Random, model: Model) -> MaterialState {
    match model {
        Model::BlinnPhong => MaterialState {
            kd: some(random, colour),
            ks: some(random, colour),
            shininess: some(random, |random| 1.0 + 199.0 * random.unit()),
            ..MaterialState::default()
        },
        Model::Ggx => MaterialState {
            base_color: some(random, colour),
            metallic: some(random, |_| -0.0),
            roughness: some(random, |random| 0.4 + 0.6 * random.unit()),
            ..MaterialState::default()
        },
        Model::CookTorrance => MaterialState {
            kd: some(random, colour),
            ks: some(random, colour),
            fresnel: some(random, number),
            roughness: some(random, |random| 0.1 + 0.9 * random.unit()),
            ..MaterialState::default()
        },
    }
}

fn shape(random: &mut Random) -> ShapeState {
    ShapeState {
        clip: some(random, |random| ["", "Läufer"][random.below(2)].to_owned()),
        time_s: some(random, |random| 9.0 * number(random) - 4.5),
        pose: some(random, |random| [Pose::Rest, Pose::Rest, Pose::Clip][random.below(3)]),
    }
}

/// A change of what `scene` has; most are legal.
fn change(random: &mut Random, scene: &Meta) -> State {
    let camera = |random: &mut Random| CameraState {
        position: some(random, |random| [(); 3].map(|()| 10.0 * number(random))),
        target: some(random, |random| [20.0, number(random), -0.0]),
        fov_deg: some(random, |random| 10.0 + 100.0 * random.unit()),
        exposure_ev: some(random, |random| 40.0 * random.signed()),
    };
    let environment = |random: &mut Random| EnvironmentState {
        map: some(random, |random| ["sky.exr", "other.exr"][random.below(2)].to_owned()),
        rotation_deg: some(random, |random| 360.0 * number(random)),
        gain: some(random, colour),
    };
    let materials = scene
        .materials
        .iter()
        .filter_map(|m| Some((m.name.clone(), some(random, |random| material(random, m.brdf.model()))?)));
    let materials = materials.collect();
    let shapes = scene.shapes.iter().filter_map(|s| Some((s.object.clone(), some(random, shape)?))).collect();
    let environment = scene.environment.is_some().then(|| some(random, environment)).flatten();
    let view =
        some(random, |random| ViewState { tonemap: some(random, |random| Tonemap::ALL[random.below(3)]) });
    State { environment, camera: some(random, camera), view, lights: BTreeMap::new(), materials, shapes }
}

/// All that a look has, in digits that tell every two numbers apart, 0 and -0 too.
fn digits(look: &Look, scene: &Meta) -> String {
    let materials: Vec<&Brdf> =
        scene.materials.iter().map(|material| &look.materials[&material.name]).collect();
    format!("{materials:?} {:?} {:?} {:?} {:?}", look.camera, look.tonemap, look.environment, look.shapes)
}

/// The state that names every leaf of a look, as a table. Shapes have a rule of their own.
fn complete(look: &Look, scene: &Meta) -> toml::Table {
    let all = State {
        environment: look.environment.as_ref().map(|now| EnvironmentState {
            map: Some(now.map.clone()),
            rotation_deg: Some(now.rotation_deg),
            gain: Some(now.gain),
        }),
        camera: Some(CameraState {
            position: Some(look.camera.position),
            target: Some(look.camera.target),
            fov_deg: Some(look.camera.fov_deg),
            exposure_ev: Some(look.camera.exposure_ev),
        }),
        view: Some(ViewState { tonemap: Some(look.tonemap) }),
        materials: scene
            .materials
            .iter()
            .map(|m| (m.name.clone(), MaterialState::from(look.materials[&m.name])))
            .collect(),
        ..State::default()
    };
    toml::Table::try_from(all).unwrap()
}

/// Puts the leaves of `above` over those of `table`.
fn lay_over(table: &mut toml::Table, above: toml::Table) {
    for (key, value) in above {
        match (table.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => lay_over(below, above),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Along a walk of random changes, of which some are illegal.
    #[test]
    fn a_change_replaces_what_it_names_and_its_inverse_leads_back(seed: u64) {
        let (scope, random) = (scope(seed), &mut Random(seed));
        let mut look = Look::default_of(&scope.scene);
        for _ in 0..6 {
            let (change, before) = (change(random, &scope.scene), look.clone());
            let was = digits(&look, &scope.scene);
            let Ok(undo) = look.apply(&change, &scope, &place()) else {
                prop_assert_eq!(digits(&look, &scope.scene), was, "an error changes nothing");
                continue;
            };
            let becomes = digits(&look, &scope.scene);
            let mut expected = complete(&before, &scope.scene);
            let shapeless = State { shapes: BTreeMap::new(), ..change.clone() };
            lay_over(&mut expected, toml::Table::try_from(&shapeless).unwrap());
            prop_assert_eq!(format!("{:?}", complete(&look, &scope.scene)), format!("{expected:?}"));
            prop_assert_eq!(digits(&before.with(&change, &scope, &place()).unwrap(), &scope.scene), becomes.clone());

            let redo = look.apply(&undo, &scope, &place()).unwrap();
            prop_assert_eq!(digits(&look, &scope.scene), was);
            prop_assert_eq!(format!("{:?}", State { shapes: BTreeMap::new(), ..redo.clone() }), format!("{shapeless:?}"));
            prop_assert!(redo.shapes.keys().eq(change.shapes.keys()));
            let again = look.apply(&redo, &scope, &place()).unwrap();
            prop_assert_eq!(digits(&look, &scope.scene), becomes);
            prop_assert_eq!(format!("{again:?}"), format!("{undo:?}"));
        }
    }

    /// Between any two looks of a walk, and through a file.
    #[test]
    fn a_difference_leads_from_one_look_to_the_other(seed: u64) {
        let (scope, random) = (scope(seed), &mut Random(seed));
        let mut looks = vec![Look::default_of(&scope.scene)];
        for _ in 0..4 {
            let mut next = looks[random.below(looks.len())].clone();
            // An illegal change leaves it as it is.
            let _ = next.apply(&change(random, &scope.scene), &scope, &place());
            looks.push(next);
        }
        for (from, to) in looks.iter().flat_map(|from| looks.iter().map(move |to| (from, to))) {
            let change = to.difference(from);
            let mut look = from.clone();
            look.apply(&change, &scope, &place()).unwrap();
            prop_assert_eq!(digits(&look, &scope.scene), digits(to, &scope.scene));
            prop_assert_eq!(digits(from, &scope.scene) == digits(to, &scope.scene), change == State::default());
            let read = from.with(&state(&toml::to_string(&change).unwrap()), &scope, &place()).unwrap();
            prop_assert_eq!(digits(&read, &scope.scene), digits(to, &scope.scene));
        }
    }

    /// What undoes a change is a state file like any other.
    #[test]
    fn an_inverse_can_be_written_and_read(seed: u64) {
        let (scope, random) = (scope(seed), &mut Random(seed));
        let mut look = Look::default_of(&scope.scene);
        if let Ok(inverse) = look.apply(&change(random, &scope.scene), &scope, &place()) {
            let text = toml::to_string(&inverse).unwrap();
            prop_assert_eq!(look.with(&state(&text), &scope, &place()).unwrap(), Look::default_of(&scope.scene), "{}", text);
        }
    }
}

#[test]
fn only_what_changes_gets_a_new_revision() {
    let scope = scope(3);
    let mut look = Look::default_of(&scope.scene);
    let first = look.materials.revision();
    look.apply(&state("camera.exposure_ev = 1"), &scope, &place()).unwrap();
    assert_eq!(look.materials.revision(), first);
    let leaf = match look.materials["m0"].model() {
        Model::BlinnPhong => "shininess = 3",
        Model::Ggx | Model::CookTorrance => "roughness = 0.5",
    };
    look.apply(&state(&format!("materials.m0.{leaf}")), &scope, &place()).unwrap();
    assert_ne!(look.materials.revision(), first);
}

#[test]
fn what_the_scene_does_not_have_is_refused_and_nothing_changes() {
    let scope = scope(2);
    let object = &scope.scene.shapes[0].object;
    let mut look = Look::default_of(&scope.scene);
    let before = look.clone();
    for (text, part) in [
        (
            "camera.fov_deg = 20\nmaterials.m9.kd = [0, 0, 0]",
            "s.toml: no material `m9`; did you mean `m0`? There are: `m0`",
        ),
        ("camera.fov_deg = 20\nshapes.hen.clip = 'Läufer'", "s.toml: no shape `hen`; "),
        (
            &format!("camera.fov_deg = 20\nshapes.\"{object}\".clip = 'Walk'"),
            "no clip `Walk`; it has ``, `Läufer`",
        ),
        ("camera.fov_deg = 200", "camera: fov_deg 200 is outside"),
        (
            "camera.fov_deg = 20\nenvironment.map = 'skies.exr'",
            "environment: no map `skies.exr`; this bundle has: sky.exr, other.exr",
        ),
        (
            "camera.fov_deg = 20\nenvironment.gain = [-1, 0, 0]",
            "environment: gain [-1.0, 0.0, 0.0] is outside",
        ),
    ] {
        let message = look.apply(&state(text), &scope, &place()).unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
        assert_eq!(look, before, "{text}");
    }
    let dark = State { lights: [("lamp".to_owned(), LightState { gain: None })].into(), ..State::default() };
    let message = look.apply(&dark, &scope, &place()).unwrap_err().to_string();
    assert_eq!(
        message,
        "s.toml: sets light `lamp`, but no method of this version lets lights vary; remove it"
    );
    let mut bare = Look { environment: None, ..before };
    let message =
        bare.apply(&state("environment.rotation_deg = 1"), &scope, &place()).unwrap_err().to_string();
    assert_eq!(message, "s.toml: sets [environment], but the scene has none; remove it");
}

#[test]
fn a_shape_comes_back_to_rest() {
    let scope = scope(2);
    let object = &scope.scene.shapes[0].object;
    let mut look = Look::default_of(&scope.scene);
    let mut apply = |leaves: &str| {
        look.apply(&state(&format!("[shapes.\"{object}\"]\n{leaves}")), &scope, &place()).unwrap().shapes
            [object]
            .clone()
    };
    let rest = ShapeState { pose: Some(Pose::Rest), ..ShapeState::default() };
    let named = |clip: Option<&str>, time_s| ShapeState { clip: clip.map(str::to_owned), time_s, pose: None };
    assert_eq!(apply("clip = 'Läufer'\ntime_s = 0.5"), rest);
    assert_eq!(apply("time_s = 0.75"), named(None, Some(0.5)));
    assert_eq!(apply("clip = ''"), named(Some("Läufer"), None));
    assert_eq!(apply(""), ShapeState::default());
    assert_eq!(apply("pose = 'rest'"), named(Some(""), Some(0.75)));
    assert_eq!(apply("pose = 'rest'"), rest);
    assert_eq!(apply(""), ShapeState::default());
    assert!(look.shapes.is_empty());
}
