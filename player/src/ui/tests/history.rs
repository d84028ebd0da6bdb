//! Undo, redo, closing, copying and pasting.

use super::*;
use crate::support::mirror::typed;
use egui::{Modifiers, Vec2};
use relume_formats::state::{EnvironmentState, ShapeState};

const REDO: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// What undoing everything must bring back, in digits that tell every two numbers apart.
fn digits(editor: &Editor) -> String {
    let settings = editor.settings();
    let materials: Vec<_> =
        editor.scene().materials.iter().map(|m| editor.look().materials[&m.name]).collect();
    format!(
        "{materials:?} {:?} {:?} {:?} {:?}",
        settings.base.camera, settings.base.environment, settings.base.shapes, settings.held
    )
}

fn undo(user: &mut User) {
    user.frame(chord(Modifiers::COMMAND, Key::Z));
}

fn redo(user: &mut User) {
    user.frame(chord(REDO, Key::Z));
}

#[test]
fn a_drag_is_one_step_back_and_one_forth() {
    let mut user = User::new(editor(false));
    user.click("a");
    let start = digits(&user.editor);
    user.slide("shininess", 1.0);
    let sharp = digits(&user.editor);
    user.slide("exposure", 0.25);
    let dark = digits(&user.editor);
    undo(&mut user);
    assert_eq!(
        (digits(&user.editor), user.wishes.tell.clone()),
        (sharp.clone(), Some(Ok("undo: the exposure".to_owned())))
    );
    undo(&mut user);
    assert_eq!(
        (digits(&user.editor), user.wishes.tell.clone()),
        (start.clone(), Some(Ok("undo: material a".to_owned())))
    );
    undo(&mut user);
    assert_eq!(
        (digits(&user.editor), user.wishes.tell.clone()),
        (start.clone(), Some(Err("there is nothing to undo".to_owned())))
    );
    redo(&mut user);
    assert_eq!(digits(&user.editor), sharp);
    user.click("Redo");
    assert_eq!(digits(&user.editor), dark);
    assert!(user.mirror.is_disabled("Redo"));
    user.click("Undo");
    // A new edit ends what could be done again.
    user.click("Reset material");
    assert!(user.mirror.is_disabled("Redo") && digits(&user.editor) == start);
    undo(&mut user);
    assert_eq!(digits(&user.editor), sharp, "a reset is undone like anything else");
}

#[test]
fn a_turn_of_the_wheel_and_a_typed_number_are_one_step_each() {
    let mut user = User::before(lit::lit(false), None);
    let start = digits(&user.editor);
    let centre = user.mirror.rect("picture").center();
    let turn = Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: Vec2::new(0.0, 2.0),
        modifiers: Modifiers::NONE,
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
    };
    user.frame(vec![Event::PointerMoved(centre), turn.clone(), turn]);
    user.settle();
    let near = digits(&user.editor);
    assert_ne!(near, start);
    let field = user.mirror.rect("gain R").center();
    user.frame([press(field), release(field), typed("0.125\n")].concat());
    user.settle();
    assert_ne!(digits(&user.editor), near);
    undo(&mut user);
    assert_eq!(digits(&user.editor), near);
    undo(&mut user);
    assert_eq!(digits(&user.editor), start);
}

#[test]
fn numbers_typed_one_after_the_other_are_steps_of_their_own() {
    let mut user = User::new(editor(false));
    user.click("a");
    let start = kd(&user.editor, "a");
    let field = user.mirror.rect("kd R").center();
    user.frame([press(field), release(field), typed("0.125\t0.0625\n")].concat());
    user.settle();
    assert_eq!(kd(&user.editor, "a"), [0.125, 0.0625, start[2]]);
    // A field that keeps the focus does not swallow what is dragged meanwhile.
    let field = user.mirror.rect("kd B").center();
    user.frame([press(field), release(field), typed("0.25")].concat());
    user.slide("shininess", 1.0);
    user.slide("exposure", 0.0);
    user.frame(key(Key::Enter));
    user.settle();
    for expected in ["the exposure", "material a", "material a"] {
        assert_eq!(user.editor.undo().as_deref(), Some(expected));
    }
    assert_eq!(kd(&user.editor, "a"), [0.125, 0.0625, start[2]]);
    user.editor.undo();
    assert_eq!(kd(&user.editor, "a"), [0.125, start[1], start[2]]);
    user.editor.undo();
    assert_eq!(kd(&user.editor, "a"), start);
}

#[test]
fn what_is_under_way_is_not_undone() {
    let mut user = User::new(editor(false));
    user.click("a");
    user.slide("shininess", 1.0);
    let rail = user.mirror.rect("exposure");
    user.frame(press(rail.left_center()));
    let held = digits(&user.editor);
    undo(&mut user);
    assert_eq!((digits(&user.editor), user.wishes.tell.clone()), (held, None));
    user.frame(release(rail.left_center()));
    // In a field, the keys are the field's.
    let field = user.mirror.rect("kd R").center();
    user.frame([press(field), release(field), typed("0.5")].concat());
    undo(&mut user);
    assert_eq!(user.wishes.tell, None);
}

#[test]
fn holding_against_an_animation_is_undone_too() {
    let mut editor = editor(true);
    editor.advance(0.1);
    let before = editor.look();
    editor.edit("a", &set_kd([0.0, 0.7, 0.0]));
    editor.commit();
    assert!(editor.undo().is_some() && !editor.is_held(&Part::Material("a".to_owned(), "kd")));
    assert_eq!(editor.look(), before);
    assert!(editor.redo().is_some() && editor.is_held(&Part::Material("a".to_owned(), "kd")));
    assert_eq!(kd(&editor, "a"), [0.0, 0.7, 0.0]);
    editor.choose(Some(FADE));
    editor.commit();
    assert_eq!(editor.undoes(), Some("the animation"));
    assert_eq!(editor.undo().as_deref(), Some("the animation"));
    assert_eq!((editor.active(), editor.is_playing()), (Some(GLOW), false));
}

/// SplitMix64, 0..below.
fn random(seed: &mut u64, below: u64) -> u64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) % below
}

/// An edit of anything, or a step back or forth.
fn anything(editor: &mut Editor, seed: &mut u64) {
    let number = |seed: &mut u64| {
        [-0.0, 0.0, 0.25, 1.0, -3.0, 1e9, f32::NAN][random(seed, 7) as usize]
            + random(seed, 1000) as f32 / 1000.0
    };
    let material = ["a", "b", "fixed"][random(seed, 3) as usize];
    let colour = [number(seed), number(seed), number(seed)];
    match random(seed, 16) {
        0 => editor.edit(
            material,
            &MaterialState { kd: Some(colour), base_color: Some(colour), ..Default::default() },
        ),
        1 => editor.edit(
            material,
            &MaterialState {
                ks: Some(colour),
                shininess: Some(number(seed)),
                roughness: Some(number(seed)),
                ..Default::default()
            },
        ),
        2 => editor.reset(material),
        3 => editor.set_exposure(number(seed)),
        4 => editor.reset_exposure(),
        5 => editor.edit_light(&EnvironmentState {
            gain: Some(colour),
            rotation_deg: Some(number(seed)),
            map: None,
        }),
        6 => editor.reset_light(),
        7 => editor.move_camera(Motion::Orbit([number(seed), number(seed)]), &Surfaces::default()),
        8 => editor.reset_view(),
        9 => {
            let object = editor.scene().shapes.first().map(|shape| shape.object.clone()).unwrap_or_default();
            editor.edit_shape(&object, &ShapeState { time_s: Some(number(seed)), ..Default::default() });
        }
        10 => editor.choose([None, Some(FADE), Some(GLOW)][random(seed, 3) as usize]),
        11 => editor.play_or_pause(),
        12 => editor.reset_all(),
        13 => drop(editor.redo()),
        _ => drop(editor.undo()),
    }
    editor.advance(0.01);
    if random(seed, 4) > 0 {
        editor.commit();
    }
}

#[test]
fn after_ten_thousand_events_all_can_be_undone_and_done_again() {
    for (mut seed, mut editor) in
        [(1, editor(false)), (2, editor(true)), (3, lit::lit(true)), (4, shapes::editor())]
    {
        let start = digits_at_rest(&editor);
        for _ in 0..10_000 {
            anything(&mut editor, &mut seed);
        }
        while editor.redo().is_some() {}
        let end = digits_at_rest(&editor);
        let mut steps = 0;
        while editor.undo().is_some() {
            steps += 1;
        }
        assert!(steps > 100, "{steps} of seed {seed}");
        assert_eq!(digits_at_rest(&editor), start);
        while editor.redo().is_some() {}
        assert_eq!(digits_at_rest(&editor), end);
    }
}

/// As without the animation, which goes on by itself.
fn digits_at_rest(editor: &Editor) -> String {
    let settings = editor.settings();
    let base = &settings.base;
    let materials: Vec<_> = editor.scene().materials.iter().map(|m| base.materials[&m.name]).collect();
    format!(
        "{materials:?} {:?} {:?} {:?} {:?} {:?}",
        base.camera,
        base.environment,
        base.shapes,
        settings.held,
        editor.active()
    )
}

#[test]
fn edits_are_not_lost_by_closing() {
    let mut user = User::new(editor(false));
    user.screen.close();
    user.frame(Vec::new());
    assert_eq!(user.wishes, Wishes { close: true, ..Wishes::default() }, "nothing to lose");
    user.click("a");
    user.slide("shininess", 1.0);
    user.frame(key(Key::Q));
    user.settle();
    assert!(user.shows("Edits of material a are in no state file"), "{:?}", user.mirror.names());
    assert_eq!(user.wishes, Wishes::default());
    // Keys of the window mean nothing meanwhile, and neither does what is behind the question.
    user.frame(typed("st "));
    user.slide("exposure", 0.0);
    assert!(user.wishes == Wishes::default() && user.editor.look().camera.exposure_ev == 0.5);
    user.frame(key(Key::Escape));
    user.settle();
    assert!(!user.shows("in no state file") && user.wishes == Wishes::default());
    user.screen.close();
    user.settle();
    user.click("Cancel");
    assert!(!user.shows("in no state file") && user.wishes == Wishes::default());
    for (button, save) in [("Close without saving", Vec::new()), ("Save state and close", vec![Save::State])]
    {
        user.screen.close();
        user.settle();
        user.click(button);
        assert_eq!(user.wishes, Wishes { save, close: true, ..Wishes::default() });
    }
    user.screen.close();
    user.settle();
    user.frame(key(Key::Enter));
    assert_eq!(user.wishes, Wishes { save: vec![Save::State], close: true, ..Wishes::default() });
    user.editor.mark_saved();
    user.frame(key(Key::Q));
    assert!(user.wishes.close, "saved is not lost");
    undo(&mut user);
    assert_eq!(user.editor.unsaved(), None, "as at the start");
    redo(&mut user);
    assert_eq!(user.editor.unsaved(), None);
    // Told is what has changed since the nearer of the two.
    user.editor.set_exposure(2.0);
    assert_eq!(user.editor.unsaved().as_deref(), Some("the exposure"), "since it was saved");
    user.editor.reset("a");
    assert_eq!(user.editor.unsaved().as_deref(), Some("the exposure"), "since the start");
    user.editor.reset_exposure();
    assert_eq!(user.editor.unsaved(), None);
}

#[test]
fn everything_is_reset_at_once() {
    let mut user = User::new(editor(true));
    assert!(user.mirror.is_disabled("Reset all"));
    user.click("a");
    user.slide("shininess", 1.0);
    user.slide("exposure", 0.0);
    let edited = digits(&user.editor);
    user.click("Reset all");
    assert_eq!(user.editor.settings().base, Look::default_of(user.editor.scene()));
    assert!(user.editor.settings().held.is_empty() && user.mirror.is_disabled("Reset all"));
    undo(&mut user);
    assert_eq!(digits(&user.editor), edited);
}

#[test]
fn a_material_is_copied_to_another() {
    let mut user = User::new(editor(false));
    user.click("a");
    user.frame(vec![Event::Copy]);
    let text = user.mirror.copied.concat();
    assert!(text.starts_with("[materials.a]\nkd = ["), "{text}");
    user.click("b");
    user.frame(vec![Event::Paste(text.clone())]);
    assert_eq!(user.editor.look().materials["b"], user.editor.look().materials["a"]);
    assert_eq!(user.wishes.tell, Some(Ok("pasted a on b".to_owned())));
    undo(&mut user);
    assert_ne!(user.editor.look().materials["b"], user.editor.look().materials["a"]);
    user.click("Copy");
    assert_ne!(user.mirror.copied.concat(), text);
    user.click("Paste");
    assert!(user.wishes.paste);
    // A whole state.
    user.frame(vec![Event::Paste(
        "camera.exposure_ev = 2\nmaterials.a.shininess = 3\nmaterials.b.shininess = 4".to_owned(),
    )]);
    let look = user.editor.look();
    assert_eq!(
        (
            look.camera.exposure_ev,
            blinn_phong(look.materials["a"]).shininess,
            blinn_phong(look.materials["b"]).shininess
        ),
        (2.0, 3.0, 4.0)
    );
    let before = digits(&user.editor);
    for (text, part) in [
        ("hello", "no material and no state"),
        ("", "is empty"),
        ("materials.x.roughness = 0.5", "clipboard: material `b`"),
        ("materials.x.shininess = 1e9", "clipboard: material `b`"),
        ("camera.position = [0, 0, 9]", "clipboard: "),
        ("camera.exposure_ev = 99", "clipboard: camera: exposure_ev 99"),
        ("camera.exposure_ev = 1\nmaterials.x.kd = [0, 0, 0]", "x"),
    ] {
        user.frame(vec![Event::Paste(text.to_owned())]);
        let told = user.wishes.tell.clone();
        assert!(
            told.clone().is_some_and(|told| told.is_err_and(|reason| reason.contains(part))),
            "{text}: {told:?}"
        );
        assert_eq!(digits(&user.editor), before);
    }
}

#[test]
fn colours_are_hexadecimal_digits_too() {
    let mut user = User::new(editor(false));
    user.click("a");
    let enter = |user: &mut User, text: &str| {
        let field = user.mirror.rect("ks hex").center();
        user.frame(
            [
                press(field),
                release(field),
                chord(Modifiers::COMMAND, Key::A),
                vec![Event::Paste(text.to_owned())],
                key(Key::Enter),
            ]
            .concat(),
        );
        user.settle();
        blinn_phong(user.editor.look().materials["a"]).ks
    };
    let before = blinn_phong(user.editor.look().materials["a"]).ks;
    assert_eq!(enter(&mut user, "no"), before);
    let black = enter(&mut user, "#000000");
    assert_eq!(black, [0.0; 3]);
    let grey = enter(&mut user, "808080");
    assert!(close(grey, [0.215_860_5; 3]), "{grey:?}");
    undo(&mut user);
    assert_eq!(blinn_phong(user.editor.look().materials["a"]).ks, black);
    // Called off.
    let field = user.mirror.rect("ks hex").center();
    user.frame(
        [press(field), release(field), chord(Modifiers::COMMAND, Key::A), typed("fff"), key(Key::Escape)]
            .concat(),
    );
    user.settle();
    assert_eq!(blinn_phong(user.editor.look().materials["a"]).ks, black);
}
