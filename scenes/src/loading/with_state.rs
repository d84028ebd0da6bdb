//! A scene at a state: what the tracer sees when something has changed.

use super::environment::check as check_environment;
use super::environment_map::{read_map, white_map};
use super::index_of;
use super::lights::expect_radiometric;
use crate::library::{expect_file, locate};
use crate::scene::{Emitter, Environment, Scene};
use relume_formats::state::{EnvironmentState, Rgb, State};
use relume_formats::{Error, Place, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Scene {
    /// This scene at `state`, whether or not it varies so at playback. Meshes are shared, not copied. `place` is where the state comes
    /// from; maps that it names are sought beside it, then beside the scene.
    ///
    /// # Errors
    /// `Invalid` for names that the scene lacks and values out of range, `Unsupported` for shapes, `Io` for a map that is not there.
    pub fn with_state(&self, state: &State, place: &Place) -> Result<Self> {
        if let Some(name) = state.shapes.keys().next() {
            return Err(Error::unsupported(place, format!("sets shape `{name}`, but deformation is not modelled yet; remove it")));
        }
        let mut scene = self.clone();
        if let Some(change) = &state.camera {
            scene.camera = self.camera.with(change, place)?;
        }
        let names: Vec<&str> = self.materials.iter().map(|m| m.name.as_str()).collect();
        for (name, change) in &state.materials {
            let material = &mut scene.materials[index_of(name, "material", &names, place)?];
            material.brdf = material.brdf.with(change, name, place)?;
        }
        let names: Vec<&str> = self.lights.iter().map(|l| l.name.as_str()).collect();
        for (name, change) in &state.lights {
            let light = &mut scene.lights[index_of(name, "light", &names, place)?];
            let gain = change.gain.unwrap_or([1.0; 3]);
            expect_radiometric(gain, &format!("light `{name}`: gain"), place)?;
            light.emitter.scale(gain);
            expect_radiometric(light.emitter.emission(), &format!("light `{name}`: emission times gain"), place)?;
        }
        if let Some(change) = &state.environment {
            scene.environment = Some(self.environment_with(change, place, &mut scene.warnings)?);
        }
        Ok(scene)
    }

    /// Names of the materials that vary at playback, in the order of `[vary]`.
    pub fn varying_names(&self) -> Vec<&str> {
        self.vary.materials.iter().filter_map(|index| self.materials.get(*index)).map(|m| m.name.as_str()).collect()
    }

    fn environment_with(&self, change: &EnvironmentState, place: &Place, warnings: &mut Vec<String>) -> Result<Environment> {
        let mut environment = match (&self.environment, &change.map) {
            (Some(environment), _) => environment.clone(),
            (None, Some(_)) => Environment { map: Arc::new(white_map()), gain: [1.0; 3], rotation_deg: 0.0 },
            (None, None) => return Err(Error::invalid(place, "sets [environment], but the scene has none; add one, or name a map")),
        };
        if let Some(name) = &change.map {
            let path = self.locate_map(name, place);
            expect_file(&path, name, place)?;
            environment.map = Arc::new(read_map(&path, warnings)?);
        }
        environment.gain = change.gain.unwrap_or(environment.gain);
        environment.rotation_deg = change.rotation_deg.unwrap_or(environment.rotation_deg);
        check_environment(&environment, &place.part("environment"))?;
        Ok(environment)
    }

    fn locate_map(&self, name: &str, place: &Place) -> PathBuf {
        let folder_of = |file: &Path| file.parent().map(Path::to_path_buf).unwrap_or_default();
        let beside_state = locate(&folder_of(&place.file), name);
        if beside_state.is_file() { beside_state } else { locate(&folder_of(&self.file), name) }
    }
}

impl Emitter {
    fn emission(&self) -> Rgb {
        match self {
            Self::Area { radiance, .. } | Self::Mesh { radiance, .. } => *radiance,
            Self::Point { intensity, .. } => *intensity,
            Self::Directional { irradiance, .. } => *irradiance,
        }
    }

    fn scale(&mut self, gain: Rgb) {
        let value = match self {
            Self::Area { radiance, .. } | Self::Mesh { radiance, .. } => radiance,
            Self::Point { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        };
        value.iter_mut().zip(gain).for_each(|(v, g)| *v *= g);
    }
}
