//! The card of `transfer-tensor`.

use super::card::{Card, Count, Form, Materials, Variation};
use crate::container::Kind;
use crate::kinds::transfer_tensor;

/// The environment, the view and the materials of whole objects vary together: tensors at vertices (thesis §5).
pub const TRANSFER_TENSOR: Card = Card {
    name: "transfer-tensor",
    lets_vary: Variation { light: true, view: true, materials: Materials::Whole, ..Variation::NONE },
    files: &[
        (Kind::Environment, Count::Some),
        (Kind::Textures, Count::Perhaps),
        (Kind::BrdfTensor, Count::Some),
        (Kind::BrdfBasis, Count::Any),
        (Kind::TransferTensor, Count::One),
    ],
    // Behind the meta, with what is seen.
    first_piece: transfer_tensor::BLOCK_SECTIONS + 1,
    settings: &[
        ("revision", Form::Count),
        ("rays_per_texel", Form::Count),
        ("samples", Form::Count),
        ("seed", Form::Count),
        ("terms", Form::Count),
        ("max_error", Form::Positive),
    ],
    sphere_sets: false,
    lies_over: false,
};
