//! Carries out each command of the command line; returns what to print.

mod bundle_path;
mod chart;
mod common;
mod first_scene;
mod gallery;
mod reference;
mod regions;
mod run;
mod shell;
mod spheres;

use bundle_path::expect_no_scene;
pub use chart::chart;
use common::{BUNDLES, asked, load, look_at};
pub use first_scene::new;
pub use gallery::gallery;
pub use reference::reference;
pub use run::{merge, run};
pub use shell::{completions, man};
pub use spheres::spheres;

use crate::cli::{ExportArgs, InfoArgs, PathArgs, PlanArgs, TablesArgs};
use relume_bake::error::Result;
use relume_bake::inspect;
use relume_bake::job::{Job, ProgressMode, watch_signals};
use relume_bake::output::create_folder;
use relume_bake::paintings::paintings;
use relume_chart::plan;
use relume_formats::container::Stored;
use relume_formats::kinds::{HaarTable, VisibilityTable};
use relume_scenes::starter::is_model;
use std::path::Path;

/// `bake plan`.
pub fn plan(args: &PlanArgs) -> Result<String> {
    watch_signals()?;
    let folders =
        plan::Folders { bundles: Path::new(BUNDLES), charts: Path::new(relume_chart::chart::FOLDER) };
    let model = Path::new(&args.scene);
    let scene = if is_model(model) { first_scene::unwritten(model)? } else { load(&args.scene)? };
    let asked = asked(&args.asked, &scene);
    look_at(&scene, asked.size)?;
    plan::plan(&scene, &asked, &folders, args.json)
}

/// `bake info`.
pub fn info(args: &InfoArgs) -> Result<String> {
    expect_no_scene(&args.path)?;
    Ok(inspect::info(&args.path, args.json)?)
}

/// `bake verify`.
pub fn verify(args: &PathArgs) -> Result<String> {
    expect_no_scene(&args.path)?;
    Ok(inspect::verify(&args.path)?)
}

/// `bake export`.
pub fn export(args: &ExportArgs) -> Result<String> {
    watch_signals()?;
    let path = Path::new(&args.what);
    // A bundle that is not finished says so better than a scene that is not there.
    let is_of_bundle = ["manifest.json", "unfinished"].iter().any(|name| path.join(name).exists());
    let is_bundle = path.extension().is_some_and(|e| e == "relume") || is_of_bundle;
    let files = if is_bundle {
        inspect::export_file(path, &args.output)?
    } else {
        let scene = load(&args.what)?;
        // They take longest and may fail: before anything is written.
        let paintings = paintings(&scene, &Job::new(ProgressMode::Auto))?;
        let files = inspect::export_scene(&scene, &args.output)?;
        [files, regions::export(&scene, &paintings, &args.output)?].concat()
    };
    Ok(files.iter().map(|f| format!("{}\n", f.display())).collect())
}

/// `bake tables`.
pub fn tables(args: &TablesArgs) -> Result<String> {
    create_folder(&args.output)?;
    let line = |path: &Path, file: &[u8]| format!("{}: {} bytes\n", path.display(), file.len());
    let [haar, visibility] =
        ["haar-table.relume", "visibility-table.relume"].map(|name| args.output.join(name));
    let text = line(&haar, &HaarTable::bake().write_file(&haar)?);
    Ok(text + &line(&visibility, &VisibilityTable::bake().write_file(&visibility)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_go_into_a_folder_that_is_made_and_their_sizes_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("deeper/tables");
        let said = tables(&TablesArgs { output: output.clone() }).unwrap();
        let line = |name: &str| {
            let path = output.join(name);
            format!("{}: {} bytes\n", path.display(), std::fs::metadata(&path).unwrap().len())
        };
        assert_eq!(said, ["haar-table.relume", "visibility-table.relume"].map(line).concat());
    }
}
