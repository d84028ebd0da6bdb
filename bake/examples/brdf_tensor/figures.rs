//! Tables in Markdown. Errors that say nothing else are squared norms in parts of the lobe's, mean over
//! samples.

use crate::expectation::expectation;
use relume_bake::brdf::tensor::{
    Comparison, Fit, SOURCE_WIDTHS_DEG, Separation, SpaceTensor, least_squares, lobe_of, make, ranks,
    samples_of,
};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::Samples;
use relume_formats::state::{Brdf, Model};
use std::error::Error;
use std::time::Instant;

type Done = Result<(), Box<dyn Error>>;

/// Other standard deviations of mirror terms, degrees.
const WIDTHS_DEG: [&[f32]; 6] = [
    &SOURCE_WIDTHS_DEG,
    &[4.0, 7.0, 14.0, 21.0],
    &[2.0, 4.0, 8.0, 16.0],
    &[3.0, 6.0, 12.0, 24.0],
    &[2.0, 5.0, 10.0, 20.0],
    &[2.0, 4.0, 8.0, 16.0, 32.0],
];
/// Columns of directions.
const COLUMNS: [usize; 4] = [4, 8, 16, 32];
/// Samples that are shown one by one.
const SHOWN: usize = 12;
/// Angles from the normal, degrees.
const SEEN_FROM_DEG: [f64; 6] = [0.0, 30.0, 50.0, 65.0, 75.0, 85.0];

/// All of `model`, but how fits compare.
pub fn print(model: Model) -> Done {
    println!("## {}", model.name());
    by_widths(model)?;
    chart("Without mirror terms", &space(model, &[], least_squares))?;
    chart("With all", &space(model, &SOURCE_WIDTHS_DEG, least_squares))?;
    by_gloss(model)?;
    let started = Instant::now();
    let tensor = make(model)?;
    println!("\nMade in {:.1} s.", started.elapsed().as_secs_f64());
    between(&tensor)?;
    albedos(&tensor)
}

fn space(model: Model, widths_deg: &[f32], fit: Fit) -> SpaceTensor {
    SpaceTensor::new(model, samples_of(model), &Separation { widths_deg: widths_deg.to_vec(), fit })
}

fn heading(columns: &[&str]) {
    println!("\n| {} |\n|{}", columns.join(" | "), "---|".repeat(columns.len()));
}

/// Mirror terms by least squares and by expectation maximisation; minutes.
pub fn fits(model: Model) -> Done {
    heading(&["terms", "fit", "left by them", "error", "materials", "outgoing", "incoming", "bend", "s"]);
    let fits: [(&str, Fit); 2] = [("least squares", least_squares), ("expectation", expectation)];
    for (terms, (name, fit)) in (1..=SOURCE_WIDTHS_DEG.len()).flat_map(|terms| fits.map(|fit| (terms, fit))) {
        let started = Instant::now();
        let space = space(model, &SOURCE_WIDTHS_DEG[..terms], fit);
        let m = space.decomposed(ranks(model))?.0.meta;
        let errors = [m.residual, m.whole, m.materials, m.outgoing, m.incoming];
        let errors = errors.map(|error| format!("{error:.5}")).join(" | ");
        let seconds = started.elapsed().as_secs_f64();
        println!("| {terms} | {name} | {errors} | {:.4} | {seconds:.1} |", bend(&space));
    }
    Ok(())
}

/// How far a share of a sample of a line is from the mean of its neighbours' at most.
fn bend(space: &SpaceTensor) -> f32 {
    let Samples::Line(exponents) = space.samples() else { return f32::NAN };
    let shares = space.shares();
    let row = shares.len() / exponents.len();
    let bends = (row..shares.len() - row).map(|at| 0.5 * (shares[at - row] + shares[at + row]) - shares[at]);
    bends.map(f32::abs).fold(0.0, f32::max)
}

fn by_widths(model: Model) -> Done {
    heading(&["widths, °", "left by them", "error"]);
    for widths in WIDTHS_DEG {
        let meta = space(model, widths, least_squares).decomposed(ranks(model))?.0.meta;
        println!("| {widths:?} | {:.5} | {:.5} |", meta.residual, meta.whole);
    }
    Ok(())
}

/// The source's Fig. 5-5.
fn chart(title: &str, space: &SpaceTensor) -> Done {
    println!("\n{title}, error by columns of materials (rows) and of directions:");
    heading(&[&[""][..], &COLUMNS.map(|n| n.to_string()).each_ref().map(String::as_str)].concat());
    for of_materials in 1..=6 {
        let mut errors = Vec::new();
        for n in COLUMNS {
            errors.push(format!("{:.5}", space.decomposed([of_materials, n, n])?.0.meta.whole));
        }
        println!("| {of_materials} | {} |", errors.join(" | "));
    }
    Ok(())
}

/// The source's Fig. 5-6: of single lobes the relative L2 error of the tensor with 0 to 4 mirror terms, and
/// what all four leave.
fn by_gloss(model: Model) -> Done {
    println!(
        "\nRelative L2 error of single lobes at {:?} by mirror terms, and what all leave:",
        ranks(model)
    );
    heading(&["sample", "0", "1", "2", "3", "4", "left by 4"]);
    let mut errors = Vec::new();
    for terms in 0..=SOURCE_WIDTHS_DEG.len() {
        let space = space(model, &SOURCE_WIDTHS_DEG[..terms], least_squares);
        errors.push(space.errors_of(&space.decomposed(ranks(model))?.0));
    }
    let samples = samples_of(model);
    for sample in (0..samples.count()).step_by(1 + samples.count() / SHOWN) {
        let by_terms: Vec<String> = errors.iter().map(|errors| format!("{:.4}", errors[sample][1])).collect();
        let left = errors.last().map_or(f64::NAN, |errors| errors[sample][0]);
        println!("| {} | {} | {left:.4} |", name(&samples, sample), by_terms.join(" | "));
    }
    Ok(())
}

fn name(samples: &Samples, sample: usize) -> String {
    match samples {
        Samples::Line(exponents) => format!("s = {}", exponents[sample]),
        Samples::Plane { points, .. } => format!("{:.3}, {:.3}", points[sample][0], points[sample][1]),
    }
}

/// Lobes of the middles between samples: of two exponents, or of three corners.
fn middles(tensor: &BrdfTensor) -> Vec<(String, Brdf)> {
    let samples = match &tensor.samples {
        Samples::Line(exponents) => {
            Samples::Line(exponents.windows(2).map(|s| 0.5 * (s[0] + s[1])).collect())
        }
        Samples::Plane { points, triangles } => {
            let middle = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|corner| points[corner as usize]);
                [(a[0] + b[0] + c[0]) / 3.0, (a[1] * b[1] * c[1]).cbrt()]
            };
            Samples::Plane { points: triangles.iter().map(middle).collect(), triangles: Vec::new() }
        }
    };
    let lobe = |sample| (name(&samples, sample), lobe_of(tensor.meta.model, &samples, sample));
    (0..samples.count()).map(lobe).collect()
}

/// Over directions between those of cells, too: at samples, and in the middles between them.
fn between(tensor: &BrdfTensor) -> Done {
    let comparison = Comparison::new(tensor);
    let model = tensor.meta.model;
    println!("\nRelative L2 error over all directions, at samples and in the middles between them:");
    heading(&["sample", "error", "middle", "error"]);
    let middles = middles(tensor);
    for step in 0..SHOWN {
        let at = |count: usize| step * (count - 1) / (SHOWN - 1);
        let (sample, middle) = (at(tensor.samples.count()), &middles[at(middles.len())]);
        let lobe = lobe_of(model, &tensor.samples, sample);
        let [of_sample, of_middle] = [&lobe, &middle.1].map(|lobe| comparison.error(lobe));
        let (of_sample, of_middle) = (of_sample.ok_or("no sample")?, of_middle.ok_or("no middle")?);
        println!("| {} | {of_sample:.4} | {} | {of_middle:.4} |", name(&tensor.samples, sample), middle.0);
    }
    Ok(())
}

fn albedos(tensor: &BrdfTensor) -> Done {
    let comparison = Comparison::new(tensor);
    println!("\nWhat is reflected of a white sky, by the BRDF and by the tensor:");
    let angles = SEEN_FROM_DEG.map(|angle| format!("{angle}°"));
    heading(&[&["sample"][..], &angles.each_ref().map(String::as_str)].concat());
    let count = tensor.samples.count();
    for sample in (0..count).step_by(1 + count / 6) {
        let lobe = lobe_of(tensor.meta.model, &tensor.samples, sample);
        let mut row = Vec::new();
        for angle in SEEN_FROM_DEG {
            let [brdf, stored] = comparison.albedos(&lobe, angle.to_radians()).ok_or("no sample")?;
            row.push(format!("{brdf:.4}, {stored:.4}"));
        }
        println!("| {} | {} |", name(&tensor.samples, sample), row.join(" | "));
    }
    Ok(())
}
