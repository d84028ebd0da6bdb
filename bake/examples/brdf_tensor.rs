//! The figures of docs/notes/TRANSFER-TENSOR.md, and the tensors themselves:
//!
//! `cargo run --release --example brdf_tensor -- figures MODEL`
//!
//! `cargo run --release --example brdf_tensor -- write MODEL FILE.relume`

use relume_bake::brdf::tensor::{Fit, Separation, SpaceTensor, ranks, samples_of};
use relume_formats::container::Stored as _;
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::{Samples, TERMS};
use relume_formats::state::{Model, SHININESS_MAX};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

const USAGE: &str = "usage: brdf_tensor figures MODEL | write MODEL FILE.relume, MODEL one of blinn-phong, ggx, cook-torrance";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["figures", model] => figures(named(model)?),
        ["write", model, file] => write(named(model)?, Path::new(file)),
        _ => Err(USAGE.into()),
    }
}

fn named(name: &str) -> Result<Model, Box<dyn Error>> {
    let models = [Model::BlinnPhong, Model::Ggx, Model::CookTorrance];
    models.into_iter().find(|model| model.name() == name).ok_or_else(|| USAGE.into())
}

fn space(model: Model, terms: usize, fit: Fit) -> SpaceTensor {
    SpaceTensor::new(model, samples_of(model), Separation { terms, fit })
}

fn write(model: Model, file: &Path) -> Result<(), Box<dyn Error>> {
    let started = Instant::now();
    let (tensor, found) = space(model, TERMS, Fit::Expectation).decomposed(ranks(model))?;
    tensor.write_file(file)?;
    println!("{}: {} rounds, {:.1} s", file.display(), found.sweeps, started.elapsed().as_secs_f64());
    Ok(())
}

fn figures(model: Model) -> Result<(), Box<dyn Error>> {
    let ranks = ranks(model);
    println!("## {}\n\n### Mirror terms\n", model.name());
    println!(
        "| terms | fit | left by them | error at {ranks:?} | materials | outgoing | incoming | rounds | s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut split = None;
    for terms in 0..=TERMS {
        let fits = if terms == 0 { &[Fit::Expectation][..] } else { &[Fit::Expectation, Fit::LeastSquares] };
        for fit in fits {
            let started = Instant::now();
            let space = space(model, terms, *fit);
            let (tensor, found) = space.decomposed(ranks)?;
            row(terms, *fit, &tensor, found.sweeps, started);
            if terms == 0 {
                chart("no mirror terms", model, &space)?;
            }
            if terms == TERMS {
                bends(*fit, &space);
                if *fit == Fit::Expectation {
                    split = Some(space);
                }
            }
        }
    }
    if let Some(split) = split {
        chart("all mirror terms", model, &split)?;
        by_sharpness(&split, ranks)?;
    }
    Ok(())
}

fn row(terms: usize, fit: Fit, tensor: &BrdfTensor, rounds: usize, started: Instant) {
    let m = &tensor.meta;
    println!(
        "| {terms} | {fit:?} | {:.5} | {:.5} | {:.5} | {:.5} | {:.5} | {rounds} | {:.1} |",
        m.residual,
        m.whole,
        m.materials,
        m.outgoing,
        m.incoming,
        started.elapsed().as_secs_f64()
    );
}

/// The source's Fig. 5-5.
fn chart(title: &str, model: Model, space: &SpaceTensor) -> Result<(), Box<dyn Error>> {
    let columns = [4, 8, 16, 32];
    println!("\n{title}, {}, error by columns of materials (rows) and of directions:\n", model.name());
    println!("| | {} |\n|{}", columns.map(|n| n.to_string()).join(" | "), "---|".repeat(1 + columns.len()));
    for of_materials in 1..=6 {
        let mut errors = Vec::new();
        for n in columns {
            errors.push(format!("{:.5}", space.decomposed([of_materials, n, n])?.0.meta.whole));
        }
        println!("| {of_materials} | {} |", errors.join(" | "));
    }
    println!();
    Ok(())
}

/// How far the shares of a sample of a line are from the mean of its neighbours'.
fn bends(fit: Fit, space: &SpaceTensor) {
    let Samples::Line(exponents) = space.samples() else { return };
    let rings = space.shares().len() / exponents.len();
    let share = |sample: usize, ring: usize, term: usize| space.shares()[sample * rings + ring][term];
    let mut most = (0.0f32, 0.0);
    for (sample, s) in exponents.iter().enumerate().skip(1).take(SHININESS_MAX as usize - 2) {
        for (ring, term) in (0..rings).flat_map(|ring| (0..TERMS).map(move |term| (ring, term))) {
            let [a, b, c] = [sample - 1, sample, sample + 1].map(|sample| share(sample, ring, term));
            let bend = (0.5 * (a + c) - b).abs();
            most = if bend > most.0 { (bend, *s) } else { most };
        }
    }
    println!(
        "\n{fit:?}: a share is at most {:.5} from the mean of its neighbours', at exponent {}\n",
        most.0, most.1
    );
}

/// Relative L2 error of single lobes.
fn by_sharpness(space: &SpaceTensor, ranks: [usize; 3]) -> Result<(), Box<dyn Error>> {
    let (tensor, _) = space.decomposed(ranks)?;
    println!("| sample | left by mirror terms | error at {ranks:?} |\n|---|---|---|");
    let errors = space.errors_of(&tensor);
    for (sample, [residual, error]) in errors.iter().enumerate().step_by(1 + errors.len() / 12) {
        let name = match space.samples() {
            Samples::Line(exponents) => format!("s = {}", exponents[sample]),
            Samples::Plane { points, .. } => {
                format!("reflectance {:.3}, roughness {:.3}", points[sample][0], points[sample][1])
            }
        };
        println!("| {name} | {residual:.4} | {error:.4} |");
    }
    Ok(())
}
