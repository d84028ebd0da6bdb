//! Tables in Markdown. Errors are relative, not squared, in the metric of natural light; of a space the root
//! mean square over samples.

use relume_bake::brdf::tensor::{CONES, Comparison, SOURCE_CONES, Size, SpaceTensor, lobe_of, samples_of};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::{Cone, Samples};
use relume_formats::state::{Brdf, Model};
use std::error::Error;
use std::time::Instant;

type Done = Result<(), Box<dyn Error>>;

/// Columns of a vertex beside the diffuse one, at most.
const COLUMNS: usize = 16;
/// Columns of materials and of outgoing angles.
const RANKS: [usize; 5] = [3, 4, 6, 8, 12];
/// Samples that are shown one by one.
const SHOWN: usize = 12;
/// Angles from the normal, degrees.
const SEEN_FROM_DEG: [f64; 7] = [0.0, 30.0, 50.0, 65.0, 75.0, 82.5, 85.0];

/// All of `model`.
pub fn print(model: Model) -> Done {
    println!("## {}", model.name());
    let started = Instant::now();
    let space = SpaceTensor::new(model, samples_of(model));
    let tabulated = started.elapsed().as_secs_f64();
    let tensor = space.decomposed(&Size::default())?;
    let made = started.elapsed().as_secs_f64();
    println!("\nMade in {made:.1} s, {tabulated:.1} s of them for lobes. Orders {:?}.", tensor.orders);
    by_columns(&space)?;
    by_ranks(&space)?;
    with_sources_cones(&space)?;
    lobes(&tensor)?;
    albedos(&tensor)
}

fn heading(columns: &[&str]) {
    println!("\n| {} |\n|{}", columns.join(" | "), "---|".repeat(columns.len()));
}

fn by_columns(space: &SpaceTensor) -> Done {
    println!("\nError by columns of a vertex beside the diffuse one:");
    let columns: Vec<String> = (0..=COLUMNS).step_by(2).map(|n| n.to_string()).collect();
    heading(&[&["cones"][..], &columns.iter().map(String::as_str).collect::<Vec<_>>()].concat());
    let fans: [(&str, &[Cone]); 3] = [("none", &[]), ("the source's 4", &SOURCE_CONES), ("16", &CONES)];
    for (name, cones) in fans {
        let errors = space.errors(cones, COLUMNS)?;
        let errors: Vec<String> = errors.iter().step_by(2).map(|error| format!("{error:.4}")).collect();
        println!("| {name} | {} |", errors.join(" | "));
    }
    Ok(())
}

fn by_ranks(space: &SpaceTensor) -> Done {
    println!(
        "\nError of all by columns of materials (rows) and of outgoing angles, of a vertex those of files:"
    );
    let columns: Vec<String> = RANKS.iter().map(ToString::to_string).collect();
    heading(&[&[""][..], &columns.iter().map(String::as_str).collect::<Vec<_>>()].concat());
    for of_materials in RANKS {
        let mut errors = Vec::new();
        for of_outgoing in RANKS {
            let size = Size { ranks: [of_materials, of_outgoing], ..Size::default() };
            errors.push(format!("{:.4}", space.decomposed(&size)?.meta.whole.sqrt()));
        }
        println!("| {of_materials} | {} |", errors.join(" | "));
    }
    Ok(())
}

fn with_sources_cones(space: &SpaceTensor) -> Done {
    println!(
        "\nErrors of whole tensors, and before the last fit of materials, outgoing and incoming directions alone:"
    );
    heading(&["cones", "columns of a vertex", "left by cones", "error", "materials", "outgoing", "incoming"]);
    for (cones, columns) in [(&SOURCE_CONES[..], 8), (&CONES, 2), (&CONES, 4), (&CONES, 8)] {
        let m = space.decomposed(&Size { cones: cones.to_vec(), columns, ..Size::default() })?.meta;
        let errors = [m.residual, m.whole, m.materials, m.outgoing, m.incoming];
        let errors = errors.map(|error| format!("{:.4}", error.sqrt())).join(" | ");
        println!("| {} | {columns} | {errors} |", cones.len());
    }
    Ok(())
}

fn name(samples: &Samples, sample: usize) -> String {
    match samples {
        Samples::Line(exponents) => format!("s = {:.1}", exponents[sample]),
        Samples::Plane { points, .. } => format!("{:.3}, {:.3}", points[sample][0], points[sample][1]),
    }
}

/// The middles between samples: of two exponents, or of three corners.
fn middles(samples: &Samples) -> Samples {
    match samples {
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
    }
}

/// Some lobes of `samples`, spread evenly.
fn shown(model: Model, samples: &Samples, count: usize) -> Vec<(String, Brdf)> {
    let at = |step: usize| step * (samples.count() - 1) / (count - 1);
    (0..count).map(|step| (name(samples, at(step)), lobe_of(model, samples, at(step)))).collect()
}

/// At samples, and in the middles between them.
fn lobes(tensor: &BrdfTensor) -> Done {
    let (comparison, model) = (Comparison::new(tensor), tensor.meta.model);
    println!(
        "\nError of single lobes, over all angles and seen from some, and in the middles between samples:"
    );
    let angles = SEEN_FROM_DEG.map(|angle| format!("{angle}°"));
    let columns = ["sample", "error", "middle", "error"];
    heading(&[&columns[..2], &angles.each_ref().map(String::as_str), &columns[2..]].concat());
    let middles = shown(model, &middles(&tensor.samples), SHOWN);
    for ((name, lobe), (middle, between)) in shown(model, &tensor.samples, SHOWN).iter().zip(middles) {
        let error = |lobe| comparison.error(lobe).ok_or("no sample");
        let seen = |angle: f64| {
            let [off, whole] = comparison.squares(lobe, &[angle.to_radians()]).unwrap_or([f64::NAN; 2]);
            // A lobe that reflects as good as nothing from there.
            if off > whole { "–".to_owned() } else { format!("{:.3}", (off / whole).sqrt()) }
        };
        let seen = SEEN_FROM_DEG.map(seen).join(" | ");
        println!("| {name} | {:.4} | {seen} | {middle} | {:.4} |", error(lobe)?, error(&between)?);
    }
    Ok(())
}

fn albedos(tensor: &BrdfTensor) -> Done {
    let comparison = Comparison::new(tensor);
    println!("\nWhat is reflected of a white sky, by the BRDF and by the tensor:");
    let angles = SEEN_FROM_DEG.map(|angle| format!("{angle}°"));
    heading(&[&["sample"][..], &angles.each_ref().map(String::as_str)].concat());
    for (name, lobe) in shown(tensor.meta.model, &tensor.samples, 8) {
        let mut row = Vec::new();
        for angle in SEEN_FROM_DEG {
            let [brdf, stored] = comparison.albedos(&lobe, angle.to_radians()).ok_or("no sample")?;
            row.push(format!("{brdf:.4}, {stored:.4}"));
        }
        println!("| {name} | {} |", row.join(" | "));
    }
    Ok(())
}
