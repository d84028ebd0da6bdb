//! A loaded scene: everything in world space, validated, ready for tracing.

use relume_formats::basis::{EquirectMap, Texture, linear_from_srgb};
use relume_formats::display::Tonemap;
use relume_formats::shape::DeformingMesh;
use relume_formats::state::{Animation, Brdf, Camera, Model, Paint, Rgb};
use std::path::PathBuf;
use std::sync::Arc;

/// A loaded and validated scene. Directions and positions are in world space, lengths in metres.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Name: the folder's.
    pub name: String,
    /// The file it was read from, for messages.
    pub file: PathBuf,
    /// Film size in pixels, width and height.
    pub size: [u32; 2],
    /// Number of reflections that methods model: 1 is direct light only, [`ALL_REFLECTIONS`] all of them.
    pub reflections: u32,
    /// Largest relative L2 error that methods may make.
    pub max_error: f64,
    /// What varies at playback.
    pub vary: Vary,
    /// The camera.
    pub camera: Camera,
    /// The curve of the display.
    pub tonemap: Tonemap,
    /// Every material, by name.
    pub materials: Vec<Material>,
    /// Every object that reflects light, in file order.
    pub objects: Vec<Object>,
    /// Every light but the environment, in file order.
    pub lights: Vec<Light>,
    /// The light from afar.
    pub environment: Option<Environment>,
    /// Animations that come with the scene, by name.
    pub animations: Vec<Animation>,
    /// What was mended or ignored while loading, one line each.
    pub warnings: Vec<String>,
}

/// The number of [`Scene::reflections`] that stands for all of them.
pub const ALL_REFLECTIONS: u32 = u32::MAX;

impl Scene {
    /// [`Scene::reflections`] as a scene file has it.
    pub fn reflections_written(&self) -> String {
        if self.reflections == ALL_REFLECTIONS { "\"all\"".to_owned() } else { self.reflections.to_string() }
    }
}

/// What varies at playback.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Vary {
    /// Lights and environment.
    pub light: bool,
    /// The camera.
    pub view: bool,
    /// The shapes.
    pub shape: bool,
    /// Indices into [`Scene::materials`], in the order that the scene file names them.
    pub materials: Vec<usize>,
    /// Those of them that take textures, in the order that the scene file names them.
    pub painted: Vec<usize>,
    /// The largest exponent that they may have, if larger than usual.
    pub shininess_max: Option<f32>,
    /// The least roughness or slope that they may have, if less than usual.
    pub roughness_min: Option<f32>,
}

impl Vary {
    /// Which of the materials that vary the one of this number is.
    pub fn place_of(&self, material: u32) -> Option<usize> {
        self.materials.iter().position(|varies| *varies == material as usize)
    }

    /// The sharpest lobe that materials of `model` may have: an exponent, roughness or slope.
    pub fn sharpest(&self, model: Model) -> f32 {
        let asked = match model {
            Model::BlinnPhong => self.shininess_max,
            Model::Ggx | Model::CookTorrance => self.roughness_min,
        };
        asked.unwrap_or(model.usual_sharpest())
    }

    /// That of material number `index`; as usual if it does not vary.
    pub fn sharpest_of(&self, index: usize, brdf: &Brdf) -> f32 {
        let model = brdf.model();
        if self.materials.contains(&index) { self.sharpest(model) } else { model.usual_sharpest() }
    }

    /// The reflections of a scene that says nothing of them: all where materials alone vary, for that is
    /// cheap, else two.
    pub(crate) fn usual_reflections(&self) -> u32 {
        let others_vary = self.light || self.view || self.shape;
        if others_vary || self.materials.is_empty() { 2 } else { ALL_REFLECTIONS }
    }
}

/// A material and its default parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name, unique in the scene.
    pub name: String,
    /// Default parameters.
    pub brdf: Brdf,
    /// Multiplies kd or the base colour, where the mesh has texture coordinates.
    pub texture: Option<Arc<Texture>>,
    /// What a state has painted on it: then this says what it is, and not `brdf`.
    pub paint: Option<Arc<Paint>>,
    /// Where the texture's alpha is below this, there is no surface (glTF's alpha mode MASK).
    pub alpha_cutoff: Option<f32>,
}

/// Most spheres that an object may ask for.
pub const MAX_SPHERES: u32 = 4096;

/// A mesh wearing a material.
#[derive(Debug, Clone)]
pub struct Object {
    /// Name, unique in the scene.
    pub name: String,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// The mesh in world space, at rest unless a state poses it.
    pub mesh: Arc<Mesh>,
    /// What moves the mesh, if shapes vary and the object has clips: vertex i of one is vertex i of the
    /// other, at the same place at rest.
    pub shape: Option<Arc<DeformingMesh>>,
    /// How many spheres are to be fitted to it, at most [`MAX_SPHERES`].
    pub spheres: Option<u32>,
}

/// A triangle mesh: finite, without degenerate triangles, one unit normal per vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit shading normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one per vertex, or none at all.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// A light and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Name, unique among lights.
    pub name: String,
    /// What it emits, and from where.
    pub emitter: Emitter,
}

/// The kinds of light.
#[derive(Debug, Clone, PartialEq)]
pub enum Emitter {
    /// A parallelogram that emits on one side and reflects nothing.
    Area {
        /// One corner.
        corner: [f32; 3],
        /// From the corner to its two neighbours; `edge_u × edge_v` points to the side that emits.
        edge_u: [f32; 3],
        /// See `edge_u`.
        edge_v: [f32; 3],
        /// Emitted radiance, W/(sr·m²).
        radiance: Rgb,
    },
    /// The front of an object's mesh emits, and reflects by the object's material as well.
    Mesh {
        /// Index into [`Scene::objects`].
        object: usize,
        /// Emitted radiance, W/(sr·m²); what `glow` multiplies.
        radiance: Rgb,
        /// Where how much of it is emitted; evenly all of it without one.
        glow: Option<Glow>,
    },
    /// A point that emits evenly in all directions, or within a cone.
    Point {
        /// Where.
        position: [f32; 3],
        /// Radiant intensity, W/sr.
        intensity: Rgb,
        /// For a spot light: outside it there is no light.
        cone: Option<Cone>,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Unit direction in which the light travels.
        direction: [f32; 3],
        /// Irradiance on a surface that faces it, W/m².
        irradiance: Rgb,
    },
}

/// A texture of emitted light.
#[derive(Debug, Clone, PartialEq)]
pub struct Glow {
    /// Its alpha means nothing.
    pub texture: Arc<Texture>,
    /// Texture coordinates, one per vertex of the object's mesh.
    pub uvs: Arc<[[f32; 2]]>,
}

impl Glow {
    /// What a faint texture emits at most, as a share of one that is white all over; methods lit by the
    /// environment alone leave it out.
    pub const FAINT: f64 = 0.05;

    /// True if the texture emits at most [`Glow::FAINT`]: a few lamps on a surface that otherwise reflects.
    pub fn is_faint(&self) -> bool {
        let largest = |[r, g, b, _]: &[u8; 4]| f64::from(linear_from_srgb((*r).max(*g).max(*b)));
        let sum: f64 = self.texture.texels.iter().map(largest).sum();
        sum <= Self::FAINT * self.texture.texels.len() as f64
    }
}

/// The cone of a spot light. Intensity falls from the inner to the outer angle as the square of a linear ramp
/// in the cosine (glTF's KHR_lights_punctual).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit direction of its axis, away from the light.
    pub direction: [f32; 3],
    /// Cosine of the angle from the axis up to which the light has its full intensity.
    pub cos_inner: f32,
    /// Cosine of the angle from the axis at which it has vanished; below `cos_inner`.
    pub cos_outer: f32,
}

/// Light from all directions, infinitely far away.
#[derive(Debug, Clone)]
pub struct Environment {
    /// The map that shines.
    pub map: NamedMap,
    /// Further maps that may shine instead at playback.
    pub others: Vec<NamedMap>,
    /// Factor on its radiance.
    pub gain: Rgb,
    /// Counter-clockwise turn seen from +Y, degrees.
    pub rotation_deg: f32,
}

/// An environment map and what states call it.
#[derive(Debug, Clone)]
pub struct NamedMap {
    /// The name of its file, or of the procedural sky.
    pub name: String,
    /// The map.
    pub map: Arc<EquirectMap>,
}
