//! The method as the bundle sees it: settings, files, entry of the manifest.

use super::bake::bake;
use super::fit::{expect_fit, expect_sizes, predicted_bytes};
use super::settings::{NAME, REVISION, Settings, Terms, bounces};
use super::{errors, prediction};
use crate::error::Result;
use crate::job::Job;
use crate::memory::MemoryNeed;
use crate::method::{Method, Predicted, Product};
use crate::methods::environment_lit;
use crate::scene_hash::{Part, hash_of};
use crate::unfinished::Work;
use relume_formats::method::Card;
use relume_scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The setting that says how many terms a row has.
const TERMS: &str = "terms";

/// What to bake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparseTransferMethod {
    /// How exact.
    pub settings: Settings,
}

impl Method for SparseTransferMethod {
    fn card(&self) -> &'static Card {
        &relume_formats::method::SPARSE_TRANSFER
    }

    fn expect_fit(&self, scene: &Scene) -> Result<()> {
        expect_fit(scene)?;
        expect_sizes(scene)
    }

    fn leaves_out(&self, scene: &Scene) -> Vec<String> {
        environment_lit::leaves_out(scene, NAME)
    }

    fn asked_for(&self) -> BTreeMap<String, Value> {
        let Settings { rays_per_texel, terms } = self.settings;
        let mut asked = BTreeMap::from([
            ("revision".to_owned(), json!(REVISION)),
            ("rays_per_texel".to_owned(), json!(rays_per_texel)),
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
        MemoryNeed { bytes: predicted_bytes(scene), remedy: "simplify the meshes" }
    }

    fn reads(&self, scene: &Scene) -> u128 {
        let parts = [Part::Geometry, Part::Textures, Part::Maps, Part::Reflections];
        // Light that bounces takes the colours of the surfaces with it.
        let albedos = (bounces(scene) > 0).then_some(Part::Albedos);
        hash_of(scene, &parts.into_iter().chain(albedos).collect::<Vec<_>>())
    }

    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<Option<Product>> {
        let Some(baked) = bake(scene, &self.settings, work.job, &|stage| work.run(stage))? else {
            return Ok(None);
        };
        let mut files = environment_lit::files(scene, &baked.environments, work)?;
        files.push((NAME.to_owned(), work.write(&baked.transfer, "sparse-transfer.relume")?));
        let mut recorded = self.asked_for();
        recorded.insert(TERMS.to_owned(), baked.transfer.meta.terms().into());
        let [stored, unrounded] = &baked.errors;
        let errors = environment_lit::figures(&[("", stored), ("_before_rounding", unrounded)]);
        let measured_on = errors::measured_on();
        Ok(Some(Product { files, settings: recorded, errors, measured_on }))
    }
}
