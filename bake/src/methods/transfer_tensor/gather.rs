//! The tensor of a vertex: rays over what is above it, and what the points that they meet reflect.

use super::classes::Class;
use super::{Arriving, Classes, Lobes, RAYS};
use crate::compress::linalg::single_thread;
use crate::trace::receivers::{Receiver, triangles};
use crate::trace::sampler::PixelSampler;
use crate::trace::world::{Meeting, Owner, World};
use glam::{Vec3, Vec3A};
use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayViewMut2, s};
use relume_formats::basis::sh;
use relume_scenes::Scene;
use std::f32::consts::TAU;

/// Rays whose reflected light is multiplied with harmonics at once: what fits a core's cache.
const BATCH: usize = 64;

/// Finds the tensors of vertices.
pub struct Gather<'a> {
    world: &'a World,
    receivers: &'a [Receiver],
    arriving: &'a Arriving,
    classes: &'a Classes,
    lobes: Lobes,
    triangles: Vec<[u32; 3]>,
    /// Rays a vertex.
    rays: u32,
    seed: u64,
}

/// A ray that met something.
struct Ray {
    direction: Vec3A,
    meeting: Meeting,
    material: u32,
}

impl<'a> Gather<'a> {
    /// For the vertices of `scene`, which `world` and `receivers` are of, under the light that `arriving`
    /// has. Every vertex looks in [`RAYS`] directions, random by `seed`.
    pub fn new(
        scene: &Scene,
        (world, receivers): (&'a World, &'a [Receiver]),
        arriving: &'a Arriving,
        classes: &'a Classes,
        seed: u64,
    ) -> Self {
        single_thread();
        let lobes = Lobes::new(arriving.face_size);
        let triangles = triangles(scene);
        Self { world, receivers, arriving, classes, lobes, triangles, rays: RAYS, seed }
    }

    /// The same with `rays` a vertex, best a power of two.
    pub fn with_rays(self, rays: u32) -> Self {
        Self { rays, ..self }
    }

    /// Columns of a tensor, texels of the light, harmonics.
    pub fn shape(&self) -> [usize; 3] {
        [self.classes.columns.len(), self.arriving.texels(), sh::COUNT]
    }

    /// T¹ of `vertex`, row-major [columns, texels, harmonics]: the radiance that arrives at it after one
    /// reflection is Σ light(texel) · weight(column) · T¹ · Y. `tensor` is as long as [`Gather::shape`] says
    /// and is overwritten.
    pub fn tensor(&self, vertex: usize, tensor: &mut [f32]) {
        tensor.fill(0.0);
        let of_column = self.arriving.texels() * sh::COUNT;
        let mut rays = self.looked(vertex);
        // All that one class reflects, one after the other; a stable sort, for sums are in the order of rays.
        rays.sort_by_key(|ray| self.classes.of(ray.material).first);
        for of_class in
            rays.chunk_by(|a, b| self.classes.of(a.material).first == self.classes.of(b.material).first)
        {
            let class = self.classes.of(of_class[0].material);
            let to = &mut tensor[class.first * of_column..][..class.columns * of_column];
            let shape = (class.columns * self.arriving.texels(), sh::COUNT);
            if let Ok(mut to) = ArrayViewMut2::from_shape(shape, to) {
                of_class.chunks(BATCH).for_each(|rays| self.add(rays, class.columns, &mut to));
            }
        }
    }

    /// The light that rays of one class bring, times the harmonics of their directions.
    fn add(&self, rays: &[Ray], columns: usize, to: &mut ArrayViewMut2<'_, f32>) {
        let weight = TAU / self.rays as f32;
        let mut reflected = Array2::<f32>::zeros((BATCH, columns * self.arriving.texels()));
        let mut harmonics = Array2::<f32>::zeros((BATCH, sh::COUNT));
        let rows = reflected.rows_mut().into_iter().zip(harmonics.rows_mut());
        for (ray, (mut row, mut values)) in rays.iter().zip(rows) {
            if let (Some(row), Some(values)) = (row.as_slice_mut(), values.as_slice_mut()) {
                values.copy_from_slice(&sh::evaluate(Vec3::from(ray.direction)).map(|y| y * weight));
                self.reflect(ray, row);
            }
        }
        let used = s![..rays.len(), ..];
        general_mat_mul(1.0, &reflected.slice(used).t(), &harmonics.slice(used), 1.0, to);
    }

    /// What `vertex` meets that reflects: surfaces from their fronts.
    fn looked(&self, vertex: usize) -> Vec<Ray> {
        let sampler = PixelSampler::new(self.seed, vertex as u32);
        let Receiver { origin, normal } = self.receivers[vertex];
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let look = |index: u32| {
            let [u, cos] = sampler.sample(index).pair(0);
            let (sin, (sin_phi, cos_phi)) = ((1.0 - cos * cos).max(0.0).sqrt(), (TAU * u).sin_cos());
            let direction = normal * cos + (tangent * cos_phi + bitangent * sin_phi) * sin;
            let meeting = self.world.meet(origin, direction)?;
            match meeting.owner {
                Owner::Material(material) if meeting.front => Some(Ray { direction, meeting, material }),
                _ => None,
            }
        };
        (0..self.rays).filter_map(look).collect()
    }

    /// Adds the light that reaches the start of `ray` to `row`, [columns of the class, texels].
    fn reflect(&self, ray: &Ray, row: &mut [f32]) {
        let class = self.classes.of(ray.material);
        for (vertex, share) in self.corners(&ray.meeting) {
            self.reflect_at(vertex, share, class, ray, row);
        }
    }

    /// The vertices around a point that was met, and what each of them counts.
    fn corners(&self, meeting: &Meeting) -> [(usize, f32); 3] {
        let [v, w] = meeting.barycentric;
        let [a, b, c] = self.triangles[meeting.triangle as usize].map(|vertex| vertex as usize);
        [(a, 1.0 - v - w), (b, v), (c, w)]
    }

    fn reflect_at(&self, vertex: usize, share: f32, class: &Class, ray: &Ray, row: &mut [f32]) {
        let (normal, outgoing) = (self.receivers[vertex].normal, -ray.direction);
        let texels = self.arriving.texels();
        let albedo = ray.meeting.albedo;
        let (even, count) = self.classes.even(class, albedo);
        let evaluate = |at: &_| self.classes.evaluate(class, albedo, at);
        for (texel, arriving) in self.arriving.at(vertex) {
            let (texel, arriving) = (usize::from(*texel), arriving * share);
            for (column, value) in even[..count].iter().enumerate() {
                row[column * texels + texel] += arriving * value;
            }
            if count < class.columns {
                let mean = self.lobes.mean(texel, normal, outgoing, evaluate);
                for (column, value) in mean[..class.columns].iter().enumerate().skip(count) {
                    row[column * texels + texel] += arriving * value;
                }
            }
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
        for ray in self.looked(vertex) {
            let column = self.classes.of(ray.material).first;
            let to = &mut sketch[self.classes.columns[column].class * of_class..][..of_class];
            let harmonics = sh::evaluate(Vec3::from(ray.direction));
            for (corner, share) in self.corners(&ray.meeting) {
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
