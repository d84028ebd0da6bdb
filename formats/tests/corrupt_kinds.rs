//! Sound containers whose content breaks the rules of its kind, and manifests that break theirs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod support {
    pub mod playing;
    pub mod raw_file;
    pub mod reading;
    pub mod samples;
    pub mod scenes;
}

use half::f16;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::scene::StoredMaterial;
use relume_formats::kinds::transfer_images::Head;
use relume_formats::kinds::{BrdfBasis, HaarTable, Manifest, StoredScene, TransferImages, VisibilityTable};
use relume_formats::state::{Animation, BlinnPhong, Brdf, Ggx, Track, TrackValues};
use relume_formats::{Error, Place};
use std::sync::Arc;
use support::raw_file::{RawFile, RawSection};
use support::reading::refusal;
use support::{samples, scenes};

/// Refused when it is read, and not even written.
fn assert_refused<T: Stored>(value: &T, expected: &str) {
    assert_invalid(T::KIND, &value.to_bytes_unchecked(Place::file("a.relume")).unwrap(), expected);
    let unwritten = value.to_bytes(Place::file("a.relume")).unwrap_err().to_string();
    assert!(unwritten.contains(expected) && !unwritten.contains("damaged"), "`{expected}`: {unwritten}");
}

fn assert_invalid(kind: Kind, bytes: &[u8], expected: &str) {
    let error = refusal(kind, bytes);
    assert!(matches!(error, Error::Invalid { .. }) && error.to_string().contains(expected), "`{expected}`: {error}");
}

/// A file with one section changed beyond what the types allow.
fn assert_forged_refused<T: Stored>(value: &T, section: &str, change: impl Fn(&mut RawSection), expected: &str) {
    let folder = tempfile::tempdir().unwrap();
    let mut file = RawFile::parse(&value.write_file(&folder.path().join("a.relume")).unwrap());
    change(file.sections.iter_mut().find(|s| s.name == section).unwrap());
    assert_invalid(T::KIND, &file.bytes(), expected);
}

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
    assert_order_matters(&samples::images(3, 1, 2, true, [3, 2]));
    assert_order_matters(&HaarTable::bake());
    assert_order_matters(&VisibilityTable::bake());
}

fn blinn_phong(kd: f32, shininess: f32) -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd: [kd; 3], ks: [0.1; 3], shininess })
}

fn ggx(metallic: f32, roughness: f32) -> Brdf {
    Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic, roughness })
}

/// Gives the first material, which is textured, other parameters.
fn wear(scene: &mut StoredScene, varies: bool, brdf: Brdf) {
    let name = scene.meta.materials[0].name.clone();
    scene.meta.materials[0] = StoredMaterial { name, brdf, varies, textured: true };
}

#[test]
fn broken_scenes() {
    type Change = fn(&mut StoredScene);
    let cases: [(Change, &str); 33] = [
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
        (|s| wear(s, true, ggx(0.1, 0.5)), "metallic 0.1 with a textured base colour"),
        (|s| s.meta.materials.push(s.meta.materials[0].clone()), "are called `"),
        (|s| s.meta.objects.push(s.meta.objects[0].clone()), "are called `"),
        (|s| s.meta.objects[0].material = s.meta.materials.len() as u32, "names a material that is not there"),
        (|s| s.meta.objects[0].triangles += 1, "do not cover the triangles"),
        (|s| s.positions[0][2] = f32::INFINITY, "section `positions`: element 2 is not a finite number"),
        (|s| s.normals[0][0] = f32::NAN, "section `normals`: element 0 is not a finite number"),
        (|s| s.triangles[0][1] = s.positions.len() as u32, "names a vertex that is not there"),
        (|s| s.normals[0] = [0.0; 3], "section `normals`: the normal of vertex 0 is of length 0, not 1"),
        (|s| s.normals[0][0] *= 1.0001, "section `normals`: the normal of vertex 0 is of length 1.0001, not 1"),
        (|s| s.positions[0][1] = -1.001e9, "section `positions`: element 1 is -1001000000.0, farther from the origin than 1e9 m"),
        (|s| s.meta.camera.target[0] = 3e38, "section `meta`: camera: 3e38 m is farther from the origin"),
        (|s| s.meta.camera.target = s.meta.camera.position.map(|x| x + 1e-30), "position and target coincide"),
        (|s| s.meta.camera.fov_deg = 180.0, "fov_deg 180 is outside"),
        (|s| s.meta.name = "a\u{1b}[2J".to_owned(), "the name `a\\u{1b}[2J` of the scene has control characters"),
        (|s| s.meta.objects[0].name = "\n".to_owned(), "the name `\\n` of one of the objects has control characters"),
        (|s| s.meta.materials[0].name = "m".repeat(273), "the name of one of the materials has more than 272 characters"),
        (|s| s.meta.materials = vec![s.meta.materials[0].clone(); 4097], "4097 materials and"),
        (|s| s.meta.environment.as_mut().unwrap().gain[1] = f32::NAN, "gain [1.0, NaN, 1000000000.0] is outside"),
        (|s| s.meta.environment.as_mut().unwrap().rotation_deg = f32::INFINITY, "rotation_deg must be a finite number"),
        (|s| s.meta.environment.as_mut().unwrap().map = "\r".to_owned(), "of the environment map has control characters"),
    ];
    let sound =
        (0..).map(scenes::scene).find(|s| !s.meta.objects.is_empty() && !s.triangles.is_empty() && s.meta.environment.is_some()).unwrap();
    for (change, expected) in cases {
        let mut scene = sound.clone();
        change(&mut scene);
        assert_refused(&scene, expected);
    }
    let one_more = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[s.shape[0] + 1, 3], 1, &[s.raw(), vec![0; 12]].concat());
    assert_forged_refused(&sound, "normals", one_more, "section `normals`: has shape");
    let flat = |s: &mut RawSection| s.shape = vec![s.shape.iter().product()];
    assert_forged_refused(&sound, "positions", flat, "section `positions`: has shape");
    assert_forged_refused(&sound, "triangles", |s| s.element = 4, "section `triangles`: holds f32, expected u32");
    assert_forged_refused(&sound, "meta", |s| *s = RawSection::new("meta", 0, &[3], 0, &[1, 2, 3]), "section `meta`: is malformed");
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
    let track = |leaf: Vec<String>| Track { leaf, times_s: vec![0.0], values: TrackValues::Scalar(vec![1.0]) };
    let cases: Vec<(Change<'_>, &str)> = vec![
        (Box::new(|a| a.duration_s = 0.0), "must be above 0"),
        (Box::new(|a| a.duration_s = f32::NAN), "must be above 0"),
        (Box::new(|a| a.tracks[0].times_s[1] = f32::NAN), "finite times"),
        (Box::new(|a| a.tracks[0].times_s[0] = -0.5), "finite times"),
        (Box::new(|a| a.tracks[0].times_s.swap(0, 1)), "must increase"),
        (Box::new(|a| a.tracks[0].times_s.clear()), "needs keys"),
        (Box::new(|a| a.tracks[0].times_s.push(90.0)), "one value of the same length"),
        (Box::new(|a| a.tracks[0].values = TrackValues::Vector(vec![vec![1.0; 3], vec![1.0; 2], vec![1.0; 3]])), "same length"),
        (Box::new(|a| a.tracks[0].values = TrackValues::Vector(vec![Vec::new(); 3])), "same length"),
        (Box::new(|a| a.tracks[1].values = TrackValues::Scalar(vec![1.0, f32::NAN])), "is not finite; write numbers"),
        (Box::new(|a| a.tracks[0].leaf = leaf(&["materials", "m0", "kdd"])), "kdd"),
        (Box::new(|a| a.tracks[0].values = TrackValues::Scalar(vec![1.0; 3])), "invalid type"),
        (Box::new(|a| a.tracks[2].leaf[2] = "base_colour".to_owned()), "unknown field `base_colour`"),
        (Box::new(|a| a.tracks[2].values = TrackValues::Scalar(vec![1.0; 2])), "invalid type"),
        (Box::new(|a| a.tracks[1].leaf = a.tracks[0].leaf.clone()), "out of order or there twice"),
        (Box::new(|a| a.tracks.reverse()), "out of order or there twice"),
        (Box::new(|a| a.tracks.insert(0, track(leaf(&["materials", "m0"])))), "both a leaf and a table"),
        (Box::new(|a| a.tracks.insert(0, track(Vec::new()))), "a track's leaf has 0 names"),
        // A state built from this would nest so deeply that it overflows the stack.
        (Box::new(|a| a.tracks.insert(0, track(vec![String::new(); 1_000_000]))), "a track's leaf has 1000000 names"),
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

/// Lobes of a Blinn-Phong basis.
fn lobes(basis: &mut BrdfBasis) -> &mut Vec<f32> {
    match &mut basis.functions {
        Functions::BlinnPhong { lobes } => lobes,
        Functions::Ggx { .. } => panic!("not of this model"),
    }
}

#[test]
fn broken_bases() {
    type Change = fn(&mut BrdfBasis);
    let cases: [(Change, &str); 15] = [
        (|b| b.parameters.swap(0, 1), "increasing parameters"),
        (|b| b.parameters[1] = f32::NAN, "increasing parameters"),
        (|b| *b.parameters.last_mut().unwrap() = f32::INFINITY, "section `parameters`: element"),
        (|b| (b.parameters, b.coefficients) = (vec![1.0], vec![0.0; 3]), "needs 2 to 65536"),
        (|b| b.coefficients[2] = f32::NAN, "section `coefficients`: element 2"),
        (|b| lobes(b)[77] = f32::NEG_INFINITY, "section `lobes`: element 77"),
        (|b| (b.coefficients, *lobes(b)) = (vec![1.0; b.parameters.len()], Vec::new()), "holds 1 bases, 2 to 32"),
        (|b| *b = samples::basis(1, 33, true), "holds 33 bases, 2 to 32"),
        (|b| *b.parameters.last_mut().unwrap() = 199.0, "section `parameters`: runs from 1 to 199, expected 1 to 200"),
        (|b| b.parameters[0] = -5.0, "section `parameters`: runs from -5 to 200"),
        (|b| b.parameters.iter_mut().for_each(|p| *p = 1.0 + *p * 1e-3), "section `parameters`: runs from 1.001 to 1.2"),
        (|b| b.coefficients[1] = 3e38, "section `coefficients`: element 1, 3e38, is beyond 10000.0"),
        (|b| lobes(b)[5] = -3e38, "section `lobes`: element 5"),
        (|b| b.meta.error_between.mean = f64::NAN, "section `meta`: errors"),
        (|b| b.meta.error_at_samples.worst = -1.0, "section `meta`: errors"),
    ];
    let sound = samples::basis(3, 3, true);
    for (change, expected) in cases {
        let mut basis = sound.clone();
        change(&mut basis);
        assert_refused(&basis, expected);
    }
    let transposed = |s: &mut RawSection| s.shape.reverse();
    assert_forged_refused(&sound, "coefficients", transposed, "section `coefficients`: has shape");
    assert_forged_refused(&sound, "lobes", transposed, "section `lobes`: has shape");
    assert_forged_refused(&sound, "lobes", |s| s.element = 2, "section `lobes`: holds u32, expected f32");
    assert_forged_refused(&sound, "lobes", |s| s.name = "lobe".to_owned(), "expected section `lobes` or `roughness` here");
    assert_forged_refused(&sound, "parameters", |s| s.shape.push(1), "section `parameters`: has shape");
    let many = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[65_537], 1, &[0; 4 * 65_537]);
    assert_forged_refused(&sound, "parameters", many, "needs 2 to 65536");
}

/// Roughness and weights of a GGX basis.
fn samples_of(basis: &mut BrdfBasis) -> (&mut Vec<f32>, &mut Vec<f32>) {
    match &mut basis.functions {
        Functions::Ggx { roughness, weights } => (roughness, weights),
        Functions::BlinnPhong { .. } => panic!("not of this model"),
    }
}

#[test]
fn broken_ggx_bases() {
    type Change = fn(&mut BrdfBasis);
    let cases: [(Change, &str); 12] = [
        (|b| b.parameters.reverse(), "increasing parameters"),
        (|b| b.parameters[0] = 0.3, "section `parameters`: runs from 0.3 to 1, expected 0.32 to 1"),
        (|b| samples_of(b).1[9] = 1e31, "section `weights`: element 9"),
        (|b| b.coefficients[11] = f32::NAN, "section `coefficients`: element 11"),
        (|b| samples_of(b).0[1] = 0.0, "section `roughness`: needs 1 to 64 roughnesses of 0.32 to 1"),
        (|b| samples_of(b).0[1] = 0.3, "section `roughness`: needs 1 to 64 roughnesses of 0.32 to 1"),
        (|b| samples_of(b).0[0] = 1.01, "section `roughness`: needs 1 to 64 roughnesses of 0.32 to 1"),
        (|b| samples_of(b).0[0] = f32::NAN, "section `roughness`: element 0"),
        (|b| samples_of(b).1[9] = f32::INFINITY, "section `weights`: element 9"),
        (|b| *b = samples::ggx_basis(1, 2, 65), "section `roughness`: needs 1 to 64"),
        (|b| (b.coefficients, *samples_of(b).1) = (vec![1.0; 2 * b.parameters.len()], Vec::new()), "holds 1 bases, 2 to 32"),
        (|b| *b = samples::ggx_basis(1, 33, 2), "holds 33 bases, 2 to 32"),
    ];
    let sound = samples::ggx_basis(3, 3, 2);
    for (change, expected) in cases {
        let mut basis = sound.clone();
        change(&mut basis);
        assert_refused(&basis, expected);
    }
    let none = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[0], 1, &[]);
    assert_forged_refused(&sound, "roughness", none, "section `roughness`: needs 1 to 64");
    assert_forged_refused(&sound, "roughness", |s| s.shape.push(1), "section `roughness`: has shape [2, 1]");
    let transposed = |s: &mut RawSection| s.shape.reverse();
    assert_forged_refused(&sound, "weights", transposed, "section `weights`: has shape [5, 2], expected [2, 5]");
    assert_forged_refused(&sound, "coefficients", |s| s.shape.swap(1, 2), "section `coefficients`: has shape");
    // Of one part only, as a basis of the other model has.
    let one_part = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[s.shape[0], 1, 3], 1, &s.raw()[..s.raw_bytes as usize / 2]);
    assert_forged_refused(&sound, "coefficients", one_part, "section `coefficients`: has shape");
}

#[test]
fn broken_transfer_images() {
    type Change = fn(&mut Head);
    let cases: [(Change, &str); 22] = [
        (|h| h.meta.size = [0, 3], "film size [0, 3]"),
        (|h| h.meta.size = [3, 16_385], "film size [3, 16385]"),
        (|h| h.meta.materials[1] = "m0".to_owned(), "are called `"),
        (|h| h.meta.chromaticity = Some([1.0, 2.0, 0.0]), "chromaticity is outside"),
        (|h| h.meta.chromaticity = Some([1.0, f32::NAN, 0.0]), "chromaticity is outside"),
        (|h| h.meta.editable_fragments = h.pixel.len() as u32 + 1, "do not fit the film"),
        (|h| h.meta.editable_fragments += 1, "not in order, or of a class"),
        (|h| h.meta.editable_fragments -= 1, "not in order, or of a class"),
        (|h| h.pixel[0] = 12, "outside the film"),
        (|h| h.pixel.swap(0, 4), "not in order"),
        (|h| (h.pixel[1], h.class[1]) = (h.pixel[0], h.class[0]), "not in order"),
        (|h| h.class[0] = 3, "of a class that is not there"),
        (|h| *h.class.last_mut().unwrap() = 3, "of a class that is not there"),
        (|h| h.coverage[0] = f16::ZERO, "a coverage is outside"),
        (|h| h.coverage[0] = f16::from_f32(1.01), "a coverage is outside"),
        (|h| h.coverage[0] = f16::NAN, "a coverage is outside"),
        (|h| h.scales[2] = f32::INFINITY, "section `scales`: element 2"),
        (|h| h.scales[2] = 3e38, "section `scales`: element 2, 3e38, is beyond 1e18"),
        (|h| h.scales[2] = -1.0, "a scale is negative"),
        (|h| h.coverage.fill(f16::from_f32(0.9)), "section `fragments/coverage`: the fragments of pixel"),
        (|h| h.meta.chromaticity = Some([0.5, 0.25, 0.5]), "has no channel of 1"),
        (|h| h.meta.materials[1] = "\u{7}".to_owned(), "has control characters"),
    ];
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    for (change, expected) in cases {
        let mut head = (*sound.head).clone();
        change(&mut head);
        // Images after a broken head must not matter, nor could all of them be written.
        assert_refused(&TransferImages { head: Arc::new(head), images: Vec::new() }, expected);
    }
}

#[test]
fn broken_counts_of_transfer_images() {
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    let with_head = |change: &dyn Fn(&mut Head)| {
        let mut head = (*sound.head).clone();
        change(&mut head);
        TransferImages { head: Arc::new(head), images: Vec::new() }
    };
    assert_refused(&with_head(&|_| ()), "0 images, expected 24");
    assert_refused(&with_head(&|h| h.meta.bases = 1), "2 materials and 1 bases are out of range");
    assert_refused(&with_head(&|h| h.meta.bases = 33), "2 materials and 33 bases are out of range");
    // In the record: two numbers of 4 bytes, then a list of two names of 2 characters, then the number of bases.
    let endless = |s: &mut RawSection| {
        let mut raw = s.raw();
        let at = 8 + 8 + 2 * (8 + 2);
        assert_eq!(raw[at..at + 4], [3, 0, 0, 0]);
        raw[at..at + 4].fill(255);
        s.set_raw(&raw);
    };
    assert_forged_refused(&sound, "meta", endless, "2 materials and 4294967295 bases are out of range");
    assert_refused(&with_head(&|h| h.meta.materials = (0..65).map(|i| i.to_string()).collect()), "65 materials and 3 bases");
    assert_refused(&with_head(&|h| h.meta.materials.clear()), "0 materials and 3 bases");
    assert_refused(&with_head(&|h| h.scales.truncate(3)), "section `scales`: has shape [3]");
    let three = |s: &mut RawSection| *s = RawSection::new(&s.name, s.element, &[3], 1, &s.raw()[..6]);
    assert_forged_refused(&sound, "fragments/class", three, "section `fragments/class`: has shape [3]");
    assert_forged_refused(&sound, "fragments/coverage", three, "section `fragments/coverage`: has shape [3]");
}

#[test]
fn broken_images() {
    let sound = samples::images(3, 2, 3, true, [4, 3]);
    let mut not_finite = sound.clone();
    not_finite.images[4].values[1] = f16::INFINITY;
    assert_refused(&not_finite, "a value is not a finite number");
    let rgb = sound.images.iter().position(|i| i.slot == 0).unwrap();
    let mut short = sound.clone();
    short.images.truncate(rgb);
    assert_refused(&short, &format!("{rgb} images, expected"));
    for name in ["image/9999", "image/0", "image/00001", "picture/0001", "image/"] {
        assert_forged_refused(&sound, "image/0001", |s| s.name = name.to_owned(), "is no image of this layout");
    }
    let grey = |s: &mut RawSection| s.shape = vec![1, s.shape.iter().product()];
    assert_forged_refused(&sound, "image/0000", grey, "section `image/0000`: has shape [1, ");
}

const MANIFEST: &str = r#"{
    "version": 0, "scene": "box", "scene_hash": "00",
    "scene_file": {"file": "scene.relume", "bytes": 1, "hash": "00"},
    "animations": {"turn": {"file": "turn.relume", "bytes": 1, "hash": "00"}},
    "methods": [{"name": "transfer-images", "files": [["brdf-basis", {"file": "basis.relume", "bytes": 1, "hash": "00"}]],
                 "settings": {"bases": 6}, "errors": {"relative_l2": 0.001}}]
}"#;

fn read_manifest(text: &[u8]) -> Result<Manifest, Error> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("manifest.json"), text).unwrap();
    Manifest::read(folder.path())
}

#[test]
fn broken_manifests() {
    assert_eq!(read_manifest(MANIFEST.as_bytes()).unwrap().entries().count(), 3);
    let cases = [
        ("\"version\": 0,", "", "has no version"),
        ("\"version\": 0", "\"version\": -1", "has no version"),
        ("\"version\": 0", "\"version\": \"0\"", "has no version"),
        ("\"scene\": \"box\",", "", "missing field `scene`"),
        ("\"scene\": \"box\"", "\"scene\": 3", "invalid type"),
        ("\"bytes\": 1", "\"bytes\": -1", "invalid value"),
        ("\"bytes\": 1", "\"bytes\": 1, \"more\": 2", "unknown field `more`"),
        ("\"settings\"", "\"setings\"", "unknown field `setings`"),
        ("0.001", "null", "invalid type"),
        ("]\n}", "", "EOF"),
        ("scene.relume", "../scene.relume", "`../scene.relume` is no plain file name"),
        ("scene.relume", "/etc/passwd", "`/etc/passwd` is no plain file name"),
        ("turn.relume", "sub/turn.relume", "is no plain file name"),
        ("turn.relume", "..", "is no plain file name"),
        ("basis.relume", ".hidden", "is no plain file name"),
        ("basis.relume", "", "is no plain file name"),
        ("basis.relume", "c:\\\\basis.relume", "is no plain file name"),
    ];
    for (from, to, expected) in cases {
        let text = MANIFEST.replacen(from, to, 1);
        assert_ne!(text, MANIFEST, "the case `{from}` changes something");
        let error = read_manifest(text.as_bytes()).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, Error::Invalid { .. }) && message.contains(expected), "`{to}`: {message}");
        assert!(message.contains("manifest.json: ") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn manifests_that_are_not_there_or_not_ours() {
    let error = read_manifest(MANIFEST.replace("\"version\": 0", "\"version\": 12").as_bytes()).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }));
    assert!(error.to_string().contains("manifest version 12, this program reads version 0"), "{error}");
    assert!(read_manifest(b"\xff\xfe").unwrap_err().to_string().contains("not a text file"));
    assert!(read_manifest(&[b'['; 100_000]).unwrap_err().to_string().contains("recursion limit"));

    let folder = tempfile::tempdir().unwrap();
    let error = Manifest::read(folder.path()).unwrap_err();
    assert!(matches!(error, Error::Invalid { .. }));
    assert!(error.to_string().contains("holds no bundle (no manifest.json); make one with `bake run"), "{error}");
}
