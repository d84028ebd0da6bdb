//! The documentation: every relative link of the README and of `docs/` leads to a file, and the README is
//! short.

use std::fs;
use std::path::{Path, PathBuf};

/// Most words of the README, as `wc -w` counts them.
const README_WORDS: usize = 900;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Every Markdown file in `folder` and below.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_page = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "md");
    let of = |path: PathBuf| if path.is_dir() { pages(&path) } else { vec![path] };
    entries.flat_map(of).filter(is_page).collect()
}

/// The relative targets of all links and pictures of a page, without what follows `#`; code has none.
fn relative_links(text: &str) -> Vec<String> {
    let mut in_code = false;
    let prose = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        in_code ^= fence;
        !in_code && !fence
    });
    // What stands between backticks is every second piece; a span may go on in the next line.
    let prose: String = prose.flat_map(|line| [line, "\n"]).collect();
    let prose: String = prose.split('`').step_by(2).collect();
    let targets = prose.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned()));
    let files = targets.map(|target| target.split('#').next().unwrap_or_default().to_owned());
    files.filter(|file| !file.is_empty() && !file.contains("://") && !file.starts_with("mailto:")).collect()
}

#[test]
fn links_are_found() {
    let prose = "[a](x.md) ![b](img/y.png)\n`[c](not.md)` [`d`](z.md#part) [e](#here) [f](https://a.b/c)\n";
    let text = format!("{prose}```\n[g](not.md)\n```\n[h\ni](../w.md)");
    assert_eq!(relative_links(&text), ["x.md", "img/y.png", "z.md", "../w.md"]);
}

#[test]
fn relative_links_lead_to_files() {
    let mut pages = pages(&root().join("docs"));
    pages.push(root().join("README.md"));
    assert!(pages.len() > 20, "{pages:?}");
    let mut broken = Vec::new();
    for page in &pages {
        for link in relative_links(&fs::read_to_string(page).unwrap()) {
            if !page.parent().unwrap().join(&link).exists() {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere:\n{}", broken.join("\n"));
}

#[test]
fn the_readme_is_short() {
    let words = fs::read_to_string(root().join("README.md")).unwrap().split_whitespace().count();
    assert!(words <= README_WORDS, "README.md has {words} words, at most {README_WORDS} are wanted");
}
