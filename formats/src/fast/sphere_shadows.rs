//! Method `sphere-shadows` for many receivers: the same radiance as [`crate::evaluate::sphere_shadows`] gives.
//!
//! * Receivers go in groups of 16, a lane each: caps are added to all of their bitmaps at once, row by row ([`caps`]). Only rows that the cap reaches
//!   for one of them are looked at, so receivers that follow each other should be near each other.
//! * With light and lobe given, the product is linear in the visibility, whatever terms and levels are kept. So both are folded once per change of the light
//!   into one weight per lobe and tile ([`fold`]), and a receiver's radiance is the sum of its tiles' visible texels times these ([`sum`]). The
//!   second level of visibility enters at the few tiles where light has kept terms of it.
//! * A blend of lobes is the blend of their sums.

mod caps;
mod fold;
mod sum;

use crate::evaluate::sphere_shadows::{Function, Levels, Receiver, Spheres};
use crate::kinds::HaarTable;
use crate::state::Rgb;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Receivers of a group.
const LANES: usize = 16;

/// One value for each receiver of a group.
type Lanes<T> = [T; LANES];

/// Light and lobes, folded.
#[derive(Debug)]
pub struct Shading {
    weights: fold::Weights,
    arch: Arch,
}

impl Shading {
    /// Folds `light` into each of `lobes`; to be done anew when either changes.
    pub fn new(lobes: &[Function], light: &[Function; 3], levels: Levels) -> Self {
        Self { weights: fold::Weights::new(lobes, light, levels), arch: Arch::new() }
    }

    /// Linear radiance that a white diffuse surface shows at each receiver, W/(sr·m²), to `out`.
    ///
    /// # Panics
    /// If a receiver has a lobe that was not given.
    pub fn radiance(&self, receivers: &[Receiver], sets: &[Spheres], table: &HaarTable, out: &mut [Rgb]) {
        receivers.par_chunks(LANES).zip(out.par_chunks_mut(LANES)).for_each(|(receivers, out)| {
            self.arch.dispatch(Group { receivers, sets, table, weights: &self.weights, out });
        });
    }
}

/// What is done for a group.
struct Group<'a> {
    receivers: &'a [Receiver],
    sets: &'a [Spheres],
    table: &'a HaarTable,
    weights: &'a fold::Weights,
    out: &'a mut [Rgb],
}

impl WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let rows = caps::blocked(self.receivers, self.sets);
        sum::radiance(&rows, self.receivers, self.weights, self.table, self.out);
    }
}
