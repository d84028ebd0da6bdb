//! sparse-transfer beside precomputed radiance transfer by spherical harmonics (Sloan, Kautz, Snyder 2002): 25
//! coefficients a vertex, bands 0 to 4, from the very rows that sparse-transfer keeps terms of, and the light in the
//! same bands. The table of docs/notes/SPARSE-TRANSFER.md; errors are those at the vertices under the held-out lights.
//! bunny-plane needs the assets (`make assets`):
//!
//! `cargo run --release --example harmonics -- bunny-plane|knot-outdoors`

use half::f16;
use rayon::prelude::*;
use relume_bake::compress::quantise::unit_for;
use relume_bake::compress::statistics::{median, worst};
use relume_bake::error::{BakeError, Result};
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::sparse_transfer::errors::{by_terms, of_stored};
use relume_bake::methods::sparse_transfer::rows::{MAX_TERMS, Rows};
use relume_bake::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use relume_bake::methods::sparse_transfer::visibility::transfer_row;
use relume_bake::methods::sparse_transfer::{importance, quantise};
use relume_bake::trace::held_out_lights::{Exact, HeldOutLights, RADIANCES, STATES};
use relume_bake::trace::receivers::{Receiver, receivers};
use relume_bake::trace::world::World;
use relume_chart::harmonics::{COUNT, Coefficients, of_texels, project};
use relume_formats::Place;
use relume_formats::evaluate::sparse_transfer::radiance;
use relume_formats::kinds::SparseTransfer;
use relume_formats::kinds::sparse_transfer::{BlockShape, Meta};
use relume_scenes::Scene;
use std::process::ExitCode;
use std::time::Instant;

/// Rays a texel where visibility changes, along each side.
const RAYS: usize = 4;
/// Rounds that the best time is taken of.
const ROUNDS: usize = 9;
/// Numbers of terms that make rows of about as many bytes as 25 halves, and of twice as many.
const AS_MANY_BYTES: [usize; 2] = [12, 24];

/// Rows of all vertices, in both bases.
struct Gathered {
    rows: Rows,
    harmonics: Vec<Coefficients>,
}

fn gathered(scene: &Scene, lights: &HeldOutLights, basis: &[(Coefficients, f32)]) -> Gathered {
    let (world, texels, weights) = (World::new(scene), Texels::new(RAYS), importance::weights(FACE_SIZE, 1));
    let of_piece = |piece: &[Receiver]| {
        let (mut rows, mut harmonics) = (Rows::new(MAX_TERMS, 1), Vec::new());
        let mut row = vec![0.0; weights.len()];
        for receiver in piece {
            transfer_row(receiver, &world, &texels, &mut row);
            harmonics.push(project(&row, basis).map(|value| f16::from_f32(value).to_f32()));
            rows.push_texels(vec![row.clone()], &weights, lights, FACE_SIZE);
        }
        (rows, harmonics)
    };
    let pieces: Vec<_> = receivers(scene).par_chunks(16).map(of_piece).collect();
    let mut all = Gathered { rows: Rows::new(MAX_TERMS, 1), harmonics: Vec::new() };
    for (rows, harmonics) in pieces {
        all.rows.append(rows);
        all.harmonics.extend(harmonics);
    }
    all
}

/// Each of the lights, [`RADIANCES`] of them by `texels`, projected.
fn projected(texels: &[f32], basis: &[(Coefficients, f32)]) -> Vec<Coefficients> {
    let light = |at: usize| {
        let integrals: Vec<f32> = basis
            .iter()
            .enumerate()
            .map(|(texel, (_, angle))| texels[texel * RADIANCES + at] * angle)
            .collect();
        project(&integrals, basis)
    };
    (0..RADIANCES).into_par_iter().map(light).collect()
}

/// Errors of harmonics under all lights, relative L2 of all that is seen, against what `of` takes.
fn errors(
    gathered: &Gathered,
    lights: &[Coefficients],
    of: impl Fn(&Exact) -> &[f32; RADIANCES] + Sync,
) -> Vec<f64> {
    let error = |state: usize| {
        let (mut off, mut norm) = (0.0, 0.0);
        for (row, exact) in gathered.harmonics.iter().zip(&gathered.rows.exact) {
            for (at, light) in lights.iter().enumerate().skip(3 * state).take(3) {
                let sum: f32 = row.iter().zip(light).map(|(t, l)| t * l).sum();
                off += f64::from(sum - of(exact)[at]).powi(2);
                norm += f64::from(exact.seen[at]).powi(2);
            }
        }
        (off / norm).sqrt()
    };
    (0..STATES).into_par_iter().map(error).collect()
}

/// The first `terms` of rows as they are stored.
fn stored(rows: &Rows, terms: usize) -> SparseTransfer {
    let (blocks, unit) = (quantise::shapes(terms), unit_for(&rows.values));
    let meta = Meta {
        vertices: rows.count() as u32,
        face_size: FACE_SIZE as u32,
        bounces: 0,
        rgb: false,
        unit,
        blocks: blocks.clone(),
        rays_per_texel: (RAYS * RAYS) as u32,
    };
    SparseTransfer { blocks: quantise::blocks(rows, &blocks, unit), meta }
}

/// Bytes of a row in memory: an index and a value for each term, a scale for each block.
fn bytes_of(stored: &SparseTransfer) -> usize {
    let of = |shape: &BlockShape| 2 + shape.terms as usize * (2 + if shape.wide { 2 } else { 1 });
    stored.meta.blocks.iter().map(of).sum()
}

/// The shortest time that `of` takes, milliseconds.
fn milliseconds<T>(of: impl Fn() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        std::hint::black_box(of());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..ROUNDS).map(time).fold(f64::INFINITY, f64::min)
}

/// Of radiance at all vertices, summed column by column, as the meaning of sparse-transfer does; milliseconds.
fn time_of_sums(harmonics: &[Coefficients], light: &[Coefficients; 3]) -> f64 {
    let column = |index: usize| harmonics.iter().map(|row| row[index]).collect::<Vec<f32>>();
    let columns: Vec<Vec<f32>> = (0..COUNT).map(column).collect();
    milliseconds(|| {
        let mut sums = vec![[0.0; 3]; harmonics.len()];
        for (index, column) in columns.iter().enumerate() {
            for (sum, value) in sums.iter_mut().zip(column) {
                (0..3).for_each(|c| sum[c] += value * light[c][index]);
            }
        }
        sums
    })
}

fn print(name: &str) -> Result<()> {
    let scene = relume_scenes::load(&relume_scenes::resolve(name)?)?;
    let maps = environments(&scene);
    let lights = HeldOutLights::new(&maps, FACE_SIZE, false);
    let basis = of_texels(FACE_SIZE);
    let gathered = gathered(&scene, &lights, &basis);
    let by_terms = by_terms(&gathered.rows, &lights);
    // With room for rounding, as bakes have it.
    let fewest = |most: f64| {
        by_terms.iter().position(|errors| 1.05 * worst(errors) <= most).map_or(MAX_TERMS, |at| at + 1)
    };
    let names: Vec<&str> = maps.iter().map(|map| map.name.as_str()).collect();
    println!(
        "\n**{name}, {} vertices**: relative L2, %, median over {STATES} held-out lights\n",
        gathered.rows.count()
    );
    println!(
        "| | bytes a vertex | {} | all | worst | sums, ms |\n|---|---|{}---|---|---|",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    let line = |what: &str, bytes: usize, errors: &[f64], time: f64| {
        // The lights are the maps by turns.
        let of_map = |map: usize| errors.iter().copied().skip(map).step_by(names.len()).collect::<Vec<f64>>();
        let cells: String =
            (0..names.len()).map(|map| format!(" {:.2} |", 100.0 * median(&of_map(map)))).collect();
        let [all, worst] = [median(errors), worst(errors)].map(|error| 100.0 * error);
        println!("| {what} | {bytes} |{cells} {all:.2} | {worst:.2} | {time:.2} |");
    };
    let [rest, whole] = [&lights.texels, &lights.whole].map(|texels| projected(texels, &basis));
    let time = time_of_sums(&gathered.harmonics, &[0, 1, 2].map(|c| whole[c]));
    line("harmonics, the whole map", 2 * COUNT, &errors(&gathered, &whole, |exact| &exact.seen), time);
    let apart = errors(&gathered, &rest, |exact| &exact.given);
    line("harmonics, suns by shadow maps", 2 * COUNT, &apart, time);
    let planes: [Vec<f32>; 3] =
        std::array::from_fn(|c| lights.coefficients.iter().skip(c).step_by(RADIANCES).copied().collect());
    for terms in AS_MANY_BYTES.into_iter().chain([fewest(scene.max_error), fewest(worst(&apart))]) {
        let stored = stored(&gathered.rows, terms);
        let (errors, time) =
            (of_stored(&stored, &gathered.rows, &lights), milliseconds(|| radiance(&stored, &planes)));
        line(
            &format!("sparse-transfer, {terms} terms, suns by shadow maps"),
            bytes_of(&stored),
            &errors,
            time,
        );
    }
    Ok(())
}

fn main() -> ExitCode {
    let printed = match std::env::args().nth(1).as_deref() {
        Some(name @ ("bunny-plane" | "knot-outdoors")) => print(name),
        _ => Err(BakeError::invalid(&Place::file("SCENE"), "give bunny-plane or knot-outdoors")),
    };
    let Err(error) = printed else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(error.exit_code())
}
