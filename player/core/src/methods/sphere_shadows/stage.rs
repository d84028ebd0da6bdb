//! A bake at play: light, receivers, picture, and which of them has to be computed again.

use super::blockers::Blockers;
#[cfg(feature = "cpu")]
use super::on_cpu::OnCpu;
use super::receivers::Receivers;
use super::shading::Shading;
use crate::controls::Look;
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use crate::lit::{Light, Map, Picture};
use relume_formats::kinds::Environment;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::shape::Pose;
use relume_formats::state::Rgb;

/// Everything that it takes to draw a frame.
pub(super) struct Stage {
    pub(super) light: Light,
    pub(super) receivers: Receivers,
    pub(super) picture: Picture,
    /// By vertex: W/(sr·m²) before the light's gain, four floats of which the last is unused.
    pub(super) radiance: wgpu::Buffer,
    /// What computes radiance on the GPU, unless the CPU does.
    pub(super) on_gpu: Option<(Blockers, Box<Shading>)>,
    /// What computes it on the CPU, if that does.
    #[cfg(feature = "cpu")]
    pub(super) on_cpu: Option<OnCpu>,
    pub(super) changed: Changed,
    /// What shines.
    pub(super) environment: Option<EnvironmentLook>,
}

/// What the next frame has to compute again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Changed {
    /// Map or rotation.
    pub(super) light: bool,
    /// Or the gain, which decides too what is kept of the light.
    pub(super) terms: bool,
    /// Where receivers and spheres are.
    pub(super) shapes: bool,
}

impl Stage {
    /// Sets how things look.
    ///
    /// # Errors
    /// If a mesh would reach beyond what numbers hold.
    pub(super) fn update(&mut self, gpu: &Gpu, look: &Look) -> Result<()> {
        self.set_light(gpu, look.environment.as_ref());
        let moved = self.receivers.pose(&look.shapes)?;
        if !moved.is_empty() {
            self.changed.shapes = true;
            self.picture.vertices_move();
            self.upload(gpu, &moved);
        }
        self.picture.set(gpu, &look.camera, self.gain());
        #[cfg(feature = "cpu")]
        self.compute_on_cpu(gpu);
        Ok(())
    }

    /// Adds an environment map, or puts it in the place of the one that has its name.
    pub(super) fn add_map(&mut self, gpu: &Gpu, map: &Environment) {
        let index = self.light.add(gpu, Map::new(gpu, map));
        self.picture.set_map(gpu, index, &self.light);
        #[cfg(feature = "cpu")]
        if let Some(on_cpu) = &mut self.on_cpu {
            on_cpu.add_map(map.clone());
        }
        // What shines may have been exchanged under its name.
        self.environment = None;
    }

    fn set_light(&mut self, gpu: &Gpu, environment: Option<&EnvironmentLook>) {
        let Some(environment) =
            environment.filter(|environment| self.environment.as_ref() != Some(environment))
        else {
            return;
        };
        if self.light.set(gpu, environment) {
            self.picture.set_suns(gpu, &self.light);
            self.changed.light = true;
        }
        self.changed.terms = true;
        if let Some((_, shading)) = &self.on_gpu {
            shading.set_gain(gpu, environment.gain);
        }
        self.environment = Some(environment.clone());
    }

    /// Uploads what the next frame needs of shapes that `moved`.
    fn upload(&self, gpu: &Gpu, moved: &[(usize, Pose)]) {
        if let Some((blockers, _)) = &self.on_gpu {
            blockers.upload_spheres(gpu, &self.receivers);
            moved.iter().for_each(|(shape, pose)| blockers.set_pose(gpu, *shape, pose));
        } else {
            moved.iter().for_each(|(shape, _)| self.upload_vertices(gpu, *shape));
        }
    }

    /// Uploads vertices that the CPU has brought to their pose where they are drawn.
    fn upload_vertices(&self, gpu: &Gpu, shape: usize) {
        let Some(range) = self.receivers.moving().get(shape).map(|moving| moving.vertices.clone()) else {
            return;
        };
        let begin = (range.start * size_of::<[f32; 3]>()) as u64;
        let now = &self.receivers.now()[range.clone()];
        let normals: Vec<[f32; 3]> = now.iter().map(|receiver| receiver.normal.to_array()).collect();
        let write = |buffer, values| gpu.queue.write_buffer(buffer, begin, bytemuck::cast_slice(values));
        write(self.picture.positions(), &self.receivers.positions()[range]);
        write(self.picture.normals(), &normals);
    }

    fn gain(&self) -> Rgb {
        self.environment.as_ref().map_or([1.0; 3], |environment| environment.gain)
    }

    #[cfg(feature = "cpu")]
    fn compute_on_cpu(&mut self, gpu: &Gpu) {
        let (Some(on_cpu), Some(environment)) = (&mut self.on_cpu, &self.environment) else { return };
        if self.changed.terms {
            on_cpu.set_light(environment);
        }
        if self.changed.terms || self.changed.shapes {
            on_cpu.shade(gpu, &mut self.receivers, &self.radiance);
        }
        self.changed = Changed { light: false, terms: false, shapes: false };
    }

    /// Encodes a frame, and of what comes before the picture no more than has changed.
    pub(super) fn encode(&mut self, passes: &mut Passes<'_>) {
        if let Some((blockers, shading)) = &self.on_gpu {
            if self.changed.light {
                self.light.encode(passes);
            }
            if self.changed.shapes {
                blockers.encode(passes);
            }
            if self.changed.terms {
                shading.encode_fold(passes);
            }
            if self.changed.terms || self.changed.shapes {
                shading.encode(passes);
            }
        }
        self.picture.encode(self.light.map(), passes);
        self.changed = Changed { light: false, terms: false, shapes: false };
    }

    /// Radiance by vertex, and the gain.
    pub(super) fn vertex_radiance(&self) -> (&wgpu::Buffer, Rgb) {
        (&self.radiance, self.gain())
    }

    /// Bytes that a frame reads of bitmaps and weights.
    pub(super) fn bytes_per_frame(&self) -> u64 {
        self.on_gpu.as_ref().map_or(0, |(blockers, shading)| blockers.bytes() + shading.bytes())
    }

    /// The film.
    pub(super) fn film(&self) -> &Film {
        self.picture.film()
    }
}
