//! A bundle being played: what has arrived, what is set, and the frames that follow.

use crate::controls::{Controls, Look, PlacedAnimation, PlacedState};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Readback, Timer};
use crate::methods::transfer_images::{Images, TransferImages, decode_all};
use crate::stream::{Animations, Arrival, Event, Limits, Playlist, Source};
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::{StoredScene, scene};
use relume_formats::state::{Animation, Rgb};
use relume_formats::{Error as FormatError, Place};
use std::collections::BTreeSet;
use std::path::Path;
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
    /// Whether to read all of the bundle's animations, for the user to choose from, or only the one to play.
    pub offer_all: bool,
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
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Updating coefficients, encoding and submitting, in milliseconds.
    pub cpu_ms: f64,
    /// The pass on the GPU, in milliseconds, where the device tells.
    pub gpu_ms: Option<f64>,
}

/// A bundle being played.
pub struct Session {
    source: Source,
    gpu: Gpu,
    method_name: String,
    method: TransferImages,
    /// Sections of the small file that is arriving.
    pending: Vec<Section>,
    scene: Option<scene::Meta>,
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
        let wanted = if request.offer_all { Animations::All { first: name } } else { Animations::Only(name) };
        let playlist = Playlist::of(request.folder, request.method, wanted)?;
        let animations: Vec<_> = own.into_iter().collect();
        let animations_expected = animations.len() + playlist.items.iter().filter(|item| item.kind == Kind::Animation).count();
        let bytes_expected = playlist.items.iter().map(|item| item.bytes).sum();
        let method_name = playlist.method.clone();
        let source = Source::start(playlist, request.limits)?;
        let gpu = open_gpu()?;
        Ok(Self {
            source,
            timer: Timer::new(&gpu),
            gpu,
            method_name,
            method: TransferImages::default(),
            pending: Vec::new(),
            scene: None,
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
                if let Some(sections) = self.collect(arrival) {
                    self.scene = Some(decode_all::<StoredScene>(sections)?.meta);
                }
            }
            Kind::Animation => {
                let place = arrival.section.place.clone();
                if let Some(sections) = self.collect(arrival) {
                    self.animations.push(PlacedAnimation { animation: decode_all::<Animation>(sections)?, place });
                }
            }
            _ => {
                let known = self.method.images().is_some();
                self.method.section_arrived(&self.gpu, arrival)?;
                if let Some(images) = self.method.images().filter(|_| !known) {
                    self.check_same_bake(images)?;
                }
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
        let all_known = self.animations.len() == self.animations_expected;
        if let Some(scene) = self.scene.as_ref().filter(|_| self.controls.is_none() && all_known) {
            let mut animations = std::mem::take(&mut self.animations).into_iter();
            let animation = if self.plays_first { animations.next() } else { None };
            self.controls = Some(Controls::new(scene, &self.state, animation, animations.collect())?);
        }
        Ok(())
    }

    /// Files of different bakes can each be sound and yet not fit together.
    fn check_same_bake(&self, images: &Images) -> Result<()> {
        let Some(scene) = &self.scene else { return Ok(()) };
        let varying: BTreeSet<_> = scene.materials.iter().filter(|m| m.varies).map(|m| &m.name).collect();
        if scene.size != images.size() || varying != images.materials().iter().collect() {
            let reason = "film size or editable materials differ from the scene file's; the files are of different bakes, bake it again";
            return Err(FormatError::invalid(images.place(), reason).into());
        }
        Ok(())
    }

    fn check_loaded(&self, complete: bool) -> Result<()> {
        let missing = self.images()?.missing().len();
        if self.controls.is_none() || !self.is_ready() || (complete && missing > 0) {
            let reason = format!("{missing} images are missing; bake it again");
            return Err(FormatError::invalid(self.images()?.place(), reason).into());
        }
        Ok(())
    }

    /// Whether a frame can be rendered, if only a coarse one.
    pub fn is_ready(&self) -> bool {
        self.controls.is_some() && self.method.images().is_some_and(Images::any_present)
    }

    /// The controls, once the scene is there.
    pub fn controls(&self) -> Option<&Controls> {
        self.controls.as_ref()
    }

    /// The images and what is known of them.
    pub fn images(&self) -> Result<&Images> {
        self.method.images().ok_or_else(|| {
            let reason = format!("no file of kind `{}` came; bake it again", Kind::TransferImages.name());
            FormatError::invalid(&Place::file(relume_formats::kinds::manifest::FILE_NAME), reason).into()
        })
    }

    /// Renders the frame at `time_s` with what has arrived, and waits for it.
    pub fn render(&mut self, time_s: f64) -> Result<Frame> {
        let Some(controls) = &self.controls else { return Err(Error::Failed("nothing has arrived that could be rendered".to_owned())) };
        let look = controls.look_at(time_s)?;
        let cost = self.sum(&look)?;
        Ok(Frame { radiance: self.read_film()?, exposure_ev: look.exposure_ev, cost })
    }

    /// Fills the film for `look` with what has arrived. Waits for it only where the GPU tells its time.
    pub fn sum(&self, look: &Look) -> Result<Cost> {
        let started = Instant::now();
        self.submit_pass(look)?;
        let cpu_ms = started.elapsed().as_secs_f64() * 1e3;
        let gpu_ms = self.timer.as_ref().map(|timer| timer.read_ms(&self.gpu)).transpose()?;
        Ok(Cost { cpu_ms, gpu_ms })
    }

    fn submit_pass(&self, look: &Look) -> Result<()> {
        self.method.update(&self.gpu, &look.materials)?;
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        self.method.encode(&mut encoder, self.timer.as_ref().map(Timer::writes));
        if let Some(timer) = &self.timer {
            timer.encode(&mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The film as it is: linear radiance, row by row, W/(sr·m²).
    pub fn read_film(&mut self) -> Result<Vec<Rgb>> {
        let readback = match self.readback.take() {
            Some(readback) => readback,
            None => Readback::new(&self.gpu, self.images()?.film()),
        };
        let film = self.images()?.film();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read-back") });
        readback.encode(&mut encoder, film);
        self.gpu.queue.submit([encoder.finish()]);
        let mut radiance = Vec::new();
        readback.read(&self.gpu, |bytes| {
            radiance.extend(bytes.as_chunks::<16>().0.iter().map(|pixel| {
                let [r, g, b, _] = bytemuck::cast::<[u8; 16], [f32; 4]>(*pixel);
                [r, g, b]
            }));
        })?;
        self.readback = Some(readback);
        Ok(radiance)
    }

    /// Name of the method that plays.
    pub fn method_name(&self) -> &str {
        &self.method_name
    }

    /// What the adapter says of itself.
    pub fn adapter(&self) -> &wgpu::AdapterInfo {
        &self.gpu.info
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
