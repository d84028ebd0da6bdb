//! From a scene to a bundle on disk: reuses what is there, resumes what was interrupted, and writes the manifest last.

use crate::brdf;
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::methods::transfer_images::{self, Settings, TileLog, Traced, held_out};
use crate::scene_hash::scene_hash;
use relume_formats::container::{Stored, replace_file};
use relume_formats::kinds::manifest::{self, FileEntry, Manifest, MethodEntry, content_hash};
use relume_formats::kinds::scene::{Meta, StoredMaterial, StoredObject};
use relume_formats::kinds::{BrdfBasis, StoredScene};
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
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
    /// Errors over the held-out states: relative L2, median and worst.
    pub errors: [f64; 2],
    /// Bytes of all files.
    pub bytes: u64,
}

/// Bakes `scene` into `folder`.
///
/// # Errors
/// See [`BakeError`]; whatever happens, no file under its final name is half-written, and finished tiles stay in the folder.
pub fn run(scene: &Scene, settings: &Settings, folder: &Path, leftover: Leftover, job: &Job) -> Result<Summary> {
    transfer_images::expect_fit(scene)?;
    expect_memory(transfer_images::predicted_bytes(scene, settings))?;
    let start = Instant::now();
    let unfinished = folder.join(UNFINISHED);
    let hash = scene_hash(scene);
    create_folder(folder)?;

    let reusable = if leftover == Leftover::Discard { None } else { reusable_method(folder, hash, settings) };
    let (entry, traced) = match reusable {
        Some(entry) => (entry, None),
        None => {
            let log = open_log(&unfinished, leftover, log_key(hash, settings))?;
            let (entry, traced) = bake_method(scene, settings, folder, &log, job)?;
            (entry, Some(traced))
        }
    };
    let scene_file = write_entry(&stored_scene(scene, settings), folder, "scene.relume")?;
    let mut animations = BTreeMap::new();
    for animation in &scene.animations {
        let file = format!("animation-{}.relume", animation.name);
        animations.insert(animation.name.clone(), write_entry(animation, folder, &file)?);
    }
    let errors = ["relative_l2_median", "relative_l2_worst"].map(|name| entry.errors.get(name).copied().unwrap_or(f64::NAN));
    let manifest = Manifest {
        version: manifest::VERSION,
        scene: scene.name.clone(),
        scene_hash: format!("{hash:032x}"),
        scene_file,
        animations,
        methods: vec![entry],
    };
    manifest.write(folder)?;
    if let Some(traced) = traced {
        write_report(folder, traced, start)?;
    }
    // The manifest stands; what is left of the work is only in the way.
    remove_folder(&unfinished)?;
    let bytes = manifest.entries().map(|e| e.bytes).sum();
    Ok(Summary { reused: traced.is_none(), traced, errors, bytes })
}

fn bake_method(scene: &Scene, settings: &Settings, folder: &Path, log: &TileLog, job: &Job) -> Result<(MethodEntry, Traced)> {
    let basis = brdf::basis::build(settings.bases, true)?;
    let (images, traced) = transfer_images::bake(scene, settings, &basis, log, job)?;
    let errors = held_out::measure(scene, settings, &basis, &images, job)?;
    let basis_file = write_entry(&basis, folder, "brdf-basis.relume")?;
    let images_file = write_entry(&images, folder, "transfer-images.relume")?;
    let entry = MethodEntry {
        name: transfer_images::NAME.to_owned(),
        files: vec![(BrdfBasis::KIND.name().to_owned(), basis_file), (transfer_images::NAME.to_owned(), images_file)],
        settings: recorded_settings(settings),
        errors: BTreeMap::from([("relative_l2_median".to_owned(), errors.median), ("relative_l2_worst".to_owned(), errors.worst)]),
    };
    Ok((entry, traced))
}

fn recorded_settings(settings: &Settings) -> BTreeMap<String, serde_json::Value> {
    let Settings { size, samples, seed, bases } = settings;
    let values = json!({ "revision": transfer_images::REVISION, "size": size, "samples": samples, "seed": seed, "bases": bases });
    match values {
        serde_json::Value::Object(map) => map.into_iter().collect(),
        _ => BTreeMap::new(),
    }
}

/// The method's entry of a finished bundle if it came from the same scene and settings and its files are whole.
fn reusable_method(folder: &Path, hash: u128, settings: &Settings) -> Option<MethodEntry> {
    let manifest = Manifest::read(folder).ok()?;
    let entry = manifest.methods.into_iter().find(|m| m.name == transfer_images::NAME)?;
    let same = manifest.scene_hash == format!("{hash:032x}") && entry.settings == recorded_settings(settings);
    let whole = |file: &FileEntry| std::fs::read(folder.join(&file.file)).is_ok_and(|bytes| content_hash(&bytes) == file.hash);
    (same && entry.files.iter().all(|(_, file)| whole(file))).then_some(entry)
}

fn log_key(hash: u128, settings: &Settings) -> u128 {
    let text = format!("{hash:032x} {:?} {}", settings, transfer_images::REVISION);
    xxhash_rust::xxh3::xxh3_128(text.as_bytes())
}

fn open_log(unfinished: &Path, leftover: Leftover, key: u128) -> Result<TileLog> {
    let path = unfinished.join(LOG);
    if !path.exists() || leftover == Leftover::Discard {
        create_folder(unfinished)?;
        return Ok(TileLog::create(&path, key)?);
    }
    let place = Place::file(unfinished);
    if leftover == Leftover::Refuse {
        return Err(BakeError::invalid(&place, "holds an unfinished bake; add --resume to go on with it or --force to start again"));
    }
    TileLog::reopen(&path, key)?.ok_or_else(|| {
        BakeError::invalid(&place, "holds an unfinished bake of another scene or other settings; add --force to start again")
    })
}

fn stored_scene(scene: &Scene, settings: &Settings) -> StoredScene {
    let mut stored = StoredScene {
        meta: Meta { name: scene.name.clone(), camera: scene.camera, size: settings.size, materials: Vec::new(), objects: Vec::new() },
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
    };
    for (index, material) in scene.materials.iter().enumerate() {
        let varies = scene.vary.materials.contains(&index);
        stored.meta.materials.push(StoredMaterial { name: material.name.clone(), brdf: material.brdf, varies });
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

/// Memory that the system could give out now; `None` where it does not say.
fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string(PathBuf::from("/proc/meminfo")).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kib| kib << 10)
}
