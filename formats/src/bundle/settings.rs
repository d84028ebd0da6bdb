//! The settings that a manifest lists, against what the files themselves say.

use super::{Objects, refuse};
use crate::error::{Place, Result};
use crate::kinds::manifest::{Manifest, MethodEntry};
use crate::kinds::{SphereSet, scene, sparse_transfer, transfer_images, transfer_tensor};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The settings of a method and of the sphere sets of its bundle.
#[derive(Debug, Clone)]
pub struct Settings {
    place: Place,
    method: BTreeMap<String, Value>,
    sphere_sets: BTreeMap<String, BTreeMap<String, Value>>,
}

impl Settings {
    /// Those of `method` in the `manifest` at `place`.
    pub fn of(method: &MethodEntry, manifest: &Manifest, place: &Place) -> Self {
        let sphere_sets =
            manifest.sphere_sets.iter().map(|(object, set)| (object.clone(), set.settings.clone())).collect();
        Self {
            place: place.part(format!("method `{}`", method.name)),
            method: method.settings.clone(),
            sphere_sets,
        }
    }

    /// Fails unless the settings of the method are as a file of it says, by their names.
    ///
    /// # Errors
    /// `Invalid` with the first that differs; what is not listed does not.
    pub fn expect(&self, there: &[(&str, Value)]) -> Result<()> {
        expect(&self.method, there, &self.place)
    }

    /// Fails unless the images of `meta` are those of the settings.
    ///
    /// # Errors
    /// As [`Settings::expect`].
    pub fn expect_images(&self, meta: &transfer_images::Meta) -> Result<()> {
        let [size, samples, seed, bases] =
            [json!(meta.size), json!(meta.samples), json!(meta.seed), json!(meta.bases)];
        self.expect(&[("size", size), ("samples", samples), ("seed", seed), ("bases", bases)])
    }

    /// Fails unless the rows of `meta` are those of the settings.
    ///
    /// # Errors
    /// As [`Settings::expect`].
    pub fn expect_rows(&self, meta: &sparse_transfer::Meta) -> Result<()> {
        self.expect(&[("terms", json!(meta.terms())), ("rays_per_texel", json!(meta.rays_per_texel))])
    }

    /// Fails unless the tensors of `meta` are those of the settings.
    ///
    /// # Errors
    /// As [`Settings::expect`].
    pub fn expect_tensors(&self, meta: &transfer_tensor::Meta) -> Result<()> {
        self.expect(&[("terms", json!(meta.terms())), ("rays_per_texel", json!(meta.rays_per_texel))])
    }

    /// Fails unless the objects of `scene` are those of the settings, and those with spheres have a set in
    /// `objects`.
    ///
    /// # Errors
    /// As [`Settings::expect`].
    pub fn expect_objects(&self, scene: &scene::Meta, objects: &Objects) -> Result<()> {
        let Some(listed) = self.method.get("objects").and_then(Value::as_array) else { return Ok(()) };
        let listed =
            listed.iter().map(|object| (object[0].as_str().unwrap_or_default(), !object[1].is_null()));
        if listed.eq(scene.objects.iter().map(|object| (object.name.as_str(), objects.has_set(&object.name))))
        {
            return Ok(());
        }
        refuse(
            &self.place,
            "setting `objects` does not list the objects of the scene, with spheres where there are some",
        )
    }

    /// Fails unless the spheres of `object` are those that its settings ask for, or fewer.
    ///
    /// # Errors
    /// As [`Settings::expect`].
    pub fn expect_set(&self, set: &SphereSet, object: &str) -> Result<()> {
        let Some(listed) = self.sphere_sets.get(object) else { return Ok(()) };
        let place = Place::file(&self.place.file).part(format!("spheres of `{object}`"));
        expect(
            listed,
            &[("seed", json!(set.meta.seed)), ("iterations", json!(set.meta.iterations))],
            &place,
        )?;
        let count = set.spheres.len() as u64;
        match listed.get("spheres").and_then(Value::as_u64) {
            Some(most) if most < count => {
                refuse(&place, format!("setting `spheres` is {most}, the file has {count}"))
            }
            _ => Ok(()),
        }
    }
}

fn expect(listed: &BTreeMap<String, Value>, there: &[(&str, Value)], place: &Place) -> Result<()> {
    match there
        .iter()
        .find_map(|(name, value)| Some((name, value, listed.get(*name).filter(|listed| *listed != value)?)))
    {
        None => Ok(()),
        Some((name, value, listed)) => {
            refuse(place, format!("setting `{name}` is {listed}, the file has {value}"))
        }
    }
}
