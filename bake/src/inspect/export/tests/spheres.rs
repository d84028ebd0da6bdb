//! An exported sphere set, and what `info` and `verify` say of it.

use super::super::super::test_spheres::octahedron;
use super::super::super::{info, verify};
use super::*;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::Solid;

/// The folder, the file in it, and where it was exported to.
fn exported() -> (tempfile::TempDir, PathBuf, PathBuf, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let (path, out) = (folder.path().join("octahedron.relume"), folder.path().join("out"));
    octahedron().write_file(&path).unwrap();
    let files = export_file(&path, &out).unwrap();
    (folder, path, out, files)
}

#[test]
fn arrays_are_those_of_the_file() {
    let (_folder, _, out, files) = exported();
    let set = octahedron();
    assert_eq!(
        names(&files, &out),
        ["spheres.npy", "points.npy", "cluster.npy", "history.npy", "spheres.ply", "metrics.json"]
    );
    assert_eq!(Npy::f32s(&files[0]), (vec![2, 4], vec![0.0, 0.0, 1.0, 1.5, 0.0, 0.0, -1.0, 1.5]));
    assert_eq!(Npy::f32s(&files[1]), (vec![7, 3], set.points.as_flattened().to_vec()));
    let cluster = Npy::read(&files[2]);
    let numbers: Vec<u32> = cluster.payload.as_chunks().0.iter().map(|c| u32::from_le_bytes(*c)).collect();
    assert_eq!((cluster.shape, cluster.descr.as_str(), numbers), (vec![7], "<u4", vec![0, 0, 1, 1, 0, 1, 0]));
    assert_eq!(Npy::f32s(&files[3]), (vec![3], vec![4.0, 3.0, 2.5]));
}

#[test]
fn metrics_have_their_names_and_info_tells_the_same() {
    let (_folder, path, out, _) = exported();
    let metrics = json(&out.join("metrics.json"));
    let expected = serde_json::json!({
        "E/V(T)": 2.5, "coverage": 0.9375, "coverage_surface": 1.0, "coverage_volume": 0.9375,
        "protrusion": { "mean": 0.25, "p95": 0.5, "max": 0.75 }, "largest_uncovered_gap": 0.125, "overlap": 0.375,
        "n": 2, "poses": 0, "volume": 8.0 / 3.0, "outside_volume": 2.5 * (8.0 / 3.0), "diagonal": 4.8989797, "mesh": "octahedron.off", "vertices": 6,
        "triangles": 8, "seed": 7, "iterations": 40, "tight": 0.0, "solid": "closed",
    });
    assert_eq!(metrics, expected);
    let value: Value = serde_json::from_str(&info(&path, true).unwrap()).unwrap();
    for (name, metric) in expected.as_object().unwrap() {
        assert_eq!(&value["details"][name], metric, "{name}");
    }
    assert_eq!((&value["details"]["points"], &value["details"]["iterations_done"]), (&7.into(), &3.into()));
}

#[test]
fn info_says_how_good_a_fit_is() {
    let (folder, path, ..) = exported();
    let text = info(&path, false).unwrap();
    for line in [
        "  kind        sphere-set version 0, container version 0\n",
        "  mesh        octahedron.off, 6 vertices, 8 triangles, diagonal 4.89",
        "  solid       closed, so its volumes are exact\n",
        "  spheres     2, which follow 7 points\n",
        "  fit         seed 7, 3 of at most 40 iterations, complete coverage\n",
        "  E/V(T)      2.500000, of the volume 2.66666",
        "  coverage    100.0000 % of the surface, 93.7500 % of the volume\n",
        // 0.125, 0.25, 0.5 and 0.75 of √24.
        "  gap         2.5516 % of the diagonal at most\n",
        "  protrusion  5.1031 % of the diagonal in the mean, 10.2062 % at 95 %, 15.3093 % at most\n",
        "  overlap     0.3750\n",
    ] {
        assert!(text.contains(line), "`{line}` is not in\n{text}");
    }
    let mut open = octahedron();
    (open.meta.solid, open.meta.tight) = (Solid::WindingNumber { cells: 64 }, 0.5);
    let path = folder.path().join("open.relume");
    open.write_file(&path).unwrap();
    let text = info(&path, false).unwrap();
    assert!(
        text.contains("on a grid of 64 cells") && text.contains("up to 50 % of the diagonal uncovered"),
        "{text}"
    );
    export_file(&path, folder.path()).unwrap();
    assert_eq!(
        json(&folder.path().join("metrics.json"))["solid"],
        serde_json::json!({ "winding-number": { "cells": 64 } })
    );
}

/// Vertices on their spheres with normals outwards, triangles of one sphere each and facing out, two colours.
#[test]
fn the_mesh_is_made_of_spheres() {
    let (_folder, _, out, _) = exported();
    let file = std::fs::read(out.join("spheres.ply")).unwrap();
    let end = file.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&file[..end]).unwrap();
    // An icosphere of 1,280 triangles has 642 vertices.
    assert!(header.contains("\ncomment mesh units\nelement vertex 1284\n"), "{header}");
    assert!(header.ends_with("nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2560\nproperty list uchar int vertex_indices\nend_header\n"), "{header}");
    let (vertices, faces) = file[end..].split_at(1284 * 27);
    let mut positions = Vec::new();
    let mut colours = BTreeSet::new();
    for (index, row) in vertices.chunks_exact(27).enumerate() {
        let float = |k: usize| f32::from_le_bytes(row[4 * k..4 * k + 4].try_into().unwrap());
        let [position, normal] = [0, 3].map(|k| glam::Vec3::new(float(k), float(k + 1), float(k + 2)));
        let centre = glam::Vec3::new(0.0, 0.0, if index < 642 { 1.0 } else { -1.0 });
        assert!((position - centre - 1.5 * normal).length() < 1e-6 && (normal.length() - 1.0).abs() < 1e-6);
        positions.push(position - centre);
        colours.insert((index / 642, row[24..].to_vec()));
    }
    assert_eq!(colours.len(), 2);
    assert_ne!(colours.first().unwrap().1, colours.last().unwrap().1);
    assert_eq!(faces.len(), 2560 * 13);
    for (index, face) in faces.chunks_exact(13).enumerate() {
        assert_eq!(face[0], 3);
        let corners = [1, 5, 9].map(|k| i32::from_le_bytes(face[k..k + 4].try_into().unwrap()) as usize);
        assert!(corners.iter().all(|v| v / 642 == index / 1280));
        let [a, b, c] = corners.map(|v| positions[v]);
        assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "faces out");
    }
}

#[test]
fn a_set_must_keep_what_it_promises() {
    let (folder, path, ..) = exported();
    assert!(verify(&path).unwrap().ends_with("sphere-set, 7 sections, every checksum and value checked\n"));
    let verdict = |change: &dyn Fn(&mut SphereSet)| {
        let mut set = octahedron();
        change(&mut set);
        let path = folder.path().join("changed.relume");
        std::fs::write(&path, set.to_bytes_unchecked(Place::file(&path)).unwrap()).unwrap();
        verify(&path).map_err(|e| e.to_string())
    };
    // Points 0 and 1 lie √2 from the centre of their sphere; the diagonal is 4.9, so they may stand out by
    // 4.9e-5.
    assert!(verdict(&|s| s.spheres[0][3] = 2f32.sqrt() - 4e-5).is_ok());
    let message = verdict(&|s| s.spheres[0][3] = 1.414).unwrap_err();
    assert!(
        message.contains("section `spheres`: point 0 is 0.0002") && message.contains("outside its sphere 0"),
        "{message}"
    );
    assert!(verdict(&|s| (s.spheres[0][3], s.meta.tight) = (1.4, 0.01)).is_ok(), "0.049 may be left out");
    assert!(
        verdict(&|s| (s.spheres[0][3], s.meta.tight) = (1.3, 0.01)).unwrap_err().contains("point 0 is 0.11")
    );
    let message = verdict(&|s| s.history[2] = 2.4).unwrap_err();
    assert!(
        message.contains("section `history`: ends with E/V(T) = 2.4") && message.contains("the set has 2.5"),
        "{message}"
    );
    // What breaks the rules of the kind is refused before.
    assert!(
        verdict(&|s| s.clusters[0] = 2)
            .unwrap_err()
            .contains("point 0 belongs to a sphere that is not there")
    );
}
