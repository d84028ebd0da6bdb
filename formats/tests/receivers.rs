//! The kind `sphere-shadows`: what is written comes back, what is broken is refused, and terms stand in
//! order.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::{read_and_use, refusal};
use crate::support::samples::Random;
use crate::support::shadows::sphere_shadows;
use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::basis::diffuse::{self, NODES};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::SphereShadows;
use relume_formats::kinds::sphere_shadows::{COEFFICIENTS, Casts, NO_ROW, ORDERED, order};

fn sample() -> SphereShadows {
    sphere_shadows(1, &[5, 4, 3], 2)
}

fn written(shadows: &SphereShadows) -> Vec<u8> {
    shadows.to_bytes_unchecked(Place::file("a.relume")).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2) })]

    #[test]
    fn shadows_come_back(seed: u64, vertices in prop::collection::vec(1u32..9, 1..5), exact in 0usize..9) {
        let shadows = sphere_shadows(seed, &vertices, exact);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.relume");
        let bytes = shadows.write_file(&path).unwrap();
        let read = SphereShadows::read_file(&path).unwrap();
        prop_assert!(read == shadows);
        prop_assert!(read.write_file(&path).unwrap() == bytes, "reading and writing again changes nothing");
        prop_assert!(RawFile::parse(&bytes).bytes() == bytes);
        read_and_use(Kind::SphereShadows, &path).unwrap();
    }
}

#[test]
fn the_sections_are_those_documented() {
    let file = RawFile::parse(&written(&sample()));
    let rows: Vec<(&str, u32, &[u64])> =
        file.sections.iter().map(|s| (s.name.as_str(), s.element, s.shape.as_slice())).collect();
    let meta = [file.sections[0].raw_bytes];
    assert_eq!(
        rows,
        [
            ("meta", 0, &meta[..]),
            ("rows", 2, &[12]),
            ("normals", 4, &[386, 3]),
            ("lobes", 4, &[386, 6144]),
            ("order", 1, &[386, 200]),
            ("casters", 2, &[2, 3]),
            ("caster_offsets", 4, &[2, 3]),
            ("caster_errors", 4, &[2]),
        ]
    );
    assert_eq!((file.kind, file.kind_version), (12, 0));
}

fn assert_refused(change: impl FnOnce(&mut SphereShadows), expected: &str) {
    let mut shadows = sample();
    change(&mut shadows);
    let message = refusal(Kind::SphereShadows, &written(&shadows)).to_string();
    assert!(message.contains(expected), "`{expected}` is not in `{message}`");
}

#[test]
fn broken_objects_and_rows_are_refused() {
    type Case = (fn(&mut SphereShadows), &'static str);
    let cases: [Case; 18] = [
        (
            |s| s.meta.face_size = 64,
            "section `meta`: faces of 64 texels and a grid of 8 nodes a side, expected 32 and 8",
        ),
        (|s| s.meta.normal_grid = 0, "a grid of 0 nodes"),
        (|s| s.meta.terms = 5, "keeps 5 terms, expected 6 to 200"),
        (|s| s.meta.terms = 201, "keeps 201 terms, expected 6 to 200"),
        (|s| s.meta.objects.clear(), "there are no objects"),
        (|s| s.meta.objects[2].name = "päper 0".to_owned(), "two objects are called `päper 0`"),
        (|s| s.meta.objects[0].first_vertex = 1, "object `päper 0` has 5 vertices from 1 on"),
        (
            |s| s.meta.objects[1].first_vertex = 4,
            "object `päper 1` has 4 vertices from 4 on, which do not follow those before",
        ),
        (|s| s.meta.objects[1].vertices = 0, "object `päper 1` has 0 vertices"),
        (|s| s.meta.objects[1].vertices = u32::MAX, "object `päper 2` has 3 vertices from 9 on"),
        (|s| s.meta.objects.swap(0, 1), "object `päper 1` has 4 vertices from 5 on"),
        (|s| s.meta.objects[2].vertices = 2, "section `rows`: has shape [12], expected [11]"),
        (|s| s.meta.objects[2].vertices = u32::MAX - 9, "has shape [12], expected [4294967295]"),
        (|s| s.rows.push(NO_ROW), "has shape [13], expected [12]"),
        (|s| s.rows[3] = 386, "vertex 3 has row 386, expected one of 384..386 or none"),
        (|s| s.rows[11] = NO_ROW - 1, "vertex 11 has row 4294967294"),
        (|s| s.rows[0] = 383, "vertex 0 has row 383"),
        (|s| s.rows[6] = 384, "object `päper 1` deforms, so its vertices cannot have rows of their own"),
    ];
    cases.into_iter().for_each(|(change, expected)| assert_refused(change, expected));
}

#[test]
fn broken_normals_and_lobes_are_refused() {
    type Case = (fn(&mut SphereShadows), &'static str);
    let cases: [Case; 17] = [
        (
            |s| s.normals.truncate(NODES - 1),
            "section `normals`: has shape [383, 3], expected [384 to 4096, 3]",
        ),
        (|s| s.normals = vec![[1.0, 0.0, 0.0]; 4097], "has shape [4097, 3]"),
        (|s| s.normals[385] = [0.0; 3], "the normal of row 385 is not of length 1"),
        (|s| s.normals[385][1] = 0.01, "the normal of row 385 is not of length 1"),
        (|s| s.normals[2][0] = f32::NAN, "the normal of row 2 is not"),
        (|s| s.normals[384][0] = f32::INFINITY, "the normal of row 384 is not"),
        (|s| s.normals.swap(7, 9), "row 7 is not that node of the grid"),
        (|s| s.lobes[3] = f32::NAN, "section `lobes`: element 3 is not a finite number"),
        (|s| s.lobes[386 * 6144 - 1] = f32::NEG_INFINITY, "section `lobes`: element 2371583 is not"),
        (|s| s.lobes.iter_mut().for_each(|c| *c *= 1000.0), "section `lobes`: coefficient 0 of row 0 is"),
        (|s| s.lobes.iter_mut().for_each(|c| *c = -*c), "which is not that of the lobe of its normal"),
        (|s| s.lobes[384 * 6144 + 77] += 1e-4, "section `lobes`: coefficient 77 of row 384"),
        (|s| s.lobes[5 * 6144..6 * 6144].fill(0.0), "of row 5 is 0"),
        (
            |s| s.order[199] = 6144,
            "section `order`: the terms of row 0 are not the largest of its lobe in order",
        ),
        (|s| s.order[385 * 200 + 8] = s.order[385 * 200 + 7], "the terms of row 385"),
        (|s| s.order.swap(3 * 200 + 6, 3 * 200 + 7), "the terms of row 3"),
        (|s| s.order.swap(0, 1), "the terms of row 0"),
    ];
    // Rows and lobes need to be as many as normals, or writing them fails.
    for (change, expected) in cases {
        let fit = |s: &mut SphereShadows| {
            change(s);
            s.lobes.resize(s.normals.len() * COEFFICIENTS, 0.0);
            s.order.resize(s.normals.len() * ORDERED, 0);
        };
        assert_refused(fit, expected);
    }
}

#[test]
fn broken_casters_are_refused() {
    type Case = (fn(&mut SphereShadows), &'static str);
    let cases: [Case; 12] = [
        (|s| s.meta.objects[0].sphere_set = false, "object `päper 0` casts shadows by spheres and has none"),
        (
            |s| s.meta.objects[2].casts = Casts::Mesh { triangles: 0, closed: true },
            "object `päper 2` casts shadows by its mesh, but by no triangle of it",
        ),
        (
            |s| s.meta.objects[2].casts = Casts::Mesh { triangles: u32::MAX, closed: true },
            "section `casters`: 4294967295 triangles cast shadows, at most 1048576 may",
        ),
        (
            |s| s.meta.objects[2].casts = Casts::Mesh { triangles: 3, closed: true },
            "section `casters`: has shape [2, 3], expected [3, 3]",
        ),
        (|s| s.meta.objects[2].casts = Casts::Nothing, "has shape [2, 3], expected [0, 3]"),
        (
            |s| s.casters[1][2] = 12,
            "triangle 1 has the corners [11, 10, 12], which are not three vertices of object `päper 2`",
        ),
        (|s| s.casters[0][0] = 8, "triangle 0 has the corners [8, 10, 11]"),
        (|s| s.casters[0][0] = u32::MAX, "triangle 0 has the corners [4294967295, 10, 11]"),
        (|s| s.casters[0][0] = 10, "triangle 0 has the corners [10, 10, 11]"),
        (
            |s| s.caster_errors[1] = -1.0,
            "section `caster_errors`: the error of triangle 1 is -1, expected metres",
        ),
        (|s| s.caster_errors[0] = f32::NAN, "the error of triangle 0 is NaN"),
        (|s| s.caster_errors.truncate(1), "section `caster_errors`: has shape [1], expected [2]"),
    ];
    cases.into_iter().for_each(|(change, expected)| assert_refused(change, expected));
}

#[test]
fn sections_of_other_shapes_and_orders_are_refused() {
    let sound = RawFile::parse(&written(&sample()));
    let refused = |change: &dyn Fn(&mut Vec<RawSection>)| {
        let mut sections = sound.sections.clone();
        change(&mut sections);
        refusal(Kind::SphereShadows, &RawFile::new(sound.kind, sections).bytes()).to_string()
    };
    for (section, shape) in [(1, vec![12, 1]), (2, vec![3, 386]), (3, vec![6144, 386]), (4, vec![77_200])] {
        let message = refused(&|s| s[section].shape = shape.clone());
        assert!(
            message.contains(&format!("section `{}`: has shape", sound.sections[section].name)),
            "{message}"
        );
    }
    for at in 0..8 {
        refused(&|s| drop(s.remove(at)));
    }
    assert!(refused(&|s| s.swap(3, 4)).contains("expected section `lobes` here"));
    let message = refused(&|s| s.push(RawSection { name: "more".to_owned(), ..s[0].clone() }));
    assert!(message.contains("9 sections, kind `sphere-shadows` has at most 8"), "{message}");
}

#[test]
fn damaged_and_shortened_files_are_refused() {
    let file = written(&sample());
    for at in (0..file.len()).step_by(file.len() / 25) {
        let mut damaged = file.clone();
        damaged[at] ^= 4;
        refusal(Kind::SphereShadows, &damaged);
        refusal(Kind::SphereShadows, &file[..at]);
    }
}

/// By its definition: nothing left out is larger than anything kept, and what is kept falls.
fn assert_ordered(lobe: &[f32]) {
    let terms = order(lobe);
    assert_eq!(terms[..6], [0, 1024, 2048, 3072, 4096, 5120], "scaling functions");
    let mut plain: Vec<usize> = (0..COEFFICIENTS).filter(|i| i % 1024 != 0).collect();
    // Stable, so equals stay as they are.
    plain.sort_by(|a, b| lobe[*b].abs().total_cmp(&lobe[*a].abs()));
    let expected: Vec<u16> = plain[..ORDERED - 6].iter().map(|i| *i as u16).collect();
    assert_eq!(terms[6..], expected);
}

#[test]
fn terms_stand_by_size_after_the_scaling_functions() {
    let random = &mut Random(5);
    assert_ordered(&vec![0.0; COEFFICIENTS]);
    assert_ordered(&(0..COEFFICIENTS).map(|_| random.signed()).collect::<Vec<_>>());
    // Many equals, zeros of both signs among them.
    assert_ordered(
        &(0..COEFFICIENTS)
            .map(|_| [0.0, -0.0, 0.5, -0.5, 1e-40, f32::MAX][random.below(6)])
            .collect::<Vec<_>>(),
    );
    for node in [0, 77, 383] {
        assert_ordered(&diffuse::lobe(diffuse::grid_normal(node)));
    }
}
