//! Files and folders that are dropped on the window.

use super::{Open, waking};
use crate::error::Result;
use crate::live::Live;
use crate::session::{Request, Session};
use crate::stream::Limits;
use crate::ui::{Note, Screen};
use relume_formats::kinds::manifest::FILE_NAME;
use relume_playback::PlacedState;
use std::path::{Path, PathBuf};
use std::time::Instant;

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

    /// Shows another bundle as soon as there is anything to see of it, unless that would lose edits.
    fn open_bundle(&mut self, folder: &Path) -> Note {
        let edits = self.live.shown().and_then(|shown| shown.editor.unsaved());
        if let Some(edits) = edits {
            return Err(format!(
                "edits of {edits} are in no state file; save the state (T) or reset all, then drop the bundle again"
            ));
        }
        self.opening = Some(self.start(folder).map_err(|error| error.to_string())?);
        Ok(format!("opening {}", folder.display()))
    }

    /// Takes what there is to see of a bundle that is being opened; of one that fails before, the reason.
    pub(super) fn look_at_opening(&mut self) {
        let Some(mut live) = self.opening.take() else { return };
        live.take_news();
        if live.is_hopeless() {
            self.note = live.end().ended.err().map(|error| Err(error.to_string()));
        } else if live.shown().is_none() {
            self.opening = Some(live);
            return;
        } else {
            // How the last one ended does not matter any more.
            let _ = std::mem::replace(&mut self.live, live).end();
            (self.picture, self.screen, self.note) = (None, Screen::default(), None);
        }
        self.window.request_redraw();
    }

    fn start(&self, folder: &Path) -> Result<Live> {
        let (state, limits) = (PlacedState::default(), Limits::default());
        let request = Request {
            folder,
            method: None,
            state,
            animation: None,
            environment: None,
            meters: false,
            size: None,
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
