//! Incoming profiles of residuals: which few functions I(θ)·cos mφ, linear between nodes of θ, leave least of all
//! lobes.
//!
//! Lobes turn with the direction that they are seen from, so that each order m stands by itself: cos m(φ_i − φ_o) is
//! the sum of two products. That is why a profile of order 0 costs a vertex one number and any other two, and why no
//! cut through a pair is ever made.

use super::hemisphere::{BANDS, Hemisphere, of_order};
use crate::compress::linalg::symmetric_eigen;
use ndarray::{Array2, ArrayView2};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::kinds::brdf_tensor::angles::{self, NODES};

/// Orders among which profiles are chosen: none beyond half of them ever is.
const ORDERS: usize = 17;
/// Combinations of nodes whose squared norm is below this part of the largest are left out: noise.
const FAINT: f64 = 1e-6;

/// Functions of one order that are 1 at one node and 0 at all others, times cosine.
struct Hats {
    /// Their harmonics, [bands, [`NODES`]].
    harmonics: Array2<f64>,
    /// Combinations of them that are orthonormal, [[`NODES`], combinations].
    orthonormal: Array2<f64>,
}

/// One of the functions that residuals are made of.
pub struct Profile {
    /// m.
    pub order: usize,
    /// I at the nodes, sr⁻¹.
    pub nodes: Vec<f64>,
    /// The harmonics of I·cos θ·cos mφ, of squared norm 1: those of its order.
    pub harmonics: Vec<f64>,
    /// The squared norm of the residuals along it.
    pub squared: f64,
}

impl Profile {
    /// How many numbers of a vertex it costs.
    pub fn columns(&self) -> usize {
        if self.order == 0 { 1 } else { 2 }
    }

    /// How much of it is in a function.
    pub fn along(&self, harmonics: &[f64]) -> f64 {
        let own = harmonics.get(of_order(self.order)).unwrap_or_default();
        own.iter().zip(&self.harmonics).map(|(a, b)| a * b).sum()
    }
}

/// The harmonics of `nodes`, a profile of `order`, times cosine.
pub fn harmonics(order: usize, nodes: impl Fn(usize) -> f64, hemisphere: &Hemisphere) -> Vec<f64> {
    let between = |theta: f64| {
        let (node, share) = angles::locate(theta as f32);
        let share = f64::from(share);
        theta.cos() * (nodes(node) * (1.0 - share) + nodes(node + 1) * share)
    };
    hemisphere.of_profile(order, between)
}

/// All profiles of `residuals`, [functions, harmonics], those that take most of their squared norm for each column
/// first. The sign of each is such that its largest value times cosine is positive.
///
/// # Errors
/// If LAPACK does not converge.
pub fn of(residuals: &ArrayView2<'_, f64>, hemisphere: &Hemisphere) -> Result<Vec<Profile>, LinalgError> {
    let of_order = |order: usize| of_one_order(order, residuals, hemisphere);
    let each: Vec<_> = (0..ORDERS).into_par_iter().map(of_order).collect::<Result<_, _>>()?;
    let mut all: Vec<Profile> = each.into_iter().flatten().collect();
    let gain = |profile: &Profile| profile.squared / profile.columns() as f64;
    all.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    Ok(all)
}

/// The first of `profiles` that fit into so many columns.
pub fn within(profiles: Vec<Profile>, columns: usize, most: usize) -> Vec<Profile> {
    let mut left = columns;
    let mut fits = |profile: &Profile| {
        let fits = profile.columns() <= left;
        left -= if fits { profile.columns() } else { 0 };
        fits
    };
    profiles.into_iter().filter(|profile| fits(profile)).take(most).collect()
}

fn of_one_order(
    order: usize,
    residuals: &ArrayView2<'_, f64>,
    hemisphere: &Hemisphere,
) -> Result<Vec<Profile>, LinalgError> {
    let hats = Hats::new(order, hemisphere)?;
    let range = of_order(order);
    let own = residuals.slice(ndarray::s![.., range]);
    let basis = hats.harmonics.dot(&hats.orthonormal);
    let along = own.dot(&basis);
    let (squares, vectors) = symmetric_eigen(&along.t().dot(&along))?;
    let profile = |(vector, squared): (ndarray::ArrayView1<'_, f64>, &f64)| {
        let nodes = hats.orthonormal.dot(&vector);
        let sign =
            of_largest(nodes.iter().enumerate().map(|(n, value)| value * angles::theta(n).cos())).signum();
        Profile {
            order,
            nodes: nodes.iter().map(|value| sign * value).collect(),
            harmonics: basis.dot(&vector).iter().map(|value| sign * value).collect(),
            squared: squared.max(0.0),
        }
    };
    Ok(vectors.columns().into_iter().zip(&squares).map(profile).collect())
}

/// The value of largest magnitude.
pub fn of_largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0f64, |most, value| if value.abs() > most.abs() { value } else { most })
}

impl Hats {
    fn new(order: usize, hemisphere: &Hemisphere) -> Result<Self, LinalgError> {
        let mut all = Array2::zeros((BANDS - order, NODES));
        for (node, mut column) in all.columns_mut().into_iter().enumerate() {
            // At the pole cos mφ has no value, and no lobe any part of it.
            if node > 0 || order == 0 {
                let hat = harmonics(order, |at| f64::from(u8::from(at == node)), hemisphere);
                column.assign(&ndarray::ArrayView1::from(&hat));
            }
        }
        let (squares, vectors) = symmetric_eigen(&all.t().dot(&all))?;
        let most = squares.first().copied().unwrap_or(0.0);
        let kept = squares.iter().take_while(|square| **square > FAINT * most).count();
        let orthonormal = Array2::from_shape_fn((NODES, kept), |(n, k)| vectors[[n, k]] / squares[k].sqrt());
        Ok(Self { harmonics: all, orthonormal })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lobes that are mixtures of three profiles, two of one order: all of them is found, in the order of what they
    /// are worth for their columns, and nothing else.
    #[test]
    fn mixtures_of_profiles_are_found_again() {
        let hemisphere = Hemisphere::new();
        let shapes: [(usize, fn(f64) -> f64, f64); 3] =
            [(0, |t| 1.0 - 0.3 * t, 4.0), (0, |t| t * t, 1.0), (2, |t| t * (2.0 - t), 2.0)];
        let total = of_order(BANDS - 1).end;
        let mut residuals = Array2::zeros((30, total));
        for (row, mut function) in residuals.rows_mut().into_iter().enumerate() {
            for (number, (order, shape, scale)) in shapes.iter().enumerate() {
                let weight = scale * ((row * (7 + 4 * number) + 3 * number) % 30) as f64 - 14.0;
                let at_nodes = |node: usize| shape(angles::theta(node));
                let own = harmonics(*order, at_nodes, &hemisphere);
                for (to, value) in function.slice_mut(ndarray::s![of_order(*order)]).iter_mut().zip(own) {
                    *to += weight * value;
                }
            }
        }
        let whole: f64 = residuals.iter().map(|x| x * x).sum();
        let found = of(&residuals.view(), &hemisphere).unwrap();
        let orders: Vec<usize> = found.iter().take(3).map(|profile| profile.order).collect();
        assert!(orders.iter().filter(|order| **order == 0).count() == 2 && orders.contains(&2), "{orders:?}");
        let left = whole - found.iter().take(3).map(|profile| profile.squared).sum::<f64>();
        // Combinations of nodes that are left out hold less than a millionth of the squared norm of the largest.
        assert!(left.abs() < 1e-5 * whole && found[3].squared < 1e-5 * whole, "{left} of {whole}");
        for profile in found.iter().take(3) {
            let stored = harmonics(profile.order, |node| profile.nodes[node], &hemisphere);
            let products: f64 = stored.iter().zip(&profile.harmonics).map(|(a, b)| a * b).sum();
            assert!((products - 1.0).abs() < 1e-6, "{products}");
            let along: f64 = residuals.rows().into_iter().map(|r| profile.along(&r.to_vec()).powi(2)).sum();
            assert!((along - profile.squared).abs() < 1e-8 * whole);
        }
        // A pair is taken whole or not at all.
        for columns in 1..5 {
            let chosen = within(of(&residuals.view(), &hemisphere).unwrap(), columns, 16);
            assert!(chosen.iter().map(Profile::columns).sum::<usize>() <= columns);
        }
    }
}
