//! Method `sphere-shadows` on the GPU: every vertex of the scene receives the light that spheres and triangles of
//! its objects leave it, and the meshes are drawn with it.
//!
//! The CPU tells where joints are, and lets spheres follow ([`receivers`]). Then come passes: vertices and normals
//! of shapes brought to their pose ([`poses`]), what triangles and spheres block in the bitmaps of all receivers
//! ([`blockers`]), the light's terms folded into the lobes, and the radiance that both give ([`shading`]). What a
//! frame costs depends on what has changed: a shape asks for poses, bitmaps and radiance, the light for folding and
//! radiance, the camera for neither. With the adapter `cpu` poses and radiance are computed on the CPU
//! ([`on_cpu`]).

mod blockers;
mod gpu_data;
#[cfg(feature = "cpu")]
mod on_cpu;
mod poses;
mod receivers;
mod shading;
mod stage;

use super::{Method, Pieces, Playback, Setup};
use crate::controls::Look;
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use crate::lit::{Surface, Surroundings, belongs};
use crate::stream::{Arrival, decode_all};
use receivers::{Receivers, Sets, Shapes};
use relume_formats::Place;
use relume_formats::basis::two_level::SIDE;
use relume_formats::bundle::{Objects, expect_receivers};
use relume_formats::container::{Kind, Section};
use relume_formats::evaluate::sphere_shadows::{Detail, lobe};
use relume_formats::kinds::{Environment, SphereShadows as Bake};
use relume_formats::state::Rgb;
use stage::{Changed, Stage};
use wgpu::BufferUsages;

/// The method's line in the registry.
pub const METHOD: Method = Method {
    card: &relume_formats::method::SPHERE_SHADOWS,
    on_cpu: cfg!(feature = "cpu"),
    resizes: true,
    start: |gpu, setup| Ok(Box::new(SphereShadows::new(gpu, setup)?)),
};

const POSE: &str = include_str!("pose.wgsl");
const TURN: &str = include_str!("turn.wgsl");
const PLACE: &str = include_str!("place.wgsl");
const CAPS: &str = include_str!("caps.wgsl");
const TERMS: &str = include_str!("terms.wgsl");
const FOLD: &str = include_str!("fold.wgsl");
const SHADE: &str = include_str!("shade.wgsl");

/// What has arrived of a bake, on its way to and on the GPU.
struct SphereShadows {
    /// What waits for the main file.
    waiting: Option<Waiting>,
    /// Sections of the file that is arriving.
    pending: Vec<Section>,
    /// Names of the maps, as soon as the main file comes.
    maps: Option<Vec<String>>,
    stage: Option<Stage>,
}

/// Everything that comes before the main file.
struct Waiting {
    surroundings: Surroundings,
    objects: Objects,
    sets: Sets,
    shapes: Shapes,
}

impl SphereShadows {
    fn new(gpu: &Gpu, setup: Setup) -> Result<Self> {
        let surroundings = Surroundings::new(gpu, setup, gpu.radiance_on_cpu)?;
        let objects = Objects::new(&surroundings.scene);
        let waiting = Waiting { surroundings, objects, sets: Sets::new(), shapes: Shapes::new() };
        Ok(Self { waiting: Some(waiting), pending: Vec::new(), maps: None, stage: None })
    }

    fn file_arrived(
        &mut self,
        gpu: &Gpu,
        kind: Kind,
        object: Option<String>,
        place: &Place,
        sections: Vec<Section>,
    ) -> Result<()> {
        let Some(waiting) = &mut self.waiting else { return Ok(()) };
        match (kind, object) {
            (Kind::SphereSet, Some(object)) => {
                let set = decode_all(sections)?;
                waiting.objects.add_set(&set, &object, &waiting.surroundings.scene, place)?;
                waiting.surroundings.settings.expect_set(&set, &object)?;
                waiting.sets.insert(object, set);
            }
            (Kind::Shape, _) => {
                // Shapes come in the order of the scene's.
                let mesh = decode_all(sections)?;
                let shape = waiting.surroundings.scene.meta.shapes.get(waiting.shapes.len());
                let Some(shape) = shape else {
                    return Err(relume_formats::Error::invalid(
                        place,
                        "is a shape of no object; bake the whole bundle again",
                    )
                    .into());
                };
                waiting.objects.expect_shape(&mesh, shape, &waiting.surroundings.scene, place)?;
                waiting.shapes.insert(shape.object.clone(), mesh);
            }
            _ => {
                let bake: Bake = decode_all(sections)?;
                waiting.surroundings.expect_bake("lobes", bake.meta.vertices(), place)?;
                expect_receivers(&bake, &waiting.surroundings.scene, &waiting.objects, place)?;
                waiting
                    .surroundings
                    .settings
                    .expect_objects(&waiting.surroundings.scene.meta, &waiting.objects)?;
                self.maps = Some(waiting.surroundings.map_names());
                if let Some(waiting) = self.waiting.take() {
                    self.stage = Some(waiting.set_up(gpu, &bake, place)?);
                }
            }
        }
        Ok(())
    }
}

impl Waiting {
    fn set_up(mut self, gpu: &Gpu, bake: &Bake, place: &Place) -> Result<Stage> {
        let detail = Detail::of(&bake.meta);
        let (scene, on_cpu) = (&self.surroundings.scene, gpu.radiance_on_cpu);
        let receivers = Receivers::new(scene, bake, self.sets, self.shapes, on_cpu, place)?;
        let lobes: Vec<_> =
            (0..bake.normals.len()).map(|row| lobe(bake.lobe(row).to_vec(), detail.terms)).collect();
        let light = self.surroundings.light(gpu, SIDE as u32, false);
        let usage =
            BufferUsages::STORAGE | BufferUsages::VERTEX | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let radiance = gpu.buffer("radiance", (receivers.now().len() * size_of::<[f32; 4]>()) as u64, usage);
        let picture = self.surroundings.picture(gpu, Surface::diffuse(&radiance), &light);
        let on_gpu = || -> Result<_> {
            let placed = [picture.positions(), picture.normals()];
            let blockers = blockers::Blockers::new(gpu, &receivers, placed, place)?;
            let shading =
                shading::Shading::new(gpu, detail, &lobes, light.coefficients(), &blockers, &radiance);
            Ok((blockers, Box::new(shading)))
        };
        let on_gpu = if gpu.radiance_on_cpu { None } else { Some(on_gpu()?) };
        #[cfg(feature = "cpu")]
        let on_cpu = gpu
            .radiance_on_cpu
            .then(|| on_cpu::OnCpu::new(self.surroundings.take_environments(), lobes, detail, &receivers));
        let changed = Changed { light: false, terms: false, shapes: true };
        Ok(Stage {
            light,
            receivers,
            picture,
            radiance,
            on_gpu,
            #[cfg(feature = "cpu")]
            on_cpu,
            changed,
            environment: None,
        })
    }
}

impl Playback for SphereShadows {
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        match &mut self.waiting {
            Some(waiting) if belongs(arrival.kind) => waiting.surroundings.section_arrived(gpu, arrival),
            Some(_) if matches!(arrival.kind, Kind::SphereSet | Kind::Shape | Kind::SphereShadows) => {
                let Arrival { kind, name: object, section, last } = arrival;
                let place = section.place.clone();
                self.pending.push(section);
                if !last {
                    return Ok(());
                }
                let sections = std::mem::take(&mut self.pending);
                self.file_arrived(gpu, kind, object, &place, sections)
            }
            _ => Err(METHOD.has_no_use_for(&arrival)),
        }
    }

    fn maps(&self) -> Option<Vec<String>> {
        self.maps.clone()
    }

    fn add_map(&mut self, gpu: &Gpu, map: &Environment) {
        if let Some(stage) = &mut self.stage {
            stage.add_map(gpu, map);
        }
    }

    fn pieces(&self) -> Pieces {
        let missing = if self.stage.is_some() { Vec::new() } else { vec![0] };
        let bytes_per_frame = self.stage.as_ref().map_or(0, Stage::bytes_per_frame);
        Pieces { what: "files of lobes", expected: 1, missing, bytes_per_frame }
    }

    fn film(&self) -> Option<&Film> {
        self.stage.as_ref().map(Stage::film)
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()> {
        match (&mut self.stage, &mut self.waiting) {
            (Some(stage), _) => stage.picture.resize(gpu, size),
            (None, Some(waiting)) => waiting.surroundings.resize(gpu, size),
            (None, None) => Ok(()),
        }
    }

    fn moving_vertices(&self) -> Option<Vec<[f32; 3]>> {
        self.stage.as_ref()?.receivers.moving_positions()
    }

    fn update(&mut self, gpu: &Gpu, look: &Look) -> Result<()> {
        self.stage.as_mut().map_or(Ok(()), |stage| stage.update(gpu, look))
    }

    fn encode(&mut self, passes: &mut Passes<'_>) {
        if let Some(stage) = &mut self.stage {
            stage.encode(passes);
        }
    }

    fn vertex_radiance(&self) -> Option<(&wgpu::Buffer, Rgb)> {
        self.stage.as_ref().map(Stage::vertex_radiance)
    }
}

#[cfg(test)]
mod tests;
