//! sparse-transfer: lights that no map has, walls without thickness, receivers without light, and what is
//! left out.

use crate::support::relit::{BALL, Baked, bake, wanted};
use crate::support::{expect_exit, relative_l2, scaled, scene, write_scene};
use glam::Vec3;
use half::f16;
use relume_bake::method::Method as _;
use relume_bake::methods::sparse_transfer::{Settings, SparseTransferMethod, Terms};
use relume_formats::basis::{EquirectMap, cubemap};
use relume_formats::evaluate::sparse_transfer::{light, radiance};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{Environment, SparseTransfer};
use std::f64::consts::PI;

const TEXELS: usize = 6 * 64 * 64;

/// The scene of [`BALL`] with a ball of 42 vertices, for what depends on the plane's alone.
fn rough_ball() -> String {
    assert!(BALL.contains("subdivisions = 3"));
    BALL.replace("subdivisions = 3", "subdivisions = 1")
}

/// The scene of [`BALL`] with something else in the place of the ball.
fn with_instead_of_the_ball(shape: &str, transform: &str) -> String {
    let [ball, place] = [
        "shape = 'sphere'\n    subdivisions = 3",
        "transform = { translation = [0.0, 1.0, 0.0], scale = 0.4 }",
    ];
    assert!(BALL.contains(ball) && BALL.contains(place));
    BALL.replace(ball, shape).replace(place, transform)
}

/// Lights that no map has: the terms of a row are chosen by what is likely, and still have to carry these.
#[test]
fn hard_lights_stay_within_bounds() {
    let scene = scene(BALL);
    let (whole, coarse) = (bake(&scene, wanted(16, 1024)), bake(&scene, wanted(16, 100)));
    let texels = TEXELS;
    assert!(whole.under_texels(&vec![0.0; texels]).iter().all(|r| *r == 0.0), "no light, no radiance");

    // An even light and one that is a whole face have scaling functions only, which every row keeps: as exact
    // as the rounding of six values.
    let even = whole.under_texels(&vec![1.0; texels]);
    assert!(coarse.under_texels(&vec![1.0; texels]).iter().zip(&even).all(|(a, b)| (a - b).abs() < 1e-4));
    for face in 0..6 {
        let lit: Vec<f32> = (0..texels).map(|i| if i / 4096 == face { 1e5 } else { 0.0 }).collect();
        let (exact, shown) = (whole.under_texels(&lit), coarse.under_texels(&lit));
        assert!(exact.iter().zip(&shown).all(|(a, b)| (a - b).abs() < 1e-4 * 1e5), "face {face}");
    }

    // A single texel of 10⁵ straight above: all that reaches a row is the texel's transfer, and nothing may
    // come out of proportion.
    let above = cubemap::texel_of(Vec3::new(0.01, 1.0, 0.01), 64);
    let lit: Vec<f32> = (0..texels).map(|i| if i == above { 1e5 } else { 0.0 }).collect();
    let transfer = (cubemap::solid_angles(64)[above % 4096] / PI * 1e5) as f32;
    let in_shadow = |vertex: usize| baked_distance(&whole, vertex) < 0.3;
    for (baked, bound) in [(&whole, 0.25), (&coarse, 1.0)] {
        let shown = baked.under_texels(&lit);
        for vertex in baked.plane().filter(|v| !(0.3..0.5).contains(&baked_distance(baked, *v))) {
            let expected = if in_shadow(vertex) { 0.0 } else { transfer };
            assert!(
                (shown[vertex] - expected).abs() < bound * transfer,
                "vertex {vertex}: {} for {expected}",
                shown[vertex]
            );
        }
        // What is wrong at one vertex is right on average: no light is made or lost.
        let mean = |values: Vec<f32>| values.iter().sum::<f32>() / values.len() as f32;
        let outside: Vec<usize> = baked.plane().filter(|v| baked_distance(baked, *v) > 0.5).collect();
        let average = mean(outside.iter().map(|v| shown[*v]).collect());
        assert!((average / transfer - 1.0).abs() < 0.5 * bound, "{average} for {transfer}");
    }
}

/// A bundle is as exact as was asked under the maps that it was baked with, and says so. Under another one it
/// has the terms that those needed: a few for an even sky, which leave lamps neither a shadow's edge nor its amount.
/// Baked with both, it has the terms for both.
#[test]
fn a_map_that_the_bundle_was_not_baked_with_has_the_terms_that_others_needed() {
    let asked = SparseTransferMethod { settings: Settings { rays_per_texel: 16, terms: Terms::Error(0.02) } };
    let bake_under = |maps: &str| bake(&scene(&format!("{}{maps}", rough_ball())), asked);
    let (white, both) = (bake_under(""), bake_under("others = ['lamps']"));
    let exact = bake(&scene(&rough_ball()), wanted(16, 1024));
    let lamps = both.maps.iter().find(|map| map.name == "lamps").unwrap();
    let error = |baked: &Baked| baked.error_under(&exact, &lamps.map);
    assert!(white.manifest.methods[0].errors["relative_l2_worst"] <= 0.02);
    let (alien, own) = (error(&white), error(&both));
    assert!(alien > 0.1 && alien < 1.0 && own < 0.02, "{alien} and {own}");
}

/// From the middle of the plane, metres.
fn baked_distance(baked: &Baked, vertex: usize) -> f32 {
    let [x, _, z] = baked.stored.positions[vertex];
    x.hypot(z)
}

/// A map of 0.5° a texel with one of 10⁵ at an elevation and a longitude, both of texels' centres; W/(sr·m²).
fn sun(elevation_deg: f32) -> (EquirectMap, f64) {
    let (width, height) = (720, 360);
    let row = (2.0 * (90.0 - elevation_deg)) as u32;
    let mut map = EquirectMap { width, height, texels: vec![[0.0; 3]; (width * height) as usize] };
    map.texels[(row * width + width / 2) as usize] = [1e5; 3];
    let edge = |row: u32| (PI * f64::from(row) / f64::from(height)).cos();
    // What a white surface that faces up shows: L·dω·cos θ/π.
    let middle = (PI * (f64::from(row) + 0.5) / f64::from(height)).cos();
    (map, 1e5 * (2.0 * PI / f64::from(width)) * (edge(row) - edge(row + 1)) * middle / PI)
}

/// The plane's vertices that the sun reaches by a margin of 0.1 m around the ball's shadow, when the map is
/// turned.
fn sunlit(baked: &Baked, elevation_deg: f32, rotation_deg: f32) -> Vec<usize> {
    let ((sin, cos), (up, along)) =
        ((-rotation_deg.to_radians()).sin_cos(), elevation_deg.to_radians().sin_cos());
    let towards = Vec3::new(along * sin, up, -along * cos);
    let passes = |vertex: &usize| {
        (Vec3::Y - Vec3::from(baked.stored.positions[*vertex])).cross(towards).length() > 0.5
    };
    baked.plane().filter(passes).collect()
}

/// No more than `terms` terms of each row, whole blocks of them.
fn first_terms(rows: &SparseTransfer, terms: u32) -> SparseTransfer {
    let mut first = rows.clone();
    while first.meta.terms() > terms as usize {
        first.blocks.pop();
        first.meta.blocks.pop();
    }
    first
}

/// A sun of 10⁵ and half a degree, less than a texel of the light, that turns across the cube's edges. With
/// 1024 terms its flux is kept and no step makes a jump. With 100 it is kept in the mean only, to half of
/// what a sun straight above sends, and single vertices flicker: they see what the kept terms make of one
/// texel after the other.
#[test]
fn a_sun_of_1e5_crosses_the_edges_of_the_cube() {
    let scene = scene(&rough_ball());
    let baked = bake(&scene, wanted(16, 1024));
    let (whole, coarse) = (&baked.transfer, &first_terms(&baked.transfer, 100));
    // At 20° of elevation the light passes from side to side at 45°, at 40° from a side to the top where cos
    // φ = tan 40°, 33°.
    for (elevation, crossing) in [(20.0, 45.0), (40.0, 33.0)] {
        let (map, expected) = sun(elevation);
        let mut last: Option<Vec<f64>> = None;
        for step in -5..=5 {
            let rotation = crossing + 0.25 * step as f32;
            let sunlit = sunlit(&baked, elevation, rotation);
            let light = light(
                &map,
                &EnvironmentLook { map: String::new(), gain: [1.0; 3], rotation_deg: rotation },
                64,
            );
            let shown = |rows: &SparseTransfer| {
                radiance(rows, &light).iter().map(|r| f64::from(r[0]) / expected).collect::<Vec<_>>()
            };
            let mean = |shown: &[f64]| sunlit.iter().map(|v| shown[*v]).sum::<f64>() / sunlit.len() as f64;
            let place = format!("{elevation}°, turned {rotation}°");
            // As for one texel straight above: a quarter at one vertex, half as much in the mean over the
            // plane; with 100 terms half of a sun straight above in the mean, for what is cut is cut from the
            // whole row, however low the sun stands.
            let (whole, coarse) = (shown(whole), shown(coarse));
            let straight_above = f64::from(elevation.to_radians().sin());
            assert!(
                (mean(&coarse) - 1.0).abs() * straight_above < 0.5,
                "{place}, 100 terms: {}",
                mean(&coarse)
            );
            assert!((mean(&whole) - 1.0).abs() < 0.125, "{place}: {}", mean(&whole));
            assert!(sunlit.iter().all(|v| (whole[*v] - 1.0).abs() < 0.25), "{place}");
            if let Some(last) = last.replace(whole.clone()) {
                // A texel of the map, interpolated, is a tent 1° wide: a quarter of a degree takes at most
                // half of its light to the next texel of the cube, whose response differs by twice the bound
                // at most.
                let jump = sunlit.iter().map(|v| (whole[*v] - last[*v]).abs()).fold(0.0, f64::max);
                assert!(jump < 0.25, "{place}: {jump}");
            }
        }
    }
}

/// A sun beyond half floats in a map: the whole map is stored in a power of two that brings it within, so a
/// sun of 10⁵ costs nothing, and the real sun's 1.6·10⁹ beside a night sky takes from the sky what is below
/// half a step, 2⁻²⁵ of that unit: an absolute loss of 10⁻³ W/(sr·m²), which the sun outshines 10¹²-fold.
#[test]
fn maps_beyond_half_floats_keep_sun_and_sky() {
    for sun in [1e5f32, 1.6e9, 1e12] {
        let sky = [1e-3f32, 0.02, 0.2, 1.0, 30.0, 999.0];
        let texels: Vec<[f32; 3]> = sky.iter().chain([&sun]).map(|v| [*v; 3]).collect();
        let stored = Environment { name: "sun".to_owned(), map: EquirectMap { width: 7, height: 1, texels } }
            .rounded();
        let unit = (sun / f16::MAX.to_f32()).log2().ceil().exp2();
        for (is, was) in stored.map.texels.iter().zip(sky.iter().chain([&sun])) {
            let bound = (was * 2.0f32.powi(-11)).max(unit * 2.0f32.powi(-25));
            assert!((is[0] - was).abs() <= bound, "{} for {was} beside {sun}", is[0]);
        }
        assert!(sun > 1e6 || stored.map.texels[0][0] > 0.9e-3, "nothing dark is lost to a sun of 1e5");
    }
}

/// Receivers inside a blocker: their rows are all zero, which is legal, and exactly black under any light
/// with any number of terms.
#[test]
fn receivers_inside_a_blocker_have_rows_of_zeros() {
    let scene = scene(&rough_ball().replace(
        "transform = { scale = 4.0 }",
        "transform = { translation = [0.0, 1.0, 0.0], scale = 0.3 }",
    ));
    let baked = bake(&scene, wanted(4, 64));
    for texels in [vec![1e5; TEXELS], (0..TEXELS).map(|i| (i % 97) as f32).collect()] {
        let shown = baked.under_texels(&texels);
        assert!(baked.plane().all(|vertex| shown[vertex] == 0.0));
        assert!(shown[13 * 13..].iter().any(|r| *r > 0.0), "the ball's outside is lit");
    }
    assert!(baked.manifest.methods[0].errors.values().all(|error| error.is_finite()));
}

/// Thin walls and open meshes: a roof of 2 m × 2 m, half a metre above the plane, as a box a centimetre or a
/// micrometre thick, and as a sheet seen from its front or its back, leaves the middle of the plane what
/// passes its rim, by the form factor of a rectangle.
#[test]
fn a_roof_of_any_thinness_leaves_the_light_that_passes_its_rim() {
    let mut shown_before = None;
    let roofs = [
        ("shape = 'box'", "transform = { translation = [0.0, 0.505, 0.0], scale = [2.0, 0.01, 2.0] }"),
        ("shape = 'box'", "transform = { translation = [0.0, 0.5, 0.0], scale = [2.0, 1e-6, 2.0] }"),
        ("shape = 'quad'", "transform = { translation = [0.0, 0.5, 0.0], scale = 2.0 }"),
        (
            "shape = 'quad'",
            "transform = { translation = [0.0, 0.5, 0.0], rotation_deg = [180.0, 0.0, 0.0], scale = 2.0 }",
        ),
    ];
    for (shape, transform) in roofs {
        let baked = bake(
            &scene(&with_instead_of_the_ball(shape, transform).replace("segments = 12", "segments = 2")),
            wanted(16, 100),
        );
        let shown = baked.under_texels(&vec![1.0; TEXELS])[4];
        // Sides over height, both 2.
        let a = 2.0 / 5.0f64.sqrt();
        let open = 1.0 - 4.0 / PI * a * a.atan();
        // The rim runs through 256 texels of at most 1e-4 of the light each, of which one in sixteen rays may
        // err towards the same side: an eighth of each.
        assert!(
            (f64::from(shown) - open).abs() < 256.0 * 1e-4 / 8.0,
            "{shape} {transform}: {shown} for {open}"
        );
        // All are seen alike from below.
        assert!((shown_before.replace(shown).unwrap_or(shown) - shown).abs() < 1e-3, "{shape} {transform}");
    }
}

/// A mesh coarser than the shadow on it: light is exact at vertices and linear between, which for a ball's
/// soft shadow errs by h²/8 of its curvature; with half the distance of vertices a quarter is left.
#[test]
fn shadows_are_as_fine_as_the_mesh() {
    let worst = |segments: usize| {
        let text = BALL.replace("segments = 12", &format!("segments = {segments}"));
        let baked = bake(&scene(&text), wanted(16, 200));
        let shown = baked.under_texels(&vec![1.0; TEXELS]);
        let off = |vertex: usize| {
            let [a, b] = [vertex, vertex + 1].map(|v| baked.stored.positions[v]);
            let (x, z) = (f64::from(a[0] + b[0]) / 2.0, f64::from(a[2] + b[2]) / 2.0);
            let hidden = 0.16 / (x * x + z * z + 1.0).powf(1.5);
            (f64::from(shown[vertex] + shown[vertex + 1]) / 2.0 - (1.0 - hidden)).abs()
        };
        (0..(segments + 1) * segments).filter(|v| v % (segments + 1) < segments).map(off).fold(0.0, f64::max)
    };
    for segments in [12, 24] {
        let h = 4.0 / segments as f64;
        let worst = worst(segments);
        println!("{segments} segments: {worst:.5}");
        // |f''| ≤ 3 · 0.16, above the ball's middle; vertices themselves are off by 1.2e-3 at most (relighting.rs).
        assert!(worst < h * h / 8.0 * 0.48 + 1.2e-3, "{segments} segments: {worst}");
        assert!(segments > 12 || worst > 0.004, "the loss is real: {worst}");
    }
}

/// A scene a thousand times larger or smaller: the same rows.
#[test]
fn a_thousand_times_larger_or_smaller() {
    let base = scene(&format!("{} file = 'lamps'\n", rough_ball()));
    let shown = |scale: f32| {
        let baked = bake(&scaled(&base, scale), wanted(4, 200));
        baked.under(&baked.maps[0].map, 20.0)
    };
    let metre = shown(1.0);
    for scale in [1e-3, 1e3] {
        // Coordinates round differently: a ray here and there passes the other side of an edge.
        let error = relative_l2(&shown(scale), &metre);
        assert!(error < 2e-3, "scale {scale}: {error}");
    }
}

/// Highlights and materials that vary are left out with a sentence each; they are no error.
#[test]
fn what_is_left_out_is_said() {
    let text = BALL
        .replace("kd = [0.7, 0.7, 0.1]", "kd = [0.2, 0.2, 0.1]\n    ks = [0.5, 0.5, 0.5]")
        .replace("view = true", "view = true\n    materials = ['plane']");
    let said = wanted(1, 6).leaves_out(&scene(&text));
    let expected = [
        "material `ball`: sparse-transfer shows its diffuse part only",
        "[vary] names material `plane`, but sparse-transfer keeps materials as the scene has them",
    ];
    assert_eq!(said, expected);
    let metal = "brdf = 'ggx'\n    base_color = [0.9, 0.8, 0.7]\n    metallic = 1.0\n    roughness = 0.4";
    let text = BALL.replace("brdf = 'blinn-phong'\n    kd = [0.7, 0.7, 0.1]", metal);
    let said = wanted(1, 6).leaves_out(&scene(&text));
    assert!(
        said.len() == 1
            && said[0].contains("`ball`")
            && said[0].ends_with("it will be black; set metallic = 0"),
        "{said:?}"
    );
}

/// Surfaces seen from behind are black: the player, looking up from under the plane.
#[test]
fn surfaces_seen_from_behind_are_black() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_scene(folder.path(), &format!("{} file = 'lamps'\n", rough_ball()));
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(
        file("below.toml"),
        "camera = { position = [0.0, -0.5, 0.0], target = [0.0, 0.0, 0.01] }\n",
    )
    .unwrap();
    let bundle = file("bundle");
    expect_exit(
        "bake",
        &["run", path.to_str().unwrap(), "-o", &bundle, "--terms", "32", "--spp", "1", "--progress", "none"],
        0,
    );
    expect_exit(
        "player",
        &[&bundle, "--headless", "--state", &file("below.toml"), "--exr", &file("frame.exr")],
        0,
    );
    let image = relume_bake::exr_file::read_exr(&folder.path().join("frame.exr")).unwrap();
    assert!(["R", "G", "B"].iter().all(|c| image.channel(c).unwrap().iter().all(|v| *v == 0.0)));
}
