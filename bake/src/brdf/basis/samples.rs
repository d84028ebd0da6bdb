//! What bases of all models are made of, and how far off they are.

use ndarray::{Array2, ShapeBuilder as _};
use rayon::prelude::*;
use relume_formats::kinds::brdf_basis::BasisError;

/// The matrix that the PCA runs on, a column for each sample, and how each column was made from its lobe.
pub struct Samples {
    /// As it is decomposed.
    pub matrix: Array2<f64>,
    /// For each sample: the factor on its lobe.
    pub scale: Vec<f64>,
    /// For each sample: how much of the diffuse lobe was taken away after scaling.
    pub diffuse_share: Vec<f64>,
}

impl Samples {
    /// `lobes` gives each sample's lobe, tabulated as `diffuse` is, and its factor.
    pub fn new(lobes: &[(Vec<f64>, f64)], diffuse: &[f64], shared_diffuse: bool) -> Self {
        let diffuse_squared = dot(diffuse, diffuse);
        // Columns are contiguous.
        let mut matrix = Array2::zeros((diffuse.len(), lobes.len()).f());
        let (mut scale, mut diffuse_share) = (Vec::new(), Vec::new());
        for (mut column, (lobe, factor)) in matrix.columns_mut().into_iter().zip(lobes) {
            let share = if shared_diffuse { factor * dot(lobe, diffuse) / diffuse_squared } else { 0.0 };
            for (value, (l, d)) in column.iter_mut().zip(lobe.iter().zip(diffuse)) {
                *value = factor * l - share * d;
            }
            scale.push(*factor);
            diffuse_share.push(share);
        }
        Self { matrix, scale, diffuse_share }
    }
}

/// The inner product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The columns, all of one length, with the values of a row beside one another.
pub fn interleaved(columns: &[Vec<f64>]) -> Vec<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
}

/// The inner products of `a` with each of so many interleaved `columns`, summed as [`dot`] does. Side by
/// side, for one sum alone waits for each of its additions.
pub fn dots(a: &[f64], columns: &[f64], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for (a, row) in a.iter().zip(columns.chunks_exact(count.max(1))) {
        sums.iter_mut().zip(row).for_each(|(sum, b)| *sum += a * b);
    }
    sums
}

/// No error yet.
pub fn unmeasured() -> BasisError {
    BasisError { mean: f64::NAN, worst: f64::NAN, worst_at: f64::NAN }
}

/// Mean and worst of `error` over `parameters`.
pub fn errors_of(parameters: &[f32], error: impl Fn(&f32) -> f64 + Send + Sync) -> BasisError {
    let errors: Vec<f64> = parameters.par_iter().map(error).collect();
    let worse = |w: (f64, f64), (e, at): (&f64, &f32)| if *e > w.0 { (*e, f64::from(*at)) } else { w };
    let (worst, worst_at) = errors.iter().zip(parameters).fold((0.0, 0.0), worse);
    BasisError { mean: errors.iter().sum::<f64>() / errors.len() as f64, worst, worst_at }
}
