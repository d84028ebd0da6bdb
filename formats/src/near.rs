//! What was meant by a name that is not there.

use crate::name::shortened;
use std::path::{Path, PathBuf};

/// Most files of a folder that are looked at.
const MAX_FILES: usize = 10_000;

/// Longest name that is compared, bytes.
const MAX_COMPARED: usize = 256;

/// As many names as anybody would read are listed.
const MOST_LISTED: usize = 20;

/// The one of `known` that is so like `given` that it was meant: but for capitals, a few letters, or the rest
/// of the name.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let small = given.to_lowercase();
    let distance = |name: &str| {
        let name = name.to_lowercase();
        let letters = strsim::damerau_levenshtein(&small, &name);
        let part = small.len() >= 3 && (name.starts_with(&small) || name.ends_with(&small));
        (letters <= 1 + given.len() / 3 || part).then_some((letters, part))
    };
    // Comparing takes the product of two lengths, so that what is too long for a name is near to none.
    let near = known
        .into_iter()
        .filter(|name| name.len() <= MAX_COMPARED)
        .filter_map(|name| Some((distance(name)?, name)));
    if given.len() > MAX_COMPARED { None } else { near.min().map(|(_, name)| name) }
}

/// "; did you mean `bunny`?", or nothing if no name is near.
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(given, known).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}

/// The end of a message that `given` is not among `known`: what was meant, and all that there is.
pub fn what_there_is(given: &str, known: &[&str]) -> String {
    let list: Vec<String> =
        known.iter().take(MOST_LISTED).map(|name| format!("`{}`", shortened(name))).collect();
    let more = known.len().saturating_sub(MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    match did_you_mean(given, known.iter().copied()).as_str() {
        "" => format!("; there are: {}{more}", list.join(", ")),
        meant => format!("{meant} There are: {}{more}", list.join(", ")),
    }
}

/// The file that was meant by `name`, a path from `folder`, in which some folder or the file is misspelt;
/// `None` if nothing there is like it.
pub fn nearest_file(folder: &Path, name: &Path) -> Option<String> {
    let (mut there, mut meant) = (folder.to_path_buf(), PathBuf::new());
    for component in name.components() {
        let given = Path::new(&component);
        let found = if there.join(given).exists() {
            given.to_path_buf()
        } else {
            nearest_in(&there, given.to_str()?)?
        };
        there.push(&found);
        meant.push(&found);
    }
    Some(meant.to_str()?.to_owned()).filter(|meant| Path::new(meant) != name)
}

fn nearest_in(folder: &Path, name: &str) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let files = std::fs::read_dir(folder).ok()?.take(MAX_FILES).filter_map(Result::ok);
    let mut names: Vec<String> = files.filter_map(|file| file.file_name().into_string().ok()).collect();
    names.sort();
    nearest(name, names.iter().map(String::as_str)).map(PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capitals_letters_and_beginnings_are_forgiven() {
        let known = ["position", "target", "fov_deg", "base_color", "kd", "ks"];
        for (given, expected) in [
            ("Position", Some("position")),
            ("postion", Some("position")),
            ("fov", Some("fov_deg")),
            ("color", Some("base_color")),
            ("KD", Some("kd")),
            ("aperture", None),
            ("", None),
        ] {
            assert_eq!(nearest(given, known), expected, "{given}");
        }
        assert_eq!(
            (did_you_mean("traget", known), did_you_mean("x_y_z", known)),
            ("; did you mean `target`?".to_owned(), String::new())
        );
    }

    #[test]
    fn misspelt_folders_and_files_are_found() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("Maps")).unwrap();
        std::fs::write(folder.path().join("Maps/Studio.exr"), "").unwrap();
        let near = |name: &str| nearest_file(folder.path(), Path::new(name));
        for given in ["maps/studio.exr", "Maps/studio.hdr", "Map/Studo.exr"] {
            assert_eq!(near(given), Some("Maps/Studio.exr".to_owned()), "{given}");
        }
        assert_eq!((near("Maps/sky.exr"), near("Maps/Studio.exr")), (None, None));
        let absolute = folder.path().join("maps/studio.exr");
        assert_eq!(
            nearest_file(Path::new(""), &absolute),
            Some(folder.path().join("Maps/Studio.exr").to_str().unwrap().to_owned())
        );
    }
}
