//! What must agree between the files of a bundle: files of different bakes can each be sound and yet not fit
//! together.
//!
//! Everything that reads bundles calls these: `bake verify`, `bake info` and `bake export` on all files, a
//! player on those that it reads, as they arrive. No check needs more of another file than its head, so that
//! nothing large must be kept.
//!
//! * [`expect_name`]: what the manifest calls a file's content;
//! * [`expect_images`], [`expect_regions`]: images against basis and scene;
//! * [`Maps`], [`expect_textures`] and [`expect_lit`]: maps and textures against the scene, and the main file
//!   of a method that they light;
//! * [`expect_spaces`]: tensors against BRDF spaces, bases and the scene;
//! * [`Objects`] and [`expect_receivers`]: sphere sets, shapes and receivers against the scene;
//! * [`Settings`]: what the manifest says of settings against the files;
//! * [`Scope`], [`Look`], [`Brdfs`], [`expect_playable`] and [`expect_some_plays`]: what of a scene may be
//!   set, and whether an animation sets nothing else.

mod animations;
mod brdfs;
mod difference;
mod images;
mod lit;
mod look;
mod settings;
mod shadows;
mod tensors;

pub use animations::{expect_playable, expect_some_plays, sets_only};
pub use brdfs::Brdfs;
pub use images::{expect_images, expect_regions};
pub use lit::{MAX_MAP_TEXELS, MAX_MAPS, Maps, expect_lit, expect_textures};
pub use look::{Look, Scope};
pub use settings::Settings;
pub use shadows::{MAX_SPHERE_PAIRS, Objects, expect_receivers};
pub use tensors::expect_spaces;

use crate::error::{Error, Place, Result};

/// The error that a file does not fit the others of its bundle.
fn refuse<T>(place: &Place, reason: impl AsRef<str>) -> Result<T> {
    Err(Error::invalid(place, format!("{}; bake the whole bundle again", reason.as_ref())))
}

/// Fails unless the file at `place`, whose content is called `name`, is listed by that name.
pub fn expect_name(name: &str, listed: &str, place: &Place) -> Result<()> {
    if name == listed {
        return Ok(());
    }
    refuse(place, format!("holds `{name}`, the manifest lists `{listed}`"))
}
