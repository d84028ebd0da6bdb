//! The gallery: a chart, a picture and the figures of each scene, and a page that shows them all.
//!
//! * [`changes`]: what differs from the figures that stood there before;
//! * [`page`]: the page, made from the figures alone.

pub mod changes;
pub mod page;

use crate::figures::{Chart, JSON, PICTURE, SVG};
use relume_bake::error::{BakeError, Result};
use relume_bake::job::say;
use relume_bake::output::create_folder;
use relume_formats::container::replace_file;
use relume_formats::kinds::manifest::is_plain_name;
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use std::path::{Path, PathBuf};

/// The page.
const PAGE: &str = "README.md";

/// Makes the charts of `scenes` with `chart`, which returns the folder that it left one in, puts them into
/// the gallery in `folder`, and writes its page anew after each; what it returns says what changed.
///
/// # Errors
/// What `chart` returns, or if a file of a chart or of the gallery cannot be read or written.
pub fn make(
    scenes: &[String],
    folder: &Path,
    mut chart: impl FnMut(&str) -> Result<PathBuf>,
) -> Result<String> {
    let mut text = String::new();
    for scene in scenes {
        let published = chart(scene).and_then(|from| publish(&from, folder));
        // What has changed already would not be told again.
        text += &published.inspect_err(|_| say(text.trim_end()))?;
        write_page(folder)?;
    }
    text += &format!("{}\n", write_page(folder)?.display());
    Ok(text)
}

/// The scenes of the library that can be charted; says on stderr why others cannot: `fits` refuses them, or
/// an asset is not there.
///
/// # Errors
/// If there is no library, or one of its scenes is broken.
pub fn scenes(fits: impl Fn(&Scene) -> Result<()>) -> Result<Vec<String>> {
    let mut names = relume_scenes::library()?;
    let mut broken = Ok(());
    names.retain(|name| match look_at(name, &fits) {
        Ok(None) => true,
        Ok(Some(reason)) => {
            say(&format!("{name} is left out: {reason}"));
            false
        }
        Err(error) => {
            broken = Err(error);
            false
        }
    });
    broken.map(|()| names)
}

/// Why a scene of the library cannot be charted, if so.
fn look_at(name: &str, fits: &impl Fn(&Scene) -> Result<()>) -> Result<Option<String>> {
    let scene = match relume_scenes::load(&relume_scenes::resolve(name)?) {
        Err(error @ Error::Io { .. }) if error.is_bad_input() => return Ok(Some(error.to_string())),
        other => other?,
    };
    match fits(&scene) {
        Err(error) if error.exit_code() == 2 => Ok(Some(error.to_string())),
        other => other.map(|()| None),
    }
}

/// Fails unless the folder of `scene` in a gallery can be called as the scene is.
///
/// # Errors
/// `Invalid` with the remedy.
pub fn expect_plain(scene: &str, place: &Place) -> Result<()> {
    if is_plain_name(scene) {
        return Ok(());
    }
    let reason = format!(
        "scene `{scene}` is no plain file name of a-z A-Z 0-9 . _ - and blanks; give it another name"
    );
    Err(BakeError::invalid(place, reason))
}

/// Copies the chart in `from` into the gallery and says what changed there.
fn publish(from: &Path, gallery: &Path) -> Result<String> {
    let chart = Chart::read(from)?;
    expect_plain(&chart.scene, &Place::file(from.join(JSON)))?;
    let to = gallery.join(&chart.scene);
    let before = to.join(JSON).exists().then(|| Chart::read(&to));
    create_folder(&to)?;
    // The figures come last: they stand for the rest.
    for name in [PICTURE, SVG, JSON] {
        let bytes =
            std::fs::read(from.join(name)).map_err(|e| Error::output(&Place::file(from.join(name)), e))?;
        replace_file(&to.join(name), &bytes)?;
    }
    let lines = match before {
        None => vec!["new in the gallery".to_owned()],
        Some(Err(error)) => vec![format!("replaces what could not be read ({error})")],
        Some(Ok(before)) => changes::between(&before, &chart),
    };
    Ok(lines.iter().map(|line| format!("{}: {line}\n", chart.scene)).collect())
}

/// Writes the page of all charts in the gallery.
fn write_page(gallery: &Path) -> Result<PathBuf> {
    let path = gallery.join(PAGE);
    replace_file(&path, page::page(&charts(gallery)?).as_bytes())?;
    Ok(path)
}

/// All charts in the gallery by name of their folder, which is that of their scene.
fn charts(gallery: &Path) -> Result<Vec<Chart>> {
    create_folder(gallery)?;
    let entries = std::fs::read_dir(gallery).map_err(|e| Error::output(&Place::file(gallery), e))?;
    let mut folders: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join(JSON).is_file())
        .collect();
    folders.sort();
    let read = |folder: &PathBuf| {
        let chart = Chart::read(folder)?;
        match folder.file_name().is_some_and(|name| *name == *chart.scene) {
            true => Ok(chart),
            false => Err(BakeError::invalid(
                &Place::file(folder.join(JSON)),
                format!("is of scene `{}`, which needs a folder of this name; remove it", chart.scene),
            )),
        }
    };
    folders.iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_chart::chart;

    /// Leaves a chart as `bake chart` would.
    fn left_in(folder: &Path, chart: &Chart) -> PathBuf {
        let folder = folder.join(format!("chart-of-{}", chart.scene));
        std::fs::create_dir_all(&folder).unwrap();
        crate::files::write(chart, &folder).unwrap();
        std::fs::write(folder.join(PICTURE), chart.scene.as_bytes()).unwrap();
        folder
    }

    fn named(scene: &str) -> Chart {
        Chart { scene: scene.to_owned(), ..chart() }
    }

    #[test]
    fn a_gallery_grows_keeps_what_is_there_and_says_what_changed() {
        let folder = tempfile::tempdir().unwrap();
        let gallery = folder.path().join("gallery");
        let scenes = ["b".to_owned(), "a".to_owned()];
        let text = make(&scenes, &gallery, |scene| Ok(left_in(folder.path(), &named(scene)))).unwrap();
        assert_eq!(
            text,
            format!("b: new in the gallery\na: new in the gallery\n{}\n", gallery.join(PAGE).display())
        );
        for scene in ["a", "b"] {
            assert_eq!(Chart::read(&gallery.join(scene)).unwrap(), named(scene));
            assert_eq!(std::fs::read(gallery.join(scene).join(PICTURE)).unwrap(), scene.as_bytes());
            assert!(gallery.join(scene).join(SVG).is_file());
        }
        let page = std::fs::read_to_string(gallery.join(PAGE)).unwrap();
        assert!(page.find("## a\n").unwrap() < page.find("## b\n").unwrap());

        let mut other = named("a");
        other.points[0].bytes_on_disk += 1;
        let text = make(&scenes[1..], &gallery, |_| Ok(left_in(folder.path(), &other))).unwrap();
        assert!(
            text.starts_with("a: transfer-images, 256 spp, 2 bases: bytes on disk 1200001, were 1200000\n"),
            "{text}"
        );
        assert_eq!(Chart::read(&gallery.join("a")).unwrap(), other);
        let text = make(&scenes[1..], &gallery, |_| Ok(left_in(folder.path(), &other))).unwrap();
        assert!(text.starts_with("a: all figures as before"), "{text}");
        assert!(std::fs::read_to_string(gallery.join(PAGE)).unwrap().contains("## b\n"));
    }

    #[test]
    fn what_cannot_be_read_is_replaced_if_made_anew_and_named_if_not() {
        let folder = tempfile::tempdir().unwrap();
        let gallery = folder.path().join("gallery");
        std::fs::create_dir_all(gallery.join("a")).unwrap();
        std::fs::write(gallery.join("a").join(JSON), "{}").unwrap();
        let message = make(&[], &gallery, |_| unreachable!()).unwrap_err().to_string();
        assert!(message.contains("a/chart.json"), "{message}");
        let text =
            make(&["a".to_owned()], &gallery, |scene| Ok(left_in(folder.path(), &named(scene)))).unwrap();
        assert!(text.starts_with("a: replaces what could not be read"), "{text}");
        std::fs::rename(gallery.join("a"), gallery.join("b")).unwrap();
        let message = make(&[], &gallery, |_| unreachable!()).unwrap_err().to_string();
        assert!(message.contains("is of scene `a`"), "{message}");
    }

    #[test]
    fn scenes_of_the_library_are_asked_whether_they_fit() {
        let place = Place::file("scene.toml");
        let only = |scene: &Scene| match scene.name.as_str() {
            "cornell-knot" | "ring" => Ok(()),
            other => Err(BakeError::invalid(&place, format!("{other} does not fit"))),
        };
        assert_eq!(scenes(only).unwrap(), ["cornell-knot", "ring"]);
        let stopped =
            scenes(|_| Err(BakeError::Interrupted(relume_bake::interrupted::Interrupted))).unwrap_err();
        assert_eq!(stopped.exit_code(), 130, "not every error is a misfit");
    }

    #[test]
    fn a_chart_without_its_picture_or_with_a_name_that_leads_elsewhere_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let gallery = folder.path().join("gallery");
        let left = left_in(folder.path(), &named("a"));
        std::fs::remove_file(left.join(PICTURE)).unwrap();
        let message = make(&["a".to_owned()], &gallery, |_| Ok(left.clone())).unwrap_err().to_string();
        assert!(message.contains(PICTURE), "{message}");
        assert!(!gallery.join("a").join(JSON).exists());
        crate::files::write(&Chart { scene: "../a".to_owned(), ..chart() }, &left).unwrap();
        let message = make(&["a".to_owned()], &gallery, |_| Ok(left.clone())).unwrap_err().to_string();
        assert!(message.contains("no plain file name"), "{message}");
    }
}
