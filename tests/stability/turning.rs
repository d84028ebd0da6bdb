//! A map that turns by quarter degrees through a full circle: what pictures change by from one to the next,
//! beside the path tracer's.

use crate::support::{expect_exit, radiance_in, render, write_scene};
use relume_bake::trace::reference::Paths;
use relume_chart::play::Playing;
use relume_chart::states::write_animation;
use relume_formats::Place;
use relume_formats::state::{EnvironmentState, State};
use relume_scenes::Scene;
use std::path::Path;

/// Width and height of the pictures, pixels.
const SIDE: u32 = 64;
/// Steps of a circle.
const STEPS: u32 = 1440;
/// Steps after which the reference is looked at.
const EVERY: usize = 24;
/// Its paths a pixel, twice.
const SAMPLES: u32 = 128;
/// How many of the player's largest steps are looked at, one by one, with so many times the paths.
const LARGEST: usize = 4;
const MORE: u32 = 32;
/// How many times as much as the path tracer's pictures the player's may change by.
const MOST: f64 = 1.5;

fn text(vary: &str, map: &str) -> String {
    format!(
        "[vary]\n{vary}\n[render]\nsize = [{SIDE}, {SIDE}]\nreflections = 1\n\
         [camera]\nposition = [0, 2.4, 4.4]\ntarget = [0, 0.35, 0]\nfov_deg = 30\n\
         [materials.white]\nbrdf = 'blinn-phong'\nkd = [0.7, 0.7, 0.7]\n[environment]\nfile = '{map}'\n\
         [[object]]\nname = 'plane'\nshape = 'quad'\nsegments = 96\nmaterial = 'white'\ntransform = {{ scale = 4 }}\n\
         [[object]]\nname = 'knot'\nshape = 'torus-knot'\nradius = 0.4\ntube = 0.12\nmaterial = 'white'\n\
         transform = {{ translation = [0, 0.75, 0], rotation_deg = [70, 0, 0] }}\n"
    )
}

fn turned(step: u32) -> State {
    let rotation_deg = Some(360.0 * step as f32 / STEPS as f32);
    State {
        environment: Some(EnvironmentState { rotation_deg, ..EnvironmentState::default() }),
        ..State::default()
    }
}

/// Mean over the channels of the squares of what changed between two pictures, counted by two estimates of it
/// whose noise is independent, or by one that has none.
fn change(first: [&[[f32; 3]]; 2], second: [&[[f32; 3]]; 2]) -> f64 {
    let [a, b] = [0, 1].map(|k| {
        let of = |(x, y): (&f32, &f32)| f64::from(*y) - f64::from(*x);
        first[k].as_flattened().iter().zip(second[k].as_flattened()).map(of)
    });
    a.zip(b).map(|(a, b)| a * b).sum::<f64>() / f64::from(3 * SIDE * SIDE)
}

/// Of every step around the circle, what the player's picture changes by.
fn played(scene: &Path, folder: &Path) -> (String, Vec<f64>) {
    let (bundle, animation) = (folder.join("bundle"), folder.join("turn.toml"));
    let arguments = [scene.to_str().unwrap(), "-o", bundle.to_str().unwrap(), "--progress", "none"];
    expect_exit("bake", &[&["run"], &arguments[..]].concat(), 0);
    let states: Vec<State> = (0..=STEPS).map(turned).collect();
    write_animation(&states, &animation).unwrap();
    let manifest = relume_formats::kinds::Manifest::read(&bundle).unwrap();
    let method = manifest.methods[0].name.clone();
    let pattern = folder.join("%04d.exr");
    let playing = Playing {
        folder: &bundle,
        method: &method,
        animation: &animation,
        frames: STEPS + 1,
        size: [SIDE; 2],
        exr: pattern.to_str(),
    };
    playing.play().unwrap();
    let picture = |step: u32| radiance_in(&folder.join(format!("{step:04}.exr")));
    let changes = (0..STEPS).map(|step| {
        let [now, then] = [picture(step), picture(step + 1)];
        change([&now, &now], [&then, &then])
    });
    (method, changes.collect())
}

/// What the path tracer's picture changes by in a step, with so many paths a pixel, twice.
fn traced(scene: &Scene, step: u32, samples: u32) -> f64 {
    let halves = |step: u32| {
        let scene = scene.with_state(&turned(step), &Place::file("test")).unwrap();
        [1, 2].map(|seed| render(&scene, [SIDE; 2], samples, 1, Paths::Best, seed).radiance)
    };
    let ([now, also_now], [then, also_then]) = (halves(step), halves(step + 1));
    change([&now, &also_now], [&then, &also_then])
}

/// The steps in which the player's picture changes most, largest first.
fn largest(changes: &[f64]) -> Vec<u32> {
    let mut steps: Vec<u32> = (0..STEPS).collect();
    steps.sort_by(|a, b| changes[*b as usize].total_cmp(&changes[*a as usize]));
    steps.truncate(LARGEST);
    steps
}

#[test]
#[ignore = "plays and traces thousands of pictures"]
fn a_map_that_turns_by_quarter_degrees_does_not_flicker() {
    let mut missed = Vec::new();
    for map in ["lamps", "clear-sky"] {
        for vary in ["light = true\nview = true", "light = true\nview = true\nshape = true"] {
            let folder = tempfile::tempdir().unwrap();
            let path = write_scene(folder.path(), &text(vary, map));
            let scene = relume_scenes::load(&path).unwrap();
            let (method, ours) = played(&path, folder.path());
            let rms = |squares: &[f64]| (squares.iter().sum::<f64>() / squares.len() as f64).max(0.0).sqrt();
            let truth: Vec<f64> =
                (0..STEPS).step_by(EVERY).map(|step| traced(&scene, step, SAMPLES)).collect();
            let ratio = rms(&ours) / rms(&truth);
            println!("{map}, {method}: {:.3e}, {ratio:.2} times the path tracer's", rms(&ours));
            if ratio > MOST {
                missed.push(format!("{map}, {method}: {ratio:.2} over the circle"));
            }
            for step in largest(&ours) {
                let ours = ours[step as usize].sqrt();
                let ratio = ours / traced(&scene, step, MORE * SAMPLES).max(0.0).sqrt();
                println!("step {step}: {ours:.3e}, {ratio:.2} times the path tracer's");
                if ratio > MOST {
                    missed.push(format!("{map}, {method}: {ratio:.2} in step {step}"));
                }
            }
        }
    }
    assert!(missed.is_empty(), "times what the path tracer's pictures change by: {missed:#?}");
}
