//! The method as the bundle sees it: settings, files, entry of the manifest.

use super::albedo_errors::albedo_errors;
use super::bake::{Baked, bake};
use super::basis::space_for;
use super::fit::{expect_fit, predicted_bytes};
use super::held_out::{CHOICE_PIXELS, HeldOutErrors};
use super::settings::{Bases, NAME, READS, REVISION, Settings, TransferImagesMethod};
use super::{held_out, prediction};
use crate::error::Result;
use crate::filter::Noise;
use crate::guided;
use crate::job::Job;
use crate::memory::MemoryNeed;
use crate::method::{Method, Predicted, Product};
use crate::methods::registered::unpainted;
use crate::scene_hash::hash_of;
use crate::trace::lights::Lights;
use crate::trace::world::World;
use crate::unfinished::Work;
use relume_formats::container::Stored;
use relume_formats::kinds::BrdfBasis;
use relume_formats::method::Card;
use relume_scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The setting that says how many bases there are.
const BASES: &str = "bases";
/// That says how many samples pixels have in the mean.
const MEAN_SAMPLES: &str = "mean_samples";

impl Method for TransferImagesMethod {
    fn card(&self) -> &'static Card {
        &relume_formats::method::TRANSFER_IMAGES
    }

    fn expect_fit(&self, scene: &Scene) -> Result<()> {
        expect_fit(scene)
    }

    fn leaves_out(&self, scene: &Scene) -> Vec<String> {
        let parts = [("light", scene.vary.light), ("view", scene.vary.view)];
        let fixed = parts.into_iter().filter(|(_, varies)| *varies);
        fixed
            .map(|(what, _)| format!("[vary] {what} = true, but {NAME} keeps the {what} as the scene has it"))
            .chain(unpainted(scene, NAME))
            .collect()
    }

    fn asked_for(&self) -> BTreeMap<String, Value> {
        let Self { size, samples, seed, bases, filter, noise } = *self;
        let mut asked = BTreeMap::from([
            ("revision".to_owned(), json!(REVISION)),
            ("size".to_owned(), json!(size)),
            ("samples".to_owned(), json!(samples)),
            ("seed".to_owned(), json!(seed)),
            ("filter".to_owned(), json!(if filter { "on" } else { "off" })),
        ]);
        match bases {
            Bases::Number(bases) => asked.insert(BASES.to_owned(), json!(bases)),
            Bases::Error(max) => asked.insert("max_error".to_owned(), json!(max)),
        };
        asked.extend(noise.map(|noise| ("noise".to_owned(), json!(noise))));
        asked
    }

    fn chosen(&self) -> &'static [&'static str] {
        &[BASES, MEAN_SAMPLES]
    }

    fn predict(&self, scene: &Scene, job: &Job) -> Result<Predicted> {
        prediction::predict(self, scene, job)
    }

    fn memory(&self, scene: &Scene) -> MemoryNeed {
        let Self { size, samples, seed, bases, filter, .. } = *self;
        let bases = match bases {
            Bases::Number(bases) => bases,
            Bases::Error(_) => *held_out::CHOICE.start(),
        };
        need(scene, &Settings { size, samples, seed, bases, filter })
    }

    fn reads(&self, scene: &Scene) -> u128 {
        hash_of(scene, &READS)
    }

    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<Option<Product>> {
        let Self { size, samples, seed, bases, filter, .. } = *self;
        let Work { job, .. } = *work;
        let preparing = job.step("preparing");
        let world = World::new(scene);
        let lights = Lights::new(scene, &world);
        drop(preparing);
        let gather = guided::gather(scene, &world, &lights, &self.paths(scene.reflections), job)?;
        let making_basis = job.step("basis");
        let space = space_for(scene, bases.most())?;
        drop(making_basis);
        let bases = match bases {
            Bases::Number(bases) => bases,
            Bases::Error(max) => {
                let pixels = held_out::some_pixels(CHOICE_PIXELS, size);
                held_out::choose_bases(scene, &gather, space.whole(), samples, max, &pixels, job)?
            }
        };
        let settings = Settings { size, samples, seed, bases, filter };
        job.memory().expect(need(scene, &settings))?;
        let making_basis = job.step("basis");
        let basis = space.basis(bases);
        drop((space, making_basis));
        let Some(baked) = bake(scene, &gather, &settings, &basis, job, |stage| work.run(stage))? else {
            return Ok(None);
        };
        let Baked { images, unfiltered, noise } = &baked;
        let measured = unfiltered.as_ref().unwrap_or(images);
        let errors = held_out::measure(scene, &gather, &settings, &basis, measured, job)?;
        let files = vec![
            (BrdfBasis::KIND.name().to_owned(), work.write(&basis, "brdf-basis.relume")?),
            (NAME.to_owned(), work.write(images, "transfer-images.relume")?),
        ];
        let mut recorded = self.asked_for();
        recorded.insert(BASES.to_owned(), bases.into());
        recorded.extend(gather.counts().map(|counts| (MEAN_SAMPLES.to_owned(), json!(counts.mean()))));
        let (of_nodes, of_albedos) = match &images.head.later {
            Some(later) => {
                let pixels = held_out::one_pixel_in(held_out::SPACING, size);
                (
                    held_out::measure_nodes(scene, &gather, &settings, &basis, measured, job)?,
                    albedo_errors(scene, &gather, (&basis, later), samples, &pixels, job)?,
                )
            }
            None => (None, None),
        };
        let figures = |(ending, errors): (&str, Option<HeldOutErrors>)| {
            let of = |errors: HeldOutErrors| [("median", errors.median), ("worst", errors.worst)];
            let named = |(which, error)| (format!("relative_l2_{which}{ending}"), error);
            errors.into_iter().flat_map(of).map(named).collect::<Vec<_>>()
        };
        let of_noise = noise.iter().flat_map(|Noise { before, after }| {
            [("relative_l2_of_noise", *after), ("relative_l2_of_noise_unfiltered", *before)]
        });
        let errors = [("", errors), ("_of_nodes", of_nodes), ("_of_albedos", of_albedos)]
            .into_iter()
            .flat_map(figures)
            .chain(of_noise.map(|(name, error)| (name.to_owned(), error)))
            .collect();
        let measured_on = held_out::measured_on(images.head.later.is_some());
        Ok(Some(Product { files, settings: recorded, errors, measured_on }))
    }
}

fn need(scene: &Scene, settings: &Settings) -> MemoryNeed {
    MemoryNeed { bytes: predicted_bytes(scene, settings), remedy: "lower --size or --bases" }
}
