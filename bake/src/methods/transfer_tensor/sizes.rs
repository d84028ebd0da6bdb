//! Bytes on disk of what a file has, about.

use relume_formats::basis::{hemisphere, sh};
use relume_formats::kinds::transfer_tensor::{ONCE_LIGHT, TWICE_LIGHT};

/// Bytes on disk of a stored number, in parts of what it takes in memory: indices, bytes, halves, what is seen;
/// from bundles of the library's scenes.
const INDEX: f64 = 0.62;
const VALUE: f64 = 0.55;
const HALF: f64 = 0.93;
const SEEN: f64 = 0.25;

/// What the tensors of a scene are of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Number of vertices.
    pub vertices: f64,
    /// Columns of direct light.
    pub columns: f64,
    /// Clusters of vertices.
    pub clusters: f64,
    /// Sources of reflected light.
    pub sources: f64,
    /// Their pairs.
    pub pairs: f64,
}

impl Sizes {
    /// Direct light of so many terms, without what vertices see.
    pub fn of_terms(&self, terms: usize) -> f64 {
        self.vertices * terms as f64 * (2.0 * INDEX + self.columns * VALUE)
    }

    /// What vertices see.
    pub fn of_seen(&self) -> f64 {
        self.vertices * hemisphere::TEXELS as f64 * SEEN
    }

    /// Light after one reflection, by so many functions of vertices and of light.
    pub fn of_ranks(&self, ranks: [usize; 2]) -> f64 {
        let [m, n] = ranks.map(|rank| rank as f64);
        let of_clusters = self.clusters * n * (m * sh::COUNT as f64 + ONCE_LIGHT as f64) * 2.0 * HALF;
        self.sources * (of_clusters + self.vertices * m * VALUE)
    }

    /// Light after two reflections, by so many vectors.
    pub fn of_vectors(&self, vectors: usize) -> f64 {
        let of_clusters = self.clusters * TWICE_LIGHT as f64 * self.pairs * 2.0 * HALF;
        vectors as f64 * (of_clusters + self.vertices * VALUE)
    }
}
