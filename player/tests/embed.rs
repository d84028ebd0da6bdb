//! Somebody else's program, `player/core/examples/embed.rs`, shows what the player shows.

use crate::run::{expect_success, gpu_there, headless};
use crate::support::{Bundle, shadows, sparse};
use std::path::Path;
use std::process::Command;

/// Runs the example on the bundle in `folder`, where `state.toml` may be.
fn embed(folder: &Path, picture: &str, state: Option<&str>) {
    let release = Path::new(env!("CARGO_BIN_EXE_player")).parent().unwrap();
    let example = release.join("examples/embed");
    assert!(example.exists(), "{} is missing; `cargo test --workspace` makes it", example.display());
    let mut command = Command::new(example);
    command.arg(folder).arg(folder.join(picture)).args(state.map(|state| folder.join(state)));
    expect_success(&command.output().unwrap());
}

#[test]
fn an_embedded_player_shows_what_the_player_shows() {
    if !gpu_there() {
        return;
    }
    let (images, rows, shadows) =
        (Bundle::write(true), sparse::Bundle::write(16, true), shadows::Bundle::write(true));
    let light = "environment = { map = \"sun\", rotation_deg = 40.0 }\ncamera = { position = [0.4, 0.6, 3.0], exposure_ev = 1.5 }\n";
    for (folder, state) in [
        (images.folder(), "materials.a.kd = [0.1, 0.6, 0.2]\ncamera.exposure_ev = -1.0\n"),
        (rows.folder(), light),
        (shadows.folder(), "shapes.worm = { clip = \"Turn\", time_s = 0.6 }\n"),
    ] {
        std::fs::write(folder.join("state.toml"), state).unwrap();
        let open = |name: &str| image::open(folder.join(name)).unwrap().to_rgba8();
        for (name, state) in [("default", None), ("state", Some("state.toml"))] {
            let (ours, theirs) = (format!("{name}-embedded.png"), format!("{name}.png"));
            embed(folder, &ours, state);
            let frames = format!("@/{theirs}");
            let arguments: Vec<&str> =
                if state.is_some() { vec!["--state", "@/state.toml"] } else { Vec::new() };
            expect_success(&headless(
                folder,
                &[&["--frames", frames.as_str(), "--count", "1"], &arguments[..]].concat(),
            ));
            // The curve is reckoned by the device there and by the CPU here.
            let (ours, theirs) = (open(&ours), open(&theirs));
            let steps = ours.iter().zip(theirs.iter()).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(
                ours.dimensions() == theirs.dimensions() && steps <= Some(1),
                "{state:?} of {}: {steps:?}",
                folder.display()
            );
        }
        assert!(open("default.png") != open("state.png"));
    }
}
