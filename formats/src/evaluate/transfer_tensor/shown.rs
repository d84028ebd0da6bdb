//! What vertices show.

use super::{Lights, Lobes, Parts, Received, harmonic_weights, widths};
use crate::basis::{EquirectMap, blurred, hemisphere, sh};
use crate::kinds::BrdfTensor;
use crate::state::{Brdf, Rgb};
use glam::{Mat3, Vec3};
use std::f32::consts::FRAC_PI_3;

/// What a vertex shows, W/(sr·m²), without the direct light of suns.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// By its diffuse function, if that were white.
    pub diffuse: Rgb,
    /// By its highlights, but for what cones have of the map itself, which [`Parts::mirrored`] tells of any point.
    pub glossy: Rgb,
    /// Of the light of the map in each cone of its space, the part that is visible.
    pub seen: Vec<f32>,
}

/// Up to this standard deviation, degrees, a cone stands for itself: texels of what is seen are as wide.
const NARROW_DEG: f32 = 4.5;
/// From this one on, the cones that stand for a cone are divided again.
const WIDE_DEG: f32 = 20.0;
/// How far from the middle six of the seven cones are that stand for one, each half as wide, in its standard deviations: their
/// variance and that of these places make up its own, √(3/4 · 7/3).
const RING: f32 = 1.322_875_7;

/// How far above the surface the eye is at least, as a cosine.
const LEAST_HEIGHT: f32 = 1e-3;

/// What a kind of material makes of light, worked out once.
struct Prepared<'a> {
    space: &'a BrdfTensor,
    lobes: Lobes,
    /// [`harmonic_weights`].
    weights: Vec<f32>,
}

/// What every vertex shows.
pub(super) fn shown(
    parts: &Parts<'_>,
    received: &Received,
    lights: &Lights,
    brdfs: &[Brdf],
    eye: [f32; 3],
) -> Vec<Shown> {
    let prepared = |brdf: &Brdf| {
        let space = parts.space(brdf.model())?;
        Some(Prepared { lobes: Lobes::new(space, brdf)?, weights: harmonic_weights(space), space })
    };
    let prepared: Vec<Option<Prepared<'_>>> = brdfs.iter().map(prepared).collect();
    let widths = widths(parts.spaces);
    let materials = parts.scene.materials_of_vertices();
    let of_vertex = |(vertex, material): (usize, &u32)| {
        let material = prepared.get(*material as usize).and_then(Option::as_ref);
        let dark = || Shown { diffuse: [0.0; 3], glossy: [0.0; 3], seen: Vec::new() };
        material.map_or_else(dark, |material| {
            let normal = Vec3::from(parts.scene.normals[vertex]);
            let (tangent, bitangent) = normal.any_orthonormal_pair();
            let columns = parts.transfer.meta.columns as usize;
            let place = Place {
                world_from_frame: Mat3::from_cols(tangent, bitangent, normal),
                direct: &received.direct[vertex * columns..][..columns],
                once: &received.once[vertex],
                twice: received.twice[vertex],
                seen: &parts.transfer.seen[vertex * hemisphere::TEXELS..][..hemisphere::TEXELS],
            };
            let way = Vec3::from(eye) - Vec3::from(parts.scene.positions[vertex]);
            material.shown(&place, (lights, &widths), way.normalize_or(normal))
        })
    };
    materials.iter().enumerate().map(of_vertex).collect()
}

/// A vertex.
struct Place<'a> {
    /// Columns are tangent, bitangent and normal.
    world_from_frame: Mat3,
    direct: &'a [Rgb],
    once: &'a [Rgb; sh::COUNT],
    twice: Rgb,
    seen: &'a [u8],
}

impl Prepared<'_> {
    /// What it shows towards the unit vector `outgoing` in world space, from behind what it shows along the surface: a
    /// triangle may be seen of which a vertex faces away.
    fn shown(&self, place: &Place<'_>, light: (&Lights, &[f32]), outgoing: Vec3) -> Shown {
        let outgoing = above(place.world_from_frame.transpose() * outgoing);
        let arriving = self.arriving(place);
        let even = BrdfTensor::seen_from(&self.space.even, outgoing).first().copied().unwrap_or_default();
        let first = arriving.first().copied().unwrap_or_default();
        let rest = self.residual(&arriving, outgoing);
        let (reflected, seen) = self.cones(place, light, outgoing);
        Shown {
            diffuse: first.map(|value| (even * value).max(0.0)),
            glossy: std::array::from_fn(|c| rest[c] + reflected[c]),
            seen,
        }
    }

    /// All that arrives, by columns.
    fn arriving(&self, place: &Place<'_>) -> Vec<Rgb> {
        let columns = self.space.columns();
        let mut sums: Vec<Rgb> =
            place.direct.iter().copied().chain(std::iter::repeat([0.0; 3])).take(columns).collect();
        let towards = sh::directions()
            .map(|direction| harmonics_at(place.once, place.world_from_frame * direction, |_| 1.0));
        for (radiance, weights) in towards.iter().zip(self.weights.chunks_exact(columns)) {
            // What was reflected twice is taken to come evenly from all directions.
            for (sum, weight) in sums.iter_mut().zip(weights) {
                (0..3).for_each(|c| sum[c] += weight * (radiance[c] + place.twice[c]));
            }
        }
        sums
    }

    fn residual(&self, arriving: &[Rgb], outgoing: Vec3) -> Rgb {
        std::array::from_fn(|c| {
            let weights = self.space.column_weights(&self.lobes.profiles[c], outgoing);
            weights.iter().zip(&arriving[1..]).map(|(weight, received)| weight * received[c]).sum()
        })
    }

    /// What cones have of light that other surfaces reflect, and the visible part of each.
    fn cones(&self, place: &Place<'_>, light: (&Lights, &[f32]), outgoing: Vec3) -> (Rgb, Vec<f32>) {
        let shares = self.lobes.cones.each_ref().map(|table| BrdfTensor::seen_from(table, outgoing));
        let (mut sum, mut seen) = ([0.0; 3], Vec::new());
        for (number, cone) in self.space.cones.iter().enumerate() {
            let part = 1.0 / cone.count() as f32;
            let mut of_cone = 0.0;
            for direction in cone.directions(outgoing) {
                let [visible, above] = parts_of(place, light, direction, cone.width_deg);
                of_cone += part * visible;
                let towards = place.world_from_frame * direction;
                let once = harmonics_at(place.once, towards, |band| shrunk(band, cone.width_deg));
                (0..3).for_each(|c| sum[c] += part * shares[c][number] * (once[c] + above * place.twice[c]));
            }
            seen.push(of_cone);
        }
        (sum, seen)
    }
}

/// What the highlights of a point with the unit shading `normal` have of the map itself towards the unit vector `outgoing`, where
/// `seen` is the visible part of each cone there.
pub(super) fn mirrored(
    (space, lobes): (&BrdfTensor, &Lobes),
    (lights, widths): (&Lights, &[f32]),
    normal: Vec3,
    outgoing: Vec3,
    seen: &[f32],
) -> Rgb {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let world_from_frame = Mat3::from_cols(tangent, bitangent, normal);
    let outgoing = above(world_from_frame.transpose() * outgoing);
    let shares = lobes.cones.each_ref().map(|table| BrdfTensor::seen_from(table, outgoing));
    let mut sum = [0.0; 3];
    for (number, (cone, seen)) in space.cones.iter().zip(seen).enumerate() {
        let map =
            widths.iter().position(|width| *width == cone.width_deg).and_then(|at| lights.blurred.get(at));
        let Some(map) = map else { continue };
        for direction in cone.directions(outgoing) {
            let radiance = blurred::radiance(map, lights.rotation_deg, world_from_frame * direction);
            let part = seen / cone.count() as f32;
            (0..3).for_each(|c| sum[c] += part * shares[c][number] * lights.gain[c] * radiance[c]);
        }
    }
    sum
}

/// A unit vector in the frame of a surface, no lower than eyes may be.
fn above(Vec3 { x, y, z }: Vec3) -> Vec3 {
    Vec3::new(x, y, z.max(LEAST_HEIGHT)).normalize()
}

/// What is left of a band of harmonics in a cone.
fn shrunk(band: usize, width_deg: f32) -> f32 {
    let sigma = width_deg.to_radians();
    (-0.5 * (band * (band + 1)) as f32 * sigma * sigma).exp()
}

/// Of a cone about the unit vector `direction`, which may point below the surface, the part of its light from the map that is
/// visible, of red, green and blue together, and the part of it that is above the surface.
fn parts_of(
    place: &Place<'_>,
    (lights, widths): (&Lights, &[f32]),
    direction: Vec3,
    width_deg: f32,
) -> [f32; 2] {
    let (mut light, mut lit, mut seen, mut above, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (point, width_deg) in cone_points(direction, width_deg) {
        let radiance = map_of(lights, widths, width_deg).map_or(0.0, |map| {
            blurred::radiance(map, lights.rotation_deg, place.world_from_frame * point).iter().sum()
        });
        let visible = if point.z > 0.0 { hemisphere::sample(place.seen, point) } else { 0.0 };
        (light, lit) = (light + radiance, lit + radiance * visible);
        (seen, above, count) = (seen + visible, above + f32::from(u8::from(point.z > 0.0)), count + 1.0);
    }
    [if light > 0.0 { lit / light } else { seen / count }, above / count]
}

/// The map that cones of a width see, or the next narrower ones.
fn map_of<'a>(lights: &'a Lights, widths: &[f32], width_deg: f32) -> Option<&'a EquirectMap> {
    lights.blurred.get(widths.iter().rposition(|width| *width <= width_deg).unwrap_or(0))
}

/// Radiance of `harmonics` in a direction, a band times what `scale` gives for it.
fn harmonics_at(harmonics: &[Rgb; sh::COUNT], direction: Vec3, scale: impl Fn(usize) -> f32) -> Rgb {
    let values = sh::evaluate(direction);
    let mut sum = [0.0; 3];
    for (at, (value, harmonic)) in values.iter().zip(harmonics).enumerate() {
        let value = value * scale(at.isqrt());
        (0..3).for_each(|c| sum[c] += value * harmonic[c]);
    }
    sum
}

/// The middles and widths of the cones, alike in weight, that stand for one about `direction`: itself if it is narrow, else seven half as
/// wide, or seven times seven.
pub fn cone_points(direction: Vec3, width_deg: f32) -> impl Iterator<Item = (Vec3, f32)> {
    let (first, again) = (width_deg > NARROW_DEG, width_deg > WIDE_DEG);
    divided(direction, width_deg, first).flat_map(move |(part, width_deg)| divided(part, width_deg, again))
}

fn divided(direction: Vec3, width_deg: f32, divides: bool) -> impl Iterator<Item = (Vec3, f32)> {
    let (right, up) = direction.any_orthonormal_pair();
    let (sin, cos) = (RING * width_deg.to_radians()).sin_cos();
    let width_deg = if divides { 0.5 * width_deg } else { width_deg };
    let ring = (0..if divides { 6 } else { 0 }).map(move |k| {
        let (s, c) = (FRAC_PI_3 * k as f32).sin_cos();
        (cos * direction + sin * (c * right + s * up), width_deg)
    });
    std::iter::once((direction, width_deg)).chain(ring)
}
