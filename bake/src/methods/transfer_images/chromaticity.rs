//! Whether all light of a scene has one colour: then one channel holds an image.

use relume_formats::basis::linear_from_srgb;
use relume_formats::state::Rgb;
use relume_scenes::{Emitter, Scene};

/// The one colour of all light in `scene`, its largest channel 1; `None` if colours differ.
pub fn chromaticity(scene: &Scene) -> Option<Rgb> {
    let colours = scene.lights.iter().flat_map(|light| colours_of(&light.emitter));
    let environment = scene.environment.iter().flat_map(|e| {
        let gain = e.gain;
        e.map.map.texels.iter().map(move |t| [t[0] * gain[0], t[1] * gain[1], t[2] * gain[2]])
    });
    let mut common: Option<Rgb> = None;
    for colour in colours.chain(environment) {
        let largest = colour.iter().copied().fold(0.0, f32::max);
        if largest <= 0.0 {
            continue;
        }
        let unit = colour.map(|c| c / largest);
        match common {
            None => common = Some(unit),
            Some(c) if c.iter().zip(unit).all(|(a, b)| (a - b).abs() <= 1e-6) => {}
            Some(_) => return None,
        }
    }
    Some(common.unwrap_or([1.0; 3]))
}

/// Every colour that a light has somewhere.
fn colours_of(emitter: &Emitter) -> Box<dyn Iterator<Item = Rgb> + '_> {
    match emitter {
        Emitter::Mesh { radiance, glow: Some(glow), .. } => {
            Box::new(glow.texture.texels.iter().map(|texel| {
                let share = |k: usize| linear_from_srgb(texel[k]);
                std::array::from_fn(|k| radiance[k] * share(k))
            }))
        }
        Emitter::Area { radiance, .. } | Emitter::Mesh { radiance, .. } => {
            Box::new(std::iter::once(*radiance))
        }
        Emitter::Point { intensity, .. } => Box::new(std::iter::once(*intensity)),
        Emitter::Directional { irradiance, .. } => Box::new(std::iter::once(*irradiance)),
    }
}

/// The channel in which light of this colour is brightest.
pub fn grey_channel(chromaticity: Option<Rgb>) -> usize {
    let colour = chromaticity.unwrap_or([1.0; 3]);
    (0..3).max_by(|a, b| colour[*a].total_cmp(&colour[*b])).unwrap_or(0)
}
