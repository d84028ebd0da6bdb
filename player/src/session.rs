//! A bundle being played from files, on a GPU of its own: the core with a source, a clock, and someone who
//! waits.

mod costs;

pub use costs::Cost;

use crate::environment;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Readback};
use crate::stream::{Edition, Files, Limits};
use costs::Costs;
use relume_formats::display::{Display, auto_exposure_ev};
use relume_formats::state::Rgb;

use relume_playback::{Look, Options, PlacedAnimation, PlacedState, Player, Playlist, Progress};
use std::path::Path;
use std::time::Instant;
use wgpu::{CommandEncoder, CommandEncoderDescriptor};

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
    /// An environment map of the user's own, to shine from the start.
    pub environment: Option<&'a Path>,
    /// Whether the exposure is to be set by the picture.
    pub meters: bool,
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

/// One rendered frame and its cost.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Linear radiance, row by row, W/(sr·m²).
    pub radiance: Vec<Rgb>,
    /// How a display is to show it.
    pub display: Display,
    /// What it took.
    pub cost: Cost,
}

/// A bundle being played.
pub struct Session {
    edition: Edition,
    files: Files,
    gpu: Gpu,
    player: Player,
    bytes_expected: u64,
    costs: Costs,
    readback: Option<Readback>,
    meters: bool,
    resizes: bool,
}

impl Session {
    /// Opens the bundle, then the GPU by `open_gpu`; sections arrive from now on.
    pub fn start(request: Request<'_>, open_gpu: impl FnOnce() -> Result<Gpu>) -> Result<Self> {
        let (meters, free) = (request.meters, request.size.is_none());
        let (name, own) = match request.animation {
            None => (None, None),
            Some(AnimationChoice::Named(name)) => (Some(name), None),
            Some(AnimationChoice::Own(animation)) => (None, Some(animation)),
        };
        let environment = request.environment.map(environment::read).transpose()?;
        let edition = Edition::read(request.folder)?;
        let playlist = Playlist::of(edition.manifest(), &edition.place(), request.method, name)?;
        let bytes_expected = playlist.items.iter().map(|item| item.bytes).sum();
        let resizes = free && playlist.method.resizes;
        let files = Files::start(playlist.clone(), edition.clone(), request.limits)?;
        let mut gpu = open_gpu()?;
        let radiance_on_cpu = gpu.leaves_sums_of(&playlist.method)?;
        let options = Options {
            state: request.state,
            animation: own,
            environment,
            find_map: Some(environment::beside),
            size: request.size,
            radiance_on_cpu,
        };
        let player = Player::new(&gpu.device, &gpu.queue, &playlist, options)?;
        let costs = Costs::new(player.is_timed(), gpu.is_software());
        Ok(Self { edition, files, gpu, player, bytes_expected, costs, readback: None, meters, resizes })
    }

    /// Takes in the next section, if there is one. Never waits for the source.
    pub fn advance(&mut self) -> Result<Progress> {
        let progress =
            self.player.advance(&mut self.files).map_err(|error| Error::from(error).with_line())?;
        self.gpu.check()?;
        Ok(progress)
    }

    /// Renders the frame at `time_s` with what has arrived, and waits for it.
    pub fn render(&mut self, time_s: f64) -> Result<Frame> {
        let Some(controls) = self.player.controls() else { return Err(nothing_there()) };
        let look = controls.look_at(time_s)?;
        let frame = self.draw(&look, |_, _| Ok(()))?;
        if self.player.is_timed() {
            // Before anything else is submitted, so that the time is the frame's alone.
            self.gpu.wait()?;
        }
        let radiance = self.read_film()?;
        let cost = self.take_costs()?.into_iter().find(|cost| cost.frame == frame).unwrap_or_default();
        Ok(Frame { radiance, display: look.display(), cost })
    }

    /// Whether the frames' size is free: neither baked nor asked for.
    pub fn resizes(&self) -> bool {
        self.resizes
    }

    /// Draws frames of `size` pixels from now on.
    ///
    /// # Errors
    /// Those of [`Player::resize`].
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        self.player.resize(size)?;
        // It was made for the film that there was.
        self.readback = None;
        Ok(())
    }

    /// Whether the exposure is to be set by the picture.
    pub fn meters(&self) -> bool {
        self.meters
    }

    /// The exposure of the film as it is, EV; `None` of one without light.
    pub fn metered_ev(&mut self) -> Result<Option<f32>> {
        Ok(auto_exposure_ev(&self.read_film()?))
    }

    /// Adds the environment map in the file at `path`, to be chosen by the name that is returned.
    ///
    /// # Errors
    /// If the file holds no map, or the bundle's light does not vary.
    pub fn add_environment(&mut self, path: &Path) -> Result<String> {
        let environment = environment::read(path)?;
        self.player.add_environment(&environment)?;
        Ok(environment.name)
    }

    /// Submits a frame: the film for `look` with what has arrived, then what `more` adds. Does not wait for
    /// it. Returns its number.
    pub fn draw(
        &mut self,
        look: &Look,
        more: impl FnOnce(&mut Player, &mut CommandEncoder) -> Result<()>,
    ) -> Result<u64> {
        let started = Instant::now();
        let mut encoder = self.encoder("frame");
        let frame = self.player.draw(&mut encoder, look)?;
        more(&mut self.player, &mut encoder)?;
        self.costs.watch(frame, &encoder);
        self.gpu.queue.submit([encoder.finish()]);
        self.costs.submitted(frame, started);
        Ok(frame)
    }

    /// Submits what `more` encodes, without a new frame.
    pub fn submit(
        &mut self,
        more: impl FnOnce(&mut Player, &mut CommandEncoder) -> Result<()>,
    ) -> Result<()> {
        let mut encoder = self.encoder("no frame");
        more(&mut self.player, &mut encoder)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn encoder(&self, label: &str) -> CommandEncoder {
        self.gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: Some(label) })
    }

    /// What frames took that are done, as far as that has become known since the last call. Does not wait for
    /// others.
    pub fn take_costs(&mut self) -> Result<Vec<Cost>> {
        self.gpu.poll()?;
        Ok(self.costs.take(self.player.times()))
    }

    /// Waits until every frame is done.
    pub fn wait(&self) -> Result<()> {
        self.gpu.wait()
    }

    /// The film as it is: linear radiance, row by row, W/(sr·m²).
    pub fn read_film(&mut self) -> Result<Vec<Rgb>> {
        let Some(film) = self.player.film() else { return Err(nothing_there()) };
        let readback = self.readback.get_or_insert_with(|| Readback::new(&self.gpu, &film.bands));
        readback.radiance(&self.gpu, &film.bands)
    }

    /// The radiance that a white diffuse surface would show at every vertex of the scene in the last frame,
    /// W/(sr·m²).
    ///
    /// # Errors
    /// If the method that plays knows nothing of vertices.
    pub fn read_vertices(&self) -> Result<Vec<Rgb>> {
        let Some(radiance) = self.player.vertex_radiance() else {
            return Err(Error::Usage(
                "this method computes no radiance at vertices; choose another with --method".to_owned(),
            ));
        };
        let read = Readback::new(&self.gpu, [radiance.buffer]).radiance(&self.gpu, [radiance.buffer])?;
        Ok(read.into_iter().map(|rgb| std::array::from_fn(|k| rgb[k] * radiance.gain[k])).collect())
    }

    /// Which bake of the bundle plays.
    pub fn edition(&self) -> &Edition {
        &self.edition
    }

    /// What plays.
    pub fn player(&self) -> &Player {
        &self.player
    }

    /// What plays, to change.
    pub fn player_mut(&mut self) -> &mut Player {
        &mut self.player
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
        self.files.bytes()
    }
}

fn nothing_there() -> Error {
    relume_playback::Error::NothingThere.into()
}
