use super::*;
use crate::spheres::random::unit;
use ndarray::{Array4, ArrayView3};

fn noise(seed: u64, shape: (usize, usize, usize, usize)) -> Array4<f32> {
    let mut number = seed << 32;
    Array4::from_shape_simple_fn(shape, || {
        number += 1;
        (unit(number) - 0.5) as f32
    })
}

/// A tensor of the ranks [`ranks`], with a third mode of `columns` times `harmonics`.
fn of_rank(shape: (usize, usize, usize, usize), ranks: [usize; 2]) -> Array4<f32> {
    let (rows, columns, texels, harmonics) = shape;
    let core = noise(1, (ranks[0], columns, ranks[1], harmonics)).mapv(f64::from);
    let first = noise(2, (rows, ranks[0], 1, 1)).mapv(f64::from);
    let second = noise(3, (texels, ranks[1], 1, 1)).mapv(f64::from);
    Array4::from_shape_fn(shape, |(v, c, l, h)| {
        let term = |i: usize, j: usize| first[[v, i, 0, 0]] * second[[l, j, 0, 0]] * core[[i, c, j, h]];
        (0..ranks[0]).flat_map(|i| (0..ranks[1]).map(move |j| (i, j))).map(|(i, j)| term(i, j)).sum::<f64>()
            as f32
    })
}

fn assert_orthonormal(columns: &Array2<f64>) {
    let error = columns.t().dot(columns) - Array2::<f64>::eye(columns.ncols());
    assert!(error.iter().all(|e| e.abs() < 1e-12), "{error}");
}

/// What is rebuilt, [first, third, second].
fn rebuilt(found: &Tucker2) -> Array3<f64> {
    found.contracted(&Array2::eye(found.second.nrows()).view())
}

fn squared_error(tensor: &Array4<f32>, found: &Tucker2) -> f64 {
    let (rebuilt, harmonics) = (rebuilt(found), tensor.dim().3);
    let off = |((v, c, l, h), x): ((usize, usize, usize, usize), &f32)| {
        (f64::from(*x) - rebuilt[[v, c * harmonics + h, l]]).powi(2)
    };
    tensor.indexed_iter().map(off).sum()
}

fn squared_norm(tensor: &Array4<f32>) -> f64 {
    tensor.iter().map(|x| f64::from(*x).powi(2)).sum()
}

/// A tensor of low rank in single precision, whose entries are off by 6e-8 of themselves at most, comes back,
/// and its subspace is found: rows of the tensor are no farther from the span of U than rounding.
#[test]
fn a_tensor_of_low_rank_comes_back() {
    for (shape, ranks) in [((150, 1, 40, 5), [6, 4]), ((90, 3, 24, 4), [8, 5])] {
        let tensor = of_rank(shape, ranks);
        let found = tucker2(&tensor.view(), ranks).unwrap();
        assert_eq!((found.first.dim(), found.second.dim()), ((shape.0, ranks[0]), (shape.2, ranks[1])));
        assert_eq!(found.core.dim(), (ranks[0], ranks[1], shape.1 * shape.3));
        [&found.first, &found.second].into_iter().for_each(assert_orthonormal);
        assert!(squared_error(&tensor, &found) < 1e-13 * squared_norm(&tensor));
        assert!(found.error < 1e-13);
    }
}

/// Against the decomposition of the whole tensor, whose third mode has its full rank, on one whose singular
/// values fall slowly, 1/k: the subspaces found beforehand have next to all that the best has. Both are local
/// optima; they may differ by little either way.
#[test]
fn it_is_as_good_as_the_whole_decomposition() {
    let (rows, texels, harmonics) = (120, 30, 6);
    let mut tensor = Array4::<f32>::zeros((rows, 1, texels, harmonics));
    for k in 1..40u64 {
        let [a, b, c] = [rows, texels, harmonics]
            .map(|n| noise(10 * k + n as u64, (n, 1, 1, 1)).into_raw_vec_and_offset().0);
        for ((v, _, l, h), x) in tensor.indexed_iter_mut() {
            *x += a[v] * b[l] * c[h] / k as f32;
        }
    }
    for ranks in [[4, 3], [10, 8]] {
        let found = tucker2(&tensor.view(), ranks).unwrap();
        let third: ArrayView3<'_, f32> =
            tensor.view().into_shape_with_order((rows, texels, harmonics)).unwrap();
        let whole = tucker(&third.mapv(f64::from), [ranks[0], ranks[1], harmonics]).unwrap();
        let told = found.error * squared_norm(&tensor);
        assert!((told - squared_error(&tensor, &found)).abs() < 1e-9 * squared_norm(&tensor));
        let ratio = found.error / whole.errors.whole;
        assert!((0.99..1.01).contains(&ratio), "{ratio}");
    }
}

/// Fewer rows than the rank, one row, one row of one column, zeros.
#[test]
fn small_and_empty_tensors_are_whole() {
    for shape in [(5, 2, 12, 4), (1, 1, 12, 4), (1, 1, 1, 1), (3, 2, 6, 1)] {
        let tensor = noise(5, shape);
        let found = tucker2(&tensor.view(), [16, 16]).unwrap();
        assert!(found.first.ncols() <= shape.0 && found.second.ncols() <= shape.2, "{shape:?}");
        assert!(squared_error(&tensor, &found) < 1e-12 * squared_norm(&tensor), "{shape:?}");
        let zeros = Array4::<f32>::zeros(shape);
        let found = tucker2(&zeros.view(), [16, 16]).unwrap();
        assert!(found.core.iter().all(|z| *z == 0.0) && found.error == 0.0);
        assert!(found.first.iter().chain(&found.second).all(|u| u.is_finite()));
        assert_orthonormal(&found.first);
    }
}

/// Of equal singular values any rotation of columns is as good: the subspace, not the columns, is what
/// counts.
#[test]
fn equal_singular_values_give_their_subspace() {
    // Six rows each see one texel, all as brightly.
    let tensor = Array4::from_shape_fn(
        (80, 1, 16, 2),
        |(v, _, l, h)| if v < 6 && l == v && h == 0 { 1.0f32 } else { 0.0 },
    );
    let found = tucker2(&tensor.view(), [6, 6]).unwrap();
    assert!(found.error < 1e-12);
    for mode in [&found.first, &found.second] {
        let onto = mode.dot(&mode.t());
        for ((i, j), x) in onto.indexed_iter() {
            let expected = f64::from(u8::from(i == j && i < 6));
            assert!((x - expected).abs() < 1e-9, "{i}, {j}: {x}");
        }
    }
    let half = tucker2(&tensor.view(), [3, 6]).unwrap();
    assert!((half.error - 0.5).abs() < 1e-9, "{}", half.error);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let tensor = noise(9, (300, 2, 20, 3));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tucker2(&tensor.view(), [7, 5]).unwrap())
    };
    let (one, two) = (on(1), on(2));
    assert_eq!((one.first, one.second, one.core), (two.first, two.second, two.core));
}
