//! Texels of a cube as bits.

use relume_formats::basis::cubemap::FACES;
use std::ops::RangeInclusive;

/// Some texels of a cube, a bit each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TexelSet {
    face_size: usize,
    words_per_row: usize,
    /// Rows of words, the first texel in the lowest bit of the first.
    words: Vec<u64>,
}

impl TexelSet {
    /// None of a cube with faces of `face_size`², a multiple of 8.
    pub fn none(face_size: usize) -> Self {
        let words_per_row = face_size.div_ceil(64);
        Self { face_size, words_per_row, words: vec![0; FACES * face_size * words_per_row] }
    }

    /// Those whose index `is_one`.
    pub fn of(face_size: usize, is_one: impl Fn(usize) -> bool) -> Self {
        let mut texels = Self::none(face_size);
        for row in 0..FACES * face_size {
            for word in 0..texels.words_per_row {
                let first = row * face_size + 64 * word;
                let width = (face_size - 64 * word).min(64);
                let bits = (0..width).fold(0, |bits, k| bits | u64::from(is_one(first + k)) << k);
                texels.words[row * texels.words_per_row + word] = bits;
            }
        }
        texels
    }

    /// Texels along a side of a face.
    pub fn face_size(&self) -> usize {
        self.face_size
    }

    /// Whether the texel at (`x`, `row`) is one, rows of all faces counted.
    pub fn has(&self, row: usize, x: usize) -> bool {
        self.words[row * self.words_per_row + x / 64] >> (x % 64) & 1 == 1
    }

    /// Adds all in `columns`, both ends included, of `row`.
    pub fn insert_all(&mut self, row: usize, columns: [usize; 2]) {
        for word in columns[0] / 64..=columns[1] / 64 {
            self.words[row * self.words_per_row + word] |= mask(word, columns);
        }
    }

    /// Adds the texel at (`x`, `row`).
    pub fn insert(&mut self, row: usize, x: usize) {
        self.words[row * self.words_per_row + x / 64] |= 1 << (x % 64);
    }

    /// Replaces 64 texels of `row`, which has no more.
    pub fn set_word(&mut self, row: usize, word: u64) {
        self.words[row * self.words_per_row] = word;
    }

    /// The indices of all that there are, in their order.
    pub fn members(&self) -> impl Iterator<Item = usize> {
        let word = |(index, word): (usize, &u64)| {
            let (row, within) = (index / self.words_per_row, index % self.words_per_row);
            let (first, mut left) = (row * self.face_size + 64 * within, *word);
            std::iter::from_fn(move || {
                let bit = left.trailing_zeros() as usize;
                let found = (left != 0).then_some(first + bit);
                left &= left.wrapping_sub(1);
                found
            })
        };
        self.words.iter().enumerate().flat_map(word)
    }

    /// Eight texels a byte, the first in the lowest bit.
    pub fn to_bytes(&self) -> impl Iterator<Item = u8> {
        let of_row = |row: &[u64]| {
            row.iter().flat_map(|word| word.to_le_bytes()).take(self.face_size / 8).collect::<Vec<u8>>()
        };
        self.words.chunks_exact(self.words_per_row).flat_map(of_row)
    }

    /// From [`TexelSet::to_bytes`]; `None` if these are too few or too many.
    pub fn from_bytes(face_size: usize, bytes: &[u8]) -> Option<Self> {
        let mut set = Self::none(face_size);
        (bytes.len() == FACES * face_size * face_size / 8).then_some(())?;
        for (row, bytes) in
            set.words.chunks_exact_mut(set.words_per_row).zip(bytes.chunks_exact(face_size / 8))
        {
            for (word, bytes) in row.iter_mut().zip(bytes.chunks(8)) {
                *word = bytes.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte));
            }
        }
        Some(set)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Row by row, 64 texels a word.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Which of the 64 texels of word number `word` of `row` there are.
    #[inline(always)]
    pub(super) fn word(&self, row: usize, word: usize) -> u64 {
        self.words[row * self.words_per_row + word]
    }

    /// Takes `texels` out of word number `word` of `row`.
    #[inline(always)]
    pub(super) fn remove(&mut self, row: usize, word: usize, texels: u64) {
        self.words[row * self.words_per_row + word] &= !texels;
    }

    /// All in `columns`, both ends included, of `rows`, as (row, column), if these are no more than there is
    /// room for in `found`; how many they are.
    #[inline(always)]
    pub(super) fn few(
        &self,
        rows: RangeInclusive<usize>,
        columns: [usize; 2],
        found: &mut [(usize, usize)],
    ) -> Option<usize> {
        let mut count = 0;
        for row in rows {
            for word in columns[0] / 64..=columns[1] / 64 {
                let mut left = self.word(row, word) & mask(word, columns);
                while left != 0 {
                    *found.get_mut(count)? = (row, word * 64 + left.trailing_zeros() as usize);
                    left &= left - 1;
                    count += 1;
                }
            }
        }
        Some(count)
    }

    /// Takes out all in `columns`, both ends included, of `row`.
    #[inline(always)]
    pub(super) fn remove_all(&mut self, row: usize, columns: [usize; 2]) {
        for word in columns[0] / 64..=columns[1] / 64 {
            self.remove(row, word, mask(word, columns));
        }
    }

    /// Whether any lies in `columns`, both ends included, of `rows`.
    #[inline(always)]
    pub(super) fn any(&self, rows: RangeInclusive<usize>, columns: [usize; 2]) -> bool {
        for row in rows {
            for word in columns[0] / 64..=columns[1] / 64 {
                if self.word(row, word) & mask(word, columns) != 0 {
                    return true;
                }
            }
        }
        false
    }
}

/// The bits of word number `word` of a row that stand for texels in `columns`, both ends included.
#[inline(always)]
pub(super) fn mask(word: usize, [first, last]: [usize; 2]) -> u64 {
    let (from, to) = (first.saturating_sub(64 * word), (last - 64 * word).min(63));
    u64::MAX << from & u64::MAX >> (63 - to)
}
