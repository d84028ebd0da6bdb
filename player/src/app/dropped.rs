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

    /// Shows another bundle, unless that would lose edits or it cannot be shown.
    fn open_bundle(&mut self, folder: &Path) -> Note {
        let edits = self.live.shown().and_then(|shown| shown.editor.unsaved());
        if let Some(edits) = edits {
            return Err(format!("edits of {edits} are in no state file; save the state (T) or reset all, then drop the bundle again"));
        }
        let live = self.start(folder).map_err(|error| error.to_string())?;
        // How the last one ended does not matter any more.
        let _ = std::mem::replace(&mut self.live, live).end();
        (self.picture, self.screen) = (None, Screen::default());
        Ok(format!("playing {}", folder.display()))
    }

    fn start(&self, folder: &Path) -> Result<Live> {
        let (state, limits) = (PlacedState::default(), Limits::default());
        let request = Request { folder, method: None, state, animation: None, environment: None, meters: false, size: None, limits };
        let session = Session::start(request, || self.gpu.again())?;
        Live::start(session, Instant::now(), false, waking(&self.for_news))
    }
}

/// The folder of the bundle that `path`, or a file next to its manifest, belongs to.
fn bundle_of(path: &Path) -> Option<PathBuf> {
    let folder = if path.is_dir() { path } else { path.parent().filter(|_| path.file_name().is_some_and(|name| name == FILE_NAME))? };
    (path.is_dir() || folder.join(FILE_NAME).is_file()).then(|| folder.to_owned())
}
