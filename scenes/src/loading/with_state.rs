//! A scene at a state: what the tracer sees when something has changed.

use super::environment::named_map;
use crate::library::locate;
use crate::scene::{Emitter, Environment, Material, NamedMap, Scene};
use crate::suggest::Names;
use relume_formats::name::plain;
use relume_formats::near::nearest;
use relume_formats::paint_file::Canvas;
use relume_formats::state::{EnvironmentState, MaterialState, Rgb, State, numbers_of};
use relume_formats::{Error, Place, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Scene {
    /// This scene, which is at rest, at `state`, whether or not it varies so at playback. Meshes are shared,
    /// not copied, but for those that it poses: clips repeat, and a clip without a time is at its start.
    /// `place` is where the state comes from; maps that it names are sought beside it, then beside the scene, and
    /// textures beside it.
    ///
    /// # Errors
    /// `Invalid` for names that the scene lacks and values out of range, `Io` for a map or texture that is not there.
    pub fn with_state(&self, state: &State, place: &Place) -> Result<Self> {
        let mut scene = self.clone();
        for (name, change) in &state.shapes {
            scene.pose(name, change, place)?;
        }
        if let Some(change) = &state.camera {
            scene.camera = self.camera.with(change, place)?;
        }
        if let Some(tonemap) = state.view.as_ref().and_then(|view| view.tonemap) {
            scene.tonemap = tonemap;
        }
        let names = Names::new("material", self.materials.iter().map(|m| m.name.as_str()));
        for (name, change) in &state.materials {
            let index = names.index_of(name, place)?;
            scene.materials[index] = self.material_with(index, change, place, &mut scene.warnings)?;
        }
        let names = Names::new("light", self.lights.iter().map(|l| l.name.as_str()));
        for (name, change) in &state.lights {
            let light = &mut scene.lights[names.index_of(name, place)?];
            let emission = light.emitter.emission_mut();
            *emission = change.emission(*emission, name, place)?;
        }
        if let Some(change) = &state.environment {
            scene.environment = Some(self.environment_with(change, place, &mut scene.warnings)?);
        }
        Ok(scene)
    }

    /// Material number `index` with this change.
    fn material_with(
        &self,
        index: usize,
        change: &MaterialState,
        place: &Place,
        warnings: &mut Vec<String>,
    ) -> Result<Material> {
        let material = &self.materials[index];
        let Some((key, file)) = change.textures.iter().next() else {
            let brdf = material.brdf.with(change, &material.name, place)?;
            return Ok(Material { brdf, ..material.clone() });
        };
        if !self.vary.painted.contains(&index) {
            let (name, file) = (&material.name, plain(file));
            let reason = format!(
                "material `{name}`: `{file}` is a texture for {key}, but the material is not painted; add `{name}` to [vary] painted in \
                 scene.toml, or write {}",
                numbers_of(key)
            );
            return Err(Error::invalid(place, reason));
        }
        let sharpest = self.vary.sharpest_of(index, &material.brdf);
        let canvas = Canvas { name: &material.name, brdf: &material.brdf, sharpest };
        let paint = canvas.paint(change, place, warnings)?;
        Ok(Material { paint: Some(Arc::new(paint)), ..material.clone() })
    }

    /// Names of the materials that vary at playback, in the order of `[vary]`.
    pub fn varying_names(&self) -> Vec<&str> {
        self.vary
            .materials
            .iter()
            .filter_map(|index| self.materials.get(*index))
            .map(|m| m.name.as_str())
            .collect()
    }

    fn environment_with(
        &self,
        change: &EnvironmentState,
        place: &Place,
        warnings: &mut Vec<String>,
    ) -> Result<Environment> {
        let named = change.map.as_ref().map(|name| self.map_called(name, place, warnings)).transpose()?;
        let environment = match (&self.environment, named) {
            (Some(environment), None) => environment.clone(),
            (Some(environment), Some(map)) => Environment { map, ..environment.clone() },
            (None, Some(map)) => Environment { map, others: Vec::new(), gain: [1.0; 3], rotation_deg: 0.0 },
            (None, None) => {
                return Err(Error::invalid(
                    place,
                    "sets [environment], but the scene has none; add one, or name a map",
                ));
            }
        };
        environment.with(change, place)
    }

    /// One of the scene's own maps, a procedural one, or a file beside the state or the scene.
    fn map_called(&self, name: &str, place: &Place, warnings: &mut Vec<String>) -> Result<NamedMap> {
        let own = self
            .environment
            .iter()
            .flat_map(|e| [&e.map].into_iter().chain(&e.others))
            .find(|map| map.name == name);
        if let Some(map) = own {
            return Ok(map.clone());
        }
        let path = self.locate_map(name, place);
        let names = self
            .environment
            .iter()
            .flat_map(|e| [&e.map].into_iter().chain(&e.others))
            .map(|map| map.name.as_str());
        named_map(name, &path, place, warnings).map_err(|error| match nearest(name, names) {
            Some(meant) if !path.exists() => {
                Error::invalid(place, format!("no map `{name}`; did you mean `{meant}`?"))
            }
            _ => error,
        })
    }

    fn locate_map(&self, name: &str, place: &Place) -> PathBuf {
        let folder_of = |file: &Path| file.parent().map(Path::to_path_buf).unwrap_or_default();
        let beside_state = locate(&folder_of(&place.file), name);
        if beside_state.is_file() { beside_state } else { locate(&folder_of(&self.file), name) }
    }
}

impl Emitter {
    pub(super) fn emission(&self) -> Rgb {
        match self {
            Self::Area { radiance, .. } | Self::Mesh { radiance, .. } => *radiance,
            Self::Point { intensity, .. } => *intensity,
            Self::Directional { irradiance, .. } => *irradiance,
        }
    }

    fn emission_mut(&mut self) -> &mut Rgb {
        match self {
            Self::Area { radiance, .. } | Self::Mesh { radiance, .. } => radiance,
            Self::Point { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }
}
