//! Polygons as triangles, for the formats that have any.

/// Triangles from polygons, and what was not one.
#[derive(Default)]
pub(super) struct Triangulation {
    /// Vertex indices, facing as the polygons do.
    pub triangles: Vec<[u32; 3]>,
    /// Faces with fewer than three corners.
    pub degenerate: usize,
}

impl Triangulation {
    /// Adds a polygon as a fan around its first corner, which is right for convex ones.
    pub fn add(&mut self, corners: &[u32]) {
        let Some((first, rest)) = corners.split_first().filter(|(_, rest)| rest.len() >= 2) else {
            self.degenerate += 1;
            return;
        };
        self.triangles.extend(rest.windows(2).filter_map(|pair| <[u32; 2]>::try_from(pair).ok()).map(|[a, b]| [*first, a, b]));
    }

    /// What to tell the user of faces that were no polygons.
    pub fn note(&self) -> Option<String> {
        (self.degenerate > 0).then(|| format!("ignored {} faces with fewer than three corners", self.degenerate))
    }
}
