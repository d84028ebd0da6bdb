//! Where the points of a world's triangles are in the textures that are painted on their materials.

use super::spot::UNPAINTED;
use relume_scenes::Scene;
use relume_scenes::painting::{Corners, Painting, within};

/// Texture coordinates of the corners of triangles; where all are alike, there are none.
#[derive(Default)]
pub(super) struct Coordinates {
    /// By triangle; empty if no material is painted.
    corners: Vec<Corners>,
}

impl Coordinates {
    /// Those that `paintings` have of `scene`, triangles in the order of its objects. Triangles of no object,
    /// which come after, have none.
    pub fn new(scene: &Scene, paintings: &[Painting]) -> Self {
        if paintings.is_empty() {
            return Self::default();
        }
        let mut corners = Vec::new();
        for (number, object) in scene.objects.iter().enumerate() {
            let painted =
                paintings.iter().find_map(|painting| painting.of_object(number)).unwrap_or_default();
            corners.extend_from_slice(painted);
            // In every pose an object has the triangles that it has at rest; no more, no less.
            let missing = object.mesh.triangles.len().saturating_sub(painted.len());
            corners.extend(std::iter::repeat_n([UNPAINTED; 3], missing));
        }
        Self { corners }
    }

    /// The same with triangles in another order: the first is now `order[0]`.
    pub fn reordered(self, order: &[u32]) -> Self {
        if self.corners.is_empty() {
            return self;
        }
        let corners = |i: &u32| self.corners.get(*i as usize).copied().unwrap_or([UNPAINTED; 3]);
        Self { corners: order.iter().map(corners).collect() }
    }

    /// Where a point of a triangle is, by the weights of its second and third corner.
    pub fn at(&self, triangle: u32, barycentric: [f32; 2]) -> [f32; 2] {
        self.corners.get(triangle as usize).map_or(UNPAINTED, |corners| within(corners, barycentric))
    }
}
