//! What makes the library fit into any program: what it depends on, and what its sources do not do.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::disallowed_methods, reason = "a test may read files")]

use std::path::{Path, PathBuf};

/// All it may depend on.
const DEPENDENCIES: [&str; 6] = ["bytemuck", "glam", "half", "relume-formats", "thiserror", "wgpu"];

/// Words that no source may hold outside tests, and why.
const BARRED: [(&str, &str); 17] = [
    ("std::fs", "files"),
    ("std::thread", "threads"),
    ("rayon", "threads"),
    ("std::time", "clocks"),
    ("Instant::now", "clocks"),
    ("std::process", "processes"),
    ("std::env", "the caller's surroundings"),
    ("std::io", "reading and writing"),
    ("std::net", "networks"),
    (".poll(wgpu", "waiting for the GPU"),
    ("PollType", "waiting for the GPU"),
    ("block_on", "waiting"),
    (".recv()", "waiting"),
    ("Condvar", "waiting"),
    (".lock()", "waiting"),
    ("println!", "the caller's terminal"),
    ("_file(", "files: what formats reads and writes by path"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The barred words of a source, up to the tests at its end.
fn barred(text: &str) -> Vec<&'static str> {
    let code = text.split("\n#[cfg(test)]\nmod tests").next().unwrap();
    let lines = || code.lines().filter(|line| !line.trim_start().starts_with("//"));
    BARRED.iter().filter(|(word, _)| lines().any(|line| line.contains(word))).map(|(word, _)| *word).collect()
}

#[test]
fn it_depends_on_little() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    let section = text.split("\n[dependencies]\n").nth(1).unwrap().split("\n[").next().unwrap();
    let names: Vec<&str> = section
        .lines()
        .filter_map(|line| line.split(['.', ' ', '=']).next())
        .filter(|name| !name.is_empty())
        .collect();
    assert_eq!(
        {
            let mut sorted = names;
            sorted.sort_unstable();
            sorted
        },
        DEPENDENCIES
    );
    assert!(!text.contains("[target"), "the same on every system");
}

#[test]
fn it_starts_no_threads_opens_no_files_and_never_waits() {
    let mut found = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
    assert!(found.len() > 20);
    let is_test = |path: &Path| {
        path.ends_with("testing.rs") || path.ends_with("tests.rs") || path.iter().any(|part| part == "tests")
    };
    for path in found.iter().filter(|path| !is_test(path)) {
        assert_eq!(barred(&std::fs::read_to_string(path).unwrap()), Vec::<&str>::new(), "{}", path.display());
    }
    assert_eq!(barred("fn f() {\n    std::thread::sleep(x);\n}\n"), ["std::thread"]);
    assert!(barred("// std::fs is not used\n\n#[cfg(test)]\nmod tests {\n    use std::fs;\n}\n").is_empty());
}
