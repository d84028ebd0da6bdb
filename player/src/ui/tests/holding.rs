//! What is held against an animation, and what it covers.

use super::*;
use relume_formats::state::BlinnPhong;

/// Drives two parameters of the material a.
const SWELL: &str = "duration_s = 1\n[[key]]\nt_s = 0\nmaterials.a = { kd = [0, 0, 0], shininess = 1 }\n\
                     [[key]]\nt_s = 1\nmaterials.a = { kd = [0.7, 0.7, 0.7], shininess = 101 }\n";

#[test]
fn only_the_parameter_that_is_edited_is_held() {
    let mut editor = editor(false);
    let start = blinn_phong(editor.look().materials["a"]);
    let swell = Animation::parse("swell", SWELL, &Place::file("swell")).unwrap();
    editor.take_animation(swell, &Place::file("swell")).unwrap();
    editor.scrub(0.25);
    editor.edit("a", &MaterialState { shininess: Some(7.0), ..Default::default() });
    editor.scrub(0.5);
    let a = blinn_phong(editor.look().materials["a"]);
    assert_eq!((a.kd, a.shininess), ([0.35; 3], 7.0), "the colour moves on");
    editor.choose(None);
    assert_eq!(
        blinn_phong(editor.look().materials["a"]),
        BlinnPhong { shininess: 7.0, ..start },
        "and was never edited"
    );
    // What shares its range with what is held gives way to it, though it moves.
    editor.choose(Some(editor.animations().len() - 1));
    editor.edit("a", &MaterialState { ks: Some([0.5; 3]), ..Default::default() });
    assert!(editor.is_held(&Part::Material("a".to_owned(), "ks")) && !editor.is_playing());
    for (time_s, expected) in [(0.25, 0.175), (0.5, 0.35), (1.0, 0.5)] {
        editor.scrub(time_s);
        let a = blinn_phong(editor.look().materials["a"]);
        assert_eq!(a.ks, [0.5; 3]);
        assert!(close(a.kd, [expected; 3]), "{a:?} at {time_s} s");
    }
    editor.reset("a");
    editor.scrub(1.0);
    assert_eq!(kd(&editor, "a"), [0.7; 3]);
}

#[test]
fn what_the_player_was_started_with_is_no_edit_that_an_animation_covers() {
    let text = "camera.exposure_ev = 2\nmaterials.a.kd = [0.1, 0.1, 0.1]";
    let state = relume_formats::state::parse_toml(text, &Place::file("start")).unwrap();
    let mut editor = Editor::new(&controls(&support::scene_meta(), state, false));
    editor.choose(Some(GLOW));
    assert_eq!(editor.covered(), []);
    editor.choose(None);
    editor.edit("a", &set_kd([0.2; 3]));
    editor.choose(Some(GLOW));
    assert_eq!(Part::words_of(&editor.covered()), ["material a"]);
}
