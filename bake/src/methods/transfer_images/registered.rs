//! The method's line in the registry.

use super::held_out::CHOICE;
use super::inspected::INSPECTED;
use super::settings::{Bases, TransferImagesMethod};
use crate::methods::asked::Asked;
use crate::methods::registered::{Bundled, Registered, more_of};
use relume_formats::bundle::{Maps, expect_images};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::method::TRANSFER_IMAGES;
use relume_formats::{Place, Result};
use relume_scenes::Scene;
use std::path::PathBuf;

/// See there.
pub const METHOD: Registered = Registered {
    card: &TRANSFER_IMAGES,
    why: "light, view and shape stay, so a frame is a sum of baked images, which costs least",
    options: &[("--bases", |asked| asked.bases.is_some()), ("--noise", |asked| asked.noise.is_some())],
    new: |asked, _: &Scene| Box::new(method(asked)),
    remedy: |settings| more_of(settings, "bases", |n| n + 1, *CHOICE.end() as u64),
    verify,
    inspected: &[INSPECTED],
};

fn method(asked: &Asked) -> TransferImagesMethod {
    TransferImagesMethod {
        size: asked.size,
        samples: asked.samples.unwrap_or(asked.quality.samples()),
        seed: asked.seed,
        bases: asked.bases.map_or(Bases::Error(asked.max_error), |n| Bases::Number(n as usize)),
        filter: asked.filter,
        noise: asked.noise,
    }
}

fn verify(bundle: &Bundled<'_>, files: &[(Kind, PathBuf)]) -> Result<Maps> {
    if let [(_, basis), (_, images)] = files {
        let head = TransferImages::open(images)?.read(TransferImages::checked_head)?;
        expect_images(&head, &BrdfBasis::read_file(basis)?, &bundle.scene.meta, &Place::file(images))?;
        bundle.settings.expect_images(&head.meta)?;
    }
    Ok(Maps::default())
}
