//! Plays bundles that `bake` wrote.
//!
//! * [`stream`]: the files of a bundle as they arrive;
//! * [`gpu`]: device, buffers, read-back, timestamps;
//! * [`methods`]: one folder per method, the GPU twins of `relume_formats::evaluate`;
//! * [`controls`]: state and animation on top of the scene's defaults;
//! * [`session`]: a bundle being played;
//! * [`headless`]: frames to files, through [`output`] and [`stats`];
//! * [`live`]: a bundle shown and edited while it plays; [`ui`]: what the user sees of that; [`app`]: the window around it;
//! * [`interrupt`]: the wish to stop;
//! * [`cli`]: the command line.

#![forbid(unsafe_code)]

pub mod app;
pub mod cli;
pub mod controls;
pub mod error;
pub mod gpu;
pub mod headless;
pub mod interrupt;
pub mod live;
pub mod methods;
pub mod output;
pub mod session;
pub mod stats;
pub mod stream;
pub mod ui;

#[cfg(test)]
#[path = "../tests/support/mod.rs"]
mod support;

pub use error::{Error, Result};
pub use interrupt::Interrupt;

use cli::Cli;
use controls::PlacedState;
use gpu::Gpu;
use relume_formats::Place;
use relume_formats::state::{Rgb, State};
use session::{Request, Session};
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

/// Does what the command line says. Raising `interrupt` ends it with [`Error::Interrupted`] within a frame or a section.
pub fn run(cli: &Cli, interrupt: &Interrupt) -> Result<()> {
    if cli.list_adapters {
        let text = gpu::list()?.join("\n");
        return match writeln!(std::io::stdout(), "{text}") {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Failed(format!("cannot write to stdout: {e}"))),
            // A closed pipe is the reader's choice, not a failure.
            _ => Ok(()),
        };
    }
    if cli.headless { headless::play(cli, interrupt) } else { app::play(cli, interrupt) }
}

/// Renders one state of the bundle in `folder` with its preferred method: film size, and linear radiance row by row in W/(sr·m²).
///
/// `adapter` is any part of an adapter's name; `None` takes the most promising one.
pub fn render_once(folder: &Path, state: &State, adapter: Option<&str>) -> Result<([u32; 2], Vec<Rgb>)> {
    let state = PlacedState { state: state.clone(), place: Place::file("state") };
    let mut session =
        Session::start(Request { folder, method: None, state, animation: None, offer_all: false, limits: Default::default() }, || {
            Gpu::open(adapter)
        })?;
    headless::load(&mut session, Instant::now(), &Interrupt::new(), |_| Ok(()))?;
    let frame = session.render(0.0)?;
    Ok((session.images()?.size(), frame.radiance))
}
