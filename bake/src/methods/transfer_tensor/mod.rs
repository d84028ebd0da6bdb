//! Method `transfer-tensor`, the part of it that is here: light that reaches vertices after one and two
//! reflections, for any light and any materials of the objects that may be edited (thesis §5.3.3, eq. 5-8,
//! 5-10).
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
//! [`Arriving`] has the light at vertices before any reflection, [`classes`] say what (r, p) are,
//! [`LobeTable`] has means of ρ over texels, [`Gather`] sums; [`Second`] goes on to light after two
//! reflections. [`cluster`] groups vertices, and [`packed`] has the tensors of a cluster made small, by
//! [`tucker2`](crate::compress::tucker2).

pub mod around;
pub mod arriving;
mod bake;
pub mod classes;
pub mod cluster;
pub mod errors;
mod fit;
pub mod functions;
pub mod gather;
mod inspected;
pub mod lobe_harmonics;
pub mod lobe_table;
mod method;
pub mod packed;
mod prediction;
pub mod quantise;
pub mod ranks;
mod reflected;
mod registered;
pub mod rows;
pub mod second;
mod seen_texels;
mod settings;
mod sizes;
pub mod spaces;
mod stages;
#[cfg(test)]
mod tests;

pub use arriving::Arriving;
pub use bake::{Baked, bake};
pub use classes::Classes;
pub use gather::Gather;
pub use lobe_table::LobeTable;
pub use method::TransferTensorMethod;
pub use registered::METHOD;
pub use second::Second;
pub use settings::{NAME, REVISION, Settings};

/// Texels along a side of a face of the light (thesis §5.3.3.4).
pub const FACE_SIZE: usize = 8;
/// Functions of an editable material: diffuse, and four of its lobe.
pub const BASES: usize = 5;
/// Directions that a vertex looks in.
pub const RAYS: u32 = 1024;
/// The same for light after two reflections.
pub const SECOND_RAYS: u32 = 256;
