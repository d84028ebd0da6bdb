//! The sample models that `make assets` fetches.

use super::{at, at_rest};
use crate::scene::Mesh;
use crate::test_support::enclosed_volume;
use crate::{load_deforming, load_mesh};
use glam::Vec3;
use std::path::Path;

fn asset(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name)
}

/// The least and the greatest coordinates.
fn bounds(positions: &[[f32; 3]]) -> [Vec3; 2] {
    let vectors = positions.iter().map(|p| Vec3::from(*p));
    vectors.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[least, greatest], p| [least.min(p), greatest.max(p)])
}

#[test]
#[ignore = "needs make assets"]
fn the_fox_walks() {
    let mut warnings = Vec::new();
    let fox = load_deforming(&asset("fox.glb"), &mut warnings).unwrap();
    assert_eq!(fox.rest, load_mesh(&asset("fox.glb"), &mut Vec::new()).unwrap());
    assert_eq!(
        (fox.rest.positions.len(), fox.rest.triangles.len(), fox.shape.joints.len()),
        (1728, 576, 24),
        "{warnings:?}"
    );
    assert_eq!(at_rest(&fox), fox.rest.positions);
    // The model is stored in its bind pose, which is its rest pose.
    for (rest, stored) in fox.rest.positions.iter().zip(&fox.shape.positions) {
        assert!(Vec3::from(*rest).distance(Vec3::from(*stored)) < 1e-3, "{rest:?} {stored:?}");
    }
    let clips: Vec<_> =
        fox.shape.clips.iter().map(|clip| (clip.name.as_str(), (clip.duration_s * 24.0).round())).collect();
    assert_eq!(clips, [("Survey", 82.0), ("Walk", 17.0), ("Run", 28.0)]);
    let walk = &fox.shape.clips[1];
    assert!((walk.duration_s - 0.708_333_3).abs() < 1e-6);
    let [rest_least, rest_greatest] = bounds(&fox.rest.positions);
    let (mut out, mut seen) = (Vec::new(), Vec::new());
    for frame in 0..=17 {
        fox.shape.positions_at(walk, frame as f32 / 24.0, &mut out);
        let [least, greatest] = bounds(&out);
        let (size, rest_size) = (greatest - least, rest_greatest - rest_least);
        assert!(
            size.cmpgt(0.5 * rest_size).all() && size.cmplt(2.0 * rest_size).all(),
            "frame {frame}: {size} of {rest_size}"
        );
        assert!(least.y > -0.1 * rest_size.y, "frame {frame}: feet at {}", least.y);
        assert!(
            (least + greatest).distance(rest_least + rest_greatest) < rest_size.length(),
            "frame {frame}: walks on the spot"
        );
        seen.push(out.clone());
    }
    // The walk is a cycle: its last pose is near its first, and its middle is not.
    let apart = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.iter().zip(b).map(|(a, b)| Vec3::from(*a).distance(Vec3::from(*b))).fold(0.0, f32::max)
    };
    assert!(
        apart(&seen[0], &seen[17]) < 0.2 * apart(&seen[0], &seen[8]),
        "{} {}",
        apart(&seen[0], &seen[17]),
        apart(&seen[0], &seen[8])
    );
}

#[test]
#[ignore = "needs make assets"]
fn the_cube_morphs() {
    let cube = load_deforming(&asset("morph-cube.glb"), &mut Vec::new()).unwrap();
    assert_eq!(cube.rest, load_mesh(&asset("morph-cube.glb"), &mut Vec::new()).unwrap());
    assert_eq!(
        (cube.rest.positions.len(), cube.rest.triangles.len(), cube.shape.morph_targets.len()),
        (24, 12, 2)
    );
    assert_eq!(
        (cube.shape.clips.len(), cube.shape.clips[0].name.as_str(), cube.shape.clips[0].tracks.len()),
        (1, "Square", 2)
    );
    assert!((cube.shape.clips[0].duration_s - 4.2).abs() < 1e-4);
    assert_eq!(at_rest(&cube), cube.rest.positions);
    assert!((enclosed_volume(&cube.rest) - 8.0).abs() < 1e-3, "a cube of 2");
    // Both targets only push sides of the cube along one axis, by nearly its size: it shrinks and never
    // leaves its bounds.
    let [least, greatest] = bounds(&cube.rest.positions);
    let volumes = (0..=42).map(|frame| {
        let positions = at(&cube, frame as f32 / 10.0);
        let [l, g] = bounds(&positions);
        assert!(l.cmpge(least - 1e-3).all() && g.cmple(greatest + 1e-3).all(), "frame {frame}: {l} {g}");
        enclosed_volume(&Mesh { positions, ..cube.rest.clone() })
    });
    let (smallest, largest) = volumes.fold((f64::INFINITY, 0.0f64), |(s, l), v| (s.min(v), l.max(v)));
    assert!(smallest > -1e-3 && smallest < 1.0 && (largest - 8.0).abs() < 1e-2, "{smallest} {largest}");
}
