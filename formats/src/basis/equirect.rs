//! An equirectangular map of radiance.

/// Linear RGB radiance from every direction, W/(sr·m²).
///
/// Texture coordinates of a direction d, which need not be of unit length: u = 0.5 + atan2(d.x, −d.z)/2π to the right and v = acos(d.y/|d|)/π down, so that
/// the middle of the map looks to −Z and its top row to +Y.
#[derive(Debug, Clone, PartialEq)]
pub struct EquirectMap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major from the top left.
    pub texels: Vec<[f32; 3]>,
}
