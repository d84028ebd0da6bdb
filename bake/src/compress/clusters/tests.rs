use super::*;

fn noise(seed: u64, shape: (usize, usize)) -> Array2<f32> {
    let mut number = seed << 32;
    Array2::from_shape_simple_fn(shape, || {
        number += 1;
        (unit(number) - 0.5) as f32
    })
}

/// Rows of `groups` subspaces of three dimensions each, in turn, and features that tell nothing of them.
fn planted(rows: usize, groups: usize) -> (Array2<f32>, Array2<f32>) {
    let spans: Vec<Array2<f32>> = (0..groups).map(|group| noise(50 + group as u64, (3, 40))).collect();
    let coefficients = noise(7, (rows, 3));
    let mut all = Array2::zeros((rows, 40));
    for (row, mut to) in all.rows_mut().into_iter().enumerate() {
        to.assign(&coefficients.row(row).dot(&spans[row % groups]));
    }
    (noise(8, (rows, 3)), all)
}

fn lost(rows: &Array2<f32>, clusters: &[Vec<usize>]) -> f64 {
    let spans = spans(&rows.view(), clusters).unwrap();
    let residuals = residuals(&rows.view(), &spans);
    let of = |(cluster, members): (usize, &Vec<usize>)| {
        members.iter().map(|row| f64::from(residuals[[*row, cluster]])).sum::<f64>()
    };
    clusters.iter().enumerate().map(of).sum::<f64>() / rows.iter().map(|x| f64::from(x * x)).sum::<f64>()
}

fn assert_partition(clusters: &[Vec<usize>], rows: usize, sizes: &RangeInclusive<usize>) {
    let mut all: Vec<usize> = clusters.iter().flatten().copied().collect();
    all.sort_unstable();
    assert_eq!(all, (0..rows).collect::<Vec<_>>());
    assert!(clusters.iter().all(|members| members.is_sorted() && sizes.contains(&members.len())));
    assert!(clusters.is_sorted_by_key(|members| members[0]));
}

/// Six subspaces of three dimensions have 18 in all, of which eight vectors span at most two whole and a
/// third of a third subspace. With two clusters of eight vectors each, what stays is less than without
/// rounds.
#[test]
fn rounds_find_what_is_spanned_together() {
    let (features, rows) = planted(600, 4);
    let asked = |rounds| Asked { clusters: 2, rounds, sizes: 20..=600 };
    let of = |rounds| clusters(&features.view(), &rows.view(), &asked(rounds)).unwrap();
    let (before, after) = (of(0), of(15));
    assert_partition(&before, 600, &(20..=600));
    assert_partition(&after, 600, &(20..=600));
    let [before_lost, after_lost] = [lost(&rows, &before), lost(&rows, &after)];
    // Two clusters of two subspaces each leave nothing; six dimensions of twelve, mixed, leave a tenth or so.
    assert!(before_lost > 0.02 && after_lost < 1e-5, "{before_lost} {after_lost}");
    for cluster in &after {
        let groups: std::collections::BTreeSet<usize> = cluster.iter().map(|row| row % 4).collect();
        assert_eq!(groups.len(), 2, "{groups:?}");
    }
}

#[test]
fn clusters_are_no_smaller_and_no_larger_than_asked() {
    let (features, rows) = planted(500, 3);
    for (count, sizes) in [(1, 10..=100), (20, 60..=120), (50, 10..=20), (3, 400..=800)] {
        let asked = Asked { clusters: count, rounds: 5, sizes: sizes.clone() };
        let found = clusters(&features.view(), &rows.view(), &asked).unwrap();
        assert_partition(&found, 500, &sizes);
    }
}

/// Fewer rows than anything, one row, none, and rows that are all the same or zero.
#[test]
fn little_is_one_cluster() {
    let asked = Asked { clusters: 4, rounds: 3, sizes: 32..=4096 };
    for count in [1, 2, 31] {
        for rows in [noise(3, (count, 5)), Array2::zeros((count, 5)), Array2::ones((count, 5))] {
            let found = clusters(&Array2::zeros((count, 3)).view(), &rows.view(), &asked).unwrap();
            assert_eq!(found, [(0..count).collect::<Vec<_>>()]);
        }
    }
    let none = clusters(&Array2::zeros((0, 3)).view(), &Array2::zeros((0, 5)).view(), &asked).unwrap();
    assert!(none.is_empty());
}

#[test]
fn threads_change_nothing() {
    let (features, rows) = planted(400, 3);
    let asked = Asked { clusters: 5, rounds: 6, sizes: 20..=200 };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| clusters(&features.view(), &rows.view(), &asked).unwrap())
    };
    assert_eq!(on(1), on(2));
}
