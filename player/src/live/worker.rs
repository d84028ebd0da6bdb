//! The thread that draws: it takes orders and tells news.

use crate::error::{Error, Result};
use crate::picture::{Picture, PictureFile, Ready};
use crate::ui::{Facts, Metering};
use relume_formats::state::Posed;
use relume_playback::Look;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// How often to look whether anything has arrived.
const POLL_PAUSE: Duration = Duration::from_millis(10);
/// While loading, least time from one telling of how it stands to the next: most of the time belongs to
/// loading.
const PROGRESS_PAUSE: Duration = Duration::from_millis(60);

/// What the thread is to do.
pub enum Order {
    /// Show this look, and none that was ordered before.
    Show(Box<Look>),
    /// Draw the picture at this size, in pixels, or the nearest that can be drawn.
    Resize([u32; 2]),
    /// Tell the exposure that the picture asks for.
    Meter(Metering),
    /// Add the environment map in this file.
    Light(PathBuf),
    /// Add the environment maps in these files, for an animation to name.
    Maps(Vec<PathBuf>),
    /// Write the picture into this folder.
    Save(PictureFile, PathBuf),
}

/// What the thread tells.
pub enum News {
    /// How things stand.
    Facts(Box<Facts>),
    /// There is something to see.
    Ready(Box<Ready>),
    /// A new picture of this size in pixels, sRGB-encoded RGBA, row by row, and where the vertices are if they
    /// have moved.
    Drawn { size: [u32; 2], pixels: Vec<u8>, moved: Option<Vec<[f32; 3]>> },
    /// The exposure that was asked for, if the picture has any light, in EV.
    Metered(Option<f32>),
    /// A map was added under this name, or why it was not.
    Lit(std::result::Result<String, String>),
    /// Maps were added under these names, or why they were not.
    Mapped(std::result::Result<Vec<String>, String>),
    /// A picture was written to this file, or why it was not.
    Saved(std::result::Result<PathBuf, String>),
    /// Whether another bake of the bundle is on disk than the one on show.
    Rebaked(bool),
    /// Nothing is drawn any more, for this reason.
    Ended(String),
}

/// What a thread that fails says of itself.
pub const FAILED: &str = "the thread that draws has failed; please report this";

/// What is left when it ends.
pub struct Outcome {
    /// What `--stats` writes, if frames were recorded.
    pub statistics: Option<Vec<u8>>,
    /// How drawing and loading ended.
    pub ended: Result<()>,
}

/// The thread's own.
pub struct Worker<T: Fn(News)> {
    picture: Picture,
    tell: T,
    /// What to show.
    look: Option<Look>,
    /// The size that was ordered last, until the picture has it.
    size: Option<[u32; 2]>,
    /// What shapes show in the picture.
    shapes_drawn: Option<BTreeMap<String, Posed>>,
    metering: Option<Metering>,
    told: Option<Facts>,
    told_at: Option<Instant>,
}

/// Whoever waits for news learns of a thread that panics, too.
impl<T: Fn(News)> Drop for Worker<T> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            (self.tell)(News::Ended(FAILED.to_owned()));
        }
    }
}

impl<T: Fn(News)> Worker<T> {
    /// Draws `picture` and tells by `tell`.
    pub fn new(picture: Picture, tell: T) -> Self {
        Self {
            picture,
            tell,
            look: None,
            size: None,
            shapes_drawn: None,
            metering: None,
            told: None,
            told_at: None,
        }
    }

    /// Works until nobody gives orders any more.
    pub fn run(mut self, orders: &Receiver<Order>) -> Outcome {
        if let Err(error) = self.work(orders) {
            (self.tell)(News::Ended(error.to_string()));
            return Outcome { statistics: None, ended: Err(error) };
        }
        match self.picture.statistics() {
            Ok(statistics) => Outcome { statistics, ended: self.picture.finish() },
            Err(error) => Outcome { statistics: None, ended: Err(error) },
        }
    }

    fn work(&mut self, orders: &Receiver<Order>) -> Result<()> {
        loop {
            let arrived = self.picture.poll()?;
            if let Some(ready) = self.picture.ready() {
                self.look = Some(ready.editor.look());
                (self.tell)(News::Ready(Box::new(ready)));
            }
            self.draw()?;
            self.meter()?;
            self.tell_facts();
            let Some(order) = self.next(orders, arrived) else { return Ok(()) };
            order.into_iter().for_each(|order| self.obey(order));
            while let Ok(order) = orders.try_recv() {
                self.obey(order);
            }
        }
    }

    /// Waits for the next order; for a while only where more may arrive. `None` if nobody gives orders any
    /// more.
    fn next(&self, orders: &Receiver<Order>, arrived: bool) -> Option<Option<Order>> {
        if !self.picture.is_loading() {
            return orders.recv().ok().map(Some);
        }
        match orders.recv_timeout(if arrived { Duration::ZERO } else { POLL_PAUSE }) {
            Ok(order) => Some(Some(order)),
            Err(RecvTimeoutError::Timeout) => Some(None),
            Err(RecvTimeoutError::Disconnected) => None,
        }
    }

    fn obey(&mut self, order: Order) {
        let words = |error: Error| error.to_string();
        match order {
            Order::Show(look) => self.look = Some(*look),
            Order::Resize(size) => self.size = Some(size),
            Order::Meter(metering) => self.metering = Some(metering),
            Order::Light(path) => {
                let added = self.picture.add_environment(&path).map_err(words);
                (self.tell)(News::Lit(added));
            }
            Order::Maps(paths) => {
                let added = paths.iter().map(|path| self.picture.add_environment(path));
                let added = added.collect::<Result<Vec<_>>>().map_err(words);
                (self.tell)(News::Mapped(added));
            }
            Order::Save(file, folder) => {
                let saved = self.draw().and_then(|()| self.picture.save(file, &folder)).map_err(words);
                (self.tell)(News::Saved(saved));
            }
        }
    }

    /// Draws what has changed, and tells it when it is done.
    fn draw(&mut self) -> Result<()> {
        let Some(look) = &self.look else { return Ok(()) };
        if let Some(size) = self.size.take() {
            self.picture.resize(size)?;
        }
        if self.picture.draw(look)? {
            let pixels = self.picture.pixels()?;
            let moved = self.shapes_drawn.as_ref().is_none_or(|drawn| *drawn != look.shapes);
            let moved = if moved { self.picture.moving_vertices() } else { None };
            self.shapes_drawn = Some(look.shapes.clone());
            (self.tell)(News::Drawn { size: self.picture.size(), pixels, moved });
            // What the frame took is known by now.
            self.picture.take_costs()?;
        }
        Ok(())
    }

    fn meter(&mut self) -> Result<()> {
        let Some(metering) = self.metering else { return Ok(()) };
        if let Some(ev) = self.picture.metered(metering)? {
            self.metering = None;
            (self.tell)(News::Metered(ev));
        }
        Ok(())
    }

    fn tell_facts(&mut self) {
        let soon = self.told_at.is_some_and(|at| at.elapsed() < PROGRESS_PAUSE);
        if soon && self.picture.is_loading() {
            return;
        }
        let facts = self.picture.facts();
        if self.told.as_ref() != Some(&facts) {
            (self.told, self.told_at) = (Some(facts.clone()), Some(Instant::now()));
            (self.tell)(News::Facts(Box::new(facts)));
        }
    }
}
