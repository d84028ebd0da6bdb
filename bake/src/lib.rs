//! The offline pipeline: traces how light moves through a scene, projects it on bases, compresses and writes it.
//!
//! * [`trace`]: rays, samples, lights, the path tracer that is our truth, and every gather;
//! * [`brdf`]: BRDF models, their bases, and sampling of their lobes;
//! * [`compress`]: numerics that make data small;
//! * [`chart`]: speed against accuracy, measured;
//! * [`methods`]: one folder per method: gather, project, compress, write;
//! * [`work_log`]: finished pieces of a bake on disk, which make it resumable;
//! * [`plan`]: what a scene needs and what baking it will take;
//! * [`gallery`]: charts and pictures of many scenes on one page;
//! * [`play`]: runs the player, to measure what it shows;
//! * [`playable`]: which animations a bundle's methods can play;
//! * [`darkness`]: whether a scene shows anything;
//! * [`memory`]: how much memory a bake may take;
//! * [`output`]: folders that the user wants things in;
//! * [`frame_cost`]: what a frame of a new bundle costs;
//! * [`inspect`]: looking into bundles: info, verify, export.

pub mod brdf;
pub mod bundle;
pub mod chart;
pub mod cli;
pub mod commands;
pub mod compress;
pub mod darkness;
pub mod error;
pub mod exr_file;
pub mod frame_cost;
pub mod gallery;
pub mod inspect;
pub mod job;
pub mod memory;
pub mod merge;
pub mod methods;
pub mod output;
pub mod plan;
pub mod play;
pub mod playable;
pub mod report;
pub mod scene_hash;
pub mod spheres;
pub mod stage;
pub mod trace;
pub mod work_log;
