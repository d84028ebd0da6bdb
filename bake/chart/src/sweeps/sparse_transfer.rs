//! The settings of the method on the chart: terms, which frames and files pay for; how they are rounded; the
//! light's texels; and rays, which the bake pays for.

use crate::sweep::{Bench, Cut, Sweep, Variant, read};
use relume_bake::compress::quantise::unit_for;
use relume_bake::error::Result;
use relume_bake::methods::sparse_transfer::quantise::{blocks, shapes};
use relume_bake::methods::sparse_transfer::rows::{MAX_TERMS, Rows};
use relume_bake::methods::sparse_transfer::{METHOD, NAME, Settings, SparseTransferMethod, Terms};
use relume_bake::trace::held_out_lights::{Exact, RADIANCES};
use relume_formats::kinds::SparseTransfer;
use relume_formats::kinds::sparse_transfer::{BlockShape, Meta};
use relume_scenes::Scene;
use serde_json::json;
use std::collections::BTreeMap;

/// The method's line among the sweeps.
pub const SWEEP: Sweep = Sweep { method: &METHOD, variants };

/// Rays a texel where visibility changes: those of draft and preview. More take longer than a chart may, and
/// change nothing that it can tell.
const RAYS: [u32; 2] = [1, 16];
/// Terms a vertex, each the end of a block; the last are baked.
const TERMS: [usize; 6] = [32, 64, 128, 256, 512, MAX_TERMS];
/// Terms of the variants that differ in something else.
const SOME: usize = 256;

/// How a bake is cut.
#[derive(Clone, Copy)]
struct Shape {
    terms: usize,
    /// Whether all terms are bytes, the first ones too.
    bytes: bool,
    /// How many times fewer texels along a side of the light's faces.
    coarser: usize,
}

fn variants(scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let mut variants = Vec::new();
    for rays in RAYS {
        let settings = Settings { rays_per_texel: rays, terms: Terms::Number(MAX_TERMS) };
        let baked =
            bench.bake(scene, Box::new(SparseTransferMethod { settings }), &format!("{NAME}-{rays}"))?;
        let transfer: SparseTransfer = read(&baked.folder)?;
        let mut add = |series: String, label: String, shape: Shape| {
            let Shape { terms, bytes, coarser } = shape;
            let whole = terms >= transfer.meta.terms() && !bytes && coarser == 1;
            let name = format!("{NAME}-{rays}-{terms}{}-{coarser}", if bytes { "-bytes" } else { "" });
            let write = |file: &mut Cut<'_>| {
                let cut = cut(&transfer, shape);
                file.set("terms", json!(cut.meta.terms()));
                file.replace(&cut)
            };
            let folder = if whole { baked.folder.clone() } else { bench.cut(&baked.folder, &name, write)? };
            let face_size = transfer.meta.face_size as usize / coarser;
            let settings = [
                ("terms", json!(terms)),
                ("rays_per_texel", json!(rays)),
                ("face_size", json!(face_size)),
                ("bytes", json!(bytes)),
            ];
            let settings: BTreeMap<_, _> = settings.map(|(name, value)| (name.to_owned(), value)).into();
            variants.push(Variant {
                method: NAME,
                series,
                label,
                settings,
                folder,
                bake_seconds: baked.seconds,
            });
            Ok::<_, relume_bake::error::BakeError>(())
        };
        let by_rays = format!("{rays} ray{}", if rays == 1 { "" } else { "s" });
        let plain = Shape { terms: SOME, bytes: false, coarser: 1 };
        if rays == RAYS[1] {
            TERMS.iter().try_for_each(|terms| {
                add(by_rays.clone(), format!("{terms} terms"), Shape { terms: *terms, ..plain })
            })?;
            for terms in [TERMS[0], SOME] {
                add(
                    "bytes alone".to_owned(),
                    format!("{terms} terms of bytes"),
                    Shape { terms, bytes: true, coarser: 1 },
                )?;
            }
            for coarser in [2, 4] {
                let side = transfer.meta.face_size as usize / coarser;
                add(
                    "coarser light".to_owned(),
                    format!("{SOME} terms, light {side}\u{b2}"),
                    Shape { coarser, ..plain },
                )?;
            }
        } else {
            add(by_rays.clone(), format!("{SOME} terms, {by_rays}"), plain)?;
        }
    }
    Ok(variants)
}

/// The first terms of `transfer` as `shape` has them. With a coarser light every coefficient is worth more,
/// for each texel's mean counts for several, and the finest wavelets are gone. Whole blocks are what a bake
/// with fewer terms writes.
fn cut(transfer: &SparseTransfer, shape: Shape) -> SparseTransfer {
    if !shape.bytes && shape.coarser == 1 {
        let mut left = shape.terms;
        let whole =
            |block: &&BlockShape| left.checked_sub(block.terms as usize).map(|rest| left = rest).is_some();
        let blocks: Vec<BlockShape> = transfer.meta.blocks.iter().take_while(whole).copied().collect();
        return SparseTransfer {
            blocks: transfer.blocks[..blocks.len()].to_vec(),
            meta: Meta { blocks, ..transfer.meta.clone() },
        };
    }
    let rows = coarser(transfer, shape.coarser, shape.terms);
    let wide = |block: BlockShape| BlockShape { wide: block.wide && !shape.bytes, ..block };
    let shapes: Vec<BlockShape> = shapes(rows.terms).into_iter().map(wide).collect();
    let unit = unit_for(&rows.values);
    let face_size = transfer.meta.face_size / shape.coarser as u32;
    SparseTransfer {
        blocks: blocks(&rows, &shapes, unit),
        meta: Meta { unit, face_size, blocks: shapes, ..transfer.meta.clone() },
    }
}

/// Rows of at most `terms` terms in a light of faces `times` as coarse.
fn coarser(transfer: &SparseTransfer, times: usize, terms: usize) -> Rows {
    let meta = &transfer.meta;
    let face = (meta.face_size * meta.face_size) as usize;
    let coarse = face / (times * times);
    let terms = terms.min(meta.coefficients() / face * coarse);
    let mut rows = Rows::new(terms, meta.channels());
    for vertex in 0..meta.vertices as usize {
        let mut kept = Vec::with_capacity(terms);
        for (block, shape) in transfer.blocks.iter().zip(&meta.blocks) {
            for term in 0..shape.terms as usize {
                let index = usize::from(block.indices[term * meta.vertices as usize + vertex]);
                if index % face < coarse && kept.len() < terms {
                    kept.push((
                        index / face * coarse + index % face,
                        block.value(meta, term, vertex).map(|value| value * times as f32),
                    ));
                }
            }
        }
        kept.resize(terms, (0, [0.0; 3]));
        for (index, value) in kept {
            rows.indices.push(index as u16);
            rows.values.extend(&value[..meta.channels()]);
        }
        // As many as there are rows; packing does not look at them.
        rows.exact.push(Exact { given: [0.0; RADIANCES], seen: [0.0; RADIANCES] });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;
    use relume_formats::kinds::sparse_transfer::{Block, Steps};

    /// Two vertices that keep, of a light of 4 × 4 texels a face, a scaling function, wavelets of both
    /// levels, and nothing else.
    fn transfer() -> SparseTransfer {
        let shapes = [(2, true), (2, false)].map(|(terms, wide)| BlockShape { terms, wide });
        let meta = Meta {
            vertices: 2,
            face_size: 4,
            bounces: 0,
            rgb: false,
            unit: 0.5,
            blocks: shapes.to_vec(),
            rays_per_texel: 1,
        };
        let scales = vec![f16::ONE, f16::from_f32(2.0)];
        let first = Block {
            indices: vec![16, 0, 5, 80],
            scales: scales.clone(),
            steps: Steps::Wide(vec![400, 500, -60, 70]),
        };
        let second = Block { indices: vec![2, 31, 81, 3], scales, steps: Steps::Bytes(vec![9, -8, 7, 6]) };
        SparseTransfer { meta, blocks: vec![first, second] }
    }

    #[test]
    fn whole_blocks_are_kept_as_they_are() {
        let whole = transfer();
        let cut = cut(&whole, Shape { terms: 3, bytes: false, coarser: 1 });
        assert_eq!(
            (cut.meta.blocks.len(), &cut.blocks[..]),
            (1, &whole.blocks[..1]),
            "three terms are one block and a half"
        );
        assert_eq!(super::cut(&whole, Shape { terms: 4, bytes: false, coarser: 1 }), whole);
    }

    /// A light that is the same over each 2 × 2 texels has nothing in the finest level, so leaving that out
    /// changes nothing.
    #[test]
    fn coarser_rows_give_the_same_under_a_coarse_light() {
        use relume_formats::basis::haar::forward_cube;
        let coarse: Vec<f32> = (0..24).map(|i| ((i * 37) % 11) as f32).collect();
        let mut fine: Vec<f32> =
            (0..96).map(|i| coarse[i / 16 * 4 + (i % 16) / 8 * 2 + (i % 4) / 2]).collect();
        let mut coarse = coarse;
        forward_cube(&mut coarse, 2);
        forward_cube(&mut fine, 4);
        let rows = coarser(&transfer(), 2, 4);
        let whole = transfer();
        for vertex in 0..2 {
            let ours: f32 = (0..4)
                .map(|k| rows.values[vertex * 4 + k] * coarse[usize::from(rows.indices[vertex * 4 + k])])
                .sum();
            let theirs: f32 = whole
                .blocks
                .iter()
                .flat_map(|block| (0..2).map(move |k| (block, k)))
                .map(|(block, k)| {
                    block.value(&whole.meta, k, vertex)[0] * fine[usize::from(block.indices[2 * k + vertex])]
                })
                .sum();
            assert!((ours - theirs).abs() <= 1e-4 * theirs.abs(), "{ours} {theirs}");
        }
    }

    #[test]
    fn bytes_are_within_half_a_step() {
        let whole = transfer();
        let bytes = cut(&whole, Shape { terms: 4, bytes: true, coarser: 1 });
        assert!(bytes.blocks.iter().all(|block| matches!(block.steps, Steps::Bytes(_))));
        let value = |t: &SparseTransfer, vertex: usize, term: usize| {
            let (mut block, mut term) = (0, term);
            while term >= t.meta.blocks[block].terms as usize {
                term -= t.meta.blocks[block].terms as usize;
                block += 1;
            }
            t.blocks[block].value(&t.meta, term, vertex)[0]
        };
        for vertex in 0..2 {
            let largest = (0..4).map(|term| value(&whole, vertex, term).abs()).fold(0.0, f32::max);
            for term in 0..4 {
                let off = (value(&whole, vertex, term) - value(&bytes, vertex, term)).abs();
                // The step is the largest over 127, rounded up to a half.
                assert!(off <= 0.5 * largest / 127.0 * 1.001, "{off}");
            }
        }
    }
}
