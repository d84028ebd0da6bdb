//! Which moment of which clip a shape shows.

use super::ShapeState;
use crate::error::{Error, Place, Result};
use crate::near::did_you_mean;
use serde::{Deserialize, Serialize};

/// A moment of a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Posed {
    /// Name of the clip.
    pub clip: String,
    /// Seconds; clips repeat, so the time counts modulo the clip's duration.
    pub time_s: f32,
}

/// Whether a shape shows a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pose {
    /// It does not: it is as its file has it.
    Rest,
    /// It does.
    Clip,
}

impl ShapeState {
    /// What the shape called `shape`, which shows `now` and has clips called `clips`, shows with the leaves
    /// replaced that this change names; `None` at rest. A shape that rested begins at 0 s, and with its only
    /// clip if there is but one. [`Pose::Rest`] wins over a clip and a time.
    ///
    /// # Errors
    /// `Invalid` for a clip that the shape does not have, a time without a clip to choose, and a time that is
    /// no number.
    pub fn posed(
        &self,
        shape: &str,
        now: Option<&Posed>,
        clips: &[&str],
        place: &Place,
    ) -> Result<Option<Posed>> {
        let place = place.part(format!("shape `{shape}`"));
        if let Some(clip) = self.clip.as_ref().filter(|clip| !clips.contains(&clip.as_str())) {
            let reason = format!(
                "no clip `{clip}`; it has {}{}",
                list(clips),
                did_you_mean(clip, clips.iter().copied())
            );
            return Err(Error::invalid(&place, reason));
        }
        if self.time_s.is_some_and(|time_s| !time_s.is_finite()) {
            return Err(Error::invalid(&place, "time_s must be a finite number"));
        }
        if self.pose == Some(Pose::Rest) {
            return Ok(None);
        }
        if *self == Self::default() {
            return Ok(now.cloned());
        }
        let clip = match (&self.clip, now, clips) {
            (Some(clip), ..) => clip.clone(),
            (None, Some(now), _) => now.clip.clone(),
            (None, None, [only]) => (*only).to_owned(),
            (None, None, _) => {
                let key = if self.time_s.is_some() { "time_s" } else { "pose" };
                return Err(Error::invalid(
                    &place,
                    format!("{key} needs a clip; add `clip`, one of {}", list(clips)),
                ));
            }
        };
        let time_s = self.time_s.or(now.map(|now| now.time_s)).unwrap_or(0.0);
        Ok(Some(Posed { clip, time_s }))
    }

    /// What undoes this change of a shape that shows `now` and, with the change, `after`.
    pub fn inverse(&self, now: Option<&Posed>, after: Option<&Posed>) -> Self {
        let Posed { clip, time_s } = match now {
            Some(now) => now.clone(),
            None if *self == Self::default() => return Self::default(),
            None => return Self { pose: Some(Pose::Rest), ..Self::default() },
        };
        let all = after.is_none();
        let clip = Some(clip).filter(|_| all || self.clip.is_some());
        let time_s = Some(time_s).filter(|_| all || self.time_s.is_some());
        Self { clip, time_s, pose: None }
    }
}

fn list(clips: &[&str]) -> String {
    if clips.is_empty() {
        "none".to_owned()
    } else {
        clips.iter().map(|clip| format!("`{clip}`")).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn posed(
        change: &str,
        now: Option<&Posed>,
        clips: &[&str],
    ) -> std::result::Result<Option<(String, f32)>, String> {
        let place = Place::file("s.toml");
        let change: ShapeState = crate::state::parse_toml(change, &place).unwrap();
        let posed = change.posed("fox", now, clips, &place).map_err(|e| e.to_string())?;
        Ok(posed.map(|posed| (posed.clip, posed.time_s)))
    }

    #[test]
    fn leaves_replace_what_there_is() {
        let now = Posed { clip: "Run".to_owned(), time_s: 0.75 };
        let both = ["Run", "Walk"];
        let shows = |clip: &str, time_s| Ok(Some((clip.to_owned(), time_s)));
        assert_eq!(posed("", None, &both), Ok(None), "at rest");
        assert_eq!(posed("", Some(&now), &both), shows("Run", 0.75));
        assert_eq!(posed("clip = \"Walk\"", None, &both), shows("Walk", 0.0));
        assert_eq!(posed("clip = \"Walk\"", Some(&now), &both), shows("Walk", 0.75));
        assert_eq!(posed("clip = \"Walk\"\ntime_s = -9.5", Some(&now), &both), shows("Walk", -9.5));
        assert_eq!(posed("time_s = 2", Some(&now), &both), shows("Run", 2.0));
        assert_eq!(posed("time_s = 2", None, &["Twist"]), shows("Twist", 2.0));
        assert_eq!(posed("pose = \"clip\"", None, &["Twist"]), shows("Twist", 0.0));
        assert_eq!(posed("pose = \"clip\"", Some(&now), &both), shows("Run", 0.75));
        for at_rest in ["", "clip = \"Walk\"", "time_s = 2"] {
            assert_eq!(
                posed(&format!("pose = \"rest\"\n{at_rest}"), Some(&now), &both),
                Ok(None),
                "{at_rest}"
            );
        }
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        for (change, clips, message) in [
            (
                "clip = \"Fly\"",
                &["Run", "Walk"][..],
                "s.toml: shape `fox`: no clip `Fly`; it has `Run`, `Walk`",
            ),
            (
                "time_s = 1",
                &["Run", "Walk"],
                "s.toml: shape `fox`: time_s needs a clip; add `clip`, one of `Run`, `Walk`",
            ),
            (
                "pose = \"clip\"",
                &["Run", "Walk"],
                "s.toml: shape `fox`: pose needs a clip; add `clip`, one of `Run`, `Walk`",
            ),
            ("pose = \"rest\"\nclip = \"Fly\"", &["Run"], "s.toml: shape `fox`: no clip `Fly`; it has `Run`"),
            (
                "pose = \"rest\"\ntime_s = inf",
                &["Run"],
                "s.toml: shape `fox`: time_s must be a finite number",
            ),
            ("clip = \"Run\"\ntime_s = nan", &["Run"], "s.toml: shape `fox`: time_s must be a finite number"),
        ] {
            assert_eq!(posed(change, None, clips), Err(message.to_owned()));
        }
    }
}
