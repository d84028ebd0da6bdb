//! Whether the method can show a scene, and what of it is left out.

use super::settings::NAME;
use crate::error::{BakeError, Result};
use crate::methods::environment_lit;
use relume_formats::Place;
use relume_formats::bundle::MAX_SPHERE_PAIRS;
use relume_scenes::{Object, Scene};

/// Fails, naming what stands in the way, unless the method can show `scene`.
pub(super) fn expect_fit(scene: &Scene) -> Result<()> {
    let refuse = |reason: String| Err(BakeError::invalid(&Place::file(&scene.file), reason));
    environment_lit::expect_fit(scene, NAME)?;
    if scene.reflections > 1 {
        let reflections = scene.reflections_written();
        return refuse(format!(
            "[render] reflections = {reflections}, {NAME} models direct light only; set it to 1"
        ));
    }
    let pairs =
        scene.objects.iter().filter_map(|object| object.spheres).map(|n| u64::from(n).pow(2)).sum::<u64>();
    if pairs > MAX_SPHERE_PAIRS {
        return refuse(format!(
            "its spheres make {pairs} pairs within objects, {NAME} holds at most {MAX_SPHERE_PAIRS}; lower `spheres`"
        ));
    }
    for object in &scene.objects {
        let place = Place::file(&scene.file).part(format!("object `{}`", object.name));
        object.shape.iter().try_for_each(|shape| shape.validate(&place))?;
    }
    Ok(())
}

/// What of `scene` is not shown, a sentence each.
pub(super) fn leaves_out(scene: &Scene) -> Vec<String> {
    let is_cut =
        |object: &&Object| scene.materials.get(object.material).is_some_and(|m| m.alpha_cutoff.is_some());
    let cut = scene.objects.iter().filter(is_cut).map(|object| {
        format!(
            "object `{}`: {NAME} cuts the holes of its texture into the shadows of suns alone; cut them into its mesh",
            object.name
        )
    });
    environment_lit::leaves_out(scene, NAME).into_iter().chain(cut).collect()
}
