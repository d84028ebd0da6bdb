//! The keys, and the help that tells them.

use super::*;
use crate::support::mirror::chord;
use crate::ui::help::TITLE;
use crate::ui::keys::{Does, GESTURES, Group, TABLE};
use egui::Modifiers;

/// A user who can do whatever keys do: undo, do again, play, move, reset and copy.
fn user(editor: fn() -> Editor) -> User {
    let mut user = User::new(editor());
    let first = user.editor.materials().next().map(|material| material.name.clone());
    user.editor.select(first.as_deref());
    for ev in [1.0, 2.0] {
        user.editor.set_exposure(ev);
        user.editor.commit();
    }
    user.editor.undo();
    user.editor.move_camera(Motion::Orbit([0.2, 0.0]), &Surfaces::default());
    user.mirror.context().set_zoom_factor(1.5);
    (0..2).for_each(|_| user.frame(Vec::new()));
    user
}

/// What the keys of the window change.
fn digits(user: &User) -> String {
    format!(
        "{:?} {:?} {:?} {} {:?} {} {}",
        user.wishes,
        user.editor.settings(),
        (user.editor.undoes(), user.editor.redoes()),
        user.shows(TITLE),
        user.screen.title(Some(&user.editor), &user.facts),
        user.mirror.context().zoom_factor(),
        user.mirror.copied.concat(),
    )
}

#[test]
fn every_key_that_does_anything_stands_in_the_table() {
    let modifiers = [
        Modifiers::NONE,
        Modifiers::SHIFT,
        Modifiers::ALT,
        Modifiers::COMMAND,
        Modifiers::COMMAND | Modifiers::SHIFT,
    ];
    let mut found = Vec::new();
    for editor in [|| editor(true), || lit::lit(true)] as [fn() -> Editor; 2] {
        for key in Key::ALL {
            for modifiers in modifiers {
                let mut user = user(editor);
                let before = digits(&user);
                user.frame(chord(modifiers, *key));
                let wishes = std::mem::take(&mut user.wishes);
                (0..2).for_each(|_| user.frame(Vec::new()));
                user.wishes = wishes;
                if digits(&user) != before {
                    let of = TABLE.iter().find(|entry| {
                        entry
                            .chords()
                            .iter()
                            .any(|(of, other)| modifiers.matches_logically(*of) && other == key)
                    });
                    found.push(of.unwrap_or_else(|| panic!("{key:?} {modifiers:?} is told nowhere")).does);
                }
            }
        }
    }
    // And what is told does something, unless the system tells it by another name or it needs a reason.
    for entry in TABLE {
        let elsewhere = matches!(entry.does, Does::Copy | Does::Paste | Does::Cancel);
        assert!(elsewhere || found.contains(&entry.does), "{:?} does nothing", entry.does);
    }
}

#[test]
fn the_help_tells_all_and_goes_away() {
    let mut user = User::before(lit::lit(false), None);
    // But for the size of the picture, which nobody has to ask for.
    let asks_nothing =
        |user: &User| user.wishes == Wishes { picture: user.wishes.picture, ..Wishes::default() };
    for (opens, closes) in
        [(Key::F1, Key::F1), (Key::Questionmark, Key::Escape), (Key::F1, Key::Questionmark)]
    {
        user.frame(key(opens));
        user.settle();
        for entry in &TABLE {
            assert!(user.shows(entry.words) && user.shows(&entry.keys.join(" or ")), "{}", entry.words);
        }
        assert!(GESTURES.iter().all(|gesture| user.shows(gesture.how) && user.shows(gesture.words)));
        assert!(Group::ALL.iter().all(|group| user.shows(group.title())));
        // Nothing behind it is reached meanwhile.
        user.frame(key(Key::S));
        assert!(asks_nothing(&user), "{:?}", user.wishes);
        user.frame(key(closes));
        user.settle();
        assert!(!user.shows(TITLE) && asks_nothing(&user), "{:?}", user.wishes);
    }
    user.click("?");
    user.settle();
    assert!(user.shows(TITLE));
    user.click("Close help");
    user.settle();
    assert!(!user.shows(TITLE));
    // What asks before edits are lost comes first.
    user.frame(key(Key::F1));
    user.editor.set_exposure(3.0);
    user.screen.close();
    user.settle();
    assert!(!user.shows(TITLE) && user.shows("Close without saving?"));
}

#[test]
fn a_field_takes_a_question_mark_for_itself() {
    let mut user = User::new(editor(false));
    user.click("a");
    let field = user.mirror.rect("kd hex").center();
    user.frame(
        [press(field), release(field), vec![Event::Text("?".to_owned())], key(Key::Questionmark)].concat(),
    );
    user.settle();
    assert!(!user.shows(TITLE));
}

#[test]
fn no_tooltip_covers_a_question() {
    let mut user = User::new(editor(false));
    user.editor.set_exposure(3.0);
    user.frame(vec![Event::PointerMoved(user.mirror.rect("Undo").center())]);
    user.settle();
    let hint = "the exposure (Ctrl+Z)";
    assert!(user.shows(hint), "{:?}", user.mirror.names());
    for open in [|user: &mut User| user.screen.close(), |user: &mut User| user.frame(key(Key::F1))] {
        open(&mut user);
        user.settle();
        assert!(!user.shows(hint), "{:?}", user.mirror.names());
        user.frame(key(Key::Escape));
        user.settle();
        assert!(user.shows(hint), "it comes back");
    }
}
