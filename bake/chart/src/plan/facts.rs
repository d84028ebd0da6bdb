//! What a plan says.

use super::charted::BestPoint;
use super::stored::StoredFigures;
use relume_bake::bundle::Shared;
use relume_bake::method::Predicted;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// A plan.
#[derive(Debug, Serialize)]
pub(super) struct Plan {
    pub scene: String,
    pub varies: Varies,
    /// Every method, the one whose frames cost least first; none if nothing varies.
    pub methods: Vec<Candidate>,
    /// The method that `bake run` takes, if it fits.
    pub chosen: Option<&'static str>,
    /// Why that one, or why none.
    pub why: String,
    /// A sentence each.
    pub not_modelled: Vec<String>,
    /// What is wrong with the figures of an earlier bake, if there is one.
    pub stored_unusable: Option<String>,
}

/// What varies at playback.
#[derive(Debug, Serialize)]
pub(super) struct Varies {
    pub light: bool,
    pub view: bool,
    pub shape: bool,
    pub materials: Vec<String>,
}

/// A method in the light of the scene.
#[derive(Debug, Serialize)]
pub(super) struct Candidate {
    pub name: &'static str,
    /// Why it does not fit, with the remedy; `None` if it does.
    pub misfit: Option<String>,
    pub serves_all: bool,
    pub leaves_out: Vec<String>,
    /// Those of `bake run` with the same options.
    pub settings: BTreeMap<String, Value>,
    pub predicted: Option<Prediction>,
    pub stored: Option<StoredFigures>,
    pub charted: Option<BestPoint>,
}

/// What a bake by this method alone will take and leave, sphere sets and all that methods share included.
#[derive(Debug, Serialize)]
pub(super) struct Prediction {
    pub rays: u64,
    pub seconds: f64,
    pub bytes_on_disk: u64,
    pub bytes_of_memory: u64,
    /// The setting that the bake will choose by the wanted error, and its value.
    pub chooses: Option<(&'static str, usize)>,
    /// What else it will choose, and why, a sentence each.
    pub tells: Vec<String>,
}

impl Prediction {
    /// Of a method that takes its `own` besides what it has in common with others.
    pub fn new(own: &Predicted, shared: &Shared, chosen: Option<&'static str>) -> Self {
        Self {
            rays: own.rays.round() as u64,
            seconds: own.seconds + shared.seconds,
            bytes_on_disk: (own.bytes + shared.bytes).round() as u64,
            bytes_of_memory: own.memory,
            chooses: chosen.zip(own.chosen),
            tells: own.tells.clone(),
        }
    }
}
