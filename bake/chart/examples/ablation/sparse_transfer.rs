//! sparse-transfer: suns, texels, terms, rounding.

use crate::steps::{Drawing, Film, Steps, at_states, bundle_folder, exact, library, played, quiet};
use crate::suns::{Parted, sum};
use rayon::prelude::*;
use relume_bake::bundle;
use relume_bake::error::Result;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::sparse_transfer::errors::light_of;
use relume_bake::methods::sparse_transfer::rows::{MAX_TERMS, Rows};
use relume_bake::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use relume_bake::methods::sparse_transfer::visibility::transfer_row;
use relume_bake::methods::sparse_transfer::{METHOD, NAME, importance};
use relume_bake::trace::held_out_lights::{HeldOutLights, RADIANCES, add};
use relume_bake::trace::receivers::receivers;
use relume_bake::trace::world::World;
use relume_bake::unfinished::Leftover;
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::{lights as lights_of, radiance};
use relume_formats::kinds::SparseTransfer;
use relume_formats::state::Rgb;
use relume_scenes::Scene;

/// Numbers of terms, besides that of the bundle.
const TERMS: [usize; 3] = [MAX_TERMS, 256, 64];

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

/// Radiance at all vertices in a state, from the first terms of their rows, suns left out.
fn of_terms(rows: &Rows, lights: &HeldOutLights, terms: usize, state: usize) -> Vec<Rgb> {
    let of = |row: usize| {
        let mut sums = [0.0; RADIANCES];
        for at in row * rows.terms..row * rows.terms + terms {
            add(&mut sums, &rows.values[at..=at], light_of(lights, rows.indices[at]));
        }
        std::array::from_fn(|c| sums[3 * state + c])
    };
    (0..rows.count()).into_par_iter().map(of).collect()
}

fn whole_rows(rows: &Rows, state: usize) -> Vec<Rgb> {
    rows.exact.iter().map(|exact| std::array::from_fn(|c| exact.given[3 * state + c])).collect()
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
    let parted = states.iter().map(Parted::new).collect::<Result<Vec<_>>>()?;
    let of_state = |state: usize| {
        let light = &parted[state % parted.len()];
        (&light.whole, light.look.rotation_deg)
    };
    let lights = HeldOutLights::of(std::array::from_fn(of_state), FACE_SIZE, false);
    let rows = gathered(&scene, &lights, stored.meta.rays_per_texel.isqrt() as usize);

    let drawings: Vec<Drawing> = states.iter().map(|state| Drawing::new(state, Film::Reference)).collect();
    let suns: Vec<Vec<Rgb>> =
        parted.iter().zip(&states).map(|(light, state)| light.of_suns(state, Film::Reference)).collect();
    let drawn = |radiance: &dyn Fn(usize) -> Vec<Rgb>| {
        (0..states.len()).map(|at| sum(&drawings[at].draw(&radiance(at)), &suns[at])).collect::<Vec<_>>()
    };
    let mut steps = Steps::new(&states)?;
    let at_vertices =
        drawings.iter().zip(&states).map(|(drawing, state)| drawing.draw(&exact(state))).collect();
    let vertices = steps.push("exact radiance at vertices, drawn by the mesh", None, at_vertices);
    let apart = steps.push(
        "suns at every sample, only the rest at vertices",
        vertices,
        drawn(&|at| exact(&parted[at].without_suns(&states[at]))),
    );
    let texels =
        steps.push("light of 6 × 64 × 64 texels, whole rows", apart, drawn(&|at| whole_rows(&rows, at)));
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
    let stored_radiance = |at: usize| {
        let Parted { whole, look, .. } = &parted[at];
        radiance(&stored, &lights_of(whole, look, &stored.meta))
    };
    let rounded = steps.push("rounded to bytes", unrounded, drawn(&stored_radiance));
    let by_quarters = |at: usize| {
        let rest = Drawing::new(&states[at], Film::Quarters).draw(&stored_radiance(at));
        sum(&rest, &parted[at].of_suns(&states[at], Film::Quarters))
    };
    let quarters = steps.push("four samples a pixel", rounded, (0..states.len()).map(by_quarters).collect());
    steps.push("the player, suns by shadow maps", quarters, played(&scene, NAME, &folder)?);
    let masks: Vec<&[bool]> = drawings.iter().map(|drawing| &drawing.shows_surface[..]).collect();
    steps.print(&format!("sparse-transfer, {name}"), &masks);
    Ok(())
}
