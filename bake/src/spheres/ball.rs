//! How much of a ball lies in a solid: exactly, from the triangles that bound the solid.
//!
//! With c the centre and R the radius, the divergence theorem on (x − c)/3 turns the volume of ball ∩ solid
//! into
//!
//! V = ⅓ ∑ d·A + ⅓ R³ Ω,
//!
//! d a triangle's signed distance from c, A the area of the part of it that lies in the ball, Ω the solid
//! angle of the part of the sphere that lies in the solid. Branches wholly in the ball are one product. Ω
//! comes from the circular arcs in which the sphere meets triangles, modulo 4π, and only if it is all or
//! nothing is a winding number needed. So the cost is that of the triangles that the sphere crosses.
//!
//! Wang et al. 2006 integrate over each triangle the space between it and the sphere along lines from the
//! centre, which counts space twice where such a line leaves the solid more than once. This does not: it is
//! exact up to rounding for every closed mesh that does not cross itself.

use super::triangle_tree::TriangleTree;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Centre.
    pub centre: DVec3,
    /// Radius.
    pub radius: f64,
}

/// The part of a ball that lies outside a solid, and how it changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outside {
    /// Volume.
    pub volume: f64,
    /// Area of the sphere outside the solid: the derivative of the volume by the radius.
    pub area: f64,
    /// The derivative of the volume by the centre.
    pub gradient: DVec3,
}

/// Where areas on the sphere are measured from: any unit vector does, best one that no mesh is likely to
/// favour.
const POLE: DVec3 = DVec3::new(2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0);
/// Solid angles this near to none or all may be either.
const DOUBTFUL: f64 = 1e-6;

impl Ball {
    /// A ball.
    pub fn new(centre: DVec3, radius: f64) -> Self {
        Self { centre, radius }
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    /// Whether `point` lies in it.
    pub fn contains(&self, point: DVec3) -> bool {
        (point - self.centre).length_squared() <= self.radius * self.radius
    }

    /// What of it lies outside the solid that `mesh` bounds.
    pub fn outside(&self, mesh: &TriangleTree) -> Outside {
        let mut sums = Sums { z: DVec2::X, ..Sums::default() };
        let radius_squared = self.radius * self.radius;
        mesh.walk(|node| {
            if node.nearest_squared(self.centre) >= radius_squared {
                return false;
            }
            if node.farthest_squared(self.centre) < radius_squared {
                sums.area_vector += node.area_vector;
                sums.moment += node.moment - node.area_vector.dot(self.centre);
                return false;
            }
            if node.second == 0 {
                (node.range.0..node.range.1).for_each(|t| self.add_triangle(mesh, t as usize, &mut sums));
            }
            true
        });
        let inside = self.solid_angle_inside(mesh, &sums);
        let volume = self.volume() - (sums.moment + self.radius.powi(3) * inside) / 3.0;
        // Rounding may leave a hair's breadth less than nothing.
        let volume = volume.max(0.0);
        Outside { volume, area: radius_squared * (2.0 * TAU - inside), gradient: sums.area_vector }
    }

    /// Solid angle, seen from the centre, of the part of the sphere that lies in the solid.
    fn solid_angle_inside(&self, mesh: &TriangleTree, sums: &Sums) -> f64 {
        // Arcs run counter-clockwise about the normals, so they surround what lies outside.
        let angle = (-2.0 * (sums.linear + sums.z.y.atan2(sums.z.x))).rem_euclid(2.0 * TAU);
        if (DOUBTFUL..2.0 * TAU - DOUBTFUL).contains(&angle) {
            return angle;
        }
        let away_from_arcs = -sums.crossings.try_normalize().unwrap_or(POLE);
        let all = mesh.encloses(self.centre + self.radius * away_from_arcs);
        match (all, angle < PI) {
            (true, true) => 2.0 * TAU,
            (false, false) => 0.0,
            _ => angle,
        }
    }

    fn add_triangle(&self, mesh: &TriangleTree, triangle: usize, sums: &mut Sums) {
        let indices = mesh.triangles[triangle];
        let corners = indices.map(|v| mesh.vertices[v as usize] - self.centre);
        let (normal, area) = mesh.planes[triangle];
        let distance = normal.dot(corners[0]);
        let radius_squared = self.radius * self.radius;
        let disc_squared = radius_squared - distance * distance;
        if disc_squared <= 0.0 || area == 0.0 {
            return;
        }
        let inside = corners.map(|v| v.length_squared() <= radius_squared);
        if inside == [true; 3] {
            sums.area_vector += area * normal;
            sums.moment += area * distance;
            return;
        }
        let u = (corners[1] - corners[0]).normalize();
        let circle = Circle::new([u, normal.cross(u), normal], distance, disc_squared.sqrt(), self.radius);
        let mut overlap = Overlap::default();
        for p in 0..3 {
            let q = (p + 1) % 3;
            let ends_inside = [inside[p], inside[q]];
            if let Some(range) = self.roots([indices[p], indices[q]], [corners[p], corners[q]], ends_inside) {
                circle.add_edge([corners[p], corners[q]], range, ends_inside, &mut overlap);
            }
        }
        circle.add_arcs(&corners, &mut overlap);
        sums.area_vector += overlap.area * normal;
        sums.moment += overlap.area * distance;
        // About the nearer pole of the circle, so that small circles stay small; the other differs by whole
        // spheres.
        sums.linear += circle.height.signum() * (1.0 - circle.height.abs()) * overlap.angle / 2.0;
        sums.z = times(sums.z, overlap.z);
        sums.crossings += overlap.crossings;
    }

    /// The parameters in [0, 1] between which the edge lies in the ball; `None` where none of it does. Both
    /// triangles of an edge get the same points: the edge is always solved from its lower vertex.
    fn roots(
        &self,
        [i, j]: [u32; 2],
        [p, q]: [DVec3; 2],
        [p_inside, q_inside]: [bool; 2],
    ) -> Option<[f64; 2]> {
        if p_inside && q_inside {
            return Some([0.0, 1.0]);
        }
        let (start, end) = if i < j { (p, q) } else { (q, p) };
        let edge = end - start;
        let (a, half_b, c) =
            (edge.length_squared(), edge.dot(start), start.length_squared() - self.radius * self.radius);
        let root = (half_b * half_b - a * c).max(0.0).sqrt();
        // Without cancellation.
        let (low, high) = if half_b > 0.0 {
            ((-half_b - root) / a, c / (-half_b - root))
        } else {
            (c / (root - half_b), (root - half_b) / a)
        };
        let (low, high) = if i < j { (low, high) } else { (1.0 - high, 1.0 - low) };
        let low = if p_inside { 0.0 } else { low.clamp(0.0, 1.0) };
        let high = if q_inside { 1.0 } else { high.clamp(0.0, 1.0) };
        // An edge with one end inside crosses, be it by no more than rounding: what enters a triangle must
        // leave it.
        (p_inside || q_inside || low < high).then_some([low, high.max(low)])
    }
}

/// Sums over a solid's triangles.
#[derive(Default)]
struct Sums {
    /// Area vectors of the parts in the ball.
    area_vector: DVec3,
    /// d · A of them.
    moment: f64,
    /// Half of the part of the arcs' solid angle that is a plain sum.
    linear: f64,
    /// A complex number whose argument is half of the rest of it.
    z: DVec2,
    /// Directions of the points where the sphere crosses edges, added.
    crossings: DVec3,
}

/// The circle in which the sphere meets the plane of a triangle.
struct Circle {
    /// Two axes in the plane, and the normal.
    frame: [DVec3; 3],
    /// [`POLE`] in that frame.
    pole: [f64; 3],
    /// Distance of the plane from the centre, along the normal.
    distance: f64,
    /// Radius of the circle.
    radius: f64,
    /// Both again, in radii of the sphere.
    height: f64,
    width: f64,
}

/// What a triangle and the circle's disc share.
struct Overlap {
    /// Area.
    area: f64,
    /// Angle of the circle's arcs in the triangle.
    angle: f64,
    /// A complex number whose argument is half of what the arcs add to the solid angle besides sectors of the
    /// cap.
    z: DVec2,
    /// See [`Sums::crossings`].
    crossings: DVec3,
    /// Where the triangle's boundary, run along counter-clockwise, crosses the circle, in units of its
    /// radius; and whether it leaves the disc there.
    events: [(DVec2, bool); 6],
    /// Number of them.
    count: usize,
    /// Whether the boundary meets the disc at all.
    met: bool,
}

impl Default for Overlap {
    fn default() -> Self {
        let events = [(DVec2::ZERO, false); 6];
        Self { area: 0.0, angle: 0.0, z: DVec2::X, crossings: DVec3::ZERO, events, count: 0, met: false }
    }
}

impl Circle {
    fn new(frame: [DVec3; 3], distance: f64, radius: f64, sphere: f64) -> Self {
        Self {
            frame,
            pole: frame.map(|axis| POLE.dot(axis)),
            distance,
            radius,
            height: distance / sphere,
            width: radius / sphere,
        }
    }

    fn add_edge(
        &self,
        [p, q]: [DVec3; 2],
        [low, high]: [f64; 2],
        [p_inside, q_inside]: [bool; 2],
        overlap: &mut Overlap,
    ) {
        let flat = |x: DVec3| DVec2::new(x.dot(self.frame[0]), x.dot(self.frame[1]));
        let (start, end) = (flat(p), flat(q));
        let (enter, leave) = (start.lerp(end, low), start.lerp(end, high));
        overlap.met = true;
        overlap.area += enter.perp_dot(leave) / 2.0;
        for (at, leaves, happens, t) in [(enter, false, !p_inside, low), (leave, true, !q_inside, high)] {
            if happens {
                overlap.events[overlap.count] = (at / self.radius, leaves);
                overlap.count += 1;
                overlap.crossings += p.lerp(q, t);
            }
        }
    }

    /// Adds the circle's arcs within the triangle: each runs from where its boundary leaves the disc to where
    /// it next enters.
    fn add_arcs(&self, corners: &[DVec3; 3], overlap: &mut Overlap) {
        if !overlap.met {
            // The circle lies in the triangle or beside it.
            overlap.angle = if self.lies_within(corners, 0.0) { TAU } else { 0.0 };
        }
        for i in 0..overlap.count {
            let ((from, leaves), (to, _)) = (overlap.events[i], overlap.events[(i + 1) % overlap.count]);
            if leaves {
                let angle = self.angle(corners, from, to, overlap.count == 2);
                overlap.angle += angle;
                self.add_arc(from, to, angle, overlap);
            }
        }
        overlap.area += overlap.angle * self.radius * self.radius / 2.0;
    }

    /// Counter-clockwise angle between two points of the circle, 0 to 2π. `alone`: no other arc of it lies in
    /// the triangle.
    fn angle(&self, corners: &[DVec3; 3], from: DVec2, to: DVec2, alone: bool) -> f64 {
        let angle = from.perp_dot(to).atan2(from.dot(to));
        // Rounding cannot tell no arc from a whole circle, but the triangle can. Where the sphere touches an
        // edge the points are only good to the square root of rounding, in parts of what may be a small
        // circle; of a lone arc the triangle tells surely up to half a radian.
        let doubtful = if alone { 0.1 } else { 1e-7 };
        let whole = if angle.abs() < doubtful { self.lies_within(corners, 0.9) } else { angle < 0.0 };
        if whole { angle + TAU } else { angle }
    }

    /// The area on the unit sphere between an arc and its chord's great circle as seen from the pole, less
    /// the sector of the cap: two spherical triangles.
    fn add_arc(&self, from: DVec2, to: DVec2, angle: f64, overlap: &mut Overlap) {
        if angle > 2.0 {
            // The chord of a half circle has no great circle of its own.
            let middle = DVec2::from_angle(angle / 2.0).rotate(from);
            self.add_arc(from, middle, angle / 2.0, overlap);
            return self.add_arc(middle, to, angle / 2.0, overlap);
        }
        let (h, s) = (self.height, self.width);
        let [pu, pv, pn] = self.pole;
        let sin = from.perp_dot(to);
        let across = h * h + s * s * from.dot(to);
        let (sum, difference) = (from + to, to - from);
        let triple = h * s * (difference.x * pv - difference.y * pu) + s * s * sin * pn;
        let of_pole = DVec2::new(1.0 + across + 2.0 * h * pn + s * (sum.x * pu + sum.y * pv), triple);
        let of_normal = DVec2::new(1.0 + across + 2.0 * h.abs(), -h.signum() * s * s * sin);
        overlap.z = times(overlap.z, times(of_pole, of_normal));
    }

    /// Whether the circle, made smaller by `share`, lies within the triangle.
    fn lies_within(&self, corners: &[DVec3; 3], share: f64) -> bool {
        let (normal, foot) = (self.frame[2], self.distance * self.frame[2]);
        let reach = if share == 0.0 { 0.0 } else { share * self.radius };
        (0..3).all(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            normal.dot((q - p).normalize().cross(foot - p)) > reach
        })
    }
}

/// Product of complex numbers, scaled to stay within range.
fn times(a: DVec2, b: DVec2) -> DVec2 {
    let product = DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
    let size = product.abs().max_element();
    if size > 0.0 { product / size } else { a }
}
