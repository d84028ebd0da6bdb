//! The command line: what can be asked for, and nothing of how it is done.

mod values;

use clap::{ArgAction, Args, Parser, Subcommand};
use clap_complete::Shell;
use relume_bake::job::ProgressMode;
use relume_bake::memory::MemoryLimit;
use relume_bake::methods::asked::Quality;
use relume_bake::methods::registered::Registered;
use relume_bake::spheres::fit::{DEFAULT_ITERATIONS, MAX_SPHERES};
use relume_bake::stage::Share;
use relume_bake::trace::reference::Paths;
use std::path::PathBuf;
use values::{
    FILTER, PATHS, PROGRESS, QUALITIES, method_parser, one_of, parse_max_error, parse_memory, parse_scale,
    parse_size, parse_tight,
};

/// Bakes how light moves through a scene, once, so that `player` can show it while materials, or light, view and
/// shapes change.
#[derive(Debug, Parser)]
#[command(
    name = "bake",
    version = env!("RELUME_VERSION"),
    after_help = "\
SCENE is a path to a scene.toml or the name of a scene in scenes/library, such as cornell-knot; `bake run` and `bake plan` take a model, too.
Exit codes: 0 done, 1 failed, 2 wrong usage or bad input, 130 interrupted."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say nothing but warnings and errors, and what was asked for
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say how long steps take before tracing, and every warning
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a first scene for a model: scene.toml, commented, and a picture of it
    #[command(long_about = "\
Write a first scene for a model of any kind: DIR/scene.toml, with a camera that sees the model, a ground, light, and every material of the model, and DIR/preview.png, which shows it. \
The file is commented for somebody who has never seen one. The model stays where it is; what is there already is never overwritten.")]
    New(NewArgs),
    /// Bake a scene, or a model, into a bundle that `player` plays
    Run(RunArgs),
    /// Make one bundle of the folders that `bake run --pieces` made on many machines
    #[command(long_about = "\
Make one bundle of the folders that `bake run SCENE --pieces I/N -o DIR` made, one for each I from 1 to N, in any order: the bundle of the undivided bake, byte for byte. What waits for all pieces, such as \
light that bounces, is done here; the scene is read again from where it was.")]
    Merge(MergeArgs),
    /// Tell what a scene varies, which methods serve that, what baking it will take, and what is left out
    Plan(PlanArgs),
    /// Tell what a file or bundle holds: sections, sizes, settings, measured error
    Info(InfoArgs),
    /// Check every checksum and invariant of a file or bundle
    Verify(PathArgs),
    /// Write a file, bundle or scene in standard formats: .npy, .exr, .ply, .json, and of painted materials .png
    Export(ExportArgs),
    /// Write the tables that depend on no scene
    Tables(TablesArgs),
    /// Fit a set of spheres to a mesh
    #[command(long_about = "\
Fit a set of spheres to a mesh: N spheres that cover the solid that the mesh bounds and stand out of it as little as they can. They follow the mesh when it deforms. What they are for: \
blockers that cast the soft shadows of shapes that move, collision tests, level of detail. `bake info` tells how good the fit is, `bake export` writes the spheres as .npy, .ply and .json.")]
    Spheres(SpheresArgs),
    /// Path trace reference images of a scene in any state
    Reference(ReferenceArgs),
    /// Chart speed against accuracy: every method and setting that fits a scene, measured against the
    /// reference
    #[command(long_about = "\
Chart speed against accuracy. Random states of what the scene varies are path traced; every method that fits is baked with the settings that trade speed for accuracy, played by the `player` beside \
this program, compared with the reference and timed. DIR gets chart.svg to look at, chart.csv and chart.json to reckon with, and picture.png, the most exact setting beside the reference. \
At 256 x 256 pixels, which it does not exceed, it takes some 10 to 30 minutes; interrupted, it goes on where it was. Do nothing else on the machine meanwhile: frames are timed.")]
    Chart(ChartArgs),
    /// Chart many scenes, put charts and pictures on one page, and tell what changed
    Gallery(GalleryArgs),
    /// Print what completes `bake` in a shell
    #[command(long_about = "\
Print a script that completes `bake` in a shell. For bash: bake completions bash > ~/.local/share/bash-completion/completions/bake. `make install` does so.")]
    Completions(CompletionsArgs),
    /// Write the manual pages of `bake`
    Man(ManArgs),
}

impl Command {
    /// Whether what it makes is files, and what it prints tells of them.
    pub fn writes_files(&self) -> bool {
        !matches!(self, Self::Plan(_) | Self::Info(_) | Self::Verify(_) | Self::Completions(_))
    }
}

/// Arguments of `bake new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The model: a .gltf, .glb, .obj, .ply or .off file
    pub model: PathBuf,
    /// Where scene.toml and preview.png go
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Metres in the model's unit: 0.01 for centimetres [default: guessed from its size]
    #[arg(long, value_name = "METRES", value_parser = parse_scale)]
    pub scale: Option<f64>,
}

/// Arguments of `bake run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The scene; or a model, for which a first scene is written beside the bundle as DIR.toml, unless it is
    /// there
    pub scene: String,
    /// Where the bundle goes [default: baked/<scene name>]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Method to bake; may be given several times, the one that the player should prefer first [default:
    /// sphere-shadows if shapes vary, transfer-tensor if materials vary together with light or view,
    /// sparse-transfer if only these do, else transfer-images]
    #[arg(long, value_name = "NAME", value_parser = method_parser())]
    pub method: Vec<&'static Registered>,
    /// What is asked of methods.
    #[command(flatten)]
    pub asked: AskedArgs,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Most memory that the bake may take; it is refused at once if it will take more [default: what the
    /// machine has free]
    #[arg(long, value_name = "GIB", value_parser = parse_memory)]
    pub memory: Option<MemoryLimit>,
    /// Go on with an interrupted bake
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Throw away what is there and bake everything again; what other methods left unfinished stays
    #[arg(long)]
    pub force: bool,
    /// Make piece I of every N alone, for one of N machines, each with a folder of its own; `bake merge`
    /// makes the bundle of all N folders
    #[arg(
        long,
        value_name = "I/N",
        default_value = "1/1",
        hide_default_value = true,
        conflicts_with = "force"
    )]
    pub pieces: Share,
    /// How progress is told
    #[arg(long, default_value = "auto", value_parser = one_of(&PROGRESS))]
    pub progress: ProgressMode,
}

/// What `bake run` bakes and `bake plan` predicts.
#[derive(Debug, Args)]
pub struct AskedArgs {
    /// Samples by name. transfer-images, film samples a pixel: draft 64, preview 256, final 1024;
    /// sparse-transfer and transfer-tensor, rays for a texel of the light at whose border visibility changes:
    /// draft 1, preview 16, final 64, and of the latter for reflected light 256, 1024, 4096; sphere-shadows has
    /// none
    #[arg(long, default_value = "preview", value_parser = one_of(&QUALITIES))]
    pub quality: Quality,
    /// Largest relative L2 error that the method may make on states that it was not made for; chooses bases
    /// or terms, or what objects cast shadows by, by trying them on the scene [default: the scene's, or 0.01]
    #[arg(long, value_name = "E", value_parser = parse_max_error)]
    pub max_error: Option<f64>,
    /// transfer-images: number of BRDF bases, the diffuse one included: more is more exact and larger
    /// [default: from --max-error]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=16))]
    pub bases: Option<u32>,
    /// sparse-transfer and transfer-tensor, which has 512 at most: number of terms a vertex: more is more exact
    /// and larger [default: from --max-error]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub terms: Option<u32>,
    /// transfer-images: whether noise is filtered out, the same way of all images
    #[arg(long, action = ArgAction::Set, default_value = "on", value_parser = one_of(&FILTER))]
    pub filter: bool,
    /// transfer-images: noise over random states that is good enough, relative L2, such as 0.01; tiles then get as
    /// many samples as this takes, noisy ones more, and those of --quality or --spp are the most in the mean
    #[arg(long, value_name = "E", value_parser = parse_max_error)]
    pub noise: Option<f64>,
    /// Film size [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Samples, instead of --quality's; rays a texel are rounded up to a square number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub spp: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// Arguments of `bake merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The folders of all pieces, as `bake run SCENE --pieces I/N -o DIR` made them, in any order
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Where the bundle goes
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Most memory that the bake may take; it is refused at once if it will take more [default: what the
    /// machine has free]
    #[arg(long, value_name = "GIB", value_parser = parse_memory)]
    pub memory: Option<MemoryLimit>,
    /// How progress is told
    #[arg(long, default_value = "auto", value_parser = one_of(&PROGRESS))]
    pub progress: ProgressMode,
}

/// Arguments of `bake plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The scene, or a model, whose first scene is planned and not written
    pub scene: String,
    /// What would be asked of methods.
    #[command(flatten)]
    pub asked: AskedArgs,
    /// As JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bake info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// A .relume file or a bundle's folder
    pub path: PathBuf,
    /// As JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `bake verify`.
#[derive(Debug, Args)]
pub struct PathArgs {
    /// A .relume file or a bundle's folder
    pub path: PathBuf,
}

/// Arguments of `bake export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// A .relume file, a bundle's folder, or a scene
    pub what: String,
    /// Where the files go
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Arguments of `bake tables`.
#[derive(Debug, Args)]
pub struct TablesArgs {
    /// Where the tables go
    #[arg(short, long, value_name = "DIR", default_value = "baked/tables")]
    pub output: PathBuf,
}

/// Arguments of `bake spheres`.
#[derive(Debug, Args)]
pub struct SpheresArgs {
    /// The mesh: a .gltf, .glb, .obj, .ply or .off file
    pub mesh: PathBuf,
    /// Number of spheres, 1 to 4096: more fit closer
    #[arg(short = 'n', value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MAX_SPHERES as i64))]
    pub count: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Most iterations; a fit that nothing betters ends sooner
    #[arg(long, value_name = "I", default_value_t = DEFAULT_ITERATIONS, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub iterations: u32,
    /// How far outside every sphere a point of the solid may lie, in parts of the bounding box's diagonal, at
    /// most 0.1; 0: everything is covered
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = parse_tight)]
    pub tight: f64,
    /// Where the set goes, a .relume file [default: <mesh>-spheres-<N>.relume]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// How progress is told
    #[arg(long, default_value = "auto", value_parser = one_of(&PROGRESS))]
    pub progress: ProgressMode,
}

/// Arguments of `bake reference`.
#[derive(Debug, Args)]
pub struct ReferenceArgs {
    /// The scene
    pub scene: String,
    /// A state to render; may be given many times [default: the scene as it is]
    #[arg(long, value_name = "STATE.toml")]
    pub state: Vec<PathBuf>,
    /// Most reflections of a path; 1 is direct light only [default: unlimited; the scene's with --paths
    /// gather]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub reflections: Option<u32>,
    /// best: least noise; gather: the very paths that `bake run` traces with the same size, seed and samples
    #[arg(long, default_value = "best", value_parser = one_of(&PATHS))]
    pub paths: Paths,
    /// Film samples a pixel
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub spp: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Film size [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// With --paths gather, whether noise is filtered out as `bake run` does
    #[arg(long, action = ArgAction::Set, default_value = "on", value_parser = one_of(&FILTER))]
    pub filter: bool,
    /// With --paths gather, noise over random states that is good enough, as in `bake run`; --spp is then the most
    /// in the mean
    #[arg(long, value_name = "E", value_parser = parse_max_error)]
    pub noise: Option<f64>,
    /// FILE.exr, or FILE.png to look at; or a pattern such as 'OUT/%04d.exr' for one image per state
    #[arg(short, long, value_name = "FILE")]
    pub output: String,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// How progress is told
    #[arg(long, default_value = "auto", value_parser = one_of(&PROGRESS))]
    pub progress: ProgressMode,
}

/// Arguments of `bake chart`.
#[derive(Debug, Args)]
pub struct ChartArgs {
    /// The scene
    pub scene: String,
    /// Method to chart; may be given several times [default: all that show everything that the scene varies]
    #[arg(long, value_name = "NAME", value_parser = method_parser())]
    pub method: Vec<&'static Registered>,
    /// Where the chart goes [default: charts/<scene name>]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// How progress is told
    #[arg(long, default_value = "auto", value_parser = one_of(&PROGRESS))]
    pub progress: ProgressMode,
}

/// Arguments of `bake gallery`.
#[derive(Debug, Args)]
pub struct GalleryArgs {
    /// The scenes [default: all of the library that vary something, if their assets are there]
    pub scene: Vec<String>,
    /// Where the gallery is; what it holds of other scenes stays
    #[arg(short, long, value_name = "DIR", default_value = "docs/gallery")]
    pub output: PathBuf,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// How progress is told
    #[arg(long, default_value = "auto", value_parser = one_of(&PROGRESS))]
    pub progress: ProgressMode,
}

/// Arguments of `bake completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: Shell,
}

/// Arguments of `bake man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Where bake.1 and the pages of its commands go
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}
