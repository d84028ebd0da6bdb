//! Tensors at vertices: how many and how large, and all of them as arrays.

use crate::inspected::out::Out;
use crate::inspected::words::{grouped, many};
use crate::inspected::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::basis::{hemisphere, sh};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::TransferTensor;
use relume_formats::kinds::transfer_tensor::{FACE_SIZE, Meta, ONCE_LIGHT, Source, TWICE_LIGHT};
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::TransferTensor, describe, export };

#[derive(Serialize)]
struct Details {
    vertices: u32,
    columns: u32,
    terms: usize,
    rays_per_texel: u32,
    reflections: u32,
    sources: Vec<Source>,
    clusters: u32,
    /// Functions of a cluster and source: of vertices and of the light.
    ranks: [u32; 2],
    /// Vectors of a cluster for light that was reflected twice.
    vectors: u32,
    /// What direct light would take as f32 with every coefficient, and reflected light without clusters.
    bytes_of_dense_tensors: u64,
}

fn describe(path: &Path) -> Result<Described> {
    let meta = TransferTensor::open(path)?.read_first(Meta::decode)?;
    let direct = u64::from(meta.columns) * (6 * FACE_SIZE * FACE_SIZE) as u64;
    let once = (meta.sources.len() * ONCE_LIGHT * sh::COUNT) as u64;
    let twice = if meta.reflections > 2 { (meta.pairs().len() * TWICE_LIGHT) as u64 } else { 0 };
    let details = Details {
        vertices: meta.vertices,
        columns: meta.columns,
        terms: meta.terms(),
        rays_per_texel: meta.rays_per_texel,
        reflections: meta.reflections,
        clusters: meta.clusters,
        ranks: meta.ranks,
        vectors: meta.vectors,
        bytes_of_dense_tensors: 4 * u64::from(meta.vertices) * (direct + once + twice),
        sources: meta.sources,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let [vertices, columns, rays, reflections, clusters] =
        [details.vertices, details.columns, details.rays_per_texel, details.reflections, details.clusters]
            .map(|n| n as usize);
    let rows = format!(
        "{}, {} of {}, {} a texel",
        many(vertices, "vertex", "vertices"),
        many(details.terms, "term", "terms"),
        many(columns, "column", "columns"),
        many(rays, "ray", "rays")
    );
    let mut facts = vec![("direct", rows)];
    if reflections > 1 {
        let [m, n] = details.ranks;
        let vectors = match details.vectors {
            0 => String::new(),
            vectors => format!(", {}", many(vectors as usize, "vector", "vectors")),
        };
        facts.push((
            "reflected",
            format!(
                "{}, by {} in {}, ranks {m} and {n}{vectors}",
                many(reflections, "reflection", "reflections"),
                many(details.sources.len(), "source", "sources"),
                many(clusters, "cluster", "clusters")
            ),
        ));
    }
    facts
        .push(("dense", format!("{} bytes as f32, not compressed", grouped(details.bytes_of_dense_tensors))));
    facts
}

/// `index.npy` [terms, vertices], `value.npy` [terms, vertices, columns] and `seen.npy` [vertices, 576]; with reflected light
/// `cluster.npy`, `share.npy`, `core.npy`, `light.npy`, `twice-share.npy` and `twice.npy`; `transfer-tensor.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let tensor = &TransferTensor::read_file(path)?;
    let meta = &tensor.meta;
    let [vertices, columns, clusters, vectors] =
        [meta.vertices, meta.columns, meta.clusters, meta.vectors].map(|n| n as usize);
    let (terms, sources, [m, n]) = (meta.terms(), meta.sources.len(), meta.ranks.map(|rank| rank as usize));
    out.npy("index.npy", &[terms, vertices], tensor.blocks.iter().flat_map(|b| b.indices.iter().copied()))?;
    let of_blocks = tensor.blocks.iter().zip(&meta.blocks);
    let values = of_blocks.flat_map(|(block, terms)| {
        (0..*terms as usize * vertices * columns).map(move |at| {
            let (term, within) = (at / (vertices * columns), at % (vertices * columns));
            block.value(meta, term, within / columns, within % columns)
        })
    });
    out.npy("value.npy", &[terms, vertices, columns], values)?;
    out.npy("seen.npy", &[vertices, hemisphere::TEXELS], tensor.seen.iter().copied())?;
    if let Some(once) = &tensor.once {
        let floats = |values: &[half::f16]| values.iter().map(|value| value.to_f32()).collect::<Vec<f32>>();
        let shares =
            |values: &[i8]| values.iter().map(|share| f32::from(*share) / 127.0).collect::<Vec<f32>>();
        out.npy("cluster.npy", &[vertices], once.clusters.iter().copied())?;
        out.npy("share.npy", &[vertices, sources, m], shares(&once.shares))?;
        out.npy("core.npy", &[clusters, sources, m, n, sh::COUNT], floats(&once.core))?;
        out.npy("light.npy", &[clusters, sources, n, ONCE_LIGHT], floats(&once.light))?;
        if let Some(twice) = &tensor.twice {
            let pairs = meta.pairs().len();
            out.npy("twice-share.npy", &[vertices, vectors], shares(&twice.shares))?;
            out.npy("twice.npy", &[clusters, vectors, TWICE_LIGHT, pairs], floats(&twice.vectors))?;
        }
    }
    out.json(
        "transfer-tensor.json",
        &json!({
            "index": "index.npy [terms, vertices]: which Haar coefficient of the light, 6 x 64 x 64, the term multiplies",
            "value": "value.npy [terms, vertices, columns]: what it is multiplied with; the first column gives the radiance of a white diffuse surface",
            "seen": "seen.npy [vertices, 576]: visible part of texels of equal solid angle, 255 is all; concentric map of the disc, r² = 1 - cos",
            "reflected": "radiance after one reflection, by 16 spherical harmonics in world space: sum of weight(source) · share · core · light · Haar coefficient of 6 x 8 x 8",
            "twice": "irradiance over pi after two reflections: sum of weights of a pair of sources · twice-share · twice · Haar coefficient of 6 x 2 x 2",
            "sources": meta.sources,
            "pairs": meta.pairs(),
            "terms": terms,
            "vertices": vertices,
            "columns": columns,
            "clusters": clusters,
            "reflections": meta.reflections,
            "rays_per_texel": meta.rays_per_texel,
        }),
    )
}
