//! Small BRDF tensors, made from a seed.

use super::samples::Random;
use relume_formats::basis::disc::{self, AZIMUTHS, CELLS, RINGS};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::{Meta, Samples};
use relume_formats::state::Model;
use std::f32::consts::FRAC_1_PI;

/// Of the mirror terms.
pub const WIDTHS_DEG: [f32; 3] = [0.0, 5.0, 20.0];

/// Columns that are orthonormal over cells, weighed by areas: [`CELLS`] rows.
fn columns(random: &mut Random, count: usize) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).enumerate().map(|(cell, (a, b))| disc::weight(cell / AZIMUTHS) * a * b).sum()
    };
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for _ in 0..count {
        let mut column: Vec<f64> = (0..CELLS).map(|_| f64::from(random.signed())).collect();
        for other in &columns {
            let along = product(&column, other);
            column.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
        }
        let length = product(&column, &column).sqrt();
        column.iter_mut().for_each(|value| *value /= length);
        columns.push(column);
    }
    columns
}

fn row_major(columns: &[Vec<f64>], first: Option<f32>) -> Vec<f32> {
    (0..CELLS)
        .flat_map(|cell| first.into_iter().chain(columns.iter().map(move |column| column[cell] as f32)))
        .collect()
}

/// Of three exponents, or the four corners of a plane and something within.
fn samples(model: Model, random: &mut Random) -> Samples {
    let least = match model {
        Model::BlinnPhong => return Samples::Line(vec![1.0, 1.0 + 199.0 * random.unit().max(1e-3), 200.0]),
        Model::Ggx => 0.32,
        Model::CookTorrance => 0.1,
    };
    let [x, y] = [0.1 + 0.8 * random.unit(), least + (1.0 - least) * (0.1 + 0.8 * random.unit())];
    Samples::Plane {
        points: vec![[0.0, least], [1.0, least], [1.0, 1.0], [0.0, 1.0], [x, y]],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    }
}

pub fn tensor(seed: u64, model: Model, ranks: [usize; 3]) -> BrdfTensor {
    let random = &mut Random(seed);
    let samples = samples(model, random);
    let [a, b, c] = ranks;
    let whole = f64::from(random.unit());
    let meta = Meta {
        model,
        residual: whole + 0.25,
        materials: 0.5 * whole,
        outgoing: 0.25 * whole,
        incoming: 0.125 * whole,
        whole,
    };
    BrdfTensor {
        core: (0..a * b * c).map(|_| random.signed()).collect(),
        materials: (0..samples.count() * a).map(|_| random.signed()).collect(),
        outgoing: row_major(&columns(random, b), None),
        incoming: row_major(&columns(random, c), Some(FRAC_1_PI)),
        widths_deg: WIDTHS_DEG.to_vec(),
        mirror: (0..samples.count() * RINGS * WIDTHS_DEG.len()).map(|_| random.unit()).collect(),
        meta,
        samples,
        ranks,
    }
}
