//! From a scene to a bundle on disk: reuses what is there, resumes what was interrupted, and writes the manifest last.

use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::methods::transfer_images::{self, Settings, TileLog, Traced, held_out};
use crate::scene_hash::scene_hash;
use relume_formats::container::{self, Stored, replace_file};
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::manifest::{self, FileEntry, Manifest, MethodEntry, content_hash};
use relume_formats::kinds::scene::{EnvironmentLook, Meta, StoredMaterial, StoredObject};
use relume_formats::kinds::{BrdfBasis, StoredScene, TransferImages};
use relume_formats::{Error, Place};
use relume_scenes::{Environment, Scene};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Folder within a bundle that holds unfinished work.
const UNFINISHED: &str = "unfinished";
/// Log of finished tiles within it.
const LOG: &str = "tiles.log";
/// Where timings and the machine are told.
const REPORT: &str = "report.json";

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
    /// Whether finished images of an earlier bake served.
    pub reused: bool,
    /// What tracing took, if anything was traced.
    pub traced: Option<Traced>,
    /// Number of bases.
    pub bases: u64,
    /// Errors over the held-out states: relative L2, median and worst.
    pub errors: [f64; 2],
    /// Bytes of all files.
    pub bytes: u64,
}

/// What to bake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// How many bases.
    pub bases: Bases,
}

/// How many bases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bases {
    /// This many, the diffuse one included.
    Number(usize),
    /// As many as keep the relative L2 error of every held-out state below this.
    Error(f64),
}

/// Bakes `scene` into `folder`.
///
/// New files are made in a folder of their own and moved when all are whole, so an older bundle stays playable until then.
///
/// # Errors
/// See [`BakeError`]; whatever happens, no file under its final name is half-written, and finished tiles stay in the folder.
pub fn run(scene: &Scene, wanted: &Wanted, folder: &Path, leftover: Leftover, job: &Job) -> Result<Summary> {
    transfer_images::expect_fit(scene)?;
    transfer_images::expect_sizes(scene, wanted.size)?;
    let start = Instant::now();
    let unfinished = folder.join(UNFINISHED);
    let has_log = TileLog::exists(&unfinished.join(LOG));
    if has_log && leftover == Leftover::Refuse {
        let reason = "holds an unfinished bake; add --resume to go on with it or --force to start again";
        return Err(BakeError::invalid(&Place::file(&unfinished), reason));
    }
    let hash = scene_hash(scene);
    // A kill in the middle of publishing leaves the old manifest where publishing had put it aside.
    let old = Manifest::read(folder).or_else(|_| Manifest::read(&unfinished)).ok();
    let may_reuse = !has_log && leftover != Leftover::Discard;
    let reusable = old.as_ref().filter(|_| may_reuse).and_then(|old| reusable_method(old, folder, hash, wanted));
    create_folder(&unfinished)?;
    let (entry, traced) = match reusable {
        Some(entry) => (entry, None),
        None => {
            let (entry, traced) = bake_method(scene, wanted, &unfinished, leftover, hash, job)?;
            (entry, Some(traced))
        }
    };
    let mut animations = BTreeMap::new();
    for animation in &scene.animations {
        let file = format!("animation-{}.relume", animation.name);
        animations.insert(animation.name.clone(), write_entry(animation, &unfinished, &file)?);
    }
    let errors = ["relative_l2_median", "relative_l2_worst"].map(|name| entry.errors.get(name).copied().unwrap_or(f64::NAN));
    let bases = entry.settings.get("bases").and_then(serde_json::Value::as_u64).unwrap_or(0);
    let manifest = Manifest {
        version: manifest::VERSION,
        scene: scene.name.clone(),
        scene_hash: format!("{hash:032x}"),
        scene_file: write_entry(&stored_scene(scene, wanted.size), &unfinished, "scene.relume")?,
        animations,
        methods: vec![entry],
    };
    publish(&manifest, old.as_ref(), &unfinished, folder)?;
    if let Some(traced) = traced {
        write_report(folder, traced, start)?;
    }
    // The manifest stands; what is left of the work is only in the way.
    remove_folder(&unfinished)?;
    let bytes = manifest.entries().map(|e| e.bytes).sum();
    Ok(Summary { reused: traced.is_none(), traced, bases, errors, bytes })
}

fn bake_method(
    scene: &Scene,
    wanted: &Wanted,
    unfinished: &Path,
    leftover: Leftover,
    hash: u128,
    job: &Job,
) -> Result<(MethodEntry, Traced)> {
    let Wanted { size, samples, seed, bases } = *wanted;
    let bases = match bases {
        Bases::Number(bases) => bases,
        Bases::Error(max) => held_out::choose_bases(scene, size, samples, seed, max, job)?,
    };
    let settings = Settings { size, samples, seed, bases };
    expect_memory(transfer_images::predicted_bytes(scene, &settings))?;
    let basis = transfer_images::basis_for(scene, bases)?;
    let log = open_log(unfinished, leftover, log_key(hash, &settings, &basis))?;
    let (images, traced) = transfer_images::bake(scene, &settings, &basis, &log, job)?;
    let errors = held_out::measure(scene, &settings, &basis, &images, job)?;
    let basis_file = write_entry(&basis, unfinished, "brdf-basis.relume")?;
    let images_file = write_entry(&images, unfinished, "transfer-images.relume")?;
    let mut recorded = asked_for(wanted);
    recorded.insert("bases".to_owned(), bases.into());
    let entry = MethodEntry {
        name: transfer_images::NAME.to_owned(),
        files: vec![(BrdfBasis::KIND.name().to_owned(), basis_file), (transfer_images::NAME.to_owned(), images_file)],
        settings: recorded,
        errors: BTreeMap::from([("relative_l2_median".to_owned(), errors.median), ("relative_l2_worst".to_owned(), errors.worst)]),
    };
    Ok((entry, traced))
}

/// The settings that the user gave or left to default, for the manifest.
fn asked_for(wanted: &Wanted) -> BTreeMap<String, serde_json::Value> {
    let Wanted { size, samples, seed, bases } = *wanted;
    let mut asked = BTreeMap::from([
        ("revision".to_owned(), json!(transfer_images::REVISION)),
        ("size".to_owned(), json!(size)),
        ("samples".to_owned(), json!(samples)),
        ("seed".to_owned(), json!(seed)),
    ]);
    match bases {
        Bases::Number(bases) => asked.insert("bases".to_owned(), json!(bases)),
        Bases::Error(max) => asked.insert("max_error".to_owned(), json!(max)),
    };
    asked
}

/// The method's entry of a finished bundle if it came from the same scene and settings, and its files are whole and of today's versions.
fn reusable_method(old: &Manifest, folder: &Path, hash: u128, wanted: &Wanted) -> Option<MethodEntry> {
    let entry = old.methods.iter().find(|m| m.name == transfer_images::NAME)?;
    let mut asked = asked_for(wanted);
    if let Some(bases) = entry.settings.get("bases") {
        // Chosen by error then, and so it would be again.
        asked.entry("bases".to_owned()).or_insert_with(|| bases.clone());
    }
    let whole = |file: &FileEntry| std::fs::read(folder.join(&file.file)).is_ok_and(|bytes| content_hash(&bytes) == file.hash);
    let readable = |(kind, file): &(String, FileEntry)| {
        let version = if kind == transfer_images::NAME { TransferImages::VERSION } else { BrdfBasis::VERSION };
        container::open(&folder.join(&file.file)).is_ok_and(|reader| reader.header().kind_version == version) && whole(file)
    };
    let same = old.scene_hash == format!("{hash:032x}") && entry.settings == asked;
    (same && entry.files.iter().all(readable)).then(|| entry.clone())
}

/// Everything that the tiles of a log depend on.
fn log_key(hash: u128, settings: &Settings, basis: &BrdfBasis) -> u128 {
    let functions: &[f32] = match &basis.functions {
        Functions::BlinnPhong { lobes } => lobes,
        Functions::Ggx { weights, .. } => weights,
    };
    let functions = content_hash(bytemuck::cast_slice(functions));
    let text = format!("{hash:032x} {settings:?} {} {functions}", transfer_images::REVISION);
    xxhash_rust::xxh3::xxh3_128(text.as_bytes())
}

fn open_log(unfinished: &Path, leftover: Leftover, key: u128) -> Result<TileLog> {
    let path = unfinished.join(LOG);
    if leftover != Leftover::Resume || !TileLog::exists(&path) {
        return Ok(TileLog::create(&path, key)?);
    }
    let reason = "holds an unfinished bake of another scene or other settings; add --force to start again";
    TileLog::reopen(&path, key)?.ok_or_else(|| BakeError::invalid(&Place::file(unfinished), reason))
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

fn stored_scene(scene: &Scene, size: [u32; 2]) -> StoredScene {
    let mut stored = StoredScene {
        meta: Meta {
            name: scene.name.clone(),
            camera: scene.camera,
            size,
            varies_light: scene.vary.light,
            varies_view: scene.vary.view,
            environment: scene.environment.as_ref().map(environment_look),
            materials: Vec::new(),
            objects: Vec::new(),
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

fn environment_look(environment: &Environment) -> EnvironmentLook {
    EnvironmentLook { map: environment.map.name.clone(), gain: environment.gain, rotation_deg: environment.rotation_deg }
}

fn write_entry(content: &impl Stored, folder: &Path, file: &str) -> Result<FileEntry> {
    Ok(FileEntry::of(file, &content.write_file(&folder.join(file))?))
}

fn write_report(folder: &Path, traced: Traced, start: Instant) -> Result<()> {
    let report = json!({
        "seconds": start.elapsed().as_secs_f64(),
        "tracing_seconds": traced.seconds,
        "rays": traced.rays,
        "rays_per_second": traced.rays as f64 / traced.seconds.max(1e-9),
        "threads": rayon::current_num_threads(),
        "machine": format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        "program": concat!("bake ", env!("CARGO_PKG_VERSION")),
    });
    Ok(replace_file(&folder.join(REPORT), format!("{report:#}\n").as_bytes())?)
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

/// Fails if `needed` bytes are more than the machine has free.
fn expect_memory(needed: u64) -> Result<()> {
    match available_bytes() {
        Some(available) if needed > available / 10 * 9 => {
            Err(BakeError::Memory { needed_mib: needed >> 20, available_mib: available >> 20 })
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
