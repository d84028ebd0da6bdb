//! The 48 symmetries of the cube, which exchange and mirror its axes, and what they do to bitmaps: a face
//! goes to a face, perhaps with x and y exchanged, perhaps mirrored. So a bitmap moves by whole rows.

use super::{DIRECTIONS, RADII};
use crate::basis::cubemap::{self, FACES};
use crate::basis::two_level::{BYTES, SIDE};
use glam::Vec3;

/// A face of a bitmap: row y, in which bit x is texel (x, y).
type Face = [u32; SIDE];

/// The orders that three axes can stand in.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// The centre of `texel` on the cube [−1, 1]³, not normalised: multiples of 1/32.
pub(super) fn centre(texel: usize) -> [f64; 3] {
    let [face, x, y] = place(texel);
    let along = |i: usize| (2 * i + 1) as f64 / SIDE as f64 - 1.0;
    cubemap::on_face(face, along(x), along(y))
}

/// Face, x and y.
fn place(texel: usize) -> [usize; 3] {
    [texel / (SIDE * SIDE), texel % SIDE, texel / SIDE % SIDE]
}

/// Takes the point p to (±p\[a\], ±p\[b\], ±p\[c\]).
pub(super) struct Symmetry {
    axes: [usize; 3],
    signs: [f64; 3],
}

impl Symmetry {
    /// All 48.
    pub fn all() -> impl Iterator<Item = Self> {
        let sign = |number: usize, bit: usize| if number >> bit & 1 == 1 { -1.0 } else { 1.0 };
        ORDERS.into_iter().flat_map(move |axes| {
            (0..8).map(move |n| Self { axes, signs: [sign(n, 0), sign(n, 1), sign(n, 2)] })
        })
    }

    /// Where `texel` goes.
    pub fn texel(&self, texel: usize) -> usize {
        let p = centre(texel);
        texel_at(std::array::from_fn(|axis| self.signs[axis] * p[self.axes[axis]]))
    }

    /// What comes to `texel`.
    fn source(&self, texel: usize) -> usize {
        let p = centre(texel);
        let mut from = [0.0; 3];
        for axis in 0..3 {
            from[self.axes[axis]] = self.signs[axis] * p[axis];
        }
        texel_at(from)
    }

    /// What comes to each face.
    fn moves(&self) -> [Move; FACES] {
        std::array::from_fn(|face| {
            let first = face * SIDE * SIDE;
            let [from, x, y] = place(self.source(first));
            let [_, x_beside, _] = place(self.source(first + 1));
            let transposed = x_beside == x;
            let [mirrored_x, mirrored_y] = if transposed { [y != 0, x != 0] } else { [x != 0, y != 0] };
            Move { from, transposed, mirrored_x, mirrored_y }
        })
    }
}

/// Of a centre, whose coordinates f32 holds exactly.
fn texel_at(centre: [f64; 3]) -> usize {
    cubemap::texel_of(Vec3::from_array(centre.map(|c| c as f32)), SIDE)
}

/// How a face comes to its place: x and y exchanged first, then mirrored.
struct Move {
    from: usize,
    transposed: bool,
    mirrored_x: bool,
    mirrored_y: bool,
}

/// The bitmaps of one direction, ready to be moved.
pub(super) struct Image {
    /// Of every radius.
    plain: Vec<[Face; FACES]>,
    /// The same with x and y exchanged.
    transposed: Vec<[Face; FACES]>,
}

impl Image {
    /// `rings` as they are stored, for each texel the number of the first bitmap that has it.
    pub fn new(rings: &[u8; DIRECTIONS]) -> Self {
        let bits = |bit_of: fn(usize, usize) -> (usize, usize)| {
            let mut bitmaps = vec![[[0; SIDE]; FACES]; RADII];
            for (texel, ring) in rings.iter().enumerate() {
                let [face, x, y] = place(texel);
                let (x, y) = bit_of(x, y);
                if let Some(bitmap) = bitmaps.get_mut(usize::from(*ring)) {
                    bitmap[face][y] |= 1 << x;
                }
            }
            for radius in 1..RADII {
                let narrower = bitmaps[radius - 1];
                let rows = bitmaps[radius].as_flattened_mut().iter_mut();
                rows.zip(narrower.as_flattened()).for_each(|(row, before)| *row |= before);
            }
            bitmaps
        };
        Self { plain: bits(|x, y| (x, y)), transposed: bits(|x, y| (y, x)) }
    }

    /// Writes the bitmaps of every radius, moved by `symmetry`.
    pub fn write(&self, symmetry: &Symmetry, out: &mut [[u8; BYTES]]) {
        let moves = symmetry.moves();
        for (radius, bitmap) in out.iter_mut().enumerate() {
            let faces = bitmap.as_chunks_mut::<{ BYTES / FACES }>().0;
            for (to, step) in faces.iter_mut().zip(&moves) {
                let faces = if step.transposed { &self.transposed[radius] } else { &self.plain[radius] };
                put(&faces[step.from], step, to);
            }
        }
    }
}

/// Writes `face`, mirrored as `step` says.
fn put(face: &Face, step: &Move, out: &mut [u8; BYTES / FACES]) {
    for (y, bytes) in out.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let row = face[if step.mirrored_y { SIDE - 1 - y } else { y }];
        *bytes = if step.mirrored_x { row.reverse_bits() } else { row }.to_le_bytes();
    }
}
