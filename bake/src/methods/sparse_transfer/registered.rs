//! The method's line in the registry.

use super::inspected::INSPECTED;
use super::method::SparseTransferMethod;
use super::rows::MAX_TERMS;
use super::settings::{Settings, Terms};
use crate::methods::asked::Asked;
use crate::methods::environment_lit;
use crate::methods::registered::{Bundled, Registered, more_of};
use relume_formats::bundle::{Maps, expect_lit};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::SparseTransfer;
use relume_formats::method::SPARSE_TRANSFER;
use relume_formats::{Place, Result};
use std::path::PathBuf;

/// More rays than that a texel show nothing new.
const MAX_RAYS_PER_TEXEL: u32 = 256;

/// See there.
pub const METHOD: Registered = Registered {
    card: &SPARSE_TRANSFER,
    why: "light or view varies while shapes stay, and no cheaper method follows a light or a camera",
    options: &[("--terms", |asked| asked.terms.is_some())],
    new: |asked, _| Box::new(method(asked)),
    remedy: |settings| more_of(settings, "terms", |n| 2 * n, MAX_TERMS as u64),
    verify,
    inspected: &[INSPECTED],
};

fn method(asked: &Asked) -> SparseTransferMethod {
    let rays = asked.samples.unwrap_or(asked.quality.rays_per_texel()).min(MAX_RAYS_PER_TEXEL);
    let side = (1..).find(|side| side * side >= rays).unwrap_or(1);
    let terms = asked.terms.map_or(Terms::Error(asked.max_error), |n| Terms::Number(n as usize));
    SparseTransferMethod { settings: Settings { rays_per_texel: side * side, terms } }
}

fn verify(bundle: &Bundled<'_>, files: &[(Kind, PathBuf)]) -> Result<Maps> {
    environment_lit::verify(bundle, files, |_, path, lit| {
        let meta = SparseTransfer::open(path)?.read(SparseTransfer::checked_meta)?;
        expect_lit("rows", meta.vertices.into(), bundle.scene, &lit.maps, lit.textured, &Place::file(path))?;
        bundle.settings.expect_rows(&meta)
    })
}
