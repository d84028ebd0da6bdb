//! The card of `transfer-images`.

use super::card::{Card, Count, Form, Materials, Variation};
use crate::container::Kind;
use crate::kinds::transfer_images;

/// Materials of whole objects vary: sums of baked images (thesis §4.1).
pub const TRANSFER_IMAGES: Card = Card {
    name: "transfer-images",
    lets_vary: Variation { materials: Materials::Whole, ..Variation::NONE },
    files: &[(Kind::BrdfBasis, Count::One), (Kind::TransferImages, Count::One)],
    first_piece: transfer_images::HEAD_SECTIONS,
    settings: &[
        ("revision", Form::Count),
        ("size", Form::Size),
        ("samples", Form::Count),
        ("seed", Form::Count),
        ("bases", Form::Count),
        ("max_error", Form::Positive),
        ("filter", Form::Text),
        ("noise", Form::Positive),
        ("mean_samples", Form::Positive),
    ],
    sphere_sets: false,
    lies_over: false,
};
