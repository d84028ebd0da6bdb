//! The method as the bundle sees it: settings, files, entry of the manifest.

use super::bake::{Measured, bake};
use super::fit::{expect_fit, expect_sizes, predicted_bytes};
use super::settings::{NAME, REVISION, Settings};
use super::{errors, prediction, ranks};
use crate::error::Result;
use crate::job::Job;
use crate::memory::MemoryNeed;
use crate::method::{Method, Predicted, Product};
use crate::methods::environment_lit;
use crate::methods::registered::unpainted;
use crate::methods::sparse_transfer::Terms;
use crate::scene_hash::{Part, hash_of};
use crate::unfinished::Work;
use relume_formats::container::Stored;
use relume_formats::kinds::{BrdfBasis, BrdfTensor};
use relume_formats::method::Card;
use relume_scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The setting that says how many terms a vertex has.
const TERMS: &str = "terms";

/// What to bake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferTensorMethod {
    /// How exact.
    pub settings: Settings,
}

impl Method for TransferTensorMethod {
    fn card(&self) -> &'static Card {
        &relume_formats::method::TRANSFER_TENSOR
    }

    fn expect_fit(&self, scene: &Scene) -> Result<()> {
        expect_fit(scene)?;
        expect_sizes(scene)
    }

    fn leaves_out(&self, scene: &Scene) -> Vec<String> {
        environment_lit::shine_left_out(scene, NAME).into_iter().chain(unpainted(scene, NAME)).collect()
    }

    fn asked_for(&self) -> BTreeMap<String, Value> {
        let Settings { rays_per_texel, samples, seed, terms } = self.settings;
        let mut asked = BTreeMap::from([
            ("revision".to_owned(), json!(REVISION)),
            ("rays_per_texel".to_owned(), json!(rays_per_texel)),
            ("samples".to_owned(), json!(samples)),
            ("seed".to_owned(), json!(seed)),
        ]);
        match terms {
            Terms::Number(terms) => asked.insert(TERMS.to_owned(), json!(terms)),
            Terms::Error(max) => asked.insert("max_error".to_owned(), json!(max)),
        };
        asked
    }

    fn chosen(&self) -> &'static [&'static str] {
        &[TERMS]
    }

    fn predict(&self, scene: &Scene, job: &Job) -> Result<Predicted> {
        prediction::predict(&self.settings, scene, job)
    }

    fn memory(&self, scene: &Scene) -> MemoryNeed {
        MemoryNeed { bytes: predicted_bytes(scene), remedy: "lower --threads, or simplify the meshes" }
    }

    fn reads(&self, scene: &Scene) -> u128 {
        hash_of(scene, &[Part::Geometry, Part::Surfaces, Part::Maps, Part::Reflections])
    }

    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<Option<Product>> {
        let Some(baked) = bake(scene, &self.settings, work.job, &|stage| work.run(stage))? else {
            return Ok(None);
        };
        let mut files = environment_lit::files(scene, &baked.environments, work)?;
        for (number, space) in baked.spaces.iter().enumerate() {
            let name = format!("brdf-tensor-{number}.relume");
            files.push((BrdfTensor::KIND.name().to_owned(), work.write(space, &name)?));
        }
        for (number, basis) in baked.bases.iter().enumerate() {
            let name = format!("brdf-functions-{number}.relume");
            files.push((BrdfBasis::KIND.name().to_owned(), work.write(basis, &name)?));
        }
        files.push((NAME.to_owned(), work.write(&baked.transfer, "transfer-tensor.relume")?));
        let mut recorded = self.asked_for();
        recorded.insert(TERMS.to_owned(), baked.transfer.meta.terms().into());
        let Measured { direct, reflected } = &baked.errors;
        let all: [(&str, &[f64]); 3] = [
            ("", &ranks::together(direct, reflected)),
            ("_of_direct_light", direct),
            ("_of_reflected_light", reflected),
        ];
        let errors = environment_lit::figures(&all[..if scene.reflections > 1 { 3 } else { 1 }]);
        Ok(Some(Product { files, settings: recorded, errors, measured_on: errors::measured_on() }))
    }
}
