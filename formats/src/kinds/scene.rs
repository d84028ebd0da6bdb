//! Kind `scene`, version 0: what the player needs to know of a scene besides its light transport.
//!
//! | section     | type | shape        | content |
//! |-------------|------|--------------|---------|
//! | `meta`      | u8   | record       | [`Meta`]: name, camera, film size, what varies, environment, materials, objects |
//! | `positions` | f32  | [vertices, 3] | metres, world space |
//! | `normals`   | f32  | [vertices, 3] | unit shading normals, world space |
//! | `triangles` | u32  | [triangles, 3] | vertex indices, counter-clockwise seen from the front |
//!
//! Objects own consecutive ranges of triangles.

use crate::container::{Kind, MAX_SECTION_BYTES, Sections, Stored, Writer};
use crate::error::{Error, Place, Result};
use crate::state::{Brdf, Camera, EnvironmentState, MaterialState, Posed, Rgb, ShapeState, Varies};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Names, camera, materials, objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Name of the scene.
    pub name: String,
    /// The camera as the scene file gives it.
    pub camera: Camera,
    /// Film size in pixels, width and height.
    pub size: [u32; 2],
    /// Whether lights and environment may change at playback, as far as the method that plays lets them.
    pub varies_light: bool,
    /// Whether the camera may.
    pub varies_view: bool,
    /// Whether objects may deform.
    pub varies_shape: bool,
    /// The environment, if there is one.
    pub environment: Option<EnvironmentLook>,
    /// Every material.
    pub materials: Vec<StoredMaterial>,
    /// Every object, in the order of its triangles.
    pub objects: Vec<StoredObject>,
    /// The objects that deform, in the same order.
    pub shapes: Vec<StoredShape>,
}

/// Which environment map shines, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentLook {
    /// Name of the map: that of a file of kind `environment`.
    pub map: String,
    /// Factor on the map's radiance.
    pub gain: Rgb,
    /// Counter-clockwise turn seen from +Y, degrees.
    pub rotation_deg: f32,
}

impl EnvironmentLook {
    /// This environment with the leaves that `change` names replaced.
    ///
    /// # Errors
    /// `Invalid` for a gain that is negative or no number, and for a rotation that is none.
    pub fn with(&self, change: &EnvironmentState, place: &Place) -> Result<Self> {
        let look = Self {
            map: change.map.clone().unwrap_or_else(|| self.map.clone()),
            gain: change.gain.unwrap_or(self.gain),
            rotation_deg: change.rotation_deg.unwrap_or(self.rotation_deg),
        };
        look.validate(place)?;
        Ok(look)
    }

    fn validate(&self, place: &Place) -> Result<()> {
        if !self.gain.iter().all(|g| (0.0..=MAX_GAIN).contains(g)) {
            return Err(Error::invalid(place, format!("environment: gain {:?} is outside 0..{MAX_GAIN}", self.gain)));
        }
        if !self.rotation_deg.is_finite() {
            return Err(Error::invalid(place, "environment: rotation_deg must be a finite number"));
        }
        Ok(())
    }
}

/// Largest gain of an environment: times the largest radiance of any map it is still a number.
pub const MAX_GAIN: f32 = 1e9;

/// A material and its default parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredMaterial {
    /// Name, unique in the scene.
    pub name: String,
    /// Default parameters.
    pub brdf: Brdf,
    /// Whether playback may change it.
    pub varies: bool,
    /// Whether a texture multiplies its diffuse colour.
    pub textured: bool,
}

impl Meta {
    /// What a method whose main file is of `kind` lets vary of this scene.
    pub fn varies(&self, kind: Kind) -> Varies<'_> {
        match kind {
            Kind::TransferImages => {
                Varies { materials: self.materials.iter().filter(|m| m.varies).map(|m| m.name.as_str()).collect(), ..Varies::default() }
            }
            Kind::SparseTransfer => {
                Varies { environment: self.varies_light && self.environment.is_some(), camera: self.varies_view, ..Varies::default() }
            }
            Kind::SphereShadows => Varies {
                environment: self.varies_light && self.environment.is_some(),
                camera: self.varies_view,
                shapes: if self.varies_shape { self.shapes.iter().map(|shape| shape.object.as_str()).collect() } else { Vec::new() },
                ..Varies::default()
            },
            _ => Varies::default(),
        }
    }
}

impl StoredMaterial {
    /// Checks parameters that the material has, or is to have: first the narrower range of one that varies, whose message is of more use.
    ///
    /// # Errors
    /// `Invalid` with the range that is left.
    pub fn validate(&self, brdf: &Brdf, place: &Place) -> Result<()> {
        if self.varies {
            brdf.validate_varying(self.textured, &self.name, place)?;
        }
        brdf.validate(&self.name, place)
    }

    /// `brdf`, which the material has at the moment, with the leaves that `change` names replaced.
    ///
    /// # Errors
    /// `Invalid` for leaves of another model and for what [`StoredMaterial::validate`] refuses.
    pub fn with(&self, brdf: &Brdf, change: &MaterialState, place: &Place) -> Result<Brdf> {
        let brdf = brdf.replaced(change, &self.name, place)?;
        self.validate(&brdf, place)?;
        Ok(brdf)
    }
}

/// An object that deforms, and its clips; the rest is in a file of kind `shape`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredShape {
    /// Name of the object.
    pub object: String,
    /// The clips, each with a name of its own.
    pub clips: Vec<StoredClip>,
}

/// A clip, as far as one can choose it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredClip {
    /// Name.
    pub name: String,
    /// Seconds, at least 0.
    pub duration_s: f32,
}

impl StoredShape {
    /// What the shape, which shows `now`, shows after `change`; `None` at rest.
    ///
    /// # Errors
    /// Those of [`ShapeState::posed`].
    pub fn with(&self, now: Option<&Posed>, change: &ShapeState, place: &Place) -> Result<Option<Posed>> {
        let clips: Vec<&str> = self.clips.iter().map(|clip| clip.name.as_str()).collect();
        change.posed(&self.object, now, &clips, place)
    }

    fn fault(&self, objects: &[StoredObject]) -> Option<String> {
        if !objects.iter().any(|object| object.name == self.object) {
            return Some(format!("shape `{}` is no object", self.object));
        }
        let names: BTreeSet<&String> = self.clips.iter().map(|clip| &clip.name).collect();
        if names.len() != self.clips.len() || !self.clips.iter().all(|clip| clip.duration_s.is_finite() && clip.duration_s >= 0.0) {
            return Some(format!("the clips of shape `{}` have a name twice, or a duration that is no number of at least 0", self.object));
        }
        None
    }
}

/// An object: a range of triangles and its material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredObject {
    /// Name, unique in the scene.
    pub name: String,
    /// Index into [`Meta::materials`].
    pub material: u32,
    /// Number of triangles; the first follows the previous object's last.
    pub triangles: u32,
}

/// Meshes, camera and materials of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredScene {
    /// Everything that is not a big array.
    pub meta: Meta,
    /// Vertex positions, metres, world space.
    pub positions: Vec<[f32; 3]>,
    /// Unit shading normals, world space.
    pub normals: Vec<[f32; 3]>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

/// Largest film side, so that a product of two fits in 32 bits with room to spare.
pub const MAX_SIDE: u32 = 16_384;
/// Most pixels of a film: an RGB image of halves must fit one section, with a tenth of the pixels showing a second class.
pub const MAX_PIXELS: u64 = MAX_SECTION_BYTES / 6 * 10 / 11;

/// Whether a film may have this size.
pub fn is_legal_size(size: [u32; 2]) -> bool {
    size.iter().all(|n| (1..=MAX_SIDE).contains(n)) && u64::from(size[0]) * u64::from(size[1]) <= MAX_PIXELS
}

impl Stored for StoredScene {
    const KIND: Kind = Kind::Scene;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let (vertices, triangles) = (self.positions.len() as u64, self.triangles.len() as u64);
        out.record("meta", &self.meta)?;
        out.f32s("positions", &[vertices, 3], self.positions.as_flattened())?;
        out.f32s("normals", &[vertices, 3], self.normals.as_flattened())?;
        out.u32s("triangles", &[triangles, 3], self.triangles.as_flattened())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Meta = section.record()?;
        meta.camera.validate(&sections.place)?;
        if !is_legal_size(meta.size) {
            return Err(section.invalid(format!("film size {:?} is not one of 1 to {MAX_PIXELS} pixels", meta.size)));
        }
        if let Some(environment) = &meta.environment {
            environment.validate(&sections.place)?;
        }
        for material in &meta.materials {
            material.validate(&material.brdf, &sections.place)?;
        }
        let distinct = |names: Vec<&String>| names.iter().collect::<BTreeSet<_>>().len() == names.len();
        if !distinct(meta.materials.iter().map(|m| &m.name).collect()) || !distinct(meta.objects.iter().map(|o| &o.name).collect()) {
            return Err(section.invalid("two materials or two objects have the same name"));
        }
        if let Some(fault) = meta.shapes.iter().find_map(|shape| shape.fault(&meta.objects)) {
            return Err(section.invalid(fault));
        }
        if !distinct(meta.shapes.iter().map(|s| &s.object).collect()) {
            return Err(section.invalid("an object has two shapes"));
        }
        if meta.objects.iter().any(|o| o.material as usize >= meta.materials.len()) {
            return Err(section.invalid("an object names a material that is not there"));
        }

        let positions = vectors(sections, "positions", None)?;
        let vertices = positions.len() as u64;
        let normals = vectors(sections, "normals", Some(vertices))?;

        let section = sections.take("triangles")?;
        let values = section.u32s()?;
        let count = values.len() as u64 / 3;
        section.expect_shape(&[count, 3])?;
        if values.iter().any(|index| u64::from(*index) >= vertices) {
            return Err(section.invalid("a triangle names a vertex that is not there"));
        }
        if meta.objects.iter().map(|o| u64::from(o.triangles)).sum::<u64>() != count {
            return Err(section.invalid("the objects do not cover the triangles"));
        }
        Ok(Self { meta, positions, normals, triangles: values.as_chunks().0.to_vec() })
    }
}

/// A section of finite vectors, `count` of them where that is known. Its bytes are gone on return: a hostile scene's sections are large together.
fn vectors(sections: &mut Sections<'_>, name: &str, count: Option<u64>) -> Result<Vec<[f32; 3]>> {
    let section = sections.take(name)?;
    let values = section.f32s()?;
    section.expect_finite(&values)?;
    section.expect_shape(&[count.unwrap_or(values.len() as u64 / 3), 3])?;
    Ok(values.as_chunks().0.to_vec())
}
