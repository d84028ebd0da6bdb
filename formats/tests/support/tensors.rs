//! Small BRDF tensors, made from a seed.

use super::samples::Random;
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::angles::NODES;
use relume_formats::kinds::brdf_tensor::{Cone, Meta, Samples};
use relume_formats::state::Model;

/// Width, tilt and side of the cones, degrees.
pub const CONES_DEG: [[f32; 3]; 3] = [[3.0, 0.0, 0.0], [6.0, -20.0, 0.0], [12.0, 5.0, 20.0]];

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

/// Profiles of orders 0, 1, 2, 0, 1, …
pub fn tensor(seed: u64, model: Model, ranks: [usize; 3]) -> BrdfTensor {
    let random = &mut Random(seed);
    let samples = samples(model, random);
    let [a, b, c] = ranks;
    let count = samples.count();
    let whole = f64::from(random.unit());
    let meta = Meta {
        model,
        residual: whole + 0.25,
        materials: 0.5 * whole,
        outgoing: 0.25 * whole,
        incoming: 0.125 * whole,
        whole,
    };
    let mut signed = |count: usize| -> Vec<f32> { (0..count).map(|_| random.signed()).collect() };
    BrdfTensor {
        core: signed(a * b * c),
        materials: signed(count * a),
        outgoing: signed(NODES * b),
        incoming: signed(NODES * c),
        orders: (0..c as u32).map(|profile| profile % 3).collect(),
        cones: CONES_DEG
            .map(|[width_deg, tilt_deg, side_deg]| Cone { width_deg, tilt_deg, side_deg })
            .to_vec(),
        shares: signed(count * NODES * CONES_DEG.len()).into_iter().map(f32::abs).collect(),
        even: signed(NODES).into_iter().map(f32::abs).collect(),
        meta,
        samples,
        ranks,
    }
}
