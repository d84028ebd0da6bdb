//! Bundles whose light and view vary, and whose picture has the size that the window has for it.

use super::{Twin, expect_same_without_window, state};
use crate::desk::{Display, Window};
use crate::support::sparse;
use egui::{Pos2, Vec2};
use std::path::Path;

#[test]
fn light_and_view_are_changed_by_hand() {
    let Some(display) = Display::open() else { return };
    let bundle = sparse::Bundle::write(16, true);
    let mut window = Window::open(&display, bundle.folder(), &["--size", "90x60"], "lit - Relume");
    let mut twin = Twin::lit(window.size());
    twin.film = [90, 60];
    (0..3).for_each(|_| twin.frame(Vec::new()));
    let picture = twin.mirror.rect("picture");
    twin.drag(
        &window,
        1,
        picture.center(),
        picture.center() + Vec2::new(0.25 * picture.height(), 0.1 * picture.height()),
    );
    twin.drag(&window, 3, picture.center(), picture.center() + Vec2::new(40.0, 20.0));
    let rail = twin.mirror.rect("rotation");
    twin.drag(&window, 1, rail.center(), Pos2::new(rail.right() + 30.0, rail.center().y));
    let moved = state(&window.save("t", "lit-0001.toml"));
    let (camera, light) = (moved.camera.clone().unwrap(), moved.environment.clone().unwrap());
    // No pixel of the way is lost.
    let expected = twin.editor.look().camera;
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    assert!(
        near(camera.position.unwrap(), expected.position) && near(camera.target.unwrap(), expected.target),
        "{camera:?}, {expected:?}"
    );
    let [x, y, z] = expected.position;
    assert!(x < -1.0 && y > 0.3 && z > 0.5 && expected.target[0] < -0.05, "{expected:?}");
    assert_eq!((light.rotation_deg, light.map, light.gain), (Some(180.0), None, None));
    let png = window.save("s", "lit-0001.png");
    let size = expect_same_without_window(bundle.folder(), &png, &["--state", "lit-0001.toml"]);
    assert_eq!(size, [90, 60], "the size that was asked for is kept");

    window.keys("v");
    let home = state(&window.save("t", "lit-0002.toml"));
    assert_eq!((home.camera, home.environment), (None, moved.environment));
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

#[test]
fn blocks_refine_the_picture_while_they_arrive() {
    let Some(display) = Display::open() else { return };
    let bundle = sparse::Bundle::write(64, true);
    let bytes: u64 = bundle.manifest.entries().map(|entry| entry.bytes).sum();
    let mut window = Window::open(&display, bundle.folder(), &["--rate", &(bytes / 3).to_string()], "lit - ");
    window.wait_for_title("lit - Relume");
    let png = window.save("s", "lit-0001.png");
    expect_same_without_window(bundle.folder(), &png, &[]);
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

/// Size in pixels of the picture in a file.
fn size_of(png: &Path) -> [u32; 2] {
    image::image_dimensions(png).unwrap().into()
}

#[test]
fn the_picture_has_the_pixels_that_it_covers() {
    let Some(display) = Display::open() else { return };
    let bundle = sparse::Bundle::write(16, true);
    let mut window = Window::open(&display, bundle.folder(), &[], "lit - Relume");
    let mut number = 0;
    // Wide, narrow so that the panel is below, and high.
    for size in [[1100, 640], [420, 640], [820, 1000]] {
        let [width, height] = size;
        display.xdotool(&format!("windowsize --sync {} {width} {height}", window.id)).unwrap();
        window.focus();
        let mut twin = Twin::lit(size.map(|side| side as f32));
        twin.resizes = true;
        (0..3).for_each(|_| twin.frame(Vec::new()));
        let area = twin.mirror.rect("picture");
        let room = twin.room.unwrap();
        assert_eq!(room, [area.width() as u32, area.height() as u32]);
        // The window may hear of its size after it hears of the key.
        let png = loop {
            number += 1;
            let png = window.save("s", &format!("lit-{number:04}.png"));
            if size_of(&png) == room {
                break png;
            }
        };
        assert_eq!(expect_same_without_window(bundle.folder(), &png, &[]), room);
    }
    // Where a pixel of the display is one of the picture, a drag goes its exact way.
    let mut twin = Twin::lit(window.size());
    twin.resizes = true;
    (0..3).for_each(|_| twin.frame(Vec::new()));
    let picture = twin.mirror.rect("picture");
    twin.drag(&window, 1, picture.center(), picture.center() + Vec2::new(80.0, -30.0));
    let saved = state(&window.save("t", "lit-0001.toml")).camera.unwrap().position.unwrap();
    let expected = twin.editor.look().camera.position;
    assert!(saved.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{saved:?}, {expected:?}");
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}
