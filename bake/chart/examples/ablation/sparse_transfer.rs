//! sparse-transfer: texels, terms, rounding.

use crate::steps::{
    Drawing, SAMPLES, Steps, at_states, bundle_folder, exact, library, played, quiet, reference,
};
use rayon::prelude::*;
use relume_bake::bundle;
use relume_bake::error::{BakeError, Result};
use relume_bake::methods::asked::Asked;
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::sparse_transfer::errors::light_of;
use relume_bake::methods::sparse_transfer::rows::{MAX_TERMS, Rows};
use relume_bake::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use relume_bake::methods::sparse_transfer::visibility::transfer_row;
use relume_bake::methods::sparse_transfer::{METHOD, NAME, importance};
use relume_bake::trace::held_out_lights::{Exact, HeldOutLights, RADIANCES, add};
use relume_bake::trace::receivers::receivers;
use relume_bake::trace::world::World;
use relume_bake::unfinished::Leftover;
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::{lights as lights_of, radiance};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::{Environment, SparseTransfer};
use relume_formats::state::Rgb;
use relume_scenes::Scene;

/// Numbers of terms, besides that of the bundle.
const TERMS: [usize; 4] = [MAX_TERMS, 256, 128, 64];

/// Rows of all vertices, with what they reflect exactly under `lights`.
fn gathered(scene: &Scene, lights: &HeldOutLights, rays_per_side: usize) -> Rows {
    let (world, texels, weights) =
        (World::new(scene), Texels::new(rays_per_side), importance::weights(FACE_SIZE, 1));
    let pieces = receivers(scene);
    let pieces = pieces.par_chunks(16).map(|piece| {
        let mut rows = Rows::new(MAX_TERMS, 1);
        let mut row = vec![0.0; weights.len()];
        for receiver in piece {
            transfer_row(receiver, &world, &texels, &mut row);
            rows.push_texels(vec![row.clone()], &weights, lights, FACE_SIZE);
        }
        rows
    });
    let mut all = Rows::new(MAX_TERMS, 1);
    pieces.collect::<Vec<_>>().into_iter().for_each(|rows| all.append(rows));
    all
}

/// Direct light of suns at a vertex, with the visibility that its row has.
fn of_suns(exact: &Exact, state: usize) -> Rgb {
    std::array::from_fn(|c| exact.seen[3 * state + c] - exact.given[3 * state + c])
}

/// Radiance at all vertices in a state, from the first terms of their rows and of suns.
fn of_terms(rows: &Rows, lights: &HeldOutLights, terms: usize, state: usize) -> Vec<Rgb> {
    let of = |row: usize| {
        let mut sums = [0.0; RADIANCES];
        for at in row * rows.terms..row * rows.terms + terms {
            add(&mut sums, &rows.values[at..=at], light_of(lights, rows.indices[at]));
        }
        std::array::from_fn(|c| sums[3 * state + c] + of_suns(&rows.exact[row], state)[c])
    };
    (0..rows.count()).into_par_iter().map(of).collect()
}

fn whole_rows(rows: &Rows, state: usize) -> Vec<Rgb> {
    rows.exact.iter().map(|exact| std::array::from_fn(|c| exact.seen[3 * state + c])).collect()
}

/// Bakes the library's scene `name`, or goes on with what is there, and prints its table.
pub fn ablation(name: &str) -> Result<()> {
    let scene = library(name)?;
    let folder = bundle_folder(name);
    let method = (METHOD.new)(&Asked::of_scene(&scene), &scene);
    bundle::run(&scene, &[method], scene.size, &folder, Leftover::Resume, 0, &quiet())?;
    let stored = SparseTransfer::read_file(&folder.join("sparse-transfer.relume"))?;
    let kept = stored.meta.terms();

    let states = at_states(&scene)?;
    let lit = |scene: &Scene| -> Result<(Environment, f32)> {
        let environment = scene.environment.as_ref();
        let environment = environment
            .ok_or_else(|| BakeError::invalid(&Place::file(&scene.file), "has no [environment]"))?;
        Ok((environments(scene).swap_remove(0), environment.rotation_deg))
    };
    let maps = states.iter().map(lit).collect::<Result<Vec<_>>>()?;
    let of_state = |state: usize| (&maps[state % maps.len()].0.map, maps[state % maps.len()].1);
    let rows = gathered(
        &scene,
        &HeldOutLights::of(std::array::from_fn(of_state), FACE_SIZE, false),
        stored.meta.rays_per_texel.isqrt() as usize,
    );
    let lights = HeldOutLights::of(std::array::from_fn(of_state), FACE_SIZE, false);

    let drawings: Vec<Drawing> = states.iter().map(|state| Drawing::new(state, 0)).collect();
    let drawn = |radiance: &dyn Fn(usize) -> Vec<Rgb>| {
        (0..states.len()).map(|at| drawings[at].draw(&radiance(at))).collect::<Vec<_>>()
    };
    let mut steps = Steps::default();
    let traced = |seed: u64, reflections: u32| {
        states.iter().map(|s| reference(s, SAMPLES, seed, reflections)).collect::<Result<Vec<_>>>()
    };
    let truth = steps.push("path tracer", 0, traced(0, 1)?);
    steps.push("(the path tracer with other seeds)", truth, traced(1, 1)?);
    steps.push("(reflections without limit, which the scene does not ask for)", truth, traced(0, u32::MAX)?);
    let vertices =
        steps.push("exact radiance at vertices, drawn by the mesh", truth, drawn(&|at| exact(&states[at])));
    let texels =
        steps.push("light of 6 × 64 × 64 texels, whole rows", vertices, drawn(&|at| whole_rows(&rows, at)));
    let mut most = texels;
    for terms in TERMS {
        let number =
            steps.push(&format!("{terms} terms"), texels, drawn(&|at| of_terms(&rows, &lights, terms, at)));
        most = if terms == MAX_TERMS { number } else { most };
    }
    let unrounded = steps.push(
        &format!("{kept} terms, as in the bundle"),
        most,
        drawn(&|at| of_terms(&rows, &lights, kept, at)),
    );
    let look = |at: usize| EnvironmentLook { map: String::new(), gain: [1.0; 3], rotation_deg: maps[at].1 };
    let rounded = drawn(&|at| {
        let shown = radiance(&stored, &lights_of(&maps[at].0.map, &look(at), &stored.meta)).into_iter();
        let add = |(shown, exact): (Rgb, &Exact)| {
            let of_suns = of_suns(exact, at);
            std::array::from_fn(|c| shown[c] + of_suns[c])
        };
        shown.zip(&rows.exact).map(add).collect()
    });
    let rounded = steps.push("rounded to bytes", unrounded, rounded);
    steps.push("the player, suns by shadow maps", rounded, played(&scene, NAME, &folder)?);
    let masks: Vec<&[bool]> = drawings.iter().map(|drawing| &drawing.shows_surface[..]).collect();
    steps.print(&format!("sparse-transfer, {name}"), &masks);
    Ok(())
}
