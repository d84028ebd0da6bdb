//! The card of `sparse-transfer`.

use super::card::{Card, Count, Form, Variation};
use crate::container::Kind;
use crate::kinds::sparse_transfer;

/// The environment and the view vary: rows of Haar coefficients at vertices.
pub const SPARSE_TRANSFER: Card = Card {
    name: "sparse-transfer",
    lets_vary: Variation { light: true, view: true, ..Variation::NONE },
    files: &[
        (Kind::Environment, Count::Some),
        (Kind::Textures, Count::Perhaps),
        (Kind::SparseTransfer, Count::One),
    ],
    // Behind the meta.
    first_piece: sparse_transfer::BLOCK_SECTIONS,
    settings: &[
        ("revision", Form::Count),
        ("rays_per_texel", Form::Count),
        ("terms", Form::Count),
        ("max_error", Form::Positive),
    ],
    sphere_sets: false,
    lies_over: false,
};
