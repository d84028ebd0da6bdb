//! The cards of the methods: the one place that says what a method is called, what it lets vary, and which
//! files it has. Whoever chooses a method, plans a bake, checks a bundle or plays one reads it here.

mod card;
mod region_images;
mod sparse_transfer;
mod sphere_shadows;
mod transfer_images;
mod transfer_tensor;

pub use card::{Card, Count, Form, Materials, Variation};
pub use region_images::REGION_IMAGES;
pub use sparse_transfer::SPARSE_TRANSFER;
pub use sphere_shadows::SPHERE_SHADOWS;
pub use transfer_images::TRANSFER_IMAGES;
pub use transfer_tensor::TRANSFER_TENSOR;

use crate::error::{Error, Place, Result};
use crate::near::did_you_mean;

/// All methods, the one whose frames cost least first.
pub const CARDS: [&Card; 4] = [&TRANSFER_IMAGES, &SPARSE_TRANSFER, &TRANSFER_TENSOR, &SPHERE_SHADOWS];

impl Card {
    /// The card of the method called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        CARDS.into_iter().find(|card| card.name == name)
    }
}

/// The cards of the methods called `names`, in their order: none of them twice, and none that lies over
/// another without one below it.
///
/// # Errors
/// `Unsupported` for a name that is no method's, with the one that may be meant; `Invalid` for an order that
/// cannot be played.
pub fn cards_of<'a>(names: impl IntoIterator<Item = &'a str>, place: &Place) -> Result<Vec<&'static Card>> {
    let mut cards: Vec<&'static Card> = Vec::new();
    for name in names {
        let Some(card) = Card::find(name) else {
            let meant = did_you_mean(name, CARDS.into_iter().map(|card| card.name));
            return Err(Error::unsupported(
                place,
                format!("method `{name}` is unknown to this program{meant}; use a newer one"),
            ));
        };
        expect_next(&cards, card, place)?;
        cards.push(card);
    }
    Ok(cards)
}

/// Fails if `card` may not come after `before`.
fn expect_next(before: &[&Card], card: &Card, place: &Place) -> Result<()> {
    let name = card.name;
    if before.iter().any(|other| other.name == name) {
        return Err(Error::invalid(place, format!("method `{name}` is there twice; bake it again")));
    }
    if card.lies_over && before.iter().all(|other| other.lies_over) {
        return Err(Error::invalid(
            place,
            format!("method `{name}` lies over another, which must come before it; bake both"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::Kind;
    use crate::kinds::manifest::FileEntry;

    fn fits(card: &Card, kinds: &[&str]) -> bool {
        let files: Vec<_> = kinds.iter().map(|kind| ((*kind).to_owned(), FileEntry::of("a", b""))).collect();
        card.expect_files(&files, &Place::file("manifest.json")).is_ok()
    }

    #[test]
    fn files_stand_in_the_order_in_which_they_are_needed() {
        let (e, t, shape, rows, shadows) =
            ("environment", "textures", "shape", "sparse-transfer", "sphere-shadows");
        assert!(fits(&TRANSFER_IMAGES, &["brdf-basis", "transfer-images"]));
        for wrong in [
            &["transfer-images", "brdf-basis"][..],
            &["brdf-basis"],
            &["transfer-images"],
            &["brdf-basis", "transfer-images", "shape"],
            &[],
        ] {
            assert!(!fits(&TRANSFER_IMAGES, wrong), "{wrong:?}");
        }
        assert!(fits(&SPARSE_TRANSFER, &[e, e, t, rows]) && fits(&SPARSE_TRANSFER, &[e, rows]));
        for wrong in [
            &[rows][..],
            &[t, rows],
            &[e, t, t, rows],
            &[t, e, rows],
            &[e, rows, rows],
            &[e, shape, rows],
            &[e, t],
            &[e, "magic", rows],
        ] {
            assert!(!fits(&SPARSE_TRANSFER, wrong), "{wrong:?}");
        }
        assert!(
            fits(&SPHERE_SHADOWS, &[e, t, shape, shape, shadows]) && fits(&SPHERE_SHADOWS, &[e, shadows])
        );
        assert!(!fits(&SPHERE_SHADOWS, &[e, shape, t, shadows]) && !fits(&SPHERE_SHADOWS, &[e, shape]));
    }

    #[test]
    fn every_method_can_be_found_and_played() {
        for card in CARDS {
            assert_eq!(Card::find(card.name), Some(card));
            assert_eq!(Kind::find(card.name), card.main(), "the main file is called as its method");
            assert!(card.main().is_some_and(|kind| card.first_piece < kind.max_sections()));
        }
    }

    #[test]
    fn what_includes_what() {
        let painted = Variation { materials: Materials::Painted, ..Variation::NONE };
        let all =
            Variation { light: true, view: true, materials: Materials::Painted, shape: true, media: true };
        assert!(
            painted.includes(&TRANSFER_IMAGES.lets_vary) && !TRANSFER_IMAGES.lets_vary.includes(&painted)
        );
        assert!(SPHERE_SHADOWS.lets_vary.includes(&SPARSE_TRANSFER.lets_vary));
        assert!(!SPARSE_TRANSFER.lets_vary.includes(&SPHERE_SHADOWS.lets_vary));
        for card in CARDS {
            assert!(
                all.includes(&card.lets_vary)
                    && card.lets_vary.includes(&Variation::NONE)
                    && !card.lets_vary.includes(&all)
            );
        }
    }

    #[test]
    fn orders_that_cannot_be_played_are_refused() {
        let place = Place::file("manifest.json");
        let names = |names: &[&str]| cards_of(names.iter().copied(), &place).map_err(|e| e.to_string());
        assert_eq!(
            names(&["sparse-transfer", "transfer-images"]),
            Ok(vec![&SPARSE_TRANSFER, &TRANSFER_IMAGES])
        );
        assert!(names(&["sparse-transfer", "sparse-transfer"]).unwrap_err().contains("twice"));
        assert!(names(&["sparse-transfr"]).unwrap_err().contains("did you mean `sparse-transfer`?"));
        let mirrors = Card { name: "mirrors", lies_over: true, ..TRANSFER_IMAGES };
        assert!(expect_next(&[], &mirrors, &place).unwrap_err().to_string().contains("must come before it"));
        expect_next(&[&SPARSE_TRANSFER], &mirrors, &place).unwrap();
    }
}
