//! BRDF tensors: what they mean, written out, and files that are none.

use crate::support::raw_file::RawSection;
use crate::support::refusing::{assert_forged_refused, assert_refused};
use crate::support::tensors::{CONES_DEG, tensor};
use glam::Vec3;
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::angles::{self, NODES};
use relume_formats::kinds::brdf_tensor::{Cone, MAX_PROFILES, Samples, strength};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx, Model};

const MODELS: [Model; 3] = [Model::BlinnPhong, Model::Ggx, Model::CookTorrance];

fn direction(theta: f64, azimuth: f64) -> Vec3 {
    let (sin, cos) = theta.sin_cos();
    Vec3::new((sin * azimuth.cos()) as f32, (sin * azimuth.sin()) as f32, cos as f32)
}

/// Σ D U U U cos m(φ_i − φ_o) at nodes, in double precision, of two samples mixed; and the same through the columns
/// of a vertex.
#[test]
fn a_residual_is_the_sum_over_all_columns() {
    for (seed, model) in (0..).zip(MODELS) {
        let [a, b, c] = [2, 3, 4];
        let tensor = tensor(seed, model, [a, b, c]);
        let mixture = [(0, 0.25), (2, 0.75)];
        let (core, weights) = (tensor.core_of(&mixture), tensor.weights_of(&mixture));
        assert_eq!((core.len(), weights.len(), tensor.columns()), (b * c, NODES * c, 1 + 6));
        for (o, i, from, to) in [(0, 0, 0.3, 2.0), (3, 30, 0.0, -1.5), (17, 7, 3.0, 3.1), (30, 12, -2.0, 0.4)]
        {
            let (mut sum, mut magnitude) = (0.0, 0.0);
            for (i0, j, k) in (0..a).flat_map(|i| (0..b).flat_map(move |j| (0..c).map(move |k| (i, j, k)))) {
                for (sample, share) in mixture {
                    let factors = [
                        share,
                        tensor.core[(i0 * b + j) * c + k],
                        tensor.materials[sample * a + i0],
                        tensor.outgoing[o * b + j],
                        tensor.incoming[i * c + k],
                    ];
                    let term: f64 = factors.map(f64::from).iter().product();
                    sum += term * (f64::from(tensor.orders[k]) * (to - from)).cos();
                    magnitude += term.abs();
                }
            }
            let [outgoing, incoming] =
                [(o, from), (i, to)].map(|(node, azimuth)| direction(angles::theta(node), azimuth));
            // At the poles azimuths are lost, so that only what is not at them can be compared.
            let orders_matter = o > 0 && i > 0;
            let value = tensor.residual(&weights, outgoing, incoming);
            let (columns, through) =
                (tensor.column_values(incoming), tensor.column_weights(&weights, outgoing));
            assert_eq!(columns[0], std::f32::consts::FRAC_1_PI);
            let by_columns: f32 = columns[1..].iter().zip(&through).map(|(u, w)| u * w).sum();
            // Some ten roundings a term, nodes are met to theirs, and azimuths to theirs times an order of 2.
            assert!((by_columns - value).abs() < 2e-5 * magnitude as f32, "{by_columns} is not {value}");
            if orders_matter {
                assert!((f64::from(value) - sum).abs() < 2e-5 * magnitude, "{value} is not {sum}");
            }
        }
    }
}

/// A residual does not change when both directions are turned about the normal together.
#[test]
fn turning_both_directions_changes_nothing() {
    let tensor = tensor(7, Model::Ggx, [2, 5, 6]);
    let weights = tensor.weights_of(&[(1, 1.0)]);
    let at = |turn: f64| tensor.residual(&weights, direction(0.7, 0.2 + turn), direction(1.1, 1.4 + turn));
    let scale: f32 = weights.iter().map(|w| w.abs()).fold(0.0, f32::max);
    for turn in [0.5, 2.0, 3.0, 4.4] {
        // Six profiles, each of at most the scale; azimuths are off by roundings of π times an order of 2.
        assert!((at(turn) - at(0.0)).abs() < 2e-5 * scale, "{turn}");
    }
}

/// Between nodes tables are linear in the angle, and those of two samples mix.
#[test]
fn shares_are_linear_between_angles_and_samples() {
    let tensor = tensor(5, Model::BlinnPhong, [1, 1, 1]);
    let cones = CONES_DEG.len();
    let stored = |sample: usize, node: usize| &tensor.shares[(sample * NODES + node) * cones..][..cones];
    let table = tensor.shares_of(&[(0, 0.5), (2, 0.5)]);
    for (node, part) in [(0, 0.0), (2, 0.5), (11, 0.25), (29, 0.5), (29, 1.0)] {
        let theta = angles::theta(node) + part * (angles::theta(1) - angles::theta(0));
        let found = BrdfTensor::seen_from(&table, direction(theta, 1.0));
        for (k, found) in found.into_iter().enumerate() {
            let at = |node: usize| f64::from(stored(0, node)[k] + stored(2, node)[k]) * 0.5;
            let expected = at(node) * (1.0 - part) + at(node + 1) * part;
            assert!((f64::from(found) - expected).abs() < 1e-5, "node {node} and {part}");
        }
    }
    // Below the horizon, the horizon.
    let [below, at] =
        [2.0, std::f64::consts::FRAC_PI_2].map(|t| BrdfTensor::seen_from(&table, direction(t, 0.0)));
    assert!(below.iter().zip(&at).all(|(a, b)| (a - b).abs() < 1e-5));
}

/// In spherical coordinates: the mirror direction is at the same angle in the opposite azimuth; tilted by t, at
/// t more; and a side is that far off on a great circle across the plane of incidence.
#[test]
fn cones_are_about_the_mirror_direction() {
    let cone = |tilt_deg: f32, side_deg: f32| Cone { width_deg: 5.0, tilt_deg, side_deg };
    for (theta, azimuth) in [(0.0, 0.0), (0.4, 1.0), (1.5, -2.5)] {
        let outgoing = direction(theta, azimuth);
        for tilt in [0.0f32, 10.0, -40.0] {
            let middle: Vec<Vec3> = cone(tilt, 0.0).directions(outgoing).collect();
            let expected = direction(theta + f64::from(tilt).to_radians(), azimuth + std::f64::consts::PI);
            assert!(
                middle.len() == 1 && (middle[0] - expected).length() < 1e-6,
                "{theta} {tilt}: {middle:?}"
            );
            let sides: Vec<Vec3> = cone(tilt, 20.0).directions(outgoing).collect();
            assert_eq!(sides.len(), 2);
            let normal_of_plane =
                direction(std::f64::consts::FRAC_PI_2, azimuth + std::f64::consts::FRAC_PI_2);
            let heights: Vec<f32> = sides.iter().map(|side| side.dot(normal_of_plane)).collect();
            assert!((heights[0] + heights[1]).abs() < 1e-6);
            for (side, height) in sides.iter().zip(heights) {
                assert!((side.dot(expected) - 20f32.to_radians().cos()).abs() < 1e-6);
                assert!((height.abs() - 20f32.to_radians().sin()).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn a_strength_is_what_unit_lobes_are_multiplied_with() {
    let ks = [0.1, 0.2, 0.3];
    assert_eq!(strength(&Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks, shininess: 9.0 })), ks);
    let grooves = CookTorrance { kd: [0.5; 3], ks, fresnel: 0.5, roughness: 0.5 };
    assert_eq!(strength(&Brdf::CookTorrance(grooves)), ks);
    assert_eq!(strength(&Brdf::Ggx(Ggx { base_color: ks, metallic: 0.5, roughness: 0.5 })), [1.0; 3]);
}

/// A material is the mixture of samples that gives its place, also on the edges of the space; outside of it,
/// the mixture of the nearest place inside; other models' are none.
#[test]
fn materials_lie_between_samples() {
    let line = Samples::Line(vec![1.0, 3.0, 200.0]);
    let phong = |shininess| Brdf::BlinnPhong(BlinnPhong { kd: [0.1; 3], ks: [0.5; 3], shininess });
    assert_eq!(line.mixture(&phong(2.0), 0), Some(vec![(0, 0.5), (1, 0.5)]));
    for (s, node) in [(1.0, 0), (3.0, 1), (200.0, 2)] {
        let mixture = line.mixture(&phong(s), 0).unwrap();
        assert!(mixture.iter().all(|(sample, share)| *share == f32::from(u8::from(*sample == node))), "{s}");
    }
    // Outside, the nearest.
    assert_eq!(line.mixture(&phong(0.5), 0), line.mixture(&phong(1.0), 0));
    assert_eq!(line.mixture(&phong(1e9), 0), line.mixture(&phong(200.0), 0));
    assert!(line.mixture(&phong(f32::NAN), 0).is_none());
    let plane = tensor(3, Model::CookTorrance, [1, 1, 1]).samples;
    let Samples::Plane { points, .. } = &plane else { panic!() };
    let grooves = |fresnel, roughness| {
        Brdf::CookTorrance(CookTorrance { kd: [0.1; 3], ks: [0.5; 3], fresnel, roughness })
    };
    for step in 0..400 {
        let (x, y) = (step % 20, step / 20);
        let (fresnel, roughness) = (x as f32 / 19.0, 0.1f32.powf(1.0 - y as f32 / 19.0).clamp(0.1, 1.0));
        let mixture = plane.mixture(&grooves(fresnel, roughness), 0).unwrap();
        let sum = |f: &dyn Fn([f32; 2]) -> f32| -> f32 {
            mixture.iter().map(|(sample, share)| share * f(points[*sample])).sum()
        };
        assert!(mixture.iter().all(|(_, share)| (0.0..=1.0).contains(share)));
        assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-6 && (sum(&|p| p[0]) - fresnel).abs() < 1e-5);
        assert!((sum(&|p| p[1].ln()) - roughness.ln()).abs() < 1e-4, "{fresnel} {roughness}: {mixture:?}");
    }
    // Outside, the nearest in either coordinate, on edges and at corners.
    for (outside, [fresnel, roughness]) in [
        ((0.5, 0.01), [0.5, 0.1]),
        ((0.25, 7.0), [0.25, 1.0]),
        ((-3.0, 0.3), [0.0, 0.3]),
        ((1.5, 0.01), [1.0, 0.1]),
    ] {
        let mixture = plane.mixture(&grooves(outside.0, outside.1), 0).unwrap();
        assert_eq!(Some(&mixture), plane.mixture(&grooves(fresnel, roughness), 0).as_ref(), "{outside:?}");
        let sum = |axis: usize| -> f32 { mixture.iter().map(|(s, share)| share * points[*s][axis]).sum() };
        assert!((sum(0) - fresnel).abs() < 1e-5 && mixture.iter().all(|(_, share)| *share >= 0.0));
        let logarithm: f32 = mixture.iter().map(|(s, share)| share * points[*s][1].ln()).sum();
        assert!((logarithm - roughness.ln()).abs() < 1e-4, "{outside:?}: {mixture:?}");
    }
    let nothing = [(f32::NAN, 0.5), (0.5, f32::NAN)];
    assert!(nothing.iter().all(|(fresnel, rough)| plane.mixture(&grooves(*fresnel, *rough), 0).is_none()));
    assert!(plane.mixture(&phong(5.0), 0).is_none());
    let other = tensor(3, Model::Ggx, [1, 1, 1]);
    assert!(other.mixture(&grooves(0.5, 0.5), 0).is_none() && other.mixture(&phong(5.0), 0).is_none());
    let gold = Ggx { base_color: [1.0, 0.8, 0.3], metallic: 1.0, roughness: 0.5 };
    let plane = tensor(3, Model::Ggx, [1, 1, 1]).samples;
    let Samples::Plane { points, .. } = &plane else { panic!() };
    for (channel, f0) in gold.f0().into_iter().enumerate() {
        let mixture = plane.mixture(&Brdf::Ggx(gold), channel).unwrap();
        assert!((mixture.iter().map(|(s, share)| share * points[*s][0]).sum::<f32>() - f0).abs() < 1e-5);
    }
}

#[test]
fn broken_tensors() {
    type Change = fn(&mut BrdfTensor);
    type OfLine = fn(&mut Vec<f32>);
    let cases: [(Change, &str); 22] = [
        (|t| t.meta.whole = f64::NAN, "no numbers of at least 0"),
        (|t| t.meta.outgoing = -1.0, "no numbers of at least 0"),
        (|t| t.meta.whole = t.meta.residual + 0.1, "above what cones leave"),
        (|t| t.orders[1] = 49, "section `orders`: element 1 is an order beyond 48"),
        (|t| t.core[1] = f32::INFINITY, "section `core`: element 1"),
        (|t| t.materials[1] = 1e7, "section `materials`: element 1"),
        (|t| t.outgoing[3] = f32::NAN, "section `outgoing`: element 3"),
        (|t| t.incoming[4] = -1e7, "section `incoming`: element 4"),
        (|t| t.shares[9] = -0.1, "section `shares`: element 9 is a share below 0"),
        (|t| t.shares[9] = 65.0, "section `shares`: element 9"),
        (|t| t.even[3] = 1.1, "section `even`: element 3"),
        (|t| t.even[2] = -0.1, "section `even`: element 2"),
        (|t| t.cones[1].width_deg = 0.0, "section `cones`: cone 1 is narrower"),
        (|t| t.cones[1].width_deg = f32::NAN, "section `cones`: element 3"),
        (|t| t.cones[2].side_deg = -1.0, "section `cones`: cone 2"),
        (|t| t.cones[0].tilt_deg = -91.0, "section `cones`: element 1"),
        (|t| points(t)[0][0] = 1.5, "section `points`: sample 0 is outside"),
        (|t| points(t)[4][1] = 0.05, "section `points`: sample 4 is outside"),
        (|t| triangles(t)[1][2] = 5, "triangle 1 names a sample that is not there"),
        (|t| triangles(t)[1].swap(0, 1), "triangle 1 is not counter-clockwise"),
        (|t| triangles(t).truncate(3), "times what materials may be"),
        (|t| *triangles(t) = vec![[0, 1, 4]; 11], "at most 10 are possible"),
    ];
    for (change, expected) in cases {
        let mut tensor = tensor(1, Model::CookTorrance, [2, 2, 2]);
        change(&mut tensor);
        assert_refused(&tensor, expected);
    }
    let lines: [(OfLine, &str); 3] = [
        (|s| s.swap(0, 1), "exponents must increase"),
        (|s| s[2] = 199.0, "expected 1 to 200"),
        (|s| s[1] = f32::NAN, "section `exponents`: element 1"),
    ];
    for (change, expected) in lines {
        let mut tensor = tensor(1, Model::BlinnPhong, [2, 2, 2]);
        let Samples::Line(exponents) = &mut tensor.samples else { panic!() };
        change(exponents);
        assert_refused(&tensor, expected);
    }
    let sound = tensor(1, Model::BlinnPhong, [2, 2, 2]);
    let many = |s: &mut RawSection| {
        let rank = MAX_PROFILES + 1;
        *s = RawSection::new(&s.name, 4, &[rank], 1, &vec![0; 4 * rank as usize]);
    };
    assert_forged_refused(&sound, "orders", many, "holds 17 profiles");
    assert_forged_refused(&sound, "core", |s| s.shape = vec![2, 4, 1], "expected 1 to 16, 1 to 31 and 2");
    assert_forged_refused(&sound, "outgoing", |s| s.shape = vec![2, NODES as u64], "has shape [2, 31]");
    let one = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[1], 1, &[0; 4]);
    assert_forged_refused(&sound, "exponents", one, "holds 1 samples");
    assert_forged_refused(&sound, "even", one, "has shape [1]");
    let fan = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[33, 3], 1, &[0; 4 * 99]);
    assert_forged_refused(&sound, "cones", fan, "holds 33 cones");
}

fn points(tensor: &mut BrdfTensor) -> &mut Vec<[f32; 2]> {
    let Samples::Plane { points, .. } = &mut tensor.samples else { panic!() };
    points
}

fn triangles(tensor: &mut BrdfTensor) -> &mut Vec<[u32; 3]> {
    let Samples::Plane { triangles, .. } = &mut tensor.samples else { panic!() };
    triangles
}
