//! What stored numbers mean, computed a second time from the published formulas in double precision.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod support {
    pub mod samples;
}

use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::transfer_images::{FirstReflection, Slot};
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{Animation, BlinnPhong};
use support::samples::{self, Random};

/// Coefficients of a material on every basis in one channel (thesis eq. 4-22): kd on the diffuse basis, plus ks times those of the unit
/// lobe, which lie on the chord between the two stored exponents around s.
fn coefficients(basis: &BrdfBasis, material: &BlinnPhong, channel: usize) -> Vec<f64> {
    let (s, nodes) = (f64::from(material.shininess), &basis.shininess);
    let bases = basis.coefficients.len() / nodes.len();
    let right = (1..nodes.len()).find(|i| s <= f64::from(nodes[*i])).unwrap_or(nodes.len() - 1);
    let (s0, s1) = (f64::from(nodes[right - 1]), f64::from(nodes[right]));
    let t = ((s - s0) / (s1 - s0)).clamp(0.0, 1.0);
    let stored = |node: usize, b: usize| f64::from(basis.coefficients[node * bases + b]);
    (0..bases)
        .map(|b| {
            let diffuse = if b == 0 { f64::from(material.kd[channel]) } else { 0.0 };
            diffuse + f64::from(material.ks[channel]) * ((1.0 - t) * stored(right - 1, b) + t * stored(right, b))
        })
        .collect()
}

/// Radiance per unit coefficient that the file stores for one fragment under `slot`, whose number is `number`.
fn stored(bundle: &TransferImages, slot: &Slot, number: usize, fragment: usize, channel: usize) -> f64 {
    let head = &bundle.head;
    let fragments = if slot.fixed.is_some() { head.pixel.len() } else { head.meta.editable_fragments as usize };
    let image = bundle.images.iter().find(|i| i.slot == number).unwrap();
    let half = |plane: usize| f64::from(image.values[plane * fragments + fragment].to_f32()) * f64::from(head.scales[number]);
    match (slot.rgb, head.meta.chromaticity) {
        (true, _) => half(channel),
        (false, Some(colour)) => half(0) * f64::from(colour[channel]),
        (false, None) => panic!("lights of several colours cannot be stored in one channel"),
    }
}

/// Thesis eq. 4-26 and 4-27 for one fragment: direct light, then every way by one first reflection. Returns the sum, and what rounding
/// errors are to be measured by: the same sum of magnitudes, each coefficient made 1 larger for it may be a small difference of large numbers.
fn radiance(bundle: &TransferImages, on_bases: &[Vec<f64>], fragment: usize, channel: usize) -> (f64, f64) {
    let head = &bundle.head;
    let slots: Vec<_> = head.layout().slots.into_iter().enumerate().collect();
    let bases = head.meta.bases as usize;
    let mut firsts = vec![(FirstReflection::None, 1.0), (FirstReflection::Fixed, 1.0)];
    for (material, coefficients) in on_bases.iter().enumerate() {
        firsts.extend((0..bases).map(|basis| (FirstReflection::Editable { material, basis }, coefficients[basis])));
    }
    let (mut sum, mut magnitude) = (0.0, 0.0);
    let mut add = |eye: f64, first: f64, stored: f64| {
        sum += eye * first * stored;
        magnitude += (eye.abs() + 1.0) * (first.abs() + 1.0) * stored.abs();
    };
    for (first, first_coefficient) in firsts {
        match on_bases.get(usize::from(head.class[fragment])) {
            // An editable surface: its own coefficient on each basis stands in front.
            Some(eye) => (0..bases).for_each(|eye_basis| {
                let (number, slot) = slots.iter().find(|(_, s)| s.eye_basis == eye_basis && s.first == first).unwrap();
                add(eye[eye_basis], first_coefficient, stored(bundle, slot, *number, fragment, channel));
            }),
            // A fixed surface: its reflectance was baked in.
            None => {
                let (number, slot) = slots.iter().find(|(_, s)| s.fixed == Some(first)).unwrap();
                add(1.0, first_coefficient, stored(bundle, slot, *number, fragment, channel));
            }
        }
    }
    (sum, magnitude)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn a_pixel_is_the_sum_over_its_light_paths(
        seed: u64, editable in 1usize..4, bases in 2usize..5, one_colour: bool, width in 1u32..4, height in 1u32..4
    ) {
        let bundle = samples::images(seed, editable, bases, one_colour, [width, height]);
        let basis = samples::basis(seed, bases, false);
        let mut random = Random(seed ^ 1);
        let materials: Vec<_> = (0..editable).map(|_| random.material()).collect();
        let film = evaluate(&bundle, &basis, &materials);
        prop_assert_eq!(film.len() as u32, width * height);
        for channel in 0..3 {
            let on_bases: Vec<_> = materials.iter().map(|m| coefficients(&basis, m, channel)).collect();
            for (pixel, value) in film.iter().enumerate() {
                let fragments = (0..bundle.head.pixel.len()).filter(|f| bundle.head.pixel[*f] as usize == pixel);
                let (sum, magnitude) = fragments
                    .map(|f| radiance(&bundle, &on_bases, f, channel))
                    .fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
                // At most 4 fragments of 4·14 terms: 224 roundings of 6e-8 in the sum and less than ten in each term.
                let tolerance = 1.5e-5 * magnitude;
                prop_assert!((f64::from(value[channel]) - sum).abs() <= tolerance, "pixel {pixel}: {} is not {sum}", value[channel]);
            }
        }
    }

    #[test]
    fn coefficients_of_a_material_are_those_of_the_formula(seed: u64, bases in 2usize..6) {
        let basis = samples::basis(seed, bases, true);
        let material = Random(seed ^ 1).material();
        let computed = basis.coefficients_of(&material);
        prop_assert_eq!(computed.len(), bases);
        for channel in 0..3 {
            for (value, expected) in computed.iter().zip(coefficients(&basis, &material, channel)) {
                prop_assert!((f64::from(value[channel]) - expected).abs() < 1e-6, "{} is not {expected}", value[channel]);
            }
        }
    }

    /// f(αa + βb) = αf(a) + βf(b) at equal exponents, which is what lets a player edit colours without a new bake.
    #[test]
    fn coefficients_are_linear_in_kd_and_ks(seed: u64, alpha in 0.0f32..1.0) {
        let basis = samples::basis(seed, 4, true);
        let mut random = Random(seed ^ 1);
        let a = random.material();
        let b = BlinnPhong { shininess: a.shininess, ..random.material() };
        let mix = |x: [f32; 3], y: [f32; 3]| [0, 1, 2].map(|i| alpha * x[i] + (1.0 - alpha) * y[i]);
        let mixed = BlinnPhong { kd: mix(a.kd, b.kd), ks: mix(a.ks, b.ks), shininess: a.shininess };
        let (of_a, of_b) = (basis.coefficients_of(&a), basis.coefficients_of(&b));
        for (value, (x, y)) in basis.coefficients_of(&mixed).into_iter().zip(of_a.into_iter().zip(of_b)) {
            for (v, e) in value.into_iter().zip(mix(x, y)) {
                prop_assert!((v - e).abs() < 1e-6, "{v} is not {e}");
            }
        }
    }
}

#[test]
fn coefficients_at_and_beyond_the_nodes_are_the_stored_ones() {
    let basis = samples::basis(5, 3, true);
    let unit = |shininess: f32| BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess };
    let last = basis.shininess.len() - 1;
    for (s, node) in [(1.0, 0), (0.5, 0), (200.0, last), (900.0, last), (basis.shininess[1], 1)] {
        let expected = &basis.coefficients[node * 3..node * 3 + 3];
        let computed: Vec<f32> = basis.coefficients_of(&unit(s)).iter().map(|c| c[1]).collect();
        computed.iter().zip(expected).for_each(|(c, e)| assert!((c - e).abs() < 1e-6, "at s = {s}: {computed:?} is not {expected:?}"));
    }
}

/// A colour turns from red to blue over two seconds and back, the exponent rises in the last second.
#[test]
fn an_animation_is_linear_between_keys_and_held_outside() {
    let text = "
        duration_s = 4.0
        [[key]]
        t_s = 0.5
        materials.a.kd = [0.8, 0.0, 0.0]
        camera.exposure_ev = -2
        [[key]]
        t_s = 2.5
        materials.a.kd = [0.0, 0.0, 0.4]
        [[key]]
        t_s = 3
        materials.a.kd = [0.8, 0.0, 0.0]
        materials.a.shininess = 10
        [[key]]
        t_s = 4.0
        materials.a.shininess = 200
    ";
    let animation = Animation::parse("turn", text, &Place::file("turn.toml")).unwrap();
    assert!(!animation.looping);
    assert_eq!(animation.tracks.iter().map(|t| t.times_s.len()).collect::<Vec<_>>(), [1, 3, 2]);
    let hand: [(f32, [f32; 3], f32); 9] = [
        (-1.0, [0.8, 0.0, 0.0], 10.0),
        (0.0, [0.8, 0.0, 0.0], 10.0),
        (0.5, [0.8, 0.0, 0.0], 10.0),
        (1.0, [0.6, 0.0, 0.1], 10.0),
        (1.5, [0.4, 0.0, 0.2], 10.0),
        (2.5, [0.0, 0.0, 0.4], 10.0),
        (2.75, [0.4, 0.0, 0.2], 10.0),
        (3.5, [0.8, 0.0, 0.0], 105.0),
        (9.0, [0.8, 0.0, 0.0], 200.0),
    ];
    for (time_s, kd, shininess) in hand {
        let state = animation.sample(time_s).unwrap();
        let material = &state.materials["a"];
        for (value, expected) in material.kd.unwrap().into_iter().zip(kd) {
            assert!((value - expected).abs() < 1e-6, "at {time_s} s");
        }
        assert!((material.shininess.unwrap() - shininess).abs() < 1e-4, "at {time_s} s");
        assert_eq!((material.ks, state.camera.unwrap().exposure_ev), (None, Some(-2.0)), "at {time_s} s");
    }
}
