//! A BRDF space as cones and a residual of low rank (thesis §5.3.1, §5.3.3.1): what its stored form means is told by
//! [`relume_formats::kinds::brdf_tensor`].
//!
//! The lobes of all samples, times cosine, are turned into harmonics about the normal, seen from every node of the
//! angle, and compared in the metric of natural light ([`hemisphere`]). Beside a background of broad functions,
//! which stay in the residual, each is fitted by cones whose shares are at least 0; of what cones leave a few
//! profiles are chosen by what they are worth for their columns at a vertex ([`profiles`]). How much of each profile
//! a sample has, seen from each node, is a tensor, which is cut short in the modes of samples and of outgoing angles
//! ([`crate::compress::tucker`]). The source fits round Gaussians about the mirror direction by expectation
//! maximisation, and cuts azimuths with the rest.
//!
//! Every sample counts alike: its lobes are divided by their norm before and multiplied by it after.

mod comparison;
mod cones;
mod hemisphere;
mod least_squares;
mod profiles;
mod space;

pub use comparison::Comparison;
pub use cones::{CONES, SOURCE_CONES};
pub use space::{lobe_of, samples_of};

use crate::brdf;
use crate::compress::linalg::single_thread;
use crate::compress::tucker::{Tucker, tucker};
use glam::{DVec3, Vec3A};
use hemisphere::{BANDS, Hemisphere, of_order, outgoing, seen_from};
use least_squares::non_negative;
use ndarray::{Array2, Array3, ArrayView1, ArrayView2, Axis};
use ndarray_linalg::error::LinalgError;
use profiles::{Profile, of_largest};
use rayon::prelude::*;
use relume_formats::basis::microfacet::{self, Facets};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::angles::{self, NODES};
use relume_formats::kinds::brdf_tensor::{Cone, MAX_PROFILES, Meta, Samples};
use relume_formats::state::{Brdf, Model};
use std::f64::consts::PI;

/// What all angles count, beside sin θ cos θ, which is how much of a ball is seen so: planes are seen from anywhere,
/// and rims are looked at.
const ENDS_COUNT: f64 = 0.1;

/// How large a tensor may be.
#[derive(Debug, Clone)]
pub struct Size {
    /// The cones; none for lobes that stay whole.
    pub cones: Vec<Cone>,
    /// Columns of a vertex beside that of the diffuse lobe.
    pub columns: usize,
    /// Columns of materials, and of outgoing angles.
    pub ranks: [usize; 2],
}

/// Of files. Ranks beyond these take less than a tenth off the error (docs/notes/TRANSFER-TENSOR.md).
impl Default for Size {
    fn default() -> Self {
        Self { cones: CONES.to_vec(), columns: 8, ranks: [8, 12] }
    }
}

/// The tensor of the space of `model`, at its samples, of the size of files.
///
/// # Errors
/// If LAPACK does not converge.
pub fn make(model: Model) -> Result<BrdfTensor, LinalgError> {
    SpaceTensor::new(model, samples_of(model)).decomposed(&Size::default())
}

/// The lobes of a space.
pub struct SpaceTensor {
    model: Model,
    samples: Samples,
    hemisphere: Hemisphere,
    /// Root of what each node of the outgoing angle counts, together 1.
    roots: Vec<f64>,
    /// Norm of the lobe of each sample.
    norms: Vec<f64>,
    /// Harmonics of lobe times cosine over the norm, times the root of the angle: [samples · [`NODES`], harmonics].
    lobes: Array2<f64>,
}

/// What cones leave of the lobes, and their shares of the lobes that are not divided by their norms.
struct Split {
    /// As `lobes`.
    residuals: Array2<f64>,
    /// [samples, [`NODES`], cones].
    shares: Vec<f32>,
}

impl SpaceTensor {
    /// Tabulates the lobes of `model` at `samples`.
    pub fn new(model: Model, samples: Samples) -> Self {
        single_thread();
        let hemisphere = Hemisphere::new();
        let roots: Vec<f64> = node_weights().into_iter().map(f64::sqrt).collect();
        let rows = samples.count() * NODES;
        let mut lobes = Array2::zeros((rows, of_order(BANDS - 1).end));
        let each: Vec<_> = lobes.outer_iter_mut().enumerate().collect();
        each.into_par_iter().for_each(|(row, mut to)| {
            let lobe = lobe_of(model, &samples, row / NODES);
            let harmonics = lobe_harmonics(&lobe, outgoing(seen_from(row % NODES)), &hemisphere);
            to.assign(&(&ArrayView1::from(&harmonics) * roots[row % NODES]));
        });
        let norm = |lobe: ArrayView2<'_, f64>| squared(lobe.iter()).sqrt();
        let norms: Vec<f64> = lobes.axis_chunks_iter(Axis(0), NODES).map(norm).collect();
        lobes.outer_iter_mut().enumerate().for_each(|(row, mut lobe)| lobe /= norms[row / NODES]);
        Self { model, samples, hemisphere, roots, norms, lobes }
    }

    /// The tensor of that size.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn decomposed(&self, size: &Size) -> Result<BrdfTensor, LinalgError> {
        let Split { residuals, shares } = self.split(&size.cones)?;
        let profiles = profiles::of(&residuals.view(), &self.hemisphere)?;
        let profiles = profiles::within(profiles, size.columns, MAX_PROFILES as usize);
        let count = self.samples.count();
        let along = Array3::from_shape_fn((count, NODES, profiles.len()), |(sample, node, k)| {
            profiles[k].along(residuals.row(sample * NODES + node).as_slice().unwrap_or_default())
        });
        let [of_materials, of_outgoing] = size.ranks;
        let found = tucker(&along, [of_materials, of_outgoing, profiles.len()])?;
        let all = count as f64;
        let (residual, kept) = (squared(residuals.iter()) / all, squared(along.iter()) / all);
        let [materials, outgoing, _] = found.errors.of_modes.map(|error| error * kept);
        let incoming = (residual - kept).max(0.0);
        let meta = Meta {
            model: self.model,
            residual,
            materials,
            outgoing,
            incoming,
            whole: incoming + kept * found.errors.whole,
        };
        Ok(self.stored(meta, size, &profiles, &found, shares))
    }

    /// What is left of all lobes by `cones`, and by profiles of 0, 1, 2, … columns beside them: root mean squares
    /// over samples, in parts of the lobes'.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn errors(&self, cones: &[Cone], columns: usize) -> Result<Vec<f64>, LinalgError> {
        let residuals = self.split(cones)?.residuals;
        let whole = squared(residuals.iter());
        let left = |columns: usize| -> Result<f64, LinalgError> {
            let profiles =
                profiles::within(profiles::of(&residuals.view(), &self.hemisphere)?, columns, usize::MAX);
            let kept: f64 = profiles.iter().map(|profile| profile.squared).sum();
            Ok(((whole - kept).max(0.0) / self.samples.count() as f64).sqrt())
        };
        (0..=columns).map(left).collect()
    }

    /// Cones fitted to every lobe beside the background.
    fn split(&self, cones: &[Cone]) -> Result<Split, LinalgError> {
        if cones.is_empty() {
            return Ok(Split { residuals: self.lobes.clone(), shares: Vec::new() });
        }
        let background = background(&self.hemisphere);
        let at_nodes = cones::at_nodes(cones, &self.hemisphere);
        let fits: Vec<Fit> = at_nodes.into_iter().map(|cones| Fit::new(cones, &background)).collect();
        let mut residuals = self.lobes.clone();
        let each: Vec<_> = residuals.outer_iter_mut().enumerate().collect();
        let split = |(row, lobe): (usize, ndarray::ArrayViewMut1<'_, f64>)| {
            let scale = self.roots[row % NODES] / self.norms[row / NODES];
            fits[row % NODES].split(lobe, scale, &background)
        };
        let shares: Vec<Vec<f32>> = each.into_par_iter().map(split).collect::<Result<_, _>>()?;
        Ok(Split { residuals, shares: shares.concat() })
    }

    fn stored(
        &self,
        meta: Meta,
        size: &Size,
        profiles: &[Profile],
        found: &Tucker,
        shares: Vec<f32>,
    ) -> BrdfTensor {
        let [of_materials, of_outgoing, of_profiles] = &found.factors;
        // Profiles reach, times cosine, as high as the diffuse lobe does.
        let heights: Vec<f64> = profiles.iter().map(|profile| height(profile) * PI).collect();
        let core = core(&found.core, of_profiles, &heights);
        let materials =
            of_materials.outer_iter().zip(&self.norms).flat_map(|(row, norm)| scaled(&row, *norm));
        let outgoing =
            of_outgoing.outer_iter().zip(&self.roots).flat_map(|(row, root)| scaled(&row, 1.0 / root));
        let row = |node: usize| {
            profiles.iter().zip(&heights).map(move |(p, height)| (p.nodes[node] / height) as f32)
        };
        BrdfTensor {
            ranks: [of_materials.ncols(), of_outgoing.ncols(), profiles.len()],
            samples: self.samples.clone(),
            orders: profiles.iter().map(|profile| profile.order as u32).collect(),
            core: core.iter().map(|value| *value as f32).collect(),
            materials: materials.collect(),
            outgoing: outgoing.collect(),
            incoming: (0..NODES).flat_map(row).collect(),
            cones: size.cones.clone(),
            shares,
            even: even(self.model, &self.hemisphere),
            meta,
        }
    }
}

/// The cones seen from one node.
struct Fit {
    /// Their harmonics, [cones, harmonics].
    cones: Array2<f64>,
    /// What of them is not in the background.
    beside: Array2<f64>,
    /// Products of these with each other.
    products: Array2<f64>,
}

impl Fit {
    fn new(cones: Vec<Vec<f64>>, background: &[Vec<f64>]) -> Self {
        let harmonics = cones.first().map_or(0, Vec::len);
        let cones = Array2::from_shape_vec((cones.len(), harmonics), cones.concat()).unwrap_or_default();
        let mut beside = cones.clone();
        beside.outer_iter_mut().for_each(|row| without(row, background));
        Self { products: beside.dot(&beside.t()), cones, beside }
    }

    /// Takes the cones, times `scale`, away from a lobe; their shares without it. Shares are rounded as they are
    /// stored before.
    fn split(
        &self,
        mut lobe: ndarray::ArrayViewMut1<'_, f64>,
        scale: f64,
        background: &[Vec<f64>],
    ) -> Result<Vec<f32>, LinalgError> {
        let mut target = lobe.to_owned();
        without(target.view_mut(), background);
        let found = non_negative(&self.products, &self.beside.dot(&target).to_vec())?;
        let shares: Vec<f32> = found.iter().map(|share| (share / scale) as f32).collect();
        for (share, cone) in shares.iter().zip(self.cones.outer_iter()) {
            lobe.scaled_add(-scale * f64::from(*share), &cone);
        }
        Ok(shares)
    }
}

/// Takes what is along orthonormal functions of order 0 away.
fn without(mut function: ndarray::ArrayViewMut1<'_, f64>, background: &[Vec<f64>]) {
    for along in background {
        let share: f64 = function.iter().zip(along).map(|(a, b)| a * b).sum();
        function.iter_mut().zip(along).for_each(|(value, own)| *value -= share * own);
    }
}

/// The harmonics of order 0 of cos θ and cos³θ, made orthonormal: what is broad is no cone's.
fn background(hemisphere: &Hemisphere) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for power in [1, 3] {
        let mut function = hemisphere.of_profile(0, |theta| theta.cos().powi(power));
        without(ndarray::ArrayViewMut1::from(&mut function[..]), &all);
        let norm = squared(function.iter()).sqrt();
        all.push(function.into_iter().map(|value| value / norm).collect());
    }
    all
}

/// The harmonics of a lobe times cosine; `outgoing` is a unit vector in the azimuth of +X.
fn lobe_harmonics(lobe: &Brdf, outgoing: DVec3, hemisphere: &Hemisphere) -> Vec<f64> {
    let outgoing = outgoing.as_vec3a();
    hemisphere.harmonics(|incoming| {
        let angles = brdf::angles(incoming, outgoing, Vec3A::Z);
        f64::from(brdf::evaluate(lobe, Vec3A::ONE, &angles).x * incoming.z)
    })
}

/// What each node of the outgoing angle counts, together 1.
fn node_weights() -> Vec<f64> {
    let weight = |node: usize| {
        let theta = angles::theta(node);
        theta.sin() * theta.cos() + ENDS_COUNT
    };
    let weights: Vec<f64> = (0..NODES).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// What the diffuse lobe reflects of a white sky, by node.
fn even(model: Model, hemisphere: &Hemisphere) -> Vec<f32> {
    let of_node = |node: usize| {
        let outgoing = outgoing(seen_from(node)).as_vec3a();
        let lobe = |incoming: Vec3A| {
            let schlick = microfacet::schlick(brdf::angles(incoming, outgoing, Vec3A::Z).cos_difference);
            f64::from(Facets::Ggx.diffuse(schlick) * incoming.z)
        };
        hemisphere::integral(&hemisphere.harmonics(lobe)).clamp(0.0, 1.0) as f32
    };
    match model {
        Model::Ggx => (0..NODES).into_par_iter().map(of_node).collect(),
        Model::BlinnPhong | Model::CookTorrance => vec![1.0; NODES],
    }
}

/// How high a profile reaches, times cosine, sr⁻¹.
fn height(profile: &Profile) -> f64 {
    let values = profile.nodes.iter().enumerate().map(|(node, value)| value * angles::theta(node).cos());
    of_largest(values).abs().max(f64::MIN_POSITIVE)
}

/// The core in the profiles that were chosen: those that it was found in are turned among each other, and orders are
/// not to mix. Each profile's weight is multiplied with its height.
fn core(found: &Array3<f64>, of_profiles: &Array2<f64>, heights: &[f64]) -> Array3<f64> {
    let (a, b, _) = found.dim();
    let mut core = Array3::zeros((a, b, heights.len()));
    for (mut to, from) in core.outer_iter_mut().zip(found.outer_iter()) {
        to.assign(&(from.dot(&of_profiles.t()) * ArrayView1::from(heights)));
    }
    core
}

fn scaled(row: &ArrayView1<'_, f64>, factor: f64) -> Vec<f32> {
    row.iter().map(|value| (value * factor) as f32).collect()
}

fn squared<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.map(|value| value * value).sum()
}

#[cfg(test)]
mod tests;
