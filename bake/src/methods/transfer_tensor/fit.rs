//! Whether the method can show a scene, and what that takes.

use super::cluster;
use super::packed::RANKS;
use super::rows::MAX_TERMS;
use super::settings::NAME;
use crate::error::{BakeError, Result};
use crate::methods::environment_lit;
use crate::methods::sparse_transfer::vertices;
use relume_formats::Place;
use relume_formats::basis::sh;
use relume_formats::container::MAX_SECTION_BYTES;
use relume_formats::kinds::transfer_tensor::{MAX_REFLECTIONS, MAX_SOURCES, ONCE_LIGHT, TWICE_LIGHT};
use relume_formats::state::Model;
use relume_scenes::Scene;

/// Columns of direct light of materials with highlights, about.
const COLUMNS: u64 = 9;
/// Sources of a material that varies: as many as its basis has functions, and two more if a texture colours it.
const SOURCES: usize = super::BASES;

/// Fails, naming what stands in the way, unless the method can show `scene`.
pub(super) fn expect_fit(scene: &Scene) -> Result<()> {
    let place = Place::file(&scene.file);
    let refuse = |reason: String| Err(BakeError::invalid(&place, reason));
    if scene.vary.shape {
        return refuse(format!("[vary] shape = true, but {NAME} keeps shapes fixed; set it to false"));
    }
    let models = scene.vary.materials.iter().map(|index| scene.materials[*index].brdf.model());
    let sharper = |model: &Model| scene.vary.sharpest(*model) != model.usual_sharpest();
    if let Some(model) = models.into_iter().find(sharper) {
        let key = if model == Model::BlinnPhong { "shininess_max" } else { "roughness_min" };
        let value = scene.vary.sharpest(model);
        return refuse(format!(
            "[vary] `{key}` = {value}, but {NAME} tabulates no sharper lobes than usual; remove it, or name materials alone"
        ));
    }
    environment_lit::expect_fit(scene, NAME)?;
    if scene.reflections > MAX_REFLECTIONS {
        return refuse(format!(
            "[render] reflections = {}, {NAME} models at most {MAX_REFLECTIONS}; lower it",
            scene.reflections_written()
        ));
    }
    if scene.reflections > 1 && sources(scene) > MAX_SOURCES {
        let (most, varying) = ((MAX_SOURCES - 3) / (SOURCES + 2), scene.vary.materials.len());
        return refuse(format!(
            "[vary] names {varying} materials, {NAME} reflects the light of {most} at most; name fewer, or set reflections = 1"
        ));
    }
    Ok(())
}

/// Sources of reflected light.
fn sources(scene: &Scene) -> usize {
    let varying = scene.vary.materials.iter();
    let of_varying = varying.map(|m| SOURCES + if scene.materials[*m].texture.is_some() { 2 } else { 0 });
    of_varying.sum::<usize>() + 3
}

/// Fails if a file of the bundle could not hold the vertices of `scene`.
pub(super) fn expect_sizes(scene: &Scene) -> Result<()> {
    let of_vertex = (super::quantise::MOST_TERMS as u64 * COLUMNS).max((sources(scene) * RANKS[0]) as u64);
    let (vertices, most) = (vertices(scene) as u64, MAX_SECTION_BYTES / of_vertex);
    if vertices > most {
        let reason =
            format!("{vertices} vertices, {NAME} holds at most {most} of this kind; simplify the meshes");
        return Err(BakeError::invalid(&Place::file(&scene.file), reason));
    }
    Ok(())
}

/// Bytes that a bake holds at most: the hierarchy, and selected rows twice over, or, before these are there, the tensors of
/// a cluster for every thread and what all vertices reflect a second time.
pub(super) fn predicted_bytes(scene: &Scene) -> u64 {
    let vertices = vertices(scene) as u64;
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let selected = vertices * MAX_TERMS as u64 * (2 + 4 * COLUMNS);
    let sources = if scene.reflections > 1 { sources(scene) as u64 } else { 0 };
    let harmonics = sources * sh::COUNT as u64;
    let threads = rayon::current_num_threads() as u64;
    // A cluster's tensors, and their copy in double precision, a column at a time.
    let of_clusters = threads * cluster::MOST as u64 * harmonics * ONCE_LIGHT as u64 * 4 * 2;
    let coarse = vertices * harmonics * TWICE_LIGHT as u64 * 2;
    let stored = vertices * sources * RANKS[0] as u64 * 3;
    (2 * selected + stored).max(of_clusters + coarse) + triangles * 600 + (256 << 20)
}
