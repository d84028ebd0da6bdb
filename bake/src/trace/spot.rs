//! What BRDFs know of a point of a surface.

use glam::Vec3A;

/// Texture coordinates where nothing is painted: there, no texture is asked for.
pub const UNPAINTED: [f32; 2] = [0.5; 2];

/// A point of a surface, as far as it decides how light is reflected there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Index of its material.
    pub material: u32,
    /// What the scene's texture multiplies the diffuse colour with; 1 without one.
    pub albedo: Vec3A,
    /// Where it is in the textures that are painted on the material; [`UNPAINTED`] if none are.
    pub uv: [f32; 2],
}
