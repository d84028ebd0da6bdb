//! A scene prepared for rays: all triangles in one hierarchy, with what a hit needs to know.
//!
//! Inside, lengths are scaled by a power of two so that the scene is some 2¹⁴ units large. That costs no
//! rounding and makes every decision independent of the scene's scale.

use super::coating::Coatings;
use super::coordinates::Coordinates;
use super::spans::{Eye, TexelSet};
use super::spot::Spot;
use super::triangle::TriangleHit;
use super::wide::{Found, Wide};
use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use relume_scenes::painting::Painting;
use relume_scenes::{Emitter, Mesh, Scene};
use std::cell::Cell;
use std::collections::HashMap;

thread_local! {
    /// Rays that this thread has traced since it was last asked.
    static RAYS: Cell<u64> = const { Cell::new(0) };
}

/// How many rays the calling thread has traced since its last call.
pub fn take_ray_count() -> u64 {
    RAYS.take()
}

/// Makes every thread's count start at 0.
pub fn reset_ray_counts() {
    rayon::broadcast(|_| RAYS.set(0));
    RAYS.set(0);
}

/// What a triangle belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// A surface wearing the material of this index.
    Material(u32),
    /// The area light of this index; it emits on its front and reflects nothing.
    Light(u32),
}

/// A point of an area light or of a mesh that emits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnLight {
    /// Index of the light.
    pub light: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentric: [f32; 2],
}

/// All triangles of a scene in one bounding volume hierarchy.
pub struct World {
    hierarchy: Wide,
    /// In the order of the hierarchy's leaves.
    normals: Vec<[Vec3A; 3]>,
    owners: Vec<Owner>,
    /// For triangles that emit the light, and their index in its mesh.
    lights: Vec<Option<[u32; 2]>>,
    coatings: Coatings,
    coordinates: Coordinates,
    /// Hierarchy units per metre: a power of two.
    units_per_metre: f32,
    /// Half the diagonal of the geometry's bounding box, metres.
    pub radius: f32,
}

/// A point on a surface that a ray found.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// World space.
    pub position: Vec3A,
    /// Unit normal of the triangle, on the side that the ray came from.
    pub geometric_normal: Vec3A,
    /// Unit shading normal, within the hemisphere of the geometric one.
    pub shading_normal: Vec3A,
    /// Whose it is.
    pub owner: Owner,
    /// Where on a light it is, if its front emits.
    pub light: Option<OnLight>,
    /// What a texture multiplies the diffuse colour with; 1 without one.
    pub albedo: Vec3A,
    /// Where it is in the textures that are painted on its material; [`super::spot::UNPAINTED`] if none are.
    pub uv: [f32; 2],
    /// True if the ray came from the front.
    pub front: bool,
    /// Unit direction to where the ray came from.
    pub outgoing: Vec3A,
    /// How far rounding may have moved the point off its triangle, metres.
    pub rounding: f32,
}

/// Where a ray meets a triangle of the scene.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// Its number, counting the triangles of all objects in their order, then those of lights.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub barycentric: [f32; 2],
    /// True if the ray came from the front.
    pub front: bool,
    /// Whose it is.
    pub owner: Owner,
    /// What a texture multiplies the diffuse colour with; 1 without one.
    pub albedo: Vec3A,
}

impl Surface {
    /// What BRDFs know of it, if it wears the material of this index.
    pub fn spot(&self, material: u32) -> Spot {
        Spot { material, albedo: self.albedo, uv: self.uv }
    }

    /// Where a ray that leaves the surface may start without meeting it again.
    pub fn offset(&self) -> Vec3A {
        self.position + self.geometric_normal * self.rounding
    }
}

/// Rounding errors of a hit point and of tests against it, relative to the largest coordinate. A hit point is
/// a sum of three products and a ray test subtracts it from vertices, each off by at most a few 2⁻²⁴; 2⁻¹⁸
/// leaves a factor of about ten.
const ROUNDING: f32 = 1.0 / 262_144.0;

/// Binary logarithm of the scene's size in hierarchy units.
const EXTENT_LOG2: f32 = 14.0;

/// How far rounding may move a point computed on the triangle or parallelogram with these corners, metres.
pub fn rounding_of(corners: &[Vec3A]) -> f32 {
    ROUNDING * corners.iter().fold(0.0, |m: f32, v| m.max(v.abs().max_element()))
}

impl World {
    /// Builds the hierarchy.
    pub fn new(scene: &Scene) -> Self {
        Self::painted(scene, &[])
    }

    /// The same, with where surfaces are in the textures of `paintings`. These may be of another pose: an object
    /// has the same triangles in all of them.
    pub fn painted(scene: &Scene, paintings: &[Painting]) -> Self {
        let mut given = Given::default();
        let mut light_of: Vec<Option<u32>> = vec![None; scene.objects.len()];
        for (index, light) in (0..).zip(&scene.lights) {
            if let Emitter::Mesh { object, .. } = light.emitter {
                light_of[object] = Some(index);
            }
        }
        for (object, light) in scene.objects.iter().zip(light_of) {
            given.add(&object.mesh, Owner::Material(object.material as u32), light);
        }
        for (index, light) in (0..).zip(&scene.lights) {
            if let Emitter::Area { corner, edge_u, edge_v, .. } = light.emitter {
                given.add(&parallelogram(corner, edge_u, edge_v), Owner::Light(index), Some(index));
            }
        }
        let on_triangles = (Coatings::new(scene), Coordinates::new(scene, paintings));
        Self::from_triangles(given, on_triangles, Vec3A::from(scene.camera.position))
    }

    fn from_triangles(
        Given { triangles, normals, owners, lights }: Given,
        (coatings, coordinates): (Coatings, Coordinates),
        eye: Vec3A,
    ) -> Self {
        // What rounding errors are relative to.
        let extent =
            triangles.iter().flatten().fold(eye.abs().max_element(), |m, v| m.max(v.abs().max_element()));
        let bounds = Aabb::from_points(triangles.as_flattened());
        let radius = if triangles.is_empty() { 0.0 } else { 0.5 * bounds.diagonal().length() };
        let exponent = (EXTENT_LOG2 - extent.max(f32::MIN_POSITIVE).log2().ceil()).clamp(-100.0, 100.0);
        let units_per_metre = exponent.exp2();
        let triangles: Vec<[Vec3A; 3]> = triangles.iter().map(|t| t.map(|v| v * units_per_metre)).collect();
        // Boxes grow by more than the rounding errors of a box test, so that no ray misses the box of a
        // triangle it hits.
        let boxes = padded(&triangles, extent * units_per_metre * ROUNDING);
        let hierarchy = Wide::new(&triangles, &boxes);
        let order = hierarchy.order.iter().map(|i| *i as usize);
        Self {
            normals: order.clone().map(|i| normals[i]).collect(),
            owners: order.clone().map(|i| owners[i]).collect(),
            lights: order.map(|i| lights[i]).collect(),
            coatings: coatings.reordered(&hierarchy.order),
            coordinates: coordinates.reordered(&hierarchy.order),
            hierarchy,
            units_per_metre,
            radius,
        }
    }

    /// The nearest surface along the ray. `direction` must be a unit vector.
    pub fn intersect(&self, origin: Vec3A, direction: Vec3A) -> Option<Surface> {
        self.nearest(origin, direction).map(|found| self.surface(&found, direction))
    }

    /// The triangle that the nearest surface along the ray belongs to, and where on it. `direction` must be a
    /// unit vector.
    pub fn meet(&self, origin: Vec3A, direction: Vec3A) -> Option<Meeting> {
        Some(self.meeting(&self.nearest(origin, direction)?, direction))
    }

    /// What a ray along `direction` meets.
    fn meeting(&self, found: &Found, direction: Vec3A) -> Meeting {
        let (owner, albedo) = self.owner(found);
        Meeting {
            triangle: self.hierarchy.order[found.number() as usize],
            barycentric: found.hit.barycentric,
            front: face(&self.hierarchy.triangle(found)).dot(direction) <= 0.0,
            owner,
            albedo,
        }
    }

    /// The nearest triangle along the ray.
    fn nearest(&self, origin: Vec3A, direction: Vec3A) -> Option<Found> {
        RAYS.set(RAYS.get() + 1);
        let origin = origin * self.units_per_metre;
        self.hierarchy.nearest(origin, direction, |triangle, hit| self.is_solid(triangle, hit))
    }

    /// Whether anything stands in the way from `from` along the unit vector `direction`, nearer than
    /// `distance`.
    pub fn occluded(&self, from: Vec3A, direction: Vec3A, distance: f32) -> bool {
        RAYS.set(RAYS.get() + 1);
        let (from, distance) = (from * self.units_per_metre, distance * self.units_per_metre);
        self.hierarchy.occluded(from, direction, distance, |triangle, hit| self.is_solid(triangle, hit))
    }

    /// Leaves of `texels` those before which nothing stands, as [`World::occluded`] has it for a ray through
    /// each from `eye`, metres.
    pub fn see(&self, eye: Eye<'_>, texels: &mut TexelSet) {
        RAYS.set(RAYS.get() + texels.count() as u64);
        let eye = Eye { origin: eye.origin * self.units_per_metre, ..eye };
        let is_solid = |triangle: u32, hit: &TriangleHit| self.is_solid(triangle, hit);
        self.hierarchy.see(eye, texels, |triangle| self.may_have_holes(triangle), is_solid);
    }

    /// What the rays from `eye`, metres, through the `asked` texels meet, texel by texel, as [`World::meet`]
    /// has it.
    pub fn meet_all(&self, eye: Eye<'_>, asked: &TexelSet) -> Vec<(usize, Meeting)> {
        RAYS.set(RAYS.get() + asked.count() as u64);
        let eye = Eye { origin: eye.origin * self.units_per_metre, ..eye };
        let is_solid = |triangle: u32, hit: &TriangleHit| self.is_solid(triangle, hit);
        let found =
            self.hierarchy.nearest_of_texels(eye, asked, |triangle| self.may_have_holes(triangle), is_solid);
        let meeting = |(texel, found): (usize, Option<Found>)| {
            Some((texel, self.meeting(&found?, eye.rays.directions()[texel])))
        };
        found.into_iter().enumerate().filter_map(meeting).collect()
    }

    /// Whether a ray may pass through a triangle that it hits, as far as is known.
    fn may_have_holes(&self, triangle: u32) -> bool {
        match self.owners[triangle as usize] {
            Owner::Material(material) => self.coatings.may_have_holes(material),
            Owner::Light(_) => false,
        }
    }

    /// Whether a triangle has no hole where a ray meets it.
    fn is_solid(&self, triangle: u32, hit: &TriangleHit) -> bool {
        match self.owners[triangle as usize] {
            Owner::Material(material) => self.coatings.is_solid(material, triangle, hit.barycentric),
            Owner::Light(_) => true,
        }
    }

    /// Whose a triangle is, and what a texture multiplies the diffuse colour with.
    fn owner(&self, found: &Found) -> (Owner, Vec3A) {
        let (number, weights) = (found.number(), found.hit.barycentric);
        let owner = self.owners[number as usize];
        let albedo = match owner {
            Owner::Material(material) => self.coatings.albedo(material, number, weights),
            Owner::Light(_) => Vec3A::ONE,
        };
        (owner, albedo)
    }

    fn surface(&self, found: &Found, direction: Vec3A) -> Surface {
        let (triangle, [v, w]) = (found.number() as usize, found.hit.barycentric);
        let [a, b, c] = self.hierarchy.triangle(found);
        let [na, nb, nc] = self.normals[triangle];
        let u = 1.0 - v - w;
        let face = face(&[a, b, c]);
        let front = face.dot(direction) <= 0.0;
        let geometric_normal = if front { face } else { -face };
        let smooth = (na * u + nb * v + nc * w).normalize_or(face) * if front { 1.0 } else { -1.0 };
        let shading_normal = if smooth.dot(geometric_normal) > 0.0 { smooth } else { geometric_normal };
        let metres_per_unit = 1.0 / self.units_per_metre;
        let position = (a * u + b * v + c * w) * metres_per_unit;
        let rounding = rounding_of(&[a, b, c]) * metres_per_unit;
        let (owner, albedo) = self.owner(found);
        let light =
            self.lights[triangle].map(|[light, triangle]| OnLight { light, triangle, barycentric: [v, w] });
        Surface {
            position,
            geometric_normal,
            shading_normal,
            owner,
            light,
            albedo,
            uv: self.coordinates.at(found.number(), found.hit.barycentric),
            front,
            outgoing: -direction,
            rounding,
        }
    }
}

/// Unit normal of a triangle.
fn face([a, b, c]: &[Vec3A; 3]) -> Vec3A {
    (*b - *a).cross(*c - *a).normalize_or(Vec3A::Y)
}

/// Triangles before they are in a hierarchy, objects first.
#[derive(Default)]
struct Given {
    triangles: Vec<[Vec3A; 3]>,
    normals: Vec<[Vec3A; 3]>,
    owners: Vec<Owner>,
    lights: Vec<Option<[u32; 2]>>,
}

impl Given {
    fn add(&mut self, mesh: &Mesh, owner: Owner, light: Option<u32>) {
        for (index, corner) in (0..).zip(&mesh.triangles) {
            self.triangles.push(corner.map(|i| Vec3A::from(mesh.positions[i as usize])));
            self.normals.push(corner.map(|i| Vec3A::from(mesh.normals[i as usize])));
            self.owners.push(owner);
            self.lights.push(light.map(|light| [light, index]));
        }
    }
}

fn parallelogram(corner: [f32; 3], edge_u: [f32; 3], edge_v: [f32; 3]) -> Mesh {
    let [p, u, v] = [corner, edge_u, edge_v].map(Vec3A::from);
    let positions = [p, p + u, p + u + v, p + v].map(|p| p.to_array()).to_vec();
    let normals = vec![u.cross(v).normalize().to_array(); 4];
    Mesh { positions, normals, uvs: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// The boxes of triangles, padded by at least `pad`. Of triangles that coincide each has a little more, for
/// equal boxes in their thousands make the builder's tree as deep as they are many.
fn padded(triangles: &[[Vec3A; 3]], pad: f32) -> Vec<Padded> {
    let mut met: HashMap<[u32; 9], u32> = HashMap::new();
    let more = |triangle: &[Vec3A; 3]| {
        let corners = triangle.map(|corner| corner.to_array().map(f32::to_bits));
        let before = met.entry(std::array::from_fn(|k| corners[k / 3][k % 3])).or_default();
        *before += 1;
        // Numbers without order in [0, 1), the first of them 0.
        ((*before - 1).wrapping_mul(0x9E37_79B9) >> 8) as f32 / (1 << 24) as f32
    };
    let more: Vec<f32> = triangles.iter().map(more).collect();
    triangles
        .iter()
        .zip(more)
        .map(|(triangle, more)| Padded { triangle: *triangle, pad: pad * (1.0 + more) })
        .collect()
}

struct Padded {
    triangle: [Vec3A; 3],
    pad: f32,
}

impl Boundable for Padded {
    fn aabb(&self) -> Aabb {
        let tight = Aabb::from_points(&self.triangle);
        Aabb::new(tight.min - self.pad, tight.max + self.pad)
    }
}

#[cfg(test)]
mod tests;
