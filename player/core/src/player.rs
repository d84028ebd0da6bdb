//! A bundle being played: what has arrived, what is set, and the frames that follow.

mod outside;
mod size;
#[cfg(test)]
mod tests;

pub use outside::{FindMap, NOT_MEASURED};

use crate::controls::{Controls, Look, PlacedAnimation, PlacedState, Scope};
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu, PassTimes, Passes, Timer, Tonemap};
use crate::materials::MaterialMap;
use crate::methods::{Method, Pieces, Playback, Setup};
use crate::stream::{Arrival, Event, Playlist, Source, decode_all};
use crate::surfaces::Surfaces;
use outside::{Outside, Stage};
use relume_formats::bundle::{Settings, expect_name, expect_playable, sets_only};
use relume_formats::container::{Kind, Section};
use relume_formats::display::Display;
use relume_formats::kinds::{Environment, StoredScene, scene};
use relume_formats::state::{Animation, Rgb};
use relume_formats::{Error as FormatError, Place};
use wgpu::{CommandEncoder, TextureView};

/// How a bundle is to be played.
#[derive(Debug, Default)]
pub struct Options {
    /// State to start from.
    pub state: PlacedState,
    /// An animation of the caller's own to play.
    pub animation: Option<PlacedAnimation>,
    /// An environment map that is not the bundle's, to shine from the start.
    pub environment: Option<Environment>,
    /// Finds maps that state or animation name and the bundle does not have.
    pub find_map: Option<FindMap>,
    /// Size of the film in pixels, or the scene's.
    pub size: Option<[u32; 2]>,
    /// Whether the CPU is to do the method's sums, on all its cores, and the device only draws; for methods
    /// that say so.
    pub radiance_on_cpu: bool,
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

/// The radiance that a white diffuse surface would show at every vertex of the scene, W/(sr·m²).
#[derive(Debug)]
pub struct VertexRadiance<'a> {
    /// By vertex four floats, of which the last is unused; as of the frame submitted last.
    pub buffer: &'a wgpu::Buffer,
    /// What they are to be multiplied with.
    pub gain: Rgb,
}

/// A bundle being played on a device of the caller's.
pub struct Player {
    gpu: Gpu,
    /// Where the manifest is.
    place: Place,
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
    outside: Outside,
    /// The animations so far; with one to play, that comes first.
    animations: Vec<PlacedAnimation>,
    /// How many there will be.
    animations_expected: usize,
    plays_first: bool,
    controls: Option<Controls>,
    timer: Option<Timer>,
    frames: u64,
    tonemap: Option<Tonemap>,
}

impl Player {
    /// Plays the files of `playlist`, of which none has arrived, on `device`, whose queue is `queue`.
    ///
    /// # Errors
    /// If the device was opened with lower limits than every WebGPU device has, or the CPU is to do sums that
    /// the method leaves to the device.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        playlist: &Playlist,
        options: Options,
    ) -> Result<Self> {
        let Options { state, animation, environment, find_map, size, radiance_on_cpu } = options;
        if radiance_on_cpu && !playlist.method.on_cpu {
            return Err(Error::Request(format!(
                "the CPU cannot do the sums of method {}",
                playlist.method.card.name
            )));
        }
        let gpu = Gpu::new(device, queue, radiance_on_cpu)?;
        let plays_first = animation.is_some() || playlist.plays_first;
        let animations: Vec<_> = animation.into_iter().collect();
        Ok(Self {
            timer: Timer::new(&gpu),
            gpu,
            place: playlist.place.clone(),
            method: playlist.method,
            known: playlist.known.clone(),
            settings: playlist.settings.clone(),
            size,
            playback: None,
            pending: Vec::new(),
            scene: None,
            surfaces: Surfaces::default(),
            state,
            outside: Outside::new(find_map, environment),
            animations_expected: animations.len() + playlist.animations(),
            animations,
            plays_first,
            controls: None,
            frames: 0,
            tonemap: None,
        })
    }

    /// Takes in the next section from `source`, if there is one. Never waits for it.
    ///
    /// # Errors
    /// If the section is malformed or does not fit those before it, if state or animation cannot be played,
    /// and at the end if anything is missing.
    pub fn advance(&mut self, source: &mut impl Source) -> Result<Progress> {
        match source.poll()? {
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
                    self.playback = Some((self.method.start)(
                        &self.gpu,
                        Setup { scene, settings: self.settings.clone(), size: self.size },
                    )?);
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
                let Some(playback) = &mut self.playback else {
                    return Err(self.invalid("comes before the scene"));
                };
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
            let mut animation = if self.plays_first { animations.next() } else { None };
            let mut scope = Scope { scene, card: self.method.card, maps };
            if let Some(playback) = self.playback.as_deref_mut() {
                let mut stage = Stage { gpu: &self.gpu, playback, scope: &mut scope };
                self.outside.adopt(&mut stage, (&mut self.state.state, &self.state.place), &mut animation)?;
            }
            self.expect_some_method_plays(animation.iter().chain(animations.as_slice()), &scope)?;
            self.controls = Some(Controls::new(scope, &self.state, animation, animations.collect())?);
        }
        Ok(())
    }

    /// Fails if no method of the bundle can play an animation. One that another method plays is no fault.
    fn expect_some_method_plays<'a>(
        &self,
        mut animations: impl Iterator<Item = &'a PlacedAnimation>,
        scope: &Scope,
    ) -> Result<()> {
        let is_played = |placed: &PlacedAnimation| {
            self.known.iter().any(|method| sets_only(&placed.animation, &scope.scene.varies(method.card)))
        };
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
        FormatError::invalid(&self.place, format!("{reason}; bake it again")).into()
    }

    /// Encodes a frame of `look`, with what has arrived, onto the film, and of what comes before the picture
    /// no more than has changed. Returns its number.
    ///
    /// Small uploads go to the queue at once and count for what is submitted next: submit `encoder` before
    /// drawing again.
    ///
    /// # Errors
    /// If nothing has arrived that could be drawn, or a shape would reach beyond what numbers hold.
    pub fn draw(&mut self, encoder: &mut CommandEncoder, look: &Look) -> Result<u64> {
        let Some(playback) = &mut self.playback else { return Err(Error::NothingThere) };
        playback.update(&self.gpu, look)?;
        self.outside.drawn(look.environment.as_ref().map(|environment| &environment.map));
        let frame = self.frames;
        self.frames += 1;
        let mut passes = Passes::new(encoder, self.timer.as_mut(), frame);
        playback.encode(&mut passes);
        passes.finish();
        Ok(frame)
    }

    /// Encodes what fills `target` with the film as `display` shows it. The target is of the film's size, and
    /// may be drawn on. 8-bit formats receive what a PNG would hold, of curves that the device reckons in its
    /// own way to a step; others, and those that encode what they are given, linear values from 0 to 1.
    ///
    /// # Errors
    /// If nothing has arrived yet, or the target is of another size.
    pub fn show(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        display: Display,
    ) -> Result<()> {
        let Some(film) = self.playback.as_ref().and_then(|playback| playback.film()) else {
            return Err(Error::NothingThere);
        };
        let texture = target.texture();
        let (size, [width, height]) = ([texture.width(), texture.height()], film.size);
        if size != film.size {
            return Err(Error::Request(format!(
                "the target has {}x{} pixels, the film {width}x{height}",
                size[0], size[1]
            )));
        }
        let format = texture.format();
        if self.tonemap.as_ref().is_none_or(|tonemap| tonemap.format() != format) {
            self.tonemap = Some(Tonemap::new(&self.gpu, film, format));
        }
        if let Some(tonemap) = &self.tonemap {
            tonemap.encode(&self.gpu, encoder, target, display);
        }
        Ok(())
    }

    /// What the GPU took for frames, as far as that has become known since the last call: for most of them, a
    /// few frames later, if the device has timestamps.
    pub fn times(&mut self) -> Vec<PassTimes> {
        self.timer.as_mut().map(Timer::times).unwrap_or_default()
    }

    /// Whether the device tells what frames take.
    pub fn is_timed(&self) -> bool {
        self.timer.is_some()
    }

    /// Whether a frame can be drawn, if only a coarse one.
    pub fn is_ready(&self) -> bool {
        self.controls.is_some() && self.pieces().arrived() > 0
    }

    /// How much has arrived of what the method sums up.
    pub fn pieces(&self) -> Pieces {
        self.playback.as_ref().map_or_else(Pieces::default, |playback| playback.pieces())
    }

    /// The controls, once everything is there that decides what may be set.
    pub fn controls(&self) -> Option<&Controls> {
        self.controls.as_ref()
    }

    /// The controls, to start from something else.
    pub fn controls_mut(&mut self) -> Option<&mut Controls> {
        self.controls.as_mut()
    }

    /// The film, once its size is known.
    pub fn film(&self) -> Option<&Film> {
        self.playback.as_ref()?.film()
    }

    /// The material that every pixel shows, where the view is fixed.
    pub fn materials(&self) -> Option<MaterialMap> {
        self.playback.as_ref()?.materials()
    }

    /// Hands out the surfaces of the scene at rest; none where the view is fixed.
    pub fn take_surfaces(&mut self) -> Surfaces {
        std::mem::take(&mut self.surfaces)
    }

    /// Where the vertices of the scene are in the last frame, metres in world space, if they move at all.
    pub fn moving_vertices(&self) -> Option<Vec<[f32; 3]>> {
        self.playback.as_ref()?.moving_vertices()
    }

    /// The radiance by vertex, if the method knows of any and its files are there.
    pub fn vertex_radiance(&self) -> Option<VertexRadiance<'_>> {
        let (buffer, gain) = self.playback.as_ref()?.vertex_radiance()?;
        Some(VertexRadiance { buffer, gain })
    }

    /// The method that plays.
    pub fn method(&self) -> &Method {
        &self.method
    }
}
