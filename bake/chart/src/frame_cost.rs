//! What a frame of a new bundle costs, for its report: a few states of the scene, played by the player that
//! stands beside `bake`.

use crate::play::{Played, Playing};
use crate::states;
use relume_bake::bundle::Summary;
use relume_bake::error::Result;
use relume_bake::report;
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Duration;

/// States that are played.
const STATES: u32 = 6;
/// A player that takes longer for a method is stopped: the bake is done, and its user waits.
const LIMIT: Duration = Duration::from_secs(5);

/// Plays each method of the new bundle in `folder` at `size` and puts what frames cost into its report; why
/// not, where it cannot. Returns a line for each method that was played.
///
/// # Errors
/// If the report cannot be written.
pub fn measure(scene: &Scene, summary: &Summary, size: [u32; 2], folder: &Path) -> Result<String> {
    let (mut frames, mut text) = (Map::new(), String::new());
    for method in &summary.methods {
        let name = &method.entry.name;
        let frame = match play(scene, name, size, folder) {
            Ok(Played { adapter, median_ms, p95_ms, .. }) => {
                text += &format!(
                    "{name}: a frame in {median_ms:.2} ms, 95 % of them in {p95_ms:.2} ms, on {adapter}\n"
                );
                json!({ "adapter": adapter, "median_ms": median_ms, "p95_ms": p95_ms, "states": STATES })
            }
            Err(error) => json!({ "unmeasured": error.to_string() }),
        };
        frames.insert(name.clone(), frame);
    }
    report::merge(folder, Map::from_iter([(report::FRAME.to_owned(), Value::Object(frames))]))?;
    Ok(text)
}

fn play(scene: &Scene, method: &str, size: [u32; 2], folder: &Path) -> Result<Played> {
    let temporary = tempfile::tempdir().map_err(|e| Error::output(&Place::file(std::env::temp_dir()), e))?;
    let animation = temporary.path().join("states.toml");
    let states: Vec<_> = (0..STATES).map(|number| states::random(scene, number)).collect();
    states::write_animation(&states, &animation)?;
    Playing { folder, method, animation: &animation, frames: STATES, size, exr: None }.play_within(LIMIT)
}
