//! `[[object]]` as written.

use crate::transform::TransformFile;
use serde::Deserialize;

/// One object: a file or a procedural shape. A glTF file without `material` brings its own materials, and its
/// lights unless `lights = false`. The parameters of all shapes share one flat list, because keys can only be
/// denied there; [`crate::shapes::Shape::from_object`] refuses those that do not belong to the shape.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectFile {
    pub name: String,
    pub material: Option<String>,
    #[serde(default)]
    pub transform: TransformFile,
    pub file: Option<String>,
    pub node: Option<String>,
    pub lights: Option<bool>,
    pub crease_deg: Option<f64>,
    pub spheres: Option<u32>,
    pub shape: Option<ShapeName>,
    pub twist_deg: Option<f64>,
    pub twist_s: Option<f64>,
    pub subdivisions: Option<u32>,
    pub segments: Option<u32>,
    pub sides: Option<u32>,
    pub p: Option<u32>,
    pub q: Option<u32>,
    pub radius: Option<f64>,
    pub tube: Option<f64>,
    pub major_radius: Option<f64>,
    pub minor_radius: Option<f64>,
    pub inner_radius: Option<f64>,
    pub outer_radius: Option<f64>,
    pub height: Option<f64>,
    pub profile: Option<Vec<[f64; 2]>>,
}

/// The procedural shapes.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ShapeName {
    Quad,
    Box,
    Sphere,
    Torus,
    TorusKnot,
    Ring,
    Lathe,
}

impl ShapeName {
    /// The parameters that belong to the shape.
    pub fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Box => &[],
            Self::Quad => &["segments"],
            Self::Sphere => &["subdivisions"],
            Self::Torus => &["major_radius", "minor_radius", "segments", "sides"],
            Self::TorusKnot => &["p", "q", "radius", "tube", "segments", "sides"],
            Self::Ring => &["inner_radius", "outer_radius", "height", "segments"],
            Self::Lathe => &["profile", "segments"],
        }
    }
}

impl ObjectFile {
    /// Names of the shape parameters that the object gives.
    pub fn given_parameters(&self) -> impl Iterator<Item = &'static str> {
        [
            ("subdivisions", self.subdivisions.is_some()),
            ("segments", self.segments.is_some()),
            ("sides", self.sides.is_some()),
            ("p", self.p.is_some()),
            ("q", self.q.is_some()),
            ("radius", self.radius.is_some()),
            ("tube", self.tube.is_some()),
            ("major_radius", self.major_radius.is_some()),
            ("minor_radius", self.minor_radius.is_some()),
            ("inner_radius", self.inner_radius.is_some()),
            ("outer_radius", self.outer_radius.is_some()),
            ("height", self.height.is_some()),
            ("profile", self.profile.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, given)| given.then_some(name))
    }
}
