//! Direct light: terms of all columns of a vertex.

use super::spaces::Columns;
use crate::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, add, exact_radiances};
use crate::trace::receivers::Receiver;
use glam::Vec3A;
use relume_formats::basis::{approximate, haar};

/// Most terms that a vertex keeps until it is known how many are needed.
pub const MAX_TERMS: usize = 512;

/// Rows and what some of them are to give.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// Columns of every row, those that a vertex has not being 0.
    pub columns: usize,
    /// Row-major [rows, [`MAX_TERMS`]], most important first.
    pub indices: Vec<u16>,
    /// Row-major [rows, [`MAX_TERMS`], columns].
    pub values: Vec<f32>,
    /// What is known exactly, of some rows.
    pub exact: Vec<Exact>,
}

/// What a row gives under the held-out lights.
#[derive(Debug, Clone, PartialEq)]
pub struct Exact {
    /// Which row it is.
    pub row: usize,
    /// What each column usually counts for.
    pub importance: Vec<f32>,
    /// By column.
    pub given: Vec<[f32; RADIANCES]>,
    /// What a white diffuse surface shows, suns included.
    pub seen: [f32; RADIANCES],
}

impl Rows {
    /// No rows yet, of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { columns, ..Self::default() }
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.indices.len() / MAX_TERMS
    }

    /// Adds the most important terms of a vertex, whose first column is `row`, by texels. `weights` is what sizes of
    /// coefficients are multiplied by to tell how important they are. With `lights` what it gives under them is kept.
    pub fn push(
        &mut self,
        (receiver, row): (&Receiver, &[f32]),
        (columns, texels): (&Columns, &Texels),
        weights: &[f32],
        lights: Option<&HeldOutLights>,
    ) {
        let mut planes = planes(receiver, row, columns, texels);
        let seen = lights.map(|lights| exact_radiances(&planes[..1], lights).seen);
        planes.iter_mut().for_each(|plane| haar::forward_cube(plane, FACE_SIZE));
        if let Some((lights, seen)) = lights.zip(seen) {
            let given = planes.iter().map(|plane| radiances(plane, lights)).collect();
            self.exact.push(Exact { row: self.count(), importance: columns.importance.clone(), given, seen });
        }
        let size = |i: usize| {
            let columns = planes.iter().zip(&columns.importance);
            columns.map(|(plane, weight)| (plane[i] * weight).powi(2)).sum::<f32>().sqrt()
        };
        let sizes: Vec<f32> = (0..weights.len()).map(size).collect();
        let kept = approximate::largest(&sizes, MAX_TERMS, |index| weights[index]);
        for term in 0..MAX_TERMS {
            let index = kept.get(term).map(|(index, _)| *index as usize);
            self.indices.push(index.unwrap_or(0) as u16);
            let value = |column: usize| index.zip(planes.get(column)).map_or(0.0, |(i, plane)| plane[i]);
            self.values.extend((0..self.columns).map(value));
        }
    }

    /// Adds the rows of `other`, which have as many columns.
    pub fn append(&mut self, mut other: Self) {
        let before = self.count();
        other.exact.iter_mut().for_each(|exact| exact.row += before);
        self.indices.append(&mut other.indices);
        self.values.append(&mut other.values);
        self.exact.append(&mut other.exact);
    }
}

/// All columns by texels.
fn planes(receiver: &Receiver, row: &[f32], columns: &Columns, texels: &Texels) -> Vec<Vec<f32>> {
    let mut planes = vec![vec![0.0; row.len()]; columns.count()];
    planes[0].copy_from_slice(row);
    let (tangent, bitangent) = receiver.normal.any_orthonormal_pair();
    let mut ratios = vec![0.0; columns.count() - 1];
    if ratios.is_empty() {
        return planes;
    }
    for (texel, (value, direction)) in row.iter().zip(texels.centres.directions()).enumerate() {
        if *value > 0.0 {
            let [x, y, z] = [tangent, bitangent, receiver.normal].map(|axis| axis.dot(*direction));
            columns.ratios(Vec3A::new(x, y, z.max(0.0)), &mut ratios);
            for (plane, ratio) in planes[1..].iter_mut().zip(&ratios) {
                plane[texel] = value * ratio;
            }
        }
    }
    planes
}

fn radiances(plane: &[f32], lights: &HeldOutLights) -> [f32; RADIANCES] {
    let mut sums = [0.0; RADIANCES];
    for (value, light) in plane.iter().zip(lights.coefficients.chunks_exact(RADIANCES)) {
        if *value != 0.0 {
            add(&mut sums, &[*value], light);
        }
    }
    sums
}
