//! `bake new`, and the scenes that `bake run` and `bake plan` make of a model.

use super::common::{BUNDLES, load, look_at, start_threads, warn};
use crate::cli::NewArgs;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, ProgressMode, note, watch_signals};
use relume_bake::output::create_folder;
use relume_bake::probe::Probe;
use relume_bake::trace::reference::{self, Paths, Settings};
use relume_chart::picture;
use relume_formats::Place;
use relume_formats::container::replace_file;
use relume_formats::display::Display;
use relume_scenes::Scene;
use relume_scenes::starter::{Look, Starter, name_of};
use std::path::{Path, PathBuf};

/// Side of the picture that `bake new` makes, and its samples a pixel.
const PREVIEW: ([u32; 2], u32) = ([256, 256], 32);

/// `bake new`.
pub fn new(args: &NewArgs) -> Result<String> {
    watch_signals()?;
    start_threads(None)?;
    let [scene_file, preview] = ["scene.toml", "preview.png"].map(|name| args.output.join(name));
    [&scene_file, &preview].into_iter().try_for_each(|file| expect_nothing(file))?;
    let made = create_folder(&args.output)?;
    let written = write_new(&args.model, &scene_file, &preview, args.scale);
    if written.is_err() && made {
        // Only if nothing is in it.
        let _ = std::fs::remove_dir(&args.output);
    }
    written
}

fn write_new(model: &Path, scene_file: &Path, preview: &Path, scale: Option<f64>) -> Result<String> {
    let (text, scene) = first_scene(model, scene_file, scale)?;
    look_at(&scene, scene.size)?;
    let (size, samples) = PREVIEW;
    let settings = Settings { size, samples, seed: 0, reflections: scene.reflections, paths: Paths::Best };
    let images =
        reference::render(&scene, std::slice::from_ref(&scene), &settings, &Job::new(ProgressMode::None))?;
    let display = Display { exposure_ev: scene.camera.exposure_ev, tonemap: scene.tonemap };
    let shown: Vec<_> =
        images.into_iter().flat_map(|image| image.radiance).map(|radiance| display.shown(radiance)).collect();
    replace_file(preview, &picture::alone(&shown, size, 0.0)?)?;
    replace_file(scene_file, text.as_bytes())?;
    let (scene_file, preview) = (scene_file.display(), preview.display());
    Ok(format!(
        "{scene_file}\n{preview}\nlook at the picture, change the scene as you like, then: bake run {scene_file}\n"
    ))
}

/// The first scene for `model` for a bundle in `folder`, in a file beside that; the one that is there
/// already, if it is of this model. Returns the bundle's folder too.
pub(super) fn beside(model: &Path, folder: Option<&Path>) -> Result<(Scene, Option<PathBuf>)> {
    let folder = folder.map_or_else(|| Path::new(BUNDLES).join(name_of(model)), Path::to_path_buf);
    let mut scene_file = folder.clone().into_os_string();
    scene_file.push(".toml");
    let scene_file = PathBuf::from(scene_file);
    if let Some(above) = scene_file.parent().filter(|above| !above.as_os_str().is_empty()) {
        create_folder(above)?;
    }
    let shown = scene_file.display();
    if !scene_file.exists() {
        let (text, scene) = first_scene(model, &scene_file, None)?;
        replace_file(&scene_file, text.as_bytes())?;
        note(&format!("note: wrote {shown}, a first scene for {}; change it as you like", model.display()));
        return Ok((scene, Some(folder)));
    }
    let names = Starter::file_line(model, &scene_file)?;
    let text = std::fs::read_to_string(&scene_file).unwrap_or_default();
    if !text.contains(&names) {
        let reason = format!(
            "is there already and no scene of {}; give another folder with -o, or remove it",
            model.display()
        );
        return Err(BakeError::invalid(&Place::file(&scene_file), reason));
    }
    note(&format!("note: bakes {shown}, which is there already; remove it to have it written anew"));
    Ok((load(&scene_file.to_string_lossy())?, Some(folder)))
}

/// The first scene for `model`, which is written nowhere.
pub(super) fn unwritten(model: &Path) -> Result<Scene> {
    Ok(first_scene(model, &model.with_file_name(format!("{}.toml", name_of(model))), None)?.1)
}

/// The first scene for `model` in a file at `scene_file`, and its text. Tells what of the model is mended or
/// ignored.
fn first_scene(model: &Path, scene_file: &Path, scale: Option<f64>) -> Result<(String, Scene)> {
    let starter = Starter::of(model, scene_file, scale)?;
    let plain = starter.scene(None)?;
    let probe = Probe::new(&plain, plain.size)?;
    let look = Look { exposure_ev: probe.exposure_ev(), seen: probe.seen() };
    let scene = starter.scene(Some(&look))?;
    warn(&scene.warnings);
    Ok((starter.text(Some(&look)), scene))
}

fn expect_nothing(file: &Path) -> Result<()> {
    if !file.exists() {
        return Ok(());
    }
    Err(BakeError::invalid(&Place::file(file), "is there already; remove it, or name another folder with -o"))
}
