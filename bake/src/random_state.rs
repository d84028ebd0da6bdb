//! States that nothing was made for: random parameters of the materials that vary.

use crate::trace::sampler::{PixelSampler, Sample};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx, Model, Rgb};
use relume_scenes::Scene;

/// Parameters of the materials that vary, in random state number `state`: colours of any hue, diffuse and
/// glossy in any proportion, or dielectrics, metals and what is between in equal numbers; exponents and
/// roughnesses evenly spread over octaves, which is how artists perceive them.
pub fn random_state(state: u32, scene: &Scene) -> Vec<Brdf> {
    varying_in(state, scene, |_, gloss_and_sharpness| gloss_and_sharpness)
}

/// All materials of `scene`, those that vary being in random state number `state`.
pub fn all_in_random_state(state: u32, scene: &Scene) -> Vec<Brdf> {
    with_varying(scene, random_state(state, scene))
}

/// All materials of `scene` in so many states, number `first` and those that follow, which together have all that
/// there may be: each material that varies is in one of them as sharp as it may be, and glossy, in another as blunt
/// as it may be, and matt, and in between in the rest. Not all materials are the sharpest in the same one. There
/// are at least two.
pub fn all_in_spread_states(first: u32, states: u32, scene: &Scene) -> Vec<Vec<Brdf>> {
    let spread = |state: u32| {
        let within = |material: u32, [gloss, _]: [f32; 2]| {
            let part = ((state + material) % states) as f32;
            [(part + gloss) / states as f32, part / (states - 1) as f32]
        };
        with_varying(scene, varying_in(first + state, scene, within))
    };
    (0..states).map(spread).collect()
}

/// The materials that vary, in state number `state`; `place` moves how glossy and how sharp each is, of 0..1.
fn varying_in(state: u32, scene: &Scene, place: impl Fn(u32, [f32; 2]) -> [f32; 2]) -> Vec<Brdf> {
    let sampler = PixelSampler::new(0x68_656c_646f_7574, state);
    let material = |(index, material): (u32, &usize)| {
        let material = &scene.materials[*material];
        let sample = sampler.sample(index);
        let model = material.brdf.model();
        let sharpest = scene.vary.sharpest(model);
        let [first, sharpness] = sample.pair(0);
        let placed = |gloss| place(index, [gloss, sharpness]);
        match model {
            Model::BlinnPhong => random_blinn_phong(&sample, placed(1.0 - first), sharpest),
            Model::Ggx => random_ggx(&sample, placed(first), material.texture.is_some(), sharpest),
            Model::CookTorrance => random_cook_torrance(&sample, placed(1.0 - first), sharpest),
        }
    };
    (0..).zip(&scene.vary.materials).map(material).collect()
}

fn with_varying(scene: &Scene, varying: Vec<Brdf>) -> Vec<Brdf> {
    let mut all: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    scene.vary.materials.iter().zip(varying).for_each(|(index, brdf)| all[*index] = brdf);
    all
}

fn random_blinn_phong(sample: &Sample, [gloss, exponent]: [f32; 2], sharpest: f32) -> Brdf {
    let [kd, ks] = random_parts(sample, gloss);
    let shininess = sharpest.powf(exponent).clamp(1.0, sharpest);
    Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess })
}

/// Colours of a diffuse and of a glossy part, which is so large, of what is reflected.
fn random_parts(sample: &Sample, gloss: f32) -> [Rgb; 2] {
    let [kr, kg] = sample.pair(1);
    let [kb, sr] = sample.pair(2);
    let [sg, sb] = sample.pair(3);
    [[kr, kg, kb].map(|k| k * (1.0 - gloss)), [sr, sg, sb].map(|k| k * gloss)]
}

fn random_cook_torrance(sample: &Sample, [gloss, octave]: [f32; 2], sharpest: f32) -> Brdf {
    let [kd, ks] = random_parts(sample, gloss);
    let [fresnel, _] = sample.pair(4);
    let roughness = sharpest.powf(octave).clamp(sharpest, 1.0);
    Brdf::CookTorrance(CookTorrance { kd, ks, fresnel, roughness })
}

fn random_ggx(sample: &Sample, [metal, octave]: [f32; 2], textured: bool, sharpest: f32) -> Brdf {
    let [r, g] = sample.pair(1);
    let [b, _] = sample.pair(2);
    // A third each of dielectrics and metals, the rest evenly between.
    let metallic = if textured { 0.0 } else { (3.0 * metal - 1.0).clamp(0.0, 1.0) };
    Brdf::Ggx(Ggx { base_color: [r, g, b], metallic, roughness: sharpest.powf(octave).clamp(sharpest, 1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sharpness in octaves, and how glossy: parts of what is reflected on average.
    fn gloss_and_octave(brdf: &Brdf) -> [f32; 2] {
        let Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) = brdf else { panic!("{brdf:?}") };
        let [kd, ks] = [kd, ks].map(|colour| colour.iter().sum::<f32>());
        [ks / (kd + ks), shininess.ln() / 200f32.ln()]
    }

    /// Each material is as sharp as it may be in one of four states, as blunt in another, and in between in the rest;
    /// it is glossiest where it is sharpest; the two are not the sharpest in the same state. What does not vary
    /// stays.
    #[test]
    fn spread_states_have_all_that_there_may_be() {
        let scene = relume_scenes::load("../scenes/library/cornell-knot/scene.toml".as_ref()).unwrap();
        let states = all_in_spread_states(7, 4, &scene);
        let octaves: Vec<Vec<f32>> = (scene.vary.materials.iter())
            .map(|material| states.iter().map(|state| gloss_and_octave(&state[*material])[1]).collect())
            .collect();
        for octaves in &octaves {
            let mut thirds = octaves.clone();
            thirds.sort_by(f32::total_cmp);
            for (third, octave) in (0..).zip(thirds) {
                assert!((3.0 * octave - third as f32).abs() < 1e-5, "{octaves:?}");
            }
        }
        let sharpest = |octaves: &Vec<f32>| octaves.iter().position(|octave| *octave > 0.9).unwrap();
        assert_ne!(sharpest(&octaves[0]), sharpest(&octaves[1]));
        for (material, octaves) in scene.vary.materials.iter().zip(&octaves) {
            let gloss: Vec<f32> = states.iter().map(|state| gloss_and_octave(&state[*material])[0]).collect();
            let most = gloss.iter().copied().fold(0.0, f32::max);
            assert_eq!(gloss[sharpest(octaves)], most, "{gloss:?}");
        }
        for (number, material) in scene.materials.iter().enumerate() {
            let stays = !scene.vary.materials.contains(&number);
            assert!(!stays || states.iter().all(|state| state[number] == material.brdf));
        }
    }
}
