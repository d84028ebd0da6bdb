//! Textures on the triangles of a world: colours, and holes.

use glam::{Vec2, Vec3A};
use relume_scenes::{Scene, Texture};
use std::sync::Arc;

/// The textures of all materials, and where they lie on the triangles.
pub(super) struct Coatings {
    /// By material.
    materials: Vec<Option<Coating>>,
    /// By triangle; empty if no material has a texture.
    uvs: Vec<[Vec2; 3]>,
}

struct Coating {
    texture: Arc<Texture>,
    alpha_cutoff: Option<f32>,
}

impl Coatings {
    /// The coatings of `scene`, triangles in the order of its objects. Triangles of no object, which come
    /// after, have none.
    pub fn new(scene: &Scene) -> Self {
        let coating = |m: &relume_scenes::Material| {
            m.texture
                .as_ref()
                .map(|texture| Coating { texture: texture.clone(), alpha_cutoff: m.alpha_cutoff })
        };
        let materials: Vec<_> = scene.materials.iter().map(coating).collect();
        let mut uvs = Vec::new();
        if materials.iter().any(Option::is_some) {
            for mesh in scene.objects.iter().map(|o| &o.mesh) {
                let uv = |vertex: u32| mesh.uvs.get(vertex as usize).copied().map_or(Vec2::ZERO, Vec2::from);
                uvs.extend(mesh.triangles.iter().map(|t| t.map(uv)));
            }
        }
        Self { materials, uvs }
    }

    /// The same with triangles in another order: the first is now `order[0]`.
    pub fn reordered(self, order: &[u32]) -> Self {
        let uvs = |i: &u32| self.uvs.get(*i as usize).copied().unwrap_or_default();
        let reordered = if self.uvs.is_empty() { Vec::new() } else { order.iter().map(uvs).collect() };
        Self { uvs: reordered, materials: self.materials }
    }

    /// Whether the material's texture has holes anywhere, as far as is known.
    pub fn may_have_holes(&self, material: u32) -> bool {
        self.materials[material as usize].as_ref().is_some_and(|coating| coating.alpha_cutoff.is_some())
    }

    /// False where the material's texture has a hole.
    pub fn is_solid(&self, material: u32, triangle: u32, barycentric: [f32; 2]) -> bool {
        match &self.materials[material as usize] {
            Some(Coating { texture, alpha_cutoff: Some(cutoff) }) => {
                texture.sample(self.uv(triangle, barycentric))[3] >= *cutoff
            }
            _ => true,
        }
    }

    /// Linear colour of the material's texture; 1 without one.
    pub fn albedo(&self, material: u32, triangle: u32, barycentric: [f32; 2]) -> Vec3A {
        match &self.materials[material as usize] {
            Some(Coating { texture, .. }) => {
                let [r, g, b, _] = texture.sample(self.uv(triangle, barycentric));
                Vec3A::new(r, g, b)
            }
            None => Vec3A::ONE,
        }
    }

    fn uv(&self, triangle: u32, [v, w]: [f32; 2]) -> [f32; 2] {
        let [a, b, c] = self.uvs.get(triangle as usize).copied().unwrap_or_default();
        (a * (1.0 - v - w) + b * v + c * w).to_array()
    }
}
