//! Pictures of what the filter of transfer-images does, for docs/notes/TRANSFER-IMAGES.md.

use crate::filter::film_of;
use crate::support::images::{bake, gathering, in_state, on_bases, settings, surface_pixels};
use crate::support::{job, library_scene, relative_l2, render, with_two_reflections};
use relume_bake::filter::{Fragment, Watcher, expected_errors, pictures};
use relume_bake::methods::transfer_images::Settings;
use relume_bake::trace::reference::{self, Paths};
use relume_chart::picture::alone;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::{ALL_REFLECTIONS, Scene};
use std::path::Path;

/// Side of a film, pixels.
const SIZE: usize = 256;
/// Side of what is shown of one, pixels, and how many times its size.
const CROP: usize = 56;
const TIMES: usize = 4;
/// Pixels between pictures, and how bright they are.
const GAP: usize = 6;
const GAP_RADIANCE: f32 = 1.0;
/// How far errors are averaged, pixels.
const RADIUS: i32 = 4;

fn write(name: &str, image: &[Rgb], [width, height]: [usize; 2]) {
    let png = alone(image, [width as u32, height as u32], 0.0).unwrap();
    println!("{name}: {width} × {height} pixels, {} kB", png.len() / 1000);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/images");
    std::fs::write(folder.join(format!("{name}.png")), png).unwrap();
}

/// Pictures of `side` × `side` pixels in rows, with gaps between them.
fn grid(rows: &[Vec<Vec<Rgb>>], side: usize) -> (Vec<Rgb>, [usize; 2]) {
    let pitch = side + GAP;
    let size = [rows[0].len() * pitch - GAP, rows.len() * pitch - GAP];
    let mut grid = vec![[GAP_RADIANCE; 3]; size[0] * size[1]];
    for (row, pictures) in rows.iter().enumerate() {
        for (column, picture) in pictures.iter().enumerate() {
            for (y, line) in picture.chunks_exact(side).enumerate() {
                let at = (row * pitch + y) * size[0] + column * pitch;
                grid[at..at + side].copy_from_slice(line);
            }
        }
    }
    (grid, size)
}

/// What is at `corner`, enlarged.
fn zoom(image: &[Rgb], corner: [usize; 2]) -> Vec<Rgb> {
    let side = CROP * TIMES;
    let of = |place: usize| {
        let [x, y] = [place % side, place / side].map(|p| p / TIMES);
        image[(corner[1] + y) * SIZE + corner[0] + x]
    };
    (0..side * side).map(of).collect()
}

/// A highlight and edges, a contact shadow, a texture, a caustic: traced, filtered, and as they are.
#[test]
#[ignore = "takes minutes"]
fn zooms_beside_the_reference() {
    let places: [(&str, &[[usize; 2]]); 3] =
        [("cornell-knot", &[[98, 90], [60, 195]]), ("statue-hall", &[[104, 88]]), ("ring", &[[62, 98]])];
    let mut rows = Vec::new();
    for (name, corners) in places {
        let scene = library_scene(name);
        let materials: Vec<Brdf> = scene.vary.materials.iter().map(|m| scene.materials[*m].brdf).collect();
        let shown = [false, true].map(|filter| {
            let settings = Settings { filter, ..settings(SIZE as u32, 64, 9, 1) };
            let (basis, images) =
                bake(&scene, &settings, !scene.materials.iter().any(|m| m.texture.is_some()));
            evaluate(&images, &on_bases(&basis, &materials))
        });
        let truth = render(&scene, [SIZE as u32; 2], 512, ALL_REFLECTIONS, Paths::Best, 7).radiance;
        let [raw, filtered] = shown;
        assert!(relative_l2(&filtered, &truth) < relative_l2(&raw, &truth), "{name}");
        for corner in corners {
            rows.push([&raw, &filtered, &truth].map(|image| zoom(image, *corner)).to_vec());
        }
    }
    let (image, size) = grid(&rows, CROP * TIMES);
    write("filter-zooms", &image, size);
}

/// Relative errors that the filter expects, and those that it makes, both means over the states that it looks
/// at and over the pixels around.
#[test]
#[ignore = "takes minutes"]
fn expected_errors_beside_true_ones() {
    let scene = with_two_reflections("cornell-knot");
    let settings = Settings { filter: true, ..settings(SIZE as u32, 64, 4, 1) };
    let pixels = surface_pixels(&scene, &settings);
    let film = gathering(&scene, &settings, |gather| film_of(&scene, gather, &settings));
    let mut expected = vec![0.0f64; SIZE * SIZE];
    let shows_surfaces = |fragment: &Fragment| pixels.binary_search(&(fragment.pixel as usize)).is_ok();
    for (fragment, error) in film.fragments().iter().zip(expected_errors(&film, &job()).unwrap()) {
        if shows_surfaces(fragment) {
            expected[fragment.pixel as usize] += f64::from(error) * f64::from(fragment.coverage).powi(2);
        }
    }
    let watcher = Watcher::new(&scene);
    let states: Vec<Scene> = (watcher.states().iter())
        .map(|materials| {
            let varying: Vec<Brdf> = scene.vary.materials.iter().map(|m| materials[*m]).collect();
            in_state(&scene, &varying)
        })
        .collect();
    let Settings { size, samples, seed, .. } = settings;
    let paths =
        reference::Settings { size, samples, seed, reflections: 2, paths: Paths::Gather, target: None };
    let shown = pictures::render(&scene, &states, &paths, &job()).unwrap();
    let mut made = vec![0.0f64; SIZE * SIZE];
    for (state, picture) in states.iter().zip(shown) {
        let truth = [7, 8].map(|seed| render(state, size, 512, 2, Paths::Best, seed).radiance);
        let grey = |image: &[Rgb]| -> Vec<f64> {
            image.iter().map(|pixel| pixel.iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0).collect()
        };
        let [shown, a, b] = [&picture.radiance, &truth[0], &truth[1]].map(|image| grey(image));
        let norm: f64 = pixels.iter().map(|p| a[*p] * b[*p]).sum();
        for pixel in &pixels {
            let error = (shown[*pixel] - a[*pixel]) * (shown[*pixel] - b[*pixel]);
            made[*pixel] += error / (norm * states.len() as f64);
        }
    }
    let [expected, made] = [expected, made].map(|errors| smoothed(&errors));
    let sum = |errors: &[f64]| errors.iter().sum::<f64>().sqrt();
    println!("expected {:.4}, made {:.4}", sum(&expected), sum(&made));
    let most = expected.iter().chain(&made).copied().fold(0.0, f64::max).sqrt();
    // The root of what is shown, so that small errors are seen beside large ones.
    let shown = |errors: &[f64]| -> Vec<Rgb> {
        errors.iter().map(|error| [(error.max(0.0).sqrt() / most) as f32; 3]).collect()
    };
    let (image, size) = grid(&[vec![shown(&expected), shown(&made)]], SIZE);
    write("filter-errors", &image, size);
    let ratio = sum(&expected) / sum(&made);
    assert!((1.0 / 1.5..1.5).contains(&ratio), "{ratio}");
}

/// Means over the pixels around.
fn smoothed(errors: &[f64]) -> Vec<f64> {
    let mean = |pixel: usize| {
        let at = |x: i32, y: i32| {
            let inside = [x, y].iter().all(|k| (0..SIZE as i32).contains(k));
            inside.then(|| errors[y as usize * SIZE + x as usize])
        };
        let [x, y] = [pixel % SIZE, pixel / SIZE].map(|k| k as i32);
        let around = (-RADIUS..=RADIUS).flat_map(|dy| (-RADIUS..=RADIUS).map(move |dx| (dx, dy)));
        let found: Vec<f64> = around.filter_map(|(dx, dy)| at(x + dx, y + dy)).collect();
        found.iter().sum::<f64>() / found.len() as f64
    };
    (0..SIZE * SIZE).map(mean).collect()
}
