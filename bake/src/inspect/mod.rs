//! Looking into files and bundles: what they hold, whether they are sound, and their content in standard
//! formats.

mod codec;
mod export;
mod info;
mod info_text;
mod kinds;
#[cfg(test)]
mod test_bundle;
#[cfg(test)]
mod test_spheres;
mod verify;

pub use export::{export_file, export_scene};
pub use info::info;
pub use verify::verify;
