//! How surfaces look, given what is known of their vertices.

use super::{DIFFUSE, GLOSSY};
use wgpu::Buffer;

/// What surfaces reflect, by buffers of four floats for each vertex, of which the last is unused: W/(sr·m²)
/// before the gain, of all light but the suns, which are added where points are drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Surface<'a> {
    /// Alike in all directions.
    Diffuse {
        /// What white diffuse surfaces would show.
        radiance: &'a Buffer,
    },
    /// With highlights.
    Glossy {
        /// What the diffuse part of the material would show the eye if it were white.
        radiance: &'a Buffer,
        /// What its glossy part shows.
        glossy: &'a Buffer,
    },
}

impl Surface<'_> {
    /// The shader, with entry points `corner` and `surface`.
    pub(super) fn shader(self) -> &'static str {
        match self {
            Self::Diffuse { .. } => DIFFUSE,
            Self::Glossy { .. } => GLOSSY,
        }
    }

    /// What the shader takes of vertices beside their place, texture coordinates and normal.
    pub(super) fn vertices(self) -> Vec<Buffer> {
        match self {
            Self::Diffuse { radiance } => vec![radiance.clone()],
            Self::Glossy { radiance, glossy } => vec![radiance.clone(), glossy.clone()],
        }
    }
}
