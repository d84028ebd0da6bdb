//! What sweeps have in common: each method bakes as few bundles as it can and cuts the others out of them.

use relume_bake::bundle;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::Job;
use relume_bake::method::Method;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::registered::Registered;
use relume_bake::output::create_folder;
use relume_bake::unfinished::Leftover;
use relume_formats::container::Stored;
use relume_formats::kinds::Manifest;
use relume_formats::kinds::manifest::{self, FileEntry};
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A point of the chart before it is measured: a bundle of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// The method.
    pub method: &'static str,
    /// Variants of one series differ in one setting.
    pub series: String,
    /// What the setting is, in a few characters.
    pub label: String,
    /// All settings that tell it from others.
    pub settings: BTreeMap<String, Value>,
    /// The bundle.
    pub folder: PathBuf,
    /// Wall-clock seconds of the bake that it is, or that it was cut out of.
    pub bake_seconds: f64,
}

/// A method's sweep.
pub struct Sweep {
    /// The method.
    pub method: &'static Registered,
    /// Makes the bundles.
    pub variants: fn(&Scene, &Bench<'_>) -> Result<Vec<Variant>>,
}

/// The one variant of a method without a sweep: what a bake of `scene` with the settings of `bake run`
/// leaves.
///
/// # Errors
/// As [`bundle::run`].
pub fn by_default(method: &'static Registered, scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let name = method.card.name;
    let bake = (method.new)(&Asked { size: bench.size, ..Asked::of_scene(scene) }, scene);
    let settings = bake.asked_for();
    let Baked { folder, seconds } = bench.bake(scene, bake, name)?;
    let [series, label] = ["default", "as `bake run` bakes it"].map(str::to_owned);
    Ok(vec![Variant { method: name, series, label, settings, folder, bake_seconds: seconds }])
}

/// Where bundles are made.
pub struct Bench<'a> {
    /// Folder of this chart's work; nothing in it belongs to another scene.
    pub folder: &'a Path,
    /// Film size in pixels.
    pub size: [u32; 2],
    /// For progress and interruption.
    pub job: &'a Job,
}

/// A bundle, and the seconds that its bake took.
pub struct Baked {
    /// Its folder.
    pub folder: PathBuf,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl Bench<'_> {
    /// Bakes `scene` by `method` into the folder `name`, or goes on with what is there.
    ///
    /// # Errors
    /// As [`bundle::run`].
    pub fn bake(&self, scene: &Scene, method: Box<dyn Method>, name: &str) -> Result<Baked> {
        let folder = self.folder.join(name);
        bundle::run(scene, &[method], self.size, &folder, Leftover::Resume, 0, &self.job.anew())?;
        let seconds = relume_bake::report::seconds(&folder).unwrap_or(f64::NAN);
        Ok(Baked { folder, seconds })
    }

    /// Makes the folder `name` a copy of the bundle in `from` with other contents of some of its files.
    ///
    /// # Errors
    /// If a file cannot be read or written.
    pub fn cut(
        &self,
        from: &Path,
        name: &str,
        write: impl FnOnce(&mut Cut<'_>) -> Result<()>,
    ) -> Result<PathBuf> {
        let folder = self.folder.join(name);
        create_folder(&folder)?;
        let mut manifest = Manifest::read(from)?;
        for entry in manifest.entries() {
            copy(&from.join(&entry.file), &folder.join(&entry.file))?;
        }
        write(&mut Cut { folder: &folder, manifest: &mut manifest })?;
        manifest.validate(&Place::file(folder.join(manifest::FILE_NAME)))?;
        manifest.write(&folder)?;
        Ok(folder)
    }
}

/// A bundle that is being cut.
pub struct Cut<'a> {
    folder: &'a Path,
    manifest: &'a mut Manifest,
}

impl Cut<'_> {
    /// Gives the first method's file of the kind of `content` this content.
    ///
    /// # Errors
    /// If there is no such file, or it cannot be written.
    pub fn replace<S: Stored>(&mut self, content: &S) -> Result<()> {
        let place = Place::file(self.folder);
        let mut files = self.manifest.methods.iter_mut().flat_map(|method| &mut method.files);
        let entry = files.find(|(kind, _)| *kind == S::KIND.name());
        let (_, entry) = entry
            .ok_or_else(|| BakeError::invalid(&place, format!("has no file of kind {}", S::KIND.name())))?;
        let path = self.folder.join(&entry.file);
        // A new file, so the bundle that this is cut from keeps the old one.
        *entry = FileEntry::of(&entry.file, &content.write_file(&path)?);
        Ok(())
    }

    /// Says that the first method was baked with `value` for its setting `name`.
    pub fn set(&mut self, name: &str, value: Value) {
        if let Some(method) = self.manifest.methods.first_mut() {
            method.settings.insert(name.to_owned(), value);
        }
    }
}

/// Links where the file system can, for bundles are large.
fn copy(from: &Path, to: &Path) -> Result<()> {
    let _ = std::fs::remove_file(to);
    let copied = std::fs::hard_link(from, to).or_else(|_| std::fs::copy(from, to).map(drop));
    Ok(copied.map_err(|e| Error::output(&Place::file(to), e))?)
}

/// Reads the first file of a kind that the manifest of the bundle in `folder` lists.
///
/// # Errors
/// If there is none or it cannot be read.
pub fn read<S: Stored>(folder: &Path) -> Result<S> {
    let manifest = Manifest::read(folder)?;
    let file =
        manifest.methods.iter().flat_map(|method| &method.files).find(|(kind, _)| *kind == S::KIND.name());
    let (_, entry) = file.ok_or_else(|| {
        BakeError::invalid(&Place::file(folder), format!("has no file of kind {}", S::KIND.name()))
    })?;
    Ok(S::read_file(&folder.join(&entry.file))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweeps::{sparse_transfer, transfer_images};
    use relume_bake::inspect::verify;
    use relume_bake::job::ProgressMode;

    const ROOM: &str = "
        [vary]
        VARY
        [render]
        size = [16, 16]
        [camera]
        position = [0.0, 1.0, 4.0]
        target = [0.0, 0.4, 0.0]
        fov_deg = 45.0
        [materials.clay]
        brdf = 'blinn-phong'
        kd = [0.5, 0.5, 0.5]
        [[object]]
        name = 'ball'
        shape = 'sphere'
        subdivisions = 1
        material = 'clay'
        transform = { translation = [0.0, 0.5, 0.0], scale = 0.5 }
        [[object]]
        name = 'floor'
        shape = 'quad'
        segments = 4
        material = 'clay'
        transform = { scale = 4.0 }
        [environment]
        file = 'lamps'
    ";

    #[test]
    fn without_a_sweep_there_is_what_a_bake_leaves() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, ROOM.replace("VARY", "materials = ['clay']")).unwrap();
        let scene = relume_scenes::load(&path).unwrap();
        let bench = Bench { folder: folder.path(), size: [8, 8], job: &Job::new(ProgressMode::None) };
        let method = transfer_images::SWEEP.method;
        let [variant] = by_default(method, &scene, &bench).unwrap().try_into().unwrap();
        verify(&variant.folder).unwrap();
        let listed = &Manifest::read(&variant.folder).unwrap().methods[0];
        assert_eq!((&listed.name[..], variant.method), ("transfer-images", "transfer-images"));
        assert!(variant.settings.iter().all(|(name, value)| listed.settings.get(name) == Some(value)));
        assert_eq!(
            (&variant.settings["size"], &variant.settings["max_error"]),
            (&serde_json::json!([8, 8]), &scene.max_error.into())
        );
    }

    /// Variants of a sweep are told apart by their settings, are bundles that pass every check, and what they
    /// are cut from still does.
    #[test]
    fn variants_are_sound_bundles() {
        for (sweep, vary, count) in [
            (&transfer_images::SWEEP, "materials = ['clay']", 18),
            (&sparse_transfer::SWEEP, "light = true", 11),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("scene.toml");
            std::fs::write(&path, ROOM.replace("VARY", vary)).unwrap();
            let scene = relume_scenes::load(&path).unwrap();
            assert!(sweep.method.serves_all(&scene.vary));
            let bench = Bench { folder: folder.path(), size: [16, 16], job: &Job::new(ProgressMode::None) };
            let variants = (sweep.variants)(&scene, &bench).unwrap();
            assert_eq!(variants.len(), count);
            for (number, variant) in variants.iter().enumerate() {
                verify(&variant.folder).unwrap();
                assert!(variant.bake_seconds > 0.0, "{variant:?}");
                let same =
                    |other: &&Variant| other.settings == variant.settings || other.folder == variant.folder;
                assert_eq!(variants[..number].iter().find(same), None, "{variant:?}");
            }
            // A second run finds all bakes done.
            assert_eq!((sweep.variants)(&scene, &bench).unwrap(), variants);
        }
    }
}
