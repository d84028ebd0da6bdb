//! Tests of what is stored and what it means, all in one binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests fail by panicking")]

mod approximate;
mod brdf_tensor;
mod corpus;
mod corrupt;
mod corrupt_images;
mod corrupt_kinds;
mod corrupt_manifests;
mod corrupt_tables;
mod cubemap;
mod following;
mod haar;
mod looks;
mod materials;
mod meaning;
mod microfacet;
mod receivers;
mod region_images;
mod relighting;
mod round_trip;
mod shapes;
mod sphere_sets;
mod sphere_shadows;
mod support;
mod transfer_tensor;
mod triple;
mod two_level;
mod visibility_table;
