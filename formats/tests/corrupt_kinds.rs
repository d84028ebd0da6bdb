//! Sound containers whose content breaks the rules of its kind: scenes, animations, and the order of sections
//! in all kinds.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::refusal;
use crate::support::received::tensors;
use crate::support::refusing::{assert_forged_refused, assert_invalid, assert_refused};
use crate::support::tensors::tensor;
use crate::support::{samples, scenes};
use relume_formats::container::Stored;
use relume_formats::kinds::scene::StoredMaterial;
use relume_formats::kinds::{HaarTable, StoredScene, VisibilityTable};
use relume_formats::state::{Animation, BlinnPhong, Brdf, CookTorrance, Ggx, Model, Track, TrackValues};

/// Sections missing, there twice under another name, or in another order.
fn assert_order_matters<T: Stored>(value: &T) {
    let folder = tempfile::tempdir().unwrap();
    let sound = RawFile::parse(&value.write_file(&folder.path().join("a.relume")).unwrap());
    let rebuilt = |sections: Vec<RawSection>| RawFile::new(sound.kind, sections).bytes();
    for at in 0..sound.sections.len() {
        let mut sections = sound.sections.clone();
        sections.remove(at);
        refusal(T::KIND, &rebuilt(sections));
    }
    let mut sections = sound.sections.clone();
    sections.push(RawSection { name: "more".to_owned(), ..sound.sections[0].clone() });
    let expected = if sections.len() > T::KIND.max_sections() { "has at most" } else { "section `more`: " };
    assert_invalid(T::KIND, &rebuilt(sections), expected);
    if sound.sections.len() > 1 {
        let mut sections = sound.sections;
        sections.swap(0, 1);
        refusal(T::KIND, &RawFile::new(sound.kind, sections).bytes());
    }
}

#[test]
fn every_kind_needs_its_sections_in_order() {
    assert_order_matters(&scenes::scene(3));
    assert_order_matters(&scenes::animation(3));
    assert_order_matters(&samples::basis(3, 3, true));
    assert_order_matters(&samples::ggx_basis(3, 3, 2));
    assert_order_matters(&samples::cook_torrance_basis(3, 3, 2));
    assert_order_matters(&samples::images(3, 1, 2, true, [3, 2]));
    assert_order_matters(&tensor(3, Model::BlinnPhong, [2, 2, 2]));
    assert_order_matters(&tensor(4, Model::Ggx, [2, 2, 2]));
    assert_order_matters(&tensors(5, 2, 2, &[1, 1], 3));
    assert_order_matters(&HaarTable::bake());
    assert_order_matters(&VisibilityTable::bake());
}

fn blinn_phong(kd: f32, shininess: f32) -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd: [kd; 3], ks: [0.1; 3], shininess })
}

fn ggx(metallic: f32, roughness: f32) -> Brdf {
    Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic, roughness })
}

fn cook_torrance(kd: f32, fresnel: f32, roughness: f32) -> Brdf {
    Brdf::CookTorrance(CookTorrance { kd: [kd; 3], ks: [0.5; 3], fresnel, roughness })
}

/// Gives the first material, which is textured, other parameters.
fn wear(scene: &mut StoredScene, varies: bool, brdf: Brdf) {
    let name = scene.meta.materials[0].name.clone();
    let sharpest = brdf.model().usual_sharpest();
    scene.meta.materials[0] = StoredMaterial { name, brdf, varies, textured: true, sharpest };
}

#[test]
fn broken_scenes() {
    type Change = fn(&mut StoredScene);
    let cases: [(Change, &str); 40] = [
        (|s| s.meta.camera.fov_deg = 0.0, "fov_deg 0 is outside"),
        (|s| s.meta.camera.target = s.meta.camera.position, "position and target coincide"),
        (|s| s.meta.camera.position[1] = f32::NAN, "finite"),
        (|s| s.meta.size = [0, 5], "film size [0, 5]"),
        (|s| s.meta.size = [16_385, 5], "film size [16385, 5]"),
        (|s| wear(s, true, blinn_phong(1.5, 50.0)), "exceeds 1"),
        (|s| wear(s, true, blinn_phong(0.5, 201.0)), "shininess 201 is outside 1..200"),
        (|s| wear(s, false, blinn_phong(0.5, 10_001.0)), "shininess 10001 is outside 1..10000"),
        (|s| wear(s, true, ggx(0.0, 0.31)), "roughness 0.31 is outside 0.32..1"),
        (|s| wear(s, false, ggx(0.0, 0.11)), "roughness 0.11 is outside 0.12..1"),
        (|s| wear(s, false, ggx(1.5, 0.5)), "metallic 1.5 must be numbers of 0 to 1"),
        (|s| wear(s, true, ggx(f32::NAN, 0.5)), "metallic NaN must be"),
        (|s| wear(s, true, cook_torrance(0.6, 0.5, 0.5)), "kd + ks = 1.1 exceeds 1"),
        (|s| wear(s, true, cook_torrance(0.5, 1.1, 0.5)), "fresnel 1.1 must be a number of 0 to 1"),
        (|s| wear(s, false, cook_torrance(0.5, f32::NAN, 0.5)), "fresnel NaN must be"),
        (|s| wear(s, true, cook_torrance(0.5, 0.5, 0.099)), "roughness 0.099 is outside 0.1..1"),
        (|s| wear(s, false, cook_torrance(0.5, 0.5, 0.014)), "roughness 0.014 is outside 0.015..1"),
        (|s| wear(s, true, ggx(0.1, 0.5)), "metallic 0.1 with a textured base colour"),
        (|s| s.meta.materials.push(s.meta.materials[0].clone()), "are called `"),
        (|s| s.meta.objects.push(s.meta.objects[0].clone()), "are called `"),
        (
            |s| s.meta.objects[0].material = s.meta.materials.len() as u32,
            "names a material that is not there",
        ),
        (|s| s.meta.objects[0].triangles += 1, "do not cover the triangles"),
        (|s| s.positions[0][2] = f32::INFINITY, "section `positions`: element 2 is not a finite number"),
        (|s| s.normals[0][0] = f32::NAN, "section `normals`: element 0 is not a finite number"),
        (|s| s.triangles[0][1] = s.positions.len() as u32, "names a vertex that is not there"),
        (|s| s.triangles[0] = [0; 3], "section `triangles`: triangle 0 has two corners in one place"),
        (
            |s| s.positions[s.triangles[0][1] as usize] = s.positions[s.triangles[0][2] as usize],
            "has two corners in one place",
        ),
        (|s| s.normals[0] = [0.0; 3], "section `normals`: the normal of vertex 0 is of length 0, not 1"),
        (
            |s| s.normals[0][0] *= 1.0001,
            "section `normals`: the normal of vertex 0 is of length 1.0001, not 1",
        ),
        (
            |s| s.positions[0][1] = -1.001e9,
            "section `positions`: element 1 is -1001000000.0, farther from the origin than 1e9 m",
        ),
        (|s| s.meta.camera.target[0] = 3e38, "section `meta`: camera: 3e38 m is farther from the origin"),
        (
            |s| s.meta.camera.target = s.meta.camera.position.map(|x| x + 1e-30),
            "position and target coincide",
        ),
        (|s| s.meta.camera.fov_deg = 180.0, "fov_deg 180 is outside"),
        (
            |s| s.meta.name = "a\u{1b}[2J".to_owned(),
            "the name `a\\u{1b}[2J` of the scene has control characters",
        ),
        (
            |s| s.meta.objects[0].name = "\n".to_owned(),
            "the name `\\n` of one of the objects has control characters",
        ),
        (
            |s| s.meta.materials[0].name = "m".repeat(273),
            "the name of one of the materials has more than 272 characters",
        ),
        (|s| s.meta.materials = vec![s.meta.materials[0].clone(); 4097], "4097 materials and"),
        (
            |s| s.meta.environment.as_mut().unwrap().gain[1] = f32::NAN,
            "gain [1.0, NaN, 1000000000.0] is outside",
        ),
        (
            |s| s.meta.environment.as_mut().unwrap().rotation_deg = f32::INFINITY,
            "rotation_deg must be a finite number",
        ),
        (
            |s| s.meta.environment.as_mut().unwrap().map = "\r".to_owned(),
            "of the environment map has control characters",
        ),
    ];
    let sound = (0..)
        .map(scenes::scene)
        .find(|s| !s.meta.objects.is_empty() && !s.triangles.is_empty() && s.meta.environment.is_some())
        .unwrap();
    for (change, expected) in cases {
        let mut scene = sound.clone();
        change(&mut scene);
        assert_refused(&scene, expected);
    }
    let one_more = |s: &mut RawSection| {
        *s = RawSection::new(&s.name, 4, &[s.shape[0] + 1, 3], 1, &[s.raw(), vec![0; 12]].concat())
    };
    assert_forged_refused(&sound, "normals", one_more, "section `normals`: has shape");
    let flat = |s: &mut RawSection| s.shape = vec![s.shape.iter().product()];
    assert_forged_refused(&sound, "positions", flat, "section `positions`: has shape");
    assert_forged_refused(
        &sound,
        "triangles",
        |s| s.element = 4,
        "section `triangles`: holds f32, expected u32",
    );
    assert_forged_refused(
        &sound,
        "meta",
        |s| *s = RawSection::new("meta", 0, &[3], 0, &[1, 2, 3]),
        "section `meta`: is malformed",
    );
    let longer = |s: &mut RawSection| {
        let raw = [s.raw(), vec![0]].concat();
        *s = RawSection::new("meta", 0, &[raw.len() as u64], 0, &raw);
    };
    assert_forged_refused(&sound, "meta", longer, "section `meta`: has bytes left over");
}

#[test]
fn broken_animations() {
    let leaf = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    type Change<'a> = Box<dyn Fn(&mut Animation) + 'a>;
    let track =
        |leaf: Vec<String>| Track { leaf, times_s: vec![0.0], values: TrackValues::Scalar(vec![1.0]) };
    let cases: Vec<(Change<'_>, &str)> = vec![
        (Box::new(|a| a.duration_s = 0.0), "must be above 0"),
        (Box::new(|a| a.duration_s = f32::NAN), "must be above 0"),
        (Box::new(|a| a.tracks[0].times_s[1] = f32::NAN), "finite times"),
        (Box::new(|a| a.tracks[0].times_s[0] = -0.5), "finite times"),
        (Box::new(|a| a.tracks[0].times_s.swap(0, 1)), "must increase"),
        (Box::new(|a| a.tracks[0].times_s.clear()), "needs keys"),
        (Box::new(|a| a.tracks[0].times_s.push(90.0)), "one value of the same length"),
        (
            Box::new(|a| {
                a.tracks[0].values = TrackValues::Vector(vec![vec![1.0; 3], vec![1.0; 2], vec![1.0; 3]])
            }),
            "same length",
        ),
        (Box::new(|a| a.tracks[0].values = TrackValues::Vector(vec![Vec::new(); 3])), "same length"),
        (
            Box::new(|a| a.tracks[1].values = TrackValues::Scalar(vec![1.0, f32::NAN])),
            "is not finite; write numbers",
        ),
        (Box::new(|a| a.tracks[0].leaf = leaf(&["materials", "m0", "kdd"])), "kdd"),
        (Box::new(|a| a.tracks[0].values = TrackValues::Scalar(vec![1.0; 3])), "invalid type"),
        (Box::new(|a| a.tracks[2].leaf[2] = "base_colour".to_owned()), "unknown field `base_colour`"),
        (Box::new(|a| a.tracks[2].values = TrackValues::Scalar(vec![1.0; 2])), "invalid type"),
        (Box::new(|a| a.tracks[1].leaf = a.tracks[0].leaf.clone()), "out of order or there twice"),
        (Box::new(|a| a.tracks.reverse()), "out of order or there twice"),
        (Box::new(|a| a.tracks.insert(0, track(leaf(&["materials", "m0"])))), "both a leaf and a table"),
        (Box::new(|a| a.tracks.insert(0, track(Vec::new()))), "a track's leaf has 0 names"),
        // A state built from this would nest so deeply that it overflows the stack.
        (
            Box::new(|a| a.tracks.insert(0, track(vec![String::new(); 1_000_000]))),
            "a track's leaf has 1000000 names",
        ),
        (Box::new(|a| a.tracks[4] = many_keys()), "more than 100000 keys"),
    ];
    for (change, expected) in cases {
        let mut animation = scenes::animation(3);
        change(&mut animation);
        assert_refused(&animation, expected);
    }
}

fn many_keys() -> Track {
    let times_s: Vec<f32> = (0..=100_000).map(|i| i as f32).collect();
    let values = TrackValues::Scalar(times_s.clone());
    Track { leaf: ["materials", "z", "shininess"].map(str::to_owned).to_vec(), times_s, values }
}

/// Files of other programs have these, and a bake keeps them.
#[test]
fn normals_that_point_away_and_triangles_there_twice_are_legal() {
    let mut scene = (0..).map(scenes::scene).find(|s| s.triangles.len() > 1).unwrap();
    scene.normals.iter_mut().flatten().for_each(|x| *x = -*x);
    scene.triangles[1] = scene.triangles[0];
    scene.to_bytes(relume_formats::Place::file("a.relume")).unwrap();
}
