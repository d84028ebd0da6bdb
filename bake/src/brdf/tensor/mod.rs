//! A BRDF space as a tensor of materials, outgoing and incoming directions, of low rank (thesis §5.3.1,
//! §5.3.3.1).
//!
//! First each lobe is split in mirror terms and a rest, then the rests of all materials are decomposed
//! together ([`crate::compress::tucker`]). Every lobe is divided by its norm before and multiplied by it
//! after, so that blunt materials, whose lobes are a thousandth of the sharp ones', are not given up for
//! these. Norms are over both directions with both cosines: what a white sky would show of an error.

mod comparison;
mod separation;
mod space;
mod table;

pub use comparison::Comparison;
pub use separation::{Fit, SOURCE_WIDTHS_DEG, Separation, Shapes, least_squares};
pub use space::{lobe_of, samples_of};

use crate::compress::linalg::single_thread;
use crate::compress::tucker::{Tucker, tucker};
use ndarray::{Array2, Array3, ArrayView1};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::disc::{self, AZIMUTHS, CELLS, RINGS};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::{Meta, Samples};
use relume_formats::state::Model;
use separation::Separator;
use std::f32::consts::FRAC_1_PI;
use table::{HALF, Points};

/// Columns that the source keeps of materials, by model, and of both directions.
pub fn ranks(model: Model) -> [usize; 3] {
    let of_materials = if model == Model::BlinnPhong { 3 } else { 4 };
    [of_materials, 8, 8]
}

/// The tensor of the space of `model`, at its samples, of the source's number of columns.
///
/// # Errors
/// If LAPACK does not converge.
pub fn make(model: Model) -> Result<BrdfTensor, LinalgError> {
    let space = SpaceTensor::new(model, samples_of(model), &Separation::default());
    Ok(space.decomposed(ranks(model))?.0)
}

/// The lobes of a space without their mirror terms.
pub struct SpaceTensor {
    model: Model,
    samples: Samples,
    /// Norm of each whole lobe.
    norms: Vec<f64>,
    widths_deg: Vec<f32>,
    /// [samples, [`RINGS`], terms].
    mirror: Vec<f32>,
    /// [samples, cells, cells], each value times the roots of both cells' areas, over the norm.
    rests: Array3<f64>,
    /// Mean over samples of the squared norm of the rest, in parts of the lobe's.
    residual: f64,
}

impl SpaceTensor {
    /// Tabulates the lobes of `model` at `samples`, split by `separation`.
    pub fn new(model: Model, samples: Samples, separation: &Separation) -> Self {
        let points = Points::new();
        let separator = Separator::new(&points, separation);
        let of_sample = |sample: usize| Lobe::new(model, &samples, sample, &points, &separator);
        let lobes: Vec<Lobe> = (0..samples.count()).into_par_iter().map(of_sample).collect();
        let mut rests = Array3::zeros((lobes.len(), CELLS, CELLS));
        let slices: Vec<_> = rests.outer_iter_mut().zip(&lobes).collect();
        slices.into_par_iter().for_each(|(mut slice, lobe)| {
            slice.indexed_iter_mut().for_each(|((out, from), value)| *value = lobe.at(out, from));
        });
        let squares: f64 = lobes.iter().map(|lobe| lobe.rest_norm_squared() / lobe.norm.powi(2)).sum();
        Self {
            model,
            residual: squares / lobes.len() as f64,
            norms: lobes.iter().map(|lobe| lobe.norm).collect(),
            widths_deg: separation.widths_deg.clone(),
            mirror: lobes.into_iter().flat_map(|lobe| lobe.mirror).collect(),
            samples,
            rests,
        }
    }

    /// What mirror terms leave, see [`Meta::residual`].
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// The samples, in whose order [`SpaceTensor::shares`] are.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Shares of the mirror terms, [samples, [`RINGS`], terms].
    pub fn shares(&self) -> &[f32] {
        &self.mirror
    }

    /// Of every sample the relative L2 norm of what mirror terms leave, and of what `tensor` misses of it
    /// over cells.
    pub fn errors_of(&self, tensor: &BrdfTensor) -> Vec<[f64; 2]> {
        let matrix = |values: &[f32], columns: usize, skipped: usize| {
            let rows = values.chunks_exact(columns.max(1));
            let rows = rows.flat_map(|row| row.iter().skip(skipped).map(|value| f64::from(*value)));
            Array2::from_shape_vec((CELLS, columns - skipped), rows.collect()).unwrap_or_default()
        };
        let [_, b, c] = tensor.ranks;
        let (outgoing, incoming) = (matrix(&tensor.outgoing, b, 0), matrix(&tensor.incoming, 1 + c, 1));
        let root = |cell: usize| disc::weight(cell / AZIMUTHS).sqrt();
        let of_sample = |sample: usize| {
            let core = tensor.core_of(&[(sample, 1.0)]).into_iter().map(f64::from).collect();
            let core = Array2::from_shape_vec((b, c), core).unwrap_or_default();
            let lobe = outgoing.dot(&core).dot(&incoming.t());
            let rests = self.rests.index_axis(ndarray::Axis(0), sample);
            let mut squares = [0.0, 0.0];
            for ((at, value), rest) in lobe.indexed_iter().zip(&rests) {
                let off = value * root(at.0) * root(at.1) / self.norms[sample] - rest;
                squares = [squares[0] + rest * rest, squares[1] + off * off];
            }
            squares.map(f64::sqrt)
        };
        single_thread();
        (0..self.norms.len()).into_par_iter().map(of_sample).collect()
    }

    /// The tensor of at most `ranks` columns, and how it was found.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn decomposed(&self, ranks: [usize; 3]) -> Result<(BrdfTensor, Tucker), LinalgError> {
        let found = tucker(&self.rests, ranks)?;
        let [of_materials, of_outgoing, of_incoming] = &found.factors;
        let of_sample = |(row, norm): (ArrayView1<'_, f64>, &f64)| scaled(&row, *norm);
        let materials = of_materials.rows().into_iter().zip(&self.norms).flat_map(of_sample).collect();
        let [materials_error, outgoing_error, incoming_error] = found.errors.of_modes;
        let tensor = BrdfTensor {
            meta: Meta {
                model: self.model,
                residual: self.residual,
                materials: self.residual * materials_error,
                outgoing: self.residual * outgoing_error,
                incoming: self.residual * incoming_error,
                whole: self.residual * found.errors.whole,
            },
            samples: self.samples.clone(),
            ranks: [of_materials, of_outgoing, of_incoming].map(Array2::ncols),
            core: found.core.iter().map(|value| *value as f32).collect(),
            materials,
            outgoing: over_cells(of_outgoing, None),
            incoming: over_cells(of_incoming, Some(FRAC_1_PI)),
            widths_deg: self.widths_deg.clone(),
            mirror: self.mirror.clone(),
        };
        Ok((tensor, found))
    }
}

fn scaled(row: &ArrayView1<'_, f64>, factor: f64) -> Vec<f32> {
    row.iter().map(|value| (value * factor) as f32).collect()
}

/// Columns that are orthonormal, as columns that are so by areas of cells, behind one of the value `first`.
fn over_cells(columns: &Array2<f64>, first: Option<f32>) -> Vec<f32> {
    let rows = columns.rows().into_iter().enumerate();
    rows.flat_map(|(cell, row)| {
        let root = disc::weight(cell / AZIMUTHS).sqrt();
        first.into_iter().chain(scaled(&row, 1.0 / root))
    })
    .collect()
}

/// One lobe over cells. As it is the same in all azimuths, the outgoing directions of one azimuth tell all,
/// and half of the incoming ones.
struct Lobe {
    /// [outgoing rings, incoming rings, [`HALF`]], sr⁻¹: means over cells by area, without mirror terms.
    rest: Vec<f64>,
    /// [outgoing rings, terms].
    mirror: Vec<f32>,
    /// Of all of it, mirror terms included.
    norm: f64,
}

impl Lobe {
    fn new(model: Model, samples: &Samples, sample: usize, points: &Points, separator: &Separator) -> Self {
        let lobe = lobe_of(model, samples, sample);
        let (mut rest, mut mirror, mut squares) = (Vec::new(), Vec::new(), 0.0);
        for ring in 0..RINGS {
            let arriving = points.arriving(&lobe, disc::direction(ring * AZIMUTHS));
            squares += squared_norm(&points.over_cells(&arriving), ring);
            let (shares, left) = separator.split(ring, &arriving);
            mirror.extend(shares);
            rest.extend(points.over_cells(&left));
        }
        Self { rest, mirror, norm: squares.sqrt() }
    }

    /// Value of the tensor.
    fn at(&self, out: usize, from: usize) -> f64 {
        let ring = |cell: usize| cell / AZIMUTHS;
        let turned = (from % AZIMUTHS + AZIMUTHS - out % AZIMUTHS) % AZIMUTHS;
        let value = self.rest[(ring(out) * RINGS + ring(from)) * HALF + turned.min(AZIMUTHS - turned)];
        value * (disc::weight(ring(out)) * disc::weight(ring(from))).sqrt() / self.norm
    }

    fn rest_norm_squared(&self) -> f64 {
        self.rest.chunks_exact(RINGS * HALF).enumerate().map(|(ring, row)| squared_norm(row, ring)).sum()
    }
}

/// Over all cells of incoming directions, and all outgoing ones of `ring`.
fn squared_norm(row: &[f64], ring: usize) -> f64 {
    let of_cell = |(cell, value): (usize, &f64)| {
        let azimuth = cell % HALF;
        let times = if azimuth == 0 || azimuth == HALF - 1 { 1.0 } else { 2.0 };
        times * disc::weight(cell / HALF) * value * value
    };
    let sum: f64 = row.iter().enumerate().map(of_cell).sum();
    sum * disc::weight(ring) * AZIMUTHS as f64
}

#[cfg(test)]
mod tests;
