//! The tensors of a cluster as they are stored: ranks that are the same everywhere, light in Haar
//! coefficients, coefficients of vertices within [−1, 1].
//!
//! What light is multiplied with is the orthonormal Haar transform ([`haar`]) of the means of its radiance
//! over the texels of 6×8×8, or 6×2×2. These are the first coefficients of every face of a finer light of n×n
//! texels, divided by n/8, or n/2.

use super::FACE_SIZE;
use crate::compress::tucker2::{Tucker2, tucker2};
use half::f16;
use ndarray::{Array2, Array3, Array4, ArrayView3, Axis, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::cubemap::FACES;
use relume_formats::basis::{haar, sh};

/// Ranks of vertices and of light (docs/notes/TRANSFER-TENSOR.md).
pub const RANKS: [usize; 2] = [32, 32];
/// Coefficients of the light after one reflection, and after two.
pub const LIGHTS: [usize; 2] = [FACES * FACE_SIZE * FACE_SIZE, FACES * COARSE * COARSE];
/// Vectors of a cluster for light after two reflections.
pub const SECOND_RANK: usize = 16;
/// Texels along a side of a face of the light after two reflections (thesis §5.3.3.4).
const COARSE: usize = 2;
/// What counts as nothing, squared, in parts of all.
const NOTHING: f64 = 1e-14;

/// Light after one reflection at the vertices of a cluster. That of harmonic s and `column` at a vertex is
/// Σ_m u\[column, vertex, m\] Σ_n core\[column, m, n, s\] Σ_k light\[column, n, k\]·c_k, c being coefficients
/// of the light. Ranks beyond what there is are 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Packed {
    /// [columns, vertices, M], the largest magnitude of each m 1 or all of them 0.
    pub u: Array3<f32>,
    /// [columns, M, N, harmonics].
    pub core: Array4<f32>,
    /// [columns, N, 384], orthonormal or 0.
    pub light: Array3<f32>,
}

impl Packed {
    /// Of `tensors`, [vertices, columns, 384 texels, harmonics], to `ranks` of vertices and light.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn new(tensors: &Array4<f32>, ranks: [usize; 2]) -> Result<Self, LinalgError> {
        let (vertices, columns, texels, harmonics) = tensors.dim();
        let mut packed = Self {
            u: Array3::zeros((columns, vertices, ranks[0])),
            core: Array4::zeros((columns, ranks[0], ranks[1], harmonics)),
            light: Array3::zeros((columns, ranks[1], texels)),
        };
        let of_column = |c: usize| -> Result<Tucker2, LinalgError> {
            let mut found = tucker2(&tensors.slice(s![.., c..=c, .., ..]), ranks)?;
            balance(&mut found);
            Ok(found)
        };
        let all: Vec<Tucker2> = (0..columns).into_par_iter().map(of_column).collect::<Result<_, _>>()?;
        for (column, found) in all.iter().enumerate() {
            let (m, n, _) = found.core.dim();
            packed.u.slice_mut(s![column, .., ..m]).assign(&found.first.mapv(|x| x as f32));
            packed.core.slice_mut(s![column, ..m, ..n, ..]).assign(&found.core.mapv(|x| x as f32));
            packed.light.slice_mut(s![column, ..n, ..]).assign(&in_haar(&found.second).mapv(|x| x as f32));
        }
        Ok(packed)
    }

    /// What it stands for under lights, [384 coefficients, any]: [vertices, columns, harmonics, any].
    pub fn lit(&self, lights: &Array2<f32>) -> Array4<f32> {
        let (columns, vertices, m) = self.u.dim();
        let (harmonics, states) = (self.core.dim().3, lights.ncols());
        let mut all = Array4::zeros((vertices, columns, harmonics, states));
        for column in 0..columns {
            let light = self.light.index_axis(Axis(0), column).dot(lights);
            let mut core = Array2::zeros((m, harmonics * states));
            for (mut to, from) in
                core.outer_iter_mut().zip(self.core.index_axis(Axis(0), column).outer_iter())
            {
                to.assign(&from.t().dot(&light).flatten());
            }
            let of_column = self.u.index_axis(Axis(0), column).dot(&core);
            for (mut to, from) in all.outer_iter_mut().zip(of_column.rows()) {
                to.index_axis_mut(Axis(0), column).iter_mut().zip(from).for_each(|(to, from)| *to = *from);
            }
        }
        all
    }
}

/// Light after two reflections at the vertices of a cluster: that of `pair` is Σ_m u\[vertex, m\] Σ_k
/// vectors\[m, k, pair\]·c_k.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedSecond {
    /// [vertices, [`SECOND_RANK`]], the largest magnitude of each m 1 or all of them 0.
    pub u: Array2<f32>,
    /// [[`SECOND_RANK`], 24, pairs].
    pub vectors: Array3<f32>,
}

impl PackedSecond {
    /// Of `tensors`, [vertices, pairs, 24 coefficients].
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn new(tensors: &ArrayView3<'_, f32>) -> Result<Self, LinalgError> {
        let (vertices, pairs, lights) = tensors.dim();
        let mut packed = Self {
            u: Array2::zeros((vertices, SECOND_RANK)),
            vectors: Array3::zeros((SECOND_RANK, lights, pairs)),
        };
        // Of the full rank of light, so that vectors are free in both.
        let mut found = tucker2(&tensors.view().insert_axis(Axis(3)), [SECOND_RANK, lights])?;
        balance(&mut found);
        let rank = found.core.dim().0;
        packed.u.slice_mut(s![.., ..rank]).assign(&found.first.mapv(|x| x as f32));
        for (mut to, core) in packed.vectors.outer_iter_mut().zip(found.core.outer_iter()) {
            to.assign(&found.second.dot(&core).mapv(|x| x as f32));
        }
        Ok(packed)
    }

    /// What it stands for, [vertices, 24, pairs].
    pub fn whole(&self) -> Array3<f32> {
        let (rank, lights, pairs) = self.vectors.dim();
        let mut all = Array3::zeros((self.u.nrows(), lights, pairs));
        for k in 0..rank {
            for (mut to, u) in all.outer_iter_mut().zip(self.u.column(k)) {
                to.scaled_add(*u, &self.vectors.index_axis(Axis(0), k));
            }
        }
        all
    }
}

/// Makes the largest of every vector of the first mode 1, and those of nothing 0: their core is but rounding.
fn balance(found: &mut Tucker2) {
    let whole: f64 = found.core.iter().map(|x| x * x).sum();
    for (mut column, mut core) in found.first.columns_mut().into_iter().zip(found.core.outer_iter_mut()) {
        let own: f64 = core.iter().map(|x| x * x).sum();
        let largest = column.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if own > NOTHING * whole && largest > 0.0 {
            column.mapv_inplace(|x| x / largest);
            core.mapv_inplace(|x| x * largest);
        } else {
            column.fill(0.0);
            core.fill(0.0);
        }
    }
    for (mut column, core) in found.second.columns_mut().into_iter().zip(found.core.axis_iter(Axis(1))) {
        if core.iter().map(|x| x * x).sum::<f64>() <= NOTHING * whole {
            column.fill(0.0);
        }
    }
}

/// Columns of texels as rows of Haar coefficients.
fn in_haar(texels: &Array2<f64>) -> Array2<f64> {
    let mut rows = texels.t().as_standard_layout().into_owned();
    for mut row in rows.rows_mut() {
        if let Some(row) = row.as_slice_mut() {
            haar::forward_cube(row, FACE_SIZE);
        }
    }
    rows
}

/// What of the tensor of a vertex, [columns, 384 texels, harmonics], light after two reflections begins with:
/// for a light of 6×2×2, row-major [harmonics, columns, 24 Haar coefficients].
pub fn coarse(tensor: &ArrayView3<'_, f32>) -> Vec<f16> {
    let (columns, _, _) = tensor.dim();
    let mut coarse = Array3::<f32>::zeros((sh::COUNT, columns, LIGHTS[1]));
    let step = FACE_SIZE / COARSE;
    for (column, of_column) in tensor.outer_iter().enumerate() {
        for (texel, values) in of_column.outer_iter().enumerate() {
            let (row, x) = (texel / FACE_SIZE, texel % FACE_SIZE);
            let mut to = coarse.slice_mut(s![.., column, row / step * COARSE + x / step]);
            to += &values;
        }
    }
    let mut values = coarse.into_raw_vec_and_offset().0;
    haar::forward_cube(&mut values, COARSE);
    values.into_iter().map(f16::from_f32).collect()
}

/// The tensor of a vertex, [columns, 384 texels, harmonics], with Haar coefficients of the light for its
/// texels.
pub fn whole(tensor: &ArrayView3<'_, f32>) -> impl Iterator<Item = f16> + use<> {
    let mut by_light = tensor.view().permuted_axes([0, 2, 1]).as_standard_layout().into_owned();
    for mut row in by_light.rows_mut() {
        if let Some(row) = row.as_slice_mut() {
            haar::forward_cube(row, FACE_SIZE);
        }
    }
    let values = by_light.permuted_axes([0, 2, 1]).as_standard_layout().into_owned();
    values.into_iter().map(f16::from_f32)
}

#[cfg(test)]
pub(super) mod tests;
