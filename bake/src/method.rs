//! What the bundle needs to know of any method.

use crate::error::Result;
use crate::job::Job;
use crate::memory::MemoryNeed;
use crate::unfinished::Work;
use relume_formats::kinds::manifest::FileEntry;
use relume_formats::method::Card;
use relume_scenes::Scene;
use serde_json::Value;
use std::collections::BTreeMap;

/// A method with the settings that it is to bake with.
pub trait Method {
    /// What there is to say of it.
    fn card(&self) -> &'static Card;

    /// Its name in manifests and on the command line.
    fn name(&self) -> &'static str {
        self.card().name
    }

    /// Fails, naming what stands in the way, unless the method can show the scene at all and a file can hold
    /// it.
    ///
    /// # Errors
    /// `Invalid` with the remedy.
    fn expect_fit(&self, scene: &Scene) -> Result<()>;

    /// What varies or is there in the scene and is left out by the method, a sentence each.
    fn leaves_out(&self, scene: &Scene) -> Vec<String>;

    /// The settings that the user gave or left to default, for the manifest.
    fn asked_for(&self) -> BTreeMap<String, Value>;

    /// The settings that a bake chooses by itself if they are not asked for, the main one first.
    fn chosen(&self) -> &'static [&'static str];

    /// What baking a scene that fits will take, found by doing a small part of it here and now.
    ///
    /// # Errors
    /// If LAPACK fails or the job is interrupted.
    fn predict(&self, scene: &Scene, job: &Job) -> Result<Predicted>;

    /// Memory that a bake holds at most, as far as is known before anything is traced.
    fn memory(&self, scene: &Scene) -> MemoryNeed;

    /// A hash of everything of the scene that the files and errors of a bake depend on, and of nothing else:
    /// while it and the settings stay, a bake serves.
    fn reads(&self, scene: &Scene) -> u128;

    /// Bakes the scene and writes the method's files; `None` if pieces are missing that others make.
    ///
    /// # Errors
    /// See [`crate::error::BakeError`]; finished work stays in the logs.
    fn bake(&self, scene: &Scene, work: &Work<'_>) -> Result<Option<Product>>;
}

/// What a bake has made.
#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    /// Its files in the order in which a player wants them, each with its kind.
    pub files: Vec<(String, FileEntry)>,
    /// The settings that change results, with those that the bake chose.
    pub settings: BTreeMap<String, Value>,
    /// Measured errors, by what was measured.
    pub errors: BTreeMap<String, f64>,
    /// On which states, where, and against what they were measured.
    pub measured_on: String,
}

/// What a bake will take, and leave.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Rays traced, shadow rays included.
    pub rays: f64,
    /// Wall-clock seconds of all stages of the method on as many threads as rayon has, if the machine goes on
    /// as it does now.
    pub seconds: f64,
    /// Of the method's own files, on disk.
    pub bytes: f64,
    /// Of memory, at most.
    pub memory: u64,
    /// What the bake will choose by itself for the first of [`Method::chosen`].
    pub chosen: Option<usize>,
    /// What else it will choose, and why, a sentence each.
    pub tells: Vec<String>,
}
