//! From a scene to a bundle on disk: reuses what is there, resumes what was interrupted, and writes the manifest last.

mod prediction;
mod sphere_sets;

pub use prediction::{Shared, predict_shared};
pub use sphere_sets::{Fitted, SphereSetSummary};

use crate::error::{BakeError, Result};
use crate::job::{Job, say};
use crate::methods::{Method, Traced};
use crate::scene_hash::scene_hash;
use crate::work_log::WorkLog;
use crate::{playable, report};
use relume_formats::container::{self, Header, Stored};
use relume_formats::kinds::manifest::{self, FileEntry, Manifest, MethodEntry, content_hash};
use relume_formats::kinds::scene::{EnvironmentLook, Meta, StoredClip, StoredMaterial, StoredObject, StoredShape};
use relume_formats::kinds::{SphereSet, StoredScene};
use relume_formats::shape::Clip;
use relume_formats::{Error, Place};
use relume_scenes::{Environment, Object, Scene};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Folder within a bundle that holds unfinished work.
const UNFINISHED: &str = "unfinished";

/// What to do about work that an interrupted bake left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leftover {
    /// Refuse to touch it.
    Refuse,
    /// Go on with it.
    Resume,
    /// Throw it away, and finished work too.
    Discard,
}

/// What a bake came to, for the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The sphere sets, in the order of the objects.
    pub sphere_sets: Vec<SphereSetSummary>,
    /// The methods, in the order asked for.
    pub methods: Vec<MethodSummary>,
    /// Bytes of all files.
    pub bytes: u64,
}

impl Summary {
    /// Whether anything was baked that was not there before.
    pub fn has_news(&self) -> bool {
        self.methods.iter().any(|method| method.traced.is_some()) || self.sphere_sets.iter().any(|set| set.fitted.is_some())
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

/// Where a method works, and by what rules.
pub struct Work<'a> {
    /// Folder of the bundle.
    folder: &'a Path,
    /// Folder for new files.
    unfinished: &'a Path,
    leftover: Leftover,
    /// Hash of the scene.
    hash: u128,
    /// The spheres of the objects that ask for some, in their order.
    sphere_sets: &'a [SphereSetSummary],
    /// For progress and interruption.
    pub job: &'a Job,
}

impl Work<'_> {
    /// The log of `method`, empty or with what an interrupted bake left. `key` tells everything besides the scene that its pieces depend on.
    ///
    /// # Errors
    /// If what is there belongs to another bake, or the file cannot be opened.
    pub fn open_log(&self, method: &str, key: &str) -> Result<WorkLog> {
        let path = self.unfinished.join(log_name(method));
        let key = xxhash_rust::xxh3::xxh3_128(format!("{:032x} {key}", self.hash).as_bytes());
        if self.leftover != Leftover::Resume || !WorkLog::exists(&path) {
            return Ok(WorkLog::create(&path, key)?);
        }
        let reason = "holds an unfinished bake of another scene or other settings; add --force to start again";
        WorkLog::reopen(&path, key)?.ok_or_else(|| BakeError::invalid(&Place::file(self.unfinished), reason))
    }

    /// The sphere sets of the objects that ask for some, in their order.
    ///
    /// # Errors
    /// If one cannot be read back.
    pub fn sphere_sets(&self) -> Result<Vec<SphereSet>> {
        let read = |summary: &SphereSetSummary| {
            let file = &summary.entry.file.file;
            // What is reused stands in the bundle already.
            let [new, old] = [self.unfinished, self.folder].map(|folder| folder.join(file));
            Ok(SphereSet::read_file(if new.exists() { &new } else { &old })?)
        };
        self.sphere_sets.iter().map(read).collect()
    }

    /// Writes a file of the bundle.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, content: &impl Stored, file: &str) -> Result<FileEntry> {
        write_entry(content, self.unfinished, file)
    }
}

/// Name of a method's log of finished pieces.
fn log_name(method: &str) -> String {
    format!("{method}.log")
}

/// Whether there is a log worth going on with at `path`.
fn is_log(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "log") && WorkLog::exists(path)
}

/// Bakes `scene` by `methods`, the preferred one first, into `folder`; the player's film is of `size`. `seed` is that of the sphere sets: methods have
/// their own.
///
/// New files are made in a folder of their own and moved when all are whole, so an older bundle stays playable until then.
///
/// # Errors
/// See [`BakeError`]; whatever happens, no file under its final name is half-written, and finished pieces stay in the folder.
pub fn run(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    size: [u32; 2],
    folder: &Path,
    leftover: Leftover,
    seed: u64,
    job: &Job,
) -> Result<Summary> {
    methods.iter().try_for_each(|method| method.expect_fit(scene))?;
    // By the very checks of its readers, before anything is traced.
    let stored = stored_scene(scene, size);
    stored.validate(&Place::file(&scene.file))?;
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    let (playable, left_out) = playable::split(scene, &stored.meta, &names);
    left_out.iter().for_each(|sentence| say(&format!("warning: {sentence}")));
    let start = Instant::now();
    let unfinished = folder.join(UNFINISHED);
    // Of any method: publishing takes all that is unfinished away.
    let has_log = std::fs::read_dir(&unfinished).is_ok_and(|files| files.flatten().any(|file| is_log(&file.path())));
    if has_log && leftover == Leftover::Refuse {
        let reason = "holds an unfinished bake; add --resume to go on with it or --force to start again";
        return Err(BakeError::invalid(&Place::file(&unfinished), reason));
    }
    let hash = scene_hash(scene);
    // A kill in the middle of publishing leaves the old manifest where publishing had put it aside.
    let old = Manifest::read(folder).or_else(|_| Manifest::read(&unfinished)).ok();
    create_folder(&unfinished)?;
    let work = Work { folder, unfinished: &unfinished, leftover, hash, sphere_sets: &[], job };
    let sphere_sets = sphere_sets::fit_all(scene, seed, old.as_ref(), folder, &work)?;
    let work = Work { sphere_sets: &sphere_sets, ..work };
    let mut summaries = Vec::new();
    for method in methods {
        let may_reuse = leftover != Leftover::Discard && !WorkLog::exists(&unfinished.join(log_name(method.name())));
        let reusable = old.as_ref().filter(|_| may_reuse).and_then(|old| reusable_entry(old, folder, hash, method.as_ref()));
        summaries.push(match reusable {
            Some(entry) => MethodSummary { entry, traced: None },
            None => {
                let (entry, traced) = method.bake(scene, &work)?;
                MethodSummary { entry, traced: Some(traced) }
            }
        });
    }
    let mut animations = BTreeMap::new();
    for animation in playable {
        let file = format!("animation-{}.relume", animation.name);
        animations.insert(animation.name.clone(), write_entry(animation, &unfinished, &file)?);
    }
    let manifest = Manifest {
        version: manifest::VERSION,
        scene: scene.name.clone(),
        scene_hash: format!("{hash:032x}"),
        scene_file: write_entry(&stored_scene(scene, size), &unfinished, "scene.relume")?,
        animations,
        sphere_sets: sphere_sets.iter().map(|set| (set.object.clone(), set.entry.clone())).collect(),
        methods: summaries.iter().map(|summary| summary.entry.clone()).collect(),
    };
    publish(&manifest, old.as_ref(), &unfinished, folder)?;
    let summary = Summary { sphere_sets, methods: summaries, bytes: manifest.entries().map(|e| e.bytes).sum() };
    if summary.has_news() {
        write_report(folder, &summary, start)?;
    }
    // The manifest stands; what is left of the work is only in the way.
    remove_folder(&unfinished)?;
    Ok(summary)
}

/// The method's entry of a finished bundle if it came from the same scene and settings, and its files are whole and of today's versions.
fn reusable_entry(old: &Manifest, folder: &Path, hash: u128, method: &dyn Method) -> Option<MethodEntry> {
    let entry = old.methods.iter().find(|m| m.name == method.name())?;
    let mut asked = method.asked_for();
    if let Some((name, chosen)) = method.chosen().and_then(|name| Some((name, entry.settings.get(name)?))) {
        // Chosen by error then, and so it would be again.
        asked.entry(name.to_owned()).or_insert_with(|| chosen.clone());
    }
    let same = old.scene_hash == format!("{hash:032x}") && entry.settings == asked;
    (same && entry.files.iter().all(|(_, file)| is_readable(file, folder))).then(|| entry.clone())
}

/// Whether the file is whole and of today's version.
fn is_readable(file: &FileEntry, folder: &Path) -> bool {
    let whole = || std::fs::read(folder.join(&file.file)).is_ok_and(|bytes| content_hash(&bytes) == file.hash);
    let current = |header: &Header| header.kind_version == header.kind.current_version();
    container::open(&folder.join(&file.file)).is_ok_and(|reader| current(reader.header())) && whole()
}

/// Moves the new files into place and names them in the manifest. The old manifest is put aside first, so nobody takes a mixture of old and new files
/// for a bundle. Nothing is lost in between: the log, or the images that the old manifest names, are still there.
fn publish(manifest: &Manifest, old: Option<&Manifest>, unfinished: &Path, folder: &Path) -> Result<()> {
    let io = |path: &Path| {
        let place = Place::file(path);
        move |e| Error::io(&place, e)
    };
    let old_manifest = folder.join(manifest::FILE_NAME);
    manifest.validate(&Place::file(&old_manifest))?;
    if old_manifest.exists() {
        std::fs::rename(&old_manifest, unfinished.join(manifest::FILE_NAME)).map_err(io(&old_manifest))?;
    }
    for entry in manifest.entries() {
        let (from, to) = (unfinished.join(&entry.file), folder.join(&entry.file));
        // What is reused stands there already.
        if from.exists() {
            std::fs::rename(&from, &to).map_err(io(&to))?;
        }
    }
    manifest.write(folder)?;
    let listed: Vec<&str> = manifest.entries().map(|e| e.file.as_str()).collect();
    for stale in old.iter().flat_map(|old| old.entries()).filter(|e| !listed.contains(&e.file.as_str())) {
        // Out of date but harmless: nothing names it any more.
        let _ = std::fs::remove_file(folder.join(&stale.file));
    }
    Ok(())
}

/// What a bundle of `scene` tells of it.
pub fn stored_scene(scene: &Scene, size: [u32; 2]) -> StoredScene {
    let mut stored = StoredScene {
        meta: Meta {
            name: scene.name.clone(),
            camera: scene.camera,
            size,
            varies_light: scene.vary.light,
            varies_view: scene.vary.view,
            varies_shape: scene.vary.shape,
            environment: scene.environment.as_ref().map(environment_look),
            materials: Vec::new(),
            objects: Vec::new(),
            shapes: scene.objects.iter().filter_map(stored_shape).collect(),
        },
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
    };
    for (index, material) in scene.materials.iter().enumerate() {
        let varies = scene.vary.materials.contains(&index);
        stored.meta.materials.push(StoredMaterial {
            name: material.name.clone(),
            brdf: material.brdf,
            varies,
            textured: material.texture.is_some(),
        });
    }
    for object in &scene.objects {
        let first = stored.positions.len() as u32;
        stored.positions.extend(&object.mesh.positions);
        stored.normals.extend(&object.mesh.normals);
        stored.triangles.extend(object.mesh.triangles.iter().map(|t| t.map(|i| i + first)));
        let triangles = object.mesh.triangles.len() as u32;
        stored.meta.objects.push(StoredObject { name: object.name.clone(), material: object.material as u32, triangles });
    }
    stored
}

fn stored_shape(object: &Object) -> Option<StoredShape> {
    let clip = |clip: &Clip| StoredClip { name: clip.name.clone(), duration_s: clip.duration_s };
    let shape = object.shape.as_ref()?;
    Some(StoredShape { object: object.name.clone(), clips: shape.clips.iter().map(clip).collect() })
}

fn environment_look(environment: &Environment) -> EnvironmentLook {
    EnvironmentLook { map: environment.map.name.clone(), gain: environment.gain, rotation_deg: environment.rotation_deg }
}

fn write_entry(content: &impl Stored, folder: &Path, file: &str) -> Result<FileEntry> {
    Ok(FileEntry::of(file, &content.write_file(&folder.join(file))?))
}

fn write_report(folder: &Path, summary: &Summary, start: Instant) -> Result<()> {
    let of_method = |summary: &MethodSummary| {
        let traced = summary.traced?;
        let report = json!({
            "tracing_seconds": traced.seconds,
            "rays": traced.rays,
            "rays_per_second": traced.rays as f64 / traced.seconds.max(1e-9),
        });
        Some((summary.entry.name.clone(), report))
    };
    let mut report = report::facts(start.elapsed().as_secs_f64());
    report.insert("methods".to_owned(), summary.methods.iter().filter_map(of_method).collect());
    let of_set = |set: &SphereSetSummary| Some((set.entry.file.file.clone(), json!({ "seconds": set.fitted.as_ref()?.seconds })));
    report.insert(report::SPHERES.to_owned(), summary.sphere_sets.iter().filter_map(of_set).collect());
    Ok(report::merge(folder, report)?)
}

fn create_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(&Place::file(folder), e).into())
}

fn remove_folder(folder: &Path) -> Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io(&Place::file(folder), e).into()),
        _ => Ok(()),
    }
}

/// Fails if `needed` bytes are more than the machine has free; `remedy` says what to do then.
///
/// # Errors
/// [`BakeError::Memory`].
pub fn expect_memory(needed: u64, remedy: &'static str) -> Result<()> {
    match available_bytes() {
        Some(available) if needed > available / 10 * 9 => {
            Err(BakeError::Memory { needed_mib: needed >> 20, available_mib: available >> 20, remedy })
        }
        _ => Ok(()),
    }
}

/// Memory that the system, or the container that this runs in, could give out now; `None` where neither says.
fn available_bytes() -> Option<u64> {
    let meminfo = std::fs::read_to_string("/proc/meminfo").ok();
    let line = meminfo.as_deref().and_then(|text| text.lines().find_map(|l| l.strip_prefix("MemAvailable:")));
    let free = line.and_then(|l| l.trim().strip_suffix(" kB")?.parse::<u64>().ok()).map(|kib| kib << 10);
    let of_container = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    [free, of_container].into_iter().flatten().min()
}
