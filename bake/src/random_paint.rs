//! Textures that nothing was made for: random paintings of the materials that take them.

use crate::random_state::random_state;
use crate::trace::sampler::{PixelSampler, Sample};
use relume_formats::state::{Brdf, Paint, Texel, texel_of};
use relume_scenes::Scene;
use std::f32::consts::TAU;
use std::sync::Arc;

/// Texels on a side.
const SIDE: u32 = 256;
/// Random materials that a painting is of.
const COLOURS: u32 = 6;
/// Cells of a mosaic.
const CELLS: u32 = 24;

/// `scene` in random state number `state`: the materials that take textures have in turn washes of colour, mosaics,
/// stripes, and checks, of six random materials each.
pub fn in_random_paint(state: u32, scene: &Scene) -> Scene {
    let mut painted = scene.clone();
    for (class, (material, brdf)) in scene.vary.materials.iter().zip(random_state(state, scene)).enumerate() {
        painted.materials[*material].brdf = brdf;
        if scene.vary.painted.contains(material) {
            let colour = |k: u32| texel_of(&random_state(1000 + state * COLOURS + k, scene)[class]);
            let colours: Vec<Texel> = (0..COLOURS).map(colour).collect();
            let sample = PixelSampler::new(0x7061_696e_7473, state).sample(class as u32);
            let paint = painting(&brdf, &colours, state % 4, &sample);
            painted.materials[*material].paint = Some(Arc::new(paint));
        }
    }
    painted
}

fn painting(brdf: &Brdf, colours: &[Texel], pattern: u32, sample: &Sample) -> Paint {
    let mut paint = Paint::uniform(brdf, [SIDE; 2]);
    paint.replaces_texture = true;
    for (index, texel) in (0..).zip(&mut paint.texels) {
        let uv = [index % SIDE, index / SIDE].map(|x| (x as f32 + 0.5) / SIDE as f32);
        *texel = match pattern {
            0 => wash(colours, uv, sample),
            1 => colours[nearest(uv, sample) as usize % colours.len()],
            2 => stripes(colours, uv, sample),
            _ => checks(colours, uv, sample),
        };
    }
    paint
}

/// Colours that flow into each other.
fn wash(colours: &[Texel], uv: [f32; 2], sample: &Sample) -> Texel {
    let share = |k: u32| {
        let ([a, b], [phase, _]) = (sample.pair(2 * k), sample.pair(2 * k + 1));
        let angle = (4.0 * a - 2.0) * uv[0] + (4.0 * b - 2.0) * uv[1] + phase;
        (0.5 + 0.5 * (TAU * angle).cos()).powi(4) + 1e-3
    };
    let shares: Vec<f32> = (0..).zip(colours).map(|(k, _)| share(k)).collect();
    mixed(colours.iter().zip(shares))
}

/// The cell of a mosaic.
fn nearest(uv: [f32; 2], sample: &Sample) -> u32 {
    let distance = |k: &u32| {
        let middle = sample.pair(*k);
        (uv[0] - middle[0]).powi(2) + (uv[1] - middle[1]).powi(2)
    };
    (0..CELLS).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

fn stripes(colours: &[Texel], uv: [f32; 2], sample: &Sample) -> Texel {
    let ([angle, count], [phase, _]) = (sample.pair(0), sample.pair(1));
    let (y, x) = (TAU * angle).sin_cos();
    let along = (uv[0] * x + uv[1] * y) * (3.0 + 9.0 * count) + 4.0 + phase;
    let number = along as usize;
    // A tenth of a stripe flows into the next.
    let edge = (10.0 * (along.fract() - 0.9)).max(0.0);
    let [a, b] = [number, number + 1].map(|number| &colours[number % colours.len()]);
    mixed([(a, 1.0 - edge), (b, edge)].into_iter())
}

fn checks(colours: &[Texel], uv: [f32; 2], sample: &Sample) -> Texel {
    let count = (4.0 + 12.0 * sample.pair(0)[0]).floor();
    let [x, y] = uv.map(|x| (x * count) as usize);
    colours[if (x + y).is_multiple_of(2) { 0 } else { 1 + (x / 2 + y / 2) % (colours.len() - 1) }]
}

/// Between materials: what is reflected in the mean, and the sharpness in the mean of logarithms.
fn mixed<'a>(colours: impl Iterator<Item = (&'a Texel, f32)>) -> Texel {
    let mut all = 0.0;
    let mut sum = [[0.0f32; 3]; 3];
    for ([colour, gloss, sharpness], share) in colours {
        all += share;
        let parts = [colour, gloss, &sharpness.map(f32::ln)];
        for (sum, part) in sum.as_flattened_mut().iter_mut().zip(parts.into_iter().flatten()) {
            *sum += share * part;
        }
    }
    let [colour, gloss, sharpness] = sum.map(|layer| layer.map(|x| x / all));
    [colour, gloss, sharpness.map(f32::exp)]
}
