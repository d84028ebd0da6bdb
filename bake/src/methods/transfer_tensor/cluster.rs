//! The tensors of the vertices of one cluster, made small.

use super::{Arriving, Gather};
use crate::compress::clusters::{Asked, clusters};
use crate::compress::tucker2::{Tucker2, tucker2};
use crate::trace::receivers::Receiver;
use glam::Vec3A;
use ndarray::{Array2, Array4, Axis, concatenate, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;

/// Vertices of a cluster, about (thesis Table 5-1).
pub const VERTICES: usize = 1000;
/// Most vertices of a cluster: its tensors are in memory at once.
pub const MOST: usize = 2048;
/// Rounds of clustering that pay where columns share bases; where each has its own, none do better
/// (docs/notes/TRANSFER-TENSOR.md).
pub const ROUNDS: usize = 12;

/// Which bases the columns of a tensor share within a cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bases {
    /// Each column has its own, as in the source.
    OfColumns,
    /// All columns share one of vertices and one of lights.
    Shared,
}

/// The tensor of a cluster as one decomposition of each column, or one of all.
pub struct Small {
    /// [columns] or [1].
    pub parts: Vec<Tucker2>,
    /// How many columns there are.
    columns: usize,
}

/// The vertices of every cluster, increasing: about `vertices` in each, spanned by a sketch of what they
/// receive, and at least twice `rank`.
///
/// # Errors
/// If LAPACK does not converge.
pub fn of_vertices(
    receivers: &[Receiver],
    gather: &Gather<'_>,
    arriving: &Arriving,
    (vertices, rank, rounds): (usize, usize, usize),
) -> Result<Vec<Vec<usize>>, LinalgError> {
    let coarse = arriving.coarser(2);
    let sketches: Vec<Vec<f32>> =
        (0..receivers.len()).into_par_iter().map(|vertex| gather.sketch(vertex, &coarse)).collect();
    let columns = sketches.first().map_or(0, Vec::len);
    let rows = Array2::from_shape_fn((sketches.len(), columns), |(vertex, k)| sketches[vertex][k]);
    let asked = asked(receivers, vertices, rank, rounds);
    clusters(&features(receivers, &rows)?.view(), &rows.view(), &asked)
}

/// The vertices of every cluster, increasing: about `vertices` in each and at least twice `rank`, near to each
/// other by place and normal alone, which is best where columns have bases of their own
/// (docs/notes/TRANSFER-TENSOR.md).
///
/// # Errors
/// If LAPACK does not converge, which is not asked to.
pub fn near(
    receivers: &[Receiver],
    (vertices, rank): (usize, usize),
) -> Result<Vec<Vec<usize>>, LinalgError> {
    let asked = asked(receivers, vertices, rank, 0);
    clusters(&places(receivers).view(), &Array2::zeros((receivers.len(), 0)).view(), &asked)
}

fn asked(receivers: &[Receiver], vertices: usize, rank: usize, rounds: usize) -> Asked {
    Asked { clusters: receivers.len().div_ceil(vertices), rounds, sizes: 2 * rank..=MOST.max(4 * rank) }
}

/// Where vertices are, for those near to each other to be found: position in parts of the scene's extent, and
/// normal, [vertices, 6].
pub fn places(receivers: &[Receiver]) -> Array2<f32> {
    let bounds = receivers.iter().fold([Vec3A::INFINITY, Vec3A::NEG_INFINITY], |[least, most], r| {
        [least.min(r.origin), most.max(r.origin)]
    });
    let extent = (bounds[1] - bounds[0]).max_element().max(f32::MIN_POSITIVE);
    Array2::from_shape_fn((receivers.len(), 6), |(vertex, k)| match k {
        0..3 => (receivers[vertex].origin[k] - bounds[0][k]) / extent,
        _ => receivers[vertex].normal[k - 3],
    })
}

/// Places, and sketches in parts of the root mean square of their norms.
fn features(receivers: &[Receiver], sketches: &Array2<f32>) -> Result<Array2<f32>, LinalgError> {
    let squares: f32 = sketches.iter().map(|x| x * x).sum();
    let norm = (squares / receivers.len().max(1) as f32).sqrt().max(f32::MIN_POSITIVE);
    concatenate(Axis(1), &[places(receivers).view(), (sketches / norm).view()]).map_err(LinalgError::Shape)
}

/// The tensors of `members`, [vertices, columns, texels, harmonics].
pub fn tensors(members: &[usize], gather: &Gather<'_>) -> Array4<f32> {
    let [columns, texels, harmonics] = gather.shape();
    let mut tensors = Array4::zeros((members.len(), columns, texels, harmonics));
    let each: Vec<_> = tensors.outer_iter_mut().zip(members).collect();
    each.into_par_iter().for_each(|(mut tensor, vertex)| {
        if let Some(values) = tensor.as_slice_mut() {
            gather.tensor(*vertex, values);
        }
    });
    tensors
}

impl Small {
    /// Of the `tensors` of a cluster, to `ranks` of vertices and of light.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn new(tensors: &Array4<f32>, ranks: [usize; 2], bases: Bases) -> Result<Self, LinalgError> {
        let columns = tensors.dim().1;
        let parts = match bases {
            Bases::Shared => vec![tucker2(&tensors.view(), ranks)?],
            Bases::OfColumns => {
                let of_column = |c: usize| tucker2(&tensors.slice(s![.., c..=c, .., ..]), ranks);
                (0..columns).into_par_iter().map(of_column).collect::<Result<_, _>>()?
            }
        };
        Ok(Self { parts, columns })
    }

    /// What it stands for, under lights: `lights` are [texels, any], the result [vertices, columns,
    /// harmonics, any].
    pub fn lit(&self, lights: &Array2<f64>) -> Array4<f64> {
        let parts: Vec<_> = self.parts.par_iter().map(|part| part.contracted(&lights.view())).collect();
        let (vertices, third, states) = parts.first().map_or((0, 0, 0), |part| part.dim());
        let harmonics = third * self.parts.len() / self.columns.max(1);
        let mut all = Array4::zeros((vertices, self.columns, harmonics, states));
        for (column, mut to) in all.axis_iter_mut(Axis(1)).enumerate() {
            let (part, first) = match self.parts.len() {
                1 => (0, column * harmonics),
                _ => (column, 0),
            };
            to.assign(&parts[part].slice(s![.., first..first + harmonics, ..]));
        }
        all
    }

    /// How many numbers each vertex has of its own, and how many all share.
    pub fn numbers(&self) -> [usize; 2] {
        let numbers = self.parts.iter().map(Tucker2::numbers);
        numbers.fold([0; 2], |sum, of_part| [sum[0] + of_part[0], sum[1] + of_part[1]])
    }
}

/// [`Small::lit`] of the tensors themselves.
pub fn lit(tensors: &Array4<f32>, lights: &Array2<f64>) -> Array4<f64> {
    let (vertices, columns, _, harmonics) = tensors.dim();
    let mut all = Array4::zeros((vertices, columns, harmonics, lights.ncols()));
    let each: Vec<_> = all.outer_iter_mut().zip(tensors.outer_iter()).collect();
    each.into_par_iter().for_each(|(mut to, from)| {
        for (mut to, from) in to.outer_iter_mut().zip(from.outer_iter()) {
            to.assign(&from.mapv(f64::from).t().dot(lights));
        }
    });
    all
}
