//! The method as the bundle sees it: settings, files, entry of the manifest.

use super::casters::{self, By};
use super::errors::{Measuring, predicted_bytes};
use super::fit::{expect_fit, leaves_out};
use super::settings::{NAME, REVISION};
use super::{prediction, rows};
use crate::error::Result;
use crate::job::{Job, detail};
use crate::memory::MemoryNeed;
use crate::method::{Method, Predicted, Product};
use crate::methods::environment_lit;
use crate::scene_hash::{Part, hash_of};
use crate::unfinished::Work;
use relume_formats::container::Kind;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::manifest::shape_file;
use relume_formats::method::Card;
use relume_scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// What to bake. The hash of a scene has neither names nor numbers of spheres, which this method's files and
/// errors depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct SphereShadowsMethod {
    /// Names of the objects, with the number of spheres of those that have some.
    objects: Vec<(String, Option<u32>)>,
    /// Of the spheres.
    seed: u64,
    casters: Asked,
}

/// What objects are to cast shadows by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// Whatever is the cheapest with so much relative L2 error in all, that of light and lobes included.
    Error(f64),
    /// Those that have spheres by them, the others by about as many triangles as takes nothing from them.
    Spheres,
    /// By about so many triangles each, if it has so many.
    Triangles(usize),
}

impl SphereShadowsMethod {
    /// For `scene`, whose spheres are fitted with `seed`.
    pub fn new(scene: &Scene, seed: u64, casters: Asked) -> Self {
        let objects = scene.objects.iter().map(|object| (object.name.clone(), object.spheres)).collect();
        Self { objects, seed, casters }
    }
}

impl Method for SphereShadowsMethod {
    fn card(&self) -> &'static Card {
        &relume_formats::method::SPHERE_SHADOWS
    }

    fn expect_fit(&self, scene: &Scene) -> Result<()> {
        expect_fit(scene)
    }

    fn leaves_out(&self, scene: &Scene) -> Vec<String> {
        leaves_out(scene)
    }

    fn asked_for(&self) -> BTreeMap<String, Value> {
        let Self { objects, seed, casters } = self;
        let (name, value) = match casters {
            Asked::Error(max) => ("max_error", json!(max)),
            Asked::Spheres => ("casters", json!("spheres")),
            Asked::Triangles(count) => ("casters", json!(format!("{count} triangles"))),
        };
        BTreeMap::from(
            [
                ("revision", json!(REVISION)),
                ("objects", json!(objects)),
                ("seed", json!(seed)),
                (name, value),
            ]
            .map(|(k, v)| (k.to_owned(), v)),
        )
    }

    fn chosen(&self) -> &'static [&'static str] {
        &["casts"]
    }

    fn predict(&self, scene: &Scene, job: &Job) -> Result<Predicted> {
        prediction::predict(scene, self.casters, job)
    }

    fn memory(&self, scene: &Scene) -> MemoryNeed {
        MemoryNeed { bytes: predicted_bytes(scene), remedy: "simplify the meshes" }
    }

    fn reads(&self, scene: &Scene) -> u128 {
        hash_of(scene, &[Part::Geometry, Part::Shapes, Part::Textures, Part::Maps])
    }

    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<Option<Product>> {
        let preparing = work.job.step("preparing");
        let environments = environment_lit::environments(scene);
        let mut shadows = rows::bake(scene);
        let measuring = Measuring::new(scene, &environments)?;
        drop(preparing);
        let Some(truth) = measuring.traced(scene, work.job, &|stage| work.run(stage))? else {
            return Ok(None);
        };
        let Some(sets) = work.sphere_sets()? else { return Ok(None) };
        let choices = casters::choose(scene, &shadows, &environments, Some(&sets), self.casters, work.job)?;
        casters::sentences(scene, &choices).iter().for_each(|sentence| detail(sentence));
        let by: Vec<By> = choices.into_iter().map(|choice| choice.by).collect();
        casters::put(&mut shadows, &by);
        let with_spheres = scene.objects.iter().zip(&by).filter(|(object, _)| object.spheres.is_some());
        let sets: Vec<SphereSet> = with_spheres
            .zip(sets)
            .filter(|((_, by), _)| matches!(by, By::Spheres(_)))
            .map(|(_, set)| set)
            .collect();
        let measured = measuring.errors(&shadows, &sets, &truth, work.job)?;
        let mut files = environment_lit::files(scene, &environments, work)?;
        for (object, shape) in
            scene.objects.iter().filter_map(|object| Some((object, object.shape.as_deref()?)))
        {
            files.push((Kind::Shape.name().to_owned(), work.write(shape, &shape_file(&object.name))?));
        }
        files.push((NAME.to_owned(), work.write(&shadows, "sphere-shadows.relume")?));
        let errors = environment_lit::figures(&[("", &measured.shown), ("_all_terms", &measured.all_terms)]);
        let mut settings = self.asked_for();
        let casts = scene.objects.iter().zip(&by).map(|(object, by)| json!([object.name, by.words()]));
        settings.insert("casts".to_owned(), casts.collect());
        Ok(Some(Product { files, settings, errors, measured_on: measured.on }))
    }
}
