//! The build script of both programs: tells `--version` which commit they were built from.
//!
//! A tree that is no repository of its own, such as an unpacked archive, has none, and it builds without git.
//! The same commit gives the same program; what was changed since is not told.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The file that cargo names as this script, by its path from the root of the workspace.
const SCRIPT: &str = "commit.rs";

fn main() {
    let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let package = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let Some(root) = package.ancestors().find(|folder| folder.join(SCRIPT).is_file()) else { return };
    let repository =
        git(root, &["rev-parse", "--show-toplevel"]).and_then(|top| Path::new(&top).canonicalize().ok());
    let is_own = repository.is_some() && repository == root.canonicalize().ok();
    let commit = if is_own { git(root, &["rev-parse", "--short=12", "HEAD"]) } else { None };
    let origin =
        commit.map_or_else(|| "not built from a repository".to_owned(), |commit| format!("commit {commit}"));
    println!("cargo::rustc-env=RELUME_VERSION={version} ({origin})");
    println!("cargo::rerun-if-changed={}", root.join(SCRIPT).display());
    if is_own {
        // What is not there would have cargo run this for every build.
        let files = watched(root).into_iter().filter(|file| file.exists());
        files.for_each(|file| println!("cargo::rerun-if-changed={}", file.display()));
    }
}

/// The files of the repository that change with its commit.
fn watched(root: &Path) -> Vec<PathBuf> {
    let branch = git(root, &["symbolic-ref", "-q", "HEAD"]);
    // A branch that is packed has no file of its own until it moves; the log of HEAD grows whenever that
    // does.
    let names = ["HEAD", "logs/HEAD", "packed-refs"].map(str::to_owned).into_iter().chain(branch);
    names
        .filter_map(|name| git(root, &["rev-parse", "--git-path", &name]))
        .map(|path| root.join(path))
        .collect()
}

/// What git says, if there is git and it agrees.
fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}
