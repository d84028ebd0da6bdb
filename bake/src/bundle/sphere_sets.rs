//! The sphere sets that a scene's objects ask for. They come before the methods, so that an object without a
//! solid is found before hours of tracing.

use super::publish::is_readable;
use crate::error::Result;
use crate::job::{Job, say};
use crate::spheres::fit::{self, DEFAULT_ITERATIONS, Settings};
use crate::spheres::motion::poses;
use crate::stage::Stage;
use crate::unfinished::work::has_log;
use crate::unfinished::{Leftover, Work};
use relume_formats::container::{Stored, replace_file};
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::manifest::{FileEntry, Manifest, SphereSetEntry, sphere_set_file};
use relume_formats::{Error, Place};
use relume_scenes::{Mesh, Object, Scene};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Raised whenever the same mesh and settings come to other spheres.
const REVISION: u32 = 0;
/// The one piece of a set's log: its file.
const WHOLE: u32 = 0;

// What a scene may ask for can be fitted.
const _: () = assert!(relume_scenes::MAX_SPHERES as usize <= fit::MAX_SPHERES);

/// What an object's spheres came to.
#[derive(Debug, Clone, PartialEq)]
pub struct SphereSetSummary {
    /// Name of the object.
    pub object: String,
    /// What the manifest says of it.
    pub entry: SphereSetEntry,
    /// `None` if an earlier bake had fitted them.
    pub fitted: Option<Fitted>,
}

/// Spheres of this bake.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The set.
    pub set: SphereSet,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// Spheres that an object asks for.
#[derive(Clone, Copy)]
struct FitRequest<'a> {
    object: &'a Object,
    /// Where its vertices are in the poses that the fit looks at.
    poses: &'a [Vec<[f32; 3]>],
    settings: &'a Settings,
    /// Everything that decides what the spheres are.
    asked: &'a BTreeMap<String, Value>,
}

/// The sets of all objects that want one, in their order; those of `old`, a bundle in `folder`, are reused if
/// mesh and settings are the same.
///
/// `None` if others fit some of them.
///
/// # Errors
/// If an object encloses nothing, a file cannot be written, or the user asks to stop; finished sets stay in
/// their logs.
pub(super) fn fit_all(
    scene: &Scene,
    seed: u64,
    old: Option<&Manifest>,
    folder: &Path,
    work: &Work<'_>,
) -> Result<Option<Vec<SphereSetSummary>>> {
    let with_spheres = scene.objects.iter().filter_map(|object| Some((object, object.spheres?)));
    let one = |(number, (object, spheres)): (u32, (&Object, u32))| {
        let settings =
            Settings { spheres: spheres as usize, seed, iterations: DEFAULT_ITERATIONS, tight: 0.0 };
        let poses = object.shape.as_deref().map(poses).unwrap_or_default();
        let asked = asked_for(&settings, &object.mesh, &poses);
        let request = FitRequest { object, poses: &poses, settings: &settings, asked: &asked };
        let may_reuse = work.leftover != Leftover::Discard && !has_log(work.unfinished, &log_of(object));
        let reusable = old.filter(|_| may_reuse).and_then(|old| reusable_entry(old, folder, object, &asked));
        let (entry, fitted) = match reusable {
            Some(entry) => (entry, None),
            None => {
                let fit = Fit { request, scene, number, job: work.job };
                let Some((file, fitted)) = fit_one(&fit, work)? else { return Ok(None) };
                (SphereSetEntry { file, settings: asked }, fitted)
            }
        };
        Ok(Some(SphereSetSummary { object: object.name.clone(), entry, fitted }))
    };
    // All are begun, whoever has the others.
    let sets = (0..).zip(with_spheres).map(one).collect::<Result<Vec<Option<SphereSetSummary>>>>()?;
    Ok(sets.into_iter().collect())
}

/// Everything that decides what the spheres are.
fn asked_for(settings: &Settings, mesh: &Mesh, poses: &[Vec<[f32; 3]>]) -> BTreeMap<String, Value> {
    let asked = [
        ("revision", json!(REVISION)),
        ("spheres", json!(settings.spheres)),
        ("seed", json!(settings.seed)),
        ("iterations", json!(settings.iterations)),
        ("mesh_hash", json!(mesh_hash(mesh, poses))),
    ];
    asked.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// xxh3-128 of triangles and positions, at rest and in the poses that are looked at, hexadecimal.
fn mesh_hash(mesh: &Mesh, poses: &[Vec<[f32; 3]>]) -> String {
    let mut hash = Xxh3::new();
    hash.update(&(mesh.positions.len() as u64).to_le_bytes());
    hash.update(bytemuck::cast_slice(&mesh.positions));
    hash.update(bytemuck::cast_slice(&mesh.triangles));
    poses.iter().for_each(|pose| hash.update(bytemuck::cast_slice(pose)));
    format!("{:032x}", hash.digest128())
}

fn log_of(object: &Object) -> String {
    let file = sphere_set_file(&object.name);
    file.trim_end_matches(".relume").to_owned()
}

fn reusable_entry(
    old: &Manifest,
    folder: &Path,
    object: &Object,
    asked: &BTreeMap<String, Value>,
) -> Option<SphereSetEntry> {
    let entry = old.sphere_sets.get(&object.name)?;
    (entry.settings == *asked && is_readable(&entry.file, folder)).then(|| entry.clone())
}

/// The set's file, from the log of an interrupted bake or fitted anew; `None` if others fit it.
fn fit_one(fit: &Fit<'_>, work: &Work<'_>) -> Result<Option<(FileEntry, Option<Fitted>)>> {
    let file = sphere_set_file(&fit.request.object.name);
    let path = work.unfinished.join(&file);
    let Some(log) = work.run(fit)? else { return Ok(None) };
    let traced = work.take_traced();
    let bytes = log.read(WHOLE)?;
    replace_file(&path, &bytes)?;
    let fitted = (traced.pieces > 0)
        .then(|| Ok::<_, Error>(Fitted { set: SphereSet::read_file(&path)?, seconds: traced.seconds }));
    Ok(Some((FileEntry::of(&file, &bytes), fitted.transpose()?)))
}

/// Fitting the spheres of one object: one piece, the file.
struct Fit<'a> {
    request: FitRequest<'a>,
    scene: &'a Scene,
    /// Among the objects with spheres.
    number: u32,
    job: &'a Job,
}

impl Stage for Fit<'_> {
    fn name(&self) -> String {
        log_of(self.request.object)
    }

    fn label(&self) -> Option<&'static str> {
        None
    }

    fn key(&self) -> u128 {
        xxh3_128(json!(self.request.asked).to_string().as_bytes())
    }

    fn pieces(&self) -> u32 {
        1
    }

    fn piece(&self, _: u32) -> Result<Vec<u8>> {
        let FitRequest { object, poses, settings, .. } = self.request;
        let place = Place::file(&self.scene.file).part(format!("object `{}`", object.name));
        let fitted = fit::fit(&object.mesh, poses, &object.name, &place, settings, self.job)?;
        fitted.notes.iter().for_each(|note| say(&format!("warning: {note}")));
        Ok(fitted.set.to_bytes(place)?)
    }

    fn first_share(&self) -> u32 {
        self.number
    }
}
