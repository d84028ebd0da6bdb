//! Rows as coefficients of vectors that move smoothly from row to row (Silvennoinen and Sloan 2021, "Moving
//! basis decomposition for precomputed light transport"): x_v ≈ Σᵢ c_v(i) · Σₖ w_v(k)·B_k(i), the w of a row
//! being shares of nodes around it. Clusters are what that is if each row has one node alone; if shares fade
//! to 0 no row has another basis than its neighbours.
//!
//! Nodes and coefficients are found in turns, each the best beside the other: the coefficients of a row by
//! themselves, the nodes all at once, for what they are multiplied with is the same for all columns. It
//! begins with the leading singular vectors of all rows, the same at all nodes.

use super::linalg::{inverse_of_positive, orthonormal, single_thread};
use ndarray::{Array1, Array2, ArrayView2, Axis, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;

/// Turns by which the beginning is found.
const FIRST_TURNS: usize = 4;
/// What is added to the diagonal of normal matrices, in parts of its mean: coefficients that hardly matter
/// stay small.
const RIDGE: f64 = 1e-7;
/// Columns that are multiplied at once, whatever the number of cores.
const BLOCK: usize = 512;

/// What share each of some nodes has in a row.
pub type Shares = Vec<(usize, f32)>;

/// Nodes and coefficients.
pub struct MovingBasis {
    /// [nodes · rank, columns]: the vectors of a node follow one another.
    pub nodes: Array2<f32>,
    /// [rows, rank].
    pub coefficients: Array2<f32>,
    /// ‖x − x̂‖²/‖x‖² over all rows; 0 of zeros.
    pub error: f64,
}

/// Decomposes `rows`, [rows, columns], to `rank` vectors at each of `nodes` nodes in `turns` turns. `shares`
/// has those of each row.
///
/// # Errors
/// If LAPACK does not converge.
pub fn moving_basis(
    rows: &ArrayView2<'_, f32>,
    shares: &[Shares],
    (nodes, rank): (usize, usize),
    turns: usize,
) -> Result<MovingBasis, LinalgError> {
    single_thread();
    let rank = rank.min(rows.nrows()).min(rows.ncols());
    let alone: Vec<Shares> = shares.iter().map(|_| vec![(0, 1.0)]).collect();
    let start = Array2::from_shape_fn((rows.ncols(), rank), |(i, j)| {
        (((i * rank + j + 1) as f64 * 0.618_033_988_749_894_9).fract() * 7919.0).fract() as f32 - 0.5
    });
    let mut coefficients = rows.dot(&start);
    for _ in 0..FIRST_TURNS {
        // Orthonormal coefficients keep the normal matrices sound.
        coefficients = orthonormal(&coefficients.mapv(f64::from))?.mapv(|x| x as f32);
        let basis = solved_nodes(rows, &alone, 1, &coefficients)?;
        coefficients = solved_coefficients(rows, &alone, (&basis, rank))?.0;
    }
    let mut result = MovingBasis { nodes: Array2::zeros((0, rows.ncols())), coefficients, error: 0.0 };
    let whole: f64 = rows.iter().map(|x| f64::from(*x).powi(2)).sum();
    for _ in 0..turns {
        result.nodes = solved_nodes(rows, shares, nodes, &result.coefficients)?;
        let (coefficients, left) = solved_coefficients(rows, shares, (&result.nodes, rank))?;
        result.coefficients = coefficients;
        result.error = if whole > 0.0 { (left / whole).max(0.0) } else { 0.0 };
    }
    Ok(result)
}

/// The nodes that are best with these coefficients.
fn solved_nodes(
    rows: &ArrayView2<'_, f32>,
    shares: &[Shares],
    nodes: usize,
    coefficients: &Array2<f32>,
) -> Result<Array2<f32>, LinalgError> {
    let rank = coefficients.ncols();
    let mut factors = Array2::<f32>::zeros((rows.nrows(), nodes * rank));
    for ((mut row, shares), own) in factors.rows_mut().into_iter().zip(shares).zip(coefficients.rows()) {
        for (node, share) in shares {
            row.slice_mut(s![node * rank..(node + 1) * rank]).scaled_add(*share, &own);
        }
    }
    let exact = factors.mapv(f64::from);
    let inverse = inverse_of_positive(&ridged(exact.t().dot(&exact)))?;
    let mut found = Array2::zeros((nodes * rank, rows.ncols()));
    let blocks: Vec<_> =
        found.axis_chunks_iter_mut(Axis(1), BLOCK).zip(rows.axis_chunks_iter(Axis(1), BLOCK)).collect();
    blocks.into_par_iter().for_each(|(mut to, rows)| {
        to.assign(&inverse.dot(&factors.t().dot(&rows).mapv(f64::from)).mapv(|x| x as f32));
    });
    Ok(found)
}

/// The coefficients that are best with these nodes, and what is left of all rows, squared.
fn solved_coefficients(
    rows: &ArrayView2<'_, f32>,
    shares: &[Shares],
    (nodes, rank): (&Array2<f32>, usize),
) -> Result<(Array2<f32>, f64), LinalgError> {
    let gram = nodes.dot(&nodes.t()).mapv(f64::from);
    let blocks: Vec<_> = rows.axis_chunks_iter(Axis(0), BLOCK).zip(shares.chunks(BLOCK)).collect();
    let of_block = |(rows, shares): (ArrayView2<'_, f32>, &[Shares])| -> Result<_, LinalgError> {
        let along = rows.dot(&nodes.t());
        let mut found = Array2::<f32>::zeros((rows.nrows(), rank));
        let mut left = 0.0;
        for (((row, along), shares), mut to) in
            rows.rows().into_iter().zip(along.rows()).zip(shares).zip(found.rows_mut())
        {
            let (mut right, mut own) = (Array1::<f64>::zeros(rank), Array2::<f64>::zeros((rank, rank)));
            for (a, of_a) in shares {
                right
                    .scaled_add(f64::from(*of_a), &along.slice(s![a * rank..(a + 1) * rank]).mapv(f64::from));
                for (b, of_b) in shares {
                    let both = gram.slice(s![a * rank..(a + 1) * rank, b * rank..(b + 1) * rank]);
                    own.scaled_add(f64::from(of_a * of_b), &both);
                }
            }
            let coefficients = inverse_of_positive(&ridged(own.clone()))?.dot(&right);
            let size: f64 = row.iter().map(|x| f64::from(*x).powi(2)).sum();
            left += size - 2.0 * coefficients.dot(&right) + coefficients.dot(&own.dot(&coefficients));
            to.assign(&coefficients.mapv(|x| x as f32));
        }
        Ok((found, left))
    };
    let blocks: Vec<(Array2<f32>, f64)> = blocks.into_par_iter().map(of_block).collect::<Result<_, _>>()?;
    let mut all = Array2::zeros((rows.nrows(), rank));
    let mut first = 0;
    let mut left = 0.0;
    for (found, of_block) in blocks {
        all.slice_mut(s![first..first + found.nrows(), ..]).assign(&found);
        first += found.nrows();
        left += of_block;
    }
    Ok((all, left))
}

/// With a little on the diagonal.
fn ridged(mut normal: Array2<f64>) -> Array2<f64> {
    let mean = normal.diag().sum() / normal.nrows().max(1) as f64;
    // Of nothing but zeros the solution is zero, whatever divides.
    let more = if mean > 0.0 { RIDGE * mean } else { 1.0 };
    normal.diag_mut().mapv_inplace(|x| x + more);
    normal
}

/// Shares of nodes at `centres`, [nodes, any], in rows at `places`, [rows, any]: (1 − d/r)², normalised, r
/// being the distance to the node behind the nearest `count`, where shares fade to 0; the nodes in their
/// order.
pub fn shares(places: &ArrayView2<'_, f32>, centres: &ArrayView2<'_, f32>, count: usize) -> Vec<Shares> {
    let of_place = |place: ndarray::ArrayView1<'_, f32>| {
        let distance = |centre: ndarray::ArrayView1<'_, f32>| (&place - &centre).mapv(|x| x * x).sum().sqrt();
        let distances: Vec<f32> = centres.rows().into_iter().map(distance).collect();
        let mut sorted = distances.clone();
        sorted.sort_by(f32::total_cmp);
        // With no more nodes than are asked for all of them count, to twice the farthest.
        let reach = sorted.get(count).copied().or_else(|| sorted.last().map(|far| 2.0 * far));
        let reach = reach.unwrap_or(0.0).max(f32::MIN_POSITIVE);
        let share = |distance: &f32| (1.0 - distance / reach).max(0.0).powi(2);
        let some: Shares =
            distances.iter().map(share).enumerate().filter(|(_, share)| *share > 0.0).collect();
        let total: f32 = some.iter().map(|(_, share)| share).sum();
        if total <= 0.0 {
            // As many nodes as that, and one more, are equally far.
            let nearest = distances.iter().position(|d| *d == sorted[0]);
            return nearest.map(|node| (node, 1.0)).into_iter().collect();
        }
        some.into_iter().map(|(node, share)| (node, share / total)).collect()
    };
    places.rows().into_iter().map(of_place).collect()
}

#[cfg(test)]
mod tests;
