//! Light that arrives after two reflections.

use super::bands::quads;
use super::clusters::{Members, batches};
use super::dispatches::{Dispatches, uniform};
use super::gpu_data::{Second, Vectors};
use super::{PAIRS, SECOND};
use crate::gpu::{Gpu, Passes};
use relume_formats::kinds::transfer_tensor::{Meta, TWICE_LIGHT, Twice as Stored};
use wgpu::{Buffer, BufferUsages};

/// What reflects twice.
pub(super) struct Twice {
    pairs: Dispatches,
    second: Dispatches,
    bytes: u64,
}

impl Twice {
    /// Of what is `stored`, for bands of vertices with these `members`, each of which finds what arrives in a
    /// buffer of its own, [17, vertices], under this `light`; `weights` is what materials make of pairs.
    pub(super) fn new(
        gpu: &Gpu,
        meta: &Meta,
        stored: &Stored,
        (members, arriving): (&[Members], &[Buffer]),
        (light, weights): (&Buffer, &Buffer),
    ) -> Self {
        let (vectors, pairs) = (meta.vectors as usize, meta.pairs().len());
        // An even number of halves, whatever the pairs.
        let size = TWICE_LIGHT * pairs;
        let lit = (meta.clusters as usize * vectors * size_of::<[f32; 4]>()) as u64;
        let lit = gpu.buffer("light of vectors", lit, BufferUsages::STORAGE);
        let mut twice = Self {
            pairs: Dispatches::new(gpu, PAIRS, "mix_pairs"),
            second: Dispatches::new(gpu, SECOND, "reflect_twice"),
            bytes: 2 * stored.vectors.len() as u64,
        };
        for clusters in batches(meta.clusters, 2 * (vectors * size) as u64, gpu.binding_bytes) {
            let [first, end] = [clusters.start, clusters.end].map(|cluster| cluster * vectors);
            let values = stored.vectors.get(first * size..end * size).unwrap_or_default();
            let count = (end - first) as u32;
            let batch = Vectors { first: first as u32, count, pairs: pairs as u32, words: (size / 2) as u32 };
            let batch = uniform(gpu, "vectors", &batch);
            let buffers = [&batch, &gpu.storage("vectors", values), light, weights, &lit];
            twice.pairs.push(gpu, &buffers, gpu.workgroups(count, 1));
        }
        for (members, arriving) in members.iter().zip(arriving) {
            let shares = gpu.storage("shares", &members.words(&stored.shares, [1, vectors]));
            twice.bytes += shares.size();
            let vertices = members.vertices.len() as u32;
            let of_band = Second { vertices, vectors: vectors as u32, quads: quads(vectors as u32) };
            let of_band = uniform(gpu, "second", &of_band);
            let buffers = [&of_band, &members.tiles, &members.order, &shares, &lit, arriving];
            twice.second.push(gpu, &buffers, gpu.workgroups(members.tile_count, 1));
        }
        twice
    }

    /// Encodes all, which depends on light and materials.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        self.pairs.encode(passes);
        self.second.encode(passes);
    }

    /// Bytes that all passes read.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}
