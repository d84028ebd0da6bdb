//! Light after two reflections, as irradiance at vertices (thesis §5.3.3.6): T²(l, pair) at x is the
//! cosine-weighted mean, over directions that meet a point y, of ∫ I¹_y(l, column₁; ω')·ρ(ω', ω_o)·(ω'·n_y)
//! dω', ρ the function of column₂ that y has and I¹ the light at y after one reflection, four bands of
//! harmonics. As before, y is the three vertices around it, each in its own frame.

use super::around::{Around, Ray, Spread};
use super::lobe_harmonics::{Harmonics, LobeHarmonics, Turn, Turns, cosine, turned};
use super::lobe_table::in_frame;
use super::packed::LIGHTS;
use super::{Classes, SECOND_RAYS};
use crate::compress::linalg::single_thread;
use crate::trace::receivers::Receiver;
use crate::trace::world::World;
use half::f16;
use half::slice::HalfFloatSliceExt as _;
use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::sh;
use relume_scenes::Scene;

/// Rays whose products are summed at once: what fits a core's cache.
const BATCH: usize = 4;
/// Vertices around a point.
const CORNERS: usize = 3;

/// Finds T² of vertices.
pub struct Second<'a> {
    around: Around<'a>,
    classes: &'a Classes,
    /// Of all vertices, [`coarse`](super::packed::coarse).
    coarse: &'a [f16],
    /// Of [`Classes::functions`].
    harmonics: Vec<LobeHarmonics>,
    /// By vertex.
    turns: Vec<Turn>,
    pairs: Vec<[usize; 2]>,
    rays: u32,
}

impl<'a> Second<'a> {
    /// For the vertices of `scene`, which `world` and `receivers` are of; `coarse` has light after one
    /// reflection at all of them, one after the other, as [`coarse`](super::packed::coarse) gives it. Every
    /// vertex looks in [`SECOND_RAYS`] directions, random by `seed`.
    ///
    /// # Errors
    /// If LAPACK fails.
    pub fn new(
        scene: &Scene,
        (world, receivers): (&'a World, &'a [Receiver]),
        classes: &'a Classes,
        coarse: &'a [f16],
        seed: u64,
    ) -> Result<Self, LinalgError> {
        single_thread();
        let turns = Turns::new()?;
        Ok(Self {
            around: Around::new(scene, (world, receivers), seed),
            classes,
            coarse,
            harmonics: classes.functions.iter().map(LobeHarmonics::new).collect(),
            turns: receivers.par_iter().map(|receiver| turns.to_world(receiver.normal)).collect(),
            pairs: classes.pairs(),
            rays: SECOND_RAYS,
        })
    }

    /// The same with `rays` a vertex, best a power of two.
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays, ..self }
    }

    /// Pairs of columns, coefficients of the light.
    pub fn shape(&self) -> [usize; 2] {
        [self.pairs.len(), LIGHTS[1]]
    }

    /// T² of `vertex`, row-major [pairs, 24]: Σ c_k · weight(pair) · T² is its irradiance over π after two
    /// reflections. `tensor` is as long as [`Second::shape`] says and is overwritten.
    pub fn tensor(&self, vertex: usize, tensor: &mut [f32]) {
        let columns = self.classes.columns.len();
        let of_column = LIGHTS[1];
        let mut sums = Array2::<f32>::zeros((columns, columns * of_column));
        let mut rays = self.around.met(vertex, self.rays, Spread::ByCosine);
        // A stable sort, for sums are in the order of rays.
        rays.sort_by_key(|ray| self.classes.of(ray.material).first);
        for of_class in
            rays.chunk_by(|a, b| self.classes.of(a.material).first == self.classes.of(b.material).first)
        {
            self.add(of_class, &mut sums);
        }
        for (to, [first, second]) in tensor.chunks_exact_mut(of_column).zip(&self.pairs) {
            let from = sums.slice(s![*second, first * of_column..(first + 1) * of_column]);
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        }
    }

    /// What rays to one class bring, to `sums`, [later columns, columns nearer the light · 24].
    fn add(&self, rays: &[Ray], sums: &mut Array2<f32>) {
        let class = self.classes.of(rays[0].material);
        let mut to = sums.slice_mut(s![class.first..class.first + class.columns, ..]);
        let rows = BATCH.min(rays.len()) * CORNERS * sh::COUNT;
        let mut light = Array2::<f32>::zeros((rows, to.ncols()));
        let mut reflectance = Array2::<f32>::zeros((rows, class.columns));
        for rays in rays.chunks(BATCH) {
            let corners = rays.iter().flat_map(|ray| self.around.corners(&ray.meeting).map(|at| (ray, at)));
            for (k, (ray, (vertex, share))) in corners.enumerate() {
                let rows = s![k * sh::COUNT..(k + 1) * sh::COUNT, ..];
                self.light(vertex, light.slice_mut(rows).as_slice_mut().unwrap_or_default());
                for (column, harmonics) in
                    self.reflectance(ray, vertex).into_iter().enumerate().take(class.columns)
                {
                    let mut to = reflectance.slice_mut(s![k * sh::COUNT..(k + 1) * sh::COUNT, column]);
                    to.iter_mut().zip(harmonics).for_each(|(to, value)| *to = share * value);
                }
            }
            let used = s![..rays.len() * CORNERS * sh::COUNT, ..];
            let weight = 1.0 / self.rays as f32;
            general_mat_mul(weight, &reflectance.slice(used).t(), &light.slice(used), 1.0, &mut to);
        }
    }

    /// The light at `vertex` after one reflection, [harmonics, columns, 24].
    fn light(&self, vertex: usize, to: &mut [f32]) {
        let length = to.len();
        self.coarse[vertex * length..][..length].convert_to_f32_slice(to);
    }

    /// The harmonics of what the columns of the class that `ray` meets make of light at `vertex`.
    fn reflectance(&self, ray: &Ray, vertex: usize) -> Vec<Harmonics> {
        let class = self.classes.of(ray.material);
        let terms = class.terms(ray.meeting.albedo);
        let mut columns: Vec<Harmonics> =
            terms.even[..class.columns].iter().map(|even| cosine().map(|y| even * y)).collect();
        if let Some(functions) = class.functions {
            let outgoing = in_frame(self.around.receivers[vertex].normal, -ray.direction);
            let all = self.harmonics[functions].towards(outgoing);
            for share in terms.shares() {
                let from = &all[share.function];
                columns[share.column].iter_mut().zip(from).for_each(|(to, y)| *to += share.of * y);
            }
        }
        columns.iter().map(|harmonics| turned(&self.turns[vertex], harmonics)).collect()
    }
}

#[cfg(test)]
mod tests;
