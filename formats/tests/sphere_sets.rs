//! The kind `sphere-set`: what is written comes back, and what is broken is refused.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::refusal;
use crate::support::spheres::{diagonal, sphere_set};
use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::{MAX_SPHERES, Solid};

fn written(set: &SphereSet) -> Vec<u8> {
    set.to_bytes_unchecked(Place::file("a.relume")).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn sphere_sets_come_back(seed: u64, vertices in 2usize..9, more in 0usize..20, spheres in 1usize..12, moved in -1e4f32..1e4) {
        let mut set = sphere_set(seed, vertices, vertices + more, spheres, 0.5);
        // Radii of these samples are up to a diagonal and 0.93, which is more than a reader takes about
        // vertices that all but coincide.
        prop_assume!(diagonal(&set) >= 1.0);
        // What is far from the origin is legal too, with the roundings that it has there.
        set.points[..vertices].iter_mut().flatten().for_each(|x| *x += moved);
        for at in vertices..set.points.len() {
            let (corners, weights) = (set.point_vertices[at], set.point_weights[at]);
            let place = |axis: usize| (0..3).map(|k| set.points[corners[k] as usize][axis] * weights[k]).sum::<f32>();
            set.points[at] = [place(0), place(1), place(2)];
        }
        set.spheres.iter_mut().for_each(|sphere| sphere[..3].iter_mut().for_each(|x| *x += moved));
        set.meta.diagonal = diagonal(&set);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.relume");
        let bytes = set.write_file(&path).unwrap();
        let read = SphereSet::read_file(&path).unwrap();
        prop_assert_eq!(&read, &set);
        prop_assert_eq!(&read.write_file(&path).unwrap(), &bytes, "reading and writing again changes nothing");
        prop_assert_eq!(RawFile::parse(&bytes).bytes(), bytes);
    }
}

#[test]
fn the_sections_are_those_documented() {
    let file = RawFile::parse(&written(&sphere_set(4, 5, 9, 3, 0.5)));
    let rows: Vec<(&str, u32, &[u64])> =
        file.sections.iter().map(|s| (s.name.as_str(), s.element, s.shape.as_slice())).collect();
    let meta = [file.sections[0].raw_bytes];
    assert_eq!(
        rows,
        [
            ("meta", 0, &meta[..]),
            ("spheres", 4, &[3, 4]),
            ("points", 4, &[9, 3]),
            ("point-vertices", 2, &[9, 3]),
            ("point-weights", 4, &[9, 3]),
            ("clusters", 2, &[9]),
            ("history", 4, &[4]),
        ]
    );
    assert_eq!((file.kind, file.kind_version), (9, 0));
}

fn assert_refused(change: impl FnOnce(&mut SphereSet), expected: &str) {
    let mut set = sphere_set(4, 5, 9, 3, 0.5);
    change(&mut set);
    let message = refusal(Kind::SphereSet, &written(&set)).to_string();
    assert!(message.contains(expected), "`{expected}` is not in `{message}`");
}

#[test]
fn fits_that_are_none_are_refused() {
    type Case = (fn(&mut SphereSet), &'static str);
    let cases: [Case; 18] = [
        (|s| s.meta.vertices = 0, "section `meta`: 0 vertices"),
        (|s| s.meta.triangles = 0, "0 triangles"),
        (|s| s.meta.solid = Solid::WindingNumber { cells: 0 }, "cells: 0 } are no solid"),
        (|s| s.meta.diagonal = 0.0, "diagonal 0 and volume 2 must be"),
        (|s| s.meta.diagonal = f32::NAN, "diagonal NaN"),
        (|s| s.meta.volume = 0.0, "volume 0 must be numbers above 0"),
        (|s| s.meta.volume = f64::INFINITY, "volume inf"),
        (|s| s.meta.tight = -0.5, "tight -0.5 must be a number of at least 0"),
        (|s| s.meta.outside_volume = f64::NAN, "outside volume NaN"),
        (|s| s.meta.quality.coverage_surface = 1.001, "coverages 1.001 and 0.75 must be at most 1"),
        (|s| s.meta.quality.coverage_volume = -0.1, "coverage of the volume -0.1"),
        (|s| s.meta.quality.largest_gap = -1.0, "largest gap -1"),
        (|s| s.meta.quality.overlap = -1.5, "overlap -1.5 must be a number of at least -1"),
        (|s| s.meta.quality.overlap = f64::NAN, "overlap NaN"),
        (|s| s.meta.quality.protrusion.mean = f64::INFINITY, "mean protrusion inf"),
        (|s| s.meta.quality.protrusion.p95 = 0.5, "must be at most the largest, 0.03"),
        (|s| s.meta.quality.protrusion.max = 0.005, "must be at most the largest, 0.005"),
        (|s| s.meta.vertices = 10, "section `points`: has shape [9, 3], expected [at least 10, 3]"),
    ];
    cases.into_iter().for_each(|(change, expected)| assert_refused(change, expected));
    // Not covering is legal, and so is overlapping less than not at all.
    let mut open = sphere_set(4, 5, 9, 3, 0.5);
    (open.meta.tight, open.meta.quality.overlap) = (0.01, -0.125);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relume");
    open.write_file(&path).unwrap();
    assert_eq!(SphereSet::read_file(&path).unwrap(), open);
}

#[test]
fn spheres_and_points_that_are_none_are_refused() {
    type Case = (fn(&mut SphereSet), &'static str);
    let cases: [Case; 24] = [
        (|s| s.spheres.clear(), "section `spheres`: has shape [0, 4], expected [1 to 4096, 4]"),
        (|s| s.spheres = vec![[1.0; 4]; MAX_SPHERES as usize + 1], "has shape [4097, 4]"),
        (|s| s.spheres[1][3] = 0.0, "sphere 1 has a radius that is not above 0"),
        (|s| s.spheres[2][3] = -1.0, "sphere 2 has a radius"),
        (|s| s.spheres[1][3] = f32::INFINITY, "element 7 is not a finite number"),
        (|s| s.spheres[0][1] = f32::NAN, "section `spheres`: element 1 is not"),
        (|s| s.spheres[1][3] = 1e30, "section `spheres`: sphere 1 of radius 1e30 about ["),
        (|s| s.spheres[2][0] += 50.0, "or so far from the mesh"),
        (|s| s.spheres.iter_mut().for_each(|s| s[3] *= 0.1), "outside its sphere"),
        (|s| s.meta.diagonal *= 1.001, "section `spheres`: a mesh of diagonal"),
        (|s| s.meta.mesh = "a\tb".to_owned(), "the name `a\\tb` of the mesh has control characters"),
        (|s| s.meta.outside_volume = 0.6, "section `history`: ends with E/V(T) = 0.25, but the set has 0.3"),
        (|s| (s.meta.volume, s.meta.outside_volume) = (1e-300, 1e300), "have no ratio"),
        (|s| s.points[7][2] = f32::NAN, "section `points`: element 23 is not a finite number"),
        (
            |s| s.points[7][2] += 1e-3,
            "section `point-weights`: point 7 is not where its vertices and weights put it",
        ),
        (
            |s| s.point_vertices[8][1] = 5,
            "section `point-vertices`: point 8 names a vertex that is not there",
        ),
        (|s| s.point_vertices.swap(2, 3), "point 2 is not vertex 2"),
        (
            |s| s.point_weights[6] = [1.5, -0.5, 0.0],
            "section `point-weights`: the weights of point 6 are below 0",
        ),
        (|s| s.point_weights[6][0] += 1e-4, "the weights of point 6 are below 0 or do not sum to 1"),
        (|s| s.point_weights[3] = [0.0, 1.0, 0.0], "the weights of vertex 3 are not 1, 0, 0"),
        (|s| s.point_weights[8][2] = f32::NAN, "element 26 is not a finite number"),
        (|s| s.clusters[4] = 3, "section `clusters`: point 4 belongs to a sphere that is not there"),
        (|s| s.history.clear(), "section `history`: is empty"),
        (|s| s.history[2] = 0.7501, "section `history`: rises from element 1 to the next"),
    ];
    cases.into_iter().for_each(|(change, expected)| assert_refused(change, expected));
    assert_refused(|s| s.history[3] = f32::NAN, "section `history`: element 3");
    assert_refused(|s| s.history = vec![-1.0], "a volume is negative");
}

#[test]
fn sections_of_other_shapes_and_orders_are_refused() {
    let sound = RawFile::parse(&written(&sphere_set(4, 5, 9, 3, 0.5)));
    let refused = |change: &dyn Fn(&mut Vec<RawSection>)| {
        let mut sections = sound.sections.clone();
        change(&mut sections);
        refusal(Kind::SphereSet, &RawFile::new(sound.kind, sections).bytes()).to_string()
    };
    for (section, shape) in
        [(1, vec![12]), (2, vec![27]), (3, vec![3, 9]), (4, vec![27]), (5, vec![9, 1]), (6, vec![2, 2])]
    {
        let message = refused(&|s| s[section].shape = shape.clone());
        assert!(
            message.contains(&format!("section `{}`: has shape", sound.sections[section].name)),
            "{message}"
        );
    }
    for at in 0..7 {
        refused(&|s| drop(s.remove(at)));
    }
    assert!(refused(&|s| s.swap(1, 2)).contains("expected section `spheres` here"));
    let message = refused(&|s| s.push(RawSection { name: "more".to_owned(), ..s[0].clone() }));
    assert!(message.contains("8 sections, kind `sphere-set` has at most 7"), "{message}");
}
