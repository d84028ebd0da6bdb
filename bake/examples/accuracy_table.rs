//! The accuracy table of docs/notes/SPARSE-TRANSFER.md. It needs the assets (`make assets`):
//!
//! `cargo run --release --example accuracy_table`

use rayon::prelude::*;
use relume_bake::compress::quantise::unit_for;
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::sparse_transfer::errors::{Errors, by_terms, of_stored};
use relume_bake::methods::sparse_transfer::rows::{MAX_TERMS, Rows};
use relume_bake::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use relume_bake::methods::sparse_transfer::visibility::transfer_row;
use relume_bake::methods::sparse_transfer::{importance, quantise};
use relume_bake::trace::held_out_lights::{HeldOutLights, STATES};
use relume_bake::trace::receivers::{Receiver, receivers};
use relume_bake::trace::world::World;
use relume_formats::basis::cubemap::FACES;
use relume_formats::basis::haar;
use relume_formats::kinds::sparse_transfer::Meta;
use relume_formats::kinds::{Environment, SparseTransfer};
use relume_scenes::Scene;
use std::process::ExitCode;

const TERMS: [usize; 6] = [32, 64, 100, 200, 400, 800];
/// Turns that every map is measured at, as far as there are states for them.
const TURNS_DEG: [f32; 3] = [0.0, 130.0, 250.0];

struct Table {
    maps: Vec<String>,
    /// By number of terms, before rounding and after.
    errors: Vec<[Errors; 2]>,
}

impl Table {
    fn new(scene: &Scene, receivers: &[Receiver], weights: &[f32], rays_per_side: usize) -> Self {
        let maps: Vec<Environment> = environments(scene);
        let state =
            |state: usize| (&maps[state % maps.len()].map, TURNS_DEG[state / maps.len() % TURNS_DEG.len()]);
        let lights = HeldOutLights::of(std::array::from_fn(state), FACE_SIZE, false);
        let (world, texels) = (World::new(scene), Texels::new(rays_per_side));
        let piece = |receivers: &[Receiver]| {
            let mut rows = Rows::new(MAX_TERMS, 1);
            let mut row = vec![0.0; FACES * FACE_SIZE * FACE_SIZE];
            for receiver in receivers {
                transfer_row(receiver, &world, &texels, &mut row);
                rows.push_texels(vec![row.clone()], weights, &lights, FACE_SIZE);
            }
            rows
        };
        let mut rows = Rows::new(MAX_TERMS, 1);
        receivers
            .par_chunks(16)
            .map(piece)
            .collect::<Vec<_>>()
            .into_iter()
            .for_each(|more| rows.append(more));
        let unrounded = by_terms(&rows, &lights);
        let stored = |terms: usize| {
            let (unit, blocks) = (unit_for(&rows.values), quantise::shapes(terms));
            let stored = quantise::blocks(&rows, &blocks, unit);
            let meta = Meta {
                vertices: rows.count() as u32,
                face_size: 64,
                bounces: 0,
                rgb: false,
                unit,
                blocks,
                rays_per_texel: 1,
            };
            of_stored(&SparseTransfer { meta, blocks: stored }, &rows, &lights)
        };
        let errors = TERMS.iter().map(|terms| [unrounded[terms - 1], stored(*terms)]).collect();
        Self { maps: maps.into_iter().map(|m| m.name).collect(), errors }
    }

    /// Unturned errors of a map in per cent, before rounding and after.
    fn unturned(&self, terms: usize, map: usize) -> [f64; 2] {
        self.errors[terms].map(|errors| 100.0 * errors[map])
    }

    /// Root mean square over all turns of a map, in per cent.
    fn turned(&self, terms: usize, map: usize) -> [f64; 2] {
        let count = (STATES / self.maps.len()).min(TURNS_DEG.len());
        let mean = |errors: Errors| {
            (0..count).map(|turn| errors[turn * self.maps.len() + map].powi(2)).sum::<f64>() / count as f64
        };
        self.errors[terms].map(|errors| 100.0 * mean(errors).sqrt())
    }

    fn print(&self, title: &str) {
        println!(
            "\n{title}: unturned, and over {} turns; before rounding / after, %",
            (STATES / self.maps.len()).min(TURNS_DEG.len())
        );
        println!("| terms | {} |", self.maps.join(" | "));
        for (row, terms) in TERMS.iter().enumerate() {
            let cell = |map: usize| {
                let ([a, b], [c, d]) = (self.unturned(row, map), self.turned(row, map));
                format!("{a:.3} / {b:.3}, {c:.3} / {d:.3}")
            };
            println!("| {terms} | {} |", (0..self.maps.len()).map(cell).collect::<Vec<_>>().join(" | "));
        }
        let of_rounding =
            self.errors.iter().flat_map(|[before, after]| before.iter().zip(after).map(|(b, a)| a / b));
        println!("rounding multiplies errors by at most {:.3}", of_rounding.fold(0.0, f64::max));
        let at = [2, 4].into_iter().flat_map(|row| (0..self.maps.len()).map(move |map| (row, map)));
        let mean = |of: &dyn Fn(usize, usize) -> f64| {
            (at.clone().map(|(row, map)| of(row, map).ln()).sum::<f64>() / (2 * self.maps.len()) as f64).exp()
        };
        let (unturned, turned) =
            (mean(&|row, map| self.unturned(row, map)[0]), mean(&|row, map| self.turned(row, map)[0]));
        println!("geometric mean at 100 and 400 terms: {unturned:.3} unturned, {turned:.3} turned");
    }
}

fn weightings() -> [(&'static str, Vec<f32>); 3] {
    let all = 0..FACES * FACE_SIZE * FACE_SIZE;
    [
        ("ours", importance::weights(FACE_SIZE, 1)),
        ("area", all.clone().map(|i| haar::support(i, FACE_SIZE) as f32).collect()),
        ("plain", all.map(|_| 1.0).collect()),
    ]
}

fn load(name: &str) -> relume_formats::Result<Scene> {
    relume_scenes::load(&relume_scenes::resolve(name)?)
}

fn print() -> relume_formats::Result<()> {
    let scene = load("spheres-24")?;
    let on_grid = |i: &usize| (i % 115).is_multiple_of(6) && (i / 115).is_multiple_of(6);
    let ground: Vec<Receiver> = receivers(&scene)
        .into_iter()
        .take(115 * 115)
        .enumerate()
        .filter(|(i, _)| on_grid(i))
        .map(|(_, r)| r)
        .collect();
    assert_eq!(ground.len(), 400);
    for (name, weights) in weightings() {
        Table::new(&scene, &ground, &weights, 1)
            .print(&format!("spheres-24, ground of 20 × 20, texel centres, weights {name}"));
    }
    for name in ["spheres-24", "bunny-plane", "armadillo-plane"] {
        let scene = load(name)?;
        let some: Vec<Receiver> = receivers(&scene).into_iter().step_by(8).collect();
        Table::new(&scene, &some, &importance::weights(FACE_SIZE, 1), 4)
            .print(&format!("{name}, every eighth vertex, 16 rays a texel at edges"));
    }
    Ok(())
}

fn main() -> ExitCode {
    let Err(error) = print() else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(2)
}
