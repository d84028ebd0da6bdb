//! The system's own dialog for choosing a file. It never blocks the window: a thread waits for the answer.

use log::{Level, LevelFilter, Log, Metadata, Record};
use rfd::AsyncFileDialog;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use winit::window::Window;

/// The file that was chosen, nothing if the dialog was called off, or why there is none.
pub(super) type Chosen = Result<Option<PathBuf>, String>;

/// What the window takes.
const KINDS: (&str, [&str; 4]) = ("bundles, states, animations, maps", ["json", "toml", "exr", "hdr"]);

/// What `rfd` last complained of: a dialog that cannot be opened and one that is called off give the same
/// answer, and only the log tells them apart.
struct Complaint(Mutex<Option<String>>);

static COMPLAINT: Complaint = Complaint(Mutex::new(None));

impl Complaint {
    fn take(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Log for Complaint {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() == Level::Error && metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// Opens the dialog over `window` and calls `tell` when it is closed.
///
/// # Errors
/// If there can be no thread.
pub(super) fn ask(window: &Window, tell: impl FnOnce(Chosen) + Send + 'static) -> Result<(), String> {
    // The second time it is there already.
    if log::set_logger(&COMPLAINT).is_ok() {
        log::set_max_level(LevelFilter::Error);
    }
    let _ = COMPLAINT.take();
    let (name, extensions) = KINDS;
    // Some systems want the dialog to be opened where the window's events are.
    let dialog = AsyncFileDialog::new()
        .set_title("Open")
        .set_parent(window)
        .add_filter(name, &extensions)
        .add_filter("all files", &["*"])
        .pick_file();
    let wait = move || {
        let chosen = pollster::block_on(dialog).map(|file| file.path().to_owned());
        tell(answer(chosen, COMPLAINT.take()));
    };
    let thread = std::thread::Builder::new().name("dialog".to_owned()).spawn(wait);
    thread.map(drop).map_err(|e| format!("cannot start the thread that waits for the dialog: {e}"))
}

fn answer(chosen: Option<PathBuf>, complaint: Option<String>) -> Chosen {
    match (chosen, complaint) {
        (None, Some(reason)) => {
            Err(format!("no file dialog here; drop the file on the window instead ({reason})"))
        }
        (chosen, _) => Ok(chosen),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dialog_that_is_called_off_is_told_from_none() {
        let file = || Some(PathBuf::from("sky.exr"));
        assert_eq!(answer(file(), None), Ok(file()));
        // What serves after something else has failed is as good.
        assert_eq!(answer(file(), Some("no portal".to_owned())), Ok(file()));
        assert_eq!(answer(None, None), Ok(None));
        let reason = answer(None, Some("no portal".to_owned())).unwrap_err();
        assert!(reason.contains("drop the file on the window instead (no portal)"), "{reason}");
    }

    #[test]
    fn only_complaints_of_the_dialog_are_kept() {
        let complaint = Complaint(Mutex::new(None));
        let log = |target: &str, level: Level| {
            complaint
                .log(&Record::builder().target(target).level(level).args(format_args!("{level}")).build());
        };
        log("wgpu_core::device", Level::Error);
        log("rfd::backend", Level::Warn);
        assert_eq!(complaint.take(), None);
        log("rfd::backend", Level::Error);
        assert_eq!((complaint.take().as_deref(), complaint.take()), (Some("ERROR"), None));
    }
}
