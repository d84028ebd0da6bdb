//! The card of `sphere-shadows`.

use super::card::{Card, Count, Form, Variation};
use crate::container::Kind;

/// The environment, the view and shapes vary: spheres and triangles of the meshes cast the shadows.
pub const SPHERE_SHADOWS: Card = Card {
    name: "sphere-shadows",
    lets_vary: Variation { light: true, view: true, shape: true, ..Variation::NONE },
    files: &[
        (Kind::Environment, Count::Some),
        (Kind::Textures, Count::Perhaps),
        (Kind::Shape, Count::Any),
        (Kind::SphereShadows, Count::One),
    ],
    // The last: all of it is needed.
    first_piece: 7,
    settings: &[
        ("revision", Form::Count),
        ("objects", Form::Objects),
        ("seed", Form::Count),
        ("max_error", Form::Positive),
        ("casters", Form::Text),
        ("casts", Form::Casters),
    ],
    sphere_sets: true,
    lies_over: false,
};
