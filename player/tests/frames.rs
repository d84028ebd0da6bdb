//! How often the window is drawn while its picture takes long, counted from outside.

use crate::desk::{Display, Window};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::protocol::Event;
use x11rb::protocol::damage::{ConnectionExt as _, ReportLevel, X11_EXTENSION_NAME};
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConnectionExt as _, MOTION_NOTIFY_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;

/// How long is measured, and how often the pointer moves meanwhile.
const SPAN: Duration = Duration::from_secs(10);
const MOTION: Duration = Duration::from_millis(8);

/// Prints how many frames a second the window of the bundle `RELUME_FRAMES_BUNDLE` is drawn, and the longest
/// time between two, while the camera is dragged.
#[test]
#[ignore = "measures, and needs a bundle whose view varies: RELUME_FRAMES_BUNDLE=DIR cargo test --release --workspace --test player -- frames --ignored --nocapture"]
fn frames_of_the_window_while_the_picture_takes_long() {
    let Some(display) = Display::open() else { return };
    let folder = PathBuf::from(std::env::var_os("RELUME_FRAMES_BUNDLE").expect("RELUME_FRAMES_BUNDLE=DIR"));
    let size = std::env::var("RELUME_FRAMES_SIZE").unwrap_or_else(|_| "1024x1024".to_owned());
    let mut window = Window::open(&display, &folder, &["--size", &size], "");
    window.display.xdotool(&format!("windowsize --sync {} 1280 800", window.id)).unwrap();
    // Once the scene is known, the title begins with its name, as files do.
    let title = window.wait("the whole bundle", |window| {
        window.title().filter(|title| title.contains(" - ") && !title.contains("loading"))
    });
    window.save("s", &format!("{}-0001.png", title.split(" - ").next().unwrap()));
    let (connection, screen) = x11rb::connect(Some(display.name())).unwrap();
    let root = connection.setup().roots[screen].root;
    let id: u32 = window.id.parse().unwrap();
    connection.extension_information(X11_EXTENSION_NAME).unwrap().expect("the display reports damage");
    connection.damage_query_version(1, 1).unwrap().reply().unwrap();
    let damage = connection.generate_id().unwrap();
    connection.damage_create(damage, id, ReportLevel::RAW_RECTANGLES).unwrap().check().unwrap();
    let fake = |kind: u8, detail: u8, x: i16, y: i16| {
        let at = connection.translate_coordinates(id, root, x, y).unwrap().reply().unwrap();
        connection.xtest_fake_input(kind, detail, 0, root, at.dst_x, at.dst_y, 0).unwrap().check().unwrap();
    };
    fake(MOTION_NOTIFY_EVENT, 0, 450, 400);
    fake(BUTTON_PRESS_EVENT, 1, 450, 400);
    let (began, mut frames) = (Instant::now(), Vec::new());
    let mut step = 0.0_f32;
    while began.elapsed() < SPAN {
        step += 1.0;
        let (x, y) = (450.0 + 100.0 * (step / 60.0).sin(), 400.0 + 40.0 * (step / 45.0).sin());
        fake(MOTION_NOTIFY_EVENT, 0, x as i16, y as i16);
        while let Some(event) = connection.poll_for_event().unwrap() {
            // A frame is put in one or more bands, of which the first begins in the corner.
            if matches!(event, Event::DamageNotify(notify) if (notify.area.x, notify.area.y) == (0, 0)) {
                frames.push(began.elapsed());
            }
        }
        std::thread::sleep(MOTION);
    }
    fake(BUTTON_RELEASE_EVENT, 1, 450, 400);
    let longest = frames.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(SPAN);
    eprintln!(
        "{:.1} frames of the window a second, at most {} ms apart",
        frames.len() as f64 / SPAN.as_secs_f64(),
        longest.as_millis()
    );
}
