//! The kind `shape`: what is written comes back, and what is broken is refused.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::refusal;
use crate::support::scenes;
use crate::support::shapes::shape;
use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::scene::{Meta, StoredClip, StoredObject, StoredShape};
use relume_formats::method::{Card, SPARSE_TRANSFER, SPHERE_SHADOWS};
use relume_formats::shape::{DeformingMesh, MAX_CLIP_KEYS, MAX_JOINTS, MAX_MORPHED, MAX_VERTICES};
use relume_formats::state::{Posed, State, parse_toml};

fn written(shape: &DeformingMesh) -> Vec<u8> {
    shape.to_bytes_unchecked(Place::file("a.relume")).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn shapes_come_back(seed: u64, vertices in 0usize..40) {
        let shape = shape(seed, vertices);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.relume");
        let bytes = shape.write_file(&path).unwrap();
        let read = DeformingMesh::read_file(&path).unwrap();
        prop_assert_eq!(&read, &shape);
        prop_assert_eq!(&read.write_file(&path).unwrap(), &bytes, "reading and writing again changes nothing");
        prop_assert_eq!(RawFile::parse(&bytes).bytes(), bytes);
    }
}

#[test]
fn a_state_chooses_a_moment_of_a_clip_that_repeats() {
    let shape = shape(4, 5);
    let at = |clip: &str, time_s| shape.pose_of(Some(&Posed { clip: clip.to_owned(), time_s }));
    assert_eq!(shape.pose_of(None), shape.rest_pose());
    assert_eq!(at("Flieger", 1.0), shape.rest_pose());
    assert_eq!(at("Läufer", 0.75), shape.pose_at(&shape.clips[0], 0.75));
    // 2.5 s long; all these times are exact in binary.
    for time_s in [3.25, 5.75, -1.75] {
        assert_eq!(at("Läufer", time_s), at("Läufer", 0.75), "{time_s} s");
    }
    assert_eq!(at("Läufer", 2.5), at("Läufer", 0.0), "the end is the beginning again");
    assert_eq!(at("", 7.0), shape.rest_pose(), "no time is within a clip of no duration");
}

#[test]
fn only_shapes_that_a_scene_varies_may_be_set() {
    let mut meta = scenes::scene(2).meta;
    meta.objects = ["fox", "plane"]
        .map(|name| StoredObject { name: name.to_owned(), material: 0, triangles: 0 })
        .to_vec();
    meta.shapes = vec![StoredShape { object: "fox".to_owned(), clips: Vec::new() }];
    (meta.varies_shape, meta.varies_view, meta.varies_light) = (true, true, false);
    let refusal = |meta: &Meta, card: &Card, text: &str| {
        let place = Place::file("s.toml");
        let state: State = parse_toml(text, &place).unwrap();
        state.expect_only(&meta.varies(card), &place).err().map(|e| e.to_string())
    };
    assert_eq!(refusal(&meta, &SPHERE_SHADOWS, "shapes.fox.time_s = 1\ncamera.fov_deg = 30"), None);
    let message = refusal(&meta, &SPHERE_SHADOWS, "shapes.plane.time_s = 1").unwrap();
    assert!(
        message.contains(
            "sets shape `plane`, which this bundle does not vary (only the camera, shape `fox` vary)"
        ),
        "{message}"
    );
    assert!(
        refusal(&meta, &SPHERE_SHADOWS, "environment.rotation_deg = 1").unwrap().contains("[environment]")
    );
    assert!(refusal(&meta, &SPARSE_TRANSFER, "shapes.fox.time_s = 1").unwrap().contains("sets shape `fox`"));
    meta.varies_shape = false;
    assert!(
        refusal(&meta, &SPHERE_SHADOWS, "shapes.fox.time_s = 1").unwrap().contains("only the camera varies")
    );
}

#[test]
fn scenes_whose_shapes_are_none_are_refused() {
    type Case = (fn(&mut Meta), &'static str);
    let clip = |name: &str, duration_s| StoredClip { name: name.to_owned(), duration_s };
    let cases: [Case; 4] = [
        (|m| m.shapes[0].object = "ghost".to_owned(), "shape `ghost` is no object"),
        (|m| m.shapes.push(m.shapes[0].clone()), "two objects that deform are called `fox`"),
        (|m| m.shapes[0].clips[1].name = "Walk".to_owned(), "two clips of shape `fox` are called `Walk`"),
        (|m| m.shapes[0].clips[1].duration_s = f32::NAN, "NaN s, is no number of at least 0"),
    ];
    for (change, expected) in cases {
        let mut scene = scenes::scene(2);
        scene.meta.objects = vec![StoredObject {
            name: "fox".to_owned(),
            material: 0,
            triangles: scene.triangles.len() as u32,
        }];
        scene.meta.shapes =
            vec![StoredShape { object: "fox".to_owned(), clips: vec![clip("Walk", 1.0), clip("Run", 0.0)] }];
        change(&mut scene.meta);
        let bytes = scene.to_bytes_unchecked(Place::file("a.relume")).unwrap();
        let message = refusal(Kind::Scene, &bytes).to_string();
        assert!(message.contains(expected), "`{expected}` is not in `{message}`");
    }
}

#[test]
fn a_shape_of_nothing_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relume");
    DeformingMesh::default().write_file(&path).unwrap();
    assert_eq!(DeformingMesh::read_file(&path).unwrap(), DeformingMesh::default());
}

#[test]
fn the_sections_are_those_documented() {
    let file = RawFile::parse(&written(&shape(4, 5)));
    let rows: Vec<(&str, u32, &[u64])> =
        file.sections.iter().map(|s| (s.name.as_str(), s.element, s.shape.as_slice())).collect();
    let record = |at: usize| [file.sections[at].raw_bytes];
    let [nodes, joints, clips] = [record(0), record(1), record(2)];
    assert_eq!(
        rows,
        [
            ("nodes", 0, &nodes[..]),
            ("joints", 0, &joints[..]),
            ("clips", 0, &clips[..]),
            ("positions", 4, &[5, 3]),
            ("joint-indices", 2, &[5, 4]),
            ("joint-weights", 4, &[5, 4]),
            ("target-weights", 4, &[3]),
            ("target-sizes", 2, &[3]),
            // Vertices 0, 2, 4; none; 1 to 4.
            ("target-vertices", 2, &[7]),
            ("target-deltas", 4, &[7, 3]),
            // 3 + 4 + 2 + 2 keys of the first clip, 1 of the second.
            ("key-times", 4, &[12]),
            // 3·3·4 + 4·3 + 2·3 + 2·3·1 + 4.
            ("key-values", 4, &[64]),
        ]
    );
    assert_eq!((file.kind, file.kind_version), (11, 0));
}

#[test]
fn shapes_that_break_the_rules_are_refused() {
    type Case = (fn(&mut DeformingMesh), &'static str);
    let cases: [Case; 10] = [
        (|s| s.clips[0].tracks[1].values.fill(1e30), "may take vertices"),
        (|s| s.clips[0].name = "\u{9b}".to_owned(), "of one of the clips has control characters"),
        (|s| s.positions[2][1] = f32::NAN, "vertex 2 is not a finite position"),
        (|s| s.influences[1].weights = [0.5, 0.0, 0.0, 0.0], "must have the sum 1"),
        (|s| s.influences[0].joints = [4, 4, 0, 0], "vertex 0: names joint 4 of 4"),
        (|s| s.joints[1].node = 9, "joint 1: names node 9 of 4"),
        (|s| s.nodes[0].parent = Some(3), "node 0: its parent 3 does not come before it"),
        (|s| s.morph_targets[0].vertices[0] = 4, "morph target 0: the vertices that it moves must increase"),
        (|s| s.clips[1].name = "Läufer".to_owned(), "two clips are called `Läufer`"),
        (|s| s.clips[0].tracks[1].times_s[1] = -1.0, "clip `Läufer`: track 1"),
    ];
    for (change, expected) in cases {
        let mut shape = shape(4, 5);
        change(&mut shape);
        let message = refusal(Kind::Shape, &written(&shape)).to_string();
        assert!(message.contains(expected), "`{expected}` is not in `{message}`");
    }
}

fn assert_forged_refused(section: &str, change: impl Fn(&mut RawSection), expected: &str) {
    let mut file = RawFile::parse(&written(&shape(4, 5)));
    change(file.sections.iter_mut().find(|s| s.name == section).unwrap());
    let message = refusal(Kind::Shape, &file.bytes()).to_string();
    assert!(message.contains(expected), "`{expected}` is not in `{message}`");
}

#[test]
fn sections_that_do_not_fit_each_other_are_refused() {
    let rows = |rows: u64| {
        move |s: &mut RawSection| {
            let per_row = s.raw().len() as u64 / s.shape[0];
            s.shape[0] = rows;
            s.set_raw(&s.raw()[..(rows * per_row) as usize]);
        }
    };
    for (section, most, part) in [
        ("joint-indices", 4, "section `joint-indices`: has shape [4, 4], expected [5, 4]"),
        ("joint-weights", 4, "section `joint-weights`: has 4 rows, expected 5"),
        ("target-sizes", 2, "section `target-sizes`: has 2 rows, expected 3"),
        ("target-vertices", 6, "section `target-deltas`: has 7 rows, expected 6"),
        ("target-deltas", 6, "section `target-deltas`: has 6 rows, expected 7"),
        ("key-times", 11, "section `clips`: does not fit the keys"),
        ("key-values", 63, "section `clips`: does not fit the keys"),
    ] {
        assert_forged_refused(section, rows(most), part);
    }
    assert_forged_refused("positions", |s| s.shape = vec![15], "has shape [15], expected rows of 3");
    assert_forged_refused("key-times", |s| s.shape = vec![12, 1], "expected one dimension");
    let sizes = |s: &mut RawSection| s.set_raw(&[3, 1, 4].map(u32::to_le_bytes).concat());
    assert_forged_refused("target-sizes", sizes, "does not sum to the 7 vertices that are moved");
    let huge = |s: &mut RawSection| s.set_raw(&[u32::MAX, u32::MAX, 9].map(u32::to_le_bytes).concat());
    assert_forged_refused("target-sizes", huge, "does not sum to the 7 vertices that are moved");
    // The clips' record ends with a track's count of keys, but for a clip without name, duration or tracks: 8
    // + 4 + 8 bytes.
    let keys = |count: u32| {
        move |s: &mut RawSection| {
            let (mut raw, end) = (s.raw(), s.raw().len() - 20);
            raw[end - 4..end].copy_from_slice(&count.to_le_bytes());
            s.set_raw(&raw);
        }
    };
    assert_forged_refused("clips", keys(u32::MAX), "section `clips`: does not fit the keys");
    assert_forged_refused("clips", keys(0), "section `clips`: does not fit the keys");
}

/// The counts are looked at before the values.
#[test]
fn too_many_of_anything_are_refused() {
    let zeros = |element: u32, shape: &[u64]| {
        let (element, shape) = (element, shape.to_vec());
        move |s: &mut RawSection| {
            let raw = vec![0; shape.iter().product::<u64>() as usize * 4];
            *s = RawSection::new(&s.name, element, &shape, 1, &raw);
        }
    };
    let (joints, morphed) = (MAX_JOINTS as u64 + 1, MAX_MORPHED as u64 + 1);
    assert_forged_refused("target-weights", zeros(4, &[joints]), "has 65537 rows, at most 65536 are allowed");
    assert_forged_refused(
        "target-vertices",
        zeros(2, &[morphed]),
        "has 16777217 rows, at most 16777216 are allowed",
    );
    assert_forged_refused(
        "key-times",
        zeros(4, &[MAX_CLIP_KEYS as u64 + 1]),
        "has 4194305 rows, at most 4194304 are allowed",
    );
    // No section of positions can be as long as the limit.
    assert_forged_refused("positions", |s| s.raw_bytes = 12 * (MAX_VERTICES as u64 + 1), "does not make");
}
