//! The GPU against the CPU: light and sums.

mod ground;
mod pictures;
mod suns;

use super::*;
use crate::Error;
use crate::support::largest_difference;
use crate::support::sparse::{self, Bundle};
use crate::testing::{arrivals, gpu, playlist, read_radiance};
use relume_formats::evaluate;
use relume_formats::kinds::SparseTransfer as Rows;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{Environment, StoredScene};
use relume_formats::state::Camera;

/// The method, and the sections of its files after the first `blocks` blocks.
fn load(gpu: &Gpu, bundle: &Bundle, blocks: usize) -> (SparseTransfer, Vec<Arrival>) {
    let setup =
        Setup { scene: bundle.scene.clone(), settings: playlist(bundle.folder(), None).settings, size: None };
    let (mut method, mut later) = (SparseTransfer::new(gpu, setup).unwrap(), Vec::new());
    for arrival in arrivals(bundle.folder()) {
        if method.pieces().arrived() == blocks && method.maps.is_some() {
            later.push(arrival);
        } else {
            method.section_arrived(gpu, arrival).unwrap();
        }
    }
    (method, later)
}

fn load_all(gpu: &Gpu, bundle: &Bundle) -> SparseTransfer {
    load(gpu, bundle, usize::MAX).0
}

fn environment(map: &str, rotation_deg: f32, gain: Rgb) -> EnvironmentLook {
    EnvironmentLook { map: map.to_owned(), gain, rotation_deg }
}

fn look(bundle: &Bundle, environment: &EnvironmentLook) -> Look {
    Look { environment: Some(environment.clone()), ..Look::default_of(&bundle.scene.meta) }
}

/// Submits a frame.
fn draw(gpu: &Gpu, method: &mut SparseTransfer, look: &Look) {
    method.update(gpu, look).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut passes = Passes::new(&mut encoder, None, 0);
    method.encode(&mut passes);
    passes.finish();
    gpu.queue.submit([encoder.finish()]);
}

fn film(gpu: &Gpu, method: &SparseTransfer) -> Vec<Rgb> {
    let bands = &method.film().unwrap().bands;
    read_radiance(gpu, bands)
}

fn light(gpu: &Gpu, method: &SparseTransfer, gain: Rgb) -> Vec<Rgb> {
    let source = method.stage.as_ref().unwrap().light().coefficients();
    read_radiance(gpu, [source]).into_iter().map(|l| std::array::from_fn(|k| l[k] * gain[k])).collect()
}

/// Radiance by vertex, the gain included.
fn vertices(gpu: &Gpu, method: &SparseTransfer) -> Vec<Rgb> {
    let (buffer, gain) = method.vertex_radiance().unwrap();
    read_radiance(gpu, [buffer]).into_iter().map(|rgb| std::array::from_fn(|k| rgb[k] * gain[k])).collect()
}

/// The first blocks of a bake.
fn prefix(rows: &Rows, blocks: usize) -> Rows {
    Rows { meta: rows.meta.clone(), blocks: rows.blocks[..blocks].to_vec() }
}

fn transposed(planes: &[Vec<f32>; 3]) -> Vec<Rgb> {
    (0..planes[0].len()).map(|i| std::array::from_fn(|k| planes[k][i])).collect()
}

#[track_caller]
fn expect_near(ours: &[Rgb], theirs: &[Rgb], bound: f32, what: &str) {
    if theirs.iter().flatten().all(|v| *v == 0.0) {
        assert_eq!(ours, theirs, "{what}");
    } else {
        let difference = largest_difference(ours, theirs);
        assert!(difference <= bound, "{what}: {difference}");
    }
}

#[test]
fn light_and_radiance_equal_the_cpus_in_any_light() {
    let Some(gpu) = gpu() else { return };
    for (n, rgb) in [(16, false), (16, true), (64, false), (64, true)] {
        let bundle = Bundle::write(n, rgb);
        let mut method = load_all(&gpu, &bundle);
        for map in ["noise", "sun", "black", "even"] {
            for (rotation_deg, gain) in
                [(0.0, [1.0; 3]), (33.3, [0.5, 2.0, 0.0]), (180.0, [1e3; 3]), (-90.0, [1e-3, 1.0, 7.0])]
            {
                let environment = environment(map, rotation_deg, gain);
                draw(&gpu, &mut method, &look(&bundle, &environment));
                let expected =
                    evaluate::sparse_transfer::lights(bundle.map(map), &environment, &bundle.transfer.meta);
                let what = format!("{n} texels a side, rgb {rgb}, {environment:?}");
                expect_near(&light(&gpu, &method, gain), &transposed(&expected), 1e-5, &what);
                let expected = evaluate::sparse_transfer::radiance(&bundle.transfer, &expected);
                expect_near(&vertices(&gpu, &method), &expected, 1e-4, &what);
            }
        }
    }
}

#[test]
fn faces_of_any_size_are_transformed() {
    let Some(gpu) = gpu() else { return };
    for n in [1, 2, 4, 8, 32] {
        let bundle =
            Bundle::of(sparse::scene([3, 3]), sparse::maps(), None, sparse::even_transfer(9, n, 1.0));
        let mut method = load_all(&gpu, &bundle);
        let environment = environment("noise", 12.0, [1.0; 3]);
        draw(&gpu, &mut method, &look(&bundle, &environment));
        let expected =
            evaluate::sparse_transfer::lights(bundle.map("noise"), &environment, &bundle.transfer.meta);
        expect_near(&light(&gpu, &method, [1.0; 3]), &transposed(&expected), 1e-5, &format!("{n}"));
    }
}

#[test]
fn every_prefix_of_blocks_plays() {
    let Some(gpu) = gpu() else { return };
    let environment = environment("sun", 70.0, [1.0; 3]);
    for rgb in [false, true] {
        let bundle = Bundle::write(16, rgb);
        let coefficients =
            evaluate::sparse_transfer::lights(bundle.map("sun"), &environment, &bundle.transfer.meta);
        let (mut method, later) = load(&gpu, &bundle, 1);
        let mut later = later.into_iter();
        for blocks in 1..=bundle.transfer.blocks.len() {
            while method.pieces().arrived() < blocks {
                method.section_arrived(&gpu, later.next().unwrap()).unwrap();
            }
            draw(&gpu, &mut method, &look(&bundle, &environment));
            let expected =
                evaluate::sparse_transfer::radiance(&prefix(&bundle.transfer, blocks), &coefficients);
            expect_near(&vertices(&gpu, &method), &expected, 1e-4, &format!("rgb {rgb}, {blocks} blocks"));
        }
        assert!(method.pieces().missing.is_empty() && later.next().is_none());
        // 77 vertices are two tiles of 64. The blocks are filled up with zeros to 4 and 4 wide terms, and 8, 4
        // and 4 of bytes, each with an index, and there are 5 scales.
        let row = 2 * 64;
        let values = row * if rgb { 3 } else { 1 };
        assert_eq!(method.pieces().bytes_per_frame, row * (5 * 2 + 24 * 2) + values * (8 * 2 + 16));
    }
}

/// More columns than all lanes of a workgroup take at a time, so that each comes back for more.
#[test]
fn lanes_take_turns() {
    let Some(gpu) = gpu() else { return };
    let environment = environment("noise", 40.0, [1.0; 3]);
    for rgb in [false, true] {
        let mut rows = sparse::transfer(77, 16, rgb);
        (rows.meta.blocks, rows.blocks) = (rows.meta.blocks.repeat(9), vec![rows.blocks; 9].concat());
        let bundle = Bundle::of(sparse::scene([11, 7]), sparse::maps(), None, rows);
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &look(&bundle, &environment));
        let meta = &bundle.transfer.meta;
        let light = evaluate::sparse_transfer::lights(bundle.map("noise"), &environment, meta);
        let expected = evaluate::sparse_transfer::radiance(&bundle.transfer, &light);
        expect_near(&vertices(&gpu, &method), &expected, 1e-4, &format!("rgb {rgb}"));
    }
}

#[test]
fn small_bands_and_dispatches_give_the_identical_sum() {
    let Some(mut gpu) = gpu() else { return };
    let environment = environment("noise", 20.0, [1.0; 3]);
    for rgb in [false, true] {
        let bundle = Bundle::write(16, rgb);
        let mut whole = load_all(&gpu, &bundle);
        draw(&gpu, &mut whole, &look(&bundle, &environment));
        let (whole_radiance, whole_film) = (vertices(&gpu, &whole), film(&gpu, &whole));
        let limit = gpu.binding_bytes;
        // A tile a band.
        let tile = whole.pieces().bytes_per_frame / 2;
        (gpu.binding_bytes, gpu.workgroups_per_dimension) = (tile, 1);
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &look(&bundle, &environment));
        assert_eq!((vertices(&gpu, &method), film(&gpu, &method)), (whole_radiance, whole_film));
        (gpu.binding_bytes, gpu.workgroups_per_dimension) = (limit, 65535);
    }
    gpu.binding_bytes = 300;
    let bundle = Bundle::write(16, false);
    let light = gpu.storage("light", &[[0.0_f32; 4]]);
    let refused =
        columns::Columns::new(&gpu, bundle.transfer.meta, &light, &Place::file("rows")).err().unwrap();
    assert!(
        refused.to_string().contains("use a coarser mesh") && matches!(refused, Error::Format(_)),
        "{refused}"
    );
}

#[test]
fn no_more_is_computed_than_has_changed() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write(16, false);
    let (mut method, later) = load(&gpu, &bundle, 1);
    let mut stages = |look: &Look, arrivals: Vec<Arrival>| {
        arrivals.into_iter().for_each(|arrival| method.section_arrived(&gpu, arrival).unwrap());
        method.update(&gpu, look).unwrap();
        let changed = method.stage.as_ref().unwrap().changes();
        draw(&gpu, &mut method, look);
        changed
    };
    let first = look(&bundle, &environment("noise", 0.0, [1.0; 3]));
    assert_eq!(stages(&first, Vec::new()), [true, true]);
    assert_eq!(stages(&first, Vec::new()), [false, false]);
    assert_eq!(stages(&Look { camera: pictures::close_up(), ..first.clone() }, Vec::new()), [false, false]);
    assert_eq!(
        stages(&look(&bundle, &environment("noise", 0.0, [2.0; 3])), Vec::new()),
        [false, false],
        "gain is a factor"
    );
    assert_eq!(stages(&look(&bundle, &environment("noise", 5.0, [2.0; 3])), Vec::new()), [true, false]);
    assert_eq!(stages(&look(&bundle, &environment("sun", 5.0, [2.0; 3])), Vec::new()), [true, false]);
    let last = look(&bundle, &environment("sun", 5.0, [2.0; 3]));
    assert_eq!(stages(&last, later), [false, true]);
    method.resize(&gpu, [31, 7]).unwrap();
    method.update(&gpu, &last).unwrap();
    assert_eq!(method.stage.as_ref().unwrap().changes(), [false, false], "another size");
}

#[test]
fn files_that_do_not_belong_together_are_refused() {
    let Some(gpu) = gpu() else { return };
    let refusal = |scene: StoredScene, maps: Vec<Environment>, rows: Rows| {
        let bundle = Bundle::of(scene, maps, None, rows);
        let setup = Setup {
            scene: bundle.scene.clone(),
            settings: playlist(bundle.folder(), None).settings,
            size: None,
        };
        let mut method = SparseTransfer::new(&gpu, setup).unwrap();
        let refused = arrivals(bundle.folder())
            .into_iter()
            .find_map(|arrival| method.section_arrived(&gpu, arrival).err());
        match refused.expect("something is refused") {
            Error::Format(error) if error.is_bad_input() => error.to_string(),
            other => panic!("{other}"),
        }
    };
    let scene = || sparse::scene([3, 3]);
    let rows = || sparse::even_transfer(9, 4, 1.0);
    let mut dark = scene();
    dark.meta.environment = None;
    let mut elsewhere = scene();
    elsewhere.meta.environment = Some(environment("elsewhere", 0.0, [1.0; 3]));
    let twins = [sparse::maps(), sparse::maps()].concat();
    for (message, part) in [
        (
            refusal(scene(), sparse::maps(), sparse::even_transfer(8, 4, 1.0)),
            "rows for 8 vertices of a scene of 9",
        ),
        (refusal(dark, sparse::maps(), rows()), "the scene has none"),
        (refusal(elsewhere, sparse::maps(), rows()), "environment map `elsewhere`"),
        (refusal(scene(), twins, rows()), "second environment map called `noise`"),
    ] {
        assert!(message.contains(part), "{message}");
    }
}
