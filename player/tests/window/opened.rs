//! Files that are opened by a dialog.

use super::{Twin, state};
use crate::desk::{Display, Window};
use crate::support::Bundle;
use egui::{Pos2, Rect};
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;

/// Where no session bus is, so that no portal answers, not even that of whoever runs the test.
const NO_BUS: &str = "unix:path=/nonexistent/bus";

/// A dialog that says when it is asked, and answers what is written into `answer` beside it; an empty line calls it
/// off.
const DIALOG: &str = "#!/bin/sh\n: > \"${0%/*}/asked\"\nread answer < \"${0%/*}/answer\"\n[ -n \"$answer\" ] && echo \"$answer\"\n";

#[test]
fn a_file_is_chosen_in_a_dialog_while_the_window_goes_on() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let tools = tempfile::tempdir().unwrap();
    let tool = |name: &str| tools.path().join(name);
    std::fs::write(tool("zenity"), DIALOG).unwrap();
    std::fs::set_permissions(tool("zenity"), Permissions::from_mode(0o755)).unwrap();
    assert!(Command::new("mkfifo").arg(tool("answer")).status().unwrap().success());
    std::fs::write(tool("dark.toml"), "camera.exposure_ev = -7.5\n").unwrap();
    let environment = [("PATH", tools.path()), ("DBUS_SESSION_BUS_ADDRESS", Path::new(NO_BUS))];
    let mut window = Window::open_among(&display, bundle.folder(), &[], "synthetic - Relume", &environment);
    window.keys("ctrl+o");
    window.wait("the dialog", |_| tool("asked").exists().then_some(()));
    // Nobody waits for the answer.
    let twin = Twin::new(&bundle, window.size());
    window.click(twin.pixel_of("a"));
    window.wait_for_title("synthetic - a - Relume");
    window.save("s", "synthetic-0001.png");
    std::fs::write(tool("answer"), tool("dark.toml").to_str().unwrap()).unwrap();
    // Until the state is taken, there is nothing to save.
    window.wait("the state", |window| {
        window.keys("t");
        window.folder.path().join("synthetic-0001.toml").exists().then_some(())
    });
    let saved = state(&window.saved("synthetic-0001.toml"));
    assert_eq!(saved.camera.unwrap().exposure_ev, Some(-7.5));
    // Asked again, as the first dialog is closed, and called off.
    std::fs::remove_file(tool("asked")).unwrap();
    window.keys("ctrl+o");
    window.wait("the dialog", |_| tool("asked").exists().then_some(()));
    std::fs::write(tool("answer"), "\n").unwrap();
    window.save("s", "synthetic-0002.png");
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

#[test]
fn without_any_dialog_the_window_says_what_to_do_instead() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let empty = tempfile::tempdir().unwrap();
    let environment = [("PATH", empty.path()), ("DBUS_SESSION_BUS_ADDRESS", Path::new(NO_BUS))];
    let mut window = Window::open_among(&display, bundle.folder(), &[], "synthetic - Relume", &environment);
    window.keys("ctrl+o");
    let [width, height] = window.size();
    // The last line of the panel, in the colour of warnings.
    let line =
        Rect::from_min_max(Pos2::new(width - 328.0, height - 32.0), Pos2::new(width - 16.0, height - 4.0));
    window.wait_for_colour(line, |[red, green, blue]| red > 160 && green < 130 && blue < 110 && green > 50);
    window.save("s", "synthetic-0001.png");
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}
