//! Sparse transfer rows as arrays.

use super::out::Out;
use relume_formats::Result;
use relume_formats::kinds::sparse_transfer::BlockShape;
use relume_formats::kinds::{SparseTransfer, StoredScene};
use serde_json::json;

/// `index.npy` [terms, vertices], `value.npy` [terms, vertices] or [terms, vertices, 3] as the player uses it, `sparse-transfer.json`; with the scene
/// of the same bundle also `positions.npy` and `normals.npy` [vertices, 3].
pub(super) fn export(transfer: &SparseTransfer, scene: Option<&StoredScene>, out: &mut Out) -> Result<()> {
    let meta = &transfer.meta;
    let (terms, vertices, channels) = (meta.terms(), meta.vertices as usize, meta.channels());
    out.npy("index.npy", &[terms, vertices], transfer.blocks.iter().flat_map(|b| b.indices.iter().copied()))?;
    let columns = transfer.blocks.iter().zip(&meta.blocks).flat_map(|(b, shape)| (0..shape.terms as usize).map(move |term| (b, term)));
    let values =
        columns.flat_map(|(block, term)| (0..vertices).flat_map(move |vertex| block.value(meta, term, vertex).into_iter().take(channels)));
    let shape = [terms, vertices, channels];
    out.npy("value.npy", if meta.rgb { &shape } else { &shape[..2] }, values)?;
    if let Some(scene) = scene {
        let vectors = |vectors: &[[f32; 3]]| vectors.as_flattened().to_vec();
        out.npy("positions.npy", &[scene.positions.len(), 3], vectors(&scene.positions))?;
        out.npy("normals.npy", &[scene.normals.len(), 3], vectors(&scene.normals))?;
    }
    let block = |b: &BlockShape| json!({ "terms": b.terms, "element": if b.wide { "i16" } else { "i8" } });
    out.json(
        "sparse-transfer.json",
        &json!({
            "index": "index.npy [terms, vertices]: which Haar coefficient of the light the term multiplies; rows in order of importance",
            "value": "value.npy [terms, vertices] or [terms, vertices, 3]: radiance that a white diffuse surface reflects, per unit coefficient",
            "light": "cube map, faces +X -X +Y -Y +Z -Z (OpenGL), each texel the mean radiance over its solid angle; per face the orthonormal square Haar transform, \
                      index face*n*n + 4^l*m + j*2^l + i for level l (0 coarsest), type m (1: left minus right, 2: top minus bottom, 3: both), square (i, j); face*n*n is the scaling function",
            "face_size": meta.face_size,
            "bounces": meta.bounces,
            "terms": terms,
            "vertices": vertices,
            "channels": channels,
            "rays_per_texel": meta.rays_per_texel,
            "blocks": meta.blocks.iter().map(block).collect::<Vec<_>>(),
        }),
    )
}
