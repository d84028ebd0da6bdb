//! How a scene looks at one moment: what it has, and what a state replaces of it.

use super::Brdfs;
use crate::display::{Display, Tonemap};
use crate::error::{Error, Place, Result};
use crate::kinds::scene::{self, EnvironmentLook, StoredMaterial};
use crate::method::{Card, Materials};
use crate::near::{did_you_mean, what_there_is};
use crate::state::{Brdf, Camera, EnvironmentState, Posed, ShapeState, State, Varies, ViewState};
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
    /// Parameters of every material.
    pub materials: Brdfs,
    /// The camera and its exposure.
    pub camera: Camera,
    /// The curve of the display.
    pub tonemap: Tonemap,
    /// The environment, if the scene has one.
    pub environment: Option<EnvironmentLook>,
    /// What objects that deform show, by name; those that rest are not there.
    pub shapes: BTreeMap<String, Posed>,
}

/// What a change makes of the parts of a look that it names.
struct Changed<'a> {
    /// Name, index and new parameters.
    materials: Vec<(&'a str, usize, Brdf)>,
    /// Name, change, and what is shown then.
    shapes: Vec<(&'a str, &'a ShapeState, Option<Posed>)>,
    camera: Option<Camera>,
    environment: Option<EnvironmentLook>,
}

impl Scope {
    /// What may change at playback.
    pub fn varies(&self) -> Varies<'_> {
        self.scene.varies(self.card)
    }

    /// The materials that may be edited, in the order of the scene.
    pub fn materials(&self) -> impl Iterator<Item = &StoredMaterial> {
        self.scene
            .materials
            .iter()
            .filter(|material| material.varies && self.card.lets_vary.materials > Materials::Fixed)
    }

    /// `now` with the leaves that `change` names replaced.
    ///
    /// # Errors
    /// `Invalid` for what is out of range, and for a map that is not there.
    pub(super) fn environment(
        &self,
        now: &EnvironmentLook,
        change: &EnvironmentState,
        place: &Place,
    ) -> Result<EnvironmentLook> {
        let look = now.with(change, place)?;
        if self.maps.contains(&look.map) {
            return Ok(look);
        }
        let meant = did_you_mean(&look.map, self.maps.iter().map(String::as_str));
        Err(Error::invalid(
            place,
            format!("environment: no map `{}`; this bundle has: {}{meant}", look.map, self.maps.join(", ")),
        ))
    }
}

impl Look {
    /// How the scene file has it.
    pub fn default_of(scene: &scene::Meta) -> Self {
        let materials = Brdfs::of(&scene.materials);
        Self {
            materials,
            camera: scene.camera,
            tonemap: scene.tonemap,
            environment: scene.environment.clone(),
            shapes: BTreeMap::new(),
        }
    }

    /// How a display shows it.
    pub fn display(&self) -> Display {
        Display { exposure_ev: self.camera.exposure_ev, tonemap: self.tonemap }
    }

    /// The look as another display shows it: the same radiance.
    pub fn displayed(&self, display: Display) -> Self {
        let Display { exposure_ev, tonemap } = display;
        Self { camera: Camera { exposure_ev, ..self.camera }, tonemap, ..self.clone() }
    }

    /// This look with the leaves that `state` names replaced.
    ///
    /// # Errors
    /// Those of [`Look::apply`].
    pub fn with(&self, state: &State, scope: &Scope, place: &Place) -> Result<Self> {
        let mut look = self.clone();
        look.apply(state, scope, place)?;
        Ok(look)
    }

    /// Replaces the leaves that `change` names, in a look of the scene of `scope`. Returns the inverse, which
    /// names the leaves that have changed with the values that they had: applied next, it leads back to this
    /// look, bit for bit, and its own inverse leads to the changed one again.
    ///
    /// Whether what is named may vary is for [`State::expect_only`] to say.
    ///
    /// # Errors
    /// `Invalid` for names that the scene does not have, and for leaves that leave their legal range. Then
    /// nothing has changed.
    pub fn apply(&mut self, change: &State, scope: &Scope, place: &Place) -> Result<State> {
        let changed = self.changed(change, scope, place)?;
        let inverse = self.inverse(change, &changed);
        for (_, index, brdf) in changed.materials {
            self.materials.set_at(index, brdf);
        }
        for (name, _, posed) in changed.shapes {
            match posed {
                Some(posed) => self.shapes.insert(name.to_owned(), posed),
                None => self.shapes.remove(name),
            };
        }
        self.camera = changed.camera.unwrap_or(self.camera);
        self.tonemap = change.view.as_ref().and_then(|view| view.tonemap).unwrap_or(self.tonemap);
        self.environment = changed.environment.or_else(|| self.environment.take());
        Ok(inverse)
    }

    /// What `change` makes of this look.
    fn changed<'a>(&self, change: &'a State, scope: &Scope, place: &Place) -> Result<Changed<'a>> {
        change.expect_no_lights(place)?;
        let environment = match (&self.environment, &change.environment) {
            (_, None) => None,
            (Some(now), Some(change)) => Some(scope.environment(now, change, place)?),
            (None, Some(_)) => {
                return Err(Error::invalid(place, "sets [environment], but the scene has none; remove it"));
            }
        };
        Ok(Changed {
            materials: self.changed_materials(change, scope, place)?,
            shapes: self.changed_shapes(change, scope, place)?,
            camera: change.camera.as_ref().map(|change| self.camera.with(change, place)).transpose()?,
            environment,
        })
    }

    fn changed_materials<'a>(
        &self,
        change: &'a State,
        scope: &Scope,
        place: &Place,
    ) -> Result<Vec<(&'a str, usize, Brdf)>> {
        let materials = &scope.scene.materials;
        let new = |(name, change)| {
            let name: &'a String = name;
            let found = self
                .materials
                .index_of(name)
                .and_then(|index| Some((index, materials.get(index)?, self.materials.get(name)?)));
            let Some((index, material, now)) = found else {
                return Err(unknown(
                    "material",
                    name,
                    materials.iter().map(|material| material.name.as_str()),
                    place,
                ));
            };
            Ok((name.as_str(), index, material.with(now, change, place)?))
        };
        change.materials.iter().map(new).collect()
    }

    fn changed_shapes<'a>(
        &self,
        change: &'a State,
        scope: &Scope,
        place: &Place,
    ) -> Result<Vec<(&'a str, &'a ShapeState, Option<Posed>)>> {
        let shapes = &scope.scene.shapes;
        let named =
            shapes.iter().filter_map(|shape| Some((shape, change.shapes.get_key_value(&shape.object)?)));
        let new = named
            .map(|(shape, (name, change))| {
                Ok((name.as_str(), change, shape.with(self.shapes.get(name), change, place)?))
            })
            .collect::<Result<Vec<_>>>()?;
        let is_known = |name: &str| shapes.iter().any(|shape| shape.object == name);
        match change.shapes.keys().find(|name| new.len() < change.shapes.len() && !is_known(name)) {
            Some(stranger) => {
                Err(unknown("shape", stranger, shapes.iter().map(|shape| shape.object.as_str()), place))
            }
            None => Ok(new),
        }
    }

    /// What undoes `change`, which makes `changed` of this look.
    fn inverse(&self, change: &State, changed: &Changed<'_>) -> State {
        let material =
            |(name, now): (&str, &Brdf)| Some((name.to_owned(), now.inverse(change.materials.get(name)?)));
        let materials =
            changed.materials.iter().filter_map(|(name, ..)| Some((*name, self.materials.get(name)?)));
        let shape = |(name, change, after): &(&str, &ShapeState, Option<Posed>)| {
            ((*name).to_owned(), change.inverse(self.shapes.get(*name), after.as_ref()))
        };
        State {
            environment: self
                .environment
                .as_ref()
                .zip(change.environment.as_ref())
                .map(|(now, change)| now.inverse(change)),
            camera: change.camera.as_ref().map(|change| self.camera.inverse(change)),
            view: change
                .view
                .as_ref()
                .map(|change| ViewState { tonemap: change.tonemap.map(|_| self.tonemap) }),
            lights: BTreeMap::new(),
            materials: materials.filter_map(material).collect(),
            shapes: changed.shapes.iter().map(shape).collect(),
        }
    }
}

/// The error that the scene has nothing of this name.
fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>, place: &Place) -> Error {
    let known: Vec<&str> = known.collect();
    Error::invalid(place, format!("no {what} `{name}`{}", what_there_is(name, &known)))
}
