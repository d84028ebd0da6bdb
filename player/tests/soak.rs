//! Random input for as long as is wanted: the window must neither crash nor fill memory.

use crate::desk::{Display, Window};
use crate::support::Bundle;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// SplitMix64, 0..below.
fn random(seed: &mut u64, below: u64) -> u64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) % below
}

/// Resident memory of a process, in MB.
fn resident_mb(process: u32) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.split_whitespace().next().unwrap().parse::<f64>().unwrap() / 1024.0
}

/// Resident memory at one size of the window, for what it draws into grows with that. Saving a
/// picture shows that it is drawn.
fn settled_mb(window: &mut Window<'_>) -> f64 {
    let pictures = |window: &Window<'_>| {
        let files = std::fs::read_dir(window.folder.path()).unwrap();
        files.filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|e| e == "png")).count()
    };
    window.display.xdotool(&format!("windowsize --sync {} 1200 820 windowfocus {0}", window.id)).unwrap();
    let before = pictures(window);
    window.wait("a saved picture", |window| {
        // A click beside the picture leaves any field or menu that would take the key for itself.
        window.display.xdotool(&format!("mousemove --window {} 4 4 click 1 key s", window.id))?;
        Some(()).filter(|()| pictures(window) > before)
    });
    resident_mb(window.child.id())
}

/// A handful of random things that a user may do, as commands for `xdotool`.
fn random_actions(seed: &mut u64, window: &str, size: [u64; 2]) -> String {
    let mut commands = Vec::new();
    let point = |seed: &mut u64| {
        format!("mousemove --window {window} {} {}", random(seed, size[0]), random(seed, size[1]))
    };
    for _ in 0..12 {
        match random(seed, 20) {
            0..8 => commands.push(format!("{} click 1", point(seed))),
            8..13 => commands.push(format!(
                "{} mousedown 1 {} {} mouseup 1",
                point(seed),
                point(seed),
                point(seed)
            )),
            13 => commands.push(format!("{} click --repeat 3 {}", point(seed), 4 + random(seed, 2))),
            14 => commands.push(format!("{} click {}", point(seed), 2 + random(seed, 2))),
            15..19 => {
                // Not q, which ends it, and saving now and then only.
                let keys = [
                    "Escape",
                    "space",
                    "Tab",
                    "Left",
                    "Right",
                    "Up",
                    "Down",
                    "Return",
                    "1",
                    "period",
                    "BackSpace",
                    "minus",
                    "Home",
                    "x",
                    "plus",
                ];
                commands.push(format!("key {}", keys[random(seed, keys.len() as u64) as usize]));
            }
            _ => commands.push(point(seed)),
        }
    }
    commands.join(" ")
}

/// Random clicks, drags, keys, scrolls and resizes for `RELUME_SOAK_S` seconds, 60 if that is not set; on the
/// bundle `RELUME_SOAK_BUNDLE`, or a synthetic one. Prints resident memory as it goes.
#[test]
#[ignore = "takes as long as it is told to: RELUME_SOAK_S=600 cargo test --release --workspace --test player -- soak --ignored --nocapture"]
fn random_input_neither_crashes_it_nor_fills_memory() {
    let Some(display) = Display::open() else { return };
    let seconds = std::env::var("RELUME_SOAK_S").map_or(60, |text| text.parse().unwrap());
    let bundle = Bundle::write(true);
    let folder = std::env::var_os("RELUME_SOAK_BUNDLE").map_or(bundle.folder().to_owned(), PathBuf::from);
    let mut window = Window::open(&display, &folder, &[], "");
    window.wait("the whole bundle", |window| window.title().filter(|title| !title.contains("loading")));
    let mut seed = 2026;
    let act = |window: &Window<'_>, seed: &mut u64, step: u64| {
        let size = [480 + random(seed, 1100), 320 + random(seed, 870)];
        if step.is_multiple_of(10) {
            display.xdotool(&format!("windowsize {} {} {}", window.id, size[0], size[1])).unwrap();
            display.xdotool(&format!("windowfocus {}", window.id)).unwrap();
        }
        display.xdotool(&random_actions(seed, &window.id, size)).expect("the window is there");
        if step % 50 == 49 {
            display.xdotool(["key s", "key e", "key t"][(step / 50 % 3) as usize]).unwrap();
        }
    };
    // Caches, fonts and swap chains of every size are part of the start.
    (0..120).for_each(|step| act(&window, &mut seed, step));
    let (began, start_mb) = (Instant::now(), settled_mb(&mut window));
    let mut step = 0;
    while began.elapsed() < Duration::from_secs(seconds) {
        act(&window, &mut seed, step);
        if step % 50 == 0 {
            eprintln!(
                "{:4.0} s: {:.1} MB resident after {} actions",
                began.elapsed().as_secs_f64(),
                settled_mb(&mut window),
                step * 12
            );
        }
        step += 1;
    }
    let end_mb = settled_mb(&mut window);
    eprintln!(
        "{} actions in {seconds} s: {start_mb:.1} MB at the start, {end_mb:.1} MB at the end",
        step * 12
    );
    assert!(window.child.try_wait().unwrap().is_none(), "it ended: {}", window.complaint());
    assert!(end_mb <= start_mb * 1.1, "{start_mb} MB have become {end_mb} MB");
}
