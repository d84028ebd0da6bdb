//! Small tensors of light at vertices, made from a seed.

use super::samples::Random;
use half::f16;
use relume_formats::basis::{hemisphere, sh};
use relume_formats::kinds::TransferTensor;
use relume_formats::kinds::transfer_tensor::{
    Block, FACE_SIZE, Meta, ONCE_LIGHT, Once, Source, TWICE_LIGHT, Twice, pairs,
};

/// Functions of a cluster in these tensors: of vertices, of the light, and vectors of light reflected twice.
const RANKS: [usize; 3] = [3, 2, 2];

/// Of two functions of material 0, and what is fixed in three channels.
pub fn sources() -> Vec<Source> {
    let varying = (0..2).map(|basis| Source { material: Some(0), basis, channel: None });
    let fixed = (0..3).map(|channel| Source { material: None, basis: 0, channel: Some(channel) });
    varying.chain(fixed).collect()
}

/// In two clusters, where light is reflected.
pub fn tensors(
    seed: u64,
    vertices: usize,
    columns: usize,
    blocks: &[u32],
    reflections: u32,
) -> TransferTensor {
    let random = &mut Random(seed);
    let [m, n, vectors] = RANKS;
    let sources = if reflections > 1 { sources() } else { Vec::new() };
    let clusters = if reflections > 1 { 2 } else { 0 };
    let meta = Meta {
        vertices: vertices as u32,
        columns: columns as u32,
        blocks: blocks.to_vec(),
        unit: 1.0 / 1024.0,
        rays_per_texel: 4,
        reflections,
        sources: sources.clone(),
        clusters: clusters as u32,
        ranks: if reflections > 1 { [m as u32, n as u32] } else { [0; 2] },
        vectors: if reflections > 2 { vectors as u32 } else { 0 },
    };
    let block = |terms: &u32| {
        let count = *terms as usize * vertices;
        Block {
            indices: (0..count).map(|_| random.below(6 * FACE_SIZE * FACE_SIZE) as u16).collect(),
            scales: (0..vertices * columns).map(|_| f16::from_f32(random.unit())).collect(),
            steps: (0..count * columns).map(|_| random.bits() as i8).collect(),
        }
    };
    let blocks = blocks.iter().map(block).collect();
    let seen = (0..vertices * hemisphere::TEXELS).map(|_| random.bits() as u8).collect();
    let mut halves = |count: usize| (0..count).map(|_| f16::from_f32(random.signed())).collect::<Vec<f16>>();
    let core = halves(clusters * sources.len() * m * n * sh::COUNT);
    let light = halves(clusters * sources.len() * n * ONCE_LIGHT);
    let of_twice = halves(clusters * vectors * TWICE_LIGHT * pairs(&sources).len());
    let mut bytes = |count: usize| (0..count).map(|_| random.bits() as i8).collect::<Vec<i8>>();
    let (shares, of_twice_shares) = (bytes(vertices * sources.len() * m), bytes(vertices * vectors));
    let once = Once { clusters: (0..vertices).map(|v| v as u16 % 2).collect(), shares, core, light };
    let twice = Twice { shares: of_twice_shares, vectors: of_twice };
    TransferTensor {
        meta,
        blocks,
        seen,
        once: (reflections > 1).then_some(once),
        twice: (reflections > 2).then_some(twice),
    }
}
