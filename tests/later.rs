//! All reflections of transfer-images: third and later ones by effective albedos.

use crate::support::images::{bake, bake_by, gathering, in_state, on_bases, settings};
use crate::support::{job, library_scene, relative_l2, render, scene};
use glam::Vec3A;
use half::f16;
use relume_bake::methods::transfer_images::albedo_errors::albedo_errors;
use relume_bake::methods::transfer_images::later::albedos;
use relume_bake::methods::transfer_images::{held_out, space_for};
use relume_bake::trace::reference::{Paths, early_radiance_of, later_radiance_of};
use relume_bake::trace::spot::Spot;
use relume_bake::trace::tile_counts::TileCounts;
use relume_formats::Place;
use relume_formats::basis::Angles;
use relume_formats::container::Stored as _;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::TransferImages;
use relume_formats::kinds::brdf_basis::MAX_BASES;
use relume_formats::kinds::transfer_images::codes::step_of;
use relume_formats::kinds::transfer_images::{FirstReflection, Image, Later};
use relume_formats::state::{BlinnPhong, Brdf, Model, Rgb};
use relume_scenes::{ALL_REFLECTIONS, Emitter, Light, Scene};
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

fn matt(kd: Rgb) -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd, ks: [0.0; 3], shininess: 1.0 })
}

/// The inside of a box that emits 2 and whose material varies.
fn closed_room() -> Scene {
    let mut scene = scene(
        "[vary]\nmaterials = ['m']\n[camera]\nposition = [0.1, 0.2, 0.3]\ntarget = [0, 0.1, -1]\nfov_deg = 60\n\
         [render]\nsize = [12, 12]\nreflections = 'all'\n[materials.m]\nbrdf = 'blinn-phong'\nkd = [0.5, 0.5, 0.5]\n\
         [[object]]\nname = 'box'\nmaterial = 'm'\nshape = 'box'\ntransform = { scale = 2.0 }\n",
    );
    let mesh = Arc::make_mut(&mut scene.objects[0].mesh);
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh.normals.iter_mut().flatten().for_each(|x| *x = -*x);
    scene.lights.push(Light {
        name: "walls".to_owned(),
        emitter: Emitter::Mesh { object: 0, radiance: [2.0; 3], glow: None },
    });
    scene
}

fn mean(image: &[Rgb]) -> [f64; 3] {
    std::array::from_fn(|k| image.iter().map(|pixel| f64::from(pixel[k])).sum::<f64>() / image.len() as f64)
}

/// A room that reflects the share a of the light that it emits shows L / (1 − a) everywhere: white of 0.95,
/// black, and each channel for itself. Beyond 0.95 it gets no brighter.
#[test]
fn closed_rooms_show_all_their_light_and_no_more() {
    let scene = closed_room();
    assert_eq!(scene.reflections, ALL_REFLECTIONS);
    let (basis, images) = bake(&scene, &settings(12, 256, 4, 1), true);
    let later = images.head.later.as_ref().unwrap();
    // All that leaves the walls meets them again.
    assert!(later.returns.iter().all(|share| (share - 1.0).abs() < 0.02), "{:?}", later.returns);
    for kd in [[0.95; 3], [0.8; 3], [0.3; 3], [0.0; 3], [0.9, 0.5, 0.0]] {
        let shown = mean(&evaluate(&images, &on_bases(&basis, &[matt(kd)])));
        for (shown, kd) in shown.iter().zip(kd) {
            let expected = 2.0 / (1.0 - f64::from(kd));
            println!("{kd}: {shown:.4}, expected {expected:.4}");
            // Paths go on by chance 0.95: about as many reflections as their spread, over 36,864 paths, is
            // half a per cent of 20; halves and bases are another tenth.
            assert!((shown / expected - 1.0).abs() < 0.02, "{kd}: {shown}, expected {expected}");
        }
    }
    let [white, brighter] =
        [0.95, 1.0].map(|kd| mean(&evaluate(&images, &on_bases(&basis, &[matt([kd; 3])])))[0]);
    // The first two reflections alone know that it is whiter.
    assert!(brighter < white * 1.06, "{brighter} {white}");
}

/// Light that is fixed does not depend on states, and every path has it: against the reference on paths of
/// its own, in states where albedos are exact, matt ones.
#[test]
fn matt_rooms_are_those_of_the_path_tracer() {
    let scene = library_scene("cornell-knot");
    let (basis, images) = bake(&scene, &settings(24, 1024, 4, 1), true);
    for state in
        [[[0.7, 0.5, 0.2], [0.6, 0.6, 0.6]], [[0.1, 0.8, 0.9], [0.9, 0.9, 0.9]], [[0.0; 3], [0.5; 3]]]
    {
        let state = state.map(matt);
        let shown = evaluate(&images, &on_bases(&basis, &state));
        let [a, b] = [5, 6].map(|seed| {
            render(&in_state(&scene, &state), [24, 24], 1024, u32::MAX, Paths::Best, seed).radiance
        });
        let lacking = render(&in_state(&scene, &state), [24, 24], 1024, 2, Paths::Best, 5).radiance;
        let (noise, error) = (relative_l2(&a, &b), relative_l2(&shown, &a));
        println!(
            "noise {:.2} %, error {:.2} %, two reflections {:.2} %",
            100.0 * noise,
            100.0 * error,
            100.0 * relative_l2(&lacking, &a)
        );
        assert!(error < 2.0 * noise + 0.01 && relative_l2(&lacking, &a) > 2.0 * error, "{error} {noise}");
    }
}

/// On the same paths, the images of two reflections are the same but for the steps that they are rounded to,
/// which are larger in a brighter picture, and files without the others have not a byte of them.
#[test]
fn other_images_are_those_of_two_reflections() {
    let (scene, settings) = (library_scene("cornell-knot"), settings(16, 8, 4, 1));
    let basis = space_for(&scene, settings.bases).unwrap().basis(settings.bases);
    let [two, all] = gathering(&scene, &settings, |gather| {
        [2, ALL_REFLECTIONS]
            .map(|reflections| bake_by(&Scene { reflections, ..scene.clone() }, &settings, &basis, gather))
    });
    assert!(two.head.later.is_none() && all.head.later.is_some());
    let (a, b) = (two.head.layout(), all.head.layout());
    for image in &two.images {
        let slot = &a.slots[image.slot];
        let at = b.slots.iter().position(|s| (s.eye_basis, s.first) == (slot.eye_basis, slot.first)).unwrap();
        let other = all.images.iter().find(|image| image.slot == at).unwrap();
        let fragments = two.head.meta.editable_fragments as usize;
        // Fixed fragments share slots in another order.
        let (n, m) = (two.head.fragments_of(slot), all.head.fragments_of(&b.slots[at]));
        let [scale, other_scale] = [two.head.scales[image.slot], all.head.scales[at]];
        let step = |image: &Image, scale: f32| 2f32.powi(i32::from(step_of(&image.values)) - 24) * scale;
        let step = step(image, scale).max(step(other, other_scale));
        for channel in 0..slot.channels() {
            for i in 0..fragments {
                let x = image.values[channel * n + i].to_f32() * scale;
                let y = other.values[channel * m + i].to_f32() * other_scale;
                assert!((x - y).abs() <= step, "{slot:?}: {x} {y}");
            }
        }
    }
    // And they come back from their files.
    for images in [two, all] {
        let bytes = images.to_bytes(Place::file("images")).unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a"), &bytes).unwrap();
        assert_eq!(TransferImages::read_file(&folder.path().join("a")).unwrap(), images);
    }
}

/// The hemispherical reflectance of basis functions, put together, is that of the material: matt ones reflect
/// kd, and a lobe what a million pairs of directions find.
#[test]
fn albedos_of_bases_make_those_of_materials() {
    let basis = relume_bake::brdf::basis::build(Model::BlinnPhong, 12, true).unwrap();
    let albedos = albedos(&basis);
    assert!((albedos[0] - 1.0).abs() < 1e-5, "{albedos:?}");
    for shininess in [1.0, 20.0, 150.0] {
        let material = BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess };
        let on_basis = basis.coefficients_of(&Brdf::BlinnPhong(material)).unwrap();
        let found: f32 = on_basis.iter().zip(&albedos).map(|(c, a)| c[0] * a).sum();
        let expected = hemispherical_albedo(&material);
        println!("s = {shininess}: {found:.4}, expected {expected:.4}");
        assert!((f64::from(found) / expected - 1.0).abs() < 0.01, "{shininess}: {found} {expected}");
    }
}

/// By midpoints over the half vectors of each outgoing direction: dωᵢ = 4 cos θ_d dω_h.
fn hemispherical_albedo(material: &BlinnPhong) -> f64 {
    use glam::DVec3;
    const N: usize = 100;
    let middle = |i: usize| (i as f64 + 0.5) / N as f64;
    let mut sum = 0.0;
    for o in 0..N {
        // Cosine-weighted: cos² θ is even.
        let cos_out = middle(o).sqrt();
        let outgoing = DVec3::new((1.0 - cos_out * cos_out).sqrt(), 0.0, cos_out);
        for h in 0..N {
            // (s + 2)/2π cosˢ⁺¹ δ dω_h is even in u = cosˢ⁺² δ, and so crowds towards the peak.
            let cos_half = middle(h).powf(1.0 / (f64::from(material.shininess) + 2.0));
            let sin_half = (1.0 - cos_half * cos_half).sqrt();
            for a in 0..N {
                let azimuth = std::f64::consts::PI * middle(a);
                let half = DVec3::new(sin_half * azimuth.cos(), sin_half * azimuth.sin(), cos_half);
                let cos_difference = half.dot(outgoing);
                let incoming = half * (2.0 * cos_difference) - outgoing;
                if cos_difference > 0.0 && incoming.z > 0.0 {
                    sum += incoming.z * 4.0 * cos_difference / cos_half;
                }
            }
        }
    }
    sum / (N * N * N) as f64
}

/// In a state of a single material that reflects so much that it counts as the brightest node, later light is what
/// each path makes of that albedo, of two functions at the surface before the eye's, and of the bases that the
/// eye's surface keeps of either.
#[test]
fn images_are_what_paths_make_of_albedos_and_two_functions() {
    let mut scene = library_scene("cornell-knot");
    // The walls.
    scene.vary.materials.remove(0);
    let settings = settings(24, 32, 9, 1);
    let material = Brdf::BlinnPhong(BlinnPhong { kd: [0.9, 0.8, 0.9], ks: [0.5; 3], shininess: 40.0 });
    let varying = scene.vary.materials[0];
    gathering(&scene, &settings, |gather| {
        let basis = space_for(&scene, settings.bases).unwrap().basis(settings.bases);
        let images = bake_by(&scene, &settings, &basis, gather);
        let later = images.head.later.as_ref().unwrap();
        let coefficients = on_bases(&basis, &[material]);
        assert_eq!(later.albedos_of(&coefficients), [[0.95; 3]]);
        let shown = evaluate(&images, &coefficients);

        let fixed = |spot: &Spot, angles: &Angles| {
            relume_bake::brdf::evaluate(&scene.materials[spot.material as usize].brdf, spot.albedo, angles)
        };
        let functions = |from: usize, to: usize, spot: &Spot, angles: &Angles, less: bool| {
            if spot.material as usize != varying {
                return if less { Vec3A::ZERO } else { fixed(spot, angles) };
            }
            let mut values = [0.0; MAX_BASES];
            basis.evaluate(angles, &mut values[..settings.bases]);
            let value = |k: usize| values[k] - if less { later.albedos[k] * FRAC_1_PI } else { 0.0 };
            (from..to).map(|k| Vec3A::from(coefficients[0][k]) * value(k)).sum()
        };
        let on = |to: usize| move |spot: &Spot, angles: &Angles| functions(0, to, spot, angles, false);
        let beyond = |spot: &Spot, angles: &Angles| functions(1, 3, spot, angles, true);
        let matt = |spot: &Spot, angles: &Angles| match spot.material as usize == varying {
            true => Vec3A::splat(0.95 * FRAC_1_PI),
            false => fixed(spot, angles),
        };
        let of_pixel = |pixel: u32| {
            let mut sum = Vec3A::ZERO;
            let samples = gather.samples(pixel, settings.samples);
            gather.pixel(pixel, samples, |path| {
                sum += early_radiance_of(path, on(9));
                sum +=
                    later_radiance_of(path, on(5), matt, matt) + later_radiance_of(path, on(2), beyond, matt);
            });
            (sum / samples as f32).to_array()
        };
        let expected: Vec<Rgb> = (0..24 * 24).map(of_pixel).collect();
        let without: Vec<Rgb> = evaluate(&without_lobes(&images), &coefficients);
        let [error, lobes] = [&shown, &without].map(|image| relative_l2(image, &expected));
        println!("{error:.1e}, without lobes {lobes:.1e}");
        // Steps of 256ths of the middle of the picture, of which 27 images of later light err by half at most.
        assert!(error < 5e-4 && lobes > 20.0 * error, "{error} {lobes}");
    });
}

/// The same images, those of lobes black.
fn without_lobes(images: &TransferImages) -> TransferImages {
    let layout = images.head.layout();
    let mut dark = images.clone();
    for image in &mut dark.images {
        if matches!(layout.slots[image.slot].first, FirstReflection::LaterLobe { .. }) {
            image.values.fill(f16::ZERO);
        }
    }
    dark
}

/// In rooms of which a material shines, albedos alone are off by more than twice as much as with two functions of the
/// surface before the eye's.
#[test]
fn two_functions_of_the_surface_before_halve_the_error_of_albedos() {
    let scene = library_scene("cornell-knot");
    let settings = settings(48, 512, 6, 1);
    let (basis, images) = bake(&scene, &self::settings(48, 2, 6, 1), true);
    let with = images.head.later.clone().unwrap();
    let without = Later { lobes: 0, lobe_eye_bases: 0, ..with.clone() };
    let pixels = held_out::one_pixel_in(2, settings.size);
    let [with, without] = gathering(&scene, &settings, |gather| {
        [&with, &without].map(|later| {
            albedo_errors(&scene, gather, (&basis, later), settings.samples, &pixels, &job())
                .unwrap()
                .unwrap()
        })
    });
    println!("{with:?}, without {without:?}");
    assert!(2.0 * with.median < without.median && with.median < 0.02, "{with:?} {without:?}");
}

/// Lobes are stored where light that has been about meets materials that vary, and not in a hall where a tenth of
/// the picture does; nor where materials may be sharper than usual, for there the ripples of a few functions are
/// dark dots beside highlights.
#[test]
fn lobes_are_kept_where_they_change_pictures() {
    for (name, lobes) in [("cornell-knot", 2), ("ring", 2), ("statue-hall", 0)] {
        for seed in [1, 2] {
            let (_, images) = bake(&library_scene(name), &settings(64, 2, 6, seed), true);
            let later = images.head.later.as_ref().unwrap();
            assert_eq!((later.lobes, later.lobe_eye_bases), (lobes, lobes), "{name} {seed}");
        }
    }
    // By as many paths, whatever those of the bake are.
    let (scene, settings) = (library_scene("cornell-knot"), settings(64, 2, 6, 1));
    let basis = space_for(&scene, settings.bases).unwrap().basis(settings.bases);
    let images = gathering(&scene, &settings, |gather| {
        let single = TileCounts::new(settings.size, 16, vec![1; 16]);
        bake_by(&scene, &settings, &basis, &gather.clone().counted_by(single))
    });
    assert_eq!(images.head.later.as_ref().unwrap().lobes, 2);
    let mut sharper = scene;
    sharper.vary.shininess_max = Some(2000.0);
    let (_, images) = bake(&sharper, &settings, true);
    assert_eq!(images.head.later.as_ref().unwrap().lobes, 0);
}

/// What the bake says of its albedos is what they are off by, and of its images what bases and halves are.
#[test]
fn bakes_tell_the_error_of_albedos_apart() {
    let scene = library_scene("cornell-knot");
    let settings = settings(48, 256, 6, 1);
    let (basis, images) = bake(&scene, &settings, true);
    let pixels = held_out::one_pixel_in(2, settings.size);
    let later = images.head.later.as_ref().unwrap();
    let (of_bases, of_nodes, of_albedos) = gathering(&scene, &settings, |gather| {
        let of_bases = held_out::measure(&scene, gather, &settings, &basis, &images, &job()).unwrap();
        let of_nodes = held_out::measure_nodes(&scene, gather, &settings, &basis, &images, &job()).unwrap();
        let of_albedos = albedo_errors(&scene, gather, (&basis, later), 256, &pixels, &job()).unwrap();
        (of_bases.unwrap(), of_nodes.unwrap(), of_albedos.unwrap())
    });
    println!("{of_bases:?} {of_nodes:?} {of_albedos:?}");
    // Six bases are off by what they are with two reflections; nodes, and four of the bases, by some per cent
    // of what was reflected more often, which is up to half of a state's light.
    assert!(of_bases.median < 0.006 && of_bases.worst < 0.015, "{of_bases:?}");
    assert!(of_nodes.median < 0.02 && of_nodes.worst < 0.04, "{of_nodes:?}");
    // A fifth of the light is in later reflections, and states that send back more than they get are random,
    // too.
    assert!(
        of_albedos.median > 0.005 && of_albedos.median < 0.08 && of_albedos.worst < 0.4,
        "{of_albedos:?}"
    );
}
