//! Clusters of vertices on the GPU: of each a range that no more than fits into bindings is stored for, and the
//! vertices of each band in the order of their clusters, so that lanes side by side have the same functions.

use super::bands::TILE;
use super::gpu_data::Tile;
use crate::gpu::Gpu;
use std::ops::Range;
use wgpu::Buffer;

/// The vertices of a band by cluster.
pub(super) struct Members {
    /// [vertices of the band] which of the scene comes where.
    pub(super) vertices: Vec<u32>,
    /// Tiles of one cluster.
    pub(super) tiles: Buffer,
    pub(super) tile_count: u32,
    /// [vertices of the band] which of the band comes where.
    pub(super) order: Buffer,
}

impl Members {
    /// Those of a `band` of vertices, of which `clusters` says where they belong.
    pub(super) fn new(gpu: &Gpu, band: &Range<u32>, clusters: &[u16]) -> Self {
        let cluster = |vertex: &u32| clusters.get(*vertex as usize).copied().unwrap_or_default();
        let mut vertices: Vec<u32> = band.clone().collect();
        vertices.sort_by_key(cluster);
        let tiles = tiles(vertices.iter().map(cluster));
        let order: Vec<u32> = vertices.iter().map(|vertex| vertex - band.start).collect();
        Self {
            tile_count: tiles.len() as u32,
            tiles: gpu.storage("tiles of clusters", &tiles),
            order: gpu.storage("order of clusters", &order),
            vertices,
        }
    }

    /// [rows, words, vertices in their order] four numbers a word of `shares`, [vertices of the scene, `rows`,
    /// `columns`].
    pub(super) fn words(&self, shares: &[i8], [rows, columns]: [usize; 2]) -> Vec<u32> {
        let share = |vertex: u32, row: usize, column: usize| {
            let at = (vertex as usize * rows + row) * columns + column;
            (column < columns).then(|| shares.get(at)).flatten().copied().unwrap_or(0)
        };
        let words = (0..rows).flat_map(|row| (0..columns.div_ceil(4)).map(move |word| (row, word)));
        let word = |(row, word): (usize, usize)| {
            self.vertices.iter().map(move |vertex| {
                u32::from_le_bytes([0, 1, 2, 3].map(|k| share(*vertex, row, 4 * word + k) as u8))
            })
        };
        words.flat_map(word).collect()
    }
}

/// Cuts runs of the same cluster into tiles.
fn tiles(clusters: impl Iterator<Item = u16>) -> Vec<Tile> {
    let mut tiles: Vec<Tile> = Vec::new();
    for (place, cluster) in (0..).zip(clusters) {
        match tiles.last_mut().filter(|tile| tile.cluster == u32::from(cluster) && tile.count < TILE) {
            Some(tile) => tile.count += 1,
            None => tiles.push(Tile { cluster: cluster.into(), first: place, count: 1 }),
        }
    }
    tiles
}

/// Ranges of `clusters` clusters of which `bytes` bytes each are stored in one piece of at most `limit`; of one
/// at least.
pub(super) fn batches(clusters: u32, bytes: u64, limit: u64) -> impl Iterator<Item = Range<usize>> {
    let most = (limit / bytes.max(1)).clamp(1, u64::from(clusters.max(1))) as usize;
    let clusters = clusters as usize;
    (0..clusters).step_by(most).map(move |first| first..(first + most).min(clusters))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_of_one_cluster_and_at_most_full() {
        let clusters = [vec![0; 64], vec![1; 65], vec![3; 2]].concat();
        let expected = [(0, 0, 64), (1, 64, 64), (1, 128, 1), (3, 129, 2)];
        let found = tiles(clusters.into_iter());
        assert_eq!(found, expected.map(|(cluster, first, count)| Tile { cluster, first, count }));
    }

    #[test]
    fn batches_are_no_larger_than_bindings() {
        let of = |clusters, limit| batches(clusters, 100, limit).collect::<Vec<_>>();
        assert_eq!(of(5, 500).len(), 1);
        assert_eq!(of(5, 299), [0..2, 2..4, 4..5]);
        assert_eq!(of(2, 1), [0..1, 1..2]);
        assert_eq!(of(0, 1000), []);
    }
}
