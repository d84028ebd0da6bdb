//! The tensor of a vertex: rays over what is above it, and what the points that they meet reflect.

use super::around::{Around, Ray, Spread};
use super::functions::MOST;
use super::lobe_table::{Discs, Lit, LobeTable, in_frame};
use super::{Arriving, Classes, RAYS};
use crate::compress::linalg::single_thread;
use crate::trace::receivers::Receiver;
use crate::trace::world::World;
use glam::Vec3;
use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayViewMut2, s};
use rayon::prelude::*;
use relume_formats::basis::sh;
use relume_scenes::Scene;
use std::f32::consts::TAU;

/// Rays whose reflected light is multiplied with harmonics at once: what fits a core's cache.
const BATCH: usize = 64;

/// Finds the tensors of vertices.
pub struct Gather<'a> {
    around: Around<'a>,
    classes: &'a Classes,
    /// Of [`Classes::functions`].
    tables: Vec<LobeTable>,
    /// By vertex.
    lit: Vec<Vec<Lit>>,
    texels: usize,
    /// Rays a vertex.
    rays: u32,
}

/// What a point reflects of each texel, before it is sorted into columns.
struct Planes {
    /// If it reflected all.
    even: Vec<f32>,
    /// By every function, [functions, texels].
    functions: Vec<f32>,
}

impl<'a> Gather<'a> {
    /// For the vertices of `scene`, which `world` and `receivers` are of, under the light that `arriving`
    /// has. Every vertex looks in [`RAYS`] directions, random by `seed`.
    pub fn new(
        scene: &Scene,
        (world, receivers): (&'a World, &'a [Receiver]),
        arriving: &Arriving,
        classes: &'a Classes,
        seed: u64,
    ) -> Self {
        single_thread();
        let discs = Discs::new(arriving.face_size);
        let tables = classes.functions.iter().map(|functions| LobeTable::new(functions, &discs)).collect();
        let lit = |vertex: usize| {
            let normal = receivers[vertex].normal;
            arriving.at(vertex).iter().map(|texel| discs.lit(*texel, normal)).collect()
        };
        let lit = (0..receivers.len()).into_par_iter().map(lit).collect();
        let around = Around::new(scene, (world, receivers), seed);
        Self { around, classes, tables, lit, texels: arriving.texels(), rays: RAYS }
    }

    /// The same with `rays` a vertex, best a power of two.
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays, ..self }
    }

    /// Columns of a tensor, texels of the light, harmonics.
    pub fn shape(&self) -> [usize; 3] {
        [self.classes.columns.len(), self.texels, sh::COUNT]
    }

    /// T¹ of `vertex`, row-major [columns, texels, harmonics]: the radiance that arrives at it after one
    /// reflection is Σ light(texel) · weight(column) · T¹ · Y. `tensor` is as long as [`Gather::shape`] says
    /// and is overwritten.
    pub fn tensor(&self, vertex: usize, tensor: &mut [f32]) {
        tensor.fill(0.0);
        let of_column = self.texels * sh::COUNT;
        let mut rays = self.around.met(vertex, self.rays, Spread::Evenly);
        // All that one class reflects, one after the other; a stable sort, for sums are in the order of rays.
        rays.sort_by_key(|ray| self.classes.of(ray.material).first);
        for of_class in
            rays.chunk_by(|a, b| self.classes.of(a.material).first == self.classes.of(b.material).first)
        {
            let class = self.classes.of(of_class[0].material);
            let to = &mut tensor[class.first * of_column..][..class.columns * of_column];
            let shape = (class.columns * self.texels, sh::COUNT);
            if let Ok(mut to) = ArrayViewMut2::from_shape(shape, to) {
                self.add(of_class, class.columns, &mut to);
            }
        }
    }

    /// The light that rays of one class bring, times the harmonics of their directions.
    fn add(&self, rays: &[Ray], columns: usize, to: &mut ArrayViewMut2<'_, f32>) {
        let weight = TAU / self.rays as f32;
        let mut reflected = Array2::<f32>::zeros((BATCH.min(rays.len()), columns * self.texels));
        let mut harmonics = Array2::<f32>::zeros((BATCH.min(rays.len()), sh::COUNT));
        let mut planes = Planes { even: vec![0.0; self.texels], functions: vec![0.0; MOST * self.texels] };
        for rays in rays.chunks(BATCH) {
            let rows = reflected.rows_mut().into_iter().zip(harmonics.rows_mut());
            for (ray, (mut row, mut values)) in rays.iter().zip(rows) {
                if let (Some(row), Some(values)) = (row.as_slice_mut(), values.as_slice_mut()) {
                    values.copy_from_slice(&sh::evaluate(Vec3::from(ray.direction)).map(|y| y * weight));
                    self.reflect(ray, &mut planes, row);
                }
            }
            let used = s![..rays.len(), ..];
            general_mat_mul(1.0, &reflected.slice(used).t(), &harmonics.slice(used), 1.0, to);
        }
    }

    /// Writes the light that reaches the start of `ray` to `row`, [columns of the class, texels].
    fn reflect(&self, ray: &Ray, planes: &mut Planes, row: &mut [f32]) {
        let class = self.classes.of(ray.material);
        let table = class.functions.map(|functions| &self.tables[functions]);
        planes.even.fill(0.0);
        planes.functions.fill(0.0);
        for (vertex, share) in self.around.corners(&ray.meeting) {
            let lit = &self.lit[vertex];
            lit.iter().for_each(|lit| planes.even[usize::from(lit.texel)] += share * lit.arriving);
            if let Some(table) = table {
                let outgoing = in_frame(self.around.receivers[vertex].normal, -ray.direction);
                table.add(outgoing, lit, share, &mut planes.functions, self.texels);
            }
        }
        let terms = class.terms(ray.meeting.albedo);
        for (to, even) in row.chunks_exact_mut(self.texels).zip(terms.even) {
            to.iter_mut().zip(&planes.even).for_each(|(to, value)| *to = even * value);
        }
        for share in terms.shares() {
            let from = &planes.functions[share.function * self.texels..][..self.texels];
            let to = &mut row[share.column * self.texels..][..self.texels];
            to.iter_mut().zip(from).for_each(|(to, value)| *to += share.of * value);
        }
    }

    /// A sketch of the tensor of `vertex` for clusters to be made by: what it would be if all that is met
    /// were white and diffuse, for a light of 6×2×2 texels and four harmonics, [materials that vary and the
    /// fixed ones, 24·4]. `coarse` has that light at all vertices.
    pub fn sketch(&self, vertex: usize, coarse: &Arriving) -> Vec<f32> {
        const HARMONICS: usize = 4;
        let of_class = coarse.texels() * HARMONICS;
        let classes = self.classes.columns.last().map_or(0, |column| column.class + 1);
        let mut sketch = vec![0.0; classes * of_class];
        for ray in self.around.met(vertex, self.rays, Spread::Evenly) {
            let column = self.classes.of(ray.material).first;
            let to = &mut sketch[self.classes.columns[column].class * of_class..][..of_class];
            let harmonics = sh::evaluate(Vec3::from(ray.direction));
            for (corner, share) in self.around.corners(&ray.meeting) {
                for (texel, arriving) in coarse.at(corner) {
                    let value = share * arriving * (2.0 / self.rays as f32);
                    let to = &mut to[usize::from(*texel) * HARMONICS..][..HARMONICS];
                    to.iter_mut().zip(harmonics).for_each(|(sum, y)| *sum += value * y);
                }
            }
        }
        sketch
    }
}

#[cfg(test)]
mod tests;
