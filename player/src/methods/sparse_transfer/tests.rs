//! The GPU against the CPU: light, sums, and pictures of which every pixel is known.

use super::*;
use crate::gpu::Readback;
use crate::stream::{Animations, Event, Limits, Playlist, Source};
use crate::support::sparse::{self, Bundle};
use crate::support::{gpu_there, largest_difference};
use relume_formats::evaluate;
use relume_formats::kinds::SparseTransfer as Rows;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::state::{Camera, Film as FilmPlane};

fn gpu() -> Option<Gpu> {
    let there = gpu_there(|| crate::gpu::list().map(|_| ()).map_err(|e| e.to_string()));
    there.then(|| Gpu::open(None).unwrap())
}

/// The method, and the sections of its files after the first `blocks` blocks.
fn load(gpu: &Gpu, bundle: &Bundle, blocks: usize) -> (SparseTransfer, Vec<Arrival>) {
    let source = Source::start(Playlist::of(bundle.folder(), None, Animations::Only(None)).unwrap(), Limits::default()).unwrap();
    let setup = Setup { scene: bundle.scene.clone(), place: Place::file("scene"), size: None };
    let (mut method, mut later) = (SparseTransfer::new(setup).unwrap(), Vec::new());
    loop {
        match source.poll().unwrap() {
            Event::Waiting => std::thread::yield_now(),
            Event::Section(arrival) if arrival.kind == Kind::Scene => {}
            Event::Section(arrival) if method.pieces().arrived() == blocks && method.maps.is_some() => later.push(arrival),
            Event::Section(arrival) => method.section_arrived(gpu, arrival).unwrap(),
            Event::End { .. } => return (method, later),
        }
    }
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

/// Submits a frame; returns the labels of its passes.
fn draw(gpu: &Gpu, method: &mut SparseTransfer, look: &Look) {
    method.update(gpu, look).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut passes = Passes::new(&mut encoder, None);
    method.encode(&mut passes);
    passes.finish();
    gpu.queue.submit([encoder.finish()]);
}

fn film(gpu: &Gpu, method: &SparseTransfer) -> Vec<Rgb> {
    let bands = &method.film().unwrap().bands;
    let film = Readback::new(gpu, bands).radiance(gpu, bands).unwrap();
    gpu.check().unwrap();
    film
}

fn light(gpu: &Gpu, method: &SparseTransfer, gain: Rgb) -> Vec<Rgb> {
    let source = method.stage.as_ref().unwrap().light().coefficients();
    let light = Readback::new(gpu, [source]).radiance(gpu, [source]).unwrap();
    light.into_iter().map(|l| std::array::from_fn(|k| l[k] * gain[k])).collect()
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
            for (rotation_deg, gain) in [(0.0, [1.0; 3]), (33.3, [0.5, 2.0, 0.0]), (180.0, [1e3; 3]), (-90.0, [1e-3, 1.0, 7.0])] {
                let environment = environment(map, rotation_deg, gain);
                draw(&gpu, &mut method, &look(&bundle, &environment));
                let expected = evaluate::sparse_transfer::light(bundle.map(map), &environment, n as usize);
                let what = format!("{n} texels a side, rgb {rgb}, {environment:?}");
                expect_near(&light(&gpu, &method, gain), &transposed(&expected), 1e-5, &what);
                let expected = evaluate::sparse_transfer::radiance(&bundle.transfer, &expected);
                expect_near(&method.vertex_radiance(&gpu).unwrap(), &expected, 1e-4, &what);
            }
        }
    }
}

#[test]
fn faces_of_any_size_are_transformed() {
    let Some(gpu) = gpu() else { return };
    for n in [1, 2, 4, 8, 32] {
        let bundle = Bundle::of(sparse::scene([3, 3]), sparse::maps(), None, sparse::even_transfer(9, n, 1.0));
        let mut method = load_all(&gpu, &bundle);
        let environment = environment("noise", 12.0, [1.0; 3]);
        draw(&gpu, &mut method, &look(&bundle, &environment));
        let expected = evaluate::sparse_transfer::light(bundle.map("noise"), &environment, n as usize);
        expect_near(&light(&gpu, &method, [1.0; 3]), &transposed(&expected), 1e-5, &format!("{n}"));
    }
}

#[test]
fn every_prefix_of_blocks_plays() {
    let Some(gpu) = gpu() else { return };
    let environment = environment("sun", 70.0, [1.0; 3]);
    for rgb in [false, true] {
        let bundle = Bundle::write(16, rgb);
        let coefficients = evaluate::sparse_transfer::light(bundle.map("sun"), &environment, 16);
        let (mut method, later) = load(&gpu, &bundle, 1);
        let mut later = later.into_iter();
        for blocks in 1..=bundle.transfer.blocks.len() {
            while method.pieces().arrived() < blocks {
                method.section_arrived(&gpu, later.next().unwrap()).unwrap();
            }
            draw(&gpu, &mut method, &look(&bundle, &environment));
            let expected = evaluate::sparse_transfer::radiance(&prefix(&bundle.transfer, blocks), &coefficients);
            expect_near(&method.vertex_radiance(&gpu).unwrap(), &expected, 1e-4, &format!("rgb {rgb}, {blocks} blocks"));
        }
        assert!(method.pieces().missing.is_empty() && later.next().is_none());
        // 77 vertices: 15 terms with an index each, 5 of them wide, 10 of bytes, in 5 blocks with a step each; rows are padded.
        let values = 77 * if rgb { 3 } else { 1 } as u64;
        let rows = (15 + 5) * 156 + 5 * (2 * values).next_multiple_of(4) + 10 * values.next_multiple_of(4);
        assert_eq!(method.pieces().bytes_per_frame, rows);
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
        let (whole_radiance, whole_film) = (whole.vertex_radiance(&gpu).unwrap(), film(&gpu, &whole));
        let limit = gpu.binding_bytes;
        (gpu.binding_bytes, gpu.workgroups_per_dimension) = (3000, 1);
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &look(&bundle, &environment));
        assert_eq!((method.vertex_radiance(&gpu).unwrap(), film(&gpu, &method)), (whole_radiance, whole_film));
        (gpu.binding_bytes, gpu.workgroups_per_dimension) = (limit, 65535);
    }
    gpu.binding_bytes = 300;
    let bundle = Bundle::write(16, false);
    let refused = columns::Columns::new(&gpu, bundle.transfer.meta, &Place::file("rows")).err().unwrap();
    assert!(refused.to_string().contains("use a coarser mesh") && refused.exit_code() == 2, "{refused}");
}

/// A camera so close to the middle of the grid that it sees nothing else.
fn close_up() -> Camera {
    Camera { position: [0.1, 0.05, 0.5], target: [0.1, 0.05, 0.0], fov_deg: 60.0, exposure_ev: 0.0 }
}

#[test]
fn a_surface_shows_radiance_times_albedo() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::of(sparse::scene([5, 4]), sparse::maps(), None, sparse::even_transfer(20, 16, 0.25));
    let mut method = load_all(&gpu, &bundle);
    let gain = [3.0, 1.0, 2.0];
    draw(&gpu, &mut method, &Look { camera: close_up(), ..look(&bundle, &environment("even", 40.0, gain)) });
    // The even light is exact in halves; its cube and the sum over six means are off by some units in the last place.
    let expected: Rgb = std::array::from_fn(|k| 0.25 * [2.0, 1.0, 0.5][k] * gain[k] * sparse::ALBEDO[k]);
    for pixel in film(&gpu, &method) {
        assert!(pixel.iter().zip(expected).all(|(ours, theirs)| (ours - theirs).abs() <= 2e-6 * theirs), "{pixel:?} is not {expected:?}");
    }
    // From behind it hides the sky, and no light is known there.
    let behind = Camera { position: [0.1, 0.05, -0.5], ..close_up() };
    draw(&gpu, &mut method, &Look { camera: behind, ..look(&bundle, &environment("even", 40.0, gain)) });
    assert!(film(&gpu, &method).iter().all(|pixel| *pixel == [0.0; 3]));
}

/// What `seen` makes of the direction of each sample, averaged by pixel.
fn averaged(plane: &FilmPlane, seen: impl Fn([f32; 3]) -> Rgb) -> Vec<Rgb> {
    let [width, height] = sparse::SIZE;
    let pixel = |index: u32| {
        let samples = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        let direction = |[x, y]: [f32; 2]| plane.direction((index % width) as f32 + x, (index / width) as f32 + y);
        let colours = samples.map(|sample| seen(direction(sample).to_array()));
        std::array::from_fn(|k| colours.iter().map(|colour| colour[k]).sum::<f32>() / 4.0)
    };
    (0..width * height).map(pixel).collect()
}

#[test]
fn behind_everything_stands_the_map() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write(16, false);
    let mut method = load_all(&gpu, &bundle);
    let mut brightest: f32 = 0.0;
    for (map, rotation_deg, gain, towards, fov_deg) in [
        ("noise", 0.0, [1.0; 3], [0.0, 0.0, 1.0], 40.0),
        ("noise", 33.3, [0.5, 2.0, 0.0], [5.0, 2.0, 1.0], 100.0),
        ("sun", 180.0, [1.0; 3], [3.0, 8.0, 0.1], 120.0),
        ("sun", -90.0, [1.0; 3], [-4.0, -7.0, 1.0], 60.0),
        ("black", 0.0, [1.0; 3], [0.0, 9.0, 0.0], 90.0),
    ] {
        // So far away that the grid falls between samples.
        let position = [0.0, 0.0, 1e4];
        let target = std::array::from_fn(|k| position[k] + towards[k]);
        let camera = Camera { position, target, fov_deg, exposure_ev: 0.0 };
        draw(&gpu, &mut method, &Look { camera, ..look(&bundle, &environment(map, rotation_deg, gain)) });
        let (sin, cos) = rotation_deg.to_radians().sin_cos();
        let sky = |[x, y, z]: [f32; 3]| {
            let (x, z) = (cos * x - sin * z, cos * z + sin * x);
            let uv = [0.5 + x.atan2(-z) / std::f32::consts::TAU, (x * x + z * z).sqrt().atan2(y) / std::f32::consts::PI];
            let radiance = bundle.map(map).sample(uv);
            std::array::from_fn(|k| radiance[k] * gain[k])
        };
        let expected = averaged(&camera.film(sparse::SIZE[0], sparse::SIZE[1]), sky);
        // Directions differ by some 1e-6 rad, a 20,000th of a texel of the finer map, and radiance by so much of the step between two texels.
        let bound = 5e-5 * bundle.map(map).texels.iter().flatten().fold(0.0, |m: f32, v| m.max(*v)) * gain.into_iter().fold(0.0, f32::max);
        let film = film(&gpu, &method);
        for (ours, theirs) in film.iter().flatten().zip(expected.iter().flatten()) {
            assert!((ours - theirs).abs() <= bound, "{map} {rotation_deg} towards {towards:?}: {ours} is not {theirs}");
        }
        brightest = film.iter().flatten().fold(brightest, |m, v| m.max(*v));
    }
    assert!(brightest > 1e3, "the sun was in the picture: {brightest}");
}

#[test]
fn silhouettes_are_antialiased() {
    let Some(gpu) = gpu() else { return };
    let mut scene = sparse::scene([2, 2]);
    scene.meta.environment = Some(environment("black", 0.0, [1.0; 3]));
    // Turned, so that no edge runs along the pixels.
    let (sin, cos) = 0.3_f32.sin_cos();
    scene.positions.iter_mut().for_each(|[x, y, _]| (*x, *y) = (0.6 * (cos * *x - sin * *y), 0.6 * (sin * *x + cos * *y)));
    let bundle = Bundle::of(scene, sparse::maps(), None, sparse::even_transfer(4, 1, 1.0));
    let mut method = load_all(&gpu, &bundle);
    draw(&gpu, &mut method, &look(&bundle, &environment("even", 0.0, [1.0; 3])));
    let sky = film(&gpu, &method)[0];
    assert!((sky[0] - 2.0).abs() < 1e-5);
    // Of a pixel at a silhouette one, two or three samples of four are on the square, whose red is 0.8 times the sky's.
    let mut counts = [0; 5];
    for pixel in film(&gpu, &method) {
        let samples = (2.0 - pixel[0]) / (2.0 - 1.6) * 4.0;
        assert!((samples - samples.round()).abs() < 1e-3, "{pixel:?}");
        counts[samples.round() as usize] += 1;
    }
    assert!(counts.iter().all(|count| *count >= 3) && counts[4] > 60, "{counts:?}");
    // The square's share of the picture: its area over that of the film at its distance.
    let plane = bundle.scene.meta.camera.film(sparse::SIZE[0], sparse::SIZE[1]).axes();
    let share = (1.2 / 3.0_f32).powi(2) / (4.0 * plane[1].length() * plane[2].length());
    let covered = counts.iter().enumerate().map(|(k, count)| k as f32 * *count as f32).sum::<f32>() / 4.0 / 600.0;
    // Along a perimeter of some 60 samples, an area is known to a fraction of that many samples.
    assert!((covered - share).abs() < 20.0 / 2400.0, "{covered} where {share} was expected");
}

#[test]
fn what_is_nearer_hides_what_is_farther() {
    let Some(gpu) = gpu() else { return };
    // Two squares, the nearer one smaller, and drawn first or last.
    for nearer_first in [true, false] {
        let mut scene = sparse::scene([2, 2]);
        let [near, far] = [(0.2, 0.5), (1.5, 0.0)]
            .map(|(size, z)| scene.positions.iter().map(move |p| [size * p[0], size * p[1], z]).collect::<Vec<_>>());
        let objects = if nearer_first { [near, far] } else { [far, near] };
        scene.positions = objects.concat();
        scene.normals = vec![[0.0, 0.0, 1.0]; 8];
        let second: Vec<_> = scene.triangles.iter().map(|t| t.map(|i| i + 4)).collect();
        scene.triangles.extend(second);
        let dark = relume_formats::state::BlinnPhong { kd: [0.0; 3], ks: [0.0; 3], shininess: 1.0 };
        let mut black = scene.meta.materials[0].clone();
        (black.name, black.brdf) = ("black".to_owned(), relume_formats::state::Brdf::BlinnPhong(dark));
        scene.meta.materials.push(black);
        let mut other = scene.meta.objects[0].clone();
        other.name = "other".to_owned();
        scene.meta.objects.push(other);
        scene.meta.objects[usize::from(!nearer_first)].material = 1;
        let bundle = Bundle::of(scene, sparse::maps(), None, sparse::even_transfer(8, 1, 1.0));
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &look(&bundle, &environment("even", 0.0, [1.0; 3])));
        let film = film(&gpu, &method);
        let [width, height] = sparse::SIZE;
        assert_eq!(film[(height / 2 * width + width / 2) as usize], [0.0; 3], "the nearer square is black");
        assert!((film[(width / 2) as usize][0] - 1.6).abs() < 1e-5, "beside it is the farther one: {:?}", film[(width / 2) as usize]);
    }
}

#[test]
fn textures_colour_surfaces_and_cut_holes() {
    let Some(gpu) = gpu() else { return };
    let scene = sparse::scene([4, 4]);
    let textures = sparse::textures(&scene);
    let bundle = Bundle::of(scene, sparse::maps(), Some(&textures), sparse::even_transfer(16, 4, 1.0));
    let mut method = load_all(&gpu, &bundle);
    let camera = close_up();
    draw(&gpu, &mut method, &Look { camera, ..look(&bundle, &environment("even", 0.0, [1.0; 3])) });
    let MaterialTexture { texture, alpha_cutoff, .. } = &textures.textures[0];
    let (mut holes, even) = (std::cell::Cell::new(0), [2.0, 1.0, 0.5]);
    let seen = |direction: [f32; 3]| {
        let reach = -camera.position[2] / direction[2];
        let [x, y] = [0, 1].map(|k| camera.position[k] + reach * direction[k]);
        let [r, g, b, alpha] = texture.sample([x + 0.3, 0.4 - y]);
        if alpha < alpha_cutoff.unwrap() {
            holes.set(holes.get() + 1);
            return even;
        }
        std::array::from_fn(|k| even[k] * sparse::ALBEDO[k] * [r, g, b][k])
    };
    let expected = averaged(&camera.film(sparse::SIZE[0], sparse::SIZE[1]), seen);
    // Alpha at the very edge of a hole may fall to either side.
    let differ = |(ours, theirs): &(Rgb, &Rgb)| ours.iter().zip(*theirs).any(|(a, b)| (a - b).abs() > 1e-4);
    let differing = film(&gpu, &method).into_iter().zip(&expected).filter(differ).count();
    assert!(differing <= 3, "{differing} pixels differ");
    assert!((100..2000).contains(holes.get_mut()), "{holes:?}");
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
    assert_eq!(stages(&Look { camera: close_up(), ..first.clone() }, Vec::new()), [false, false]);
    assert_eq!(stages(&look(&bundle, &environment("noise", 0.0, [2.0; 3])), Vec::new()), [false, false], "gain is a factor");
    assert_eq!(stages(&look(&bundle, &environment("noise", 5.0, [2.0; 3])), Vec::new()), [true, false]);
    assert_eq!(stages(&look(&bundle, &environment("sun", 5.0, [2.0; 3])), Vec::new()), [true, false]);
    assert_eq!(stages(&look(&bundle, &environment("sun", 5.0, [2.0; 3])), later), [false, true]);
}

#[test]
fn files_that_do_not_belong_together_are_refused() {
    let Some(gpu) = gpu() else { return };
    let refusal = |scene: StoredScene, maps: Vec<Environment>, rows: Rows| {
        let bundle = Bundle::of(scene, maps, None, rows);
        let source = Source::start(Playlist::of(bundle.folder(), None, Animations::Only(None)).unwrap(), Limits::default()).unwrap();
        let setup = Setup { scene: bundle.scene.clone(), place: Place::file("scene"), size: None };
        let mut method = SparseTransfer::new(setup).unwrap();
        loop {
            match source.poll().unwrap() {
                Event::Waiting => std::thread::yield_now(),
                Event::Section(arrival) if arrival.kind == Kind::Scene => {}
                Event::Section(arrival) => {
                    if let Err(error) = method.section_arrived(&gpu, arrival) {
                        assert_eq!(error.exit_code(), 2);
                        return error.to_string();
                    }
                }
                Event::End { .. } => panic!("nothing was refused"),
            }
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
        (refusal(scene(), sparse::maps(), sparse::even_transfer(8, 4, 1.0)), "rows for 8 vertices of a scene of 9"),
        (refusal(dark, sparse::maps(), rows()), "the scene has none"),
        (refusal(elsewhere, sparse::maps(), rows()), "environment map `elsewhere`"),
        (refusal(scene(), twins, rows()), "second environment map called `noise`"),
    ] {
        assert!(message.contains(part), "{message}");
    }
}
