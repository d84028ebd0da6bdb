//! Finished logs beside a bundle: other maps and other terms trace nothing and make the bytes of a clean bake,
//! whatever becomes of the logs, and whenever publishing is killed.

use super::{Column, SPARSE, home, of_column, rays};
use crate::support::{copy_folder, job, write_scene};
use relume_bake::bundle;
use relume_bake::error::Result;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::registered::Registered;
use relume_bake::unfinished::Leftover;
use std::path::{Path, PathBuf};

const ONE_MAP: &str = "file = 'lamps'";
const TWO_MAPS: &str = "file = 'lamps'\n    others = ['clear-sky']";
const TURNED_AROUND: &str = "file = 'clear-sky'\n    others = ['lamps']";

/// How many terms, or which error, is asked for.
#[derive(Clone, Copy)]
enum Terms {
    Number(u32),
    Error(f64),
}

/// Bakes the scene that stands in `folder` as it is asked for.
fn bake(folder: &Path, method: &str, terms: Terms, leftover: Leftover) -> Result<Option<u64>> {
    let scene = relume_scenes::load(&folder.join("scene.toml")).unwrap();
    let asked = Asked { samples: Some(4), ..Asked::of_scene(&scene) };
    let asked = match terms {
        Terms::Number(terms) => Asked { terms: Some(terms), ..asked },
        Terms::Error(max_error) => Asked { max_error, ..asked },
    };
    let methods = [(Registered::find(method).unwrap().new)(&asked, &scene)];
    let out = folder.join("out");
    let (summary, _) = bundle::run(&scene, &methods, scene.size, &out, leftover, 0, &job())?;
    Ok(summary.methods[0].traced.map(|traced| traced.rays))
}

/// The files of the bundle in `folder` by name; times, and what no player reads, are left out.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let files = std::fs::read_dir(folder.join("out")).unwrap().map(|entry| entry.unwrap().path());
    let is_bundle = |path: &PathBuf| path.is_file() && path.file_name().unwrap() != "report.json";
    let content = |path: PathBuf| {
        (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(path).unwrap())
    };
    let mut contents: Vec<_> = files.filter(is_bundle).map(content).collect();
    contents.sort();
    contents
}

/// Names in a folder, sorted; none if it is not there.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A folder with the scene of a column in it.
fn place(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_scene(&home(&folder), text);
    folder
}

/// What a bake makes where nothing was before.
fn clean(text: &str, method: &str, terms: Terms) -> Vec<(String, Vec<u8>)> {
    let folder = place(text);
    assert!(bake(&home(&folder), method, terms, Leftover::Refuse).unwrap().is_some_and(|rays| rays > 0));
    contents(&home(&folder))
}

/// A baked column, and what a further map makes of it.
struct Finished<'a> {
    column: &'a Column,
    text: String,
    folder: tempfile::TempDir,
    /// A clean bake's bundle with two maps.
    expected: Vec<(String, Vec<u8>)>,
}

impl<'a> Finished<'a> {
    fn new(column: &'a Column) -> Self {
        let text = of_column(column);
        let folder = place(&text);
        assert!(rays(&home(&folder), column.method).is_some_and(|rays| rays > 0));
        let expected = clean(&text.replace(ONE_MAP, TWO_MAPS), column.method, Terms::Number(8));
        Self { column, text, folder, expected }
    }

    /// Another folder that holds the same.
    fn copy(&self) -> tempfile::TempDir {
        let copy = tempfile::tempdir().unwrap();
        copy_folder(self.folder.path(), copy.path());
        copy
    }

    /// Bakes the copy again with a further map, after which all is as a clean bake leaves it; returns the
    /// rays.
    fn with_two_maps(&self, copy: &tempfile::TempDir, leftover: Leftover, what: &str) -> u64 {
        let at = home(copy);
        write_scene(&at, &self.text.replace(ONE_MAP, TWO_MAPS));
        let rays = bake(&at, self.column.method, Terms::Number(8), leftover).unwrap().unwrap();
        assert!(contents(&at) == self.expected, "{}: {what}", self.column.title);
        assert!(!at.join("out/unfinished").exists(), "{}: {what}", self.column.title);
        assert_eq!(names(&at.join("out/traced")), names(&home(&self.folder).join("out/traced")));
        rays
    }
}

#[test]
fn other_maps_and_terms_trace_nothing_and_make_the_bytes_of_a_clean_bake() {
    for column in &SPARSE {
        let text = of_column(column);
        let folder = place(&text);
        let at = home(&folder);
        let again = |maps: &str, terms: Terms| {
            let text = text.replace(ONE_MAP, maps);
            write_scene(&at, &text);
            let traced = bake(&at, column.method, terms, Leftover::Refuse).unwrap();
            assert_eq!(traced.unwrap_or(0), 0, "{}: {maps}", column.title);
            assert!(contents(&at) == clean(&text, column.method, terms), "{}: {maps}", column.title);
        };
        assert!(bake(&at, column.method, Terms::Number(8), Leftover::Refuse).unwrap().unwrap() > 0);
        again(TWO_MAPS, Terms::Number(8));
        again(TURNED_AROUND, Terms::Number(300));
        again(TWO_MAPS, Terms::Error(0.05));
        again(ONE_MAP, Terms::Error(0.2));
        let forced = bake(&at, column.method, Terms::Error(0.2), Leftover::Discard).unwrap();
        assert!(forced.unwrap() > 0, "--force traces");
        again(TWO_MAPS, Terms::Error(0.2));
    }
}

#[test]
fn whatever_becomes_of_logs_the_bundle_is_that_of_a_clean_bake() {
    for column in &SPARSE {
        let finished = Finished::new(column);
        damaged(&finished);
        killed(&finished);
    }
}

/// `traced::tests` damages every byte; here is what a bake makes of it.
fn damaged(finished: &Finished<'_>) {
    let name = names(&home(&finished.folder).join("out/traced")).pop().unwrap();
    let with = |what: &str, damage: &dyn Fn(&mut Vec<u8>)| {
        let copy = finished.copy();
        let path = home(&copy).join("out/traced").join(&name);
        let mut bytes = std::fs::read(&path).unwrap();
        damage(&mut bytes);
        std::fs::write(&path, bytes).unwrap();
        assert!(finished.with_two_maps(&copy, Leftover::Refuse, what) > 0, "{what}");
    };
    with("of other work", &|bytes| bytes[3] ^= 1);
    with("a bit", &|bytes| *bytes.last_mut().unwrap() ^= 1);
    with("cut", &|bytes| bytes.truncate(bytes.len() / 2));
    let copy = finished.copy();
    std::fs::remove_dir_all(home(&copy).join("out/traced")).unwrap();
    assert!(finished.with_two_maps(&copy, Leftover::Refuse, "gone") > 0);
    write_scene(&home(&copy), &finished.text);
    assert_eq!(rays(&home(&copy), finished.column.method), Some(0), "they are there again");
}

/// Publishing moves logs, then the old manifest, then files. Each state that a kill may leave is made here.
fn killed(finished: &Finished<'_>) {
    let logs = names(&home(&finished.folder).join("out/traced"));
    for moved in 0..=logs.len() {
        let copy = finished.copy();
        let out = home(&copy).join("out");
        let [traced, unfinished] = ["traced", "unfinished"].map(|folder| out.join(folder));
        std::fs::create_dir(&unfinished).unwrap();
        for log in &logs[moved..] {
            std::fs::rename(traced.join(log), unfinished.join(log)).unwrap();
        }
        std::fs::copy(out.join("scene.relume"), unfinished.join("scene.relume")).unwrap();
        let what = format!("{moved} moved");
        if moved == logs.len() {
            // The old manifest is put aside, too; nothing unfinished is in the way of what comes next.
            std::fs::rename(out.join("manifest.json"), unfinished.join("manifest.json")).unwrap();
            assert_eq!(finished.with_two_maps(&copy, Leftover::Refuse, &what), 0);
        } else {
            let refused = bake(&home(&copy), finished.column.method, Terms::Number(9), Leftover::Refuse);
            let refused = refused.unwrap_err().to_string();
            assert!(refused.contains("holds an unfinished bake; add --resume"), "{refused}");
            assert_eq!(finished.with_two_maps(&copy, Leftover::Resume, &what), 0);
        }
    }
}

#[test]
fn logs_of_what_a_bundle_no_longer_has_are_gone() {
    let column = &SPARSE[1];
    let folder = place(&of_column(column));
    let (at, traced) = (home(&folder), home(&folder).join("out/traced"));
    let bake_with = |reflections: &str, method: &str| {
        let text = of_column(column).replace("reflections = 2", reflections);
        write_scene(&at, &text);
        rays(&at, method)
    };
    let (direct, first, second) =
        ("sparse-transfer.log", "sparse-transfer-bounce-1.log", "sparse-transfer-bounce-2.log");
    assert!(bake_with("reflections = 2", "sparse-transfer").unwrap() > 0);
    assert_eq!(names(&traced), [first, direct]);
    std::fs::write(traced.join("notes.txt"), "the user's").unwrap();
    let more = bake_with("reflections = 3", "sparse-transfer").unwrap();
    assert_eq!(names(&traced), ["notes.txt", first, second, direct]);
    // What was there before is not traced again; a bounce is.
    assert!(more > 0);
    assert_eq!(bake_with("reflections = 1", "sparse-transfer"), Some(0));
    assert_eq!(names(&traced), ["notes.txt", direct]);
    assert!(bake_with("reflections = 1", "sphere-shadows").unwrap() > 0);
    assert_eq!(names(&traced), ["notes.txt", "sphere-shadows-pose-0.log"]);
}

#[test]
fn what_stands_where_logs_go_is_refused_before_anything_is_traced() {
    let column = &SPARSE[0];
    let folder = place(&of_column(column));
    let traced = home(&folder).join("out/traced");
    std::fs::create_dir_all(traced.parent().unwrap()).unwrap();
    let refused = || bake(&home(&folder), column.method, Terms::Number(8), Leftover::Refuse).unwrap_err();
    std::fs::write(&traced, "").unwrap();
    let error = refused();
    assert!(error.exit_code() == 2 && error.to_string().contains("traced: is a file where"), "{error}");
    std::fs::remove_file(&traced).unwrap();
    std::fs::create_dir_all(traced.join("sparse-transfer.log")).unwrap();
    let error = refused();
    assert!(error.exit_code() == 2 && error.to_string().contains("is a folder where"), "{error}");
    std::fs::remove_dir_all(&traced).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path(), &traced).unwrap();
        let error = refused();
        assert!(error.exit_code() == 2 && error.to_string().contains("traced: is a link"), "{error}");
        std::fs::remove_file(&traced).unwrap();
    }
    assert!(bake(&home(&folder), column.method, Terms::Number(8), Leftover::Refuse).unwrap().unwrap() > 0);
}
