//! Bakes of region-images without a bundle.

use super::job;
use relume_bake::guided;
use relume_bake::methods::region_images::Settings;
use relume_bake::methods::region_images::bake::{Baked, Baking};
use relume_bake::methods::transfer_images::space_for;
use relume_bake::paintings::paintings;
use relume_bake::stage::{Share, Stage, fill};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::world::World;
use relume_bake::work_log::WorkLog;
use relume_formats::evaluate::region_images::{Worn, evaluate};
use relume_formats::kinds::BrdfBasis;
use relume_formats::state::Rgb;
use relume_scenes::Scene;

/// For `size` × `size` pixels as they are traced.
pub fn settings(size: u32, samples: u32, max_error: f64) -> Settings {
    Settings { size: [size, size], samples, seed: 3, bases: 6, max_error, filter: false }
}

/// Basis and bake of `scene`.
pub fn bake(scene: &Scene, settings: Settings) -> (BrdfBasis, Baked) {
    let paintings = paintings(scene, &job()).unwrap();
    let world = World::painted(scene, &paintings);
    let lights = Lights::new(scene, &world);
    let Settings { size, samples, seed, bases, .. } = settings;
    let paths = guided::Settings { size, samples, reflections: scene.reflections, seed, target: None };
    let gather = guided::gather(scene, &world, &lights, &paths, &job()).unwrap();
    let basis = space_for(scene, bases).unwrap().basis(bases);
    let folder = tempfile::tempdir().unwrap();
    let run = |stage: &dyn Stage| {
        let log = WorkLog::create(&folder.path().join(stage.name()), 0).unwrap();
        fill(stage, &log, Share::WHOLE, &job())?;
        Ok(Some(log))
    };
    let baking = Baking { scene, paintings: &paintings, gather: &gather, basis: &basis, settings };
    let baked = baking.bake(&job(), run).unwrap().unwrap();
    (basis, baked)
}

/// What a bake shows of `state`, which is its scene in a state.
pub fn shown(basis: &BrdfBasis, baked: &Baked, state: &Scene) -> Vec<Rgb> {
    let materials = state.vary.materials.iter().map(|index| &state.materials[*index]);
    let worn: Vec<Worn<'_>> =
        materials.map(|m| m.paint.as_deref().map_or(Worn::Whole(&m.brdf), Worn::Painted)).collect();
    evaluate(&baked.images, basis, &worn).unwrap()
}
