//! What stored numbers mean, computed a second time from the published formulas in double precision.

use crate::support::samples::{self, Random};
use proptest::prelude::*;
use relume_formats::Place;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::transfer_images::{FirstReflection, Later, Slot};
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{Animation, BlinnPhong, Brdf, Ggx};

/// Coefficients of part `part` of the unit lobe, which lie on the chord between the two stored parameters
/// around `parameter`.
fn lobe(basis: &BrdfBasis, parts: usize, part: usize, parameter: f32) -> Vec<f64> {
    let (s, nodes) = (f64::from(parameter), &basis.parameters);
    let bases = basis.coefficients.len() / nodes.len() / parts;
    let right = (1..nodes.len()).find(|i| s <= f64::from(nodes[*i])).unwrap_or(nodes.len() - 1);
    let (s0, s1) = (f64::from(nodes[right - 1]), f64::from(nodes[right]));
    let t = ((s - s0) / (s1 - s0)).clamp(0.0, 1.0);
    let stored = |node: usize, b: usize| f64::from(basis.coefficients[(node * parts + part) * bases + b]);
    (0..bases).map(|b| (1.0 - t) * stored(right - 1, b) + t * stored(right, b)).collect()
}

/// Coefficients of a material on every basis in one channel. Blinn-Phong (thesis eq. 4-22): kd on the diffuse
/// basis, plus ks times those of the unit lobe. GGX, from glTF 2.0 (appendix B.3.5) written out in Schlick's
/// weight w: F = f0 + (1 - f0) w, hence rho = (1 - f0)(1 - metallic) c (1 - w)/pi + f0 D V (1 - w) + D V w:
/// the two parts are those of D V (1 - w) and of D V w. Cook-Torrance has F = f + (1 - f) w, too, ks times it, and
/// its kd beside it as it is.
fn coefficients(basis: &BrdfBasis, material: &Brdf, channel: usize) -> Vec<f64> {
    let (diffuse, glossy) = match material {
        Brdf::BlinnPhong(m) => {
            let ks = f64::from(m.ks[channel]);
            (
                f64::from(m.kd[channel]),
                lobe(basis, 1, 0, m.shininess).iter().map(|c| ks * c).collect::<Vec<_>>(),
            )
        }
        Brdf::Ggx(m) => {
            let (base, metallic) = (f64::from(m.base_color[channel]), f64::from(m.metallic));
            let f0 = 0.04 + (base - 0.04) * metallic;
            let [plain, schlick] = [0, 1].map(|part| lobe(basis, 2, part, m.roughness));
            (
                (1.0 - f0) * (1.0 - metallic) * base,
                plain.iter().zip(schlick).map(|(p, s)| f0 * p + s).collect(),
            )
        }
        Brdf::CookTorrance(m) => {
            let (ks, fresnel) = (f64::from(m.ks[channel]), f64::from(m.fresnel));
            let [plain, schlick] = [0, 1].map(|part| lobe(basis, 2, part, m.roughness));
            (
                f64::from(m.kd[channel]),
                plain.iter().zip(schlick).map(|(p, s)| ks * (fresnel * p + s)).collect(),
            )
        }
    };
    glossy.into_iter().enumerate().map(|(b, c)| if b == 0 { c + diffuse } else { c }).collect()
}

/// Radiance per unit coefficient that the file stores for one fragment under `slot`, whose number is
/// `number`.
fn stored(bundle: &TransferImages, slot: &Slot, number: usize, fragment: usize, channel: usize) -> f64 {
    let head = &bundle.head;
    let fragments =
        if slot.fixed.is_some() { head.pixel.len() } else { head.meta.editable_fragments as usize };
    let image = bundle.images.iter().find(|i| i.slot == number).unwrap();
    let half = |plane: usize| {
        f64::from(image.values[plane * fragments + fragment].to_f32()) * f64::from(head.scales[number])
    };
    match (slot.rgb, head.meta.chromaticity) {
        (true, _) => half(channel),
        (false, Some(colour)) => half(0) * f64::from(colour[channel]),
        (false, None) => panic!("lights of several colours cannot be stored in one channel"),
    }
}

/// Thesis eq. 4-26 and 4-27 for one fragment: direct light, then every way by one first reflection. Returns
/// the sum, and what rounding errors are to be measured by: the same sum of magnitudes, each coefficient made
/// 1 larger for it may be a small difference of large numbers.
fn radiance(bundle: &TransferImages, on_bases: &[Vec<f64>], fragment: usize, channel: usize) -> (f64, f64) {
    let head = &bundle.head;
    let slots: Vec<_> = head.layout().slots.into_iter().enumerate().collect();
    let bases = head.meta.bases as usize;
    let mut firsts = vec![(FirstReflection::None, 1.0), (FirstReflection::Fixed, 1.0)];
    for (material, coefficients) in on_bases.iter().enumerate() {
        firsts.extend(
            (0..bases).map(|basis| (FirstReflection::Editable { material, basis }, coefficients[basis])),
        );
    }
    if let Some(later) = &head.later {
        let nodes = node_coefficients(later, on_bases, channel).into_iter().enumerate();
        firsts.extend(nodes.map(|(node, coefficient)| (FirstReflection::Later { node }, coefficient)));
        let nodes = node_coefficients(&Later { degree: 1, ..later.clone() }, on_bases, channel);
        for (material, coefficients) in on_bases.iter().enumerate() {
            let lobes = coefficients.iter().enumerate().skip(1).take(later.lobes as usize);
            firsts.extend(lobes.flat_map(|(basis, coefficient)| {
                nodes.iter().enumerate().map(move |(node, weight)| {
                    (FirstReflection::LaterLobe { material, basis, node }, weight * coefficient)
                })
            }));
        }
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
                let is_it = |(_, s): &&(usize, Slot)| s.eye_basis == eye_basis && s.first == first;
                match slots.iter().find(is_it) {
                    Some((number, slot)) => {
                        add(
                            eye[eye_basis],
                            first_coefficient,
                            stored(bundle, slot, *number, fragment, channel),
                        );
                    }
                    None => {
                        // Light that has been about has images of the first bases alone.
                        let later = head.later.as_ref().unwrap();
                        let kept = match first {
                            FirstReflection::Later { .. } => later.eye_bases,
                            FirstReflection::LaterLobe { .. } => later.lobe_eye_bases,
                            _ => panic!("{first:?} has no image of basis {eye_basis}"),
                        };
                        assert!(eye_basis >= kept as usize);
                    }
                }
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

/// What a value at each node counts, by the definition: the weights by which all products of albedos of the
/// degree come out right, over the determinant, which is written out.
fn node_coefficients(later: &Later, on_bases: &[Vec<f64>], channel: usize) -> Vec<f64> {
    let albedo = |(coefficients, texture): (&Vec<f64>, &[f32; 3])| {
        let term = |(k, (c, a)): (usize, (&f64, &f32))| {
            c * f64::from(*a) * if k == 0 { f64::from(texture[channel]) } else { 1.0 }
        };
        coefficients.iter().zip(&later.albedos).enumerate().map(term).sum::<f64>().clamp(0.0, 0.95)
    };
    let at: Vec<f64> = on_bases.iter().zip(&later.textures).map(albedo).collect();
    let nodes: Vec<Vec<f64>> =
        later.node_albedos().iter().map(|node| node.iter().copied().map(f64::from).collect()).collect();
    // Exponents are the nodes' numbers.
    let exponent = |albedo: f64| {
        if albedo == 0.0 {
            0
        } else if albedo > 0.9 {
            1
        } else {
            2
        }
    };
    let product = |at: &[f64], powers: &[f64]| -> f64 {
        at.iter().zip(powers).map(|(x, power)| x.powi(exponent(*power))).product()
    };
    let rows = nodes.iter().map(|powers| {
        nodes.iter().map(|node| product(node, powers)).chain([product(&at, powers)]).collect::<Vec<f64>>()
    });
    let polynomial = solved(rows.collect());
    let count = at.len();
    let returns = &later.returns[channel * count * count..][..count * count];
    let denominator = |at: &[f64]| {
        let m = |i: usize, j: usize| f64::from(u8::from(i == j)) - f64::from(returns[i * count + j]) * at[j];
        match count {
            1 => m(0, 0),
            2 => m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0),
            _ => (0..3)
                .map(|i| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    m(0, i) * (m(1, j) * m(2, k) - m(1, k) * m(2, j))
                })
                .sum(),
        }
    };
    polynomial
        .iter()
        .zip(&nodes)
        .map(|(weight, node)| weight * denominator(node) / denominator(&at))
        .collect()
}

/// The solution of a linear system, the right side last in each row.
fn solved(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let count = rows.len();
    for column in 0..count {
        let pivot =
            (column..count).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs())).unwrap();
        rows.swap(column, pivot);
        let above = rows[column].clone();
        for row in (0..count).filter(|row| *row != column) {
            let factor = rows[row][column] / above[column];
            rows[row].iter_mut().zip(&above).for_each(|(value, above)| *value -= factor * above);
        }
    }
    (0..count).map(|i| rows[i][count] / rows[i][i]).collect()
}

/// A basis of any model, and materials of that model.
fn materials_and_basis(seed: u64, bases: usize, count: usize) -> (BrdfBasis, Vec<Brdf>) {
    let random = &mut Random(seed ^ 1);
    match seed % 3 {
        0 => (
            samples::basis(seed, bases, false),
            (0..count).map(|_| Brdf::BlinnPhong(random.blinn_phong())).collect(),
        ),
        1 => (samples::ggx_basis(seed, bases, 2), (0..count).map(|_| Brdf::Ggx(random.ggx())).collect()),
        _ => (
            samples::cook_torrance_basis(seed, bases, 2),
            (0..count).map(|_| Brdf::CookTorrance(random.cook_torrance())).collect(),
        ),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn a_pixel_is_the_sum_over_its_light_paths(
        seed: u64, editable in 1usize..4, bases in 2usize..5, one_colour: bool, width in 1u32..4, height in 1u32..4
    ) {
        let of_all = seed.is_multiple_of(2);
        let samples = if of_all { samples::images_of_all } else { samples::images };
        let bundle = samples(seed, editable, bases, one_colour, [width, height]);
        let (basis, materials) = materials_and_basis(seed, bases, editable);
        let on_bases: Vec<_> = materials.iter().map(|m| basis.coefficients_of(m).unwrap()).collect();
        let film = evaluate(&bundle, &on_bases);
        prop_assert_eq!(film.len() as u32, width * height);
        for channel in 0..3 {
            let on_bases: Vec<_> = materials.iter().map(|m| coefficients(&basis, m, channel)).collect();
            for (pixel, value) in film.iter().enumerate() {
                let fragments = (0..bundle.head.pixel.len()).filter(|f| bundle.head.pixel[*f] as usize == pixel);
                let (sum, magnitude) = fragments
                    .map(|f| radiance(&bundle, &on_bases, f, channel))
                    .fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
                // At most 4 fragments of 4·24 terms: 384 roundings of 6e-8 in the sum and less than ten in
                // each term.
                let tolerance = 2.5e-5 * magnitude;
                prop_assert!((f64::from(value[channel]) - sum).abs() <= tolerance, "pixel {pixel}: {} is not {sum}", value[channel]);
            }
        }
    }

    #[test]
    fn coefficients_of_a_material_are_those_of_the_formula(seed: u64, bases in 2usize..6) {
        let (basis, materials) = materials_and_basis(seed, bases, 1);
        let computed = basis.coefficients_of(&materials[0]).unwrap();
        prop_assert_eq!(computed.len(), bases);
        for channel in 0..3 {
            for (value, expected) in computed.iter().zip(coefficients(&basis, &materials[0], channel)) {
                prop_assert!((f64::from(value[channel]) - expected).abs() < 1e-6, "{} is not {expected}", value[channel]);
            }
        }
    }

    /// f(αa + βb) = αf(a) + βf(b) at equal exponents, which is what lets a player edit colours without a new
    /// bake.
    #[test]
    fn coefficients_are_linear_in_kd_and_ks(seed: u64, alpha in 0.0f32..1.0) {
        let basis = samples::basis(seed, 4, true);
        let mut random = Random(seed ^ 1);
        let a = random.blinn_phong();
        let b = BlinnPhong { shininess: a.shininess, ..random.blinn_phong() };
        let mix = |x: [f32; 3], y: [f32; 3]| [0, 1, 2].map(|i| alpha * x[i] + (1.0 - alpha) * y[i]);
        let mixed = BlinnPhong { kd: mix(a.kd, b.kd), ks: mix(a.ks, b.ks), shininess: a.shininess };
        let of = |material| basis.coefficients_of(&Brdf::BlinnPhong(material)).unwrap();
        let (of_a, of_b) = (of(a), of(b));
        for (value, (x, y)) in of(mixed).into_iter().zip(of_a.into_iter().zip(of_b)) {
            for (v, e) in value.into_iter().zip(mix(x, y)) {
                prop_assert!((v - e).abs() < 1e-6, "{v} is not {e}");
            }
        }
    }
}

#[test]
fn coefficients_at_and_beyond_the_nodes_are_the_stored_ones() {
    let basis = samples::basis(5, 3, true);
    let unit = |shininess: f32| Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess });
    let last = basis.parameters.len() - 1;
    for (s, node) in [(1.0, 0), (0.5, 0), (200.0, last), (900.0, last), (basis.parameters[1], 1)] {
        let expected = &basis.coefficients[node * 3..node * 3 + 3];
        let computed: Vec<f32> = basis.coefficients_of(&unit(s)).unwrap().iter().map(|c| c[1]).collect();
        computed
            .iter()
            .zip(expected)
            .for_each(|(c, e)| assert!((c - e).abs() < 1e-6, "at s = {s}: {computed:?} is not {expected:?}"));
    }
}

/// By hand: roughness 0.5 is half way between the nodes, f0 = 0.04·0.75 + 0.5·0.25 = 0.155, diffuse =
/// 0.845·0.75·0.5 = 0.316875.
#[test]
fn coefficients_of_a_ggx_material_by_hand() {
    let mut basis = samples::ggx_basis(1, 2, 1);
    basis.parameters = vec![0.25, 0.75];
    // [nodes, parts, bases]: at the first node 10, 20 and 30, 40, at the second 12, 26 and 34, 44.
    basis.coefficients = vec![10.0, 20.0, 30.0, 40.0, 12.0, 26.0, 34.0, 44.0];
    let material = Ggx { base_color: [0.5, 0.0, 1.0], metallic: 0.25, roughness: 0.5 };
    let computed = basis.coefficients_of(&Brdf::Ggx(material)).unwrap();
    // Part 0 is (11, 23), part 1 is (32, 42); f0 = 0.155, 0.03, 0.28, diffuse = 0.316875, 0, 0.54.
    let hand = [[34.021_875, 32.33, 35.62], [45.565, 42.69, 48.44]];
    for (value, expected) in computed.as_flattened().iter().zip(hand.as_flattened()) {
        assert!((value - expected).abs() < 2e-5, "{computed:?} is not {hand:?}");
    }
}

#[test]
fn a_basis_has_no_coefficients_for_another_model() {
    let random = &mut Random(1);
    let materials = [
        Brdf::BlinnPhong(random.blinn_phong()),
        Brdf::Ggx(random.ggx()),
        Brdf::CookTorrance(random.cook_torrance()),
    ];
    let bases =
        [samples::basis(1, 3, true), samples::ggx_basis(1, 3, 2), samples::cook_torrance_basis(1, 3, 2)];
    for (basis, material) in bases.iter().flat_map(|basis| materials.iter().map(move |m| (basis, m))) {
        let is_one = basis.functions.model() == material.model();
        assert_eq!(basis.coefficients_of(material).is_some(), is_one, "{material:?}");
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
