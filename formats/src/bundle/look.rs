//! How a scene looks at one moment: what it has, and what a state replaces of it.

use crate::error::{Error, Place, Result};
use crate::kinds::scene::{self, EnvironmentLook, StoredMaterial};
use crate::method::{Card, Materials};
use crate::near::did_you_mean;
use crate::state::{Brdf, Camera, EnvironmentState, Posed, State, Varies};
use std::collections::BTreeMap;

/// What of a scene may be set, and to what.
#[derive(Debug, Clone)]
pub struct Scope {
    /// The scene.
    pub scene: scene::Meta,
    /// The method that plays, which decides what varies.
    pub card: &'static Card,
    /// The environment maps that there are.
    pub maps: Vec<String>,
}

/// How a scene looks at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Parameters of every material, by name.
    pub materials: BTreeMap<String, Brdf>,
    /// The camera and its exposure.
    pub camera: Camera,
    /// The environment, if the scene has one.
    pub environment: Option<EnvironmentLook>,
    /// What objects that deform show, by name; those that rest are not there.
    pub shapes: BTreeMap<String, Posed>,
}

impl Scope {
    /// What may change at playback.
    pub fn varies(&self) -> Varies<'_> {
        self.scene.varies(self.card)
    }

    /// The materials that may be edited, in the order of the scene.
    pub fn materials(&self) -> impl Iterator<Item = &StoredMaterial> {
        self.scene.materials.iter().filter(|material| material.varies && self.card.lets_vary.materials > Materials::Fixed)
    }

    /// `now` with the leaves that `change` names replaced.
    ///
    /// # Errors
    /// `Invalid` for what is out of range, and for a map that is not there.
    pub(super) fn environment(&self, now: &EnvironmentLook, change: &EnvironmentState, place: &Place) -> Result<EnvironmentLook> {
        let look = now.with(change, place)?;
        if self.maps.contains(&look.map) {
            return Ok(look);
        }
        let meant = did_you_mean(&look.map, self.maps.iter().map(String::as_str));
        Err(Error::invalid(place, format!("environment: no map `{}`; this bundle has: {}{meant}", look.map, self.maps.join(", "))))
    }
}

impl Look {
    /// How the scene file has it.
    pub fn default_of(scene: &scene::Meta) -> Self {
        let materials = scene.materials.iter().map(|material| (material.name.clone(), material.brdf)).collect();
        Self { materials, camera: scene.camera, environment: scene.environment.clone(), shapes: BTreeMap::new() }
    }

    /// The look at another exposure.
    pub fn exposed(&self, exposure_ev: f32) -> Self {
        Self { camera: Camera { exposure_ev, ..self.camera }, ..self.clone() }
    }

    /// This look with the leaves that `state` names replaced.
    ///
    /// # Errors
    /// `Invalid` for leaves that leave their legal range.
    pub fn with(&self, state: &State, scope: &Scope, place: &Place) -> Result<Self> {
        let mut look = self.clone();
        for material in &scope.scene.materials {
            if let (Some(brdf), Some(change)) = (look.materials.get_mut(&material.name), state.materials.get(&material.name)) {
                *brdf = material.with(brdf, change, place)?;
            }
        }
        for shape in &scope.scene.shapes {
            let Some(change) = state.shapes.get(&shape.object) else { continue };
            if let Some(posed) = shape.with(self.shapes.get(&shape.object), change, place)? {
                look.shapes.insert(shape.object.clone(), posed);
            }
        }
        if let Some(change) = &state.camera {
            look.camera = self.camera.with(change, place)?;
        }
        if let (Some(environment), Some(change)) = (&mut look.environment, &state.environment) {
            *environment = scope.environment(environment, change, place)?;
        }
        Ok(look)
    }
}
