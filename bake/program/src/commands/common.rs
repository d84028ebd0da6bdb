//! What several commands need: where things go, scenes, threads.

use crate::cli::AskedArgs;
use relume_bake::error::Result;
use relume_bake::job::{detail, is_verbose, say};
use relume_bake::methods::asked::Asked;
use relume_bake::probe::Probe;
use relume_formats::counts::counted;
use relume_scenes::Scene;
use std::time::Instant;

/// Where bundles of scenes go if nothing else is said.
pub(super) const BUNDLES: &str = "baked";
/// How an interrupted chart goes on.
pub(super) const SAME_COMMAND: &str = "finished work is kept, the same command goes on with it";
/// More warnings at once than this are counted only.
const MOST_WARNINGS: usize = 100;

/// The scene called so, or in that file; tells what is wrong with it but can be baked.
pub(super) fn load(scene: &str) -> Result<Scene> {
    let start = Instant::now();
    let scene = relume_scenes::load(&relume_scenes::resolve(scene)?)?;
    let triangles: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
    let (objects, triangles) =
        (counted(scene.objects.len(), "object", "objects"), counted(triangles, "triangle", "triangles"));
    let (file, seconds) = (scene.file.display(), start.elapsed().as_secs_f64());
    detail(&format!("read {file} in {seconds:.2} s: {objects}, {triangles}"));
    warn(&scene.warnings);
    Ok(scene)
}

/// Tells what is wrong with how `scene` looks on a film of `size` pixels.
pub(super) fn look_at(scene: &Scene, size: [u32; 2]) -> Result<()> {
    let start = Instant::now();
    warn(&Probe::new(scene, size)?.warnings());
    detail(&format!("looked at the scene in {:.2} s", start.elapsed().as_secs_f64()));
    Ok(())
}

/// What the command line asks of all methods. Warns of what is meant as per cent.
pub(super) fn asked(args: &AskedArgs, scene: &Scene) -> Asked {
    let asked = Asked {
        size: args.size.unwrap_or(scene.size),
        quality: args.quality,
        samples: args.spp,
        seed: args.seed,
        max_error: args.max_error.unwrap_or(scene.max_error),
        filter: args.filter,
        noise: args.noise,
        bases: args.bases,
        terms: args.terms,
    };
    warn_of_per_cent("an error", asked.max_error);
    asked.noise.into_iter().for_each(|noise| warn_of_per_cent("noise", noise));
    asked
}

/// Warns of an error, or noise, to keep below of 1 or more, which is 100 %: who writes that means per cent.
pub(super) fn warn_of_per_cent(what: &str, most: f64) {
    if most >= 1.0 {
        let (per_cent, meant) = (100.0 * most, most / 100.0);
        say(&format!("warning: {what} of {most} is {per_cent} %; for {most} % write {meant}"));
    }
}

/// Tells `warnings`, as many as anybody would read.
pub(super) fn warn(warnings: &[String]) {
    let most = if is_verbose() { usize::MAX } else { MOST_WARNINGS };
    warnings.iter().take(most).for_each(|warning| say(&format!("warning: {warning}")));
    let more = warnings.len().saturating_sub(most);
    if more > 0 {
        say(&format!("warning: and {more} more of these"));
    }
}

/// So many threads, or one for each core.
pub(super) fn start_threads(threads: Option<u32>) -> Result<()> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize).build_global()?)
}
