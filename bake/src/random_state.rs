//! States that nothing was made for: random parameters of the materials that vary.

use crate::trace::sampler::{PixelSampler, Sample};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx, Model, Rgb};
use relume_scenes::Scene;

/// Parameters of the materials that vary, in random state number `state`: colours of any hue, diffuse and
/// glossy in any proportion, or dielectrics, metals and what is between in equal numbers; exponents and
/// roughnesses evenly spread over octaves, which is how artists perceive them.
pub fn random_state(state: u32, scene: &Scene) -> Vec<Brdf> {
    let sampler = PixelSampler::new(0x68_656c_646f_7574, state);
    let material = |(index, material): (u32, &usize)| {
        let material = &scene.materials[*material];
        let sample = sampler.sample(index);
        let model = material.brdf.model();
        let sharpest = scene.vary.sharpest(model);
        match model {
            Model::BlinnPhong => random_blinn_phong(&sample, sharpest),
            Model::Ggx => random_ggx(&sample, material.texture.is_some(), sharpest),
            Model::CookTorrance => random_cook_torrance(&sample, sharpest),
        }
    };
    (0..).zip(&scene.vary.materials).map(material).collect()
}

/// All materials of `scene`, those that vary being in random state number `state`.
pub fn all_in_random_state(state: u32, scene: &Scene) -> Vec<Brdf> {
    let mut all: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    scene.vary.materials.iter().zip(random_state(state, scene)).for_each(|(index, brdf)| all[*index] = brdf);
    all
}

/// All materials of `scene`, those that vary being in random state number `state` but as sharp as they may be.
pub fn all_as_sharp_as_they_get(state: u32, scene: &Scene) -> Vec<Brdf> {
    let mut all = all_in_random_state(state, scene);
    for index in &scene.vary.materials {
        let sharpest = scene.vary.sharpest(all[*index].model());
        match &mut all[*index] {
            Brdf::BlinnPhong(material) => material.shininess = sharpest,
            Brdf::CookTorrance(material) => material.roughness = sharpest,
            Brdf::Ggx(material) => material.roughness = sharpest,
        }
    }
    all
}

fn random_blinn_phong(sample: &Sample, sharpest: f32) -> Brdf {
    let ([kd, ks], exponent) = random_parts(sample);
    let shininess = sharpest.powf(exponent).clamp(1.0, sharpest);
    Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess })
}

/// Colours of a diffuse and of a glossy part that share what is reflected, and how sharp that one is, 0..1.
fn random_parts(sample: &Sample) -> ([Rgb; 2], f32) {
    let [share, sharpness] = sample.pair(0);
    let [kr, kg] = sample.pair(1);
    let [kb, sr] = sample.pair(2);
    let [sg, sb] = sample.pair(3);
    ([[kr, kg, kb].map(|k| k * share), [sr, sg, sb].map(|k| k * (1.0 - share))], sharpness)
}

fn random_cook_torrance(sample: &Sample, sharpest: f32) -> Brdf {
    let ([kd, ks], octave) = random_parts(sample);
    let [fresnel, _] = sample.pair(4);
    let roughness = sharpest.powf(octave).clamp(sharpest, 1.0);
    Brdf::CookTorrance(CookTorrance { kd, ks, fresnel, roughness })
}

fn random_ggx(sample: &Sample, textured: bool, sharpest: f32) -> Brdf {
    let [metal, octave] = sample.pair(0);
    let [r, g] = sample.pair(1);
    let [b, _] = sample.pair(2);
    // A third each of dielectrics and metals, the rest evenly between.
    let metallic = if textured { 0.0 } else { (3.0 * metal - 1.0).clamp(0.0, 1.0) };
    Brdf::Ggx(Ggx { base_color: [r, g, b], metallic, roughness: sharpest.powf(octave).clamp(sharpest, 1.0) })
}
