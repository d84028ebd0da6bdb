//! Whether the method serves a scene, and what that takes.

use super::basis::model;
use super::chromaticity::chromaticity;
use super::held_out;
use super::later;
use super::settings::{NAME, Settings};
use crate::error::{BakeError, Result};
use crate::fragments::SIDE;
use crate::guided;
use crate::trace::gather::MAX_REFLECTIONS;
use relume_formats::Place;
use relume_formats::kinds::transfer_images::{Layout, MAX_MATERIALS};
use relume_scenes::{ALL_REFLECTIONS, Scene};

/// Bytes that are known of a fragment while its filter is chosen.
const FILTERED: u64 = 512;

/// Fails, naming what stands in the way, unless the method serves what `scene` varies.
pub fn expect_fit(scene: &Scene) -> Result<()> {
    let place = Place::file(&scene.file);
    let refuse = |reason: String| Err(BakeError::invalid(&place, reason));
    if scene.vary.shape {
        return refuse(format!("[vary] shape = true, but {NAME} keeps shapes fixed; set it to false"));
    }
    if scene.vary.materials.is_empty() {
        return refuse(
            "[vary] names no materials, so there is nothing to bake; `bake reference` makes an image of a scene that never changes".into(),
        );
    }
    if scene.vary.materials.len() > MAX_MATERIALS {
        return refuse(format!(
            "[vary] names {} materials, {NAME} serves at most {MAX_MATERIALS}",
            scene.vary.materials.len()
        ));
    }
    let varying = || scene.vary.materials.iter().map(|index| &scene.materials[*index]);
    if let Some(other) = varying().find(|m| m.brdf.model() != model(scene)) {
        let (first, name) = (&scene.materials[scene.vary.materials[0]], &other.name);
        return refuse(format!(
            "[vary] names materials of two models, `{}` of \"{}\" and `{name}` of \"{}\", but one bake has bases for one; give both the same brdf",
            first.name,
            first.brdf.model().name(),
            other.brdf.model().name()
        ));
    }
    if scene.reflections > MAX_REFLECTIONS && scene.reflections != ALL_REFLECTIONS {
        return refuse(format!(
            "[render] reflections = {}, {NAME} models at most {MAX_REFLECTIONS} or all; set 1, 2 or \"all\"",
            scene.reflections_written()
        ));
    }
    Ok(())
}

/// Bytes that a bake holds at most, which is while it writes: halves, their compressed copies, the images
/// that measuring compares with, the hierarchy, and the environment.
pub(super) fn predicted_bytes(scene: &Scene, settings: &Settings) -> u64 {
    let later = later::images(scene, settings.bases);
    let layout =
        Layout::new(scene.vary.materials.len(), settings.bases, chromaticity(scene).is_some(), later);
    let pixels = u64::from(settings.size[0]) * u64::from(settings.size[1]);
    // A tenth of the pixels show a second class at most in all scenes seen so far.
    let fragments = pixels + pixels / 10;
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let texels = scene.environment.as_ref().map_or(0, |e| e.map.map.texels.len() as u64);
    // A tile is filtered beside those around it, and some pixels show several classes.
    let tiles =
        9 * u64::from(SIDE * SIDE) * layout.channels() as u64 * 4 * rayon::current_num_threads() as u64;
    fragments * (layout.channels() as u64 * 8 + 32 + FILTERED)
        + tiles
        + pixels.div_ceil(u64::from(held_out::SPACING.pow(2))) * 12 * u64::from(held_out::STATES)
        + triangles * 600
        + texels * 48
        + if scene.reflections < 2 { 0 } else { guided::MEMORY }
}
