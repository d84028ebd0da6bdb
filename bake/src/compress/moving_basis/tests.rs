use super::*;
use crate::compress::linalg::first_singular;
use crate::spheres::random::unit;

fn noise(seed: u64, shape: (usize, usize)) -> Array2<f32> {
    let mut number = seed << 32;
    Array2::from_shape_simple_fn(shape, || {
        number += 1;
        (unit(number) - 0.5) as f32
    })
}

fn rebuilt(found: &MovingBasis, shares: &[Shares]) -> Array2<f32> {
    let rank = found.coefficients.ncols();
    let mut all = Array2::zeros((shares.len(), found.nodes.ncols()));
    for ((mut to, own), shares) in all.rows_mut().into_iter().zip(found.coefficients.rows()).zip(shares) {
        for (node, share) in shares {
            to.scaled_add(*share, &own.dot(&found.nodes.slice(s![node * rank..(node + 1) * rank, ..])));
        }
    }
    all
}

fn squares(of: &Array2<f32>) -> f64 {
    of.iter().map(|x| f64::from(*x).powi(2)).sum()
}

/// Rows along a line with four nodes: a basis of rank 3 that moves.
fn moving(rows: usize) -> (Array2<f32>, Vec<Shares>) {
    let places = Array2::from_shape_fn((rows, 1), |(row, _)| row as f32 / rows as f32 * 3.0);
    let centres = Array2::from_shape_fn((4, 1), |(node, _)| node as f32);
    let shares = shares(&places.view(), &centres.view(), 2);
    let found = MovingBasis { nodes: noise(1, (12, 50)), coefficients: noise(2, (rows, 3)), error: 0.0 };
    (rebuilt(&found, &shares), shares)
}

/// One node is the best approximation of its rank, which singular values tell.
#[test]
fn one_node_is_the_singular_value_decomposition() {
    let rows = noise(3, (90, 30)) / &Array2::from_shape_fn((1, 30), |(_, j)| 1.0 + j as f32);
    let alone: Vec<Shares> = vec![vec![(0, 1.0)]; 90];
    let found = moving_basis(&rows.view(), &alone, (1, 5), 400).unwrap();
    let values = first_singular(&rows.mapv(f64::from), 30).unwrap().s;
    let best = values[5..].iter().map(|s| s * s).sum::<f64>() / values.iter().map(|s| s * s).sum::<f64>();
    assert!((found.error / best - 1.0).abs() < 1e-3, "{} {best}", found.error);
    let off = squares(&(&rows - &rebuilt(&found, &alone))) / squares(&rows);
    assert!((off / found.error - 1.0).abs() < 1e-3, "{off} {}", found.error);
}

/// What moves as is asked comes back far better than by a basis for all of the same rank, and more turns are
/// never worse.
#[test]
fn a_moving_basis_is_found() {
    let (rows, shares) = moving(400);
    let of = |turns: usize| moving_basis(&rows.view(), &shares, (4, 3), turns).unwrap().error;
    let alone: Vec<Shares> = vec![vec![(0, 1.0)]; 400];
    let still = moving_basis(&rows.view(), &alone, (1, 3), 20).unwrap().error;
    let errors = [1, 4, 16, 200].map(of);
    println!("still {still}, moving {errors:?}");
    assert!(errors.is_sorted_by(|a, b| *b <= a + 1e-6), "{errors:?}");
    assert!(errors[3] < 0.1 * still, "{errors:?}, still {still}");
}

#[test]
fn nothing_and_little_are_themselves() {
    let zeros = moving_basis(&Array2::zeros((10, 6)).view(), &vec![vec![(0, 1.0)]; 10], (1, 3), 2).unwrap();
    assert!(zeros.error == 0.0 && zeros.coefficients.iter().chain(&zeros.nodes).all(|x| x.is_finite()));
    let row = noise(4, (1, 6));
    let found = moving_basis(&row.view(), &[vec![(0, 0.5), (1, 0.5)]], (2, 8), 3).unwrap();
    assert!(found.coefficients.dim() == (1, 1) && found.error < 1e-6, "{}", found.error);
}

/// Shares are of one, and what is a little farther has a little other ones.
#[test]
fn shares_are_smooth() {
    let centres = noise(6, (12, 2));
    let along = |t: f32| Array2::from_shape_vec((1, 2), vec![t - 0.5, 0.3 * t - 0.1]).unwrap();
    let dense = |t: f32| {
        let mut all = [0.0; 12];
        shares(&along(t).view(), &centres.view(), 4)[0].iter().for_each(|(node, share)| all[*node] = *share);
        all
    };
    let mut before = dense(0.0);
    for step in 1..=1000 {
        let now = dense(step as f32 / 1000.0);
        assert!((now.iter().sum::<f32>() - 1.0).abs() < 1e-5 && now.iter().all(|share| *share >= 0.0));
        let most = now.iter().zip(&before).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
        assert!(most < 0.05, "{step}: {most}");
        before = now;
    }
    // Where all nodes are equally far none is within the reach of all.
    let (alone, same) = (Array2::zeros((1, 2)), Array2::ones((5, 2)));
    assert_eq!(shares(&alone.view(), &same.view(), 2), [vec![(0, 1.0)]]);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let (rows, shares) = moving(1100);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| moving_basis(&rows.view(), &shares, (4, 3), 3).unwrap())
    };
    let (one, two) = (on(1), on(2));
    assert_eq!((one.nodes, one.coefficients), (two.nodes, two.coefficients));
}
