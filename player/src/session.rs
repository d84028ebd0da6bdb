//! A bundle being played: what has arrived, what is set, and the frames that follow.

use crate::controls::{Controls, Look, PlacedAnimation, PlacedState, Scope};
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu, Passes, Readback, Timer};
use crate::methods::{Method, Pieces, Playback, Setup};
use crate::stream::{Arrival, Event, Limits, Playlist, Source, decode_all};
use crate::surfaces::Surfaces;
use relume_formats::bundle::{Settings, expect_name, expect_playable, sets_only};
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::manifest::FILE_NAME;
use relume_formats::kinds::transfer_images::Head;
use relume_formats::kinds::{StoredScene, scene};
use relume_formats::state::{Animation, Rgb};
use relume_formats::{Error as FormatError, Place};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What to play.
#[derive(Debug)]
pub struct Request<'a> {
    /// Folder of the bundle.
    pub folder: &'a Path,
    /// Method, or the preferred one.
    pub method: Option<&'a str>,
    /// State to start from.
    pub state: PlacedState,
    /// Animation to play.
    pub animation: Option<AnimationChoice<'a>>,
    /// Size of the film in pixels, or the scene's.
    pub size: Option<[u32; 2]>,
    /// How much may be read, and how fast.
    pub limits: Limits,
}

/// Where an animation comes from.
#[derive(Debug)]
pub enum AnimationChoice<'a> {
    /// One of the bundle's, by name.
    Named(&'a str),
    /// The user's own.
    Own(PlacedAnimation),
}

/// How loading stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// Nothing new; the caller may do something else for a moment.
    Waiting,
    /// Something new arrived.
    Arrived,
    /// Everything that will come is there.
    Loaded {
        /// Whether that is the whole bundle, or the prefix that was asked for.
        complete: bool,
    },
}

/// One rendered frame and its cost.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Linear radiance, row by row, W/(sr·m²).
    pub radiance: Vec<Rgb>,
    /// Exposure that goes with it.
    pub exposure_ev: f32,
    /// What it took.
    pub cost: Cost,
}

/// What a frame took.
#[derive(Debug, Clone, Default)]
pub struct Cost {
    /// Updating, encoding and submitting, in milliseconds.
    pub cpu_ms: f64,
    /// All its passes on the GPU, in milliseconds, where the device tells.
    pub gpu_ms: Option<f64>,
    /// Each of its passes, in milliseconds, where the device tells.
    pub passes_ms: Vec<(&'static str, f64)>,
}

/// A bundle being played.
pub struct Session {
    source: Source,
    gpu: Gpu,
    folder: PathBuf,
    method: Method,
    /// Of all methods of the bundle.
    known: Vec<Method>,
    settings: Settings,
    size: Option<[u32; 2]>,
    /// The method at work, as soon as the scene is there.
    playback: Option<Box<dyn Playback>>,
    /// Sections of the small file that is arriving.
    pending: Vec<Section>,
    scene: Option<scene::Meta>,
    /// At rest, until they are taken.
    surfaces: Surfaces,
    state: PlacedState,
    /// The animations so far; with one to play, that comes first.
    animations: Vec<PlacedAnimation>,
    /// How many there will be.
    animations_expected: usize,
    plays_first: bool,
    bytes_expected: u64,
    controls: Option<Controls>,
    timer: Option<Timer>,
    readback: Option<Readback>,
}

impl Session {
    /// Opens the bundle, then the GPU by `open_gpu`; sections arrive from now on.
    pub fn start(request: Request<'_>, open_gpu: impl FnOnce() -> Result<Gpu>) -> Result<Self> {
        let plays_first = request.animation.is_some();
        let (name, own) = match request.animation {
            None => (None, None),
            Some(AnimationChoice::Named(name)) => (Some(name), None),
            Some(AnimationChoice::Own(animation)) => (None, Some(animation)),
        };
        let playlist = Playlist::of(request.folder, request.method, name)?;
        let animations: Vec<_> = own.into_iter().collect();
        let animations_expected = animations.len() + playlist.items.iter().filter(|item| item.kind == Kind::Animation).count();
        let bytes_expected = playlist.items.iter().map(|item| item.bytes).sum();
        let (method, known, settings) = (playlist.method, playlist.known.clone(), playlist.settings.clone());
        let source = Source::start(playlist, request.limits)?;
        let gpu = open_gpu()?;
        method.expect_adapter(&gpu)?;
        Ok(Self {
            source,
            timer: Timer::new(&gpu),
            gpu,
            folder: request.folder.to_owned(),
            method,
            known,
            settings,
            size: request.size,
            playback: None,
            pending: Vec::new(),
            scene: None,
            surfaces: Surfaces::default(),
            state: request.state,
            animations,
            animations_expected,
            plays_first,
            bytes_expected,
            controls: None,
            readback: None,
        })
    }

    /// Takes in the next section, if there is one. Never waits for the source.
    pub fn advance(&mut self) -> Result<Progress> {
        match self.source.poll()? {
            Event::Waiting => Ok(Progress::Waiting),
            Event::Section(arrival) => self.section_arrived(arrival).map(|()| Progress::Arrived),
            Event::End { complete } => self.check_loaded(complete).map(|()| Progress::Loaded { complete }),
        }
    }

    fn section_arrived(&mut self, arrival: Arrival) -> Result<()> {
        match arrival.kind {
            Kind::Scene => {
                let (place, listed) = (arrival.section.place.clone(), arrival.name.clone());
                if let Some(sections) = self.collect(arrival) {
                    let scene: StoredScene = decode_all(sections)?;
                    expect_name(&scene.meta.name, &listed.unwrap_or_default(), &place)?;
                    self.scene = Some(scene.meta.clone());
                    if scene.meta.varies_view {
                        self.surfaces = Surfaces::new(scene.positions.clone(), scene.triangles.clone());
                    }
                    let setup = Setup { scene, place, settings: self.settings.clone(), size: self.size };
                    self.playback = Some((self.method.start)(&self.gpu, setup)?);
                }
            }
            Kind::Animation => {
                let (place, listed) = (arrival.section.place.clone(), arrival.name.clone());
                if let Some(sections) = self.collect(arrival) {
                    let animation: Animation = decode_all(sections)?;
                    expect_name(&animation.name, &listed.unwrap_or_default(), &place)?;
                    self.animations.push(PlacedAnimation { animation, place });
                }
            }
            _ => {
                let Some(playback) = &mut self.playback else { return Err(self.invalid("comes before the scene")) };
                playback.section_arrived(&self.gpu, arrival)?;
            }
        }
        self.set_up_controls()
    }

    /// Keeps a section of a small file until the last one is there, then hands out all.
    fn collect(&mut self, arrival: Arrival) -> Option<Vec<Section>> {
        self.pending.push(arrival.section);
        arrival.last.then(|| std::mem::take(&mut self.pending))
    }

    fn set_up_controls(&mut self) -> Result<()> {
        if self.controls.is_some() || self.animations.len() < self.animations_expected {
            return Ok(());
        }
        let maps = self.playback.as_ref().and_then(|playback| playback.maps());
        if let Some((scene, maps)) = self.scene.clone().zip(maps) {
            let mut animations = std::mem::take(&mut self.animations).into_iter();
            let animation = if self.plays_first { animations.next() } else { None };
            let scope = Scope { scene, card: self.method.card, maps };
            self.expect_some_method_plays(animation.iter().chain(animations.as_slice()), &scope).map_err(Error::with_line)?;
            self.controls = Some(Controls::new(scope, &self.state, animation, animations.collect()).map_err(Error::with_line)?);
        }
        Ok(())
    }

    /// Fails if no method of the bundle can play an animation. One that another method plays is no fault.
    fn expect_some_method_plays<'a>(&self, mut animations: impl Iterator<Item = &'a PlacedAnimation>, scope: &Scope) -> Result<()> {
        let is_played =
            |placed: &PlacedAnimation| self.known.iter().any(|method| sets_only(&placed.animation, &scope.scene.varies(method.card)));
        animations.try_for_each(|placed| {
            if is_played(placed) {
                return Ok(());
            }
            Ok(expect_playable(&placed.animation, &Look::default_of(&scope.scene), scope, &placed.place)?)
        })
    }

    fn check_loaded(&self, complete: bool) -> Result<()> {
        let Pieces { what, expected, missing, .. } = self.pieces();
        if expected == 0 {
            return Err(self.invalid(&format!("no main file of {} came", self.method.card.name)));
        }
        if !self.is_ready() || (complete && !missing.is_empty()) {
            return Err(self.invalid(&format!("{} of {expected} {what} are missing", missing.len())));
        }
        Ok(())
    }

    /// The error that the bundle as a whole is not what it should be.
    fn invalid(&self, reason: &str) -> Error {
        FormatError::invalid(&Place::file(self.folder.join(FILE_NAME)), format!("{reason}; bake it again")).into()
    }

    /// Whether a frame can be rendered, if only a coarse one.
    pub fn is_ready(&self) -> bool {
        self.controls.is_some() && self.pieces().arrived() > 0
    }

    /// How much has arrived of what the method sums up.
    pub fn pieces(&self) -> Pieces {
        self.playback.as_ref().map_or_else(Pieces::default, |playback| playback.pieces())
    }

    /// The controls, once the scene is there.
    pub fn controls(&self) -> Option<&Controls> {
        self.controls.as_ref()
    }

    /// The film, once its size is known.
    pub fn film(&self) -> Option<&Film> {
        self.playback.as_ref()?.film()
    }

    /// The materials that every pixel shows, where the view is fixed.
    pub fn pixels(&self) -> Option<&Head> {
        self.playback.as_ref()?.pixels()
    }

    /// Hands out the surfaces of the scene at rest; none where the view is fixed.
    pub fn take_surfaces(&mut self) -> Surfaces {
        std::mem::take(&mut self.surfaces)
    }

    /// Where the vertices of the scene are in the last frame, metres in world space, if they move at all.
    pub fn moving_vertices(&self) -> Option<Vec<[f32; 3]>> {
        self.playback.as_ref()?.moving_vertices()
    }

    /// Renders the frame at `time_s` with what has arrived, and waits for it.
    pub fn render(&mut self, time_s: f64) -> Result<Frame> {
        let Some(controls) = &self.controls else { return Err(nothing_there()) };
        let look = controls.look_at(time_s)?;
        let cost = self.draw(&look)?;
        Ok(Frame { radiance: self.read_film()?, exposure_ev: look.camera.exposure_ev, cost })
    }

    /// Fills the film for `look` with what has arrived. Waits for it only where the GPU tells its time.
    pub fn draw(&mut self, look: &Look) -> Result<Cost> {
        let started = Instant::now();
        let labels = self.submit(look)?;
        let cpu_ms = started.elapsed().as_secs_f64() * 1e3;
        let Some(timer) = &self.timer else { return Ok(Cost { cpu_ms, ..Cost::default() }) };
        let times = timer.read(&self.gpu, &labels)?;
        if self.gpu.is_software() {
            // Once llvmpipe has drawn anything, it writes both timestamps of a pass at the same moment.
            return Ok(Cost { cpu_ms, gpu_ms: Some(started.elapsed().as_secs_f64() * 1e3 - cpu_ms), passes_ms: Vec::new() });
        }
        Ok(Cost { cpu_ms, gpu_ms: Some(times.frame_ms), passes_ms: times.passes })
    }

    /// Submits a frame. Returns the labels of the passes that are timed.
    fn submit(&mut self, look: &Look) -> Result<Vec<&'static str>> {
        let Some(playback) = &mut self.playback else { return Err(nothing_there()) };
        playback.update(&self.gpu, look)?;
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let mut passes = Passes::new(&mut encoder, self.timer.as_ref());
        playback.encode(&mut passes);
        let labels = passes.finish();
        self.gpu.queue.submit([encoder.finish()]);
        Ok(labels)
    }

    /// The film as it is: linear radiance, row by row, W/(sr·m²).
    pub fn read_film(&mut self) -> Result<Vec<Rgb>> {
        let Some(film) = self.playback.as_ref().and_then(|playback| playback.film()) else { return Err(nothing_there()) };
        let readback = self.readback.get_or_insert_with(|| Readback::new(&self.gpu, &film.bands));
        readback.radiance(&self.gpu, &film.bands)
    }

    /// The radiance that a white diffuse surface would show at every vertex of the scene in the last frame, W/(sr·m²).
    ///
    /// # Errors
    /// If the method that plays knows nothing of vertices.
    pub fn read_vertices(&self) -> Result<Vec<Rgb>> {
        self.playback.as_ref().map_or_else(|| Err(nothing_there()), |playback| playback.vertex_radiance(&self.gpu))
    }

    /// Name of the method that plays.
    pub fn method_name(&self) -> &'static str {
        self.method.card.name
    }

    /// What the adapter says of itself.
    pub fn adapter(&self) -> &wgpu::AdapterInfo {
        &self.gpu.info
    }

    /// Bytes of all buffers and textures on the device, where the backend tells.
    pub fn gpu_bytes(&self) -> Option<u64> {
        Some(self.gpu.device.generate_allocator_report()?.total_allocated_bytes)
    }

    /// The GPU that it plays on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Bytes of all the files to be played.
    pub fn bytes_expected(&self) -> u64 {
        self.bytes_expected
    }

    /// Bytes read from the bundle's files so far.
    pub fn bytes_streamed(&self) -> u64 {
        self.source.bytes()
    }
}

fn nothing_there() -> Error {
    Error::Failed("nothing has arrived that could be rendered".to_owned())
}
