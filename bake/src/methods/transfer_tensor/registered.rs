//! The method's line in the registry.

use super::RAYS;
use super::inspected::INSPECTED;
use super::method::TransferTensorMethod;
use super::rows::MAX_TERMS;
use super::settings::Settings;
use crate::methods::asked::{Asked, Quality};
use crate::methods::environment_lit;
use crate::methods::registered::{Bundled, Registered, more_of};
use crate::methods::sparse_transfer::Terms;
use relume_formats::bundle::{Maps, expect_lit, expect_spaces};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::{BrdfBasis, BrdfTensor, TransferTensor};
use relume_formats::method::TRANSFER_TENSOR;
use relume_formats::{Place, Result};
use std::path::PathBuf;

/// More rays than that a texel show nothing new.
const MAX_RAYS_PER_TEXEL: u32 = 256;

/// See there.
pub const METHOD: Registered = Registered {
    card: &TRANSFER_TENSOR,
    why: "light or view varies together with materials, which no other method serves",
    options: &[("--terms", |asked| asked.terms.is_some())],
    new: |asked, _| Box::new(method(asked)),
    remedy: |settings| {
        let more = more_of(settings, "terms", |n| 2 * n, MAX_TERMS as u64);
        format!("{more}, which is for direct light alone: `bake info` tells what errs")
    },
    verify,
    inspected: &[INSPECTED],
};

fn method(asked: &Asked) -> TransferTensorMethod {
    let rays = asked.samples.unwrap_or(asked.quality.rays_per_texel()).min(MAX_RAYS_PER_TEXEL);
    let side = (1..).find(|side| side * side >= rays).unwrap_or(1);
    let samples = match asked.quality {
        Quality::Draft => RAYS / 4,
        Quality::Preview => RAYS,
        Quality::Final => 4 * RAYS,
    };
    let terms =
        asked.terms.map_or(Terms::Error(asked.max_error), |n| Terms::Number((n as usize).min(MAX_TERMS)));
    TransferTensorMethod {
        settings: Settings { rays_per_texel: side * side, samples, seed: asked.seed, terms },
    }
}

fn verify(bundle: &Bundled<'_>, files: &[(Kind, PathBuf)]) -> Result<Maps> {
    let (mut spaces, mut bases) = (Vec::new(), Vec::new());
    environment_lit::verify(bundle, files, |kind, path, lit| {
        match kind {
            Kind::BrdfTensor => spaces.push(BrdfTensor::read_file(path)?),
            Kind::BrdfBasis => bases.push(BrdfBasis::read_file(path)?),
            _ => {
                let place = Place::file(path);
                let meta = TransferTensor::open(path)?.read(TransferTensor::checked_meta)?;
                expect_lit("tensors", meta.vertices.into(), bundle.scene, &lit.maps, lit.textured, &place)?;
                expect_spaces(&meta, &spaces, &bases, &bundle.scene.meta, &place)?;
                bundle.settings.expect_tensors(&meta)?;
            }
        }
        Ok(())
    })
}
