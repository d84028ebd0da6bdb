//! Against tensors of known rank, LAPACK's decomposition of matrices, and sums written out.

use super::*;
use ndarray_linalg::{JobSvd, QR as _, SVDDC as _};

/// About as independent as a hash can make them, −½ to ½.
fn noise(seed: usize) -> f64 {
    let hash = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) as f64 / u64::MAX as f64 - 0.5
}

fn matrix(rows: usize, columns: usize, seed: usize) -> Array2<f64> {
    Array2::from_shape_fn((rows, columns), |(i, j)| noise(seed + i * columns + j))
}

fn random(shape: [usize; 3], seed: usize) -> Array3<f64> {
    let [a, b, c] = shape;
    Array3::from_shape_fn((a, b, c), |(i, j, k)| noise(seed + (i * b + j) * c + k))
}

/// Of exactly these ranks, with the subspaces of its modes.
fn of_ranks(shape: [usize; 3], ranks: [usize; 3]) -> (Array3<f64>, [Array2<f64>; 3]) {
    let factors = [0, 1, 2].map(|mode| matrix(shape[mode], ranks[mode], 1000 * (mode + 1)).qr().unwrap().0);
    let core = random(ranks, 7);
    let tensor = (0..MODES).fold(core, |tensor, mode| times(&tensor, mode, &factors[mode].t().to_owned()));
    (tensor, factors)
}

/// Sine of the largest angle between what the columns of two matrices span.
fn largest_angle(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    let rest = a - &b.dot(&b.t().dot(a));
    rest.svddc(JobSvd::None).unwrap().1[0]
}

/// The higher-order singular value decomposition that the search begins with, its core included.
fn hosvd(tensor: &Array3<f64>, ranks: [usize; MODES]) -> Result<Tucker, LinalgError> {
    let factors = started(tensor, within(tensor.dim(), ranks))?;
    let core = projected(tensor, &factors);
    Ok(Tucker { errors: errors(tensor, &factors, &core), core, factors, sweeps: 0 })
}

fn distance(a: &Array3<f64>, b: &Array3<f64>) -> f64 {
    squared_norm(&(a - b)) / squared_norm(a)
}

fn assert_orthonormal(columns: &Array2<f64>) {
    let error = &columns.t().dot(columns) - &Array2::<f64>::eye(columns.ncols());
    assert!(error.iter().all(|e| e.abs() < 1e-12), "{error}");
}

#[test]
fn a_tensor_of_low_rank_is_found_whole() {
    for (shape, ranks) in [([9, 30, 20], [3, 4, 5]), ([40, 7, 8], [6, 3, 2]), ([5, 5, 60], [1, 4, 4])] {
        let (tensor, factors) = of_ranks(shape, ranks);
        let found = tucker(&tensor, ranks).unwrap();
        assert_eq!(found.core.dim(), (ranks[0], ranks[1], ranks[2]));
        // Singular vectors come from the Gram matrix, whose rounding is the square root of a small angle.
        for (found, factor) in found.factors.iter().zip(&factors) {
            assert_orthonormal(found);
            assert!(largest_angle(found, factor) < 1e-6);
        }
        assert!(distance(&tensor, &found.rebuilt()) < 1e-20 && found.errors.whole < 1e-12);
        // Rank to spare loses nothing, and what cannot be of use is left out.
        let more = tucker(&tensor, [100, 100, 100]).unwrap();
        assert!(more.core.dim().0 <= shape[0] && distance(&tensor, &more.rebuilt()) < 1e-20);
    }
}

/// A tensor of one slice is a matrix, of which Eckart and Young have the best.
#[test]
fn a_matrix_is_decomposed_as_by_singular_values() {
    let tensor = random([12, 31, 1], 3);
    let matrix = tensor.index_axis(Axis(2), 0).to_owned();
    let (_, values, _) = matrix.svddc(JobSvd::None).unwrap();
    for rank in 1..12 {
        let found = tucker(&tensor, [rank, rank, 1]).unwrap();
        let lost: f64 = values.iter().skip(rank).map(|s| s * s).sum();
        let whole: f64 = values.iter().map(|s| s * s).sum();
        assert!((found.errors.whole - lost / whole).abs() < 1e-12, "rank {rank}");
        assert!((found.errors.of_modes[0] - lost / whole).abs() < 1e-12 && found.errors.of_modes[2] < 1e-12);
        for (column, value) in found.core.index_axis(Axis(2), 0).diag().iter().zip(&values) {
            assert!((column.abs() - value).abs() < 1e-10, "the core is diagonal");
        }
    }
}

#[test]
fn errors_are_those_of_what_is_rebuilt_and_never_above_the_start() {
    for seed in 0..6 {
        let tensor = random([11, 17, 13], 10_000 * seed);
        let mut last = 1.0;
        for rank in [1, 2, 4, 8] {
            let [first, found] = [hosvd, tucker].map(|by| by(&tensor, [rank, rank + 1, rank]).unwrap());
            for by in [&first, &found] {
                assert!((by.errors.whole - distance(&tensor, &by.rebuilt())).abs() < 1e-12);
                // Whoever truncates all modes loses at least what any of them alone does, and at most their
                // sum.
                let [a, b, c] = by.errors.of_modes;
                assert!(by.errors.whole >= a.max(b).max(c) - 1e-12 && by.errors.whole <= a + b + c + 1e-12);
            }
            assert!(found.errors.whole <= first.errors.whole + 1e-12 && found.errors.whole < last);
            assert!((1..=SWEEPS).contains(&found.sweeps));
            last = found.errors.whole;
        }
    }
}

#[test]
fn nothing_is_decomposed_to_nothing() {
    let found = tucker(&Array3::zeros((4, 5, 6)), [2, 2, 2]).unwrap();
    assert_eq!(found.errors, TuckerErrors { of_modes: [0.0; 3], whole: 0.0 });
    assert!(found.core.iter().all(|z| *z == 0.0));
    found.factors.iter().for_each(assert_orthonormal);
}

/// Something that is the same in all azimuths: its singular values come in pairs, one of which the rank cuts
/// in two. Rounding must not choose.
#[test]
fn equal_singular_values_are_ordered_by_rule() {
    const N: usize = 24;
    let angle = |i: usize, j: usize| std::f64::consts::TAU * (i as f64 - j as f64) / N as f64;
    let kernel = |h: usize, i: usize, j: usize| ((2.0 + h as f64) * angle(i, j).cos()).exp();
    let sound = Array3::from_shape_fn((5, N, N), |(h, i, j)| kernel(h, i, j));
    let shaken = Array3::from_shape_fn((5, N, N), |(h, i, j)| {
        kernel(h, i, j) * (1.0 + 1e-14 * noise((h * N + i) * N + j))
    });
    for rank in 1..=8 {
        let [a, b] = [&sound, &shaken].map(|tensor| tucker(tensor, [3, rank, rank]).unwrap());
        for (a, b) in a.factors.iter().zip(&b.factors) {
            let off = (a - b).iter().fold(0.0f64, |most, x| most.max(x.abs()));
            assert!(off < 1e-5, "rank {rank}: columns differ by {off}");
        }
    }
}

#[test]
fn signs_are_fixed() {
    let tensor = random([6, 9, 7], 77);
    let [a, b] = [tensor.clone(), -tensor].map(|tensor| tucker(&tensor, [3, 3, 3]).unwrap());
    for (a, b) in a.factors.iter().zip(&b.factors) {
        assert!((a - b).iter().all(|x| x.abs() < 1e-9));
        for column in a.columns() {
            let largest = column.iter().copied().max_by(|x, y| x.abs().total_cmp(&y.abs())).unwrap();
            assert!(largest > 0.0);
        }
    }
    assert!((&a.core + &b.core).iter().all(|x| x.abs() < 1e-9));
}

#[test]
fn threads_do_not_change_a_bit() {
    let tensor = random([8, 40, 30], 5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tucker(&tensor, [4, 5, 6]).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!((one.core, one.factors), (three.core, three.factors));
}
