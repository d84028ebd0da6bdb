//! Kind `animation`, version 0: one [`Animation`], as a single record section `animation`.

use super::names::fault_of_name;
use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::Result;
use crate::state::{Animation, Track, TrackValues};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct Record {
    name: String,
    duration_s: f32,
    looping: bool,
    tracks: Vec<Track>,
}

impl Stored for Animation {
    const KIND: Kind = Kind::Animation;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let Self { name, duration_s, looping, tracks } = self.clone();
        out.record("animation", &Record { name, duration_s, looping, tracks })
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("animation")?;
        let Record { name, duration_s, looping, tracks } = section.record()?;
        let animation = Self { name, duration_s, looping, tracks };
        section.expect_valid(|place| animation.validate(place))?;
        section.expect(fault_of_names(&animation))?;
        Ok(animation)
    }
}

/// Names of things that are set, and names that they are set to.
fn fault_of_names(animation: &Animation) -> Option<String> {
    let of_track = |track: &Track| {
        let values: &[String] = if let TrackValues::Name(names) = &track.values { names } else { &[] };
        track.leaf.iter().chain(values).find_map(|name| fault_of_name("what a track sets", name))
    };
    fault_of_name("the animation", &animation.name).or_else(|| animation.tracks.iter().find_map(of_track))
}
