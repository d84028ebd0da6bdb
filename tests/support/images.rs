//! Bakes of transfer-images without a bundle.

use super::job;
use relume_bake::brdf::basis::Space;
use relume_bake::guided;
pub use relume_bake::methods::transfer_images::Settings;
use relume_bake::methods::transfer_images::{self, Baked};
use relume_bake::stage::{Share, Stage, fill};
use relume_bake::trace::gather::{Gather, GatherPath};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::world::World;
use relume_bake::work_log::WorkLog;
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;

/// For `size` × `size` pixels as they are traced.
pub fn settings(size: u32, samples: u32, bases: usize, seed: u64) -> Settings {
    Settings { size: [size, size], samples, seed, bases, filter: false }
}

/// Basis and images of `scene`.
pub fn bake(scene: &Scene, settings: &Settings, shared_diffuse: bool) -> (BrdfBasis, TransferImages) {
    let model = transfer_images::model(scene);
    let space = Space::new(model, scene.vary.sharpest(model), settings.bases, shared_diffuse).unwrap();
    let basis = space.basis(settings.bases);
    let images = gathering(scene, settings, |gather| bake_by(scene, settings, &basis, gather));
    (basis, images)
}

/// Images of `scene` on `basis`, by the paths of `gather`.
pub fn bake_by(scene: &Scene, settings: &Settings, basis: &BrdfBasis, gather: &Gather<'_>) -> TransferImages {
    baked_by(scene, settings, basis, gather).images
}

/// All that a bake makes.
pub fn baked_by(scene: &Scene, settings: &Settings, basis: &BrdfBasis, gather: &Gather<'_>) -> Baked {
    let folder = tempfile::tempdir().unwrap();
    let run = |stage: &dyn Stage| {
        let log = WorkLog::create(&folder.path().join(stage.name()), 0).unwrap();
        fill(stage, &log, Share::WHOLE, &job())?;
        Ok(Some(log))
    };
    transfer_images::bake(scene, gather, settings, basis, &job(), run).unwrap().unwrap()
}

/// Gives the paths of a bake of `scene` to `then`.
pub fn gathering<T>(scene: &Scene, settings: &Settings, then: impl FnOnce(&Gather<'_>) -> T) -> T {
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let Settings { size, samples, seed, .. } = *settings;
    let reflections = scene.reflections;
    let paths = guided::Settings { size, samples, reflections, seed, target: None };
    then(&guided::gather(scene, &world, &lights, &paths, &job()).unwrap())
}

/// The coefficients of materials.
pub fn on_bases(basis: &BrdfBasis, materials: &[Brdf]) -> Vec<Vec<Rgb>> {
    materials.iter().map(|m| basis.coefficients_of(m).unwrap()).collect()
}

/// `scene` with other materials in the places of those that vary.
pub fn in_state(scene: &Scene, materials: &[Brdf]) -> Scene {
    let mut scene = scene.clone();
    for (index, material) in scene.vary.materials.clone().into_iter().zip(materials) {
        scene.materials[index].brdf = *material;
    }
    scene
}

/// Pixels that no light or background is seen through: a lamp in view would hide the errors of everything
/// else.
pub fn surface_pixels(scene: &Scene, settings: &Settings) -> Vec<usize> {
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let gather = Gather::new(scene, &world, &lights, settings.size, 2, settings.seed);
    let shows_surfaces_only = |pixel: &u32| {
        let mut only = true;
        gather.pixel(*pixel, settings.samples, |path| only &= matches!(path, GatherPath::Surface(_)));
        only
    };
    (0..settings.size[0] * settings.size[1]).filter(shows_surfaces_only).map(|p| p as usize).collect()
}

/// Of an image, these.
pub fn pick(image: &[[f32; 3]], pixels: &[usize]) -> Vec<[f32; 3]> {
    pixels.iter().map(|p| image[*p]).collect()
}
