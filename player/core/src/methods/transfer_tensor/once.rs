//! Light that arrives after one reflection: the light on the functions of clusters, what these send, and what of
//! it arrives at vertices.
//!
//! The first two depend on the light alone, and materials come in at the end: a material that changes costs the
//! pass over vertices and no more.

use super::bands::quads;
use super::clusters::{Members, batches};
use super::dispatches::{Dispatches, uniform};
use super::gpu_data::{Batch, Bounce};
use super::{BOUNCE, CORE, PROJECT};
use crate::gpu::{Gpu, Passes};
use relume_formats::basis::sh;
use relume_formats::kinds::transfer_tensor::{Meta, ONCE_LIGHT, Once as Stored};
use std::ops::Range;
use wgpu::{Buffer, BufferUsages};

/// Rows of a workgroup that projects, lanes of a workgroup, and workgroups of a tile, as in the shaders.
const ROWS: u32 = 4;
const LANES: u32 = 64;
const PARTS: u32 = 4;
/// Lanes that share a function of vertices.
const PAIRS: u32 = sh::COUNT as u32 / 2;

/// What reflects once.
pub(super) struct Once {
    project: Dispatches,
    core: Dispatches,
    bounce: Dispatches,
    bytes: u64,
}

/// Bytes of what clusters send: four floats for each harmonic of each function of vertices.
fn function_bytes(meta: &Meta) -> u64 {
    let functions =
        u64::from(meta.clusters) * meta.sources.len() as u64 * u64::from(4 * quads(meta.ranks[0]));
    functions * (sh::COUNT * size_of::<[f32; 4]>()) as u64
}

/// The same of the light on their functions of it.
fn light_bytes(meta: &Meta) -> u64 {
    let functions = u64::from(meta.clusters) * meta.sources.len() as u64 * u64::from(meta.ranks[1]);
    functions * size_of::<[f32; 4]>() as u64
}

/// Bytes of the largest thing that is in one piece whatever the bands.
pub(super) fn largest_bytes(meta: &Meta) -> u64 {
    function_bytes(meta).max(light_bytes(meta))
}

impl Once {
    /// Of what is `stored`, for bands of vertices with these `members`, each of which finds what arrives in a
    /// buffer of its own, [17, vertices], under this `light`; `weights` is what materials make of sources.
    pub(super) fn new(
        gpu: &Gpu,
        meta: &Meta,
        stored: &Stored,
        (members, arriving): (&[Members], &[Buffer]),
        (light, weights): (&Buffer, &Buffer),
    ) -> Self {
        let sources = meta.sources.len();
        let [m, n] = meta.ranks.map(|rank| rank as usize);
        let lit = gpu.buffer("light of clusters", light_bytes(meta), BufferUsages::STORAGE);
        let functions = gpu.buffer("functions", function_bytes(meta), BufferUsages::STORAGE);
        let mut once = Self {
            project: Dispatches::new(gpu, PROJECT, "project"),
            core: Dispatches::new(gpu, CORE, "mix_light"),
            bounce: Dispatches::new(gpu, BOUNCE, "reflect_once"),
            bytes: 2 * (stored.light.len() + stored.core.len()) as u64 + function_bytes(meta),
        };
        let cluster_bytes = 2 * sources * n * ONCE_LIGHT.max(m * sh::COUNT);
        for clusters in batches(meta.clusters, cluster_bytes as u64, gpu.binding_bytes) {
            once.add_clusters(gpu, meta, stored, clusters, [light, &lit, &functions]);
        }
        for (members, arriving) in members.iter().zip(arriving) {
            let shares = gpu.storage("shares", &members.words(&stored.shares, [sources, m]));
            once.bytes += shares.size();
            let vertices = members.vertices.len() as u32;
            let of_band = Bounce { vertices, sources: sources as u32, quads: quads(m as u32) };
            let of_band = uniform(gpu, "bounce", &of_band);
            let (tiles, order) = (&members.tiles, &members.order);
            let buffers = [&of_band, tiles, order, &shares, &functions, weights, arriving];
            once.bounce.push(gpu, &buffers, gpu.workgroups(members.tile_count * PARTS, 1));
        }
        once
    }

    fn add_clusters(
        &mut self,
        gpu: &Gpu,
        meta: &Meta,
        stored: &Stored,
        clusters: Range<usize>,
        [light, lit, functions]: [&Buffer; 3],
    ) {
        let sources = meta.sources.len();
        let [m, n] = meta.ranks.map(|rank| rank as usize);
        let of = |size: usize| clusters.start * sources * size..clusters.end * sources * size;
        let first = uniform(gpu, "first row", &(of(n).start as u32));
        let rows = gpu.storage("rows", stored.light.get(of(n * ONCE_LIGHT)).unwrap_or_default());
        let workgroups = gpu.workgroups((of(n).len() as u32).div_ceil(ROWS), 1);
        self.project.push(gpu, &[&first, &rows, light, lit], workgroups);
        let batch = Batch {
            first: of(m).start as u32,
            count: of(m).len() as u32,
            vertex_rank: m as u32,
            vertex_room: 4 * quads(m as u32),
            light_rank: n as u32,
        };
        let values = gpu.storage("core", stored.core.get(of(m * n * sh::COUNT)).unwrap_or_default());
        let buffers = [&uniform(gpu, "batch", &batch), &values, lit, functions];
        self.core.push(gpu, &buffers, gpu.workgroups(batch.count * PAIRS, LANES));
    }

    /// Encodes what depends on the light alone.
    pub(super) fn encode_light(&self, passes: &mut Passes<'_>) {
        self.project.encode(passes);
        self.core.encode(passes);
    }

    /// Encodes what depends on materials, too.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        self.bounce.encode(passes);
    }

    /// Bytes that all passes read.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}
