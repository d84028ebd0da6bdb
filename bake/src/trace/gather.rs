//! The paths of the method `transfer-images`: two reflections, with what each reflection needs to know left
//! open, and, where all are asked for, the later ones ([`super::later`]).
//!
//! A path does not depend on the materials that vary: directions at these come from a fixed mixture of lobes.
//! So one set of paths serves every basis, every state and the reference alike, and noise is the same in all
//! of them.

use super::later::LaterVertex;
use super::lights::{LightSample, Lights};
use super::sampler::{PixelSampler, Sample};
use super::world::{Owner, Surface, World};
use crate::brdf::angles;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::state::{Brdf, Film};
use relume_scenes::{ALL_REFLECTIONS, Scene};

/// Most reflections of a path, unless it is to have all.
pub const MAX_REFLECTIONS: u32 = 2;

/// One path from the eye.
#[allow(
    clippy::large_enum_variant,
    reason = "lives on the stack for one sample; a box would allocate for every path"
)]
#[derive(Debug, Clone)]
pub enum GatherPath {
    /// The eye sees a light or the background: its radiance.
    Light(Vec3A),
    /// The eye sees a surface.
    Surface(EyeVertex),
}

impl GatherPath {
    /// True if what the eye sees emits light itself, whatever its materials.
    pub fn shows_light(&self) -> bool {
        match self {
            Self::Light(_) => true,
            Self::Surface(eye) => eye.emitted != Vec3A::ZERO,
        }
    }
}

/// The surface that the eye sees.
#[derive(Debug, Clone)]
pub struct EyeVertex {
    /// Index of its material.
    pub material: u32,
    /// What its texture multiplies the diffuse colour with.
    pub albedo: Vec3A,
    /// World space.
    pub position: Vec3A,
    /// Unit shading normal, world space.
    pub normal: Vec3A,
    /// Radiance that it emits itself.
    pub emitted: Vec3A,
    /// Light that arrives directly.
    pub direct: Reflections,
    /// Light that arrives by way of another surface.
    pub indirect: Option<FirstVertex>,
}

impl EyeVertex {
    /// Light that it reflects to the eye, and that was reflected nowhere else, or once more. `brdf` gives the
    /// BRDF of a material, by its index, where its texture has a certain colour, at some angles.
    pub fn early_light(&self, brdf: impl Fn(u32, Vec3A, &Angles) -> Vec3A) -> [Vec3A; 2] {
        let reflected = |material: u32, albedo: Vec3A, reflections: &Reflections| -> Vec3A {
            reflections.iter().flatten().map(|r| r.light * brdf(material, albedo, &r.angles)).sum()
        };
        let direct = reflected(self.material, self.albedo, &self.direct);
        let indirect = self.indirect.as_ref().map_or(Vec3A::ZERO, |first| {
            let light = reflected(first.material, first.albedo, &first.reflections);
            light * brdf(self.material, self.albedo, &first.eye_angles)
        });
        [direct, indirect]
    }

    /// Light that it reflects to the eye, and that was reflected twice or more before: there by `before`.
    pub fn later_light(
        &self,
        brdf: impl Fn(u32, Vec3A, &Angles) -> Vec3A,
        before: impl Fn(u32, Vec3A, &Angles) -> Vec3A,
    ) -> Vec3A {
        let first = self.indirect.as_ref().filter(|first| !first.later.is_empty());
        first.map_or(Vec3A::ZERO, |first| {
            first.later_light(before) * brdf(self.material, self.albedo, &first.eye_angles)
        })
    }
}

/// Light that arrives at a surface, found in two ways: by choosing a point on a light, and by following the
/// surface's lobes. Both carry the balance heuristic's weights (Veach 1997), so their sum is the estimate.
pub type Reflections = [Option<Reflection>; 2];

/// Light about to be reflected: times the BRDF at these angles it is radiance.
#[derive(Debug, Clone, Copy)]
pub struct Reflection {
    /// Between the directions and the shading normal.
    pub angles: Angles,
    /// Radiance · cosine / density.
    pub light: Vec3A,
}

/// The surface before the one that the eye sees.
#[derive(Debug, Clone)]
pub struct FirstVertex {
    /// Index of its material.
    pub material: u32,
    /// What its texture multiplies the diffuse colour with.
    pub albedo: Vec3A,
    /// At the surface that the eye sees.
    pub eye_angles: Angles,
    /// Light that this surface reflects towards the one that the eye sees, times cosine / density there.
    pub reflections: Reflections,
    /// Cosine / density at the surface that the eye sees.
    pub weight: f32,
    /// The surfaces before this one, the next one first; none unless all reflections are asked for.
    pub later: Vec<LaterVertex>,
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
    /// For each material: what it is, if it does not vary.
    pub(super) fixed: Vec<Option<Brdf>>,
    indirect: bool,
    /// For each material: where its later reflections are looked for, if they are at all.
    later: Option<Vec<LobeMixture>>,
    seed: u64,
}

impl<'a> Gather<'a> {
    /// Prepares the paths of `scene` for a film of `size` pixels.
    pub fn new(
        scene: &Scene,
        world: &'a World,
        lights: &'a Lights,
        size: [u32; 2],
        reflections: u32,
        seed: u64,
    ) -> Self {
        let of = |(index, material): (usize, &relume_scenes::Material)| {
            (!scene.vary.materials.contains(&index)).then_some(material.brdf)
        };
        let fixed: Vec<Option<Brdf>> = scene.materials.iter().enumerate().map(of).collect();
        let mixtures_by = |varying: fn() -> LobeMixture| -> Vec<LobeMixture> {
            fixed.iter().map(|fixed| fixed.as_ref().map_or_else(varying, LobeMixture::for_material)).collect()
        };
        let (mixtures, later) =
            (mixtures_by(LobeMixture::for_any_material), mixtures_by(LobeMixture::cosine));
        Self {
            world,
            lights,
            film: scene.camera.film(size[0], size[1]),
            width: size[0],
            mixtures,
            fixed,
            indirect: reflections >= 2,
            later: (reflections == ALL_REFLECTIONS).then_some(later),
            seed,
        }
    }

    /// The same but for third and later reflections, which bakes look for as matt surfaces reflect; these
    /// find the highlights of materials that vary, too.
    #[must_use]
    pub fn with_later_highlights(&self) -> Self {
        let (mixtures, later) = (self.mixtures.clone(), self.later.as_ref().map(|_| self.mixtures.clone()));
        Self { mixtures, later, film: self.film, fixed: self.fixed.clone(), ..*self }
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
            Owner::Light(_) => GatherPath::Light(self.lights.emitted(&surface)),
            Owner::Material(material) => GatherPath::Surface(self.eye_vertex(&surface, material, sample)),
        }
    }

    fn eye_vertex(&self, surface: &Surface, material: u32, sample: &Sample) -> EyeVertex {
        let choices = sample.pair(1);
        let mixture = &self.mixtures[material as usize];
        let bounce = Bounce::sample(surface, mixture, choices[1], sample.pair(3));
        let hit = bounce.and_then(|b| self.world.intersect(surface.offset(), b.direction));
        let seen = bounce.and_then(|b| self.light_seen(surface, &b, hit.as_ref()));
        let direct = [self.light_sampled(surface, mixture, choices[0], sample.pair(2)), seen];
        let indirect = match (bounce, hit) {
            (Some(bounce), Some(first)) if self.indirect => self.first_vertex(&bounce, &first, sample),
            _ => None,
        };
        EyeVertex {
            material,
            albedo: surface.albedo,
            position: surface.position,
            normal: surface.shading_normal,
            emitted: self.lights.emitted(surface),
            direct,
            indirect,
        }
    }

    fn first_vertex(&self, bounce: &Bounce, first: &Surface, sample: &Sample) -> Option<FirstVertex> {
        let Owner::Material(material) = first.owner else { return None };
        let choices = sample.pair(4);
        let mixture = &self.mixtures[material as usize];
        let sampled = self.light_sampled(first, mixture, choices[0], sample.pair(5));
        let seen = Bounce::sample(first, mixture, choices[1], sample.pair(6))
            .and_then(|b| self.light_along(first, &b));
        let carried = |r: Reflection| Reflection { light: r.light * bounce.weight(), ..r };
        let reflections = [sampled.map(carried), seen.map(carried)];
        let later = self.later.as_ref().map(|later| self.later_vertices(later, first, material, sample));
        let is_lit = later.is_some() || reflections.iter().any(Option::is_some);
        is_lit.then(|| FirstVertex {
            material,
            albedo: first.albedo,
            eye_angles: bounce.angles,
            reflections,
            weight: bounce.weight(),
            later: later.unwrap_or_default(),
        })
    }

    /// Light from a point chosen on a light.
    pub(super) fn light_sampled(
        &self,
        surface: &Surface,
        mixture: &LobeMixture,
        choice: f32,
        point: [f32; 2],
    ) -> Option<Reflection> {
        let LightSample { direction, weight, density, .. } =
            self.lights.sample_visible(self.world, surface, choice, point)?;
        let normal = surface.shading_normal;
        let share = density.map_or(1.0, |d| d / (d + mixture.density(normal, surface.outgoing, direction)));
        let angles = angles(direction, surface.outgoing, normal);
        Some(Reflection { angles, light: weight * (direction.dot(normal) * share) })
    }

    /// Light that a bounce met, `hit` being the first surface in its way.
    pub(super) fn light_seen(
        &self,
        surface: &Surface,
        bounce: &Bounce,
        hit: Option<&Surface>,
    ) -> Option<Reflection> {
        let radiance = self.lights.met(bounce.direction, hit);
        if radiance == Vec3A::ZERO {
            return None;
        }
        let density = self.lights.density_of(surface, bounce.direction, hit);
        // Weight density / (density + light's) over density.
        let light = radiance * (bounce.cosine / (bounce.density + density));
        (light != Vec3A::ZERO).then_some(Reflection { angles: bounce.angles, light })
    }

    /// Light that a bounce meets if nothing is in its way. Asks the few lights first: most bounces miss them
    /// and need no ray.
    fn light_along(&self, surface: &Surface, bounce: &Bounce) -> Option<Reflection> {
        let from = surface.offset();
        if self.lights.have_meshes() {
            let hit = self.world.intersect(from, bounce.direction);
            return self.light_seen(surface, bounce, hit.as_ref());
        }
        let (radiance, density, distance) = self.lights.along(surface, bounce.direction)?;
        let light = radiance * (bounce.cosine / (bounce.density + density));
        let arrives = light != Vec3A::ZERO && !self.world.occluded(from, bounce.direction, distance);
        arrives.then_some(Reflection { angles: bounce.angles, light })
    }
}

/// A direction chosen by a surface's lobes, above the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounce {
    pub(super) direction: Vec3A,
    /// Per steradian.
    density: f32,
    /// With the shading normal.
    cosine: f32,
    pub(super) angles: Angles,
}

impl Bounce {
    pub(super) fn sample(
        surface: &Surface,
        mixture: &LobeMixture,
        choice: f32,
        point: [f32; 2],
    ) -> Option<Self> {
        let normal = surface.shading_normal;
        let (direction, density) = mixture.sample(normal, surface.outgoing, choice, point);
        let cosine = direction.dot(normal);
        let above = cosine > 0.0 && direction.dot(surface.geometric_normal) > 0.0;
        above.then(|| Self {
            direction,
            density,
            cosine,
            angles: angles(direction, surface.outgoing, normal),
        })
    }

    pub(super) fn weight(&self) -> f32 {
        self.cosine / self.density
    }
}
