//! The kinds of methods that relight: what is written comes back, what is broken is refused, and what the
//! numbers mean.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::refusal;
use crate::support::relighting::{environment, rows, textures};
use half::f16;
use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::basis::{EquirectMap, cubemap, haar};
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::{light, radiance};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::sparse_transfer::Steps;
use relume_formats::kinds::{Environment, SparseTransfer};
use std::fmt::Debug;

const BLOCKS: [(u32, bool); 3] = [(1, true), (3, true), (2, false)];

fn assert_round_trip<T: Stored + PartialEq + Debug>(value: &T) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relume");
    let bytes = value.write_file(&path).unwrap();
    let read = T::read_file(&path).unwrap();
    assert_eq!(&read, value);
    assert_eq!(read.write_file(&path).unwrap(), bytes, "reading and writing again changes nothing");
    assert_eq!(RawFile::parse(&bytes).bytes(), bytes);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(32) })]

    #[test]
    fn environments_come_back(seed: u64, bright: bool) {
        let environment = environment(seed, bright);
        assert_round_trip(&environment);
        assert_eq!(environment.rounded(), environment, "halves are halves already");
    }

    #[test]
    fn textures_come_back(seed: u64) {
        assert_round_trip(&textures(seed));
    }

    #[test]
    fn rows_come_back(seed: u64, vertices in 1usize..9, log in 0u32..=6, rgb: bool) {
        assert_round_trip(&rows(seed, vertices, 1 << log, rgb, &BLOCKS));
    }
}

/// A file with one section changed beyond what the types allow, or sections moved, is refused with
/// `expected`.
fn assert_forged_refused<T: Stored>(value: &T, change: impl Fn(&mut Vec<RawSection>), expected: &str) {
    let file = RawFile::parse(&value.to_bytes_unchecked(Place::file("a.relume")).unwrap());
    let mut sections = file.sections.clone();
    change(&mut sections);
    let message = refusal(T::KIND, &RawFile::new(file.kind, sections).bytes()).to_string();
    assert!(message.contains(expected), "`{expected}` is not in `{message}`");
}

fn assert_refused<T: Stored>(value: &T, expected: &str) {
    assert_forged_refused(value, |_| (), expected);
}

#[test]
fn environments_that_are_none_are_refused() {
    let sound = environment(5, false);
    let with = |texel: f32| {
        let mut broken = sound.clone();
        broken.map.texels[0][1] = texel;
        broken
    };
    assert_refused(&with(-1.0), "a radiance is outside 0..1e12");
    assert_refused(&with(f32::NAN), "a radiance is outside 0..1e12");
    assert_refused(&with(2e12), "a radiance is outside 0..1e12");
    assert_refused(
        &Environment { name: "a\nb".to_owned(), ..sound.clone() },
        "the name `a\\nb` of the map has control characters",
    );
    let reshaped = |shape: [u64; 3]| move |sections: &mut Vec<RawSection>| sections[1].shape = shape.to_vec();
    let texels = sound.map.texels.len() as u64;
    assert_forged_refused(&sound, reshaped([1, 1, texels * 3]), "has shape");
    let unitless = |sections: &mut Vec<RawSection>| {
        let length = sections[0].raw().len();
        let unit_zeroed = [&sections[0].raw()[..length - 4], &[0; 4]].concat();
        sections[0].set_raw(&unit_zeroed);
    };
    assert_forged_refused(&sound, unitless, "section `meta`: unit 0 is no power of two");
    assert_forged_refused(&sound, |sections| drop(sections.pop()), "section `texels` is missing");
}

#[test]
fn textures_that_are_none_are_refused() {
    let sound = (0..).map(textures).find(|t| t.textures.len() > 1 && !t.uvs.is_empty()).unwrap();
    let mut twice = sound.clone();
    twice.textures[1].material = twice.textures[0].material;
    assert_refused(&twice, "two textures are of one material");
    let mut cutoff = sound.clone();
    cutoff.textures[0].alpha_cutoff = Some(2.0);
    assert_refused(&cutoff, "alpha cutoff is outside 0..1");
    let mut uvs = sound.clone();
    uvs.uvs[0][1] = f32::INFINITY;
    assert_refused(&uvs, "section `uvs`: element 1 is not a finite number");
    let mut many = sound.clone();
    many.textures = (0..17)
        .map(|material| relume_formats::kinds::textures::MaterialTexture {
            material,
            ..sound.textures[0].clone()
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let refused = many.write_file(&folder.path().join("a.relume")).unwrap_err().to_string();
    assert!(refused.contains("has at most"), "{refused}");
}

#[test]
fn rows_that_are_none_are_refused() {
    let sound = rows(7, 3, 4, false, &BLOCKS);
    let changed = |change: &dyn Fn(&mut SparseTransfer)| {
        let mut rows = sound.clone();
        change(&mut rows);
        rows
    };
    type Case<'a> = (&'a dyn Fn(&mut SparseTransfer), &'a str);
    let cases: [Case<'_>; 11] = [
        (&|r| r.meta.face_size = 3, "section `meta`: a light of 3 texels"),
        (&|r| r.meta.face_size = 128, "a light of 128 texels"),
        (&|r| r.meta.bounces = 3, "and 3 bounces are out of range"),
        (&|r| r.meta.unit = 0.0, "unit 0 is not above 0"),
        (&|r| r.meta.face_size = 1, "a row has 1 to 6"),
        (
            &|r| r.blocks[1].indices[2] = 96,
            "section `index/0001`: an index is beyond the light's coefficients",
        ),
        (&|r| r.blocks[2].scales[1] = f16::NAN, "section `scale/0002`: element 1 is not a finite number"),
        (&|r| r.blocks[2].scales[1] = -f16::ONE, "section `scale/0002`: the values of vertex 1 reach -0.06"),
        (&|r| r.meta.unit = 1e38, "section `scale/0000`: the values of vertex 0 reach"),
        (&|r| r.blocks[0].scales[2] = f16::MAX, "section `scale/0000`: the values of vertex 2 reach 1048"),
        (&|r| r.meta.blocks[2].wide = true, "section `value/0002`: holds i8, expected i16"),
    ];
    // With face size 1 there are 6 coefficients, and indices up to 95: the count of terms, 6, is legal, so
    // one more block makes it illegal.
    for (number, (change, expected)) in cases.into_iter().enumerate() {
        let mut broken = changed(change);
        if number == 4 {
            broken.meta.blocks[0].terms = 2;
        }
        match broken.to_bytes_unchecked(Place::file("a.relume")) {
            Ok(bytes) => {
                let message = refusal(SparseTransfer::KIND, &bytes).to_string();
                assert!(message.contains(expected), "`{expected}` is not in `{message}`");
            }
            Err(error) => assert_eq!(number, 4, "{error}"),
        }
    }
    assert_forged_refused(&sound, |sections| sections.swap(1, 2), "expected section `index/0000`");
    assert_forged_refused(&sound, |sections| drop(sections.pop()), "section `value/0002` is missing");
    let more = |sections: &mut Vec<RawSection>| {
        sections.push(RawSection { name: "index/0003".to_owned(), ..sections[1].clone() })
    };
    assert_forged_refused(&sound, more, "unexpected section");
}

fn look(gain: [f32; 3], rotation_deg: f32) -> EnvironmentLook {
    EnvironmentLook { map: "a".to_owned(), gain, rotation_deg }
}

/// One row with every coefficient of a known transfer function gives the integral of light × transfer: cosine
/// over π against a map that is a polynomial of the direction, whose irradiance is known.
#[test]
fn a_whole_row_gives_the_irradiance() {
    let (n, width, height) = (16, 128u32, 64u32);
    let direction = |x: u32, y: u32| {
        let (azimuth, polar) = (
            ((x as f64 + 0.5) / f64::from(width) - 0.5) * std::f64::consts::TAU,
            (y as f64 + 0.5) / f64::from(height) * std::f64::consts::PI,
        );
        [polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos()]
    };
    // 1, 1 + y, and 1 + x: the mean over the hemisphere about +Y, weighted with the cosine, is 1, 1 + 2/3 and
    // 1.
    let texel = |i: u32| {
        let [x, y, _] = direction(i % width, i / width);
        [1.0, 1.0 + y as f32, 1.0 + x as f32]
    };
    let map = EquirectMap { width, height, texels: (0..width * height).map(texel).collect() };
    let solid_angles = cubemap::solid_angles(n);
    let mut row: Vec<f32> = (0..6 * n * n)
        .map(|i| {
            let centre = cubemap::direction(i / (n * n), n, (i % n) as f64 + 0.5, (i / n % n) as f64 + 0.5);
            (centre.y.max(0.0) * solid_angles[i % (n * n)] / std::f64::consts::PI) as f32
        })
        .collect();
    haar::forward_cube(&mut row, n);
    let mut bundle = rows(1, 1, n as u32, false, &[(6 * (n * n) as u32, true)]);
    let largest = row.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    bundle.meta.unit = largest / 32_767.0;
    bundle.blocks[0].scales = vec![f16::ONE];
    bundle.blocks[0].indices = (0..6 * (n * n) as u16).collect();
    bundle.blocks[0].steps = Steps::Wide(row.iter().map(|v| (v / bundle.meta.unit).round() as i16).collect());
    for (gain, rotation_deg) in [([1.0; 3], 0.0), ([0.5, 2.0, 1e5], 77.0), ([0.0; 3], -90.0)] {
        let shown = radiance(&bundle, &light(&map, &look(gain, rotation_deg), n))[0];
        for (channel, mean) in [1.0, 5.0 / 3.0, 1.0].into_iter().enumerate() {
            // Texels of 5.6° misjudge the cosine by some 10⁻³ of it; rounding to 16 bits is below that.
            assert!(
                (shown[channel] - gain[channel] * mean).abs() <= 2e-3 * gain[channel] * mean,
                "{shown:?} at {rotation_deg}° and {gain:?}"
            );
        }
    }
}

#[test]
fn gains_and_turns_are_those_of_the_state() {
    let place = Place::file("s.toml");
    let state = |text: &str| {
        relume_formats::state::parse_toml::<relume_formats::state::State>(text, &place)
            .unwrap()
            .environment
            .unwrap()
    };
    let base = look([1.0; 3], 30.0);
    let changed = base.with(&state("environment = { map = 'b', gain = [2, 0, 0.5] }"), &place).unwrap();
    assert_eq!((changed.map.as_str(), changed.gain, changed.rotation_deg), ("b", [2.0, 0.0, 0.5], 30.0));
    for (text, expected) in [
        ("environment.gain = [-1.0, 1.0, 1.0]", "gain [-1.0, 1.0, 1.0] is outside 0.."),
        ("environment.gain = [nan, 1.0, 1.0]", "is outside 0.."),
        ("environment.gain = [1e12, 1.0, 1.0]", "is outside 0.."),
        ("environment.rotation_deg = inf", "rotation_deg must be a finite number"),
    ] {
        let message = base.with(&state(text), &place).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

/// Light is linear in the map, so a reduced map must send what the whole one sends.
#[test]
fn a_reduced_map_sends_as_much() {
    let (width, height) = (64, 32);
    let texels = (0..width * height)
        .map(|i| [((i * 7919) % 1009) as f32, if i == 700 { 1e5 } else { 0.0 }, 1.0])
        .collect();
    let map = EquirectMap { width, height, texels };
    let reduced = map.reduced(16);
    assert_eq!((reduced.width, reduced.height, map.reduced(64) == map), (16, 8, true));
    let flux = |map: &EquirectMap, channel: usize| -> f64 {
        let cos = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(map.height)).cos();
        let texel = |(i, t): (usize, &[f32; 3])| {
            f64::from(t[channel]) * (cos(i as u32 / map.width) - cos(i as u32 / map.width + 1))
                / f64::from(map.width)
        };
        map.texels.iter().enumerate().map(texel).sum()
    };
    for channel in 0..3 {
        assert!((flux(&reduced, channel) / flux(&map, channel) - 1.0).abs() < 1e-5, "channel {channel}");
    }
}

#[test]
fn hdr_values_survive_storing() {
    let map = EquirectMap { width: 2, height: 1, texels: vec![[1e5, 0.0, 3e-3], [1.0, 2.0, 1e9]] };
    let stored = Environment { name: "a".to_owned(), map: map.clone() }.rounded();
    for (stored, given) in stored.map.texels.as_flattened().iter().zip(map.texels.as_flattened()) {
        // 2⁻¹¹ of the value, and 2⁻²⁵ of 2¹⁴ for what is a billionth of the brightest.
        assert!((stored - given).abs() <= given / 2048.0 + 2.0f32.powi(-11), "{stored} for {given}");
    }
}
