//! The basis of a scene's materials.

use crate::brdf::basis::Space;
use crate::error::Result;
use relume_formats::state::Model;
use relume_scenes::Scene;

/// The model of the materials that vary, all the same in a scene that fits.
pub fn model(scene: &Scene) -> Model {
    scene.vary.materials.first().map_or(Model::BlinnPhong, |index| scene.materials[*index].brdf.model())
}

/// Up to `bases` functions for the materials of `scene` that vary. The diffuse basis carries the texture of
/// textured ones, so highlights may not use it then.
///
/// # Errors
/// If LAPACK fails.
pub fn space_for(scene: &Scene, bases: usize) -> Result<Space> {
    let textured = scene.vary.materials.iter().any(|index| scene.materials[*index].texture.is_some());
    let model = model(scene);
    Ok(Space::new(model, scene.vary.sharpest(model), bases, !textured)?)
}
