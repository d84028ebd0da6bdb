//! What vertices receive.

use super::Lights;
use crate::basis::sh;
use crate::kinds::TransferTensor;
use crate::kinds::transfer_tensor::{
    FACE_SIZE, ONCE_FACE_SIZE, ONCE_LIGHT, Once, TWICE_FACE_SIZE, TWICE_LIGHT, Twice, weights,
};
use crate::state::Rgb;
use half::f16;

/// What vertices receive, gain included.
#[derive(Debug, Clone)]
pub struct Received {
    /// Direct light without suns by the columns of each vertex's space, row-major [vertices, columns].
    pub direct: Vec<Rgb>,
    /// Radiance after one reflection by spherical harmonics in world space, [vertices].
    pub once: Vec<[Rgb; sh::COUNT]>,
    /// Irradiance over π after two, [vertices].
    pub twice: Vec<Rgb>,
}

/// What the vertices of `transfer` receive of `lights`, where `coefficients` gives those of a material on its basis.
pub fn received(
    transfer: &TransferTensor,
    lights: &Lights,
    coefficients: impl Fn(u32) -> Option<Vec<Rgb>>,
) -> Received {
    let vertices = transfer.meta.vertices as usize;
    let weights = weights(&transfer.meta.sources, coefficients);
    let once = transfer.once.as_ref();
    let twice = transfer.twice.as_ref().zip(once);
    Received {
        direct: direct(transfer, &lights.rest),
        once: once.map_or(vec![[[0.0; 3]; sh::COUNT]; vertices], |once| {
            reflected(transfer, once, &lights.whole, &weights)
        }),
        twice: twice.map_or(vec![[0.0; 3]; vertices], |(twice, once)| {
            reflected_twice(transfer, twice, &once.clusters, &lights.whole, &weights)
        }),
    }
}

fn direct(transfer: &TransferTensor, light: &[Vec<f32>; 3]) -> Vec<Rgb> {
    let meta = &transfer.meta;
    let (vertices, columns) = (meta.vertices as usize, meta.columns as usize);
    let mut sums = vec![[0.0; 3]; vertices * columns];
    for (block, terms) in transfer.blocks.iter().zip(&meta.blocks) {
        for term in 0..*terms as usize {
            for (at, sum) in sums.iter_mut().enumerate() {
                let (vertex, column) = (at / columns, at % columns);
                let index = usize::from(block.indices[term * vertices + vertex]);
                let value = block.value(meta, term, vertex, column);
                (0..3).for_each(|c| sum[c] += value * light[c][index]);
            }
        }
    }
    sums
}

/// The coefficients of a coarser light: those of faces of `side` texels a side, [faces · `side`²].
fn coarser(light: &[f32], side: usize) -> impl Iterator<Item = f32> + '_ {
    let scale = side as f32 / FACE_SIZE as f32;
    light
        .chunks_exact(FACE_SIZE * FACE_SIZE)
        .flat_map(move |face| face[..side * side].iter().map(move |c| scale * c))
}

fn reflected(
    transfer: &TransferTensor,
    once: &Once,
    light: &[Vec<f32>; 3],
    weights: &[Rgb],
) -> Vec<[Rgb; sh::COUNT]> {
    let meta = &transfer.meta;
    let ([m, n], sources) = (meta.ranks.map(|rank| rank as usize), meta.sources.len());
    let light: Vec<Vec<f32>> = light.iter().map(|plane| coarser(plane, ONCE_FACE_SIZE).collect()).collect();
    // By cluster, source and function of vertices: harmonics under this light, with the weight of the source.
    let function = |at: usize| -> [Rgb; sh::COUNT] {
        let (of_source, weight) = (at / m, weights[at / m % sources]);
        let on_light = |j: usize| -> Rgb {
            let row = &once.light[(of_source * n + j) * ONCE_LIGHT..][..ONCE_LIGHT];
            std::array::from_fn(|c| weight[c] * product(row, &light[c]))
        };
        let lit: Vec<Rgb> = (0..n).map(on_light).collect();
        std::array::from_fn(|s| {
            let core = |j: usize| once.core[(at * n + j) * sh::COUNT + s].to_f32();
            std::array::from_fn(|c| (0..n).map(|j| core(j) * lit[j][c]).sum())
        })
    };
    let functions: Vec<_> = (0..meta.clusters as usize * sources * m).map(function).collect();
    let of_vertex = |(vertex, cluster): (usize, &u16)| {
        let mut sums = [[0.0; 3]; sh::COUNT];
        let shares = &once.shares[vertex * sources * m..][..sources * m];
        let functions = &functions[usize::from(*cluster) * sources * m..][..sources * m];
        for (share, function) in shares.iter().zip(functions) {
            add(&mut sums, f32::from(*share) / 127.0, function);
        }
        sums
    };
    once.clusters.iter().enumerate().map(of_vertex).collect()
}

fn add(sums: &mut [Rgb; sh::COUNT], share: f32, function: &[Rgb; sh::COUNT]) {
    for (sum, value) in sums.iter_mut().zip(function) {
        (0..3).for_each(|c| sum[c] += share * value[c]);
    }
}

fn product(row: &[f16], light: &[f32]) -> f32 {
    row.iter().zip(light).map(|(value, light)| value.to_f32() * light).sum()
}

fn reflected_twice(
    transfer: &TransferTensor,
    twice: &Twice,
    clusters: &[u16],
    light: &[Vec<f32>; 3],
    weights: &[Rgb],
) -> Vec<Rgb> {
    let (pairs, vectors) = (transfer.meta.pairs(), transfer.meta.vectors as usize);
    let light: Vec<Vec<f32>> = light.iter().map(|plane| coarser(plane, TWICE_FACE_SIZE).collect()).collect();
    let of_vector = |vector: usize| -> Rgb {
        let values = &twice.vectors[vector * TWICE_LIGHT * pairs.len()..][..TWICE_LIGHT * pairs.len()];
        std::array::from_fn(|c| {
            let weights: Vec<f32> = pairs.iter().map(|[a, b]| weights[*a][c] * weights[*b][c]).collect();
            let rows = values.chunks_exact(pairs.len()).zip(&light[c]);
            rows.map(|(row, light)| light * product(row, &weights)).sum()
        })
    };
    let lit: Vec<Rgb> = (0..transfer.meta.clusters as usize * vectors).map(of_vector).collect();
    let of_vertex = |(vertex, cluster): (usize, &u16)| {
        let shares = &twice.shares[vertex * vectors..][..vectors];
        let lit = &lit[usize::from(*cluster) * vectors..][..vectors];
        let sum =
            |c: usize| shares.iter().zip(lit).map(|(share, lit)| f32::from(*share) / 127.0 * lit[c]).sum();
        [0, 1, 2].map(sum)
    };
    clusters.iter().enumerate().map(of_vertex).collect()
}
