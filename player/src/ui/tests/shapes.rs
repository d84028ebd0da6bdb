//! A bundle whose shapes deform.

use super::*;
use relume_formats::kinds::scene::{StoredClip, StoredObject, StoredShape};
use relume_formats::method::SPHERE_SHADOWS;
use relume_formats::state::{Posed, ShapeState};
use relume_playback::Scope;

fn scope() -> Scope {
    let clip = |name: &str| StoredClip { name: name.to_owned(), duration_s: 2.0 };
    let mut scope = Scope { card: &SPHERE_SHADOWS, ..support::sparse::scope() };
    scope.scene.varies_shape = true;
    scope.scene.objects.push(StoredObject { name: "fox".to_owned(), material: 0, triangles: 0 });
    scope.scene.shapes =
        vec![StoredShape { object: "fox".to_owned(), clips: vec![clip("Walk"), clip("Run")] }];
    scope
}

/// With an animation of the fox, which plays.
pub(super) fn editor() -> Editor {
    let text = "duration_s = 1.0\n[[key]]\nt_s = 0\nshapes.fox = { clip = \"Walk\", time_s = 0.0 }\n[[key]]\nt_s = 1\nshapes.fox.time_s = 2.0";
    let place = Place::file("walk");
    let walk = PlacedAnimation { animation: Animation::parse("walk", text, &place).unwrap(), place };
    let state = PlacedState { state: State::default(), place: Place::file("state") };
    Editor::new(&Controls::new(scope(), &state, Some(walk), Vec::new()).unwrap())
}

fn shows(editor: &Editor) -> Option<Posed> {
    editor.look().shapes.get("fox").cloned()
}

fn posed(clip: &str, time_s: f32) -> Option<Posed> {
    Some(Posed { clip: clip.to_owned(), time_s })
}

#[test]
fn a_shape_that_is_set_holds_against_the_animation() {
    let mut editor = editor();
    editor.advance(0.25);
    assert_eq!(shows(&editor), posed("Walk", 0.5));
    editor.edit_shape("fox", &ShapeState { clip: Some("Run".to_owned()), ..ShapeState::default() });
    assert!(!editor.is_playing() && editor.is_held(&Part::Shape("fox".to_owned())));
    editor.scrub(0.75);
    assert_eq!(shows(&editor), posed("Run", 0.5));
    // What is illegal or unknown changes nothing.
    editor.edit_shape("fox", &ShapeState { clip: Some("Fly".to_owned()), ..ShapeState::default() });
    editor.edit_shape("hen", &ShapeState { clip: Some("Run".to_owned()), ..ShapeState::default() });
    assert_eq!(shows(&editor), posed("Run", 0.5));
    let text = toml::to_string(&editor.state()).unwrap();
    let state: State = relume_formats::state::parse_toml(&text, &Place::file("saved")).unwrap();
    let state = PlacedState { state, place: Place::file("saved") };
    assert_eq!(*Controls::new(scope(), &state, None, Vec::new()).unwrap().base(), editor.look(), "{text}");
    editor.reset_shape("fox");
    assert_eq!(shows(&editor), posed("Walk", 1.5), "the animation has it again");
    editor.choose(None);
    assert_eq!(shows(&editor), None);
}

#[test]
fn clip_and_time_are_set_in_the_panel() {
    let mut editor = editor();
    editor.choose(None);
    let mut user = User::before(editor, None);
    assert!(
        user.shows("SHAPES")
            && user.mirror.is_disabled("Reset fox")
            && user.mirror.is_disabled("time of fox")
    );
    user.click("clip of fox");
    user.click("Run");
    assert_eq!(shows(&user.editor), posed("Run", 0.0));
    user.slide("time of fox", 1.0);
    assert_eq!(shows(&user.editor), posed("Run", 2.0));
    user.click("Reset fox");
    assert_eq!(shows(&user.editor), None);
    assert!(!User::before(super::editor(false), None).shows("SHAPES"));
}
