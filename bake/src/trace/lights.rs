//! All lights of a scene as one thing to sample: one light is chosen by its power, then a point or direction
//! on it.

use super::environment::EnvironmentLight;
use super::light_mesh::{Chosen, LightMesh};
use super::world::{OnLight, Surface, World, rounding_of};
use glam::Vec3A;
use relume_scenes::{Cone, Emitter, Scene};
use std::f32::consts::PI;

/// The lights of a scene, prepared for sampling.
pub struct Lights {
    lights: Vec<PreparedLight>,
    environment: Option<EnvironmentLight>,
    /// Running sums of the chance of each light, the environment last; ends in 1.
    cdf: Vec<f32>,
}

enum PreparedLight {
    Area {
        corner: Vec3A,
        edge_u: Vec3A,
        edge_v: Vec3A,
        normal: Vec3A,
        area: f32,
        rounding: f32,
        radiance: Vec3A,
    },
    Mesh {
        mesh: LightMesh,
        radiance: Vec3A,
    },
    Point {
        position: Vec3A,
        intensity: Vec3A,
        cone: Option<Cone>,
    },
    Directional {
        towards: Vec3A,
        irradiance: Vec3A,
    },
}

/// Light that arrives at a point unless something stands in its way.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub direction: Vec3A,
    /// Distance to the light; infinite for lights from afar.
    pub distance: f32,
    /// Radiance over density: times BRDF and cosine, an estimate of reflected radiance.
    pub weight: Vec3A,
    /// Density per steradian; `None` for lights without extent, which no other sampling can find.
    pub density: Option<f32>,
}

impl LightSample {
    /// Light from a point chosen with the density 1 / `area` on a surface that emits `radiance` there, on the
    /// side of `normal`.
    fn of_surface(from: Vec3A, point: Vec3A, normal: Vec3A, area: f32, radiance: Vec3A) -> Option<Self> {
        let to = point - from;
        let distance = to.length();
        let direction = to / distance;
        let cosine = -direction.dot(normal);
        let density = distance * distance / (area * cosine);
        (cosine > 0.0).then(|| Self {
            direction,
            distance,
            weight: radiance / density,
            density: Some(density),
        })
    }
}

impl Lights {
    /// Prepares the lights of `scene`.
    pub fn new(scene: &Scene, world: &World) -> Self {
        let lights: Vec<_> = scene.lights.iter().map(|l| PreparedLight::new(&l.emitter, scene)).collect();
        let environment = scene.environment.as_ref().and_then(EnvironmentLight::new);
        let cross_section = PI * world.radius * world.radius;
        let powers = lights
            .iter()
            .map(|l| l.power(cross_section))
            .chain(environment.iter().map(|e| e.total() * cross_section));
        let mut sum = 0.0;
        let mut cdf: Vec<f32> = powers
            .map(|p| {
                sum += p;
                sum
            })
            .collect();
        cdf.iter_mut().for_each(|c| *c /= sum);
        if sum <= 0.0 {
            cdf.clear();
        }
        Self { lights, environment, cdf }
    }

    /// Chooses light towards `surface` with three numbers in [0, 1). `None` where nothing shines or the light
    /// is behind.
    pub fn sample(&self, surface: &Surface, choice: f32, point: [f32; 2]) -> Option<LightSample> {
        let index = self.cdf.partition_point(|c| *c <= choice).min(self.cdf.len().checked_sub(1)?);
        let chance = self.chance(index);
        let from = surface.offset();
        let mut sample = match self.lights.get(index) {
            Some(light) => light.sample(from, point)?,
            None => {
                let environment = self.environment.as_ref()?;
                let (direction, density) = environment.sample(point);
                LightSample {
                    direction,
                    distance: f32::INFINITY,
                    weight: environment.radiance(direction) / density,
                    density: Some(density),
                }
            }
        };
        sample.weight /= chance;
        sample.density = sample.density.map(|d| d * chance);
        let faces = sample.direction.dot(surface.geometric_normal) > 0.0
            && sample.direction.dot(surface.shading_normal) > 0.0;
        (faces && sample.weight != Vec3A::ZERO && sample.weight.is_finite()).then_some(sample)
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

    /// Whether any light is a mesh, of which [`Lights::along`] knows nothing.
    pub fn have_meshes(&self) -> bool {
        self.lights.iter().any(|light| matches!(light, PreparedLight::Mesh { .. }))
    }

    /// What shines from `direction` on the point `from` if nothing is in the way, meshes left out: radiance,
    /// the density per steradian with which [`Lights::sample`] chooses that direction, and how far away it
    /// is.
    pub fn along(&self, from: Vec3A, direction: Vec3A) -> Option<(Vec3A, f32, f32)> {
        let met =
            self.lights.iter().enumerate().filter_map(|(i, light)| {
                light.meet(from, direction).map(|(r, d, t)| (r, d * self.chance(i), t))
            });
        let nearest = met.min_by(|a, b| a.2.total_cmp(&b.2));
        nearest.or_else(|| {
            let environment = self.environment.as_ref()?;
            Some((environment.radiance(direction), self.density_of_background(direction), f32::INFINITY))
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

    /// Radiance from infinitely far away.
    pub fn background(&self, direction: Vec3A) -> Vec3A {
        self.environment.as_ref().map_or(Vec3A::ZERO, |e| e.radiance(direction))
    }

    /// Density per steradian with which [`Lights::sample`] at `from` chooses the point `hit`; 0 where it does
    /// not shine.
    pub fn density_of_surface(&self, from: Vec3A, hit: &Surface) -> f32 {
        let Some(OnLight { light, triangle, barycentric }) = hit.light else { return 0.0 };
        let area = match self.lights.get(light as usize) {
            Some(PreparedLight::Area { area, .. }) => *area,
            Some(PreparedLight::Mesh { mesh, .. }) => mesh.area_at(triangle, barycentric),
            _ => return 0.0,
        };
        let distance_squared = from.distance_squared(hit.position);
        self.chance(light as usize) * distance_squared
            / (area * hit.geometric_normal.dot(hit.outgoing)).max(f32::MIN_POSITIVE)
    }

    /// Density per steradian with which [`Lights::sample`] chooses the background in `direction`.
    pub fn density_of_background(&self, direction: Vec3A) -> f32 {
        self.environment.as_ref().map_or(0.0, |e| e.density(direction) * self.chance(self.lights.len()))
    }

    fn chance(&self, index: usize) -> f32 {
        self.cdf.get(index).map_or(0.0, |c| c - if index == 0 { 0.0 } else { self.cdf[index - 1] })
    }
}

impl PreparedLight {
    fn new(emitter: &Emitter, scene: &Scene) -> Self {
        match emitter {
            Emitter::Mesh { object, radiance, glow } => {
                let object = &scene.objects[*object];
                let mesh = LightMesh::new(&object.mesh, glow.as_ref(), scene.materials.get(object.material));
                Self::Mesh { mesh, radiance: Vec3A::from(*radiance) }
            }
            Emitter::Area { corner, edge_u, edge_v, radiance } => {
                let [corner, edge_u, edge_v, radiance] =
                    [corner, edge_u, edge_v, radiance].map(|v| Vec3A::from(*v));
                let cross = edge_u.cross(edge_v);
                let rounding =
                    rounding_of(&[corner, corner + edge_u, corner + edge_v, corner + edge_u + edge_v]);
                Self::Area {
                    corner,
                    edge_u,
                    edge_v,
                    normal: cross.normalize(),
                    area: cross.length(),
                    rounding,
                    radiance,
                }
            }
            Emitter::Point { position, intensity, cone } => Self::Point {
                position: Vec3A::from(*position),
                intensity: Vec3A::from(*intensity),
                cone: *cone,
            },
            Emitter::Directional { direction, irradiance } => {
                Self::Directional { towards: -Vec3A::from(*direction), irradiance: Vec3A::from(*irradiance) }
            }
        }
    }

    fn power(&self, cross_section: f32) -> f32 {
        match self {
            Self::Area { area, radiance, .. } => PI * area * radiance.max_element(),
            Self::Mesh { mesh, radiance } => PI * mesh.area() * radiance.max_element(),
            Self::Point { intensity, cone, .. } => {
                intensity.max_element() * cone.map_or(4.0 * PI, |c| solid_angle(&c))
            }
            Self::Directional { irradiance, .. } => cross_section * irradiance.max_element(),
        }
    }

    /// Where a ray meets the front of an area light: radiance, density over the solid angle, distance to just
    /// before it.
    fn meet(&self, from: Vec3A, direction: Vec3A) -> Option<(Vec3A, f32, f32)> {
        let Self::Area { corner, edge_u, edge_v, normal, area, rounding, radiance } = *self else {
            return None;
        };
        let cosine = -direction.dot(normal);
        if cosine <= 0.0 {
            return None;
        }
        let distance = (from - corner).dot(normal) / cosine;
        let on_light = from + direction * distance - corner;
        // Coordinates along the edges, which need not be perpendicular.
        let (uu, uv, vv) = (edge_u.dot(edge_u), edge_u.dot(edge_v), edge_v.dot(edge_v));
        let (pu, pv) = (on_light.dot(edge_u), on_light.dot(edge_v));
        let determinant = uu * vv - uv * uv;
        let (u, v) = ((pu * vv - pv * uv) / determinant, (pv * uu - pu * uv) / determinant);
        let inside = distance > 0.0 && (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        inside.then(|| (radiance, distance * distance / (area * cosine), distance - rounding / cosine))
    }

    fn sample(&self, from: Vec3A, [u, v]: [f32; 2]) -> Option<LightSample> {
        match *self {
            Self::Area { corner, edge_u, edge_v, normal, area, rounding, radiance } => {
                let point = corner + edge_u * u + edge_v * v + normal * rounding;
                LightSample::of_surface(from, point, normal, area, radiance)
            }
            Self::Mesh { ref mesh, radiance } => {
                let Chosen { point, normal, area, share } = mesh.sample([u, v])?;
                LightSample::of_surface(from, point, normal, area, radiance * share)
            }
            Self::Point { position, intensity, cone } => {
                let to = position - from;
                let distance = to.length();
                let direction = to / distance;
                let weight =
                    intensity * (cone.map_or(1.0, |c| falloff(&c, -direction)) / (distance * distance));
                (distance > 0.0).then_some(LightSample { direction, distance, weight, density: None })
            }
            Self::Directional { towards, irradiance } => Some(LightSample {
                direction: towards,
                distance: f32::INFINITY,
                weight: irradiance,
                density: None,
            }),
        }
    }
}

/// What of a spot light's intensity goes in the unit direction `away` from it.
fn falloff(cone: &Cone, away: Vec3A) -> f32 {
    let ramp = (away.dot(cone.direction.into()) - cone.cos_outer)
        / (cone.cos_inner - cone.cos_outer).max(f32::EPSILON);
    ramp.clamp(0.0, 1.0).powi(2)
}

/// Solid angle that a spot light fills, the ramp counting a third: the integral of its square.
fn solid_angle(cone: &Cone) -> f32 {
    2.0 * PI * ((1.0 - cone.cos_inner) + (cone.cos_inner - cone.cos_outer) / 3.0)
}
