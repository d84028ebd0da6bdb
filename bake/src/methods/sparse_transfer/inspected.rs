//! Sparse transfer rows: how many, and all of them as arrays.

use crate::inspected::out::Out;
use crate::inspected::words::{grouped, many};
use crate::inspected::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::sparse_transfer::{BlockShape, Meta};
use relume_formats::kinds::{Manifest, SparseTransfer, StoredScene};
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::SparseTransfer, describe, export };

#[derive(Serialize)]
struct Details {
    rows: u32,
    terms: usize,
    face_size: u32,
    bounces: u32,
    channels: usize,
    /// How many of the terms are 16-bit integers; the others are bytes.
    wide_terms: u32,
    rays_per_texel: u32,
    /// What the rows would take as f32 with every coefficient.
    bytes_of_dense_matrix: u64,
}

fn describe(path: &Path) -> Result<Described> {
    let meta = SparseTransfer::open(path)?.read_first(Meta::decode)?;
    let details = Details {
        rows: meta.vertices,
        terms: meta.terms(),
        face_size: meta.face_size,
        bounces: meta.bounces,
        channels: meta.channels(),
        wide_terms: meta.blocks.iter().filter(|b| b.wide).map(|b| b.terms).sum(),
        rays_per_texel: meta.rays_per_texel,
        bytes_of_dense_matrix: u64::from(meta.vertices) * (meta.coefficients() * meta.channels() * 4) as u64,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let Details {
        rows,
        terms,
        face_size,
        bounces,
        channels,
        wide_terms,
        rays_per_texel,
        bytes_of_dense_matrix,
    } = details;
    let [rows, bounces, rays] = [rows, bounces, rays_per_texel].map(|n| *n as usize);
    let [rows, terms] = [many(rows, "vertex", "vertices"), many(*terms, "term", "terms")];
    let [bounces, channels, rays] = [
        many(bounces, "bounce", "bounces"),
        many(*channels, "channel", "channels"),
        many(rays, "ray", "rays"),
    ];
    vec![
        ("rows", format!("{rows}, {terms} each, {wide_terms} of them 16-bit")),
        ("light", format!("6 × {face_size} × {face_size} texels, {bounces}, {channels}, {rays} a texel")),
        ("dense", format!("{} bytes with every coefficient as f32", grouped(*bytes_of_dense_matrix))),
    ]
}

/// The scene of the bundle that the file at `path` lies in, if there is one.
fn scene_beside(path: &Path) -> Result<Option<StoredScene>> {
    let bundle = path.parent().unwrap_or(Path::new(""));
    Manifest::read(bundle)
        .ok()
        .map(|manifest| StoredScene::read_file(&bundle.join(manifest.scene_file.file)))
        .transpose()
}

/// `index.npy` [terms, vertices], `value.npy` [terms, vertices] or [terms, vertices, 3] as the player uses
/// it, `sparse-transfer.json`; with the scene of the same bundle also `positions.npy` and `normals.npy`
/// [vertices, 3].
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let transfer = SparseTransfer::read_file(path)?;
    let meta = &transfer.meta;
    let (terms, vertices, channels) = (meta.terms(), meta.vertices as usize, meta.channels());
    out.npy("index.npy", &[terms, vertices], transfer.blocks.iter().flat_map(|b| b.indices.iter().copied()))?;
    let columns = transfer
        .blocks
        .iter()
        .zip(&meta.blocks)
        .flat_map(|(b, shape)| (0..shape.terms as usize).map(move |term| (b, term)));
    let values = columns.flat_map(|(block, term)| {
        (0..vertices).flat_map(move |vertex| block.value(meta, term, vertex).into_iter().take(channels))
    });
    let shape = [terms, vertices, channels];
    out.npy("value.npy", if meta.rgb { &shape } else { &shape[..2] }, values)?;
    if let Some(scene) = scene_beside(path)? {
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
