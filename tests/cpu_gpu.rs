//! The player's shaders against `evaluate`, on a real bake.

use crate::support::relit::BALL;
use crate::support::{job, library_scene, scene};
use relume_bake::bundle;
use relume_bake::methods::sparse_transfer;
use relume_bake::methods::transfer_images::{Bases, TransferImagesMethod, held_out};
use relume_bake::unfinished::Leftover;
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::{lights, radiance};
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{BrdfBasis, Environment, SparseTransfer, TransferImages};
use relume_formats::state::{EnvironmentState, MaterialState, State};
use relume_scenes::{ALL_REFLECTIONS, Scene};

#[test]
fn shaders_equal_evaluate() {
    for reflections in [2, ALL_REFLECTIONS] {
        expect_equal_shaders(&Scene { reflections, ..library_scene("cornell-knot") });
    }
}

fn expect_equal_shaders(scene: &Scene) {
    let folder = tempfile::tempdir().unwrap();
    let wanted = TransferImagesMethod {
        size: [96, 64],
        samples: 16,
        seed: 5,
        bases: Bases::Number(6),
        filter: true,
        noise: None,
    };
    bundle::run(scene, &[Box::new(wanted)], wanted.size, folder.path(), Leftover::Refuse, 0, &job()).unwrap();
    let images = TransferImages::read_file(&folder.path().join("transfer-images.relume")).unwrap();
    assert_eq!(images.head.later.is_some(), scene.reflections == ALL_REFLECTIONS);
    let basis = BrdfBasis::read_file(&folder.path().join("brdf-basis.relume")).unwrap();
    for number in 0..8 {
        let materials = held_out::random_state(number, scene);
        let named =
            images.head.meta.materials.iter().cloned().zip(materials.iter().map(|m| MaterialState::from(*m)));
        let state = State { materials: named.collect(), ..State::default() };
        let (size, gpu) = match relume_player::render_once(folder.path(), &state, None) {
            Ok(image) => image,
            Err(error)
                if std::env::var_os("RELUME_REQUIRE_GPU").is_none()
                    && error.to_string().contains("no GPU adapter") =>
            {
                println!("skipped: {error}; set RELUME_REQUIRE_GPU=1 to make this a failure");
                return;
            }
            Err(error) => panic!("{error}"),
        };
        assert_eq!(size, wanted.size);
        let on_bases: Vec<_> = materials.iter().map(|m| basis.coefficients_of(m).unwrap()).collect();
        let cpu = evaluate(&images, &on_bases);
        let largest = cpu.iter().flatten().fold(0.0f32, |m, v| m.max(v.abs()));
        let difference =
            cpu.iter().flatten().zip(gpu.iter().flatten()).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
        assert!(difference <= 1e-5 * largest, "state {number}: {difference} of {largest}");
    }
}

/// The radiance of every vertex, light resampled and transformed on the GPU, in a bake of direct light and in
/// one with a bounce.
#[test]
fn relit_vertices_equal_evaluate() {
    for reflections in [1, 2] {
        let folder = tempfile::tempdir().unwrap();
        let scene =
            Scene { reflections, ..scene(&format!("{BALL} file = 'clear-sky'\n others = ['lamps']\n")) };
        let settings =
            sparse_transfer::Settings { rays_per_texel: 1, terms: sparse_transfer::Terms::Number(90) };
        let wanted = sparse_transfer::SparseTransferMethod { settings };
        bundle::run(&scene, &[Box::new(wanted)], scene.size, folder.path(), Leftover::Refuse, 0, &job())
            .unwrap();
        let transfer = SparseTransfer::read_file(&folder.path().join("sparse-transfer.relume")).unwrap();
        for (number, map, gain, rotation_deg) in [
            (0, "clear-sky", [1.0; 3], 0.0),
            (1, "lamps", [0.5, 2.0, 1e4], 123.4),
            (0, "clear-sky", [0.0; 3], -45.0),
        ] {
            let change = EnvironmentState {
                map: Some(map.to_owned()),
                rotation_deg: Some(rotation_deg),
                gain: Some(gain),
            };
            let state = State { environment: Some(change), ..State::default() };
            let gpu = match relume_player::render_vertices(folder.path(), "sparse-transfer", &state, None) {
                Ok(radiance) => radiance,
                Err(error)
                    if std::env::var_os("RELUME_REQUIRE_GPU").is_none()
                        && error.to_string().contains("no GPU adapter") =>
                {
                    println!("skipped: {error}; set RELUME_REQUIRE_GPU=1 to make this a failure");
                    return;
                }
                Err(error) => panic!("{error}"),
            };
            let map = Environment::read_file(&folder.path().join(format!("environment-{number}.relume")))
                .unwrap()
                .map;
            let look = EnvironmentLook { map: String::new(), gain, rotation_deg };
            let cpu = radiance(&transfer, &lights(&map, &look, &transfer.meta));
            for channel in 0..3 {
                let largest = cpu.iter().fold(0.0f32, |m, v| m.max(v[channel].abs()));
                let difference =
                    cpu.iter().zip(&gpu).fold(0.0f32, |m, (a, b)| m.max((a[channel] - b[channel]).abs()));
                assert!(
                    difference <= 1e-4 * largest,
                    "{reflections} reflections, {rotation_deg}°: {difference} of {largest}"
                );
            }
        }
    }
}
