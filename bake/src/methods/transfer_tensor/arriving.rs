//! Light at vertices before any reflection, by texels of a coarse light.

use crate::error::Result;
use crate::methods::sparse_transfer::texels::{FACE_SIZE as FINE, Texels, summed};
use crate::methods::sparse_transfer::visibility::transfer_row;
use crate::trace::receivers::Receiver;
use crate::trace::world::World;
use rayon::prelude::*;
use relume_formats::basis::cubemap::FACES;
use std::f32::consts::PI;

/// ∫ V·max(0, n·ω) dω over the texels of a cube of light, at every vertex, where that is above 0.
pub struct Arriving {
    /// Texels along a side of a face of the light.
    pub face_size: usize,
    /// By vertex, texels in their order with their integrals, sr.
    rows: Vec<Vec<(u16, f32)>>,
}

impl Arriving {
    /// At `receivers`, for a light of `face_size`² texels a face, a power of two of at most 64: visibility is
    /// found for 6×64×64 texels ([`transfer_row`]) and summed, with the cosine, over those of each texel of
    /// the light.
    pub fn new(receivers: &[Receiver], world: &World, face_size: usize) -> Self {
        let texels = Texels::new(1);
        let at = |row: &mut Vec<f32>, receiver: &Receiver| {
            transfer_row(receiver, world, &texels, row);
            coarse(row, face_size)
        };
        let rows = receivers.par_iter().map_init(|| vec![0.0; FACES * FINE * FINE], at).collect();
        Self { face_size, rows }
    }

    /// The same from rows that are there already: `rows` gives those of a piece of so many `pieces` in their order.
    ///
    /// # Errors
    /// Those of `rows`.
    pub fn of_rows(
        pieces: usize,
        face_size: usize,
        rows: impl Fn(usize, &mut dyn FnMut(&[f32])) -> Result<()> + Sync,
    ) -> Result<Self> {
        let of_piece = |piece: usize| {
            let mut sums = Vec::new();
            rows(piece, &mut |row| sums.push(coarse(row, face_size)))?;
            Ok(sums)
        };
        let pieces = (0..pieces).into_par_iter().map(of_piece).collect::<Result<Vec<_>>>()?;
        Ok(Self { face_size, rows: pieces.into_iter().flatten().collect() })
    }

    /// What would arrive if nothing stood in the way.
    pub fn open(receivers: &[Receiver], texels: &Texels, face_size: usize) -> Self {
        let of_receiver = |receiver: &Receiver| {
            let open = texels.centres.directions().iter().zip(&texels.weights);
            let row: Vec<f32> = open.map(|(d, weight)| receiver.normal.dot(*d).max(0.0) * weight).collect();
            coarse(&row, face_size)
        };
        Self { face_size, rows: receivers.par_iter().map(of_receiver).collect() }
    }

    /// What arrives at `vertex`.
    pub fn at(&self, vertex: usize) -> &[(u16, f32)] {
        &self.rows[vertex]
    }

    /// Texels of the light.
    pub fn texels(&self) -> usize {
        FACES * self.face_size * self.face_size
    }

    /// The same for a light of `face_size`² texels a face, which is no finer.
    pub fn coarser(&self, face_size: usize) -> Self {
        let sum = |row: &Vec<(u16, f32)>| {
            let mut plane = vec![0.0; self.texels()];
            row.iter().for_each(|(texel, value)| plane[usize::from(*texel)] = *value);
            let sums = summed(&plane, self.face_size, face_size);
            (0..).zip(sums).filter(|(_, sum)| *sum > 0.0).collect()
        };
        Self { face_size, rows: self.rows.par_iter().map(sum).collect() }
    }
}

/// The texels of a light of `face_size`² a face that anything arrives from, with V·cos integrated over them.
fn coarse(row: &[f32], face_size: usize) -> Vec<(u16, f32)> {
    let lit = (0..).zip(summed(row, FINE, face_size)).filter(|(_, sum)| *sum > 0.0);
    lit.map(|(texel, sum)| (texel, sum * PI)).collect()
}
