//! Whole-product tests, all in one binary:
//!
//! * [`truth`]: the tracer against closed forms;
//! * [`stability`]: where methods stop being right, a suite for each;
//! * [`accuracy`]: baked images against the reference, with stated bounds;
//! * [`cpu_gpu`]: the player's shaders against `evaluate`;
//! * [`relighting`]: sparse-transfer from bake to radiance;
//! * [`shadows`]: sphere-shadows from bake to radiance;
//! * [`plan`]: plans, and their predictions against bakes;
//! * [`frame_cost`]: what bakes report of frames;
//! * [`lights`]: lights chosen by what of them arrives;
//! * [`later`]: third and later reflections of transfer-images;
//! * [`chart`]: charts of speed against accuracy;
//! * [`cli`]: the binaries as a user runs them;
//! * [`docs`]: links of the documentation, and the length of the README;
//! * [`first_scene`]: first scenes for models, and looks at scenes before they are baked;
//! * [`cases`]: inputs that went wrong once;
//! * [`reuse`]: what a change of a scene traces again;
//! * [`painted`]: painted materials in references;
//! * [`pieces`]: bakes over many machines;
//! * [`spheres`]: sphere sets as a user makes them;
//! * [`sphere_motion`]: fitted spheres on meshes that deform;
//! * [`tensors`]: tensors of BRDF spaces, from bake's library to exported arrays.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests fail by panicking")]

mod accuracy;
mod cases;
mod chart;
mod cli;
mod cpu_gpu;
mod docs;
mod filter;
mod filter_pictures;
mod first_scene;
mod five_scenes;
mod frame_cost;
mod guides;
mod later;
mod lights;
mod noise;
mod painted;
mod pieces;
mod plan;
mod region_images;
mod relighting;
mod reuse;
mod shadows;
mod shining;
mod sphere_motion;
mod spheres;
mod stability;
mod support;
mod tensors;
mod truth;
