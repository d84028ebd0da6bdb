//! The card of `region-images`.

use super::card::{Card, Count, Form, Materials, Variation};
use crate::container::Kind;
use crate::kinds::region_images;

/// Materials vary from point to point: sums of what the regions of surfaces send on (thesis §4.2).
pub const REGION_IMAGES: Card = Card {
    name: "region-images",
    lets_vary: Variation { materials: Materials::Painted, ..Variation::NONE },
    files: &[(Kind::BrdfBasis, Count::One), (Kind::RegionImages, Count::One)],
    first_piece: region_images::HEAD_SECTIONS,
    settings: &[
        ("revision", Form::Count),
        ("size", Form::Size),
        ("samples", Form::Count),
        ("seed", Form::Count),
        ("bases", Form::Count),
        ("components", Form::Count),
        ("max_error", Form::Positive),
        ("filter", Form::Text),
    ],
    sphere_sets: false,
    lies_over: false,
};
