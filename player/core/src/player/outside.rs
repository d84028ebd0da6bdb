//! Environment maps from outside the bundle: those that the player is started with, those that a state or an
//! animation names, and those that come later.

use super::Player;
use crate::controls::{PlacedAnimation, Scope};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::Playback;
use relume_formats::kinds::Environment;
use relume_formats::near::did_you_mean;
use relume_formats::state::{State, TrackValues};
use relume_formats::{Error as FormatError, Place, has_extension};

/// Finds the map that a state or animation at a place names and the bundle does not have; `None` if there is
/// none. What it is called from then on is for the one who finds it to say.
pub type FindMap = fn(&str, &Place) -> relume_formats::Result<Option<Environment>>;

/// Most maps from outside: each takes 16 MiB at most.
const MOST: usize = 32;

/// What the player is told of a map that is not the bundle's own.
pub const NOT_MEASURED: &str = "the environment map is not one of the bundle's own, under which the error was measured that the bundle states";

/// The maps from outside.
#[derive(Debug, Default)]
pub(super) struct Outside {
    /// Finds those that are named.
    find: Option<FindMap>,
    /// The one to shine from the start, until it is there.
    first: Option<Environment>,
    /// Those that are there.
    names: Vec<String>,
    /// Whether the last frame shows one of them.
    shown: bool,
}

/// Where maps are added.
pub(super) struct Stage<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) playback: &'a mut dyn Playback,
    pub(super) scope: &'a mut Scope,
}

impl Outside {
    pub(super) fn new(find: Option<FindMap>, first: Option<Environment>) -> Self {
        Self { find, first, ..Self::default() }
    }

    /// Adds what is asked for from the start, and lets `state`, which comes from `place`, and `animation`
    /// call it by its name.
    ///
    /// # Errors
    /// If there is no such map, or the light does not vary.
    pub(super) fn adopt(
        &mut self,
        stage: &mut Stage<'_>,
        (state, place): (&mut State, &Place),
        animation: &mut Option<PlacedAnimation>,
    ) -> Result<()> {
        if let Some(map) = self.first.take() {
            self.add(stage, &map)?;
            state.environment.get_or_insert_default().map = Some(map.name);
        }
        if !stage.scope.varies().environment {
            // To be refused as anything else that does not vary.
            return Ok(());
        }
        if let Some(name) = state.environment.as_mut().and_then(|change| change.map.as_mut()) {
            self.find(stage, name, place)?;
        }
        let Some(PlacedAnimation { animation, place }) = animation else { return Ok(()) };
        for track in animation.tracks.iter_mut().filter(|track| track.leaf == ["environment", "map"]) {
            if let TrackValues::Name(names) = &mut track.values {
                names.iter_mut().try_for_each(|name| self.find(stage, name, place))?;
            }
        }
        Ok(())
    }

    /// Finds the map `name` unless the bundle has it, and calls it by its name.
    fn find(&mut self, stage: &mut Stage<'_>, name: &mut String, place: &Place) -> Result<()> {
        let Some(find) = self.find.filter(|_| !stage.scope.maps.contains(name)) else { return Ok(()) };
        if let Some(map) = find(name, place)? {
            self.add(stage, &map)?;
            *name = map.name;
        } else if ["hdr", "exr"].iter().any(|extension| has_extension(name.as_ref(), extension)) {
            let (maps, meant) = (
                stage.scope.maps.join(", "),
                did_you_mean(name, stage.scope.maps.iter().map(String::as_str)),
            );
            let reason = format!(
                "environment: no map `{name}`, nor a file of that name beside this one; this bundle has: {maps}{meant}"
            );
            return Err(FormatError::invalid(place, reason).into());
        }
        Ok(())
    }

    /// Adds `map`, or puts it in the place of the one from outside that has its name.
    fn add(&mut self, stage: &mut Stage<'_>, map: &Environment) -> Result<()> {
        if !stage.scope.varies().environment {
            let reason = "this bundle does not vary the light, so no map can be added; leave it out, or add light = true to [vary] in scene.toml and bake again";
            return Err(Error::Request(reason.to_owned()));
        }
        if !self.names.contains(&map.name) {
            if stage.scope.maps.contains(&map.name) {
                return Err(Error::Request(format!(
                    "the bundle has a map called `{}` itself; rename the file",
                    map.name
                )));
            }
            if self.names.len() >= MOST {
                return Err(Error::Request(format!(
                    "{MOST} maps were added, and no more can be; start the player again"
                )));
            }
            self.names.push(map.name.clone());
            stage.scope.maps.push(map.name.clone());
        }
        stage.playback.add_map(stage.gpu, map);
        Ok(())
    }

    /// Notes which map a frame shows.
    pub(super) fn drawn(&mut self, map: Option<&String>) {
        self.shown = map.is_some_and(|map| self.names.contains(map));
    }
}

impl Player {
    /// Adds an environment map that is not the bundle's, for [`Controls`](crate::Controls) and looks to name;
    /// in place of one that was added under the same name.
    ///
    /// # Errors
    /// If the light does not vary, the bundle has a map of that name itself, or nothing has arrived yet.
    pub fn add_environment(&mut self, map: &Environment) -> Result<()> {
        let (Some(playback), Some(controls)) = (self.playback.as_deref_mut(), &mut self.controls) else {
            return Err(Error::NothingThere);
        };
        self.outside.add(&mut Stage { gpu: &self.gpu, playback, scope: controls.scope_mut() }, map)
    }

    /// Whether the last frame shows a map that is not the bundle's own; see [`NOT_MEASURED`].
    pub fn shows_map_from_outside(&self) -> bool {
        self.outside.shown
    }
}
