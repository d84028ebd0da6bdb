//! The methods, one folder each: gather, project, compress; and what the bundle needs to know of any of them.

pub mod choice;
mod coarse;
pub(crate) mod environment_lit;
pub mod sparse_transfer;
pub mod sphere_shadows;
pub mod transfer_images;

use crate::bundle::Work;
use crate::error::Result;
use crate::job::Job;
use crate::memory::MemoryNeed;
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

    /// What baking a scene that fits will take, found by doing a small part of it here and now.
    ///
    /// # Errors
    /// If LAPACK fails or the job is interrupted.
    fn predict(&self, scene: &Scene, job: &Job) -> Result<Predicted>;

    /// Memory that a bake holds at most, as far as is known before anything is traced.
    fn memory(&self, scene: &Scene) -> MemoryNeed;

    /// A hash of everything of the scene that the files and errors of a bake depend on, and of nothing else: while it and the settings stay, a bake serves.
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Rays traced, shadow rays included.
    pub rays: f64,
    /// Wall-clock seconds of all stages of the method on as many threads as rayon has, if the machine goes on as it does now.
    pub seconds: f64,
    /// Of the method's own files, on disk.
    pub bytes: f64,
    /// Of memory, at most.
    pub memory: u64,
    /// What the bake will choose by itself for [`Method::chosen`].
    pub chosen: Option<usize>,
}

/// What to tell a user whose bake with `settings` is not exact enough: to ask for the `next` number of what `setting` counts, `most` at most.
fn more_of(settings: &BTreeMap<String, Value>, setting: &str, next: impl Fn(u64) -> u64, most: u64) -> String {
    match settings.get(setting).and_then(Value::as_u64) {
        Some(n) if n < most => format!("add --{setting} {}", next(n).min(most)),
        _ => "no more of them does better".to_owned(),
    }
}

/// `count` of the numbers below `all`, or all of these, spread by the golden section: evenly, but in step with nothing.
fn spread(count: usize, all: usize) -> Vec<usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    if count >= all {
        return (0..all).collect();
    }
    let mut some: Vec<usize> = (0..count).map(|k| ((k as f64 * GOLDEN).fract() * all as f64) as usize).collect();
    some.sort_unstable();
    some.dedup();
    some
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_spread_evenly_and_none_is_there_twice() {
        for (count, all) in [(0, 0), (3, 2), (7, 7), (10, 1000), (96, 100), (256, 65_536)] {
            let some = spread(count, all);
            assert!(some.is_sorted_by(|a, b| a < b) && some.iter().all(|i| *i < all), "{count} of {all}");
            assert!(some.len() >= count.min(all) * 4 / 5, "{count} of {all}: {}", some.len());
            // Gaps between the first n multiples of the golden section, modulo 1, are at most its square times the largest of the step before: below 2.7/n.
            let gaps = some.windows(2).map(|w| w[1] - w[0]);
            assert!(gaps.max().unwrap_or(0) as f64 <= 2.7 * all as f64 / count.max(1) as f64 + 1.0, "{count} of {all}");
        }
    }
}
