//! What the method is called, and which version of it this is.

/// Name of the method.
pub const NAME: &str = relume_formats::method::SPHERE_SHADOWS.name;
/// Changes whenever the same scene and settings give other bytes than before, in bundles or in logs,
/// spheres included.
pub const REVISION: u32 = 7;
