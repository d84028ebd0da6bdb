//! The offline pipeline: traces how light moves through a scene, projects it on bases, compresses and writes
//! it.
//!
//! * [`trace`]: rays, samples, lights, the path tracer that is our truth, and every gather;
//! * [`brdf`]: BRDF models, their bases, and sampling of their lobes;
//! * [`compress`]: numerics that make data small;
//! * [`method`]: what a bundle needs to know of any method;
//! * [`methods`]: one folder per method: gather, project, compress, write;
//! * [`bundle`]: from a scene to a bundle on disk; [`unfinished`]: the folder of what is not finished yet;
//! * [`shard`], [`merge`]: bakes over many machines;
//! * [`work_log`]: finished pieces of a bake on disk, which make it resumable;
//! * [`playable`]: which animations a bundle's methods can play;
//! * [`darkness`]: whether a scene shows anything;
//! * [`random_state`]: states that bakes are judged by;
//! * [`filter`]: takes noise out of pictures that are sums of others;
//! * [`guided`]: paths that look where light comes from;
//! * [`probe`]: a look at a scene before it is baked, and what is wrong in it;
//! * [`memory`]: how much memory a bake may take;
//! * [`output`]: folders that the user wants things in;
//! * [`inspected`]: what there is to tell and to export of a file of each kind;
//! * [`inspect`]: looking into bundles: info, verify, export.

pub mod brdf;
pub mod bundle;
pub mod compress;
pub mod darkness;
pub mod error;
pub mod exr_file;
pub mod filter;
pub mod fragments;
pub mod guided;
pub mod inspect;
pub mod inspected;
pub mod interrupted;
pub mod job;
pub mod memory;
pub mod merge;
pub mod method;
pub mod methods;
pub mod noise_target;
pub mod output;
pub mod paintings;
pub mod playable;
pub mod probe;
pub mod random_paint;
pub mod random_state;
pub mod report;
pub mod scene_hash;
pub mod shard;
pub mod spheres;
pub mod stage;
pub mod trace;
mod traced;
pub mod unfinished;
pub mod work_log;
