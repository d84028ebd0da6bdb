//! Carries out each command of the command line; returns what to print.

mod bundle_path;
mod chart;
mod gallery;
mod spheres;

use bundle_path::expect_no_scene;
pub use chart::chart;
pub use gallery::gallery;
pub use spheres::spheres;

use crate::brdf::blinn_phong::glossy_albedo;
use crate::bundle::{self, Leftover, MethodSummary};
use crate::cli::{ExportArgs, InfoArgs, MergeArgs, PathArgs, PlanArgs, ReferenceArgs, RunArgs, TablesArgs};
use crate::error::{BakeError, Result};
use crate::exr_file::write_exr;
use crate::frame_cost;
use crate::inspect;
use crate::job::{Job, say, watch_signals};
use crate::memory::MemoryLimit;
use crate::merge::{self, Part};
use crate::methods::Method;
use crate::methods::choice::{self, Asked, METHODS, Registered};
use crate::output::{create_folder, expect_writable};
use crate::plan;
use crate::stage::Share;
use crate::trace::gather::MAX_REFLECTIONS;
use crate::trace::reference::{self, Estimate, Paths};
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::kinds::{HaarTable, VisibilityTable};
use relume_formats::method::cards_of;
use relume_formats::state::{BlinnPhong, Brdf, State, with_line};
use relume_scenes::Scene;
use std::path::{Path, PathBuf};

/// Where bundles of scenes go if nothing else is said.
const BUNDLES: &str = "baked";
/// How an interrupted bake goes on.
const RESUME: &str = "finished work is kept, add --resume to go on";
/// How an interrupted chart goes on.
const SAME_COMMAND: &str = "finished work is kept, the same command goes on with it";
/// More warnings at once than this are counted only.
const MOST_WARNINGS: usize = 100;

/// `bake run`.
pub fn run(args: &RunArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let scene = load(&args.scene)?;
    let max_error = args.max_error.unwrap_or(scene.max_error);
    if !(max_error > 0.0 && max_error.is_finite()) {
        return Err(BakeError::invalid(&Place::file("--max-error"), format!("{max_error} makes no sense; give a number above 0")));
    }
    let chosen = if args.method.is_empty() { vec![choice::cheapest(&scene.vary)] } else { args.method.clone() };
    let asked = asked(args, &scene, max_error);
    let methods = methods(&chosen, &asked, &scene)?;
    let folder = args.output.clone().unwrap_or_else(|| Path::new(BUNDLES).join(&scene.name));
    let leftover = match (args.resume, args.force) {
        (true, _) => Leftover::Resume,
        (_, true) => Leftover::Discard,
        _ => Leftover::Refuse,
    };
    let job = Job::new(args.progress).with_memory(args.memory.unwrap_or(MemoryLimit::Free));
    if args.pieces.is_part() {
        return run_part(&scene, &methods, &asked, args.pieces, &folder, leftover, &job);
    }
    bake(&scene, &methods, &asked, &folder, leftover, &job)
}

/// Bakes and tells what came of it.
fn bake(scene: &Scene, methods: &[Box<dyn Method>], asked: &Asked, folder: &Path, leftover: Leftover, job: &Job) -> Result<String> {
    let baked = bundle::run(scene, methods, asked.size, folder, leftover, asked.seed, job);
    // The lock lasts until the report is whole.
    let (summary, _lock) = baked.map_err(|e| e.kept(bundle::holds_work(folder, &names(methods)), RESUME))?;
    let mut text: String = summary.sphere_sets.iter().map(|set| spheres::describe_stage(&scene.name, set)).collect();
    summary.methods.iter().for_each(|method| text += &describe(scene, method, summary.is_black, asked.max_error));
    text += &format!("{:.1} MB in {}\n", summary.bytes as f64 / 1e6, folder.display());
    if summary.has_news() {
        text += &frame_cost::measure(scene, &summary, asked.size, folder)?;
    }
    Ok(text)
}

/// Makes the pieces of a share.
fn run_part(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    asked: &Asked,
    share: Share,
    folder: &Path,
    leftover: Leftover,
    job: &Job,
) -> Result<String> {
    let part = Part::new(scene, &names(methods), asked, share);
    let baked = bundle::run_part(scene, methods, &part, folder, leftover, job);
    let traced = baked.map_err(|e| e.kept(bundle::holds_work(folder, &names(methods)), RESUME))?;
    let Share { number, of } = share;
    let folder = folder.display();
    Ok(format!(
        "{}: pieces {number}/{of}: {} made, {:.1} million rays in {:.1} s, in {folder}; when all {of} are done: bake merge DIR... -o BUNDLE\n",
        scene.name,
        traced.pieces,
        traced.rays as f64 / 1e6,
        traced.seconds
    ))
}

/// `bake merge`.
pub fn merge(args: &MergeArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let part = merge::expect_all(&args.folders)?;
    let scene = relume_scenes::load(&part.scene)?;
    warn(&scene.warnings);
    let unknown = |name: &String| BakeError::invalid(&Place::file(name), "is no method of this program; merge with the one that baked");
    let chosen = part.methods.iter().map(|name| Registered::find(name).ok_or_else(|| unknown(name))).collect::<Result<Vec<_>>>()?;
    let methods = methods(&chosen, &part.asked, &scene)?;
    let job = Job::new(args.progress).with_memory(args.memory.unwrap_or(MemoryLimit::Free));
    merge::gather(&args.folders, &args.output)?;
    bake(&scene, &methods, &part.asked, &args.output, Leftover::Resume, &job)
}

fn names(methods: &[Box<dyn Method>]) -> Vec<&'static str> {
    methods.iter().map(|method| method.name()).collect()
}

/// What the command line asks of all methods.
fn asked(args: &RunArgs, scene: &Scene, max_error: f64) -> Asked {
    Asked {
        size: args.size.unwrap_or(scene.size),
        quality: args.quality,
        samples: args.spp,
        seed: args.seed,
        max_error,
        bases: args.bases,
        terms: args.terms,
    }
}

/// The methods that are `chosen`, with what is `asked` of them. Tells what they leave out.
fn methods(chosen: &[&'static Registered], asked: &Asked, scene: &Scene) -> Result<Vec<Box<dyn Method>>> {
    let refuse = |flag: &str, reason: &str| Err(BakeError::invalid(&Place::file(flag), reason));
    let names: Vec<&str> = chosen.iter().map(|method| method.card.name).collect();
    if names.iter().enumerate().any(|(i, name)| names[..i].contains(name)) {
        return refuse("--method", "the same one is given twice; once is enough");
    }
    cards_of(names.iter().copied(), &Place::file("--method"))?;
    let stranger = METHODS.into_iter().filter(|method| !names.contains(&method.card.name)).filter_map(|method| method.option);
    if let Some((flag, _)) = stranger.into_iter().find(|(_, is_given)| is_given(asked)) {
        return refuse(flag, "belongs to a method that is not baked here; remove it, or add the method with --method");
    }
    let methods: Vec<Box<dyn Method>> = chosen.iter().map(|method| (method.new)(asked, scene)).collect();
    warn(&methods.iter().flat_map(|method| method.leaves_out(scene)).collect::<Vec<_>>());
    Ok(methods)
}

/// What came of one method, and a warning where that is less than was asked for.
fn describe(scene: &Scene, summary: &MethodSummary, is_black: bool, max_error: f64) -> String {
    let MethodSummary { entry, traced } = summary;
    let error = |name: &str| entry.errors.get(name).map(|error| 100.0 * error);
    let figures = error("relative_l2_median").zip(error("relative_l2_worst")).filter(|_| !is_black);
    let settings = entry.settings.iter().filter(|(name, _)| *name != "revision").map(|(name, value)| format!("{name} {value}"));
    let settings: Vec<String> = settings.collect();
    let what = if traced.is_none() { "up to date, reused" } else { "baked" };
    let mut text = format!("{}: {} {what}: {}\n", scene.name, entry.name, settings.join(", "));
    text += &match figures {
        Some((median, worst)) => format!("error over held-out states: median {median:.3} %, worst {worst:.3} %\n"),
        None if is_black => "no error figure: the picture is black\n".to_owned(),
        None => {
            say(&format!("warning: nothing that {} was compared on is lit and reflects; check camera, lights and materials", entry.name));
            "no error figure: nothing that was compared is lit\n".to_owned()
        }
    };
    if let Some(traced) = traced {
        let rate = traced.rays as f64 / traced.seconds.max(1e-9) / 1e6;
        text += &format!("{:.1} million rays in {:.1} s, {rate:.2} million a second\n", traced.rays as f64 / 1e6, traced.seconds);
    }
    if figures.is_some_and(|(_, worst)| worst > 100.0 * max_error) {
        let remedy = Registered::find(&entry.name).map(|method| (method.remedy)(&entry.settings)).unwrap_or_default();
        say(&format!("warning: the worst error of {} is above the {} % asked for; {remedy}", entry.name, 100.0 * max_error));
    }
    text
}

/// `bake plan`.
pub fn plan(args: &PlanArgs) -> Result<String> {
    watch_signals()?;
    let folders = plan::Folders { bundles: Path::new(BUNDLES), charts: Path::new(crate::chart::FOLDER) };
    plan::plan(&load(&args.scene)?, &folders, args.json)
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
    let path = Path::new(&args.what);
    let is_bundle = path.extension().is_some_and(|e| e == "relume") || path.join("manifest.json").exists();
    let files =
        if is_bundle { inspect::export_file(path, &args.output)? } else { inspect::export_scene(&load(&args.what)?, &args.output)? };
    Ok(files.iter().map(|f| format!("{}\n", f.display())).collect())
}

/// `bake tables`.
pub fn tables(args: &TablesArgs) -> Result<String> {
    create_folder(&args.output)?;
    let line = |path: &Path, file: &[u8]| format!("{}: {} bytes\n", path.display(), file.len());
    let [haar, visibility] = ["haar-table.relume", "visibility-table.relume"].map(|name| args.output.join(name));
    let text = line(&haar, &HaarTable::bake().write_file(&haar)?);
    Ok(text + &line(&visibility, &VisibilityTable::bake().write_file(&visibility)?))
}

/// `bake reference`.
pub fn reference(args: &ReferenceArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let base = load(&args.scene)?;
    let states = if args.state.is_empty() { vec![base.clone()] } else { states(&base, &args.state)? };
    let files = output_files(&args.output, states.len())?;
    let settings = reference::Settings {
        size: args.size.unwrap_or(base.size),
        samples: args.spp,
        seed: args.seed,
        reflections: reflections(args, &base)?,
        paths: args.paths,
    };
    states.iter().for_each(|state| warn_of_gain(state, settings.reflections));
    let job = Job::new(args.progress);
    files.iter().try_for_each(|file| expect_writable(file))?;
    // States of the same light, view and shape share one set of gather paths; the others need their own, and the sooner each is written the better.
    let mut from = 0;
    while from < states.len() {
        let alike = |s: &&Scene| args.paths == Paths::Gather && differ_in_materials_only(s, &states[from]);
        let to = from + states[from..].iter().take_while(alike).count().max(1);
        // Directions follow the base's materials, whatever the states say.
        let base = Scene { materials: base.materials.clone(), ..states[from].clone() };
        let images = reference::render(&base, &states[from..to], &settings, &job)?;
        for (image, file) in images.iter().zip(&files[from..to]) {
            write_estimate(image, settings.size, file)?;
        }
        from = to;
    }
    Ok(files.iter().map(|f| format!("{}\n", f.display())).collect())
}

fn load(scene: &str) -> Result<Scene> {
    let scene = relume_scenes::load(&relume_scenes::resolve(scene)?)?;
    warn(&scene.warnings);
    Ok(scene)
}

/// Tells `warnings`, as many as anybody would read.
fn warn(warnings: &[String]) {
    warnings.iter().take(MOST_WARNINGS).for_each(|warning| say(&format!("warning: {warning}")));
    let more = warnings.len().saturating_sub(MOST_WARNINGS);
    if more > 0 {
        say(&format!("warning: and {more} more of these"));
    }
}

fn states(base: &Scene, files: &[PathBuf]) -> Result<Vec<Scene>> {
    let state = |file: &PathBuf| Ok(base.with_state(&State::read_file(file)?, &Place::file(file)).map_err(with_line)?);
    files.iter().map(state).collect()
}

fn reflections(args: &ReferenceArgs, scene: &Scene) -> Result<u32> {
    match (args.paths, args.reflections) {
        (Paths::Best, n) => Ok(n.unwrap_or(u32::MAX)),
        (Paths::Gather, None) => Ok(scene.reflections.min(MAX_REFLECTIONS)),
        (Paths::Gather, Some(n)) if n <= MAX_REFLECTIONS => Ok(n),
        (Paths::Gather, Some(n)) => {
            let place = Place::file("--reflections");
            Err(BakeError::invalid(&place, format!("{n} with --paths gather, which traces at most {MAX_REFLECTIONS}; use --paths best")))
        }
    }
}

/// Sums over many reflections need not converge if a material sends back more than it gets.
fn warn_of_gain(scene: &Scene, reflections: u32) {
    for material in scene.materials.iter().filter(|_| reflections > MAX_REFLECTIONS) {
        // GGX never reflects more than it receives.
        let Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) = material.brdf else { continue };
        let albedo = kd.iter().zip(ks).map(|(kd, ks)| kd + ks * glossy_albedo(shininess)).fold(0.0, f32::max);
        if albedo > 1.0 {
            let name = &material.name;
            say(&format!(
                "warning: material `{name}` reflects up to {albedo:.2} times what it receives; many reflections may not converge, add --reflections 2 or lower ks"
            ));
        }
    }
}

fn differ_in_materials_only(a: &Scene, b: &Scene) -> bool {
    let environment = |s: &Scene| s.environment.as_ref().map(|e| (e.gain, e.rotation_deg, std::sync::Arc::as_ptr(&e.map.map)));
    let camera = |s: &Scene| (s.camera.position, s.camera.target, s.camera.fov_deg);
    let meshes = |s: &Scene| s.objects.iter().map(|object| std::sync::Arc::as_ptr(&object.mesh)).collect::<Vec<_>>();
    meshes(a) == meshes(b) && camera(a) == camera(b) && a.lights == b.lights && environment(a) == environment(b)
}

/// The file for each of `count` images: the name itself for one, else the pattern with its number filled in.
fn output_files(pattern: &str, count: usize) -> Result<Vec<PathBuf>> {
    let place = Place::file(pattern);
    let refuse = |reason: &str| Err(BakeError::invalid(&place, reason));
    if !pattern.ends_with(".exr") {
        return refuse("references are written as .exr; end the name so");
    }
    let Some((before, rest)) = pattern.split_once('%') else {
        return if count == 1 { Ok(vec![pattern.into()]) } else { refuse("many states need a pattern such as 'OUT/%04d.exr'") };
    };
    let Some((digits, after)) = rest.split_once('d').filter(|(d, after)| d.chars().all(|c| c.is_ascii_digit()) && !after.contains('%'))
    else {
        return refuse("a pattern has one number such as %d or %04d");
    };
    let width: usize = digits.parse().unwrap_or(1).min(20);
    Ok((0..count).map(|i| format!("{before}{i:0width$}{after}").into()).collect())
}

fn write_estimate(image: &Estimate, [width, height]: [u32; 2], file: &Path) -> Result<()> {
    let plane = |pixels: &[[f32; 3]], channel: usize| -> Vec<f32> { pixels.iter().map(|p| p[channel]).collect() };
    let [r, g, b] = [0, 1, 2].map(|c| plane(&image.radiance, c));
    let [vr, vg, vb] = [0, 1, 2].map(|c| plane(&image.variance, c));
    let channels = [("R", &r[..]), ("G", &g), ("B", &b), ("variance.R", &vr), ("variance.G", &vg), ("variance.B", &vb)];
    Ok(write_exr(file, width as usize, height as usize, &channels)?)
}

fn start_threads(threads: Option<u32>) -> Result<()> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize).build_global()?)
}
