//! The picture of a bundle that is arriving: drawn when it changes, read back, saved. Knows nothing of
//! windows, and not who says what it is to show.

use crate::error::{Error, Result};
use crate::gpu::{Gpu, PictureReadback};
use crate::output::{encode_exr, encode_png, write_numbered};
use crate::session::{Cost, Session};
use crate::stats::{Appearance, FrameTimes, Recorder};
use crate::ui::{Editor, Facts, Loading, Metering, Picker, Save};
use relume_formats::state::Rgb;
use relume_playback::{Look, Player, Progress, Surfaces};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time that one poll spends on what has arrived.
const POLL: Duration = Duration::from_millis(10);
/// While pieces arrive, the time from one frame to the next for their sake alone, as a multiple of what a
/// frame takes: frames that the user causes come without one in between.
const REFINING_PAUSE_FACTOR: f64 = 3.0;

/// A bundle's picture.
pub struct Picture {
    session: Session,
    started: Instant,
    loading: Load,
    target: Option<Target>,
    /// What the picture shows.
    drawn: Option<Look>,
    /// Whether pieces have arrived that the picture lacks.
    stale: bool,
    /// When the picture may next be drawn again for the sake of new pieces alone.
    refine_at: Instant,
    /// Number of the first frame of the whole bundle.
    full_from: Option<u64>,
    times: FrameTimes,
    recorder: Option<Recorder>,
    appearance: Appearance,
}

/// How loading stands.
enum Load {
    Arriving,
    Loaded { complete: bool },
    Failed(Error),
}

/// A file that the picture can be written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFile {
    /// The picture as shown.
    Png,
    /// Linear radiance.
    Exr,
}

/// What there is as soon as there is anything to see.
pub struct Ready {
    /// The settings that the player starts with.
    pub editor: Editor,
    /// Which material is where, if the view is fixed.
    pub picker: Option<Picker>,
    /// What the camera must not go through.
    pub surfaces: Surfaces,
    /// Size of the film in pixels.
    pub size: [u32; 2],
    /// Whether [`Picture::resize`] changes it.
    pub resizes: bool,
}

/// What the picture is drawn on.
struct Target {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    readback: PictureReadback,
}

impl Target {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let texture = gpu.picture(size);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { readback: PictureReadback::new(gpu, size), texture, view }
    }
}

impl Picture {
    /// Of `session`, which began at `started`. With `record`, the cost of every frame is kept for
    /// [`Picture::statistics`].
    pub fn new(session: Session, started: Instant, record: bool) -> Self {
        Self {
            session,
            started,
            loading: Load::Arriving,
            target: None,
            drawn: None,
            stale: false,
            refine_at: started,
            full_from: None,
            times: FrameTimes::default(),
            recorder: record.then(Recorder::default),
            appearance: Appearance::default(),
        }
    }

    /// Takes in what has arrived, of the bundle and from the GPU. Returns whether anything of the bundle has.
    ///
    /// # Errors
    /// If the bundle fails before there is anything to show. Later failures are kept, see
    /// [`Picture::finish`].
    pub fn poll(&mut self) -> Result<bool> {
        self.take_costs()?;
        let until = Instant::now() + POLL;
        let mut changed = false;
        while matches!(self.loading, Load::Arriving) && Instant::now() < until {
            match self.session.advance() {
                Ok(Progress::Waiting) => break,
                Ok(Progress::Arrived) => self.stale = true,
                Ok(Progress::Loaded { complete }) => {
                    self.loading = Load::Loaded { complete };
                    // The last frame is the one whose time counts as that of full quality.
                    self.stale = true;
                }
                Err(error) if self.target.is_some() => self.loading = Load::Failed(error),
                Err(error) => return Err(error),
            }
            changed = true;
            if self.target.is_none() && self.session.player().is_ready() {
                break;
            }
        }
        Ok(changed)
    }

    /// What there is to see, once, as soon as there is.
    pub fn ready(&mut self) -> Option<Ready> {
        if self.target.is_some() || !self.session.player().is_ready() {
            return None;
        }
        let (size, mut editor) =
            (self.session.player().film()?.size, Editor::new(self.session.player().controls()?));
        if self.session.meters() {
            editor.meter(Metering::WhenWhole);
        }
        self.target = Some(Target::new(self.session.gpu(), size));
        let (picker, resizes) = (self.session.player().materials().map(Picker::new), self.session.resizes());
        Some(Ready { editor, picker, surfaces: self.session.player_mut().take_surfaces(), size, resizes })
    }

    /// Draws at `size` in pixels from now on or, where so many cannot be drawn, at the largest of the same
    /// shape; if the size is free and there is anything to see yet.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        let free = self.session.resizes() && self.target.is_some();
        let size = self.session.player().drawable_size(size).filter(|_| free);
        let Some(size) = size.filter(|size| *size != self.size()) else { return Ok(()) };
        self.session.resize(size)?;
        self.target = Some(Target::new(self.session.gpu(), size));
        self.drawn = None;
        Ok(())
    }

    /// Size in pixels; none before there is anything to see.
    pub fn size(&self) -> [u32; 2] {
        self.target.as_ref().map_or([0, 0], |target| [target.texture.width(), target.texture.height()])
    }

    /// Brings the picture up to date with `look`, doing no more than what has changed asks for, and without
    /// waiting for the GPU. Returns whether it changed.
    pub fn draw(&mut self, look: &Look) -> Result<bool> {
        let Some(target) = &self.target else { return Ok(false) };
        let same_but_for_display =
            self.drawn.as_ref().is_some_and(|drawn| drawn.displayed(look.display()) == *look);
        let refines = self.refines();
        if self.drawn.as_ref() == Some(look) && !refines {
            return Ok(false);
        }
        let (texture, view, readback) =
            (target.texture.clone(), target.view.clone(), target.readback.clone());
        let show = |player: &mut Player, encoder: &mut wgpu::CommandEncoder| {
            player.show(encoder, &view, look.display())?;
            readback.encode(encoder, &texture);
            Ok(())
        };
        if !same_but_for_display || refines {
            self.frame_drawn(|session| session.draw(look, show))?;
        } else {
            self.session.submit(show)?;
        }
        self.drawn = Some(look.clone());
        self.session.gpu().check()?;
        Ok(true)
    }

    /// The picture as last drawn, once the GPU is done with it: sRGB-encoded RGBA, row by row.
    pub fn pixels(&self) -> Result<Vec<u8>> {
        let Some(target) = &self.target else { return Ok(Vec::new()) };
        target.readback.read(self.session.gpu())
    }

    /// Where the vertices are that move with shapes, metres in world space, in the frame last drawn.
    pub fn moving_vertices(&self) -> Option<Vec<[f32; 3]>> {
        self.session.player().moving_vertices()
    }

    /// The exposure that the picture asks for, if it is as whole as `metering` wants: EV, or nothing for one
    /// without light.
    pub fn metered(&mut self, metering: Metering) -> Result<Option<Option<f32>>> {
        let is_whole = !self.is_loading() && !self.stale;
        if self.drawn.is_none() || (metering == Metering::WhenWhole && !is_whole) {
            return Ok(None);
        }
        self.session.metered_ev().map(Some)
    }

    /// Adds the environment map in the file at `path`; returns the name to choose it by.
    ///
    /// # Errors
    /// If the file holds no map, or the light does not vary. Then nothing has changed.
    pub fn add_environment(&mut self, path: &Path) -> Result<String> {
        let name = self.session.add_environment(path)?;
        // One of the same name may have been exchanged.
        self.stale = true;
        Ok(name)
    }

    fn refines(&self) -> bool {
        self.stale && (!self.is_loading() || Instant::now() >= self.refine_at)
    }

    /// Draws a frame by `draw`, of all that has arrived.
    fn frame_drawn(&mut self, draw: impl FnOnce(&mut Session) -> Result<u64>) -> Result<()> {
        let began = Instant::now();
        let frame = draw(&mut self.session)?;
        self.stale = false;
        self.rest(began.elapsed());
        if matches!(self.loading, Load::Loaded { complete: true }) {
            self.full_from.get_or_insert(frame);
        }
        Ok(())
    }

    /// Leaves most of the time to loading, after a frame that `took` so long.
    fn rest(&mut self, took: Duration) {
        self.refine_at = self.refine_at.max(Instant::now() + took.mul_f64(REFINING_PAUSE_FACTOR));
    }

    /// Notes what frames took that are done.
    pub fn take_costs(&mut self) -> Result<()> {
        for cost in self.session.take_costs()? {
            self.record(&cost);
        }
        Ok(())
    }

    /// Notes a frame that is done by now.
    fn record(&mut self, cost: &Cost) {
        let now = Instant::now();
        self.rest(Duration::from_secs_f64((cost.cpu_ms + cost.gpu_ms.unwrap_or_default()) * 1e-3));
        self.times.add(now, cost);
        if let Some(recorder) = &mut self.recorder {
            recorder.add(cost);
        }
        let elapsed_s = Some(now.duration_since(self.started).as_secs_f64());
        self.appearance.first_s = self.appearance.first_s.or(elapsed_s);
        if self.full_from.is_some_and(|first| cost.frame >= first) {
            self.appearance.full_s = self.appearance.full_s.or(elapsed_s);
        }
    }

    /// Whether more may arrive.
    pub fn is_loading(&self) -> bool {
        matches!(self.loading, Load::Arriving)
    }

    /// What the user may want to know.
    pub fn facts(&self) -> Facts {
        let pieces = self.session.player().pieces();
        let (cpu_ms, gpu_ms) = self.times.medians();
        Facts {
            adapter: self.session.adapter().name.clone(),
            method: self.session.player().method().card.name.to_owned(),
            size: self.session.player().film().map(|film| film.size),
            cpu_ms,
            gpu_ms,
            bytes: self.session.bytes_streamed(),
            bytes_expected: self.session.bytes_expected(),
            what: pieces.what,
            map_from_outside: self.session.player().shows_map_from_outside(),
            rebaked: false,
            pieces: pieces.arrived(),
            pieces_expected: pieces.expected,
            loading: match &self.loading {
                Load::Arriving => Loading::Arriving,
                Load::Loaded { complete: true } => Loading::Complete,
                Load::Loaded { complete: false } => Loading::Prefix,
                Load::Failed(error) => Loading::Failed(error.to_string()),
            },
        }
    }

    /// Writes the picture as last drawn into `folder`, under a name of its own. Returns the path.
    ///
    /// # Errors
    /// If nothing is drawn yet, or it cannot be written.
    pub fn save(&mut self, what: PictureFile, folder: &Path) -> Result<PathBuf> {
        let (Some(look), Some(controls)) = (&self.drawn, self.session.player().controls()) else {
            return Err(nothing_yet());
        };
        let (name, display) = (controls.scope().scene.name.clone(), look.display());
        let size = self.size();
        let radiance = self.session.read_film()?;
        let (bytes, extension) = match what {
            PictureFile::Exr => (encode_exr(size, &radiance)?, Save::Exr.extension()),
            PictureFile::Png => {
                let linear: Vec<Rgb> = radiance.iter().map(|radiance| display.shown(*radiance)).collect();
                (encode_png(size, &linear)?, Save::Png.extension())
            }
        };
        write_numbered(folder, &name, extension, &bytes)
    }

    /// What `--stats` writes, if frames were recorded.
    pub fn statistics(&mut self) -> Result<Option<Vec<u8>>> {
        self.session.wait()?;
        self.take_costs()?;
        let Some(recorder) = self.recorder.take() else { return Ok(None) };
        recorder.finish(&self.session, self.appearance).map(Some)
    }

    /// The end.
    ///
    /// # Errors
    /// The error that loading ended with, if it did.
    pub fn finish(&mut self) -> Result<()> {
        match std::mem::replace(&mut self.loading, Load::Loaded { complete: true }) {
            Load::Failed(error) => Err(error),
            Load::Arriving | Load::Loaded { .. } => Ok(()),
        }
    }
}

/// The error that there is nothing to save.
pub fn nothing_yet() -> Error {
    Error::Failed("there is nothing to save yet".to_owned())
}

#[cfg(test)]
mod tests;
