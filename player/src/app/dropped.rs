//! Files and folders that are dropped on the window or chosen in a dialog, and the bundle on show when it is to be read again.

use super::dialog::{self, Chosen};
use super::{Open, Wake, waking};
use crate::cli::Cli;
use crate::error::Result;
use crate::live::Live;
use crate::session::{Request, Session};
use crate::stream::Limits;
use crate::ui::{Kept, Note, Screen};
use relume_formats::kinds::manifest::FILE_NAME;
use relume_playback::PlacedState;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A bundle, and how it is to be played.
#[derive(Debug, Clone)]
pub(super) struct Playing {
    folder: PathBuf,
    method: Option<String>,
    size: Option<[u32; 2]>,
}

/// A bundle of which there is nothing to see yet.
pub(super) struct Opening {
    live: Live,
    playing: Playing,
    /// What was set on the bundle that it replaces, if that is another bake of it.
    kept: Option<Kept>,
}

impl Playing {
    /// What the command line says.
    pub(super) fn of(cli: &Cli) -> Self {
        Self {
            folder: cli.folder.clone().unwrap_or_else(|| ".".into()),
            method: cli.method.clone(),
            size: cli.size,
        }
    }
}

impl Open {
    /// Takes what was dropped, and says what became of it.
    pub(super) fn dropped(&mut self, path: &Path) {
        let taken = match bundle_of(path) {
            Some(folder) => self.open_bundle(&folder),
            None => self.live.take_file(path),
        };
        self.note = Some(taken);
        self.window.request_redraw();
    }

    /// Lets the user choose a file, which is taken as if it were dropped.
    pub(super) fn choose_file(&mut self) {
        if self.choosing {
            return;
        }
        let window = self.for_news.clone();
        let asked = dialog::ask(&self.window, move |chosen| {
            // A loop that has ended needs no file.
            let _ = window.send_event(Wake::Chosen(chosen));
        });
        match asked {
            Ok(()) => self.choosing = true,
            Err(reason) => self.note = Some(Err(reason)),
        }
    }

    /// Takes what was chosen in the dialog, which is closed now.
    pub(super) fn chosen(&mut self, chosen: Chosen) {
        self.choosing = false;
        match chosen {
            Ok(Some(path)) => self.dropped(&path),
            Ok(None) => {}
            Err(reason) => self.note = Some(Err(reason)),
        }
        self.window.request_redraw();
    }

    /// Shows another bundle as soon as there is anything to see of it, unless that would lose edits.
    fn open_bundle(&mut self, folder: &Path) -> Note {
        match self.refusal() {
            Some(refused) => Err(refused),
            None => self.open(Playing { folder: folder.to_owned(), method: None, size: None }, None),
        }
    }

    /// Why no other bundle may take the place of the one on show: edits would be lost.
    fn refusal(&mut self) -> Option<String> {
        let edits = self.live.shown()?.editor.unsaved()?;
        Some(format!(
            "edits of {edits} are in no state file; save the state (T) or reset all, then open the bundle again"
        ))
    }

    /// Shows the bundle as it is on disk now, with what is set, as soon as there is anything to see of it.
    pub(super) fn reload(&mut self) -> Note {
        let kept = self.live.shown().map(|shown| shown.editor.kept());
        self.open(self.playing.clone(), kept)
    }

    fn open(&mut self, playing: Playing, kept: Option<Kept>) -> Note {
        let live = self.start(&playing).map_err(|error| error.to_string())?;
        let said = format!("opening {}", playing.folder.display());
        self.opening = Some(Opening { live, playing, kept });
        Ok(said)
    }

    /// Takes what there is to see of a bundle that is being opened; of one that fails before, the reason.
    pub(super) fn look_at_opening(&mut self) {
        let Some(mut opening) = self.opening.take() else { return };
        opening.live.take_news();
        if opening.live.is_hopeless() {
            self.note = opening.live.end().ended.err().map(|error| Err(error.to_string()));
        } else if opening.live.shown().is_none() {
            self.opening = Some(opening);
            return;
        } else if let Some(refused) = self.refusal().filter(|_| opening.kept.is_none()) {
            // Edited since it was asked for.
            let _ = opening.live.end();
            self.note = Some(Err(refused));
        } else {
            let Opening { live, playing, kept } = opening;
            // Until now the last one could be edited.
            let kept = kept.map(|kept| self.live.shown().map_or(kept, |shown| shown.editor.kept()));
            // How it ended does not matter any more.
            let _ = std::mem::replace(&mut self.live, live).end();
            (self.picture, self.screen, self.playing) = (None, Screen::default(), playing);
            self.note = kept.map(|kept| self.live.keep(kept, Path::new("")));
        }
        self.window.request_redraw();
    }

    fn start(&self, playing: &Playing) -> Result<Live> {
        let (state, limits) = (PlacedState::default(), Limits::default());
        let request = Request {
            folder: &playing.folder,
            method: playing.method.as_deref(),
            state,
            animation: None,
            environment: None,
            meters: false,
            size: playing.size,
            limits,
        };
        let session = Session::start(request, || self.gpu.again())?;
        Live::start(session, Instant::now(), self.records, waking(&self.for_news))
    }
}

/// The folder of the bundle that `path`, or a file next to its manifest, belongs to.
fn bundle_of(path: &Path) -> Option<PathBuf> {
    let folder = if path.is_dir() {
        path
    } else {
        path.parent().filter(|_| path.file_name().is_some_and(|name| name == FILE_NAME))?
    };
    (path.is_dir() || folder.join(FILE_NAME).is_file()).then(|| folder.to_owned())
}
