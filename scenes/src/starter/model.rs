//! What a model brings: its extent, materials, lamps and clips.

use super::quoting::{Digits, quoted};
use crate::geometry::{GltfFile, is_gltf, tidy_name};
use crate::loading::load_text;
use crate::scene::{Emitter, Material, Scene};
use glam::DVec3;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// What a model without materials of its own wears.
pub(super) const WORN: &str = "model";
/// A model this many times its size away from the origin is looked at a second time where it is near, for
/// single precision.
const FAR: f64 = 100.0;

/// The box around a model, and the sphere around that box's middle, in the model's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub radius: f64,
}

/// What a model brings.
#[derive(Debug)]
pub(super) struct Model {
    pub extent: Extent,
    /// Whether its file brings materials and lamps; else it wears [`WORN`].
    pub is_gltf: bool,
    /// As a scene has them in which nothing varies.
    pub materials: Vec<Material>,
    /// How many lamps there are.
    pub lamps: usize,
    /// Whether any surface emits.
    pub glows: bool,
    /// What its animations are called.
    pub clips: Vec<String>,
}

impl Model {
    /// Reads the model in `file`.
    pub fn read(file: &Path) -> Result<Self> {
        let is_gltf = is_gltf(file);
        let scene = draft(file, is_gltf, [0.0; 3])?;
        let rough = extent(&scene);
        let Some(rough) = rough else {
            return Err(Error::invalid(
                &Place::file(file),
                "brings lamps and no surface; there is nothing to light",
            ));
        };
        let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (rough.low[k] + rough.high[k]));
        let is_far = middle.iter().any(|x| x.abs() > FAR * rough.radius);
        let near = if is_far { extent(&draft(file, is_gltf, middle.map(|x| -x))?) } else { None };
        let extent = near.map_or(rough, |near| near.moved(middle));
        let clips = if is_gltf { clips(file)? } else { Vec::new() };
        let glows = |emitter: &Emitter| matches!(emitter, Emitter::Mesh { .. });
        Ok(Self {
            extent,
            is_gltf,
            lamps: scene.lights.iter().filter(|light| !glows(&light.emitter)).count(),
            glows: scene.lights.iter().any(|light| glows(&light.emitter)),
            materials: scene.materials,
            clips,
        })
    }
}

impl Extent {
    fn moved(self, by: [f64; 3]) -> Self {
        let moved = |corner: [f64; 3]| std::array::from_fn(|k| corner[k] + by[k]);
        Self { low: moved(self.low), high: moved(self.high), ..self }
    }
}

/// A scene of the model alone, moved.
fn draft(file: &Path, is_gltf: bool, by: [f64; 3]) -> Result<Scene> {
    let name = file.file_name().unwrap_or_default().to_str();
    let name = name.ok_or_else(|| {
        Error::invalid(&Place::file(file), "its name is no text that a scene file could hold; rename it")
    })?;
    let worn = if is_gltf { String::new() } else { format!("material = {}\n", quoted(WORN)) };
    let described = if is_gltf { String::new() } else { format!("[materials.{WORN}]\nbrdf = \"ggx\"\n") };
    let text = format!(
        "[render]\nsize = [1, 1]\n[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\nfov_deg = 40\n\
         [[object]]\nname = \"model\"\nfile = {}\n{worn}transform = {{ translation = {} }}\n{described}",
        quoted(name),
        Digits::beside(0.0).list(by)
    );
    // As if it were beside the model, so that messages name the model as its user does.
    load_text(&file.with_extension("toml"), &text)
}

/// The extent of all objects; `None` if there are none.
fn extent(scene: &Scene) -> Option<Extent> {
    let points = || {
        scene.objects.iter().flat_map(|object| &object.mesh.positions).map(|p| DVec3::from(p.map(f64::from)))
    };
    let low = points().reduce(DVec3::min)?;
    let high = points().reduce(DVec3::max)?;
    let middle = 0.5 * (low + high);
    let radius = points().map(|p| p.distance(middle)).fold(0.0, f64::max);
    Some(Extent { low: low.to_array(), high: high.to_array(), radius })
}

fn clips(file: &Path) -> Result<Vec<String>> {
    let opened = GltfFile::open(file, &mut Vec::new())?;
    let name = |(number, clip): (usize, gltf::Animation<'_>)| {
        clip.name().map_or_else(|| format!("clip {number}"), tidy_name)
    };
    Ok(opened.document.animations().enumerate().map(name).collect())
}
