//! What a card says.

use crate::container::Kind;
use crate::error::{Error, Place, Result};
use crate::kinds::manifest::FileEntry;

/// What there is to say of a method without doing it.
#[derive(Debug, PartialEq, Eq)]
pub struct Card {
    /// Its name in manifests and on the command line.
    pub name: &'static str,
    /// What it lets vary at playback.
    pub lets_vary: Variation,
    /// The kinds of its files in the order in which a player needs them, the main one last; none if nothing
    /// is baked for it.
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
    /// A text.
    Text,
    /// Names of objects, each with a text that says what it casts shadows by.
    Casters,
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
    pub const NONE: Self =
        Self { light: false, view: false, materials: Materials::Fixed, shape: false, media: false };

    /// Whether this includes all that `other` has.
    pub fn includes(&self, other: &Self) -> bool {
        self.materials >= other.materials
            && [
                (self.light, other.light),
                (self.view, other.view),
                (self.shape, other.shape),
                (self.media, other.media),
            ]
            .into_iter()
            .all(|(ours, theirs)| ours || !theirs)
    }
}

impl Card {
    /// The kind of the main file, which comes last and arrives piece by piece; `None` for a method that
    /// nothing is baked for.
    pub fn main(&self) -> Option<Kind> {
        self.files.last().map(|(kind, _)| *kind)
    }

    /// Fails unless these are the `files` of the method, in order, each with its kind as the manifest lists
    /// them.
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
        Err(Error::invalid(
            place,
            format!("its files are not {}, in this order; bake the whole bundle again", list.join(", ")),
        ))
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
