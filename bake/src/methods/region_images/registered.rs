//! The method's line in the registry.

use super::inspected::INSPECTED;
use super::method::RegionImagesMethod;
use super::settings::{BASES, Settings};
use crate::methods::asked::Asked;
use crate::methods::registered::{Bundled, Registered};
use relume_formats::bundle::{Maps, expect_regions};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::{BrdfBasis, RegionImages};
use relume_formats::method::REGION_IMAGES;
use relume_formats::{Place, Result};
use relume_scenes::Scene;
use std::path::PathBuf;

/// See there.
pub const METHOD: Registered = Registered {
    card: &REGION_IMAGES,
    why: "light, view and shape stay, and materials take textures: a frame is a sum of what their regions send on",
    options: &[("--bases", |asked| asked.bases.is_some())],
    new: |asked, _: &Scene| Box::new(method(asked)),
    remedy: |_| "lower --max-error, or add --bases".to_owned(),
    verify,
    inspected: &[INSPECTED],
};

fn method(asked: &Asked) -> RegionImagesMethod {
    RegionImagesMethod(Settings {
        size: asked.size,
        samples: asked.samples.unwrap_or(asked.quality.samples()),
        seed: asked.seed,
        bases: asked.bases.map_or(BASES, |n| n as usize),
        max_error: asked.max_error,
        filter: asked.filter,
    })
}

fn verify(bundle: &Bundled<'_>, files: &[(Kind, PathBuf)]) -> Result<Maps> {
    if let [(_, basis), (_, images)] = files {
        let head = RegionImages::open(images)?.read(RegionImages::checked_head)?;
        expect_regions(&head, &BrdfBasis::read_file(basis)?, &bundle.scene.meta, &Place::file(images))?;
    }
    Ok(Maps::default())
}
