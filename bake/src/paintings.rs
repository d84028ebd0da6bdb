//! Where textures lie on the materials of a scene that are painted: one answer for bakes, references and
//! pictures.

use crate::error::Result;
use crate::interrupted::Interrupted;
use crate::job::{Job, note};
use relume_scenes::Scene;
use relume_scenes::painting::Painting;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Where textures lie on the materials of `scene` that are painted, and that anything wears: by the texture
/// coordinates of its meshes, or where these do not serve by an atlas. Tells which.
///
/// # Errors
/// If a material needs an atlas and none can be made, or the user asks to stop.
pub fn paintings(scene: &Scene, job: &Job) -> Result<Vec<Painting>> {
    let of = |material: &usize| {
        let name = &scene.materials[*material].name;
        match Painting::of_meshes(scene, *material) {
            Ok(painting) => {
                note(&format!("note: `{name}` is painted by the texture coordinates of its meshes"));
                Ok(painting)
            }
            Err(why) => {
                note(&format!(
                    "note: `{name}` is painted by an atlas, for its texture coordinates do not serve: {why}"
                ));
                atlas(scene, *material, job)
            }
        }
    };
    let found = scene.vary.painted.iter().map(of).collect::<Result<Vec<_>>>()?;
    Ok(found.into_iter().filter(|painting| !painting.is_empty()).collect())
}

fn atlas(scene: &Scene, material: usize, job: &Job) -> Result<Painting> {
    let worn = scene.objects.iter().filter(|object| object.material == material);
    let triangles: usize = worn.map(|object| object.mesh.triangles.len()).sum();
    let progress = job.progress("making an atlas", triangles as u64);
    let told = AtomicUsize::new(0);
    let goes_on = |done: usize| {
        let before = told.fetch_max(done, Ordering::Relaxed);
        progress.advance(done.saturating_sub(before) as u64);
        progress.check().is_ok()
    };
    let atlas = Painting::of_atlas(scene, material, goes_on)?;
    // Only an interruption ends it.
    atlas.map_or_else(|| Err(progress.check().err().unwrap_or(Interrupted).into()), Ok)
}
