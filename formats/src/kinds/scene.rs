//! Kind `scene`, version 0: what the player needs to know of a scene besides its light transport.
//!
//! | section     | type | shape        | content |
//! |-------------|------|--------------|---------|
//! | `meta`      | u8   | record       | [`Meta`]: name, camera, curve of the display, film size, what varies, environment, materials, objects |
//! | `positions` | f32  | [vertices, 3] | metres, world space, each coordinate of at most 10⁹ m |
//! | `normals`   | f32  | [vertices, 3] | unit shading normals, world space: of length 1 to 10⁻⁵ |
//! | `triangles` | u32  | [triangles, 3] | vertex indices, counter-clockwise seen from the front; three places |
//!
//! Triangles may be there twice and normals may point away from them: imported meshes have either, and are kept as their files have them. None has two
//! corners in one place, for those without area are left out when a mesh is loaded.
//!
//! Objects own consecutive ranges of triangles. Names of materials, of objects and of the clips of a shape differ.

use super::names::{fault_of_name, fault_of_names};
use crate::container::{Kind, MAX_SECTION_BYTES, Sections, Stored, Writer};
use crate::display::Tonemap;
use crate::error::{Error, Place, Result};
use crate::method::{Card, Materials};
use crate::shape::MAX_CLIPS;
use crate::state::{
    Brdf, Camera, EnvironmentState, MAX_COORDINATE, MaterialState, Posed, Rgb, ShapeState, Varies,
};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// Names, camera, materials, objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Name of the scene.
    pub name: String,
    /// The camera as the scene file gives it.
    pub camera: Camera,
    /// The curve of the display as the scene file gives it.
    pub tonemap: Tonemap,
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

    /// What undoes `change` on this environment: the leaves that it names, as they are here.
    pub fn inverse(&self, change: &EnvironmentState) -> EnvironmentState {
        EnvironmentState {
            map: change.map.as_ref().map(|_| self.map.clone()),
            rotation_deg: change.rotation_deg.map(|_| self.rotation_deg),
            gain: change.gain.map(|_| self.gain),
        }
    }

    /// Checks gain and rotation.
    pub fn validate(&self, place: &Place) -> Result<()> {
        if !self.gain.iter().all(|g| (0.0..=MAX_GAIN).contains(g)) {
            return Err(Error::invalid(
                place,
                format!("environment: gain {:?} is outside 0..{MAX_GAIN}", self.gain),
            ));
        }
        if !self.rotation_deg.is_finite() {
            return Err(Error::invalid(place, "environment: rotation_deg must be a finite number"));
        }
        Ok(())
    }
}

/// Largest gain of an environment: times the largest radiance of any map, 10¹², summed up by rows of as many
/// terms as there can be, it is still a number.
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
    /// The sharpest lobe that it may be edited to, an exponent, roughness or slope; as usual if it does not vary.
    pub sharpest: f32,
}

/// Most materials: each has a texture of its own on the GPU, if only of one texel.
pub const MAX_MATERIALS: usize = 4096;
/// Most objects: each is drawn by itself.
pub const MAX_OBJECTS: usize = 1 << 16;
/// How far the length of a normal may be from 1. Normals are normalised in double precision and rounded,
/// which is off by 10⁻⁷.
pub const NORMAL_TOLERANCE: f32 = 1e-5;

impl Meta {
    /// Checks everything that can be told without the meshes.
    ///
    /// # Errors
    /// `Invalid` with what is wrong, and what else is possible.
    pub fn validate(&self, place: &Place) -> Result<()> {
        self.camera.validate(place)?;
        if let Some(environment) = &self.environment {
            environment.validate(place)?;
        }
        self.materials.iter().try_for_each(|material| {
            material.expect_sharpest(place)?;
            material.validate(&material.brdf, place)
        })?;
        self.fault().map_or(Ok(()), |fault| Err(Error::invalid(place, fault)))
    }

    fn fault(&self) -> Option<String> {
        if !is_legal_size(self.size) {
            return Some(format!("film size {:?} is not one of 1 to {MAX_PIXELS} pixels", self.size));
        }
        let (materials, objects) = (self.materials.len(), self.objects.len());
        if materials > MAX_MATERIALS || objects > MAX_OBJECTS {
            return Some(format!(
                "{materials} materials and {objects} objects, at most {MAX_MATERIALS} and {MAX_OBJECTS} are possible"
            ));
        }
        let map = self.environment.as_ref().and_then(|look| fault_of_name("the environment map", &look.map));
        fault_of_name("the scene", &self.name)
            .or(map)
            .or_else(|| fault_of_names("materials", self.materials.iter().map(|m| m.name.as_str())))
            .or_else(|| fault_of_names("objects", self.objects.iter().map(|o| o.name.as_str())))
            .or_else(|| self.fault_of_shapes())
            .or_else(|| {
                let stranger = self.objects.iter().find(|o| o.material as usize >= materials)?;
                Some(format!("object `{}` names a material that is not there", stranger.name))
            })
    }

    fn fault_of_shapes(&self) -> Option<String> {
        let objects: HashSet<&str> = self.objects.iter().map(|object| object.name.as_str()).collect();
        let ghost = self.shapes.iter().find(|shape| !objects.contains(shape.object.as_str()));
        ghost
            .map(|shape| format!("shape `{}` is no object", shape.object))
            .or_else(|| {
                fault_of_names("objects that deform", self.shapes.iter().map(|shape| shape.object.as_str()))
            })
            .or_else(|| self.shapes.iter().find_map(StoredShape::fault))
    }

    /// What the method of `card` lets vary of this scene.
    pub fn varies(&self, card: &Card) -> Varies<'_> {
        let lets = &card.lets_vary;
        let materials = self.materials.iter().filter(|m| m.varies && lets.materials > Materials::Fixed);
        let shapes = self.shapes.iter().filter(|_| self.varies_shape && lets.shape);
        Varies {
            environment: lets.light && self.varies_light && self.environment.is_some(),
            camera: lets.view && self.varies_view,
            materials: materials.map(|m| m.name.as_str()).collect(),
            shapes: shapes.map(|shape| shape.object.as_str()).collect(),
        }
    }
}

impl StoredMaterial {
    fn expect_sharpest(&self, place: &Place) -> Result<()> {
        let (model, sharpest) = (self.brdf.model(), self.sharpest);
        let is_usual = sharpest == model.usual_sharpest();
        let checked = if self.varies || is_usual {
            model.expect_sharpest(sharpest)
        } else {
            Err(format!("{sharpest} is of a material that varies, which it does not"))
        };
        checked.map_err(|fault| {
            Error::invalid(place, format!("material `{}`: sharpest lobe {fault}", self.name))
        })
    }

    /// What its lobe may be edited to: from the least exponent, roughness or slope to the largest.
    pub fn editable(&self) -> [f32; 2] {
        self.brdf.model().editable(self.sharpest)
    }

    /// Checks parameters that the material has, or is to have: first the narrower range of one that varies,
    /// whose message is of more use.
    ///
    /// # Errors
    /// `Invalid` with the range that is left.
    pub fn validate(&self, brdf: &Brdf, place: &Place) -> Result<()> {
        if self.varies {
            brdf.validate_varying(self.textured, self.sharpest, &self.name, place)?;
        }
        brdf.validate(&self.name, place)
    }

    /// `brdf`, which the material has at the moment, with the leaves that `change` names replaced.
    ///
    /// # Errors
    /// `Invalid` for leaves of another model, for textures, and for what [`StoredMaterial::validate`] refuses.
    pub fn with(&self, brdf: &Brdf, change: &MaterialState, place: &Place) -> Result<Brdf> {
        let brdf = brdf.replaced(change, &self.name, place)?;
        change.expect_numbers(&self.name, place)?;
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

    fn fault(&self) -> Option<String> {
        if self.clips.len() > MAX_CLIPS {
            return Some(format!(
                "shape `{}` has {} clips, at most {MAX_CLIPS} are possible",
                self.object,
                self.clips.len()
            ));
        }
        if let Some(clip) =
            self.clips.iter().find(|clip| !(clip.duration_s.is_finite() && clip.duration_s >= 0.0))
        {
            return Some(format!(
                "the duration of a clip of shape `{}`, {} s, is no number of at least 0",
                self.object, clip.duration_s
            ));
        }
        fault_of_names(
            &format!("clips of shape `{}`", self.object),
            self.clips.iter().map(|clip| clip.name.as_str()),
        )
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
/// Most pixels of a film: an RGB image of halves must fit one section, with a tenth of the pixels showing a
/// second class.
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
        section.expect_valid(|place| meta.validate(place))?;
        let positions = vectors(sections, "positions", None, fault_of_positions)?;
        let normals = vectors(sections, "normals", Some(positions.len()), fault_of_normals)?;
        let section = sections.take("triangles")?;
        let triangles = section.u32_rows()?;
        section.expect(fault_of_triangles(&triangles, &positions, &meta.objects))?;
        Ok(Self { meta, positions, normals, triangles })
    }
}

impl StoredScene {
    /// By vertex the index of the material of the first triangle that it is a corner of, 0 if there is none.
    pub fn materials_of_vertices(&self) -> Vec<u32> {
        let mut materials = vec![None; self.positions.len()];
        let objects = self.meta.objects.iter();
        let of_triangles = objects.flat_map(|o| std::iter::repeat_n(o.material, o.triangles as usize));
        for (triangle, material) in self.triangles.iter().zip(of_triangles) {
            for vertex in triangle {
                if let Some(known) = materials.get_mut(*vertex as usize) {
                    known.get_or_insert(material);
                }
            }
        }
        materials.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Checks what reading checks, of a scene that is yet to be written.
    ///
    /// # Errors
    /// `Invalid` with what is wrong.
    pub fn validate(&self, place: &Place) -> Result<()> {
        self.meta.validate(place)?;
        let elements = self.positions.len().max(self.triangles.len());
        let most = MAX_SECTION_BYTES as usize / size_of::<[f32; 3]>();
        let too_many = (elements > most).then(|| {
            format!("{elements} vertices or triangles, at most {most} of each fit; simplify the meshes")
        });
        let uneven = || {
            (self.normals.len() != self.positions.len()).then(|| "not every vertex has a normal".to_owned())
        };
        let fault = too_many
            .or_else(uneven)
            .or_else(|| fault_of_positions(&self.positions))
            .or_else(|| fault_of_normals(&self.normals))
            .or_else(|| fault_of_triangles(&self.triangles, &self.positions, &self.meta.objects));
        fault.map_or(Ok(()), |fault| Err(Error::invalid(place, fault)))
    }
}

/// A section of vectors, `count` of them where that is known, without `fault`. Its bytes are gone on return:
/// a hostile scene's sections are large together.
fn vectors(
    sections: &mut Sections<'_>,
    name: &str,
    count: Option<usize>,
    fault: fn(&[[f32; 3]]) -> Option<String>,
) -> Result<Vec<[f32; 3]>> {
    let section = sections.take(name)?;
    let vectors = section.f32_rows()?;
    section.expect_shape(&[count.unwrap_or(vectors.len()) as u64, 3])?;
    section.expect(fault(&vectors))?;
    Ok(vectors)
}

fn fault_of_positions(positions: &[[f32; 3]]) -> Option<String> {
    // Not so with NaN either.
    let at = positions.as_flattened().iter().position(|x| x.is_nan() || x.abs() > MAX_COORDINATE)?;
    let value = positions.as_flattened()[at];
    let fault = if value.is_finite() {
        format!("is {value:?}, farther from the origin than {MAX_COORDINATE:e} m")
    } else {
        NOT_FINITE.to_owned()
    };
    Some(format!("element {at} {fault}"))
}

fn fault_of_normals(normals: &[[f32; 3]]) -> Option<String> {
    let is_unit = |n: &[f32; 3]| (Vec3::from(*n).length() - 1.0).abs() <= NORMAL_TOLERANCE;
    let vertex = normals.iter().position(|n| !is_unit(n))?;
    match normals[vertex].iter().position(|x| !x.is_finite()) {
        Some(axis) => Some(format!("element {} {NOT_FINITE}", 3 * vertex + axis)),
        None => Some(format!(
            "the normal of vertex {vertex} is of length {}, not 1",
            Vec3::from(normals[vertex]).length()
        )),
    }
}

fn fault_of_triangles(
    triangles: &[[u32; 3]],
    positions: &[[f32; 3]],
    objects: &[StoredObject],
) -> Option<String> {
    for (triangle, corners) in triangles.iter().enumerate() {
        let [Some(a), Some(b), Some(c)] = corners.map(|vertex| positions.get(vertex as usize)) else {
            return Some(format!("triangle {triangle} names a vertex that is not there"));
        };
        if a == b || b == c || c == a {
            return Some(format!("triangle {triangle} has two corners in one place, and so no area"));
        }
    }
    let owned = objects.iter().map(|o| u64::from(o.triangles)).sum::<u64>();
    (owned != triangles.len() as u64).then(|| "the objects do not cover the triangles".to_owned())
}

const NOT_FINITE: &str = "is not a finite number";
