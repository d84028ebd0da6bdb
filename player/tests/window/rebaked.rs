//! A bundle that is baked again while it is on show.

use super::{Twin, expect_picture, off_by, state};
use crate::desk::{Display, Window};
use crate::support::Bundle;
use egui::Pos2;

/// Whether a colour is the orange of what is to be noticed.
fn is_accent([red, green, blue]: [u8; 3]) -> bool {
    red > 150 && green > 90 && green < red && blue < 110
}

#[test]
fn a_bundle_that_is_baked_again_is_shown_when_asked_for() {
    let Some(display) = Display::open() else { return };
    let (bundle, other) = (Bundle::write(true), Bundle::write(false));
    let mut window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    let mut twin = Twin::new(&bundle, window.size());
    twin.click(&window, twin.pixel_of("a"));
    window.wait_for_title("synthetic - a - Relume");
    let rail = twin.mirror.rect("shininess");
    twin.drag(&window, 1, rail.center(), Pos2::new(rail.right() + 30.0, rail.center().y));
    window.wait_for_title("synthetic - a (edited) - Relume");
    let edited = state(&window.save("t", "synthetic-0001.toml"));
    expect_picture(&bundle, &edited, &window.save("s", "synthetic-0001.png"));

    bundle.bake_again(&other);
    twin.facts.rebaked = true;
    (0..3).for_each(|_| twin.frame(Vec::new()));
    let button = twin.mirror.rect("Show");
    let left = Pos2::new(twin.mirror.rect("Undo").left(), button.top());
    window.wait_for_colour(egui::Rect::from_min_max(left, button.left_bottom()), is_accent);
    // The old picture is still there, and nothing of the new one in it.
    expect_picture(&bundle, &edited, &window.save("s", "synthetic-0002.png"));
    window.click(button.center());
    // The picture of the new bake comes when all of it is there.
    let mut number = 2;
    loop {
        number += 1;
        let png = window.save("s", &format!("synthetic-{number:04}.png"));
        if off_by(&other, &edited, &png) <= 1.0 {
            break;
        }
        assert!(number < 1000, "the new bake never came");
    }
    window.wait_for_title("synthetic - a (edited) - Relume");
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()), "the edits are saved");
}

#[test]
fn a_bundle_that_is_gone_stays_on_show() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let mut window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    std::fs::remove_dir_all(bundle.folder()).unwrap();
    window.keys("F5");
    window.save("s", "synthetic-0001.png");
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}
