//! The method as the bundle sees it: settings, files, entry of the manifest.

use super::bake::{Baked, Baking};
use super::held_out::{Errors, measured_on};
use super::settings::{NAME, REVISION, Settings, reads};
use crate::error::{BakeError, Result};
use crate::filter::Noise;
use crate::guided;
use crate::job::Job;
use crate::memory::MemoryNeed;
use crate::method::{Method, Predicted, Product};
use crate::methods::transfer_images;
use crate::paintings::paintings;
use crate::trace::lights::Lights;
use crate::trace::world::World;
use crate::unfinished::Work;
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::kinds::BrdfBasis;
use relume_formats::method::Card;
use relume_scenes::{ALL_REFLECTIONS, Scene};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The method with the settings that it is to bake with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionImagesMethod(pub Settings);

impl Method for RegionImagesMethod {
    fn card(&self) -> &'static Card {
        &relume_formats::method::REGION_IMAGES
    }

    fn expect_fit(&self, scene: &Scene) -> Result<()> {
        let place = Place::file(&scene.file);
        if scene.vary.painted.is_empty() {
            let reason = format!(
                "[vary] painted names no material, so {NAME} has none to paint; name one, or take transfer-images, which edits materials as wholes"
            );
            return Err(BakeError::invalid(&place, reason));
        }
        transfer_images::expect_fit(scene)
    }

    fn leaves_out(&self, scene: &Scene) -> Vec<String> {
        let parts = [("light", scene.vary.light), ("view", scene.vary.view)];
        let fixed = parts.into_iter().filter(|(_, varies)| *varies);
        fixed
            .map(|(what, _)| format!("[vary] {what} = true, but {NAME} keeps the {what} as the scene has it"))
            .collect()
    }

    fn asked_for(&self) -> BTreeMap<String, Value> {
        let Settings { size, samples, seed, bases, max_error, filter } = self.0;
        BTreeMap::from([
            ("revision".to_owned(), json!(REVISION)),
            ("size".to_owned(), json!(size)),
            ("samples".to_owned(), json!(samples)),
            ("seed".to_owned(), json!(seed)),
            ("bases".to_owned(), json!(bases)),
            ("max_error".to_owned(), json!(max_error)),
            ("filter".to_owned(), json!(if filter { "on" } else { "off" })),
        ])
    }

    fn chosen(&self) -> &'static [&'static str] {
        &["components"]
    }

    fn predict(&self, scene: &Scene, job: &Job) -> Result<Predicted> {
        super::prediction::predict(&self.0, scene, job)
    }

    fn memory(&self, scene: &Scene) -> MemoryNeed {
        MemoryNeed { bytes: super::prediction::memory(&self.0, scene), remedy: "lower --size or --bases" }
    }

    fn reads(&self, scene: &Scene) -> u128 {
        reads(scene)
    }

    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<Option<Product>> {
        let (settings, job) = (self.0, work.job);
        let paintings = paintings(scene, job)?;
        let preparing = job.step("preparing");
        let world = World::painted(scene, &paintings);
        let lights = Lights::new(scene, &world);
        drop(preparing);
        let gather = guided::gather(scene, &world, &lights, &settings.paths(scene.reflections), job)?;
        let making_basis = job.step("basis");
        let basis = transfer_images::space_for(scene, settings.bases)?.basis(settings.bases);
        drop(making_basis);
        let baking = Baking { scene, paintings: &paintings, gather: &gather, basis: &basis, settings };
        let Some(baked) = baking.bake(job, |stage| work.run(stage))? else { return Ok(None) };
        let Baked { images, noise, weights, errors } = &baked;
        let files = vec![
            (BrdfBasis::KIND.name().to_owned(), work.write(&basis, "brdf-basis.relume")?),
            (NAME.to_owned(), work.write(images, "region-images.relume")?),
        ];
        let mut recorded = self.asked_for();
        let components: usize = weights.groups.iter().map(super::weights::Group::rank).sum();
        recorded.insert("components".to_owned(), components.into());
        let of_noise = noise.iter().flat_map(|Noise { before, after }| {
            [("relative_l2_of_noise", *after), ("relative_l2_of_noise_unfiltered", *before)]
        });
        let errors = Errors::named(&errors.all, "")
            .into_iter()
            .chain(Errors::named(&errors.of_compression, "_of_compression"))
            .chain(of_noise.map(|(name, error)| (name.to_owned(), error)))
            .collect();
        debug_assert!(scene.reflections <= 2 || scene.reflections == ALL_REFLECTIONS);
        Ok(Some(Product { files, settings: recorded, errors, measured_on: measured_on() }))
    }
}
