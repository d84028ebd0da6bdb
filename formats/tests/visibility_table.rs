//! The table of one sphere's shadows against brute force, bit for bit, and what its look-up takes a sphere
//! for.

use crate::support::samples::Random;
use glam::{DVec3, Vec3};
use relume_formats::basis::cubemap::{self, texel_of};
use relume_formats::basis::two_level::{BYTES, SIDE};
use relume_formats::kinds::VisibilityTable;
use relume_formats::kinds::visibility_table::{
    DIRECTIONS, RADII, STORED_DIRECTIONS, radius_of, stored_directions,
};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

static TABLE: LazyLock<VisibilityTable> = LazyLock::new(VisibilityTable::bake);

/// Unit directions of the centres.
static CENTRES: LazyLock<Vec<DVec3>> = LazyLock::new(|| {
    let centre = |i: usize| {
        cubemap::direction(i / (SIDE * SIDE), SIDE, (i % SIDE) as f64 + 0.5, (i / SIDE % SIDE) as f64 + 0.5)
    };
    (0..DIRECTIONS).map(centre).collect()
});

/// The rule, texel by texel, with the unit vectors that everybody else uses.
fn by_brute_force(direction: DVec3, r: f64) -> [u8; BYTES] {
    let mut bits = [0; BYTES];
    for (texel, centre) in CENTRES.iter().enumerate() {
        let blocked = centre.dot(direction) >= (1.0 - r * r).sqrt();
        bits[texel / 8] |= u8::from(blocked) << (texel % 8);
    }
    bits
}

fn assert_right(direction: usize, radius: usize) {
    let expected = by_brute_force(CENTRES[direction], radius_of(radius));
    assert!(*TABLE.bitmap(direction, radius) == expected, "direction {direction}, radius {radius}");
}

#[test]
fn bitmaps_are_brute_force_bit_for_bit() {
    // What is stored, all radii.
    stored_directions()
        .step_by(9)
        .for_each(|direction| (0..RADII).for_each(|radius| assert_right(direction, radius)));
    // What the symmetries make of it: every direction once, at random radii.
    let random = &mut Random(1);
    (0..DIRECTIONS).for_each(|direction| assert_right(direction, random.below(RADII)));
}

/// Brute force compares rounded cosines, the table exact ones. They must agree if no cosine is so near to an
/// edge that rounding could take it across; each of the few operations on numbers of at most 1 rounds by at
/// most 10⁻¹⁶.
#[test]
fn no_centre_is_on_the_edge_of_a_cap() {
    let edges: Vec<f64> = (0..RADII).map(|radius| (1.0 - radius_of(radius).powi(2)).sqrt()).collect();
    let nearest = |cosine: f64| edges.iter().map(|edge| (cosine - edge).abs()).fold(1.0, f64::min);
    let cosines = stored_directions().flat_map(|v| CENTRES.iter().map(move |d| d.dot(CENTRES[v])));
    assert!(cosines.map(nearest).fold(1.0, f64::min) > 1e-11);
}

#[test]
fn stored_directions_stand_for_all() {
    let key = |texel: usize| {
        let mut sorted = CENTRES[texel].abs().to_array().map(|c| (c * 1e9).round() as i64);
        sorted.sort_unstable();
        sorted
    };
    let stored: BTreeSet<_> = stored_directions().map(key).collect();
    assert_eq!(stored.len(), STORED_DIRECTIONS, "no two of them are symmetric");
    assert_eq!(stored, (0..DIRECTIONS).map(key).collect());
}

#[test]
fn wider_caps_block_more() {
    for direction in (0..DIRECTIONS).step_by(37) {
        let at = |radius| TABLE.bitmap(direction, radius);
        assert!(
            at(0)[direction / 8] >> (direction % 8) & 1 == 1,
            "the narrowest blocks the direction itself"
        );
        (1..RADII).for_each(|radius| {
            assert!(at(radius - 1).iter().zip(at(radius)).all(|(narrow, wide)| narrow & !wide == 0))
        });
    }
}

#[test]
fn radii_are_uniform_in_half_angle() {
    for radius in 0..RADII {
        let degrees = radius_of(radius).asin().to_degrees();
        assert!((degrees - 90.0 * (radius as f64 + 0.5) / 32.0).abs() < 1e-10, "{degrees}");
    }
}

#[test]
fn look_up_takes_the_nearest_half_angle() {
    let direction = Vec3::new(3.0, -1.0, 0.7);
    let texel = texel_of(direction, SIDE);
    let radius_at = |steps: f64| (steps / 32.0 * FRAC_PI_2).sin() as f32;
    for radius in 0..RADII {
        let first = if radius == 0 { 0.25 } else { radius as f64 };
        for steps in [first + 1e-3, radius as f64 + 0.5, radius as f64 + 0.999] {
            let found = TABLE.look_up(direction, radius_at(steps)).unwrap();
            assert!(std::ptr::eq(found, TABLE.bitmap(texel, radius)), "{steps}");
        }
    }
    for r in [radius_at(0.249), 1e-30, 0.0, -0.5, f32::NAN, f32::NEG_INFINITY] {
        assert!(TABLE.look_up(direction, r).is_none(), "{r}");
    }
    for r in [1.0, 1.5, f32::INFINITY] {
        assert!(std::ptr::eq(TABLE.look_up(direction, r).unwrap(), TABLE.bitmap(texel, RADII - 1)), "{r}");
    }
}

#[test]
fn look_up_takes_the_nearest_direction() {
    let random = &mut Random(2);
    for _ in 0..200 {
        let direction = Vec3::new(random.signed(), random.signed(), random.signed()) * 100.0;
        let found = TABLE.look_up(direction, 0.5).unwrap();
        assert!(std::ptr::eq(found, TABLE.bitmap(texel_of(direction, SIDE), 10)));
    }
    // asin ½ is 30°, 10.7 steps of 2.8°.
    let found = TABLE.look_up(Vec3::ZERO, 0.5).unwrap();
    assert!(found.iter().any(|b| *b != 0), "a sphere at the receiver itself has some direction");
}
