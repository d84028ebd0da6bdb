//! The cards of the methods: the one place that says what a method is called, what it lets vary, and which files it has. Whoever chooses a method, plans a
//! bake, checks a bundle or plays one reads it here.

use crate::container::Kind;
use crate::error::{Error, Place, Result};
use crate::kinds::manifest::FileEntry;
use crate::kinds::{sparse_transfer, transfer_images};
use crate::near::did_you_mean;

/// All methods, the one whose frames cost least first.
pub const CARDS: [&Card; 3] = [&TRANSFER_IMAGES, &SPARSE_TRANSFER, &SPHERE_SHADOWS];

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
    ],
    sphere_sets: false,
    lies_over: false,
};
/// The environment and the view vary: rows of Haar coefficients at vertices.
pub const SPARSE_TRANSFER: Card = Card {
    name: "sparse-transfer",
    lets_vary: Variation { light: true, view: true, ..Variation::NONE },
    files: &[(Kind::Environment, Count::Some), (Kind::Textures, Count::Perhaps), (Kind::SparseTransfer, Count::One)],
    // Behind the meta.
    first_piece: sparse_transfer::BLOCK_SECTIONS,
    settings: &[("revision", Form::Count), ("rays_per_texel", Form::Count), ("terms", Form::Count), ("max_error", Form::Positive)],
    sphere_sets: false,
    lies_over: false,
};
/// The environment, the view and shapes vary: spheres cast the shadows.
pub const SPHERE_SHADOWS: Card = Card {
    name: "sphere-shadows",
    lets_vary: Variation { light: true, view: true, shape: true, ..Variation::NONE },
    files: &[
        (Kind::Environment, Count::Some),
        (Kind::Textures, Count::Perhaps),
        (Kind::Shape, Count::Any),
        (Kind::SphereShadows, Count::One),
    ],
    // The order of terms, without which no lobe can be cut.
    first_piece: 4,
    settings: &[("revision", Form::Count), ("objects", Form::Objects), ("seed", Form::Count)],
    sphere_sets: true,
    lies_over: false,
};

/// What there is to say of a method without doing it.
#[derive(Debug, PartialEq, Eq)]
pub struct Card {
    /// Its name in manifests and on the command line.
    pub name: &'static str,
    /// What it lets vary at playback.
    pub lets_vary: Variation,
    /// The kinds of its files in the order in which a player needs them, the main one last; none if nothing is baked for it.
    pub files: &'static [(Kind, Count)],
    /// Index of the section of the main file with which the first piece is complete that a player can show.
    pub first_piece: usize,
    /// The settings that change its results, as manifests list them.
    pub settings: &'static [(&'static str, Form)],
    /// Whether it plays with the sphere sets of the scene's objects, which then come before its own files.
    pub sphere_sets: bool,
    /// Whether it adds to the picture of another method, which a bundle must then hold, too, and before it.
    pub lies_over: bool,
}

/// What a setting is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A whole number of at least 0.
    Count,
    /// A number above 0.
    Positive,
    /// Width and height.
    Size,
    /// 32 hexadecimal digits.
    Hash,
    /// Names of objects, each with a number of spheres or null.
    Objects,
}

/// How often a kind occurs among the files of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// Once.
    One,
    /// Once or not at all.
    Perhaps,
    /// At least once.
    Some,
    /// Any number of times.
    Any,
}

/// What varies at playback: what a method lets vary, or what a scene asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variation {
    /// The environment.
    pub light: bool,
    /// The camera.
    pub view: bool,
    /// Materials.
    pub materials: Materials,
    /// Shapes, by clips.
    pub shape: bool,
    /// What light goes through.
    pub media: bool,
}

/// How materials vary; each of these includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Materials {
    /// Not at all.
    Fixed,
    /// Each as a whole.
    Whole,
    /// Differently from point to point.
    Painted,
}

impl Variation {
    /// Nothing varies.
    pub const NONE: Self = Self { light: false, view: false, materials: Materials::Fixed, shape: false, media: false };

    /// Whether this includes all that `other` has.
    pub fn includes(&self, other: &Self) -> bool {
        self.materials >= other.materials
            && [(self.light, other.light), (self.view, other.view), (self.shape, other.shape), (self.media, other.media)]
                .into_iter()
                .all(|(ours, theirs)| ours || !theirs)
    }
}

impl Card {
    /// The card of the method called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        CARDS.into_iter().find(|card| card.name == name)
    }

    /// The kind of the main file, which comes last and arrives piece by piece; `None` for a method that nothing is baked for.
    pub fn main(&self) -> Option<Kind> {
        self.files.last().map(|(kind, _)| *kind)
    }

    /// Fails unless these are the `files` of the method, in order, each with its kind as the manifest lists them.
    ///
    /// # Errors
    /// `Invalid` with the order that is right.
    pub fn expect_files(&self, files: &[(String, FileEntry)], place: &Place) -> Result<()> {
        let mut rest = files.iter().map(|(kind, _)| kind.as_str()).peekable();
        let fits = self.files.iter().all(|(kind, expected)| {
            let count = std::iter::from_fn(|| rest.next_if_eq(&kind.name())).count();
            match expected {
                Count::One => count == 1,
                Count::Perhaps => count < 2,
                Count::Some => count > 0,
                Count::Any => true,
            }
        });
        if fits && rest.next().is_none() {
            return Ok(());
        }
        let list: Vec<String> = self.files.iter().map(|(kind, count)| count.words(*kind)).collect();
        Err(Error::invalid(place, format!("its files are not {}, in this order; bake the whole bundle again", list.join(", "))))
    }
}

impl Count {
    fn words(self, kind: Kind) -> String {
        let name = kind.name();
        match self {
            Self::One => name.to_owned(),
            Self::Perhaps => format!("perhaps {name}"),
            Self::Some => format!("one or more {name}"),
            Self::Any => format!("any number of {name}"),
        }
    }
}

/// The cards of the methods called `names`, in their order: none of them twice, and none that lies over another without one below it.
///
/// # Errors
/// `Unsupported` for a name that is no method's, with the one that may be meant; `Invalid` for an order that cannot be played.
pub fn cards_of<'a>(names: impl IntoIterator<Item = &'a str>, place: &Place) -> Result<Vec<&'static Card>> {
    let mut cards: Vec<&'static Card> = Vec::new();
    for name in names {
        let Some(card) = Card::find(name) else {
            let meant = did_you_mean(name, CARDS.into_iter().map(|card| card.name));
            return Err(Error::unsupported(place, format!("method `{name}` is unknown to this program{meant}; use a newer one")));
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
        return Err(Error::invalid(place, format!("method `{name}` lies over another, which must come before it; bake both")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fits(card: &Card, kinds: &[&str]) -> bool {
        let files: Vec<_> = kinds.iter().map(|kind| ((*kind).to_owned(), FileEntry::of("a", b""))).collect();
        card.expect_files(&files, &Place::file("manifest.json")).is_ok()
    }

    #[test]
    fn files_stand_in_the_order_in_which_they_are_needed() {
        let (e, t, shape, rows, shadows) = ("environment", "textures", "shape", "sparse-transfer", "sphere-shadows");
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
        for wrong in
            [&[rows][..], &[t, rows], &[e, t, t, rows], &[t, e, rows], &[e, rows, rows], &[e, shape, rows], &[e, t], &[e, "magic", rows]]
        {
            assert!(!fits(&SPARSE_TRANSFER, wrong), "{wrong:?}");
        }
        assert!(fits(&SPHERE_SHADOWS, &[e, t, shape, shape, shadows]) && fits(&SPHERE_SHADOWS, &[e, shadows]));
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
        let all = Variation { light: true, view: true, materials: Materials::Painted, shape: true, media: true };
        assert!(painted.includes(&TRANSFER_IMAGES.lets_vary) && !TRANSFER_IMAGES.lets_vary.includes(&painted));
        assert!(SPHERE_SHADOWS.lets_vary.includes(&SPARSE_TRANSFER.lets_vary));
        assert!(!SPARSE_TRANSFER.lets_vary.includes(&SPHERE_SHADOWS.lets_vary));
        for card in CARDS {
            assert!(all.includes(&card.lets_vary) && card.lets_vary.includes(&Variation::NONE) && !card.lets_vary.includes(&all));
        }
    }

    #[test]
    fn orders_that_cannot_be_played_are_refused() {
        let place = Place::file("manifest.json");
        let names = |names: &[&str]| cards_of(names.iter().copied(), &place).map_err(|e| e.to_string());
        assert_eq!(names(&["sparse-transfer", "transfer-images"]), Ok(vec![&SPARSE_TRANSFER, &TRANSFER_IMAGES]));
        assert!(names(&["sparse-transfer", "sparse-transfer"]).unwrap_err().contains("twice"));
        assert!(names(&["sparse-transfr"]).unwrap_err().contains("did you mean `sparse-transfer`?"));
        let mirrors = Card { name: "mirrors", lies_over: true, ..TRANSFER_IMAGES };
        assert!(expect_next(&[], &mirrors, &place).unwrap_err().to_string().contains("must come before it"));
        expect_next(&[&SPARSE_TRANSFER], &mirrors, &place).unwrap();
    }
}
