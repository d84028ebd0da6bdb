//! Where the stored columns lie on the GPU.
//!
//! Columns stand in their order, packed into as few bands as bindings allow. A band holds runs of columns of
//! one block; a block that does not fit what is left of a band goes on in the next. Every row of a column
//! starts on a whole word.

use super::gpu_data::Run;
use relume_formats::kinds::sparse_transfer::{Block, Meta, Steps};
use std::ops::Range;

/// Columns that share a storage buffer.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Band {
    /// The runs, in the order of the columns.
    pub(super) pieces: Vec<Piece>,
    /// Size of the buffer in words.
    pub(super) words: u32,
}

/// A run and where it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    /// Index of the block.
    pub(super) block: usize,
    /// Columns within the block.
    pub(super) terms: Range<usize>,
    /// Where they lie.
    pub(super) run: Run,
}

/// Words of a row of `bytes` bytes.
fn words(bytes: u64) -> u64 {
    bytes.div_ceil(4)
}

/// Places all columns in bands of at most `limit` bytes, or tells how many bytes a single column needs that
/// fits in none.
pub(super) fn arrange(meta: &Meta, limit: u64) -> Result<Vec<Band>, u64> {
    let vertices = u64::from(meta.vertices);
    let values = vertices * meta.channels() as u64;
    let limit = limit / 4;
    let mut bands = vec![Band::default()];
    for (block, shape) in meta.blocks.iter().enumerate() {
        let (index_words, value_words) =
            (words(2 * vertices), words(if shape.wide { 2 * values } else { values }));
        let scale_words = index_words;
        let mut begin = 0;
        while begin < shape.terms {
            let used = bands.last().map_or(0, |band| u64::from(band.words));
            let fit = limit.saturating_sub(used + scale_words) / (index_words + value_words);
            let terms = fit.min(u64::from(shape.terms - begin)) as u32;
            if terms == 0 {
                if used == 0 {
                    return Err(4 * (scale_words + index_words + value_words));
                }
                bands.push(Band::default());
                continue;
            }
            let [indices, values] = [used, used + u64::from(terms) * index_words];
            let scales = values + u64::from(terms) * value_words;
            let run = Run {
                terms,
                wide: u32::from(shape.wide),
                indices: indices as u32,
                values: values as u32,
                scales: scales as u32,
            };
            if let Some(band) = bands.last_mut() {
                band.pieces.push(Piece { block, terms: begin as usize..(begin + terms) as usize, run });
                band.words = (scales + scale_words) as u32;
            }
            begin += terms;
        }
    }
    Ok(bands)
}

/// The bytes of a run, a multiple of 4 long.
pub(super) fn pack(meta: &Meta, block: &Block, terms: &Range<usize>) -> Vec<u8> {
    let vertices = meta.vertices as usize;
    let values = vertices * meta.channels();
    let mut bytes = Vec::new();
    push_rows(&mut bytes, &block.indices, vertices, terms);
    match &block.steps {
        Steps::Wide(steps) => push_rows(&mut bytes, steps, values, terms),
        Steps::Bytes(steps) => push_rows(&mut bytes, steps, values, terms),
    }
    push_rows(&mut bytes, &block.scales, vertices, &(0..1));
    bytes
}

/// Appends the `rows` of `elements`, each of `length` elements, padded to whole words.
fn push_rows<T: bytemuck::Pod>(bytes: &mut Vec<u8>, elements: &[T], length: usize, rows: &Range<usize>) {
    for row in elements.chunks_exact(length.max(1)).take(rows.end).skip(rows.start) {
        bytes.extend_from_slice(bytemuck::cast_slice(row));
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::sparse;

    /// The smallest limit that all columns fit.
    fn least_limit(meta: &Meta) -> u64 {
        let mut limit = 1;
        while let Err(bytes) = arrange(meta, limit) {
            assert!(bytes > limit);
            limit = bytes;
        }
        limit
    }

    #[test]
    fn every_column_lies_in_a_band_that_is_not_too_large() {
        for rgb in [false, true] {
            let transfer = sparse::transfer(77, 16, rgb);
            let meta = &transfer.meta;
            let whole = arrange(meta, 1 << 27).unwrap();
            assert_eq!(whole.len(), 1);
            let column = least_limit(meta);
            assert_eq!(arrange(meta, column - 4), Err(column));
            for limit in [column, column + 4, 3 * column, u64::from(whole[0].words) * 4 - 1] {
                let bands = arrange(meta, limit).unwrap();
                assert!(
                    bands.len() > 1
                        && bands
                            .iter()
                            .all(|band| u64::from(band.words) * 4 <= limit && !band.pieces.is_empty())
                );
                let columns: Vec<_> = bands
                    .iter()
                    .flat_map(|b| &b.pieces)
                    .flat_map(|p| p.terms.clone().map(|t| (p.block, t)))
                    .collect();
                let expected: Vec<_> = (0..meta.blocks.len())
                    .flat_map(|b| (0..meta.blocks[b].terms as usize).map(move |t| (b, t)))
                    .collect();
                assert_eq!(columns, expected);
            }
        }
    }

    #[test]
    fn runs_follow_each_other_and_are_as_long_as_they_are_packed() {
        for rgb in [false, true] {
            let transfer = sparse::transfer(77, 16, rgb);
            let column = least_limit(&transfer.meta);
            for limit in [1 << 27, 5 * column] {
                for band in arrange(&transfer.meta, limit).unwrap() {
                    let mut end = 0;
                    for piece in &band.pieces {
                        assert_eq!(piece.run.indices, end);
                        let packed = pack(&transfer.meta, &transfer.blocks[piece.block], &piece.terms);
                        assert_eq!(packed.len() % 4, 0);
                        end += packed.len() as u32 / 4;
                    }
                    assert_eq!(end, band.words);
                }
            }
        }
    }
}
