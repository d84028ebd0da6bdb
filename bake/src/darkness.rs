//! Whether a scene shows anything: a picture that is black has no error worth telling.

use crate::error::Result;
use crate::job::{Job, ProgressMode};
use crate::trace::reference::{self, Paths, Settings};
use relume_formats::state::{BlinnPhong, Brdf};
use relume_scenes::{Material, Scene};

/// What is said of a scene that shows nothing.
pub const WARNING: &str = "the picture is black, no light reaches what the camera sees; check that the camera is not inside an object or below a floor, \
that lights face the scene, and that what they emit, or the environment's gain, is above 0";

/// About how many pixels are looked at.
const PIXELS: f64 = 1024.0;
/// Paths of each.
const SAMPLES: u32 = 16;

/// Whether all paths of a small picture of `scene`, of the proportions of a film of `size`, carry nothing,
/// whatever its materials are.
///
/// # Errors
/// If the user asks to stop.
pub fn is_black(scene: &Scene, [width, height]: [u32; 2]) -> Result<bool> {
    let smaller = (PIXELS / (f64::from(width) * f64::from(height))).sqrt().min(1.0);
    let size = [width, height].map(|side| ((f64::from(side) * smaller).round() as u32).max(1));
    let settings = Settings {
        size,
        samples: SAMPLES,
        seed: 0,
        reflections: scene.reflections,
        paths: Paths::Best,
        target: None,
    };
    let scene = in_grey(scene);
    let images = reference::render(
        &scene,
        std::slice::from_ref(&scene),
        &[],
        &settings,
        &Job::new(ProgressMode::None),
    )?;
    Ok(images.iter().flat_map(|image| &image.radiance).flatten().all(|radiance| *radiance == 0.0))
}

/// The scene in materials that reflect all colours; what is cut out of them stays cut out.
pub(crate) fn in_grey(scene: &Scene) -> Scene {
    let grey = Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks: [0.0; 3], shininess: 1.0 });
    let in_grey = |material: &Material| {
        let texture = material.texture.clone().filter(|_| material.alpha_cutoff.is_some());
        Material { brdf: grey, texture, ..material.clone() }
    };
    Scene { materials: scene.materials.iter().map(in_grey).collect(), ..scene.clone() }
}
