//! Baked images against the reference, with stated bounds.

use crate::support::images::{bake, gathering, in_state, on_bases, pick, settings, surface_pixels};
use crate::support::{job, relative_l2, render, with_two_reflections};
use relume_bake::methods::transfer_images::{self, Settings, held_out, space_for};
use relume_bake::trace::reference::{self, Estimate, Paths};
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::state::{Brdf, CookTorrance, Ggx};
use relume_scenes::{Emitter, Filter, Light, Scene, Texture, Wrap};

/// Random states from another sequence than the one that bakes measure themselves on.
fn states(scene: &Scene) -> Vec<Vec<Brdf>> {
    (100..116).map(|s| held_out::random_state(s, scene)).collect()
}

fn references(scene: &Scene, states: &[Vec<Brdf>], settings: &Settings, paths: Paths) -> Vec<Estimate> {
    let scenes: Vec<Scene> = states.iter().map(|s| in_state(scene, s)).collect();
    let Settings { size, samples, seed, .. } = *settings;
    reference::render(
        scene,
        &scenes,
        &[],
        &reference::Settings { size, samples, seed, reflections: 2, paths, target: None },
        &job(),
    )
    .unwrap()
}

/// Median and worst relative L2 over 16 random states, on the bake's own paths.
fn errors(scene: &Scene, settings: &Settings, shared_diffuse: bool) -> (f64, f64) {
    let (basis, images) = bake(scene, settings, shared_diffuse);
    let pixels = surface_pixels(scene, settings);
    let states = states(scene);
    let references = references(scene, &states, settings, Paths::Gather);
    let error = |(state, reference): (&Vec<Brdf>, &Estimate)| {
        relative_l2(
            &pick(&evaluate(&images, &on_bases(&basis, state)), &pixels),
            &pick(&reference.radiance, &pixels),
        )
    };
    let mut errors: Vec<f64> = states.iter().zip(&references).map(error).collect();
    errors.sort_by(f64::total_cmp);
    (0.5 * (errors[7] + errors[8]), errors[15])
}

#[test]
fn six_and_nine_bases_stay_below_the_published_errors() {
    let scene = with_two_reflections("cornell-knot");
    for (bases, shared, median_bound, worst_bound) in
        [(6, true, 0.006, 0.015), (6, false, 0.009, 0.02), (9, true, 0.0005, 0.003)]
    {
        let (median, worst) = errors(&scene, &settings(64, 64, bases, 1), shared);
        println!(
            "{bases} bases, shared diffuse {shared}: median {:.4} %, worst {:.4} %",
            100.0 * median,
            100.0 * worst
        );
        assert!(median <= median_bound && worst <= worst_bound, "{bases} bases: {median}, {worst}");
    }
}

/// The number of bases that a scene gets for a wanted error is enough, and not much more.
#[test]
fn bases_are_chosen_by_error() {
    let scene = with_two_reflections("cornell-knot");
    let space = space_for(&scene, 16).unwrap();
    let pixels = held_out::some_pixels(held_out::CHOICE_PIXELS, [64, 64]);
    let choose = |max_error| {
        gathering(&scene, &settings(64, 64, 16, 1), |gather| {
            held_out::choose_bases(&scene, gather, space.whole(), 64, max_error, &pixels, &job()).unwrap()
        })
    };
    for max_error in [0.02, 0.005, 0.001] {
        let bases = choose(max_error);
        let worst = |bases| {
            let settings = settings(64, 64, bases, 1);
            let (basis, images) = bake(&scene, &settings, true);
            let measured = gathering(&scene, &settings, |gather| {
                held_out::measure(&scene, gather, &settings, &basis, &images, &job()).unwrap()
            });
            measured.unwrap().worst
        };
        // The choice sees other pixels and fewer paths than the measurement.
        assert!(
            worst(bases) < 1.3 * max_error && worst(bases - 1) > 0.7 * max_error,
            "{bases} bases for {max_error}"
        );
    }
    assert_eq!(choose(1e-9), 16, "the most there are");
}

/// The demo scene in glTF's materials.
fn in_ggx() -> Scene {
    let mut scene = with_two_reflections("cornell-knot");
    for material in &mut scene.materials {
        material.brdf = Brdf::Ggx(Ggx { base_color: [0.6, 0.5, 0.4], metallic: 0.0, roughness: 0.5 });
    }
    scene
}

/// Metals, dielectrics and what is between need more bases than Blinn-Phong, for their lobes have two parts;
/// the error still falls as far as asked.
#[test]
fn ggx_converges_with_the_number_of_bases() {
    let scene = in_ggx();
    for (bases, median_bound, worst_bound) in
        [(6, 0.02, 0.04), (9, 0.006, 0.018), (12, 0.0012, 0.003), (16, 0.0004, 0.0006)]
    {
        let (median, worst) = errors(&scene, &settings(48, 64, bases, 1), true);
        println!("GGX, {bases} bases: median {:.4} %, worst {:.4} %", 100.0 * median, 100.0 * worst);
        assert!(median <= median_bound && worst <= worst_bound, "{bases} bases: {median}, {worst}");
    }
}

/// The demo scene in Cook and Torrance's materials.
fn in_grooves() -> Scene {
    let mut scene = with_two_reflections("cornell-knot");
    for material in &mut scene.materials {
        let brdf = CookTorrance { kd: [0.3, 0.25, 0.2], ks: [0.5; 3], fresnel: 0.5, roughness: 0.3 };
        material.brdf = Brdf::CookTorrance(brdf);
    }
    scene
}

/// As GGX's.
#[test]
fn cook_torrance_converges_with_the_number_of_bases() {
    let scene = in_grooves();
    let measured = [6, 9, 12, 16].map(|bases| errors(&scene, &settings(48, 64, bases, 1), true));
    println!("Cook-Torrance, 6, 9, 12 and 16 bases, median and worst: {measured:?}");
    let bounds = [(0.06, 0.15), (0.014, 0.04), (0.004, 0.007), (0.0008, 0.0016)];
    for ((median, worst), (median_bound, worst_bound)) in measured.into_iter().zip(bounds) {
        assert!(median <= median_bound && worst <= worst_bound, "{measured:?}");
    }
}

/// What a surface emits stays whatever its material becomes, and lights the rest.
#[test]
fn materials_of_surfaces_that_emit_vary_as_exactly_as_others() {
    let mut scene = with_two_reflections("cornell-knot");
    let object = scene.objects.iter().position(|o| scene.vary.materials.contains(&o.material)).unwrap();
    let emitter = Emitter::Mesh { object, radiance: [0.5, 0.4, 0.3], glow: None };
    scene.lights.push(Light { name: "glow".to_owned(), emitter });
    let settings = settings(32, 16, 9, 1);
    let (basis, images) = bake(&scene, &settings, true);
    for state in &states(&scene)[..2] {
        let reference =
            references(&scene, std::slice::from_ref(state), &settings, Paths::Gather).swap_remove(0);
        let played = evaluate(&images, &on_bases(&basis, state));
        let error = relative_l2(&played, &reference.radiance);
        assert!(error < 0.003, "{error}");
        let glowing = reference
            .radiance
            .iter()
            .filter(|pixel| pixel[0] >= 0.5 && pixel[1] >= 0.4 && pixel[2] >= 0.3)
            .count();
        assert!(glowing > 50, "{glowing}");
    }
}

/// A texture that multiplies the diffuse colour of materials that vary is baked in: as exact as without,
/// whatever the colours become.
#[test]
fn textured_materials_vary_as_exactly_as_plain_ones() {
    let texels =
        (0..16).map(|i| [(i * 16) as u8, 255 - (i * 13) as u8, ((i * 71) % 256) as u8, 255]).collect();
    let texture = std::sync::Arc::new(Texture {
        size: [4, 4],
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Linear,
        texels,
    });
    for (mut scene, bases) in [(with_two_reflections("cornell-knot"), 9), (in_ggx(), 12)] {
        for material in scene.materials.iter_mut().filter(|m| m.name == "walls") {
            material.texture = Some(texture.clone());
        }
        // Quads have texture coordinates; the colours that arrive must differ from those without the texture.
        let settings = settings(48, 64, bases, 1);
        let (median, worst) = errors(&scene, &settings, false);
        println!("textured, {bases} bases: median {:.4} %, worst {:.4} %", 100.0 * median, 100.0 * worst);
        assert!(median <= 0.0015 && worst <= 0.005, "{bases} bases: {median}, {worst}");
        let plain = render(&with_two_reflections("cornell-knot"), settings.size, 16, 2, Paths::Gather, 1);
        assert!(
            relative_l2(&render(&scene, settings.size, 16, 2, Paths::Gather, 1).radiance, &plain.radiance)
                > 0.05
        );
    }
}

/// Two lamps of different colours and three materials that vary: everything is RGB then.
#[test]
fn coloured_lights_and_three_materials() {
    let mut scene = with_two_reflections("cornell-knot");
    let red = scene.materials.iter().position(|m| m.name == "red").unwrap();
    scene.vary.materials.push(red);
    let mut lamp = scene.lights[0].clone();
    lamp.name = "green".into();
    lamp.emitter = Emitter::Point { position: [-0.6, 1.2, 0.6], intensity: [0.2, 1.5, 0.4], cone: None };
    scene.lights.push(lamp);
    assert_eq!(transfer_images::chromaticity(&scene), None);
    let (median, worst) = errors(&scene, &settings(32, 64, 9, 1), true);
    assert!(median <= 0.0005 && worst <= 0.003, "{median}, {worst}");
}

/// Against independent samples, what differs is noise and the error of the basis, and the stored variances
/// say how much noise.
#[test]
fn independent_samples_differ_by_noise_only() {
    let scene = with_two_reflections("cornell-knot");
    let (ours, theirs) = (settings(48, 256, 9, 1), settings(48, 256, 9, 2));
    let (basis, images) = bake(&scene, &ours, true);
    let states = states(&scene);
    let own = references(&scene, &states, &ours, Paths::Gather);
    let other = references(&scene, &states, &theirs, Paths::Gather);
    for ((state, own), other) in states.iter().zip(&own).zip(&other) {
        let x = evaluate(&images, &on_bases(&basis, state));
        let squared =
            |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        let difference: f64 = x
            .iter()
            .flatten()
            .zip(other.radiance.iter().flatten())
            .map(|(a, b)| f64::from(a - b).powi(2))
            .sum();
        let noise: f64 = own.variance.iter().chain(&other.variance).flatten().map(|v| f64::from(*v)).sum();
        let bound = 1.2 * noise + 0.003f64.powi(2) * squared(&other.radiance);
        assert!(difference <= bound, "{difference} above {bound}");
    }
}

/// The coverage of each pixel's fragments adds up to the whole pixel, and silhouettes have more than one.
#[test]
fn fragments_cover_every_pixel() {
    let (_, images) = bake(&with_two_reflections("cornell-knot"), &settings(64, 64, 4, 1), true);
    let mut covered = vec![0.0; 64 * 64];
    let mut count = vec![0; 64 * 64];
    for (pixel, coverage) in images.head.pixel.iter().zip(&images.head.coverage) {
        covered[*pixel as usize] += coverage.to_f64();
        count[*pixel as usize] += 1;
    }
    assert!(covered.iter().all(|c| (c - 1.0f64).abs() < 1e-3));
    let silhouettes = count.iter().filter(|n| **n > 1).count();
    assert!(silhouettes > 100 && silhouettes < 1000, "{silhouettes} pixels show two classes");
}

/// A bake of direct light is the reference of one reflection.
#[test]
fn one_reflection_is_direct_light() {
    let mut scene = with_two_reflections("cornell-knot");
    scene.reflections = 1;
    let settings = settings(32, 64, 9, 1);
    let (basis, images) = bake(&scene, &settings, true);
    let materials: Vec<_> = scene.vary.materials.iter().map(|m| scene.materials[*m].brdf).collect();
    let direct = render(&scene, settings.size, settings.samples, 1, Paths::Gather, settings.seed);
    assert!(relative_l2(&evaluate(&images, &on_bases(&basis, &materials)), &direct.radiance) < 0.002);
}
