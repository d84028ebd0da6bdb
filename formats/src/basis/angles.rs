//! What an isotropic BRDF needs to know of two directions.

/// Cosines between two directions, their half vector h and the surface normal n (Rusinkiewicz 1998).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// n·h, 0..=1: the half angle δ. 0 where there is no half vector.
    pub cos_half: f32,
    /// Between h and either direction, 0..=1.
    pub cos_difference: f32,
    /// Of one direction with n, above 0 where the BRDF counts.
    pub cos_in: f32,
    /// Of the other.
    pub cos_out: f32,
}
