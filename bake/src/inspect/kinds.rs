//! Where there is something to tell of a kind.

use crate::inspected::{Inspected, SHARED};
use crate::methods::choice::METHODS;
use crate::methods::region_images;
use relume_formats::container::Kind;
use relume_formats::{Error, Place, Result};

/// Everything that can be told, the methods' own kinds last; of region-images before it is a method to ask for.
fn all() -> impl Iterator<Item = &'static Inspected> {
    let methods = METHODS.into_iter().chain([&region_images::METHOD]);
    SHARED.iter().chain(methods.flat_map(|method| method.inspected))
}

/// What can be told of the file at `place`, which is of `kind`.
///
/// # Errors
/// `Unsupported` if that is nothing.
pub(super) fn find(kind: Kind, place: &Place) -> Result<&'static Inspected> {
    let reason =
        || format!("files of kind `{}` cannot be told of by this program; use a newer one", kind.name());
    all().find(|inspected| inspected.kind == kind).ok_or_else(|| Error::unsupported(place, reason()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_told_of_once() {
        for kind in Kind::ALL {
            assert_eq!(all().filter(|inspected| inspected.kind == kind).count(), 1, "{}", kind.name());
        }
        assert_eq!(all().count(), Kind::ALL.len());
    }
}
