//! Quick hands before a slow display, and hands that change their mind.

use super::*;
use crate::support::mirror::{chord, typed};
use egui::{Modifiers, Vec2};

/// A user who has selected material a, whose three fields of kd follow each other.
fn user() -> User {
    let mut user = User::new(editor(false));
    user.click("a");
    user
}

/// What a click on the thing called `name` sends.
fn click(user: &User, name: &str) -> Vec<Event> {
    let at = user.mirror.rect(name).center();
    [press(at), release(at)].concat()
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Default::default() }
}

#[test]
fn numbers_typed_at_once_land_in_their_fields() {
    let before = kd(&user().editor, "a");
    for (text, expected) in [
        ("0.25\t0.5\n", [0.25, 0.5, before[2]]),
        ("0.125\t0.0625\t0.75\n", [0.125, 0.0625, 0.75]),
        (".5\t\t0.25\n", [0.5, before[1], 0.25]),
    ] {
        // All at once, one by one, and however many a slow frame may take.
        for at_once in [usize::MAX, 1, 2, 3, 5, 7] {
            let mut user = user();
            let events = [click(&user, "kd R"), typed(text)].concat();
            events.chunks(at_once.min(events.len())).for_each(|events| user.frame(events.to_vec()));
            user.settle();
            assert_eq!(kd(&user.editor, "a"), expected, "{text:?}, {at_once} at once");
            assert_eq!(user.wishes, Wishes::default());
        }
    }
}

#[test]
fn the_focus_goes_back_as_fast() {
    let mut user = user();
    let back = chord(Modifiers::SHIFT, Key::Tab);
    user.frame([click(&user, "kd G"), typed("0.5"), back, typed("0.25\n")].concat());
    user.settle();
    assert_eq!(kd(&user.editor, "a")[..2], [0.25, 0.5]);
}

#[test]
fn letters_are_keys_of_the_window_or_text_as_the_focus_has_it() {
    let mut user = user();
    user.frame([typed("s"), click(&user, "kd R"), typed("qest0.5\n"), typed("t")].concat());
    assert_eq!(user.wishes, Wishes { save: vec![Save::Png, Save::State], ..Wishes::default() });
}

#[test]
fn a_drag_in_one_frame_is_a_drag() {
    let picture = User::before(lit::lit(false), None).mirror.rect("picture");
    let (from, to) = (picture.center(), picture.center() + Vec2::new(0.25, 0.1) * picture.height());
    let steps =
        |n: usize| (1..=n).map(move |step| Event::PointerMoved(from + step as f32 / n as f32 * (to - from)));
    let events: Vec<Event> = [Event::PointerMoved(from), button(from, true)]
        .into_iter()
        .chain(steps(100))
        .chain([button(to, false)])
        .collect();
    let cameras = [usize::MAX, 1, 2, 10].map(|at_once| {
        let mut user = User::before(lit::lit(false), None);
        events.chunks(at_once.min(events.len())).for_each(|events| user.frame(events.to_vec()));
        user.editor.look().camera
    });
    // An eighth of a turn.
    let [x, y, z] = cameras[0].position;
    assert!((x.atan2(z).to_degrees() + 45.0).abs() < 0.01 && y > 0.5, "{:?}", cameras[0]);
    for camera in cameras {
        assert!(camera.position.iter().zip([x, y, z]).all(|(a, b)| (a - b).abs() < 1e-4), "{cameras:?}");
    }
}

#[test]
fn a_slider_follows_a_drag_in_one_frame() {
    let mut user = user();
    let rail = user.mirror.rect("shininess");
    let end = Pos2::new(rail.right() + 30.0, rail.center().y);
    user.frame(vec![
        Event::PointerMoved(rail.center()),
        button(rail.center(), true),
        Event::PointerMoved(end),
        button(end, false),
    ]);
    assert_eq!(blinn_phong(user.editor.look().materials["a"]).shininess, 200.0);
    // What comes after it does not count as part of it.
    user.frame(vec![Event::PointerMoved(rail.center())]);
    assert_eq!(blinn_phong(user.editor.look().materials["a"]).shininess, 200.0);
}

#[test]
fn escape_brings_back_what_was_before_a_field_was_typed_in() {
    let mut user = user();
    user.frame([click(&user, "kd R"), typed("0.125\t")].concat());
    let committed = user.editor.look();
    user.frame(typed("0.99"));
    user.settle();
    // The glossy reflectance has given way to what was typed; it comes back, too.
    assert_eq!(kd(&user.editor, "a")[1], 0.99);
    assert!(user.editor.look() != committed);
    user.frame(key(Key::Escape));
    user.settle();
    assert_eq!((user.editor.look(), &user.wishes), (committed.clone(), &Wishes::default()));
    // All in one.
    user.frame([click(&user, "kd B"), typed("0.5"), key(Key::Escape), key(Key::Escape)].concat());
    user.settle();
    assert_eq!((user.editor.look(), &user.wishes), (committed, &Wishes::default()));
}

#[test]
fn escape_brings_back_what_was_before_a_drag() {
    let mut user = user();
    let before = user.editor.look();
    let rail = user.mirror.rect("shininess");
    user.frame(press(rail.left_center()));
    assert!(user.editor.look() != before, "a slider follows the press");
    user.frame(vec![Event::PointerMoved(rail.center())]);
    user.frame(key(Key::Escape));
    assert_eq!(user.editor.look(), before);
    // The hand that still holds the button holds nothing any more.
    user.frame(vec![Event::PointerMoved(rail.right_center())]);
    user.frame(release(rail.right_center()));
    assert_eq!(user.editor.look(), before);

    let mut user = User::before(lit::lit(true), None);
    user.editor.advance(0.1);
    let (before, centre) = (user.editor.look(), user.mirror.rect("picture").center());
    user.frame(press(centre));
    user.frame(vec![Event::PointerMoved(centre + Vec2::new(90.0, 30.0))]);
    assert!(user.editor.look() != before);
    user.frame(key(Key::Escape));
    assert!(user.editor.is_playing() && user.editor.look() == before);
}

#[test]
fn escape_brings_an_animation_back_that_an_edit_has_paused() {
    let mut user = User::new(editor(true));
    user.click("a");
    user.editor.advance(0.1);
    let before = user.editor.look();
    let field = user.mirror.rect("kd R").center();
    user.frame(press(field));
    user.frame(vec![Event::PointerMoved(field + Vec2::new(60.0, 0.0))]);
    assert!(!user.editor.is_playing() && user.editor.is_held(&Part::Material("a".to_owned(), "kd")));
    user.frame(key(Key::Escape));
    assert!(
        user.editor.is_playing()
            && !user.editor.is_held(&Part::Material("a".to_owned(), "kd"))
            && user.editor.look() == before
    );
    // And time that was scrubbed.
    user.frame(release(field));
    let rail = user.mirror.rect("time");
    user.frame(press(rail.right_center()));
    assert!(!user.editor.is_playing() && user.editor.time_s() > 0.4);
    user.frame(key(Key::Escape));
    assert!(user.editor.is_playing() && user.editor.time_s() == 0.1);
}

#[test]
fn escape_closes_a_picker_and_nothing_else() {
    let mut user = user();
    user.click("kd");
    assert!(user.shows("U8"), "{:?}", user.mirror.names());
    let colour = user.editor.look();
    user.frame(key(Key::Escape));
    user.settle();
    assert!(!user.shows("U8"));
    for _ in 0..3 {
        user.frame(key(Key::Escape));
        assert_eq!(user.wishes, Wishes::default());
    }
    assert_eq!((user.editor.look(), user.editor.selected().unwrap().name.as_str()), (colour, "a"));
}

#[test]
fn text_is_copied_cut_and_pasted() {
    let mut user = user();
    user.frame(
        [click(&user, "kd R"), typed("0.375"), chord(Modifiers::COMMAND, Key::A), vec![Event::Copy]].concat(),
    );
    assert_eq!(user.mirror.copied, ["0.375"]);
    user.frame([key(Key::Tab), vec![Event::Paste("0.5".to_owned())], key(Key::Enter)].concat());
    user.settle();
    assert_eq!(kd(&user.editor, "a")[..2], [0.375, 0.5]);
    user.frame(
        [click(&user, "kd G"), vec![Event::Cut, Event::Paste("0.0625".to_owned())], key(Key::Enter)].concat(),
    );
    assert_eq!(user.mirror.copied, ["0.500"]);
    user.settle();
    assert_eq!(kd(&user.editor, "a")[..2], [0.375, 0.0625]);
    user.click("kd");
    let copy = user.mirror.rect("📋").center();
    user.frame([press(copy), release(copy)].concat());
    let bytes = user
        .mirror
        .copied
        .first()
        .map(|text| text.split(", ").map(|n| n.parse::<u8>().unwrap()).collect::<Vec<_>>());
    assert_eq!(bytes.map(|bytes| bytes.len()), Some(3));
}
