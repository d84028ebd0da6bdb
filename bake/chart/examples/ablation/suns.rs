//! The suns of a scene's map, drawn at every film sample with rays: what shadow maps stand for.

use crate::steps::{Film, SAMPLES, SIZE};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use relume_bake::error::{BakeError, Result};
use relume_bake::methods::environment_lit::environments;
use relume_bake::trace::sampler::PixelSampler;
use relume_bake::trace::world::{Owner, Surface, World};
use relume_formats::Place;
use relume_formats::basis::EquirectMap;
use relume_formats::basis::suns::{Sun, split};
use relume_formats::evaluate::suns::{radiance, towards};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use std::f32::consts::TAU;
use std::sync::Arc;

/// The light of a scene, as bundles keep it, in its two parts.
pub struct Parted {
    /// The map.
    pub whole: EquirectMap,
    /// The map without its suns.
    pub rest: EquirectMap,
    /// Gain and rotation of both.
    pub look: EnvironmentLook,
    suns: Vec<Sun>,
}

impl Parted {
    /// Of the map that shines in `scene`.
    ///
    /// # Errors
    /// If there is none.
    pub fn new(scene: &Scene) -> Result<Self> {
        let none = || BakeError::invalid(&Place::file(&scene.file), "has no [environment]");
        let environment = scene.environment.as_ref().ok_or_else(none)?;
        let kept = environments(scene).swap_remove(0);
        let parts = split(&kept.map);
        let (suns, rest) = (parts.suns, parts.rest.into_owned());
        let look = EnvironmentLook {
            map: String::new(),
            gain: environment.gain,
            rotation_deg: environment.rotation_deg,
        };
        Ok(Self { look, suns, rest, whole: kept.map })
    }

    /// `scene` under the map without suns.
    pub fn without_suns(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if let Some(environment) = &mut scene.environment {
            environment.map.map = Arc::new(self.rest.clone());
        }
        scene
    }

    /// What the suns add to the film of `scene`: [`SAMPLES`] rays to points of each disc for each pixel.
    pub fn of_suns(&self, scene: &Scene, places: Film) -> Vec<Rgb> {
        let world = World::new(scene);
        let film = scene.camera.film(SIZE[0], SIZE[1]);
        let pixel = |pixel: u32| {
            let sampler = PixelSampler::new(0, pixel);
            let mut sum = Vec3A::ZERO;
            let points = SAMPLES / places.samples();
            for index in 0..places.samples() {
                let [dx, dy] = places.place(pixel, index);
                let direction = film.direction((pixel % SIZE[0]) as f32 + dx, (pixel / SIZE[0]) as f32 + dy);
                let Some(surface) = world.intersect(film.eye_in_world, direction) else { continue };
                let Owner::Material(material) = surface.owner else { continue };
                let albedo = Vec3A::from(scene.materials[material as usize].brdf.diffuse_albedo());
                let points =
                    (index * points..(index + 1) * points).map(|point| sampler.sample(point).pair(1));
                let light: Vec3A = points.map(|point| self.at(&surface, &world, point)).sum();
                sum += albedo * surface.albedo * light;
            }
            (sum / SAMPLES as f32).to_array()
        };
        (0..SIZE[0] * SIZE[1]).into_par_iter().map(pixel).collect()
    }

    /// What a white surface shows of the suns, each seen or not at the `point` of its disc.
    fn at(&self, surface: &Surface, world: &World, point: [f32; 2]) -> Vec3A {
        let of_sun = |sun: &Sun| {
            let direction = on_disc(towards(sun, self.look.rotation_deg), sun.radius, point);
            let is_seen = direction.dot(surface.geometric_normal) > 0.0
                && !world.occluded(surface.offset(), direction, f32::INFINITY);
            let seen = f32::from(u8::from(is_seen));
            Vec3A::from(radiance(sun, &self.look, surface.shading_normal.into(), seen))
        };
        self.suns.iter().map(of_sun).sum()
    }
}

/// The unit vector to a point of the disc of so many radians around `centre`, for two random numbers.
fn on_disc(centre: Vec3, radius: f32, [u, v]: [f32; 2]) -> Vec3A {
    // 1 − cos without the difference's rounding.
    let below = 2.0 * (radius / 2.0).sin().powi(2) * u;
    let (cos, sin) = (1.0 - below, (below * (2.0 - below)).sqrt());
    let (right, up) = centre.any_orthonormal_pair();
    let (y, x) = (TAU * v).sin_cos();
    Vec3A::from(cos * centre + sin * (x * right + y * up))
}

/// One film on top of another.
pub fn sum(film: &[Rgb], other: &[Rgb]) -> Vec<Rgb> {
    film.iter().zip(other).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect()
}
