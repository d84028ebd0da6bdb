//! A bundle on show: what the user sets of it, here, and its picture, which a thread of its own draws. What
//! the user does never waits for a frame: looks go there as orders, of which the last counts, and pictures
//! come back as news. Knows nothing of windows.

mod files;
mod watch;
mod worker;

use crate::error::{Error, Result};
use crate::gpu::give_way;
use crate::output::write_numbered;
use crate::picture::{Picture, PictureFile, Ready, nothing_yet};
use crate::session::Session;
use crate::ui::{Editor, Facts, Loading, Metering, Note, Picker, Save, Stage};
use relume_formats::Place;
use relume_formats::state::{Animation, EnvironmentState, State, with_line};
use relume_playback::{Look, Surfaces};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Instant;
use watch::Watch;
pub use worker::Outcome;
use worker::{News, Order, Worker};

/// A bundle on show.
pub struct Live {
    /// `None` once the thread is to end.
    orders: Option<Sender<Order>>,
    news: Receiver<News>,
    thread: JoinHandle<Outcome>,
    facts: Facts,
    shown: Option<Shown>,
    /// What was said last of what was asked for.
    note: Option<Note>,
    /// Animations that wait for the maps that they name, in the order in which these were ordered.
    waiting: VecDeque<(Animation, Place)>,
    _watch: Watch,
}

/// What there is as soon as there is anything to see.
pub struct Shown {
    /// What the user has set.
    pub editor: Editor,
    picker: Option<Picker>,
    surfaces: Surfaces,
    /// Size of the picture in pixels.
    pub size: [u32; 2],
    /// Whether it is drawn at the size that there is for it.
    resizes: bool,
    /// The size that there is for it, if that is known, and the one that was ordered last.
    room: Option<[u32; 2]>,
    ordered_size: Option<[u32; 2]>,
    /// A picture of `size` that was not yet taken: sRGB-encoded RGBA, row by row.
    pixels: Option<Vec<u8>>,
    /// The look that was ordered last.
    ordered: Look,
    /// The metering that was ordered and not yet answered.
    metering: Option<Metering>,
}

impl Shown {
    /// What the screen shows of it, with `picture` for the picture.
    pub fn stage(&mut self, picture: egui::TextureId) -> Stage<'_> {
        let Self { editor, picker, surfaces, size, resizes, .. } = self;
        Stage { editor, picker: picker.as_ref(), surfaces, size: *size, resizes: *resizes, picture }
    }

    /// Has the picture drawn at `size`, in pixels, from the next order on, or at the nearest that can be drawn.
    pub fn fill(&mut self, size: [u32; 2]) {
        self.room = Some(size).filter(|_| self.resizes);
    }

    /// The newest picture, if it was not yet taken.
    pub fn take_pixels(&mut self) -> Option<Vec<u8>> {
        self.pixels.take()
    }
}

impl Live {
    /// Shows `session`, which began at `started`; calls `wake` whenever there is news. With `record`, the
    /// cost of every frame is kept for [`Live::end`].
    ///
    /// # Errors
    /// If there can be no thread.
    pub fn start(
        session: Session,
        started: Instant,
        record: bool,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self> {
        let (edition, on_cpu) = (session.edition().clone(), session.gpu().is_software());
        let picture = Picture::new(session, started, record);
        let facts = picture.facts();
        let ((orders, received), (sender, news)) = (channel(), channel());
        let wake = Arc::new(wake);
        let telling = |sender: Sender<News>| {
            let wake = wake.clone();
            move |item| {
                // Who no longer listens shows nothing any more.
                if sender.send(item).is_ok() {
                    wake();
                }
            }
        };
        let (tell, tell_rebaked) = (telling(sender.clone()), telling(sender));
        let watch = Watch::start(edition, move |rebaked| tell_rebaked(News::Rebaked(rebaked)))?;
        let work = move || {
            if on_cpu {
                give_way();
            }
            Worker::new(picture, tell).run(&received)
        };
        let thread = std::thread::Builder::new().name("picture".to_owned()).spawn(work);
        let thread = thread.map_err(|e| Error::Failed(format!("cannot start the thread that draws: {e}")))?;
        Ok(Self {
            orders: Some(orders),
            news,
            thread,
            facts,
            shown: None,
            note: None,
            waiting: VecDeque::new(),
            _watch: watch,
        })
    }

    /// Takes in what there is to know. Returns whether there was anything.
    pub fn take_news(&mut self) -> bool {
        let mut any = false;
        while let Ok(item) = self.news.try_recv() {
            any = true;
            match (item, &mut self.shown) {
                (News::Facts(facts), _) => {
                    self.facts = Facts { rebaked: self.facts.rebaked, ..*facts };
                }
                (News::Rebaked(rebaked), _) => self.facts.rebaked = rebaked,
                (News::Saved(saved), _) => {
                    self.note = Some(saved.map(|path| format!("saved {}", path.display())))
                }
                (News::Ready(ready), _) => {
                    let ordered = ready.editor.look();
                    let Ready { editor, picker, surfaces, size, resizes } = *ready;
                    self.shown = Some(Shown {
                        editor,
                        picker,
                        surfaces,
                        size,
                        resizes,
                        room: None,
                        ordered_size: None,
                        pixels: None,
                        ordered,
                        metering: None,
                    });
                }
                (News::Ended(reason), _) => self.facts.loading = Loading::Stopped(reason),
                (News::Drawn { size, pixels, moved }, Some(shown)) => {
                    (shown.size, shown.pixels) = (size, Some(pixels));
                    moved.into_iter().for_each(|positions| shown.surfaces.set_positions(positions));
                }
                (News::Metered(ev), Some(shown)) => {
                    shown.metering = None;
                    shown.editor.metered(ev);
                }
                (News::Lit(lit), Some(shown)) => self.note = Some(lit.map(|name| shown.lit_by(name))),
                (News::Mapped(maps), Some(shown)) => {
                    let playing = self.waiting.pop_front().map(|waiting| shown.play(waiting, maps));
                    self.note = playing.or(self.note.take());
                }
                (News::Drawn { .. } | News::Metered(_) | News::Lit(_) | News::Mapped(_), None) => {}
            }
        }
        any
    }

    /// Whether bundle or GPU have failed before there was anything to show: there is nothing to wait for.
    /// [`Live::end`] tells the reason.
    pub fn is_hopeless(&self) -> bool {
        self.shown.is_none() && matches!(self.facts.loading, Loading::Stopped(_))
    }

    /// Orders what the user has set, if that is not what was ordered last.
    pub fn order(&mut self) {
        let Some(shown) = &mut self.shown else { return };
        let resized = shown.room.filter(|room| shown.ordered_size != Some(*room)).map(Order::Resize);
        shown.ordered_size = shown.room;
        let look = shown.editor.look();
        let changed = (look != shown.ordered).then(|| Order::Show(Box::new(look.clone())));
        let meters = shown.editor.metering().filter(|metering| shown.metering != Some(*metering));
        (shown.ordered, shown.metering) = (look, shown.editor.metering());
        let orders: Vec<Order> = resized.into_iter().chain(changed).chain(meters.map(Order::Meter)).collect();
        for order in orders {
            // A thread that has ended has told so.
            self.send(order);
        }
    }

    /// Whether there is still anybody to obey; one that has ended for a failure has told so.
    fn send(&self, order: Order) -> bool {
        self.orders.as_ref().is_some_and(|orders| orders.send(order).is_ok())
    }

    /// Has the picture written into `folder`, under a name of its own; the news will tell of it. The settings
    /// are written at once, unless they are the scene's, for which nobody needs a file: a note says so.
    ///
    /// # Errors
    /// If the settings cannot be written, or there are none yet.
    pub fn save(&mut self, what: Save, folder: &Path) -> Result<Option<PathBuf>> {
        self.order();
        let file = match what {
            Save::State => return self.save_state(folder),
            Save::Png => PictureFile::Png,
            Save::Exr => PictureFile::Exr,
        };
        match self.send(Order::Save(file, folder.to_owned())) {
            true => Ok(None),
            false => Err(Error::Failed(
                "nothing is drawn any more, so no picture can be saved; the state can (T)".to_owned(),
            )),
        }
    }

    fn save_state(&mut self, folder: &Path) -> Result<Option<PathBuf>> {
        let Some(Shown { editor, .. }) = &mut self.shown else { return Err(nothing_yet()) };
        let state = editor.state();
        if state == State::default() {
            editor.mark_saved();
            self.note = Some(Err("nothing is set that differs from the scene; no state is saved".to_owned()));
            return Ok(None);
        }
        let path = write_state(folder, &editor.scene().name, &state)?;
        editor.mark_saved();
        Ok(Some(path))
    }

    /// What was said last of what was asked for, once.
    pub fn take_note(&mut self) -> Option<Note> {
        self.note.take()
    }

    /// What there is to see, once there is.
    pub fn shown(&mut self) -> Option<&mut Shown> {
        self.shown.as_mut()
    }

    /// What the user may want to know.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// Ends, when everything that was ordered is done. Returns what `--stats` writes, if frames were
    /// recorded, and the error that drawing or loading ended with or, if neither, that a picture could not be
    /// saved.
    pub fn end(mut self) -> Outcome {
        self.orders = None;
        let failed = || Outcome { statistics: None, ended: Err(Error::Failed(worker::FAILED.to_owned())) };
        let Outcome { statistics, ended } = self.thread.join().unwrap_or_else(|_| failed());
        let unsaved = self.news.try_iter().find_map(|item| match item {
            News::Saved(Err(reason)) => Some(Err(Error::Failed(reason))),
            _ => None,
        });
        Outcome { statistics, ended: ended.and(unsaved.unwrap_or(Ok(()))) }
    }
}

/// Writes `state` of the scene called `name` into `folder`, under a name of its own, which is returned.
fn write_state(folder: &Path, name: &str, state: &State) -> Result<PathBuf> {
    let text = toml::to_string(state).map_err(|e| Error::Failed(format!("cannot encode the state: {e}")))?;
    write_numbered(folder, name, Save::State.extension(), text.as_bytes())
}

impl Shown {
    /// Plays an animation, now that the maps are there that it names; returns what to say.
    fn play(
        &mut self,
        (animation, place): (Animation, Place),
        maps: std::result::Result<Vec<String>, String>,
    ) -> Note {
        maps?.iter().for_each(|map| self.editor.add_map(map));
        let taken = self.editor.take_animation(animation, &place);
        taken.map(|()| files::playing(&place)).map_err(|error| with_line(error).to_string())
    }

    /// Lights the scene by the map `name`, which has just been added; returns what to say.
    fn lit_by(&mut self, name: String) -> String {
        self.editor.add_map(&name);
        let said = format!("lit by {name}");
        self.editor.edit_light(&EnvironmentState { map: Some(name), ..EnvironmentState::default() });
        said
    }
}

#[cfg(test)]
mod tests;
