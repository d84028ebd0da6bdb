//! `bake spheres`, and what is said of sphere sets.

use super::common::start_threads;
use crate::cli::SpheresArgs;
use relume_bake::bundle::SphereSetSummary;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, say, watch_signals};
use relume_bake::output::expect_writable;
use relume_bake::report;
use relume_bake::spheres::fit::{Settings, fit};
use relume_bake::spheres::motion::poses;
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::counts::counted;
use relume_formats::kinds::SphereSet;
use relume_scenes::{Deforming, Mesh};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// `bake spheres`.
pub fn spheres(args: &SpheresArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let output = output_file(args)?;
    let mut warnings = Vec::new();
    let (mesh, poses) = load(&args.mesh, &mut warnings)?;
    warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
    // A fit may take long; that its file has nowhere to go had better be known before.
    expect_writable(&output)?;
    let name = args.mesh.file_name().unwrap_or_default().to_string_lossy();
    let settings = Settings {
        spheres: args.count as usize,
        seed: args.seed,
        iterations: args.iterations,
        tight: args.tight,
    };
    let start = Instant::now();
    let fitted = fit(&mesh, &poses, &name, &Place::file(&args.mesh), &settings, &Job::new(args.progress))?;
    fitted.notes.iter().for_each(|note| say(&format!("warning: {note}")));
    let bytes = fitted.set.write_file(&output)?.len();
    write_report(&output, start.elapsed().as_secs_f64())?;
    Ok(format!("{name}: {}{}, {bytes} bytes\n", describe(&fitted.set), output.display()))
}

/// A mesh, and the poses of its clips where it has some.
fn load(path: &Path, warnings: &mut Vec<String>) -> Result<(Mesh, Vec<Vec<[f32; 3]>>)> {
    let mut deforming_warnings = Vec::new();
    match relume_scenes::load_deforming(path, &mut deforming_warnings) {
        Ok(Deforming { rest, shape }) => {
            warnings.append(&mut deforming_warnings);
            Ok((rest, poses(&shape)))
        }
        // A file of another kind has no clips; clips that are broken need not keep a mesh from its spheres.
        Err(error) => {
            let mesh = relume_scenes::load_mesh(path, warnings)?;
            if ["gltf", "glb"]
                .iter()
                .any(|e| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(e)))
            {
                warnings
                    .push(format!("{error}; the spheres are fitted at rest, without a look at its clips"));
            }
            Ok((mesh, Vec::new()))
        }
    }
}

/// Where the set goes. Other commands know it by the end of its name.
fn output_file(args: &SpheresArgs) -> Result<PathBuf> {
    let stem = args.mesh.file_stem().unwrap_or_default().to_string_lossy();
    let output =
        args.output.clone().unwrap_or_else(|| format!("{stem}-spheres-{}.relume", args.count).into());
    if output.extension().is_none_or(|e| e != "relume") {
        return Err(BakeError::invalid(
            &Place::file(&output),
            "sphere sets are written as .relume; end the name so",
        ));
    }
    Ok(output)
}

fn write_report(output: &Path, seconds: f64) -> Result<()> {
    let file = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let sets = Map::from_iter([(file, Value::Object(report::facts(seconds)))]);
    let folder = output.parent().unwrap_or(Path::new(""));
    Ok(report::merge(folder, Map::from_iter([(report::SPHERES.to_owned(), Value::Object(sets))]))?)
}

/// What `bake run` says of an object's spheres.
pub(super) fn describe_stage(scene: &str, summary: &SphereSetSummary) -> String {
    let SphereSetSummary { object, fitted, .. } = summary;
    match fitted {
        Some(fitted) => format!("{scene}: object `{object}`: {}", describe(&fitted.set)),
        None => format!("{scene}: object `{object}`: spheres up to date, reused\n"),
    }
}

/// How good a fit is; lengths in parts of the diagonal, as meshes are of any size.
fn describe(set: &SphereSet) -> String {
    let quality = &set.meta.quality;
    let (surface, volume) = (100.0 * quality.coverage_surface, 100.0 * quality.coverage_volume);
    let protrusion = &quality.protrusion;
    let share = |length: f64| 100.0 * length / f64::from(set.meta.diagonal);
    format!(
        "{}, E/V(T) {:.4}\n\
         coverage: {surface:.3} % of the surface, {volume:.3} % of the volume, largest gap {:.3} % of the diagonal\n\
         protrusion: mean {:.3} %, 95th percentile {:.3} %, largest {:.3} % of the diagonal\n",
        counted(set.spheres.len(), "sphere", "spheres"),
        set.meta.relative_outside_volume(),
        share(quality.largest_gap),
        share(protrusion.mean),
        share(protrusion.p95),
        share(protrusion.max)
    )
}
