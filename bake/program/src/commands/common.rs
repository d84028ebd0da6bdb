//! What several commands need: where things go, scenes, threads.

use relume_bake::error::Result;
use relume_bake::job::say;
use relume_bake::probe::Probe;
use relume_scenes::Scene;

/// Where bundles of scenes go if nothing else is said.
pub(super) const BUNDLES: &str = "baked";
/// How an interrupted chart goes on.
pub(super) const SAME_COMMAND: &str = "finished work is kept, the same command goes on with it";
/// More warnings at once than this are counted only.
const MOST_WARNINGS: usize = 100;

/// The scene called so, or in that file; tells what is wrong with it but can be baked.
pub(super) fn load(scene: &str) -> Result<Scene> {
    let scene = relume_scenes::load(&relume_scenes::resolve(scene)?)?;
    warn(&scene.warnings);
    Ok(scene)
}

/// Tells what is wrong with how `scene` looks on a film of `size` pixels.
pub(super) fn look_at(scene: &Scene, size: [u32; 2]) -> Result<()> {
    warn(&Probe::new(scene, size)?.warnings());
    Ok(())
}

/// Tells `warnings`, as many as anybody would read.
pub(super) fn warn(warnings: &[String]) {
    warnings.iter().take(MOST_WARNINGS).for_each(|warning| say(&format!("warning: {warning}")));
    let more = warnings.len().saturating_sub(MOST_WARNINGS);
    if more > 0 {
        say(&format!("warning: and {more} more of these"));
    }
}

/// So many threads, or one for each core.
pub(super) fn start_threads(threads: Option<u32>) -> Result<()> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize).build_global()?)
}
