//! A bundle shown while it arrives and edited while it is shown. Knows nothing of windows: it is polled, it draws, it saves.

mod environment;
mod metering;

use crate::error::{Error, Result};
use crate::output::{encode_exr, encode_png, write_numbered};
use crate::session::{Cost, Session};
use crate::stats::{Appearance, FrameTimes, Recorder};
use crate::ui::{Editor, Facts, Loading, Metering, Picker, Save, Stage};
use relume_formats::state::Rgb;
use relume_playback::{Look, Player, Progress, Surfaces};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time that one poll spends on what has arrived.
const POLL: Duration = Duration::from_millis(10);
/// While pieces arrive, the time from one frame to the next for their sake alone, as a multiple of what a frame takes: frames that the user causes
/// come without one in between.
const REFINING_PAUSE_FACTOR: f64 = 3.0;

/// Frames that may be under way on the GPU at once, so that none shows what the user did long ago.
const MOST_UNDER_WAY: usize = 2;

/// A bundle on show.
pub struct Live {
    session: Session,
    started: Instant,
    loading: Load,
    shown: Option<Shown>,
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

/// What there is as soon as there is anything to see.
pub struct Shown {
    /// What the user has set.
    pub editor: Editor,
    /// Which material is where, if the view is fixed.
    pub picker: Option<Picker>,
    /// What the camera must not go through.
    pub surfaces: Surfaces,
    /// Size of the film in pixels.
    pub size: [u32; 2],
    /// What the display shows: sRGB-encoded values.
    pub picture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Shown {
    /// What the screen shows of it, with `picture` for the picture.
    pub fn stage(&mut self, picture: egui::TextureId) -> Stage<'_> {
        let Self { editor, picker, surfaces, size, .. } = self;
        Stage { editor, picker: picker.as_ref(), surfaces, size: *size, picture }
    }
}

impl Live {
    /// Shows `session`, which began at `started`. With `record`, the cost of every frame is kept for [`Live::statistics`].
    pub fn new(session: Session, started: Instant, record: bool) -> Self {
        Self {
            session,
            started,
            loading: Load::Arriving,
            shown: None,
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
    /// If the bundle fails before there is anything to show. Later failures are kept, see [`Live::finish`].
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
                Err(error) if self.shown.is_some() => self.loading = Load::Failed(error),
                Err(error) => return Err(error),
            }
            changed = true;
            self.show_if_ready();
        }
        Ok(changed)
    }

    fn show_if_ready(&mut self) {
        if self.shown.is_none()
            && self.session.player().is_ready()
            && let Some(controls) = self.session.player().controls()
        {
            let Some(film) = self.session.player().film() else { return };
            let (mut editor, size, picture) = (Editor::new(controls), film.size, self.session.gpu().picture(film.size));
            let picker = self.session.player().materials().map(Picker::new);
            let (surfaces, view) =
                (self.session.player_mut().take_surfaces(), picture.create_view(&wgpu::TextureViewDescriptor::default()));
            if self.session.meters() {
                editor.meter(Metering::WhenWhole);
            }
            self.shown = Some(Shown { editor, picker, surfaces, size, picture, view });
        }
    }

    /// Draws what has changed of the picture. Returns whether anything has.
    fn draw_changes(&mut self) -> Result<bool> {
        let Some(shown) = &self.shown else { return Ok(false) };
        let look = shown.editor.look();
        let display = look.display();
        let same_radiance = self.drawn.as_ref().is_some_and(|drawn| drawn.displayed(display) == look);
        let refines = self.refines();
        if self.drawn.as_ref() == Some(&look) && !refines {
            return Ok(false);
        }
        let view = shown.view.clone();
        let show = |player: &mut Player, encoder: &mut _| Ok(player.show(encoder, &view, display)?);
        if !same_radiance || refines {
            self.frame_drawn(|session| session.draw(&look, show))?;
        } else {
            self.session.submit(show)?;
        }
        self.move_surfaces(&look);
        self.drawn = Some(look);
        self.session.gpu().check()?;
        Ok(true)
    }

    /// Lets the surfaces follow the shapes of a `look` that was just drawn.
    fn move_surfaces(&mut self, look: &Look) {
        let moved = self.drawn.as_ref().is_none_or(|drawn| drawn.shapes != look.shapes);
        if let (true, Some(shown)) = (moved, &mut self.shown)
            && let Some(positions) = self.session.player().moving_vertices()
        {
            shown.surfaces.set_positions(positions);
        }
    }

    fn refines(&self) -> bool {
        self.stale && (!self.is_loading() || (self.session.frames_under_way() == 0 && Instant::now() >= self.refine_at))
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

    fn take_costs(&mut self) -> Result<()> {
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

    /// Whether frames are under way, of which something will be to be told by [`Live::poll`].
    pub fn awaits_frames(&self) -> bool {
        self.session.frames_under_way() > 0
    }

    /// Whether so many frames are under way that another would only come later.
    pub fn is_behind(&self) -> bool {
        self.session.frames_under_way() >= MOST_UNDER_WAY
    }

    /// Whether more may arrive.
    pub fn is_loading(&self) -> bool {
        matches!(self.loading, Load::Arriving)
    }

    /// What there is to see, once there is.
    pub fn shown(&mut self) -> Option<&mut Shown> {
        self.shown.as_mut()
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

    /// Writes the picture or the settings into `folder`, under a name of its own. Returns the path.
    pub fn save(&mut self, what: Save, folder: &Path) -> Result<PathBuf> {
        self.draw()?;
        let (Some(shown), Some(look)) = (&self.shown, &self.drawn) else {
            return Err(Error::Failed("there is nothing to save yet".to_owned()));
        };
        let (name, display) = (shown.editor.scene().name.clone(), look.display());
        let size = shown.size;
        let bytes = match what {
            Save::State => {
                let text = toml::to_string(&shown.editor.state());
                text.map_err(|e| Error::Failed(format!("cannot encode the state: {e}")))?.into_bytes()
            }
            Save::Exr => encode_exr(size, &self.session.read_film()?)?,
            Save::Png => {
                let linear: Vec<Rgb> = self.session.read_film()?.iter().map(|radiance| display.shown(*radiance)).collect();
                encode_png(size, &linear)?
            }
        };
        write_numbered(folder, &name, what.extension(), &bytes)
    }

    /// What `--stats` writes, if frames were recorded.
    pub fn statistics(&mut self) -> Result<Option<Vec<u8>>> {
        self.session.wait()?;
        self.take_costs()?;
        let Some(recorder) = self.recorder.take().filter(|_| self.shown.is_some()) else { return Ok(None) };
        recorder.finish(&self.session, self.appearance).map(Some)
    }

    /// The end.
    ///
    /// # Errors
    /// The error that loading ended with, if it did.
    pub fn finish(self) -> Result<()> {
        match self.loading {
            Load::Failed(error) => Err(error),
            Load::Arriving | Load::Loaded { .. } => Ok(()),
        }
    }

    /// The bundle being played.
    pub fn session(&self) -> &Session {
        &self.session
    }
}

#[cfg(test)]
mod tests;
