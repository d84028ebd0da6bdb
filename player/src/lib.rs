//! The program around `relume_playback`, which plays bundles that `bake` wrote.
//!
//! * [`stream`]: the files of a bundle, read by a thread;
//! * [`gpu`]: choice of an adapter, the device and its failures, read-back;
//! * [`environment`]: maps from the user's own files;
//! * [`session`]: a bundle being played from files, and what frames take;
//! * [`headless`]: frames to files, through [`output`] and [`stats`];
//! * [`picture`]: the picture of a bundle that is arriving; [`live`]: what the user sets of it, while a
//!   thread of its own draws;
//! * [`ui`]: what the user sees of that; [`app`]: the window around it;
//! * [`interrupt`]: the wish to stop;
//! * [`cli`]: the command line.

#![forbid(unsafe_code)]

pub mod app;
pub mod cli;
pub mod environment;
pub mod error;
pub mod gpu;
pub mod headless;
pub mod interrupt;
pub mod live;
pub mod output;
pub mod picture;
pub mod session;
pub mod stats;
pub mod stream;
pub mod ui;

// What tests share is used from outside too.
#[cfg(test)]
extern crate self as relume_player;
#[cfg(test)]
#[path = "../tests/support/mod.rs"]
mod support;

pub use error::{Error, Result};
pub use interrupt::Interrupt;

use cli::Cli;
use gpu::Gpu;
use relume_formats::Place;
use relume_formats::kinds::manifest;
use relume_formats::state::{Rgb, State};
use relume_playback::PlacedState;
use session::{Frame, Request, Session};
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

/// Does what the command line says. Raising `interrupt` ends it with [`Error::Interrupted`] within a frame or
/// a section.
pub fn run(cli: &Cli, interrupt: &Interrupt) -> Result<()> {
    if cli.list_adapters {
        let text = gpu::list()?.join("\n");
        return match writeln!(std::io::stdout(), "{text}") {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(Error::Failed(format!("cannot write to stdout: {e}")))
            }
            // A closed pipe is the reader's choice, not a failure.
            _ => Ok(()),
        };
    }
    if let Some(path) = &cli.folder {
        expect_no_scene(path)?;
    }
    if cli.headless { headless::play(cli, interrupt) } else { app::play(cli, interrupt) }
}

/// A scene, or another file, is what a bundle is baked from; the player plays bundles.
fn expect_no_scene(path: &Path) -> Result<()> {
    let is_scene = path.join("scene.toml").is_file() && !path.join(manifest::FILE_NAME).exists();
    let shown = path.display();
    let what = match path.extension().and_then(|extension| extension.to_str()) {
        _ if is_scene => "the folder of a scene",
        _ if !path.is_file() => return Ok(()),
        Some("toml") => "a file of text",
        Some("relume") => return refuse(path, "is one file of a bundle; name its folder"),
        _ => {
            return refuse(
                path,
                "is a file where the folder of a bundle is wanted; make one with `bake run SCENE -o DIR`",
            );
        }
    };
    let reason = format!(
        "is {what}, but the player plays bundles; bake one by `bake run {shown} -o DIR`, then `player DIR`"
    );
    refuse(path, &reason)
}

fn refuse(path: &Path, reason: &str) -> Result<()> {
    Err(relume_formats::Error::invalid(&Place::file(path), reason).into())
}

/// Renders one state of the bundle in `folder` with its preferred method: film size, and linear radiance row
/// by row in W/(sr·m²).
///
/// `adapter` is any part of an adapter's name; `None` takes the most promising one.
pub fn render_once(folder: &Path, state: &State, adapter: Option<&str>) -> Result<([u32; 2], Vec<Rgb>)> {
    let (session, frame) = render(folder, None, state, adapter)?;
    Ok((session.player().film().map_or([0, 0], |film| film.size), frame.radiance))
}

/// The radiance that a white diffuse surface would show at every vertex of the scene in `folder`, W/(sr·m²),
/// by its method `method`.
///
/// # Errors
/// Those of [`render_once`]; and if the method knows nothing of vertices.
pub fn render_vertices(
    folder: &Path,
    method: &str,
    state: &State,
    adapter: Option<&str>,
) -> Result<Vec<Rgb>> {
    render(folder, Some(method), state, adapter)?.0.read_vertices()
}

fn render(
    folder: &Path,
    method: Option<&str>,
    state: &State,
    adapter: Option<&str>,
) -> Result<(Session, Frame)> {
    let state = PlacedState { state: state.clone(), place: Place::file("state") };
    let request = Request {
        folder,
        method,
        state,
        animation: None,
        environment: None,
        meters: false,
        size: None,
        limits: Default::default(),
    };
    let mut session = Session::start(request, || Gpu::open(adapter))?;
    headless::load(&mut session, Instant::now(), &Interrupt::new(), |_| Ok(()))?;
    let frame = session.render(0.0)?;
    Ok((session, frame))
}
