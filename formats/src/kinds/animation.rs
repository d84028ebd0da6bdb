//! Kind `animation`, version 0: one [`Animation`], as a single record section `animation`.

use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::Result;
use crate::state::{Animation, Track};
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
        animation.validate(&sections.place)?;
        Ok(animation)
    }
}
