//! The settings of the method on the chart: terms of direct light, functions and vectors of clusters, bands of
//! harmonics and reflections, which frames and files pay for; and rays, which the bake pays for.

use crate::sweep::{Bench, Sweep, Variant, read};
use half::f16;
use relume_bake::error::Result;
use relume_bake::methods::asked::{Asked, Quality};
use relume_bake::methods::sparse_transfer::Terms;
use relume_bake::methods::transfer_tensor::ranks::{cut_once, cut_twice};
use relume_bake::methods::transfer_tensor::{METHOD, NAME, RAYS, Settings, TransferTensorMethod};
use relume_formats::basis::sh;
use relume_formats::kinds::TransferTensor;
use relume_scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The method's line among the sweeps.
pub const SWEEP: Sweep = Sweep { method: &METHOD, variants };

/// Terms a vertex, each the end of a block; the last are baked.
const TERMS: [usize; 5] = [16, 40, 72, 136, 264];
/// Terms of the variants that differ in something else.
const SOME: usize = 136;
/// Functions of vertices, functions of light, vectors, and bands of harmonics, all fewer than are baked.
const OF_VERTICES: [u32; 3] = [8, 16, 24];
const OF_LIGHT: [u32; 2] = [8, 16];
const VECTORS: [u32; 2] = [4, 8];
const BANDS: [usize; 3] = [1, 2, 3];

/// What is kept of a bake.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kept {
    terms: usize,
    ranks: [u32; 2],
    vectors: u32,
    bands: usize,
    reflections: u32,
}

fn variants(scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let rays_per_texel = Quality::Preview.rays_per_texel();
    let most = Terms::Number(TERMS[TERMS.len() - 1]);
    let settings = Settings { rays_per_texel, samples: RAYS, seed: 0, terms: most };
    let baked = bench.bake(scene, Box::new(TransferTensorMethod { settings }), &format!("{NAME}-most"))?;
    let whole: TransferTensor = read(&baked.folder)?;
    let mut variants = Vec::new();
    for (number, (series, label, kept)) in all_kept(&whole).into_iter().enumerate() {
        let folder = bench.cut(&baked.folder, &format!("{NAME}-{number:02}"), |file| {
            file.set("terms", json!(kept.terms));
            file.replace(&cut(&whole, kept))
        })?;
        let settings = [
            ("terms", json!(kept.terms)),
            ("ranks", json!(kept.ranks)),
            ("vectors", json!(kept.vectors)),
            ("bands", json!(kept.bands)),
            ("reflections", json!(kept.reflections)),
        ];
        let settings: BTreeMap<_, _> = settings.map(|(name, value)| (name.to_owned(), value)).into();
        let series = series.to_owned();
        variants.push(Variant { method: NAME, series, label, settings, folder, bake_seconds: baked.seconds });
    }
    for (label, quality) in [("draft", Quality::Draft), ("preview", Quality::Preview)] {
        let bake = (METHOD.new)(&Asked { size: bench.size, quality, ..Asked::of_scene(scene) }, scene);
        let baked = bench.bake(scene, bake, &format!("{NAME}-{label}"))?;
        let settings: BTreeMap<String, Value> =
            [("quality", json!(label)), ("max_error", json!(scene.max_error))]
                .map(|(name, value)| (name.to_owned(), value))
                .into();
        let (series, label) = ("as baked".to_owned(), format!("as baked, {label}"));
        variants.push(Variant {
            method: NAME,
            series,
            label,
            settings,
            folder: baked.folder,
            bake_seconds: baked.seconds,
        });
    }
    Ok(variants)
}

/// What is cut out of `whole`: series, label and what it keeps.
fn all_kept(whole: &TransferTensor) -> Vec<(&'static str, String, Kept)> {
    let [m, n] = whole.meta.ranks;
    let (vectors, reflections) = (whole.meta.vectors, whole.meta.reflections);
    let some = Kept { terms: SOME, ranks: [m, n], vectors, bands: sh::COUNT.isqrt(), reflections };
    let mut all: Vec<_> =
        TERMS.map(|terms| ("terms", format!("{terms} terms"), Kept { terms, ..some })).into();
    if reflections > 1 {
        all.extend(
            OF_VERTICES.map(|m| ("of vertices", format!("{m} of vertices"), Kept { ranks: [m, n], ..some })),
        );
        all.extend(OF_LIGHT.map(|n| ("of light", format!("{n} of light"), Kept { ranks: [m, n], ..some })));
        all.extend(BANDS.map(|bands| ("bands", format!("{bands} bands"), Kept { bands, ..some })));
    }
    if reflections > 2 {
        all.extend(
            VECTORS.map(|vectors| ("vectors", format!("{vectors} vectors"), Kept { vectors, ..some })),
        );
    }
    all.extend(
        (1..reflections)
            .map(|r| ("reflections", format!("{r} of {reflections}"), Kept { reflections: r, ..some })),
    );
    all
}

/// What a bake that keeps less would have of `whole`, but that Tucker's bases are of more functions.
fn cut(whole: &TransferTensor, kept: Kept) -> TransferTensor {
    let mut cut = whole.clone();
    let mut left = kept.terms as u32;
    let fits = |terms: &&u32| left.checked_sub(**terms).map(|rest| left = rest).is_some();
    cut.meta.blocks = whole.meta.blocks.iter().take_while(fits).copied().collect();
    cut.blocks.truncate(cut.meta.blocks.len());
    cut.meta.reflections = kept.reflections;
    if kept.reflections < 3 {
        (cut.meta.vectors, cut.twice) = (0, None);
    } else if let Some(twice) = &mut cut.twice {
        let vectors = [whole.meta.vectors, kept.vectors].map(|vectors| vectors as usize);
        *twice = cut_twice(twice, whole.meta.clusters as usize, vectors);
        cut.meta.vectors = kept.vectors;
    }
    if kept.reflections < 2 {
        (cut.meta.ranks, cut.meta.clusters, cut.once) = ([0; 2], 0, None);
        cut.meta.sources.clear();
    } else if let Some(once) = &mut cut.once {
        let [from, to] = [whole.meta.ranks, kept.ranks].map(|ranks| ranks.map(|rank| rank as usize));
        *once = cut_once(once, from, to);
        cut.meta.ranks = kept.ranks;
        for harmonics in once.core.chunks_exact_mut(sh::COUNT) {
            harmonics[kept.bands * kept.bands..].fill(f16::ZERO);
        }
    }
    cut
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::container::Stored;
    use relume_formats::kinds::transfer_tensor::{Block, Meta, ONCE_LIGHT, Once, Source, TWICE_LIGHT, Twice};

    const VERTICES: usize = 3;

    /// One column of as many terms as are baked, and light of three reflections by one source.
    fn whole() -> TransferTensor {
        let blocks = vec![4, 4, 8, 8, 16, 32, 32, 32, 32, 32, 32, 32];
        let block = |terms: &u32| {
            let count = *terms as usize * VERTICES;
            Block { indices: vec![7; count], scales: vec![f16::ONE; VERTICES], steps: vec![3; count] }
        };
        let (m, n, vectors) = (32, 32, 16);
        TransferTensor {
            blocks: blocks.iter().map(block).collect(),
            seen: vec![255; VERTICES * 576],
            once: Some(Once {
                clusters: vec![0; VERTICES],
                shares: vec![1; VERTICES * m],
                core: vec![f16::ONE; m * n * sh::COUNT],
                light: vec![f16::ONE; n * ONCE_LIGHT],
            }),
            twice: Some(Twice {
                shares: vec![1; VERTICES * vectors],
                vectors: vec![f16::ONE; vectors * TWICE_LIGHT],
            }),
            meta: Meta {
                vertices: VERTICES as u32,
                columns: 1,
                blocks,
                unit: 1.0,
                rays_per_texel: 1,
                reflections: 3,
                sources: vec![Source { material: Some(0), basis: 0, channel: None }],
                clusters: 1,
                ranks: [m as u32, n as u32],
                vectors: vectors as u32,
            },
        }
    }

    #[test]
    fn all_that_is_cut_can_be_read_and_is_what_its_label_says() {
        let whole = whole();
        let all = all_kept(&whole);
        assert_eq!(all.len(), 5 + 3 + 2 + 3 + 2 + 2);
        for (_, label, kept) in all {
            let cut = cut(&whole, kept);
            let file = tempfile::NamedTempFile::new().unwrap();
            cut.write_file(file.path()).unwrap();
            assert_eq!(TransferTensor::read_file(file.path()).unwrap(), cut, "{label}");
            assert_eq!((cut.meta.terms(), cut.meta.reflections), (kept.terms, kept.reflections), "{label}");
            if let Some(once) = &cut.once {
                let lit = once.core[..sh::COUNT].iter().filter(|value| **value != f16::ZERO).count();
                assert_eq!((cut.meta.ranks, lit), (kept.ranks, kept.bands * kept.bands), "{label}");
            }
        }
    }
}
