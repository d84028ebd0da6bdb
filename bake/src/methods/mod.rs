//! The methods, one folder each: gather, project, compress; and what the bundle needs to know of any of them.

pub(crate) mod environment_lit;
pub mod sparse_transfer;
pub mod sphere_shadows;
pub mod transfer_images;

use crate::bundle::Work;
use crate::error::Result;
use relume_formats::kinds::manifest::MethodEntry;
use relume_scenes::Scene;
use serde_json::Value;
use std::collections::BTreeMap;

/// A method with the settings that it is to bake with.
pub trait Method {
    /// Its name in manifests and on the command line.
    fn name(&self) -> &'static str;

    /// Fails, naming what stands in the way, unless the method can show the scene at all and a file can hold it.
    ///
    /// # Errors
    /// `Invalid` with the remedy.
    fn expect_fit(&self, scene: &Scene) -> Result<()>;

    /// What varies or is there in the scene and is left out by the method, a sentence each.
    fn leaves_out(&self, scene: &Scene) -> Vec<String>;

    /// The settings that the user gave or left to default, for the manifest.
    fn asked_for(&self) -> BTreeMap<String, Value>;

    /// The setting that a bake chooses by itself if it is not asked for, if there is one.
    fn chosen(&self) -> Option<&'static str>;

    /// Bakes the scene and writes the method's files.
    ///
    /// # Errors
    /// See [`crate::error::BakeError`]; finished work stays in the log.
    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<(MethodEntry, Traced)>;
}

/// What tracing took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traced {
    /// Rays traced, shadow rays included; those of resumed pieces are not counted.
    pub rays: u64,
    /// Wall-clock seconds.
    pub seconds: f64,
}
