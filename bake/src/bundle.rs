//! From a scene to a bundle on disk: reuses what is there, resumes what was interrupted, and writes the
//! manifest last.

mod prediction;
mod publish;
mod replaced;
mod sphere_sets;
mod stored_scene;

pub use prediction::{Shared, predict_shared};
pub use sphere_sets::{Fitted, SphereSetSummary};

use crate::darkness;
use crate::error::{BakeError, Result};
use crate::job::{Job, note, say};
use crate::method::{Method, Product};
use crate::methods::asked::Asked;
use crate::output::{files, sweep_partial};
use crate::scene_hash::scene_hash;
use crate::shard::Shard;
use crate::stage::{Share, Traced};
use crate::unfinished::names::UNFINISHED;
use crate::unfinished::work::{self, has_logs, write_entry};
use crate::unfinished::{FolderLock, Leftover, Work, holds_work};
use crate::{playable, report, traced};
use publish::publish;
use relume_formats::Place;
use relume_formats::container::MAX_SECTION_BYTES;
use relume_formats::kinds::StoredScene;
use relume_formats::kinds::manifest::{self, Manifest, MethodEntry, SphereSetEntry};
use relume_formats::kinds::scene::{MAX_PIXELS, is_legal_size};
use relume_formats::name::file_of;
use relume_scenes::Scene;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Mutex;
pub use stored_scene::stored_scene;

/// What a bake came to, for the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The sphere sets, in the order of the objects.
    pub sphere_sets: Vec<SphereSetSummary>,
    /// The methods, in the order asked for.
    pub methods: Vec<MethodSummary>,
    /// Bytes of all files.
    pub bytes: u64,
    /// Whether the camera sees nothing but black.
    pub is_black: bool,
}

impl Summary {
    /// Whether anything was baked that was not there before.
    pub fn has_news(&self) -> bool {
        self.methods.iter().any(|method| method.traced.is_some())
            || self.sphere_sets.iter().any(|set| set.fitted.is_some())
    }
}

/// What a method came to.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSummary {
    /// What the manifest says of it.
    pub entry: MethodEntry,
    /// What tracing took; `None` if finished files of an earlier bake served.
    pub traced: Option<Traced>,
}

/// Bakes `scene` by `methods`, the preferred one first, into `folder`; the player's film is of `size`. `seed`
/// is that of the sphere sets: methods have their own. Nobody else bakes there before the lock is dropped.
///
/// New files are made in a folder of their own and moved when all are whole, so an older bundle stays
/// playable until then. What other methods left unfinished there stays.
///
/// # Errors
/// See [`BakeError`]; whatever happens, no file under its final name is half-written, and finished pieces
/// stay in the folder.
pub fn run(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    size: [u32; 2],
    folder: &Path,
    leftover: Leftover,
    seed: u64,
    job: &Job,
) -> Result<(Summary, FolderLock)> {
    let order = Order { folder, size, leftover, seed, shard: None };
    match make(scene, methods, &order, job)? {
        (Outcome::Bundle(summary), lock) => Ok((summary, lock)),
        (Outcome::Pieces(_), _) => {
            Err(BakeError::invalid(&Place::file(folder), "some pieces are missing; bake again with --force"))
        }
    }
}

/// Makes the pieces of `shard`, of stages that wait for no other shard, and leaves them unfinished in
/// `folder`. Everything else as [`run`], which a merge of all shards calls.
///
/// # Errors
/// As [`run`].
pub fn run_shard(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    shard: &Shard,
    folder: &Path,
    leftover: Leftover,
    job: &Job,
) -> Result<Traced> {
    let Asked { size, seed, .. } = shard.asked;
    let (outcome, _lock) =
        make(scene, methods, &Order { folder, size, leftover, seed, shard: Some(shard) }, job)?;
    Shard { done: true, ..shard.clone() }.write(folder)?;
    Ok(if let Outcome::Pieces(traced) = outcome { traced } else { Traced::default() })
}

/// How a bundle is to be made.
struct Order<'a> {
    folder: &'a Path,
    size: [u32; 2],
    leftover: Leftover,
    seed: u64,
    /// What is asked of a shard of a bake, if this is one.
    shard: Option<&'a Shard>,
}

/// Fails if a bundle of `scene` may not be put into `folder`, for it holds another.
///
/// # Errors
/// `Invalid` with the remedy.
pub fn expect_room(scene: &Scene, folder: &Path) -> Result<()> {
    publish::old_manifest(folder, &folder.join(UNFINISHED), scene, Leftover::Resume).map(drop)
}

/// Fails unless `methods` can bake `scene` for a film of `size`, as far as that can be told before anything is
/// traced or written. Returns the scene as the bundle has it.
///
/// # Errors
/// The first reason why not.
pub fn expect_fit(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    size: [u32; 2],
    job: &Job,
) -> Result<StoredScene> {
    methods.iter().try_for_each(|method| method.expect_fit(scene)).map_err(BakeError::with_line)?;
    expect_sizes(scene, size)?;
    // By the very checks of its readers.
    let stored = stored_scene(scene, size);
    stored.validate(&Place::file(&scene.file))?;
    methods.iter().try_for_each(|method| job.memory().expect(method.memory(scene)))?;
    Ok(stored)
}

/// What came of it.
enum Outcome {
    Bundle(Summary),
    Pieces(Traced),
}

fn make(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    order: &Order<'_>,
    job: &Job,
) -> Result<(Outcome, FolderLock)> {
    let Order { folder, size, leftover, shard, .. } = *order;
    let stored = expect_fit(scene, methods, size, job)?;
    let lock = FolderLock::take(folder)?;
    let unfinished = folder.join(UNFINISHED);
    traced::expect_folder(folder)?;
    [folder, &unfinished, &traced::folder_of(folder)].into_iter().try_for_each(expect_files)?;
    shard.map_or(Ok(()), |shard| shard.expect_own(folder))?;
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    if leftover == Leftover::Refuse && holds_work(folder, &names) {
        let reason = "holds an unfinished bake; add --resume to go on with it or --force to start again";
        return Err(BakeError::invalid(&Place::file(&unfinished), reason));
    }
    if let Some(shard) = shard {
        shard.write(folder)?;
    }
    let (traced, kept) = (Mutex::new(Traced::default()), Mutex::new(BTreeSet::new()));
    let work = Work {
        folder,
        unfinished: &unfinished,
        leftover,
        share: shard.map_or(Share::WHOLE, |shard| shard.share),
        sphere_sets: None,
        traced: &traced,
        kept: &kept,
        job,
    };
    let old = publish::old_manifest(folder, &unfinished, scene, leftover)?;
    match bake_into(scene, methods, &stored, old.as_ref(), order.seed, work) {
        Ok(Outcome::Bundle(summary)) => work::tidy(folder, &names).map(|()| (Outcome::Bundle(summary), lock)),
        Ok(pieces) => Ok((pieces, lock)),
        Err(error) => {
            // Without a log nothing could go on with what is there. Whatever else goes wrong, the first error
            // is the one worth telling.
            if !holds_work(folder, &names) {
                let _ = work::tidy(folder, &names);
            }
            Err(error)
        }
    }
}

fn bake_into(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    stored: &StoredScene,
    old: Option<&Manifest>,
    seed: u64,
    work: Work<'_>,
) -> Result<Outcome> {
    let Work { folder, unfinished, job, .. } = work;
    let (size, hash) = (stored.meta.size, scene_hash(scene));
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    let (playable, left_out) = playable::split(scene, &stored.meta, &names);
    left_out.iter().for_each(|sentence| say(&format!("warning: {sentence}")));
    sweep_partial(folder, |_| true);
    old.and_then(|old| replaced::notice(old, folder, hash, methods, size))
        .iter()
        .for_each(|notice| note(notice));
    // What needs no tracing comes first: what its readers would refuse is then known before hours of work.
    let writing = job.step("writing");
    let scene_file = write_entry(stored, unfinished, "scene.relume")?;
    let mut animations = BTreeMap::new();
    for animation in playable {
        let file = file_of("animation", &animation.name, "relume");
        animations.insert(animation.name.clone(), write_entry(animation, unfinished, &file)?);
    }
    drop(writing);
    let looking = job.step("looking");
    let is_black = darkness::is_black(scene, size)?;
    drop(looking);
    let sphere_sets = sphere_sets::fit_all(scene, seed, old, folder, &work)?;
    let entries: Option<Vec<SphereSetEntry>> =
        sphere_sets.as_ref().map(|sets| sets.iter().map(|set| set.entry.clone()).collect());
    let work = Work { sphere_sets: entries.as_deref(), ..work };
    let mut done = work.take_traced();
    let mut summaries = Vec::new();
    for method in methods {
        let summary = bake_by(method.as_ref(), scene, old, &work)?;
        let traced = summary.as_ref().map_or_else(|| Some(work.take_traced()), |summary| summary.traced);
        traced.into_iter().for_each(|traced| done.add(traced));
        summaries.push(summary);
    }
    let is_shard = work.share.is_part();
    let whole = summaries.into_iter().collect::<Option<Vec<MethodSummary>>>();
    let (Some(sphere_sets), Some(methods), false) = (sphere_sets, whole, is_shard) else {
        return Ok(Outcome::Pieces(done));
    };
    let manifest = Manifest {
        version: manifest::VERSION,
        scene: scene.name.clone(),
        scene_hash: format!("{hash:032x}"),
        scene_file,
        animations,
        sphere_sets: sphere_sets.iter().map(|set| (set.object.clone(), set.entry.clone())).collect(),
        methods: methods.iter().map(|summary| summary.entry.clone()).collect(),
    };
    let writing = job.step("writing");
    publish(&manifest, old, &work)?;
    drop(writing);
    let served: Vec<&str> = methods
        .iter()
        .filter(|summary| summary.traced.is_none())
        .map(|summary| summary.entry.name.as_str())
        .collect();
    work.tidy_kept(&served);
    let summary =
        Summary { sphere_sets, methods, bytes: manifest.entries().map(|e| e.bytes).sum(), is_black };
    if summary.has_news() {
        write_report(folder, &summary, job)?;
    }
    Ok(Outcome::Bundle(summary))
}

/// What a method comes to, from `old` if that serves; `None` if pieces are missing that others make.
fn bake_by(
    method: &dyn Method,
    scene: &Scene,
    old: Option<&Manifest>,
    work: &Work<'_>,
) -> Result<Option<MethodSummary>> {
    let reads = format!("{:032x}", method.reads(scene));
    let may_reuse = work.leftover != Leftover::Discard && !has_logs(work.unfinished, method.name());
    let old = old.filter(|_| may_reuse && !work.share.is_part());
    if let Some(entry) = old.and_then(|old| publish::reusable_entry(old, work.folder, &reads, method)) {
        return Ok(Some(MethodSummary { entry, traced: None }));
    }
    let Some(Product { files, settings, errors, measured_on }) = method.bake(scene, work)? else {
        return Ok(None);
    };
    let entry = MethodEntry { name: method.name().to_owned(), reads, files, settings, errors, measured_on };
    Ok(Some(MethodSummary { entry, traced: Some(work.take_traced()) }))
}

/// Fails if a folder, pipe or device stands in `folder` where only files go that a bake replaces.
fn expect_files(folder: &Path) -> Result<()> {
    let is_ours = |name: &str| {
        [manifest::FILE_NAME, report::FILE_NAME].contains(&name)
            || name.ends_with(".relume")
            || name.ends_with(".log")
    };
    match files(folder).into_iter().find(|(name, path)| is_ours(name) && !path.is_file()) {
        Some((_, path)) => {
            let what = if path.is_dir() { "a folder" } else { "no regular file" };
            let reason =
                format!("is {what} where a bake keeps a file; move it away, or bake elsewhere with -o");
            Err(BakeError::invalid(&Place::file(&path), reason))
        }
        None => Ok(()),
    }
}

/// Fails if the file of the scene could not hold a film of `size` or the meshes; better now than after hours
/// of tracing.
fn expect_sizes(scene: &Scene, size: [u32; 2]) -> Result<()> {
    let refuse = |reason: String| Err(BakeError::invalid(&Place::file(&scene.file), reason));
    if !is_legal_size(size) {
        return refuse(format!(
            "{}x{} pixels, an image holds at most {MAX_PIXELS}; lower --size",
            size[0], size[1]
        ));
    }
    let vertices: u64 = scene.objects.iter().map(|o| o.mesh.positions.len() as u64).sum();
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let most = MAX_SECTION_BYTES / 12;
    match vertices.max(triangles) > most {
        true => refuse(format!(
            "{vertices} vertices and {triangles} triangles, at most {most} of each fit; simplify the meshes"
        )),
        false => Ok(()),
    }
}

fn write_report(folder: &Path, summary: &Summary, job: &Job) -> Result<()> {
    let of_method = |summary: &MethodSummary| {
        let traced = summary.traced?;
        let report = json!({
            "tracing_seconds": traced.seconds,
            "rays": traced.rays,
            "rays_per_second": traced.rays as f64 / traced.seconds.max(1e-9),
        });
        Some((summary.entry.name.clone(), report))
    };
    let mut report = report::facts(job.seconds());
    report.insert("steps".to_owned(), json!(job.steps()));
    report.insert("methods".to_owned(), summary.methods.iter().filter_map(of_method).collect());
    let of_set = |set: &SphereSetSummary| {
        Some((set.entry.file.file.clone(), json!({ "seconds": set.fitted.as_ref()?.seconds })))
    };
    report.insert(report::SPHERES.to_owned(), summary.sphere_sets.iter().filter_map(of_set).collect());
    Ok(report::merge(folder, report)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_in_the_place_of_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("notes")).unwrap();
        std::fs::write(folder.path().join("scene.relume"), "").unwrap();
        expect_files(folder.path()).unwrap();
        for name in ["transfer-images.relume", "manifest.json", "report.json", "sparse-transfer.log"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
            let error = expect_files(folder.path()).unwrap_err();
            let expected = format!(
                "{name}: is a folder where a bake keeps a file; move it away, or bake elsewhere with -o"
            );
            assert!(error.exit_code() == 2 && error.to_string().ends_with(&expected), "{error}");
            std::fs::remove_dir(folder.path().join(name)).unwrap();
        }
    }
}
