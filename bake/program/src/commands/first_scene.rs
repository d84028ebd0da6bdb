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
use relume_formats::kinds::manifest::FILE_NAME as MANIFEST;
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
    let settings =
        Settings { size, samples, seed: 0, reflections: scene.reflections, paths: Paths::Best, target: None };
    let images = reference::render(
        &scene,
        std::slice::from_ref(&scene),
        &[],
        &settings,
        &Job::new(ProgressMode::None),
    )?;
    let display = Display { exposure_ev: scene.camera.exposure_ev, tonemap: scene.tonemap };
    let shown: Vec<_> =
        images.into_iter().flat_map(|image| image.radiance).map(|radiance| display.shown(radiance)).collect();
    replace_file(preview, &picture::alone(&shown, size, 0.0)?)?;
    if let Err(error) = replace_file(scene_file, text.as_bytes()) {
        let _ = std::fs::remove_file(preview);
        return Err(error.into());
    }
    let (scene_file, preview) = (scene_file.display(), preview.display());
    Ok(format!(
        "{scene_file}\n{preview}\nlook at the picture, change the scene as you like, then: bake run {scene_file}\n"
    ))
}

/// The scene of a model, in a file beside the bundle of it.
pub(super) struct Beside {
    /// The scene.
    pub scene: Scene,
    /// Folder of the bundle.
    pub folder: PathBuf,
    /// The scene's.
    file: PathBuf,
    /// Of a file that is not there yet, and what it is for.
    unwritten: Option<(String, PathBuf)>,
}

impl Beside {
    /// The scene that is there already, if it is of `model`, or the first one for it. Nothing is written yet.
    ///
    /// # Errors
    /// If the model cannot be read, or what is there is of another one; a bundle without a scene beside it may
    /// be anybody's, and is replaced only if that `replaces`.
    pub(super) fn of(model: &Path, folder: Option<&Path>, replaces: bool) -> Result<Self> {
        let folder = folder.map_or_else(|| Path::new(BUNDLES).join(name_of(model)), Path::to_path_buf);
        if folder.file_name().is_none() {
            let reason = "has no name that the scene's file could have; name a folder for the bundle";
            return Err(BakeError::invalid(&Place::file(&folder), reason));
        }
        let file = scene_file_of(&folder);
        if file.exists() {
            expect_scene_of(model, &file)?;
            note(&format!(
                "note: bakes {}, which is there already; to have it written anew, remove it and add --force",
                file.display()
            ));
            return Ok(Self { scene: load(&file.to_string_lossy())?, folder, file, unwritten: None });
        }
        if !replaces && folder.join(MANIFEST).exists() {
            let reason = format!(
                "holds a bundle, and there is no {} to say that it is of {}; give another folder with -o, or add --force to replace it",
                file.display(),
                model.display()
            );
            return Err(BakeError::invalid(&Place::file(&folder), reason));
        }
        let (text, scene) = first_scene(model, &file, None)?;
        Ok(Self { scene, folder, file, unwritten: Some((text, model.to_path_buf())) })
    }

    /// Writes the scene file, if it is not there.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write(&self) -> Result<()> {
        let Some((text, model)) = &self.unwritten else { return Ok(()) };
        if let Some(above) = self.file.parent().filter(|above| !above.as_os_str().is_empty()) {
            create_folder(above)?;
        }
        replace_file(&self.file, text.as_bytes())?;
        let (file, model) = (self.file.display(), model.display());
        note(&format!("note: wrote {file}, a first scene for {model}; change it as you like"));
        Ok(())
    }
}

/// Where the first scene of the bundle in `folder` is.
fn scene_file_of(folder: &Path) -> PathBuf {
    // Without a slash at the end.
    let mut file = folder.components().as_path().as_os_str().to_owned();
    file.push(".toml");
    PathBuf::from(file)
}

fn expect_scene_of(model: &Path, file: &Path) -> Result<()> {
    let names = Starter::file_line(model, file)?;
    let text = std::fs::read_to_string(file).unwrap_or_default();
    if text.contains(&names) {
        return Ok(());
    }
    let reason = format!(
        "is there already and no scene of {}; give another folder with -o, or remove it",
        model.display()
    );
    Err(BakeError::invalid(&Place::file(file), reason))
}

/// Fails if the bundle in `folder`, where `scene` goes by its name, is of the first scene of a model that is
/// called the same.
///
/// # Errors
/// `Invalid` with the remedy.
pub(super) fn expect_no_other(scene: &Scene, folder: &Path) -> Result<()> {
    let file = scene_file_of(folder);
    let is_same = |other: &Path| Some(scene.file.canonicalize().ok()? == other.canonicalize().ok()?);
    if !folder.join(MANIFEST).exists() || is_same(&file).unwrap_or(true) {
        return Ok(());
    }
    let reason = format!(
        "holds the bundle of {}, not of {}; give another folder with -o, or add --force to replace it",
        file.display(),
        scene.file.display()
    );
    Err(BakeError::invalid(&Place::file(folder), reason))
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
