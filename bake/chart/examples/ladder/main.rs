//! The ladder of docs/notes/SPHERE-SHADOWS.md: from rays against the true mesh to sparse terms and one level
//! of visibility, each step against the one before and against the first. It takes some minutes, and
//! bunny-shadow needs the assets (`make assets`):
//!
//! `cargo run --release --example ladder -- bunny-shadow|knot-twist`

mod plane;
mod table_caps;

use plane::{Lit, Prepared, SPHERES, blocked_by_mesh, flip, percent, prepared};
use rayon::prelude::*;
use relume_bake::error::{BakeError, Result};
use relume_bake::methods::sphere_shadows::errors::{Posed, lobes};
use relume_formats::Place;
use relume_formats::basis::cap::{Bitmap, ROWS};
use relume_formats::evaluate::sphere_shadows::{Levels, Receiver, blocked, light, radiance};
use relume_formats::fast::sphere_shadows::Shading;
use relume_formats::kinds::{SphereShadows, VisibilityTable};
use relume_formats::state::Rgb;
use std::process::ExitCode;
use std::time::Instant;
use table_caps::blocked_by_table;

const TERMS: [usize; 3] = [200, 100, 50];

/// A step of the ladder: its name and its image under each light.
struct Step {
    name: String,
    /// The step that it is compared with besides the first.
    before: usize,
    images: Vec<Vec<Rgb>>,
}

fn print(prepared: &Prepared, lights: &[Lit]) -> Result<()> {
    let title = &prepared.title;
    let first = prepared.posed(0, &prepared.plane)?;
    let rho = prepared.rho(&first.receivers[0]);
    let start = Instant::now();
    let by_mesh = blocked_by_mesh(&prepared.scene, &prepared.plane, |_| rho.clone());
    println!("\n{title}: rays in {:.1} s", start.elapsed().as_secs_f64());
    let table = VisibilityTable::bake();
    let steps = |number: usize| {
        ladder(&prepared.posed(number, &prepared.plane)?, &prepared.shadows, &rho, &by_mesh, &table, lights)
    };
    let ladders = (0..SPHERES.len()).map(steps).collect::<Result<Vec<Vec<Step>>>>()?;
    for (at, lit) in lights.iter().enumerate() {
        println!(
            "\n**{title}, {}**\n\n| step | {} |\n|---|---|---|---|---|",
            lit.name,
            SPHERES.map(|n| format!("n_s = {n}")).join(" | ")
        );
        let open = lit.sum(&rho, &[0; ROWS]);
        for step in 1..ladders[0].len() {
            let cell = |steps: &Vec<Step>| {
                let Step { before, images, .. } = &steps[step];
                let (ours, before, truth) = (&images[at], &steps[*before].images[at], &steps[0].images[at]);
                let [l2, l2_first] = [before, truth].map(|r| percent(ours, r));
                let [flip, flip_first] = [before, truth].map(|r| flip(ours, r, open));
                format!("{l2:.3} / {l2_first:.2}, {flip:.4} / {flip_first:.4}")
            };
            println!(
                "| {} | {} |",
                ladders[0][step].name,
                ladders.iter().map(cell).collect::<Vec<_>>().join(" | ")
            );
        }
    }
    print_object(prepared, lights)
}

/// The vertices of the object itself: with the rule of self-shadowing, with its whole own set left out,
/// and as shown.
fn print_object(prepared: &Prepared, lights: &[Lit]) -> Result<()> {
    let object: Vec<usize> = (0..prepared.plane[0]).collect();
    let posed = (0..SPHERES.len()).map(|number| prepared.posed(number, &object));
    let posed = posed.collect::<Result<Vec<Posed>>>()?;
    let exact: Vec<Vec<f32>> = posed[0].receivers.iter().map(|receiver| prepared.rho(receiver)).collect();
    let by_mesh = blocked_by_mesh(&prepared.scene, &object, |vertex| exact[vertex].clone());
    let title = &prepared.title;
    println!(
        "\n**{title}, the object's own vertices: relative L2, %**\n\n| light | step | {} |\n|---|---|---|---|---|---|",
        SPHERES.map(|n| format!("n_s = {n}")).join(" | ")
    );
    for lit in lights {
        let image = |of: &dyn Fn(usize) -> Bitmap| {
            exact.iter().enumerate().map(|(at, rho)| lit.sum(rho, &of(at))).collect::<Vec<_>>()
        };
        let truth = image(&|at| by_mesh[at]);
        let rule = posed.iter().map(|p| percent(&image(&|at| blocked(&p.receivers[at], &p.casters)), &truth));
        let none = posed.iter().map(|_| percent(&image(&|_| [0; ROWS]), &truth));
        let kept = Some(TERMS[0]);
        let shown = posed.iter().map(|p| {
            percent(
                &p.under(&Shading::new(
                    &lobes(&prepared.shadows, kept),
                    &light(lit.planes.clone(), kept),
                    Levels::Two,
                )),
                &truth,
            )
        });
        let row = |name: &str, cells: Vec<f64>| {
            println!(
                "| {} | {name} | {} |",
                lit.name,
                cells.iter().map(|c| format!("{c:.2}")).collect::<Vec<_>>().join(" | ")
            );
        };
        row("exact caps, by the rule", rule.collect());
        row("its own spheres left out altogether", none.collect());
        row("200 terms, level II", shown.collect());
    }
    Ok(())
}

/// All steps for one number of spheres.
///
/// # Errors
/// If wavelets with all terms are not what the pixel basis is.
fn ladder(
    posed: &Posed,
    shadows: &SphereShadows,
    rho: &[f32],
    by_mesh: &[Bitmap],
    table: &VisibilityTable,
    lights: &[Lit],
) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    let mut push = |name: String, before: usize, images: Vec<Vec<Rgb>>| {
        steps.push(Step { name, before, images });
        steps.len() - 1
    };
    let pixels = |bitmaps: &[Bitmap]| {
        lights.iter().map(|lit| bitmaps.par_iter().map(|b| lit.sum(rho, b)).collect()).collect()
    };
    let truth = push("mesh".to_owned(), 0, pixels(by_mesh));
    let timed = |of: &(dyn Fn(&Receiver) -> Bitmap + Sync)| {
        let start = Instant::now();
        let bitmaps: Vec<Bitmap> = posed.receivers.iter().map(of).collect();
        (bitmaps, start.elapsed().as_secs_f64() * 1e6 / posed.receivers.len() as f64)
    };
    let (exact, exact_us) = timed(&|receiver| blocked(receiver, &posed.casters));
    let (rounded, rounded_us) = timed(&|receiver| blocked_by_table(receiver, &posed.casters.spheres, table));
    println!(
        "{} spheres: exact caps {exact_us:.1} µs a receiver, table {rounded_us:.1} µs",
        posed.casters.spheres[0].now.len()
    );
    let spheres = push("spheres, exact caps".to_owned(), truth, pixels(&exact));
    push("spheres, table".to_owned(), spheres, pixels(&rounded));
    let whole = lobes(shadows, None);
    let meaning = |lit: &Lit| {
        let light = light(lit.planes.clone(), None);
        let chunk = |receivers: &[Receiver]| {
            radiance(receivers, &posed.casters, &whole, &light, Levels::All, &posed.table)
        };
        posed.receivers.par_chunks(64).flat_map_iter(chunk).collect::<Vec<Rgb>>()
    };
    let wavelets = push("wavelets, all terms".to_owned(), spheres, lights.iter().map(meaning).collect());
    for terms in TERMS {
        let lobes = lobes(shadows, Some(terms));
        let mut before = wavelets;
        for (name, levels) in [("all levels", Levels::All), ("II", Levels::Two), ("I", Levels::One)] {
            let image = |lit: &Lit| {
                posed.under(&Shading::new(&lobes, &light(lit.planes.clone(), Some(terms)), levels))
            };
            before = push(format!("{terms} terms, {name}"), before, lights.iter().map(image).collect());
        }
    }
    let off = (0..lights.len())
        .map(|at| percent(&steps[wavelets].images[at], &steps[spheres].images[at]))
        .fold(0.0, f64::max);
    if off >= 0.01 {
        let reason = format!("wavelets with all terms equal the pixel basis to 1e-4, here {off} %");
        return Err(BakeError::invalid(&Place::file("sphere-shadows"), reason));
    }
    Ok(steps)
}

fn main() -> ExitCode {
    let printed =
        prepared(std::env::args().nth(1).as_deref()).and_then(|(prepared, lights)| print(&prepared, &lights));
    let Err(error) = printed else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(error.exit_code())
}
