//! Which files a method has, and what the manifest calls them.

use super::refuse;
use crate::container::Kind;
use crate::error::{Place, Result};
use crate::kinds::manifest::FileEntry;

/// Fails unless these are the `files` of the method whose main file is of kind `method`, in the order in which a player needs them: each with its kind, as
/// the manifest lists them.
pub fn expect_files(method: Kind, files: &[(String, FileEntry)], place: &Place) -> Result<()> {
    let mut rest = files.iter().map(|(kind, _)| kind.as_str()).peekable();
    let mut count = |kind: Kind| std::iter::from_fn(|| rest.next_if_eq(&kind.name())).count();
    let (fits, expected) = match method {
        Kind::TransferImages => (count(Kind::BrdfBasis) == 1, "brdf-basis, transfer-images"),
        Kind::SparseTransfer => {
            (count(Kind::Environment) > 0 && count(Kind::Textures) < 2, "environments, perhaps textures, and sparse-transfer")
        }
        _ => {
            let fits = count(Kind::Environment) > 0 && count(Kind::Textures) < 2;
            let _shapes = count(Kind::Shape);
            (fits, "environments, perhaps textures, a shape for each object that deforms, and sphere-shadows")
        }
    };
    if fits && count(method) == 1 && rest.next().is_none() {
        return Ok(());
    }
    refuse(place, format!("its files are not {expected}, in this order"))
}

/// Fails unless the file at `place`, whose content is called `name`, is listed by that name.
pub fn expect_name(name: &str, listed: &str, place: &Place) -> Result<()> {
    if name == listed {
        return Ok(());
    }
    refuse(place, format!("holds `{name}`, the manifest lists `{listed}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stand_in_the_order_in_which_they_are_needed() {
        let fits = |method: Kind, kinds: &[&str]| {
            let files: Vec<_> = kinds.iter().map(|kind| ((*kind).to_owned(), FileEntry::of("a", b""))).collect();
            expect_files(method, &files, &Place::file("manifest.json")).is_ok()
        };
        let (e, t, shape, rows, shadows) = ("environment", "textures", "shape", "sparse-transfer", "sphere-shadows");
        assert!(fits(Kind::TransferImages, &["brdf-basis", "transfer-images"]));
        for wrong in [
            &["transfer-images", "brdf-basis"][..],
            &["brdf-basis"],
            &["transfer-images"],
            &["brdf-basis", "transfer-images", "shape"],
            &[],
        ] {
            assert!(!fits(Kind::TransferImages, wrong), "{wrong:?}");
        }
        assert!(fits(Kind::SparseTransfer, &[e, e, t, rows]) && fits(Kind::SparseTransfer, &[e, rows]));
        for wrong in
            [&[rows][..], &[t, rows], &[e, t, t, rows], &[t, e, rows], &[e, rows, rows], &[e, shape, rows], &[e, t], &[e, "magic", rows]]
        {
            assert!(!fits(Kind::SparseTransfer, wrong), "{wrong:?}");
        }
        assert!(fits(Kind::SphereShadows, &[e, t, shape, shape, shadows]) && fits(Kind::SphereShadows, &[e, shadows]));
        assert!(!fits(Kind::SphereShadows, &[e, shape, t, shadows]) && !fits(Kind::SphereShadows, &[e, shape]));
    }
}
