//! The ring: a band of metal around +Y, with vertical walls and flat rims. Its inside focuses light.

use crate::geometry::Part;
use glam::DVec3;
use std::f64::consts::TAU;

/// See the module. `inner_radius` < `outer_radius`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ring {
    /// Radius of the inner wall.
    pub inner_radius: f64,
    /// Radius of the outer wall.
    pub outer_radius: f64,
    /// Extent along +Y, half of it below the origin.
    pub height: f64,
    /// Corners of each circle.
    pub segments: u32,
}

impl Ring {
    /// The triangles; walls are smooth around the axis, edges sharp. A texture covers the height of the
    /// walls, repeats around them as often as leaves it least stretched, and is cut off by the rims.
    pub fn part(&self) -> Part {
        let mut part = Part::default();
        let (inner, outer, top, bottom) =
            (self.inner_radius, self.outer_radius, 0.5 * self.height, -0.5 * self.height);
        let outward = |direction: DVec3| direction;
        self.add_band(&mut part, [(outer, bottom), (outer, top)], outward);
        self.add_band(&mut part, [(inner, top), (inner, bottom)], |direction| -direction);
        self.add_band(&mut part, [(outer, top), (inner, top)], |_| DVec3::Y);
        self.add_band(&mut part, [(inner, bottom), (outer, bottom)], |_| DVec3::NEG_Y);
        part
    }

    /// A band between two circles, given as (radius, height); its outside is counter-clockwise around the
    /// axis × first to second circle.
    fn add_band(&self, part: &mut Part, circles: [(f64, f64); 2], normal: impl Fn(DVec3) -> DVec3) {
        let first = part.positions.len() as u32;
        let repeats = (TAU * self.outer_radius / self.height).round().max(1.0);
        let across = (circles[0].0 - circles[1].0).hypot(circles[0].1 - circles[1].1) / self.height;
        for segment in 0..=self.segments {
            let around = f64::from(segment) / f64::from(self.segments);
            // The last direction is computed as the first one, so that their positions are equal to the bit.
            let angle = TAU * f64::from(segment % self.segments) / f64::from(self.segments);
            let direction = DVec3::new(angle.cos(), 0.0, -angle.sin());
            part.positions
                .extend(circles.map(|(radius, y)| (direction * radius + DVec3::Y * y).as_vec3().to_array()));
            part.normals.extend([normal(direction).as_vec3().to_array(); 2]);
            part.uvs.extend([across, 0.0].map(|v| [(repeats * around) as f32, v as f32]));
        }
        for segment in 0..self.segments {
            let (a, b) = (first + 2 * segment, first + 2 * (segment + 1));
            part.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
}
