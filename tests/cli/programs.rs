//! What both programs say of themselves, and how much they say.

use crate::support::room::{ROOM, Workshop};
use crate::support::{expect_exit, run};
use std::process::Command;

fn printed(program: &str, arguments: &[&str]) -> String {
    let output = run(program, arguments);
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn versions_tell_the_commit() {
    for program in ["bake", "player"] {
        let version = printed(program, &["--version"]);
        let origin =
            version.trim_end().strip_prefix(&format!("{program} {} (", env!("CARGO_PKG_VERSION"))).unwrap();
        let origin = origin.strip_suffix(')').unwrap();
        let is_commit = |text: &str| text.len() >= 12 && text.chars().all(|c| c.is_ascii_hexdigit());
        assert!(
            origin == "not built from a repository" || origin.strip_prefix("commit ").is_some_and(is_commit),
            "{version}"
        );
    }
}

/// Scripts for bash are read by it, and name every command and option.
#[test]
fn shells_complete_both_programs() {
    let folder = tempfile::tempdir().unwrap();
    for (program, arguments, words) in [
        ("bake", ["completions", "bash"], ["run", "new", "--quality", "sphere-shadows"]),
        ("player", ["--completions", "bash"], ["--headless", "--frames", "--animation", "--state"]),
    ] {
        let script = printed(program, &arguments);
        assert!(words.iter().all(|word| script.contains(word)), "{program}");
        let file = folder.path().join(program);
        std::fs::write(&file, script).unwrap();
        let reads = "source \"$1\" && complete -p \"$2\"";
        let output = Command::new("bash")
            .args(["-c", reads, "bash", file.to_str().unwrap(), program])
            .output()
            .unwrap();
        assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
        for shell in ["zsh", "fish"] {
            assert!(printed(program, &[arguments[0], shell]).contains(program));
        }
    }
}

#[test]
fn manual_pages_tell_of_every_command() {
    let folder = tempfile::tempdir().unwrap();
    expect_exit("bake", &["man", "-o", folder.path().to_str().unwrap()], 0);
    for page in ["bake", "bake-new", "bake-run", "bake-merge", "bake-chart"] {
        let text = std::fs::read_to_string(folder.path().join(format!("{page}.1"))).unwrap();
        assert!(text.contains(".SH SYNOPSIS") && text.contains(".SH OPTIONS"), "{page}: {text}");
    }
    let player = printed("player", &["--man"]);
    assert!(player.contains(".SH SYNOPSIS") && player.contains("headless"), "{player}");
}

#[test]
fn programs_say_as_much_as_is_wanted() {
    let w = Workshop::new();
    let scene = w.write("narrow.toml", &ROOM.replace("fov_deg = 45.0", "fov_deg = 4.0"));
    let bundle = w.path("bundle");
    let bake = |more: &[&str]| {
        let output = run("bake", &[&["run", &scene, "-o", &bundle, "--spp", "1"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (out, err) = bake(&["-q"]);
    assert!(
        out.is_empty() && err.lines().count() > 0 && err.lines().all(|line| line.starts_with("warning: ")),
        "{out}{err}"
    );
    let (out, err) = bake(&["--force", "-v"]);
    assert!(out.contains("transfer-images baked"), "{out}");
    for part in ["read ", " objects, ", "looked at the scene in "] {
        assert!(err.contains(part), "{err}");
    }
    assert!(
        printed("bake", &["-q", "plan", &scene]).contains("chosen: transfer-images"),
        "what was asked for is told"
    );
    let refused = expect_exit("bake", &["-q", "plan", &w.path("nothing.toml")], 2);
    assert!(refused.starts_with("error: "), "{refused}");
}
