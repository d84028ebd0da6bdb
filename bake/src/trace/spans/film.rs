//! What a look leaves behind: the texels that are free, or what is nearest behind each.

use super::rays::TexelRays;
use super::set::{TexelSet, mask};
use super::triangle::Met;
use crate::trace::wide::Found;
use crate::trace::wide::lanes::{LANES, Lanes, lanes_of};

/// Texels of a row that lie in one word of it: row and word.
pub(super) type Place = (usize, usize);

/// What triangles leave on texels.
pub(super) trait Film {
    /// Whether a triangle that covers a texel wholly needs no test of it.
    const KEEPS_NO_HITS: bool;

    /// Texels that triangles may leave something on.
    fn open(&self) -> &TexelSet;

    /// Whether something of at least this distance along the axis of the face may leave anything on texels in
    /// `columns` of `rows`, both ends included.
    fn takes(&self, near: f32, rows: [usize; 2], columns: [usize; 2]) -> bool;

    /// A triangle is found behind one texel.
    fn hit(&mut self, place: Place, texel: usize, found: Found);

    /// One is hit at some of eight texels, from texel `first` of the word on, as `met` has it.
    fn hits<L: Lanes>(&mut self, simd: L, place: Place, first: u32, lanes: u32, met: &Met<L>);

    /// One covers `columns` of `row`.
    fn covered(&mut self, row: usize, columns: [usize; 2]);
}

/// Texels before which nothing stands.
impl Film for TexelSet {
    const KEEPS_NO_HITS: bool = true;

    #[inline(always)]
    fn open(&self) -> &TexelSet {
        self
    }

    #[inline(always)]
    fn takes(&self, _: f32, [first, last]: [usize; 2], columns: [usize; 2]) -> bool {
        self.any(first..=last, columns)
    }

    #[inline(always)]
    fn hit(&mut self, (row, word): Place, texel: usize, _: Found) {
        self.remove(row, word, 1 << texel);
    }

    #[inline(always)]
    fn hits<L: Lanes>(&mut self, _: L, (row, word): Place, first: u32, lanes: u32, _: &Met<L>) {
        self.remove(row, word, u64::from(lanes) << first);
    }

    #[inline(always)]
    fn covered(&mut self, row: usize, columns: [usize; 2]) {
        self.remove_all(row, columns);
    }
}

/// The nearest triangle behind each texel.
pub(super) struct Nearest<'a> {
    asked: &'a TexelSet,
    rays: &'a TexelRays,
    /// The number of each triangle as it was given: of two at the same distance the lower counts.
    order: &'a [u32],
    /// By texel; infinite where nothing is.
    distances: Vec<[f32; LANES]>,
    found: Vec<Option<Found>>,
}

impl<'a> Nearest<'a> {
    /// Nothing behind any of the `asked` texels.
    pub fn new(asked: &'a TexelSet, rays: &'a TexelRays, order: &'a [u32]) -> Self {
        let texels = rays.directions().len();
        let distances = vec![[f32::INFINITY; LANES]; texels / LANES];
        Self { asked, rays, order, distances, found: vec![None; texels] }
    }

    /// What is behind each texel.
    pub fn into_found(self) -> Vec<Option<Found>> {
        self.found
    }

    fn eight(&self, row: usize, x: usize) -> usize {
        (row * self.asked.face_size() + x) / LANES
    }
}

impl Film for Nearest<'_> {
    const KEEPS_NO_HITS: bool = false;

    #[inline(always)]
    fn open(&self) -> &TexelSet {
        self.asked
    }

    #[inline(always)]
    fn takes(&self, near: f32, [first, last]: [usize; 2], columns: [usize; 2]) -> bool {
        for row in first..=last {
            for word in columns[0] / 64..=columns[1] / 64 {
                let mut open = self.asked.word(row, word) & mask(word, columns);
                while open != 0 {
                    let at = open.trailing_zeros() & !(LANES as u32 - 1);
                    let x = word * 64 + at as usize;
                    let (distances, rays) = (&self.distances[self.eight(row, x)], self.rays.eight(row, x));
                    let mut beyond = 0;
                    for (lane, (distance, along)) in distances.iter().zip(&rays.along).enumerate() {
                        beyond |= u64::from(near * along.abs() <= *distance) << lane;
                    }
                    if open >> at & beyond != 0 {
                        return true;
                    }
                    open &= !(0xff << at);
                }
            }
        }
        false
    }

    #[inline(always)]
    fn hit(&mut self, (row, word): Place, texel: usize, found: Found) {
        let x = word * 64 + texel;
        let (eight, lane) = (self.eight(row, x), x % LANES);
        let nearest = &mut self.distances[eight][lane];
        let known = &mut self.found[eight * LANES + lane];
        let given = |found: &Found| self.order[found.number() as usize];
        let comes_first = |other: &Found| given(&found) < given(other);
        let distance = found.hit.t;
        if distance < *nearest || (distance == *nearest && known.as_ref().is_some_and(comes_first)) {
            *nearest = distance;
            *known = Some(found);
        }
    }

    #[inline(always)]
    fn hits<L: Lanes>(&mut self, simd: L, place: Place, first: u32, lanes: u32, met: &Met<L>) {
        let nearest = simd.load(&self.distances[self.eight(place.0, place.1 * 64 + first as usize)]);
        let lanes = lanes & simd.bits(simd.le(met.distances, nearest));
        for lane in lanes_of(lanes) {
            self.hit(place, first as usize + lane, met.found(simd, lane));
        }
    }

    #[inline(always)]
    fn covered(&mut self, _: usize, _: [usize; 2]) {}
}
