//! BRDF models, linear bases of their spaces, and sampling of their lobes.

pub mod basis;
pub mod blinn_phong;
pub mod lobes;
