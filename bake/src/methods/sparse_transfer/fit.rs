//! Whether the method can show a scene, and what that takes.

use super::rows::MAX_TERMS;
use super::settings::{NAME, bounces, channels, cubes, face_size, vertices};
use crate::error::{BakeError, Result};
use crate::methods::environment_lit;
use crate::trace::held_out_lights::RADIANCES;
use relume_formats::Place;
use relume_formats::basis::cubemap::FACES;
use relume_formats::container::MAX_SECTION_BYTES;
use relume_formats::kinds::sparse_transfer::MAX_BOUNCES;
use relume_scenes::Scene;

/// Fails, naming what stands in the way, unless the method can show `scene`.
pub(super) fn expect_fit(scene: &Scene) -> Result<()> {
    let place = Place::file(&scene.file);
    let refuse = |reason: String| Err(BakeError::invalid(&place, reason));
    if scene.vary.shape {
        return refuse(format!("[vary] shape = true, but {NAME} keeps shapes fixed; set it to false"));
    }
    environment_lit::expect_fit(scene, NAME)?;
    if bounces(scene) > MAX_BOUNCES {
        let most = MAX_BOUNCES + 1;
        return refuse(format!(
            "[render] reflections = {}, {NAME} models at most {most}; lower it",
            scene.reflections_written()
        ));
    }
    Ok(())
}

/// Fails if a file of the bundle could not hold the rows of `scene`.
pub(super) fn expect_sizes(scene: &Scene) -> Result<()> {
    // The largest section is a block of sixteen columns of 16-bit integers.
    let most = MAX_SECTION_BYTES / (16 * 2 * channels(scene) as u64);
    let vertices = vertices(scene) as u64;
    if vertices > most {
        let reason =
            format!("{vertices} vertices, {NAME} holds at most {most} of this kind; simplify the meshes");
        return Err(BakeError::invalid(&Place::file(&scene.file), reason));
    }
    Ok(())
}

/// Bytes that a bake holds at most: the hierarchy, the lights, and selected rows twice over, or, before these
/// are there, all that arrives at all vertices for the light that bounces on.
pub(super) fn predicted_bytes(scene: &Scene) -> u64 {
    let (vertices, channels, size) =
        (vertices(scene) as u64, channels(scene) as u64, face_size(scene) as u64);
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let coefficients = FACES as u64 * size * size;
    let selected = vertices * (MAX_TERMS as u64 * (2 + 4 * channels) + 2 * 4 * RADIANCES as u64);
    // Direct light has no colour yet.
    let arriving = match bounces(scene) {
        0 => 0,
        1 => vertices * coefficients * 4,
        _ => vertices * coefficients * 4 * 3,
    };
    let lights = (coefficients * (1 + cubes(scene) as u64)) * RADIANCES as u64 * 4 * 5;
    (2 * selected).max(arriving) + triangles * 600 + lights + (64 << 20)
}
