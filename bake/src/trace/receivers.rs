//! Where light is received: at the vertices of a scene, or beside those on a rim ([`Rims`]), as rays leave
//! them.

use super::world::rounding_of;
use glam::Vec3A;
use relume_formats::shape::Rims;
use relume_scenes::{Mesh, Scene};

/// Where light is received.
#[derive(Debug, Clone, Copy)]
pub struct Receiver {
    /// Where rays start: off the surface by what rounding may do, metres.
    pub origin: Vec3A,
    /// Unit shading normal.
    pub normal: Vec3A,
}

/// Where the vertices of a mesh receive light, in its space.
pub fn places(mesh: &Mesh) -> Vec<[f32; 3]> {
    Rims::new(mesh.positions.len(), &mesh.triangles).received(&mesh.positions)
}

/// Every vertex of every object, in the order of kind `scene`.
pub fn receivers(scene: &Scene) -> Vec<Receiver> {
    let mut receivers = Vec::new();
    for object in &scene.objects {
        let mesh = &object.mesh;
        let corners: Vec<Vec3A> = mesh.positions.iter().map(|p| Vec3A::from(*p)).collect();
        let rounding = rounding_of(&corners);
        receivers.extend(places(mesh).iter().zip(&mesh.normals).map(|(place, normal)| {
            let normal = Vec3A::from(*normal);
            Receiver { origin: Vec3A::from(*place) + normal * rounding, normal }
        }));
    }
    receivers
}

/// The vertices of every triangle of every object, in the order of [`receivers`] and of
/// [`Meeting::triangle`](super::world::Meeting::triangle).
pub fn triangles(scene: &Scene) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    for object in &scene.objects {
        triangles.extend(object.mesh.triangles.iter().map(|t| t.map(|corner| corner + first)));
        first += object.mesh.positions.len() as u32;
    }
    triangles
}
