//! Procedural shapes, their axis along +Y, all but lathed ones centred at the origin. The closed ones are
//! watertight: every edge is shared by exactly two triangles whose corners there have bit-identical positions.
//! All have texture coordinates.

mod grid;
mod knot;
mod lathe;
mod ring;
mod simple;
mod sphere;
mod sphere_uvs;
mod torus;
mod twist;

pub use sphere::icosphere;
pub(crate) use twist::Twist;

use crate::description::{ObjectFile, ShapeName};
use crate::geometry::Part;
use relume_formats::{Error, Place, Result};
use std::ops::RangeInclusive;

/// A shape and its parameters, lengths in local units.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    /// Unit square in the XZ plane, facing +Y, in so many by so many smaller ones.
    Quad { segments: u32 },
    /// Unit cube.
    Box,
    /// Sphere of radius 1: an icosahedron subdivided so many times.
    Sphere { subdivisions: u32 },
    /// Torus around +Y.
    Torus { major_radius: f64, minor_radius: f64, segments: u32, sides: u32 },
    /// A tube along a (p, q) torus knot around +Y.
    TorusKnot(knot::TorusKnot),
    /// The wall of a pipe along +Y.
    Ring(ring::Ring),
    /// A profile turned about +Y.
    Lathe(lathe::Lathe),
}

impl Shape {
    /// The shape that an object asks for; parameters it does not give have defaults.
    pub fn from_object(name: ShapeName, object: &ObjectFile, place: &Place) -> Result<Self> {
        let known = name.parameters();
        if let Some(stranger) = object.given_parameters().find(|given| !known.contains(given)) {
            let list = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(Error::invalid(
                place,
                format!("`{stranger}` is no parameter of this shape; it has {list}"),
            ));
        }
        let count =
            |name, value: Option<u32>, default, range| count(name, value.unwrap_or(default), range, place);
        let length = |name, value: Option<f64>, default| length(name, value.unwrap_or(default), place);
        let segments = |default| count("segments", object.segments, default, 3..=8192);
        let sides = |default| count("sides", object.sides, default, 3..=512);
        let refuse = |reason: &str| Err(Error::invalid(place, reason));
        Ok(match name {
            ShapeName::Quad => Self::Quad { segments: count("segments", object.segments, 1, 1..=2048)? },
            ShapeName::Box => Self::Box,
            ShapeName::Sphere => {
                Self::Sphere { subdivisions: count("subdivisions", object.subdivisions, 4, 0..=9)? }
            }
            ShapeName::Torus => {
                let major_radius = length("major_radius", object.major_radius, 1.0)?;
                let minor_radius = length("minor_radius", object.minor_radius, 0.25)?;
                if minor_radius >= major_radius {
                    return refuse("minor_radius must be smaller than major_radius");
                }
                Self::Torus { major_radius, minor_radius, segments: segments(96)?, sides: sides(32)? }
            }
            ShapeName::TorusKnot => {
                let (p, q) = (count("p", object.p, 2, 1..=32)?, count("q", object.q, 3, 1..=32)?);
                let (radius, tube) =
                    (length("radius", object.radius, 1.0)?, length("tube", object.tube, 0.2)?);
                if greatest_common_divisor(p, q) != 1 {
                    return refuse("p and q must have no common divisor, else the knot runs over itself");
                }
                if tube >= radius / 3.0 {
                    return refuse(
                        "tube must be thinner than a third of radius, else the knot runs through itself",
                    );
                }
                Self::TorusKnot(knot::TorusKnot {
                    p,
                    q,
                    radius,
                    tube,
                    segments: segments(256)?,
                    sides: sides(24)?,
                })
            }
            ShapeName::Ring => {
                let inner_radius = length("inner_radius", object.inner_radius, 0.9)?;
                let outer_radius = length("outer_radius", object.outer_radius, 1.0)?;
                if inner_radius >= outer_radius {
                    return refuse("inner_radius must be smaller than outer_radius");
                }
                Self::Ring(ring::Ring {
                    inner_radius,
                    outer_radius,
                    height: length("height", object.height, 0.5)?,
                    segments: segments(128)?,
                })
            }
            ShapeName::Lathe => match &object.profile {
                Some(profile) => Self::Lathe(lathe::Lathe::new(profile, segments(64)?, place)?),
                None => return refuse("needs a `profile`; add one, such as [[0, 0], [0.5, 0], [0, 1]]"),
            },
        })
    }

    /// How many triangles [`Shape::part`] gives.
    pub fn triangles(&self) -> u64 {
        let square = |segments: u32| 2 * u64::from(segments) * u64::from(segments);
        match *self {
            Self::Quad { segments } => square(segments),
            Self::Box => 12,
            Self::Sphere { subdivisions } => 20 << (2 * subdivisions),
            Self::Torus { segments, sides, .. }
            | Self::TorusKnot(knot::TorusKnot { segments, sides, .. }) => {
                2 * u64::from(segments) * u64::from(sides)
            }
            Self::Ring(ring::Ring { segments, .. }) => 8 * u64::from(segments),
            Self::Lathe(ref lathe) => lathe.triangles(),
        }
    }

    /// How many vertices [`Shape::part`] gives, at least.
    pub fn vertices(&self) -> u64 {
        let grid = |rows: u32, columns: u32| (u64::from(rows) + 1) * (u64::from(columns) + 1);
        match *self {
            Self::Quad { segments } => grid(segments, segments),
            Self::Box => 24,
            Self::Sphere { subdivisions } => 2 + (10 << (2 * subdivisions)),
            Self::Torus { segments, sides, .. }
            | Self::TorusKnot(knot::TorusKnot { segments, sides, .. }) => grid(segments, sides),
            Self::Ring(ring::Ring { segments, .. }) => 8 * (u64::from(segments) + 1),
            Self::Lathe(ref lathe) => lathe.vertices(),
        }
    }

    /// The triangles, with unit normals.
    pub fn part(&self) -> Part {
        match self {
            Self::Quad { segments } => simple::quad(*segments),
            Self::Box => simple::cube(),
            Self::Sphere { subdivisions } => sphere::part(*subdivisions),
            Self::Torus { major_radius, minor_radius, segments, sides } => {
                torus::torus(*major_radius, *minor_radius, *segments, *sides)
            }
            Self::TorusKnot(knot) => knot.part(),
            Self::Ring(ring) => ring.part(),
            Self::Lathe(lathe) => lathe.part(),
        }
    }
}

fn count(name: &str, value: u32, range: RangeInclusive<u32>, place: &Place) -> Result<u32> {
    if range.contains(&value) {
        return Ok(value);
    }
    Err(Error::invalid(place, format!("{name} {value} is outside {}..{}", range.start(), range.end())))
}

fn length(name: &str, value: f64, place: &Place) -> Result<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Error::invalid(place, format!("{name} {value} must be a number above 0")))
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod lathe_tests;
#[cfg(test)]
mod tests;
