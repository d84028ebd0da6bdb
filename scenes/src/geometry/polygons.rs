//! Polygons as triangles, for the formats that have any.

use super::MAX_ELEMENTS;
use super::builder::{area_vector, is_sliver};
use super::concave;
use super::normals::Smoothing;
use glam::{DVec2, DVec3, Vec3};
use relume_formats::counts::counted;
use relume_formats::{Error, Place, Result};

/// A turn to the wrong side by less than this, in radians, is the rounding of corners that lie on a line.
const STRAIGHT: f64 = 1e-6;

/// Polygons as a file holds them.
#[derive(Default)]
pub(super) struct Polygons {
    /// Vertex indices, those of all polygons in a row.
    corners: Vec<u32>,
    /// Where each polygon ends among `corners`, and how it is shaded.
    ends: Vec<(u32, Smoothing)>,
}

/// Triangles from polygons.
#[derive(Default)]
pub(super) struct Triangulation {
    /// Vertex indices, facing as the polygons do.
    pub triangles: Vec<[u32; 3]>,
    /// How each triangle is shaded.
    pub smoothing: Vec<Smoothing>,
    /// Faces with fewer than three corners.
    degenerate: usize,
    /// Faces whose outlines cross themselves.
    crossing: usize,
}

impl Polygons {
    /// Adds one.
    pub fn add(
        &mut self,
        corners: impl IntoIterator<Item = u32>,
        smoothing: Smoothing,
        place: &Place,
    ) -> Result<()> {
        self.corners.extend(corners);
        if self.corners.len() > 3 * MAX_ELEMENTS || self.ends.len() > MAX_ELEMENTS {
            return Err(Error::invalid(
                place,
                format!("more than {MAX_ELEMENTS} triangles in one file; split or simplify it"),
            ));
        }
        self.ends.push((self.corners.len() as u32, smoothing));
        Ok(())
    }

    /// The triangles of all polygons; `positions` are those of the vertices, and every corner is one of them.
    pub fn triangulate(&self, positions: &[[f32; 3]]) -> Triangulation {
        let mut done = Triangulation::default();
        let mut start = 0;
        for (end, smoothing) in &self.ends {
            let end = *end as usize;
            done.add(&self.corners[start..end], positions);
            done.smoothing.resize(done.triangles.len(), *smoothing);
            start = end;
        }
        done
    }
}

impl Triangulation {
    fn add(&mut self, corners: &[u32], positions: &[[f32; 3]]) {
        match *corners {
            [] | [_] | [_, _] => self.degenerate += 1,
            [a, b, c] => self.triangles.push([a, b, c]),
            [first, ref rest @ ..] => {
                let fan: Vec<[u32; 3]> = rest.windows(2).map(|pair| [first, pair[0], pair[1]]).collect();
                let points: Vec<DVec3> =
                    corners.iter().map(|c| Vec3::from(positions[*c as usize]).as_dvec3()).collect();
                let Some(plane) = Plane::of(&points) else {
                    self.crossing +=
                        usize::from(fan.iter().any(|t| !is_sliver(t.map(|c| positions[c as usize]))));
                    return self.triangles.extend(fan);
                };
                if plane.is_convex(&points)
                    && fan.iter().all(|t| plane.faces(t.map(|c| positions[c as usize])))
                {
                    return self.triangles.extend(fan);
                }
                let outline: Vec<DVec2> = points.iter().map(|p| plane.project(*p)).collect();
                match concave::triangulate(&outline) {
                    Some(inside) => {
                        self.triangles.extend(inside.iter().map(|t| t.map(|corner| corners[corner])))
                    }
                    None => {
                        self.crossing += 1;
                        self.triangles.extend(fan);
                    }
                }
            }
        }
    }

    /// What to tell the user of faces that were no proper polygons.
    pub fn notes(&self) -> Vec<String> {
        let degenerate =
            format!("ignored {} with fewer than three corners", counted(self.degenerate, "face", "faces"));
        let crossing = format!(
            "the outlines of {} cross themselves or have no inside; triangulated as fans, which may overlap",
            counted(self.crossing, "face", "faces")
        );
        let notes = [(self.degenerate, degenerate), (self.crossing, crossing)];
        notes.into_iter().filter_map(|(count, note)| (count > 0).then_some(note)).collect()
    }
}

/// The plane that a polygon lies in or near.
struct Plane {
    origin: DVec3,
    /// Unit vector towards the side from which the polygon runs counter-clockwise.
    normal: DVec3,
    /// Unit vectors in the plane, with `u × v` the normal.
    u: DVec3,
    v: DVec3,
    /// Of the polygon's largest extent from its first corner.
    scale: f64,
}

impl Plane {
    /// By Newell's normal, which weighs all corners; none where it vanishes.
    fn of(points: &[DVec3]) -> Option<Self> {
        let origin = *points.first()?;
        let size = points.iter().map(|p| (*p - origin).abs().max_element()).fold(0.0, f64::max);
        let next = points.iter().cycle().skip(1);
        let sum: DVec3 =
            points.iter().zip(next).map(|(a, b)| ((*a - origin) / size).cross((*b - origin) / size)).sum();
        // Whatever is not finite ends here, too.
        let normal = (sum.length() > 1e-7).then(|| sum.normalize())?;
        let (u, v) = normal.any_orthonormal_pair();
        let (u, v) = if u.cross(v).dot(normal) > 0.0 { (u, v) } else { (v, u) };
        Some(Self { origin, normal, u, v, scale: 1.0 / size })
    }

    /// In parts of the polygon's size.
    fn project(&self, point: DVec3) -> DVec2 {
        let from_origin = (point - self.origin) * self.scale;
        DVec2::new(from_origin.dot(self.u), from_origin.dot(self.v))
    }

    /// True if the outline turns to the left only, and around once.
    fn is_convex(&self, points: &[DVec3]) -> bool {
        let count = points.len();
        let edge = |i: usize| points[(i + 1) % count] - points[i % count];
        let turn = |i: usize| {
            let (before, after) = (edge(i), edge(i + 1));
            before.cross(after).dot(self.normal).atan2(before.dot(after))
        };
        let turns = (0..count).map(turn).try_fold(0.0, |sum, turn| (turn > -STRAIGHT).then_some(sum + turn));
        turns.is_some_and(|sum| sum < 3.0 * std::f64::consts::PI)
    }

    /// True if the triangle is seen from the same side as the polygon and has an area.
    fn faces(&self, triangle: [[f32; 3]; 3]) -> bool {
        !is_sliver(triangle) && area_vector(triangle).dot(self.normal) > 0.0
    }
}

#[cfg(test)]
#[path = "polygons_tests.rs"]
mod tests;
