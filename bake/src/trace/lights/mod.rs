//! All lights of a scene as one thing to sample: a light is chosen by what of it arrives where it is asked
//! for ([`places`]), then a point or direction on it.

mod pilot;
mod places;
mod prepared;

use super::environment::EnvironmentLight;
use super::world::{OnLight, Surface, World};
use glam::Vec3A;
use places::{LightChances, Places, Powers};
pub use prepared::LightSample;
use prepared::PreparedLight;
use relume_scenes::Scene;
use std::f64::consts::PI;

/// The lights of a scene, prepared for sampling.
pub struct Lights {
    lights: Vec<PreparedLight>,
    environment: Option<EnvironmentLight>,
    /// With what chance each is chosen; `None` if there is none.
    places: Option<Places>,
}

impl Lights {
    /// Prepares the lights of `scene`. Which of them are seen from where is learned on some paths of a seed of
    /// their own, on which all materials are matt: it is the same for all states and for all that trace the
    /// scene.
    pub fn new(scene: &Scene, world: &World) -> Self {
        let lights: Vec<_> = scene.lights.iter().map(|l| PreparedLight::new(&l.emitter, scene)).collect();
        let environment = scene.environment.as_ref().and_then(EnvironmentLight::new);
        let mut lights = Self { lights, environment, places: None };
        if let Some(powers) = lights.powers(world) {
            let visits = if powers.leave_a_choice() {
                pilot::visits(&lights, &powers, world, &scene.camera)
            } else {
                Vec::new()
            };
            lights.places = Some(Places::new(&powers, &visits));
        }
        lights
    }

    /// What each light sends; `None` if none sends any.
    fn powers(&self, world: &World) -> Option<Powers> {
        let cross_section = PI * f64::from(world.radius).powi(2);
        let lights = self.lights.iter().map(|l| l.power(cross_section)).collect();
        let environment = self.environment.as_ref();
        Powers::new(
            lights,
            environment.map_or(0.0, |e| f64::from(e.total()) * cross_section),
            environment.map_or_else(Vec::new, EnvironmentLight::brightness_of_patches),
            environment.map_or(0, |e| e.patches()[0]),
        )
    }

    /// Chooses light towards `surface` with three numbers in [0, 1). `None` where nothing shines or the light
    /// is behind.
    pub fn sample(&self, surface: &Surface, choice: f32, point: [f32; 2]) -> Option<LightSample> {
        let chances = self.chances(surface)?;
        let index = chances.pick(choice);
        let mut sample = match self.lights.get(index) {
            Some(light) => light.sample(surface.offset(), point)?,
            None => self.of_environment(chances, point)?,
        };
        let chance = chances.of(index);
        sample.weight /= chance;
        sample.density = sample.density.map(|d| d * chance);
        faces(surface, &sample).then_some(sample)
    }

    fn of_environment(&self, chances: &LightChances, point: [f32; 2]) -> Option<LightSample> {
        Some(LightSample::of_environment(self.environment.as_ref()?, chances.patches()?, point))
    }

    fn chances(&self, surface: &Surface) -> Option<&LightChances> {
        self.places.as_ref().map(|places| places.at(surface.position, surface.geometric_normal))
    }

    /// Light that arrives at `surface`: a sample that nothing blocks.
    pub fn sample_visible(
        &self,
        world: &World,
        surface: &Surface,
        choice: f32,
        point: [f32; 2],
    ) -> Option<LightSample> {
        self.sample(surface, choice, point)
            .filter(|s| !world.occluded(surface.offset(), s.direction, s.distance))
    }

    /// Whether all light comes from one point, be that at infinity: to choose it is to choose nothing.
    pub fn are_one_point(&self) -> bool {
        let is_point =
            |light| matches!(light, &PreparedLight::Point { .. } | &PreparedLight::Directional { .. });
        self.environment.is_none() && self.lights.len() == 1 && self.lights.iter().all(is_point)
    }

    /// Whether any light is a mesh, of which [`Lights::along`] knows nothing.
    pub fn have_meshes(&self) -> bool {
        self.lights.iter().any(|light| matches!(light, PreparedLight::Mesh { .. }))
    }

    /// What shines from `direction` on `surface` if nothing is in the way, meshes left out: radiance, the
    /// density per steradian with which [`Lights::sample`] chooses that direction, and how far away it is.
    pub fn along(&self, surface: &Surface, direction: Vec3A) -> Option<(Vec3A, f32, f32)> {
        let (from, chances) = (surface.offset(), self.chances(surface));
        let chance = |light| chances.map_or(0.0, |chances| chances.of(light));
        let met = self
            .lights
            .iter()
            .enumerate()
            .filter_map(|(i, light)| light.meet(from, direction).map(|(r, d, t)| (r, d * chance(i), t)));
        let nearest = met.min_by(|a, b| a.2.total_cmp(&b.2));
        nearest.or_else(|| {
            let radiance = self.environment.as_ref()?.radiance(direction);
            Some((radiance, self.density_of_background(surface, direction), f32::INFINITY))
        })
    }

    /// Radiance that `surface` emits towards where the ray came from: that of the area light or mesh that it
    /// belongs to, on its front.
    pub fn emitted(&self, surface: &Surface) -> Vec3A {
        let Some(at) = surface.light.as_ref().filter(|_| surface.front) else { return Vec3A::ZERO };
        match self.lights.get(at.light as usize) {
            Some(PreparedLight::Area { radiance, .. }) => *radiance,
            Some(PreparedLight::Mesh { mesh, radiance }) => {
                *radiance * mesh.share(at.triangle, at.barycentric)
            }
            _ => Vec3A::ZERO,
        }
    }

    /// Radiance that a ray of this direction meets: that of what it hits, or of the background.
    pub fn met(&self, direction: Vec3A, hit: Option<&Surface>) -> Vec3A {
        hit.map_or_else(|| self.background(direction), |hit| self.emitted(hit))
    }

    /// Density per steradian with which [`Lights::sample`] at `from` chooses what a ray of this direction
    /// meets.
    pub fn density_of(&self, from: &Surface, direction: Vec3A, hit: Option<&Surface>) -> f32 {
        match hit {
            None => self.density_of_background(from, direction),
            Some(hit) => self.density_of_surface(from, hit),
        }
    }

    /// Radiance from infinitely far away.
    pub fn background(&self, direction: Vec3A) -> Vec3A {
        self.environment.as_ref().map_or(Vec3A::ZERO, |e| e.radiance(direction))
    }

    /// Density per steradian with which [`Lights::sample`] at `from` chooses the point `hit`; 0 where it does
    /// not shine.
    fn density_of_surface(&self, from: &Surface, hit: &Surface) -> f32 {
        let Some(OnLight { light, triangle, barycentric }) = hit.light else { return 0.0 };
        let light = light as usize;
        let area = match self.lights.get(light) {
            Some(PreparedLight::Area { area, .. }) => *area,
            Some(PreparedLight::Mesh { mesh, .. }) => mesh.area_at(triangle, barycentric),
            _ => return 0.0,
        };
        let chance = self.chances(from).map_or(0.0, |chances| chances.of(light));
        chance * from.offset().distance_squared(hit.position)
            / (area * hit.geometric_normal.dot(hit.outgoing)).max(f32::MIN_POSITIVE)
    }

    /// Density per steradian with which [`Lights::sample`] at `from` chooses the background in `direction`.
    fn density_of_background(&self, from: &Surface, direction: Vec3A) -> f32 {
        let chosen = self.environment.as_ref().zip(self.chances(from));
        chosen.map_or(0.0, |(environment, chances)| {
            let patches = chances.patches().map_or(0.0, |patches| environment.density(patches, direction));
            patches * chances.of(self.lights.len())
        })
    }
}

/// Whether light comes in by the front of `surface`, and any does.
fn faces(surface: &Surface, light: &LightSample) -> bool {
    light.direction.dot(surface.geometric_normal) > 0.0
        && light.direction.dot(surface.shading_normal) > 0.0
        && light.weight != Vec3A::ZERO
        && light.weight.is_finite()
}
