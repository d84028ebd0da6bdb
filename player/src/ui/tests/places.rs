//! Where things are: they stay there, cover nothing, and can be read.

use super::*;
use egui::Rect;

/// From the least that the window may be to more than most displays have.
const SIZES: [[f32; 2]; 9] = [
    [320.0, 240.0],
    [320.0, 800.0],
    [480.0, 320.0],
    [599.0, 240.0],
    [600.0, 400.0],
    [640.0, 480.0],
    [900.0, 300.0],
    [1280.0, 800.0],
    [2560.0, 1440.0],
];

fn everyone() -> [User; 3] {
    [User::new(editor(true)), User::before(lit::lit(true), None), User::before(shapes::editor(), None)]
}

/// Where everything is that has a name of its own.
fn places(user: &User, names: &[&str]) -> Vec<Rect> {
    names.iter().map(|name| user.mirror.rect(name)).collect()
}

#[test]
fn messages_move_nothing() {
    let mut user = User::new(editor(false));
    user.click("a");
    user.settle();
    let names = ["picture", "kd R", "shininess", "Reset material", "glow", "Play", "exposure", "PNG"];
    let before = places(&user, &names);
    let long = "a/very/long/folder/".repeat(30);
    for loading in
        [Loading::Arriving, Loading::Complete, Loading::Prefix, Loading::Failed(format!("{long}: checksum"))]
    {
        for note in [None, Some(Ok(long.clone())), Some(Err(format!("cannot write {long}\nnot at all")))] {
            user.facts.rebaked = note.is_none();
            (user.facts.loading, user.note) = (loading.clone(), note);
            user.settle();
            assert_eq!(places(&user, &names), before, "{:?}", user.facts.loading);
        }
    }
    user.frame(press(user.mirror.rect("kd R").center()));
    user.frame(vec![Event::PointerMoved(Pos2::new(1100.0, 100.0))]);
    user.frame(Vec::new());
    assert!(user.shows("glossy was lowered"));
    assert_eq!(places(&user, &names), before);
}

#[test]
fn choosing_an_animation_moves_nothing() {
    let mut user = User::new(editor(true));
    let names = ["glow", "fade", "time", "exposure", "PNG"];
    let before = places(&user, &names);
    user.click("none");
    assert!(user.mirror.is_disabled("Play") && user.mirror.is_disabled("time"));
    assert_eq!(places(&user, &names), before);
}

#[test]
fn animations_are_listed_alike_whichever_plays() {
    let names = |editor: &Editor| {
        editor.animations().iter().map(|animation| animation.name.clone()).collect::<Vec<_>>()
    };
    let (plays, still) = (editor(true), editor(false));
    assert_eq!((names(&plays), names(&still)), (vec!["fade".to_owned(), "glow".to_owned()], names(&plays)));
    assert_eq!(
        (plays.animation().unwrap().name.as_str(), plays.is_playing(), still.active()),
        ("glow", true, None)
    );
}

#[test]
fn no_text_covers_another_at_any_size() {
    for size in SIZES {
        for mut user in everyone() {
            user.mirror.resize(size);
            let first = user.editor.materials().next().map(|material| material.name.clone());
            user.editor.select(first.as_deref());
            let (bytes, path) = (user.facts.bytes, "saved some-scene-0001.png".to_owned());
            for (loading, note, pointer) in [
                (Loading::Complete, None, Pos2::new(2.0, 2.0)),
                (Loading::Arriving, Some(Ok(path)), Pos2::new(0.25 * size[0], 0.25 * size[1])),
                (Loading::Failed("x".repeat(300)), Some(Err("y".repeat(300))), Pos2::new(3.0, 3.0)),
            ] {
                user.facts.rebaked = loading == Loading::Complete;
                (user.facts.loading, user.note) = (loading, note);
                (0..4).for_each(|_| user.frame(vec![Event::PointerMoved(pointer)]));
                expect_apart(&user, size);
            }
            assert!(user.mirror.rect("picture").height() > 20.0 && bytes > 0, "{size:?}");
        }
    }
}

/// Asserts that no two texts cover each other, that none leaves the window, and that the picture is free.
fn expect_apart(user: &User, size: [f32; 2]) {
    let texts = &user.mirror.texts;
    let (window, picture) = (Rect::from_min_size(Pos2::ZERO, size.into()), user.mirror.rect("picture"));
    for (index, (text, rect)) in texts.iter().enumerate() {
        assert!(window.contains_rect(*rect), "{text:?} at {rect} leaves {size:?}");
        assert!(!picture.intersects(*rect), "{text:?} at {rect} is on the picture at {picture}, {size:?}");
        for (other, place) in texts.iter().skip(index + 1) {
            let both = rect.intersect(*place);
            assert!(
                both.width() <= 0.5 || both.height() <= 0.5,
                "{text:?} at {rect} and {other:?} at {place}, {size:?}"
            );
        }
    }
    assert!(texts.len() > 2, "{texts:?}");
}

#[test]
fn every_letter_shown_is_in_the_font() {
    for mut user in everyone() {
        user.mirror.resize([1280.0, 2000.0]);
        let first = user.editor.materials().next().map(|material| material.name.clone());
        user.editor.select(first.as_deref());
        let mut seen: String = String::new();
        let openers = ["kd", "map", "clip of fox"].map(str::to_owned);
        user.settle();
        for opener in openers
            .iter()
            .filter(|name| user.mirror.names().contains(&name.as_str()))
            .cloned()
            .collect::<Vec<_>>()
        {
            user.click(&opener);
            user.settle();
            seen.extend(user.mirror.texts.iter().map(|(text, _)| text.as_str()));
            user.frame(key(Key::Escape));
        }
        user.facts.loading = Loading::Arriving;
        user.settle();
        seen.extend(user.mirror.texts.iter().map(|(text, _)| text.as_str()).chain(user.mirror.names()));
        let missing = |letter: &char| {
            let fonts = [egui::FontId::proportional(13.5), egui::FontId::monospace(13.5)];
            !letter.is_whitespace()
                && !user
                    .mirror
                    .context()
                    .fonts_mut(|all| fonts.iter().any(|font| all.has_glyph(font, *letter)))
        };
        assert_eq!(seen.chars().find(missing), None);
        assert!(seen.len() > 100);
    }
}

#[test]
fn keys_are_told_in_windows_of_any_width() {
    for width in [480.0, 640.0, 800.0, 1000.0, 1090.0, 1280.0] {
        for mut user in everyone() {
            user.mirror.resize([width, 900.0]);
            user.settle();
            let texts: Vec<&str> = user.mirror.texts.iter().map(|(text, _)| text.as_str()).collect();
            let moves = user.editor.scope().varies().camera;
            for key in
                ["S  PNG", "E  EXR", "T  state", "Space  play / pause", "Esc  cancel", "Q  close", "F1  help"]
            {
                assert!(texts.iter().any(|text| text.contains(key)), "{key} at {width}: {texts:?}");
            }
            assert_eq!(texts.iter().any(|text| text.contains("V  reset view")), moves, "{width}: {texts:?}");
            expect_apart(&user, [width, 900.0]);
        }
    }
}

#[test]
fn pointing_moves_no_picture() {
    for width in [640.0, 900.0, 1200.0] {
        let mut user = User::new(editor(false));
        user.mirror.resize([width, 900.0]);
        user.settle();
        let before = user.mirror.rect("picture");
        for wanted in
            [|seen: Seen<'_>| matches!(seen, Seen::Material(_)), |seen: Seen<'_>| seen == Seen::Fixed]
        {
            let at = user.pixel_of(wanted);
            user.frame(vec![Event::PointerMoved(at)]);
            user.settle();
            assert_eq!(user.mirror.rect("picture"), before);
        }
    }
}
