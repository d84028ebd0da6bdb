//! Lights of a scene, each prepared for sampling.

use crate::trace::environment::{EnvironmentLight, PatchChances};
use crate::trace::light_mesh::{Chosen, LightMesh};
use crate::trace::world::rounding_of;
use glam::Vec3A;
use relume_scenes::{Cone, Emitter, Scene};
use std::f64::consts::PI;

pub(super) enum PreparedLight {
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
    /// Light from a direction that `point` chooses.
    pub(super) fn of_environment(
        environment: &EnvironmentLight,
        patches: &PatchChances,
        point: [f32; 2],
    ) -> Self {
        let (direction, density) = environment.sample(patches, point);
        let weight = environment.radiance(direction) / density;
        Self { direction, distance: f32::INFINITY, weight, density: Some(density) }
    }

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

impl PreparedLight {
    pub(super) fn new(emitter: &Emitter, scene: &Scene) -> Self {
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

    /// What it sends, `cross_section` being that of the scene, m².
    pub(super) fn power(&self, cross_section: f64) -> f64 {
        let (extent, sends) = match self {
            Self::Area { area, radiance, .. } => (PI * f64::from(*area), radiance),
            Self::Mesh { mesh, radiance } => (PI * f64::from(mesh.area()), radiance),
            Self::Point { intensity, cone, .. } => (cone.map_or(4.0 * PI, |c| solid_angle(&c)), intensity),
            Self::Directional { irradiance, .. } => (cross_section, irradiance),
        };
        extent * f64::from(sends.max_element())
    }

    /// Where a ray meets the front of an area light: radiance, density over the solid angle, distance to just
    /// before it.
    pub(super) fn meet(&self, from: Vec3A, direction: Vec3A) -> Option<(Vec3A, f32, f32)> {
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

    pub(super) fn sample(&self, from: Vec3A, [u, v]: [f32; 2]) -> Option<LightSample> {
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
fn solid_angle(cone: &Cone) -> f64 {
    let [inner, outer] = [cone.cos_inner, cone.cos_outer].map(f64::from);
    2.0 * PI * ((1.0 - inner) + (inner - outer) / 3.0)
}
