//! Environment maps as other programs write them.

use super::messages::{copy_of, exits};

#[test]
fn maps_that_are_not_twice_as_wide_as_high_are_refused() {
    let folder = copy_of("environment-not-2-to-1");
    let expected = "error: probe.hdr: 8 × 8 texels, square as mirror balls and angular probes are; an equirectangular map is twice as wide as high, convert it to one\n";
    assert_eq!(exits(2, &folder, &["bake", "export", "scene.toml", "-o", "out"]), expected);
}

#[test]
fn cube_maps_are_refused_by_name() {
    let folder = copy_of("exr-cube-map-as-latlong");
    let expected = "error: cube.exr: its envmap attribute is cube, expected latlong; convert it (exrenvmap -l in.exr out.exr)\n";
    assert_eq!(exits(2, &folder, &["bake", "export", "scene.toml", "-o", "out"]), expected);
}

/// The one layer that has R, G and B is read, and a file that begins as no other reader expects.
#[test]
fn layers_and_other_signatures_are_read() {
    for (case, map) in [("exr-layers-message", "layers.exr"), ("hdr-rgbe-signature", "rgbe.hdr")] {
        let folder = copy_of(case);
        assert_eq!(exits(0, &folder, &["bake", "export", "scene.toml", "-o", "out"]), "");
        let scene = relume_scenes::load(&folder.path().join("scene.toml")).unwrap();
        let named = scene.environment.unwrap().map;
        assert_eq!((named.name.as_str(), named.map.width, named.map.height), (map, 8, 4));
        // Flat RGBE of 128, 128, 128, 129 is 1.
        assert!(named.map.texels.iter().all(|texel| *texel == [1.0; 3]), "{:?}", named.map.texels);
    }
}
