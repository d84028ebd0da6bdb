//! All methods, and which one bakes a scene unless the user says otherwise.

use super::registered::{Registered, variation};
use relume_formats::method::{Materials, Variation};
use relume_scenes::Vary;

/// All methods, a line each, in the order of their cards: the one whose frames cost least first.
pub const METHODS: [&Registered; 4] = [
    &super::transfer_images::METHOD,
    &super::sparse_transfer::METHOD,
    &super::transfer_tensor::METHOD,
    &super::sphere_shadows::METHOD,
];

impl Registered {
    /// The method called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        METHODS.into_iter().find(|method| method.card.name == name)
    }
}

/// The cheapest method that serves whatever varies; where none does, with textures as whole materials; where none does
/// that either, light, view and shape.
pub fn cheapest(vary: &Vary) -> &'static Registered {
    let all = variation(vary);
    let whole = Variation { materials: all.materials.min(Materials::Whole), ..all };
    let moves = Variation { materials: Materials::Fixed, ..all };
    let serving = |wanted: Variation| METHODS.into_iter().find(|m| m.card.lets_vary.includes(&wanted));
    let [.., last] = METHODS;
    [all, whole, moves].into_iter().find_map(serving).unwrap_or(last)
}

#[cfg(test)]
mod tests {
    use super::super::{sphere_shadows, transfer_images};
    use super::*;
    use relume_formats::method::CARDS;

    #[test]
    fn the_cheapest_that_serves_what_moves_is_chosen() {
        use relume_formats::method::{SPARSE_TRANSFER, SPHERE_SHADOWS, TRANSFER_IMAGES, TRANSFER_TENSOR};
        let vary = |light, view, shape, materials: &[usize]| Vary {
            light,
            view,
            shape,
            materials: materials.to_vec(),
            ..Vary::default()
        };
        let cases = [
            (vary(false, false, false, &[0]), TRANSFER_IMAGES, true),
            (vary(false, false, false, &[]), TRANSFER_IMAGES, true),
            (vary(true, false, false, &[]), SPARSE_TRANSFER, true),
            (vary(false, true, false, &[]), SPARSE_TRANSFER, true),
            (vary(true, true, false, &[0, 1]), TRANSFER_TENSOR, true),
            (vary(false, true, false, &[3]), TRANSFER_TENSOR, true),
            (vary(false, false, true, &[]), SPHERE_SHADOWS, true),
            (vary(true, true, true, &[]), SPHERE_SHADOWS, true),
            (vary(false, false, true, &[2]), SPHERE_SHADOWS, false),
        ];
        for (vary, expected, all) in cases {
            assert_eq!(
                (cheapest(&vary).card, cheapest(&vary).serves_all(&vary)),
                (&expected, all),
                "{vary:?}"
            );
        }
        for (light, expected) in [(false, TRANSFER_IMAGES), (true, TRANSFER_TENSOR)] {
            let painted = Vary { painted: vec![1], ..vary(light, false, false, &[0, 1]) };
            assert_eq!(
                (cheapest(&painted).card, cheapest(&painted).serves_all(&painted)),
                (&expected, false)
            );
        }
        assert!(!transfer_images::METHOD.serves_all(&vary(true, false, false, &[0])));
        assert!(sphere_shadows::METHOD.serves_all(&vary(true, true, false, &[])));
        assert_eq!(METHODS.map(|method| method.card), CARDS, "both in one order");
    }
}
