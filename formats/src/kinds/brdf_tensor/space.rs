//! The materials that a tensor was made of, and how those between are mixed of them (thesis §5.3.2).

use super::MAX_SAMPLES;
use crate::container::{Section, Sections, Writer};
use crate::error::Result;
use crate::state::{Brdf, Model, ROUGHNESS_MIN, SHININESS_MAX, SHININESS_MIN, SLOPE_MIN};

/// By how much triangles may cover less or more than all.
const COVERED: f64 = 1e-4;
/// How far the ends of a range may be off, in parts of themselves.
const RANGE_TOLERANCE: f32 = 1e-5;

/// The samples of a space of lobes.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// Of Blinn-Phong: exponents, increasing from 1 to 200.
    Line(Vec<f32>),
    /// Of microfacets.
    Plane {
        /// Reflectance at normal incidence and roughness, or slope, of each.
        points: Vec<[f32; 2]>,
        /// Triangles of indices, which cover what materials may be.
        triangles: Vec<[u32; 3]>,
    },
}

impl Samples {
    /// Number of samples.
    pub fn count(&self) -> usize {
        match self {
            Self::Line(exponents) => exponents.len(),
            Self::Plane { points, .. } => points.len(),
        }
    }

    /// The samples that the glossy lobe of `material` in one channel lies between, and how much each counts,
    /// together 1. A material outside of the space is that nearest to it: the nearest exponent, and, the
    /// space of microfacets being a rectangle, the nearest reflectance and the nearest roughness. `None` if
    /// it is of a model that has no such samples, or no number. Whose plane it is a plane does not know.
    pub fn mixture(&self, material: &Brdf, channel: usize) -> Option<Vec<(usize, f32)>> {
        match (self, material) {
            (Self::Line(exponents), Brdf::BlinnPhong(brdf)) => between(exponents, brdf.shininess),
            (Self::Plane { points, triangles }, Brdf::Ggx(brdf)) => {
                within(points, triangles, [*brdf.f0().get(channel)?, brdf.roughness])
            }
            (Self::Plane { points, triangles }, Brdf::CookTorrance(brdf)) => {
                within(points, triangles, [brdf.fresnel, brdf.roughness])
            }
            _ => None,
        }
    }

    pub(super) fn encode(&self, out: &mut Writer) -> Result<()> {
        match self {
            Self::Line(exponents) => out.f32s("exponents", &[exponents.len() as u64], exponents),
            Self::Plane { points, triangles } => {
                out.f32s("points", &[points.len() as u64, 2], points.as_flattened())?;
                out.u32s("triangles", &[triangles.len() as u64, 3], triangles.as_flattened())
            }
        }
    }

    pub(super) fn decode(model: Model, sections: &mut Sections<'_>) -> Result<Self> {
        match model {
            Model::BlinnPhong => {
                let section = sections.take("exponents")?;
                section.expect(fault_of_count(section.length()?))?;
                let exponents = section.f32s()?;
                section.expect_finite(&exponents)?;
                section.expect(fault_of_line(&exponents))?;
                Ok(Self::Line(exponents))
            }
            Model::Ggx => plane(ROUGHNESS_MIN, sections),
            Model::CookTorrance => plane(SLOPE_MIN, sections),
        }
    }
}

fn fault_of_count(count: u64) -> Option<String> {
    let few = !(2..=MAX_SAMPLES).contains(&count);
    few.then(|| format!("holds {count} samples, 2 to {MAX_SAMPLES} are allowed"))
}

fn fault_of_line(exponents: &[f32]) -> Option<String> {
    let (first, last) = (*exponents.first()?, *exponents.last()?);
    if !exponents.is_sorted_by(|a, b| a < b) {
        return Some("exponents must increase".to_owned());
    }
    let off = |value: f32, expected: f32| (value - expected).abs() > RANGE_TOLERANCE * expected;
    (off(first, SHININESS_MIN) || off(last, SHININESS_MAX))
        .then(|| format!("runs from {first} to {last}, expected {SHININESS_MIN} to {SHININESS_MAX}"))
}

fn plane(least: f32, sections: &mut Sections<'_>) -> Result<Samples> {
    let section = sections.take("points")?;
    let points = section.f32_rows::<2>()?;
    section.expect(fault_of_count(points.len() as u64))?;
    section.expect_finite(points.as_flattened())?;
    let roughness = least * (1.0 - RANGE_TOLERANCE)..=1.0 + RANGE_TOLERANCE;
    let legal =
        |[reflectance, rough]: &[f32; 2]| (0.0..=1.0).contains(reflectance) && roughness.contains(rough);
    let strange = points.iter().position(|point| !legal(point));
    section.expect(strange.map(|at| format!("sample {at} is outside 0 to 1 and {least} to 1")))?;
    let section = sections.take("triangles")?;
    let triangles = section.u32_rows::<3>()?;
    // Of a plane graph, which has no more.
    let most = 2 * points.len();
    section.expect(
        (triangles.len() > most)
            .then(|| format!("holds {} triangles, at most {most} are possible", triangles.len())),
    )?;
    expect_triangles(&section, &points, &triangles)?;
    section.expect(fault_of_cover(&points, &triangles, least))?;
    Ok(Samples::Plane { points, triangles })
}

fn expect_triangles(section: &Section, points: &[[f32; 2]], triangles: &[[u32; 3]]) -> Result<()> {
    for (number, triangle) in triangles.iter().enumerate() {
        let corners = corners(points, triangle);
        let fault = match corners.map(area) {
            None => Some("names a sample that is not there"),
            Some(area) if area <= 0.0 => Some("is not counter-clockwise"),
            Some(_) => None,
        };
        section.expect(fault.map(|fault| format!("triangle {number} {fault}")))?;
    }
    Ok(())
}

/// That triangles are not as large together as what materials may be, in the plane in which they are linear.
fn fault_of_cover(points: &[[f32; 2]], triangles: &[[u32; 3]], least: f32) -> Option<String> {
    let covered: f64 = triangles.iter().filter_map(|t| corners(points, t)).map(|t| 0.5 * area(t)).sum();
    let share = covered / -f64::from(least).ln();
    let off = (share - 1.0).abs() > COVERED;
    off.then(|| format!("triangles cover {share:.4} times what materials may be"))
}

/// Between the two nearest of increasing `exponents`, at their ends outside of them.
fn between(exponents: &[f32], exponent: f32) -> Option<Vec<(usize, f32)>> {
    let after =
        exponents.partition_point(|s| *s <= exponent).clamp(1, exponents.len().saturating_sub(1).max(1));
    let (s0, s1) = (*exponents.get(after - 1)?, *exponents.get(after)?);
    let mix = ((exponent - s0) / (s1 - s0)).clamp(0.0, 1.0);
    mix.is_finite().then(|| vec![(after - 1, 1.0 - mix), (after, mix)])
}

/// In the plane of reflectance and ln roughness, in which lobes widen evenly.
fn coordinates([reflectance, roughness]: [f32; 2]) -> [f64; 2] {
    [f64::from(reflectance), f64::from(roughness).ln()]
}

fn corners(points: &[[f32; 2]], triangle: &[u32; 3]) -> Option<[[f64; 2]; 3]> {
    let corner = |index: u32| points.get(index as usize).copied().map(coordinates);
    let [a, b, c] = triangle.map(corner);
    Some([a?, b?, c?])
}

/// Twice the area, positive if counter-clockwise.
fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Barycentric in the triangle that holds `material`, or the point of the rectangle of all samples nearest to
/// it: the triangle that this is farthest inside of, for rounding may put an edge outside of both sides.
fn within(points: &[[f32; 2]], triangles: &[[u32; 3]], material: [f32; 2]) -> Option<Vec<(usize, f32)>> {
    if material.iter().any(|value| value.is_nan()) {
        return None;
    }
    let place = coordinates(nearest(points, material));
    let shares = |triangle: &[u32; 3]| {
        let [a, b, c] = corners(points, triangle)?;
        let whole = area([a, b, c]);
        Some([area([place, b, c]), area([a, place, c]), area([a, b, place])].map(|part| part / whole))
    };
    let mut best: Option<(f64, [f64; 3], [u32; 3])> = None;
    for triangle in triangles {
        let shares = shares(triangle)?;
        let inside = shares.into_iter().fold(f64::INFINITY, f64::min);
        if inside > best.map_or(f64::NEG_INFINITY, |(least, ..)| least) {
            best = Some((inside, shares, *triangle));
        }
    }
    let (_, shares, triangle) = best?;
    let shares = shares.map(|share| share.max(0.0));
    let whole: f64 = shares.iter().sum();
    let share_of = |(index, share): (&u32, f64)| (*index as usize, (share / whole) as f32);
    Some(triangle.iter().zip(shares).map(share_of).collect())
}

/// The point of the smallest rectangle around `points` that is nearest to `material`.
fn nearest(points: &[[f32; 2]], material: [f32; 2]) -> [f32; 2] {
    [0, 1].map(|axis: usize| {
        let least = points.iter().map(|point| point[axis]).fold(f32::INFINITY, f32::min);
        let most = points.iter().map(|point| point[axis]).fold(f32::NEG_INFINITY, f32::max);
        material[axis].max(least).min(most)
    })
}
