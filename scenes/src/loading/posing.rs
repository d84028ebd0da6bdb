//! Objects at a moment of one of their clips.

use crate::scene::{Mesh, Object, Scene};
use crate::suggest::unknown_name;
use relume_formats::shape::{DeformingMesh, ShadingNormals};
use relume_formats::state::{Posed, ShapeState};
use relume_formats::{Error, Place, Result};
use std::sync::Arc;

impl Scene {
    /// Poses the object called `name`.
    ///
    /// # Errors
    /// `Invalid` if no object of this name deforms, for what [`ShapeState::posed`] refuses, and for a pose
    /// that is beyond all numbers.
    pub(super) fn pose(&mut self, name: &str, change: &ShapeState, place: &Place) -> Result<()> {
        let deforms = |object: &&mut Object| object.name == name && object.shape.is_some();
        let Some(object) = self.objects.iter_mut().find(deforms) else {
            return Err(self.no_shape(name, place));
        };
        let Some(shape) = object.shape.clone() else { return Ok(()) };
        let clips: Vec<&str> = shape.clips.iter().map(|clip| clip.name.as_str()).collect();
        if let Some(posed) = change.posed(name, None, &clips, place)? {
            object.mesh =
                Arc::new(object.mesh.posed(&shape, &posed, &place.part(format!("shape `{name}`")))?);
        }
        Ok(())
    }

    fn no_shape(&self, name: &str, place: &Place) -> Error {
        if !self.vary.shape {
            return Error::invalid(
                place,
                format!(
                    "sets shape `{name}`, but no object deforms; add shape = true to [vary] in scene.toml"
                ),
            );
        }
        let names =
            self.objects.iter().filter(|object| object.shape.is_some()).map(|object| object.name.as_str());
        let mut reason = unknown_name("object that deforms", name, names);
        if self.objects.iter().any(|object| object.name == name) {
            reason += &format!("; {TO_DEFORM}");
        }
        Error::invalid(place, reason)
    }
}

/// What makes an object deform.
pub(super) const TO_DEFORM: &str = "give a shape twist_deg, or a glTF object with clips a `material`";

impl Mesh {
    /// This mesh, which is at rest, as `shape` has it at `posed`. Its triangles are the same, so some may
    /// have no area now.
    fn posed(&self, shape: &DeformingMesh, posed: &Posed, place: &Place) -> Result<Self> {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        shape.positions(&shape.pose_of(Some(posed)), &mut positions);
        if let Some(vertex) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            let reason = format!(
                "clip `{}` at {} s takes vertex {vertex} beyond all numbers; mend the model",
                posed.clip, posed.time_s
            );
            return Err(Error::invalid(place, reason));
        }
        ShadingNormals::new(&self.positions, &self.normals, &self.triangles).at(&positions, &mut normals);
        Ok(Self { positions, normals, uvs: self.uvs.clone(), triangles: self.triangles.clone() })
    }
}
