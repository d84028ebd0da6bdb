//! Directions, solid angles and resampling of cube maps against the specification of the graphics interfaces,
//! closed forms and quadrature.

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use relume_formats::basis::EquirectMap;
use relume_formats::basis::cubemap::{
    FACES, direction, from_equirect, solid_angles, subsamples, texel_of, to_equirect,
};
use std::f64::consts::{PI, TAU};

/// Face and texture coordinates in 0..=1 by the table of the OpenGL 4.6 specification (8.19), which WebGPU
/// shares.
fn by_specification(d: DVec3) -> (usize, f64, f64) {
    let DVec3 { x, y, z } = d;
    let major = x.abs().max(y.abs()).max(z.abs());
    let (face, sc, tc) = match () {
        () if x == major => (0, -z, -y),
        () if -x == major => (1, z, -y),
        () if y == major => (2, x, z),
        () if -y == major => (3, x, -z),
        () if z == major => (4, x, -y),
        () => (5, -x, -y),
    };
    (face, 0.5 * (sc / major + 1.0), 0.5 * (tc / major + 1.0))
}

#[test]
fn every_texel_looks_where_the_specification_says() {
    for n in [1, 2, 3, 8, 64] {
        for i in 0..FACES * n * n {
            let (face, y, x) = (i / (n * n), i / n % n, i % n);
            let centre = direction(face, n, x as f64 + 0.5, y as f64 + 0.5);
            let (face_there, u, v) = by_specification(centre);
            assert_eq!(face_there, face);
            assert!(
                (u * n as f64 - x as f64 - 0.5).abs() < 1e-12 * n as f64
                    && (v * n as f64 - y as f64 - 0.5).abs() < 1e-12 * n as f64
            );
            assert!((centre.length() - 1.0).abs() < 1e-15);
            assert_eq!(texel_of(centre.as_vec3(), n), i, "texel {i} of n = {n}");
            assert_eq!(texel_of(centre.as_vec3() * 37.5, n), i, "length does not matter");
        }
    }
    assert_eq!(direction(4, 8, 4.0, 4.0), DVec3::Z);
    assert_eq!(direction(2, 8, 4.0, 4.0), DVec3::Y);
}

#[test]
fn borders_belong_to_one_texel() {
    let n = 4;
    // Corners: X before Y before Z; the last column and row at the far border.
    assert_eq!(texel_of(Vec3::new(1.0, 1.0, 1.0), n), 0);
    assert_eq!(texel_of(Vec3::new(-1.0, -1.0, 1.0), n), 31);
    assert_eq!(texel_of(Vec3::new(0.0, 1.0, 1.0), n), 2 * 16 + 3 * 4 + 2);
    // The middle of a face is a border of four texels: right and below.
    assert_eq!(texel_of(Vec3::Z, n), 4 * 16 + 2 * 4 + 2);
    for odd in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(-0.0)] {
        assert!(texel_of(odd, n) < 96);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn texels_contain_their_directions(d in prop::array::uniform3(-1.0f32..1.0), log in 0u32..9) {
        let n = 1usize << log;
        let d = Vec3::from(d);
        prop_assume!(d.length() > 1e-3);
        let at = texel_of(d, n);
        let (face, u, v) = by_specification(d.as_dvec3());
        prop_assert_eq!(at / (n * n), face);
        // Single precision moves a direction by less than 1e-6 of a face.
        let (x, y) = ((at % n) as f64, (at / n % n) as f64);
        for (place, texel) in [(u, x), (v, y)] {
            prop_assert!((place - (texel + 0.5) / n as f64).abs() <= 0.5 / n as f64 + 1e-6);
        }
    }
}

#[test]
fn solid_angles_are_exact() {
    for n in [1, 2, 3, 8, 64, 256] {
        let face = solid_angles(n);
        assert_eq!(face.len(), n * n);
        let sum = 6.0 * face.iter().sum::<f64>();
        assert!((sum - 4.0 * PI).abs() < 1e-12, "n = {n}: {sum}");
    }
    assert!((solid_angles(1)[0] - TAU / 3.0).abs() < 1e-15);
    // Against quadrature of (1 + s² + t²)^(-3/2): the midpoint rule on 32 × 32 points of a texel of width h
    // errs by less than (h/32)² of it.
    let n = 8;
    for (i, angle) in solid_angles(n).into_iter().enumerate() {
        let place = |texel: usize, k: usize| 2.0 * (texel as f64 + (k as f64 + 0.5) / 32.0) / n as f64 - 1.0;
        let at = |k: usize| (1.0 + place(i % n, k % 32).powi(2) + place(i / n, k / 32).powi(2)).powf(-1.5);
        let quadrature = (0..32 * 32).map(at).sum::<f64>() * (2.0 / n as f64 / 32.0).powi(2);
        assert!((angle / quadrature - 1.0).abs() < 6.2e-5, "texel {i}: {angle} against {quadrature}");
    }
}

fn map_of(width: u32, height: u32, radiance: impl Fn(DVec3) -> [f32; 3]) -> EquirectMap {
    let texel = |i: u32| {
        let (u, v) = (
            (f64::from(i % width) + 0.5) / f64::from(width),
            (f64::from(i / width) + 0.5) / f64::from(height),
        );
        radiance(in_map(u, v))
    };
    EquirectMap { width, height, texels: (0..width * height).map(texel).collect() }
}

/// The direction that the unturned map shows at (u, v).
fn in_map(u: f64, v: f64) -> DVec3 {
    let (phi, theta) = (TAU * (u - 0.5), PI * v);
    DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos())
}

#[test]
fn look_ups_are_dense_enough() {
    assert_eq!(
        [subsamples(1, 64), subsamples(512, 64), subsamples(513, 64), subsamples(8192, 16)],
        [4, 4, 8, 256]
    );
    // Any single lit texel below 45° of latitude is seen, whichever way the map is turned.
    let (width, height, n) = (64u32, 32u32, 4);
    for i in width * height / 4..3 * width * height / 4 {
        let mut map = EquirectMap { width, height, texels: vec![[0.0; 3]; (width * height) as usize] };
        map.texels[i as usize] = [1.0; 3];
        assert!(from_equirect(&map, (i % 7) as f32 * 3.1, n).iter().any(|t| t[0] > 0.0), "texel {i}");
    }
}

#[test]
fn an_even_map_gives_an_even_cube_and_back() {
    let radiance = [0.1, 1e5, 3e-3];
    let cube = from_equirect(&map_of(64, 32, |_| radiance), 12.0, 8);
    let back = to_equirect(&cube, 8, 40, 20);
    assert_eq!((cube.len(), back.texels.len()), (FACES * 64, 800));
    for texel in cube.iter().chain(&back.texels) {
        // 16 rounded products and sums of one sign, and a division.
        texel.iter().zip(radiance).for_each(|(ours, truth)| {
            assert!((ours / truth - 1.0).abs() < 34.0 * f32::EPSILON, "{ours} of {truth}")
        });
    }
}

/// Radiance that differs in every direction and changes by at most 1 per radian.
fn smooth(d: DVec3) -> [f32; 3] {
    [1.0 + d.x, 2.0 + d.y, 1.5 + d.z].map(|x| x as f32)
}

#[test]
fn smooth_light_comes_through_both_ways() {
    let (n, width, height) = (16, 512, 256);
    let cube = from_equirect(&map_of(width, height, smooth), 0.0, n);
    let means: Vec<[f32; 3]> = (0..FACES * n * n)
        .map(|i| smooth(direction(i / (n * n), n, (i % n) as f64 + 0.5, (i / n % n) as f64 + 0.5)))
        .collect();
    // A look-up is off by half a texel of the map at most, 0.0062 rad × √2; the mean over a texel differs
    // from its centre by its curvature, (2/16)²/12.
    let farthest = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
    };
    let error = farthest(&cube, &means);
    assert!(error < 0.0088 + 0.0013, "{error}");
    // And back: half the diagonal of a texel of the cube, 0.125/√2 rad.
    let error = farthest(&to_equirect(&cube, n, width, height).texels, &map_of(width, height, smooth).texels);
    assert!(error < 0.0884 + 0.0013 + 0.0088, "{error}");
}

#[test]
fn flux_is_kept() {
    // By the closed form: ∫ (1 + d.x) dω = 4π, and so on.
    let n = 16;
    let cube = from_equirect(&map_of(512, 256, smooth), 77.0, n);
    let solid = solid_angles(n);
    for (channel, constant) in [(0, 1.0), (1, 2.0), (2, 1.5)] {
        let flux: f64 =
            cube.iter().enumerate().map(|(i, t)| f64::from(t[channel]) * solid[i % (n * n)]).sum();
        assert!((flux / (4.0 * PI * constant) - 1.0).abs() < 1e-4, "channel {channel}: {flux}");
    }
}

#[test]
fn rotation_turns_counter_clockwise_seen_from_above() {
    // The middle of the map looks to -Z; turned by 90° it looks to -X, by 180° to +Z.
    let towards = |d: Vec3| move |e: DVec3| [if e.dot(d.as_dvec3()) > 0.9 { 1.0 } else { 0.0 }; 3];
    let lit = |degrees: f32, d: Vec3| {
        from_equirect(&map_of(128, 64, towards(Vec3::NEG_Z)), degrees, 8)[texel_of(d, 8)][0]
    };
    for (degrees, d) in
        [(0.0, Vec3::NEG_Z), (90.0, Vec3::NEG_X), (180.0, Vec3::Z), (270.0, Vec3::X), (-90.0, Vec3::X)]
    {
        assert!(lit(degrees, d) > 0.99, "{degrees}° towards {d}");
        assert!(lit(degrees, -d) < 0.01, "{degrees}° towards {}", -d);
    }
    // Turning by whole columns moves the columns: the map's left shows what stood to the right of it.
    let map = map_of(128, 64, |d| {
        [(5.0 * d.x).sin().abs() as f32, (7.0 * d.y + d.z).cos().abs() as f32, (9.0 * d.z).sin().abs() as f32]
    });
    let mut moved = map.clone();
    moved.texels.chunks_exact_mut(128).for_each(|row| row.rotate_left(10));
    let (turned, expected) = (from_equirect(&map, 360.0 * 10.0 / 128.0, 8), from_equirect(&moved, 0.0, 8));
    let differing = turned
        .iter()
        .zip(&expected)
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-6))
        .count();
    // Directions on the border of two columns, the diagonals of ±Y, may round either way.
    assert!(differing <= 2 * 2 * 8, "{differing} texels differ");
}
