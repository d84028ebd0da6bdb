//! Method `transfer-tensor`, the part of it that is here: light that reaches vertices after one reflection,
//! for any light and any materials of the objects that may be edited (thesis §5.3.3, eq. 5-8).
//!
//! The tensor T¹(l, r, p, s) of a vertex has l = texels of a coarse cube of light in world space, (r, p) =
//! what reflected it, a basis function of an editable material or a fixed material, and s = spherical
//! harmonics of the directions, in world space, that it arrives from. The source gives words; what is summed
//! is
//!
//! * T_x(l, r, p, s) = Σ_ω Y_s(ω)·R_y(l, p; −ω) dω over directions ω above the surface at x that meet a point
//!   y of r;
//! * R_y(l, p; ω_o) = ∫ over texel l of V_y(ω')·ρ_p(ω', ω_o)·(ω'·n_y) dω', at the three vertices around y in
//!   the frame of each, then interpolated.
//!
//! [`Arriving`] has the light at vertices before any reflection, [`Lobes`] means of ρ over texels, [`Gather`]
//! sums, [`classes`] say what (r, p) are, and [`clusters`](crate::compress::clusters) and
//! [`tucker2`](crate::compress::tucker2) make it small, which [`cluster`] does for the vertices of one
//! cluster.

pub mod arriving;
pub mod classes;
pub mod cluster;
pub mod gather;
pub mod lobes;
#[cfg(test)]
mod tests;

pub use arriving::Arriving;
pub use classes::Classes;
pub use gather::Gather;
pub use lobes::Lobes;

/// Texels along a side of a face of the light (thesis §5.3.3.4).
pub const FACE_SIZE: usize = 8;
/// Functions of an editable material: diffuse, and four of its lobe.
pub const BASES: usize = 5;
/// Directions that a vertex looks in.
pub const RAYS: u32 = 1024;
