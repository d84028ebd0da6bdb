//! Light at vertices before any reflection, by texels of a coarse light.

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
            let sums = summed(row, FINE, face_size);
            let lit = (0..).zip(sums).filter(|(_, sum)| *sum > 0.0);
            lit.map(|(texel, sum)| (texel, sum * PI)).collect()
        };
        let rows = receivers.par_iter().map_init(|| vec![0.0; FACES * FINE * FINE], at).collect();
        Self { face_size, rows }
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
