//! Environment maps from the user's own files. They are called by their absolute paths, so that no name of a
//! bundle is in the way, and so that a state that is saved finds them again.

use relume_formats::kinds::Environment;
use relume_formats::map_file::{is_named_so, read_map};
use relume_formats::name::one_line;
use relume_formats::{Error, Place, Result};
use std::io::Write as _;
use std::path::Path;

/// Reads the map at `path`; tells on stderr what was mended.
///
/// # Errors
/// Those of [`read_map`], and `Invalid` for what is brighter than maps may be, and for paths that are no
/// text.
pub fn read(path: &Path) -> Result<Environment> {
    let place = Place::file(path);
    let mut warnings = Vec::new();
    let map = read_map(path, &mut warnings)?;
    // Nobody listening is no reason to fail.
    warnings.iter().for_each(|warning| drop(writeln!(std::io::stderr(), "warning: {}", one_line(warning))));
    let absolute = std::path::absolute(path).map_err(|e| Error::io(&place, e))?;
    let name =
        absolute.to_str().ok_or_else(|| Error::invalid(&place, "its path is no UTF-8 text; rename it"))?;
    let environment = Environment::kept(name.to_owned(), &map);
    environment.validate_map(&place)?;
    Ok(environment)
}

/// The map that the state or animation at `place` calls `name`, if that is a file, relative to theirs.
///
/// # Errors
/// Those of [`read`].
pub fn beside(name: &str, place: &Place) -> Result<Option<Environment>> {
    let path = place.file.parent().unwrap_or(Path::new("")).join(name);
    if !is_named_so(&path) || !path.exists() {
        return Ok(None);
    }
    read(&path).map(Some)
}

/// What to show of the name of a map: of a path the file.
pub fn short_name(name: &str) -> String {
    let path = Path::new(name);
    match path.file_name() {
        Some(file) if path.is_absolute() => format!("{} (file)", file.to_string_lossy()),
        _ => name.to_owned(),
    }
}
