//! The player's shaders against `evaluate`, on a real bake.

use crate::support::{job, library_scene};
use relume_bake::bundle::{self, Leftover};
use relume_bake::methods::transfer_images::{Bases, Wanted, held_out};
use relume_formats::container::Stored;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{MaterialState, State};

#[test]
fn shaders_equal_evaluate() {
    let folder = tempfile::tempdir().unwrap();
    let wanted = Wanted { size: [96, 64], samples: 16, seed: 5, bases: Bases::Number(6) };
    let scene = library_scene("cornell-knot");
    bundle::run(&scene, &[Box::new(wanted)], wanted.size, folder.path(), Leftover::Refuse, &job()).unwrap();
    let images = TransferImages::read_file(&folder.path().join("transfer-images.relume")).unwrap();
    let basis = BrdfBasis::read_file(&folder.path().join("brdf-basis.relume")).unwrap();
    for number in 0..8 {
        let materials = held_out::random_state(number, &scene);
        let named = images.head.meta.materials.iter().cloned().zip(materials.iter().map(|m| MaterialState::from(*m)));
        let state = State { materials: named.collect(), ..State::default() };
        let (size, gpu) = match relume_player::render_once(folder.path(), &state, None) {
            Ok(image) => image,
            Err(error) if std::env::var_os("RELUME_REQUIRE_GPU").is_none() && error.to_string().contains("no GPU adapter") => {
                println!("skipped: {error}; set RELUME_REQUIRE_GPU=1 to make this a failure");
                return;
            }
            Err(error) => panic!("{error}"),
        };
        assert_eq!(size, wanted.size);
        let on_bases: Vec<_> = materials.iter().map(|m| basis.coefficients_of(m).unwrap()).collect();
        let cpu = evaluate(&images, &on_bases);
        let largest = cpu.iter().flatten().fold(0.0f32, |m, v| m.max(v.abs()));
        let difference = cpu.iter().flatten().zip(gpu.iter().flatten()).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
        assert!(difference <= 1e-5 * largest, "state {number}: {difference} of {largest}");
    }
}
