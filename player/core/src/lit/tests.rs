//! Tests of what methods with lit meshes share.

mod brdf;
