//! The paths of the method `transfer-images`: at most two reflections, with what each reflection needs to know left open.
//!
//! A path does not depend on the materials that vary: directions at these come from a fixed mixture of lobes. So one set of paths serves every
//! basis, every state and the reference alike, and noise is the same in all of them.

use super::lights::{LightSample, Lights};
use super::sampler::{PixelSampler, Sample};
use super::world::{Owner, Surface, World};
use crate::brdf::blinn_phong::cos_half_angle;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::state::Film;
use relume_scenes::Scene;

/// One path from the eye.
#[derive(Debug, Clone, Copy)]
pub enum GatherPath {
    /// The eye sees a light or the background: its radiance.
    Light(Vec3A),
    /// The eye sees a surface.
    Surface(EyeVertex),
}

/// The surface that the eye sees.
#[derive(Debug, Clone, Copy)]
pub struct EyeVertex {
    /// Index of its material.
    pub material: u32,
    /// Light that arrives directly.
    pub direct: Option<Reflection>,
    /// Light that arrives by way of another surface.
    pub indirect: Option<FirstVertex>,
}

/// Light about to be reflected: times the BRDF at this half angle it is radiance.
#[derive(Debug, Clone, Copy)]
pub struct Reflection {
    /// cos δ between half vector and shading normal.
    pub cos_delta: f32,
    /// Radiance · cosine / density.
    pub light: Vec3A,
}

/// The surface before the one that the eye sees.
#[derive(Debug, Clone, Copy)]
pub struct FirstVertex {
    /// Index of its material.
    pub material: u32,
    /// cos δ at the surface that the eye sees.
    pub eye_cos_delta: f32,
    /// Light that this surface reflects towards the one that the eye sees, times cosine / density there.
    pub reflection: Reflection,
}

/// Everything that traces the paths of one scene.
pub struct Gather<'a> {
    /// The scene's surfaces.
    pub world: &'a World,
    /// The scene's lights.
    pub lights: &'a Lights,
    film: Film,
    width: u32,
    mixtures: Vec<LobeMixture>,
    indirect: bool,
    seed: u64,
}

impl<'a> Gather<'a> {
    /// Prepares the paths of `scene` for a film of `size` pixels.
    pub fn new(scene: &Scene, world: &'a World, lights: &'a Lights, size: [u32; 2], reflections: u32, seed: u64) -> Self {
        let mixture = |(index, material): (usize, &relume_scenes::Material)| {
            if scene.vary.materials.contains(&index) { LobeMixture::for_any_material() } else { LobeMixture::for_material(&material.brdf) }
        };
        let mixtures = scene.materials.iter().enumerate().map(mixture).collect();
        Self { world, lights, film: scene.camera.film(size[0], size[1]), width: size[0], mixtures, indirect: reflections >= 2, seed }
    }

    /// Traces the first `samples` paths of pixel number `pixel`, in order.
    pub fn pixel(&self, pixel: u32, samples: u32, mut each: impl FnMut(&GatherPath)) {
        let sampler = PixelSampler::new(self.seed, pixel);
        let (x, y) = ((pixel % self.width) as f32, (pixel / self.width) as f32);
        for index in 0..samples {
            let sample = sampler.sample(index);
            let [dx, dy] = sample.pair(0);
            each(&self.path(self.film.direction(x + dx, y + dy), &sample));
        }
    }

    fn path(&self, direction: Vec3A, sample: &Sample) -> GatherPath {
        let Some(surface) = self.world.intersect(self.film.eye_in_world, direction) else {
            return GatherPath::Light(self.lights.background(direction));
        };
        match surface.owner {
            Owner::Light(index) => GatherPath::Light(if surface.front { self.lights.emitted(index) } else { Vec3A::ZERO }),
            Owner::Material(material) => {
                let choices = sample.pair(1);
                let direct = self.direct(&surface, choices[0], sample.pair(2));
                let indirect = if self.indirect { self.bounce(&surface, material, choices[1], sample) } else { None };
                GatherPath::Surface(EyeVertex { material, direct, indirect })
            }
        }
    }

    fn direct(&self, surface: &Surface, choice: f32, point: [f32; 2]) -> Option<Reflection> {
        let LightSample { direction, weight, .. } = self.lights.sample_visible(self.world, surface, choice, point)?;
        let cos_delta = cos_half_angle(direction, surface.outgoing, surface.shading_normal);
        Some(Reflection { cos_delta, light: weight * direction.dot(surface.shading_normal) })
    }

    fn bounce(&self, surface: &Surface, material: u32, choice: f32, sample: &Sample) -> Option<FirstVertex> {
        let normal = surface.shading_normal;
        let (direction, density) = self.mixtures[material as usize].sample(normal, surface.outgoing, choice, sample.pair(3));
        let cosine = direction.dot(normal);
        if cosine <= 0.0 || direction.dot(surface.geometric_normal) <= 0.0 {
            return None;
        }
        let first = self.world.intersect(surface.offset(), direction)?;
        let Owner::Material(material) = first.owner else {
            // Light seen directly from the surface is what `direct` samples.
            return None;
        };
        let mut reflection = self.direct(&first, sample.pair(4)[0], sample.pair(5))?;
        reflection.light *= cosine / density;
        let eye_cos_delta = cos_half_angle(direction, surface.outgoing, normal);
        Some(FirstVertex { material, eye_cos_delta, reflection })
    }
}
