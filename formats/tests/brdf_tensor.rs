//! BRDF tensors: what they mean, written out, and files that are none.

use crate::support::raw_file::RawSection;
use crate::support::refusing::{assert_forged_refused, assert_refused};
use crate::support::tensors::{WIDTHS_DEG, tensor};
use glam::DVec3;
use relume_formats::basis::disc::{self, CELLS, RINGS};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::{MAX_RANK, Samples};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx, Model};

const MODELS: [Model; 3] = [Model::BlinnPhong, Model::Ggx, Model::CookTorrance];

/// Σ D U U U at nodes, in double precision, of two samples mixed.
#[test]
fn a_lobe_is_the_sum_over_all_columns() {
    for (seed, model) in (0..).zip(MODELS) {
        let ranks = [2, 3, 4];
        let tensor = tensor(seed, model, ranks);
        let mixture = [(0, 0.25), (2, 0.75)];
        let core = tensor.core_of(&mixture);
        for (o, i) in [(0, 0), (3, CELLS - 1), (200, 77), (CELLS - 1, 17)] {
            let (mut sum, mut magnitude) = (0.0, 0.0);
            for (sample, share) in mixture {
                for (a, b, c) in (0..ranks[0])
                    .flat_map(|a| (0..ranks[1]).flat_map(move |b| (0..ranks[2]).map(move |c| (a, b, c))))
                {
                    let factors = [
                        share,
                        tensor.core[(a * ranks[1] + b) * ranks[2] + c],
                        tensor.materials[sample * ranks[0] + a],
                        tensor.outgoing[o * ranks[1] + b],
                        tensor.incoming[i * (1 + ranks[2]) + 1 + c],
                    ];
                    let term: f64 = factors.map(f64::from).iter().product();
                    (sum, magnitude) = (sum + term, magnitude + term.abs());
                }
            }
            let value = tensor.residual(&core, disc::direction(o), disc::direction(i));
            // Some ten roundings a term, and nodes are met to their rounding.
            assert!((f64::from(value) - sum).abs() < 1e-5 * magnitude, "{value} is not {sum}");
        }
    }
}

#[test]
fn shares_of_mirror_terms_are_linear_between_rings_and_samples() {
    let tensor = tensor(5, Model::BlinnPhong, [1, 1, 1]);
    let seen_from = |radius: f64| DVec3::new(0.0, radius, (1.0 - radius * radius).sqrt());
    let terms = WIDTHS_DEG.len();
    let stored = |sample: usize, ring: usize| &tensor.mirror[(sample * RINGS + ring) * terms..][..terms];
    for (radius, expected) in [
        (disc::radius(0), stored(1, 0)),
        (0.0, stored(1, 0)),
        (1.0, stored(1, RINGS - 1)),
        (disc::radius(4), stored(1, 4)),
    ] {
        for (share, expected) in tensor.shares(&[(1, 1.0)], seen_from(radius)).into_iter().zip(expected) {
            assert!((share - expected).abs() < 1e-5, "at {radius}");
        }
    }
    let between = tensor.shares(&[(0, 0.5), (2, 0.5)], seen_from(0.5 * (disc::radius(2) + disc::radius(3))));
    for (k, share) in between.into_iter().enumerate() {
        let mean = [(0, 2), (0, 3), (2, 2), (2, 3)].map(|(s, r)| stored(s, r)[k]).iter().sum::<f32>() / 4.0;
        assert!((share - mean).abs() < 1e-5);
    }
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
    let cases: [(Change, &str); 21] = [
        (|t| t.meta.whole = f64::NAN, "no numbers of at least 0"),
        (|t| t.meta.outgoing = -1.0, "no numbers of at least 0"),
        (|t| t.meta.whole = t.meta.residual + 0.1, "above what mirror terms leave"),
        (|t| t.core[1] = f32::INFINITY, "section `core`: element 1"),
        (|t| t.materials[1] = 1e7, "section `materials`: element 1"),
        (|t| t.outgoing[3] = f32::NAN, "section `outgoing`: element 3"),
        (
            |t| t.outgoing.iter_mut().for_each(|v| *v *= 2.0),
            "section `outgoing`: the product of columns 0 and 0",
        ),
        (
            |t| t.incoming.iter_mut().skip(1).step_by(3).for_each(|v| *v = 0.0),
            "section `incoming`: the product of",
        ),
        (|t| t.incoming[0] = 0.5, "not the diffuse lobe"),
        (|t| t.mirror[9] = -0.1, "section `mirror`: element 9 is a share below 0"),
        (|t| t.mirror[9] = 65.0, "section `mirror`: element 9"),
        (|t| t.widths_deg[1] = 20.0, "section `widths`: widths must increase"),
        (|t| t.widths_deg[0] = -1.0, "section `widths`: widths must increase"),
        (|t| t.widths_deg[2] = 91.0, "section `widths`: element 2"),
        (|t| t.widths_deg[1] = f32::NAN, "section `widths`: element 1"),
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
        let rank = MAX_RANK + 1;
        *s = RawSection::new(&s.name, 4, &[rank, 1, 1], 1, &vec![0; 4 * rank as usize]);
    };
    assert_forged_refused(&sound, "core", many, "three dimensions of 1 to 64");
    assert_forged_refused(&sound, "outgoing", |s| s.shape = vec![2, CELLS as u64], "has shape [2, 576]");
    let one = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[1], 1, &[0; 4]);
    assert_forged_refused(&sound, "exponents", one, "holds 1 samples");
    let nine = |s: &mut RawSection| *s = RawSection::new(&s.name, 4, &[9], 1, &[0; 36]);
    assert_forged_refused(&sound, "widths", nine, "holds 9 mirror terms");
}

fn points(tensor: &mut BrdfTensor) -> &mut Vec<[f32; 2]> {
    let Samples::Plane { points, .. } = &mut tensor.samples else { panic!() };
    points
}

fn triangles(tensor: &mut BrdfTensor) -> &mut Vec<[u32; 3]> {
    let Samples::Plane { triangles, .. } = &mut tensor.samples else { panic!() };
    triangles
}
