//! What casts shadows: spheres that follow an object, or some triangles of its mesh.
//!
//! Triangles are those that a bake has left of a mesh; their corners stand before vertices of the scene, along
//! their normals, so they deform as these do. **Which of them block a receiver's view** follows from the height of the receiver above a
//! triangle's plane, on the side of its normal:
//!
//! * A closed mesh blocks others by the triangles that turn away from them: outside they cover the same as those
//!   that face the receiver, and from within they cover everything. Its own receivers, which may lie a little
//!   within the fewer triangles, are blocked by those that face them.
//! * An open one blocks by both sides; so does one whose parts touch, and a room, which receivers may be within.
//! * Of its own object's triangles a receiver leaves out those that it is no higher above than their *error*: the
//!   farthest that a vertex is from the triangle that stands for the surface there. Of others it leaves out
//!   those in whose plane it lies, to [`CONTACT`].

use crate::kinds::sphere_shadows::Casts;
use crate::kinds::{SphereSet, SphereShadows};
use glam::Vec3;

/// Heights above a plane that count as none, in parts of the largest coordinate of the scene: some roundings.
pub const CONTACT: f32 = 1.0 / (1 << 20) as f32;

/// Everything that casts shadows, where it is now.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Casters {
    /// Of each object that casts by spheres.
    pub spheres: Vec<Spheres>,
    /// Of all objects that cast by their meshes.
    pub triangles: Vec<Triangle>,
}

/// The spheres of one object.
#[derive(Debug, Clone, PartialEq)]
pub struct Spheres {
    /// Centre and radius of each now, world space, metres.
    pub now: Vec<[f32; 4]>,
    /// What [`neighbours`] makes of the spheres at rest.
    pub neighbours: Vec<Vec<u32>>,
}

impl Spheres {
    /// The spheres of `set` at rest; [`crate::evaluate::sphere_set::Follower`] says where they are in other
    /// poses.
    pub fn at_rest(set: &SphereSet) -> Self {
        Self { now: set.spheres.clone(), neighbours: neighbours(&set.spheres) }
    }
}

/// For each sphere the spheres that overlap it at rest, itself among them, in order.
pub fn neighbours(rest: &[[f32; 4]]) -> Vec<Vec<u32>> {
    let overlap = |[x, y, z, r]: [f32; 4], [u, v, w, s]: [f32; 4]| {
        Vec3::new(x, y, z).distance_squared(Vec3::new(u, v, w)) < (r + s) * (r + s)
    };
    let of = |(at, sphere): (usize, &[f32; 4])| {
        let near = |(other, _): &(usize, &[f32; 4])| *other == at || overlap(*sphere, rest[*other]);
        rest.iter().enumerate().filter(near).map(|(other, _)| other as u32).collect()
    };
    rest.iter().enumerate().map(of).collect()
}

/// From which heights above its plane a triangle counts: from those beyond either.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// Above it, on the side of its normal; infinite if it does not count from there.
    pub above: f32,
    /// Below it.
    pub below: f32,
}

impl Sides {
    /// Whether it counts from `height`; from no number it does not.
    #[inline(always)]
    pub fn count_from(&self, height: f32) -> bool {
        (height > self.above) | (-height > self.below)
    }
}

/// A triangle that casts a shadow, where it is now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// World space, metres.
    pub corners: [[f32; 3]; 3],
    /// Of unit length, to the side from which the corners are seen counter-clockwise; no number if it has no
    /// area.
    pub normal: [f32; 3],
    /// The object that it is of, in the order of the scene.
    pub object: u32,
    /// From where it counts for receivers of its own object, and for others.
    pub sides: [Sides; 2],
}

impl Triangle {
    /// How high `position` is above its plane, metres.
    #[inline(always)]
    pub(crate) fn height(normal: [f32; 3], first_corner_from_position: [f32; 3]) -> f32 {
        let ([x, y, z], [u, v, w]) = (normal, first_corner_from_position);
        -(x * u + y * v + z * w)
    }
}

/// The triangles of a scene that cast shadows, by their vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CasterMeshes {
    triangles: Vec<CasterTriangle>,
}

/// A triangle by its vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CasterTriangle {
    /// Vertices of the scene.
    pub vertices: [u32; 3],
    /// How far its corners are before these, along their normals, metres.
    pub offsets: [f32; 3],
    /// The object that it is of.
    pub object: u32,
    /// From where it counts for receivers of its own object, and for others.
    pub sides: [Sides; 2],
}

impl CasterMeshes {
    /// Those of `shadows`, with the vertices of the scene at `positions` at rest.
    pub fn new(shadows: &SphereShadows, positions: &[[f32; 3]]) -> Self {
        let largest = positions.as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
        let contact = CONTACT * largest;
        let mut triangles = Vec::new();
        let mut stored = shadows.casters.iter().zip(&shadows.caster_offsets).zip(&shadows.caster_errors);
        for (number, object) in (0..).zip(&shadows.meta.objects) {
            let Casts::Mesh { triangles: count, closed } = object.casts else { continue };
            triangles.extend(stored.by_ref().take(count as usize).map(|((vertices, offsets), error)| {
                let error = error.max(contact);
                let both = |height| Sides { above: height, below: height };
                let sides = if closed {
                    [
                        Sides { above: error, below: f32::INFINITY },
                        Sides { above: f32::INFINITY, below: contact },
                    ]
                } else {
                    [both(error), both(contact)]
                };
                CasterTriangle { vertices: *vertices, offsets: *offsets, object: number, sides }
            }));
        }
        Self { triangles }
    }

    /// All of them, object by object.
    pub fn triangles(&self) -> &[CasterTriangle] {
        &self.triangles
    }

    /// Writes where they are with the vertices of the scene at `positions`, with unit `normals`, over `out`. What
    /// names vertices beyond these is left out.
    pub fn place(&self, positions: &[[f32; 3]], normals: &[[f32; 3]], out: &mut Vec<Triangle>) {
        let corner = |vertex: u32, offset: f32| {
            let (position, normal) = (positions.get(vertex as usize)?, normals.get(vertex as usize)?);
            Some(Vec3::from(*position) + offset * Vec3::from(*normal))
        };
        let placed = |triangle: &CasterTriangle| {
            let CasterTriangle { vertices: [a, b, c], offsets: [d, e, f], object, sides } = *triangle;
            let corners = [corner(a, d)?, corner(b, e)?, corner(c, f)?];
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let normal = (normal / normal.length()).to_array();
            Some(Triangle { corners: corners.map(|corner| corner.to_array()), normal, object, sides })
        };
        out.clear();
        out.extend(self.triangles.iter().filter_map(placed));
    }
}
