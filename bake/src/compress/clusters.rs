//! Clusters of rows that few vectors span (clustered principal component analysis, Sloan et al. 2003,
//! "Clustered principal components for precomputed radiance transfer", §4: here without means, as what
//! decomposes the clusters afterwards has none).
//!
//! They begin as those of k-means++ (Arthur and Vassilvitskii 2007) by features; then, round by round, the
//! leading right singular vectors of each are found and every row goes where they leave least of it. Nothing
//! depends on the number of threads, and clusters have the order of their first rows.

use super::linalg::{single_thread, symmetric_eigen};
use crate::spheres::random::unit;
use ndarray::{Array2, ArrayView2, Axis, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Vectors of a cluster that rows are assigned by (thesis: Sloan et al. find 8 to 16 enough).
const VECTORS: usize = 8;
/// Rounds of k-means.
const MEAN_ROUNDS: usize = 8;

/// How rows are to be clustered.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Clusters that it begins with.
    pub clusters: usize,
    /// Rounds of fitting vectors and assigning rows; with none the clusters are those of the features.
    pub rounds: usize,
    /// How many rows a cluster has; one of all there are may have fewer. The end is at least twice the start.
    pub sizes: RangeInclusive<usize>,
}

/// The members of every cluster, increasing: `rows`, [rows, any], are what is to be spanned, `features`,
/// [rows, any], what rows are near to each other by.
///
/// # Errors
/// If LAPACK does not converge.
pub fn clusters(
    features: &ArrayView2<'_, f32>,
    rows: &ArrayView2<'_, f32>,
    asked: &Asked,
) -> Result<Vec<Vec<usize>>, LinalgError> {
    single_thread();
    let mut of_row = by_means(features, asked.clusters.max(1));
    for _ in 0..asked.rounds {
        let spans = spans(rows, &members(&of_row))?;
        let residuals = residuals(rows, &spans);
        of_row = residuals.axis_iter(Axis(0)).map(|row| least(row.iter().copied(), |_| true)).collect();
        dissolve(&mut of_row, &residuals, *asked.sizes.start());
    }
    if asked.rounds == 0 {
        let distances = distances(features, &means(features, &members(&of_row)));
        dissolve(&mut of_row, &distances, *asked.sizes.start());
    }
    let mut clusters = Vec::new();
    for cluster in members(&of_row) {
        halve(cluster, features, *asked.sizes.end(), &mut clusters);
    }
    clusters.sort_by_key(|members| members.first().copied());
    Ok(clusters)
}

/// The rows of each cluster that has any.
fn members(of_row: &[usize]) -> Vec<Vec<usize>> {
    let count = of_row.iter().max().map_or(0, |most| most + 1);
    let mut members = vec![Vec::new(); count];
    of_row.iter().enumerate().for_each(|(row, cluster)| members[*cluster].push(row));
    members.retain(|members| !members.is_empty());
    members
}

/// The first of the least values among those that are `asked`.
fn least(values: impl Iterator<Item = f32>, asked: impl Fn(usize) -> bool) -> usize {
    let all = values.enumerate().filter(|(index, _)| asked(*index));
    all.fold((0, f32::INFINITY), |least, (index, value)| if value < least.1 { (index, value) } else { least })
        .0
}

/// k-means++ and some rounds of k-means.
fn by_means(features: &ArrayView2<'_, f32>, count: usize) -> Vec<usize> {
    let mut centres = Array2::zeros((0, features.ncols()));
    let mut nearest = vec![f32::INFINITY; features.nrows()];
    let mut chosen = 0;
    for number in 0..count.min(features.nrows()) {
        if number > 0 {
            let total: f64 = nearest.iter().map(|d| f64::from(*d)).sum();
            let mut left = unit(number as u64) * total;
            let reached = |d: &f32| {
                left -= f64::from(*d);
                left < 0.0
            };
            // All rows are where centres are already.
            let Some(next) = nearest.iter().position(reached) else { break };
            chosen = next;
        }
        let centre = features.slice(s![chosen..=chosen, ..]);
        let to_centre = distances(features, &centre.to_owned());
        nearest.iter_mut().zip(to_centre.column(0)).for_each(|(d, new)| *d = d.min(*new));
        if centres.append(Axis(0), centre).is_err() {
            break;
        }
    }
    let assigned = |centres: &Array2<f32>| -> Vec<usize> {
        let distances = distances(features, centres);
        distances.axis_iter(Axis(0)).map(|row| least(row.iter().copied(), |_| true)).collect()
    };
    let mut of_row = assigned(&centres);
    for _ in 0..MEAN_ROUNDS {
        of_row = assigned(&means(features, &members(&of_row)));
    }
    of_row
}

fn means(features: &ArrayView2<'_, f32>, members: &[Vec<usize>]) -> Array2<f32> {
    let mut means = Array2::zeros((members.len(), features.ncols()));
    for (mut mean, members) in means.rows_mut().into_iter().zip(members) {
        members.iter().for_each(|row| mean += &features.row(*row));
        mean /= members.len() as f32;
    }
    means
}

/// Squared distances, [rows, centres].
fn distances(features: &ArrayView2<'_, f32>, centres: &Array2<f32>) -> Array2<f32> {
    let mut all = Array2::zeros((features.nrows(), centres.nrows()));
    let pairs: Vec<_> = all.rows_mut().into_iter().zip(features.rows()).collect();
    pairs.into_par_iter().for_each(|(mut to, row)| {
        for (to, centre) in to.iter_mut().zip(centres.rows()) {
            *to = row.iter().zip(centre).map(|(a, b)| (a - b) * (a - b)).sum();
        }
    });
    all
}

/// The leading right singular vectors of each cluster, [columns of `rows`, [`VECTORS`] or as many as there
/// are].
fn spans(rows: &ArrayView2<'_, f32>, members: &[Vec<usize>]) -> Result<Vec<Array2<f32>>, LinalgError> {
    let span = |members: &Vec<usize>| {
        let some = rows.select(Axis(0), members).mapv(f64::from);
        let count = VECTORS.min(rows.ncols());
        // The vectors of values of next to nothing span nothing.
        let (squares, vectors) = symmetric_eigen(&some.t().dot(&some))?;
        let floor = squares.first().copied().unwrap_or(0.0).max(0.0) * 1e-12;
        let count = squares.iter().take(count).filter(|square| **square > floor).count();
        Ok(vectors.slice(s![.., ..count]).mapv(|x| x as f32))
    };
    members.par_iter().map(span).collect()
}

/// What the vectors of each cluster leave of each row, squared: [rows, clusters].
fn residuals(rows: &ArrayView2<'_, f32>, spans: &[Array2<f32>]) -> Array2<f32> {
    let mut residuals = Array2::zeros((rows.nrows(), spans.len()));
    let columns: Vec<_> = residuals.axis_iter_mut(Axis(1)).zip(spans).collect();
    columns.into_par_iter().for_each(|(mut to, span)| {
        let along = rows.dot(span);
        for ((to, row), along) in to.iter_mut().zip(rows.rows()).zip(along.rows()) {
            *to = row.dot(&row) - along.dot(&along);
        }
    });
    residuals
}

/// Takes clusters with fewer than `fewest` rows apart, the smallest first: each row goes where `costs`,
/// [rows, clusters], are least among those that are left.
fn dissolve(of_row: &mut [usize], costs: &Array2<f32>, fewest: usize) {
    let mut sizes = vec![0; costs.ncols()];
    of_row.iter().for_each(|cluster| sizes[*cluster] += 1);
    let mut left: Vec<bool> = sizes.iter().map(|size| *size > 0).collect();
    while left.iter().filter(|left| **left).count() > 1 {
        let smallest =
            (0..sizes.len()).filter(|cluster| left[*cluster]).min_by_key(|cluster| sizes[*cluster]);
        let Some(smallest) = smallest.filter(|cluster| sizes[*cluster] < fewest) else { break };
        left[smallest] = false;
        for (row, cluster) in of_row.iter_mut().enumerate().filter(|(_, cluster)| **cluster == smallest) {
            *cluster = least(costs.row(row).iter().copied(), |other| left[other]);
            sizes[*cluster] += 1;
        }
    }
}

/// Adds `cluster` to `to`, in equal parts of at most `most` rows along the feature that differs most.
fn halve(mut cluster: Vec<usize>, features: &ArrayView2<'_, f32>, most: usize, to: &mut Vec<Vec<usize>>) {
    if cluster.len() > most {
        let spread = |column: usize| {
            let values = || cluster.iter().map(|row| features[[*row, column]]);
            let mean = values().sum::<f32>() / cluster.len() as f32;
            values().map(|x| (x - mean) * (x - mean)).sum::<f32>()
        };
        let along = (0..features.ncols()).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0);
        cluster.sort_by(|a, b| features[[*a, along]].total_cmp(&features[[*b, along]]).then(a.cmp(b)));
        let second = cluster.split_off(cluster.len() / 2);
        [cluster, second].into_iter().for_each(|half| halve(half, features, most, to));
        return;
    }
    cluster.sort_unstable();
    to.push(cluster);
}

#[cfg(test)]
mod tests;
