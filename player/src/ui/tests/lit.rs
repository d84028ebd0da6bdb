//! Bundles whose light and view vary.

use super::*;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::state::EnvironmentState;

/// Settings of a bundle whose light and view vary, with the animations `turn`, which plays if `plays`, and
/// `glow`.
pub(super) fn lit(plays: bool) -> Editor {
    let placed = |name: &str, text: &str| {
        let place = Place::file(name);
        PlacedAnimation { animation: Animation::parse(name, text, &place).unwrap(), place }
    };
    let (turn, glow) = (placed("turn", support::sparse::TURN), placed("glow", support::ANIMATION));
    let state = PlacedState { state: State::default(), place: Place::file("state") };
    let (first, others) = if plays { (Some(turn), vec![glow]) } else { (None, vec![glow, turn]) };
    Editor::new(&Controls::new(support::sparse::scope(), &state, first, others).unwrap())
}

fn light(editor: &Editor) -> EnvironmentLook {
    editor.look().environment.unwrap()
}

#[test]
fn animations_of_what_does_not_vary_are_not_on_offer() {
    assert_eq!(lit(false).animations().iter().map(|a| a.name.as_str()).collect::<Vec<_>>(), ["turn"]);
}

#[test]
fn an_edit_of_the_light_holds_its_leaf_and_no_other() {
    let mut editor = lit(true);
    editor.advance(0.5);
    assert_eq!(
        light(&editor),
        EnvironmentLook { map: "noise".to_owned(), rotation_deg: 45.0, gain: [1.5, 1.0, 0.5] }
    );
    editor.edit_light(&EnvironmentState { rotation_deg: Some(-10.0), ..Default::default() });
    assert!(
        !editor.is_playing()
            && editor.is_held(&Part::Light("rotation_deg"))
            && !editor.is_held(&Part::Light("gain"))
    );
    editor.scrub(1.0);
    assert_eq!(
        light(&editor),
        EnvironmentLook { map: "sun".to_owned(), rotation_deg: -10.0, gain: [2.0, 1.0, 0.0] }
    );
    editor.move_camera(Motion::Orbit([0.1, 0.0]), &Surfaces::default());
    let moved = editor.look().camera;
    editor.scrub(0.0);
    assert_eq!(editor.look().camera, moved, "the view is held, too");
    editor.reset_view();
    editor.reset_light();
    assert_eq!((light(&editor).rotation_deg, editor.look().camera.position), (0.0, [0.0, 0.0, 3.0]));
    // What is illegal or unknown changes nothing.
    let before = editor.look();
    for change in [
        EnvironmentState { map: Some("moon".to_owned()), ..Default::default() },
        EnvironmentState { rotation_deg: Some(f32::NAN), ..Default::default() },
        EnvironmentState { gain: Some([1.0, -1.0, 1.0]), ..Default::default() },
    ] {
        editor.edit_light(&change);
        assert_eq!(editor.look(), before);
    }
}

#[test]
fn a_saved_light_and_view_lead_to_the_same_look() {
    let mut editor = lit(true);
    editor.scrub(0.3);
    editor.move_camera(Motion::Pan([0.1, 0.2]), &Surfaces::default());
    editor.edit_light(&EnvironmentState { map: Some("even".to_owned()), ..Default::default() });
    let text = toml::to_string(&editor.state()).unwrap();
    let state: State = relume_formats::state::parse_toml(&text, &Place::file("saved")).unwrap();
    let state = PlacedState { state, place: Place::file("saved") };
    assert_eq!(
        *Controls::new(support::sparse::scope(), &state, None, Vec::new()).unwrap().base(),
        editor.look(),
        "{text}"
    );
    assert_eq!(toml::to_string(&lit(false).state()).unwrap(), "");
}

#[test]
fn the_light_is_set_in_the_panel() {
    let mut user = User::before(lit(false), None);
    assert!(
        !user.shows("MATERIALS")
            && user.mirror.is_disabled("Reset light")
            && user.mirror.is_disabled("Reset view")
    );
    user.slide("rotation", 0.75);
    // Sliders prefer round numbers close by.
    assert!((light(&user.editor).rotation_deg - 90.0).abs() <= 10.0, "{}", light(&user.editor).rotation_deg);
    user.slide("gain", 1.0);
    assert_eq!(light(&user.editor).gain, [100.0; 3]);
    user.slide("gain", 0.0);
    assert_eq!(light(&user.editor).gain, [0.0; 3]);
    let field = user.mirror.rect("gain G").center();
    user.frame(press(field));
    user.frame(vec![Event::PointerMoved(field + egui::Vec2::new(100.0, 0.0))]);
    user.frame(release(field + egui::Vec2::new(100.0, 0.0)));
    let [r, g, b] = light(&user.editor).gain;
    assert!((r, b) == (0.0, 0.0) && g > 0.5, "{r} {g} {b}");
    user.click("map");
    user.click("sun");
    assert_eq!(light(&user.editor).map, "sun");
    user.click("Reset light");
    assert_eq!(Some(light(&user.editor)), user.editor.scene().environment);
}

#[test]
fn merely_showing_the_light_changes_nothing() {
    let mut user = User::before(lit(false), None);
    (0..5).for_each(|_| user.frame(vec![Event::PointerMoved(Pos2::new(3.0, 3.0))]));
    assert_eq!(user.editor.look(), Look::default_of(user.editor.scene()));
    (0..60).for_each(|_| user.frame(Vec::new()));
    assert!(!user.mirror.restless);
    let mut user = User::before(lit(true), None);
    for _ in 0..20 {
        user.editor.advance(0.012_345);
        user.frame(Vec::new());
    }
    assert!(user.editor.is_playing());
}

#[test]
fn the_pointer_moves_the_camera() {
    let mut user = User::before(lit(false), None);
    let home = user.editor.scene().camera;
    let picture = user.mirror.rect("picture");
    let (from, to) = (picture.center(), picture.center() + egui::Vec2::new(0.25 * picture.height(), 0.0));
    user.drag(PointerButton::Primary, from, to);
    // An eighth of a turn: the front goes to the right, so the camera goes to the left.
    let camera = user.editor.look().camera;
    assert!(
        (camera.position[0] + 3.0 * 0.5_f32.sqrt()).abs() < 1e-3 && camera.target == home.target,
        "{camera:?}"
    );
    assert!(!user.mirror.is_disabled("Reset view"));
    user.click("Reset view");
    assert_eq!(user.editor.look().camera, home);
    for button in [PointerButton::Secondary, PointerButton::Middle] {
        user.drag(button, from, to);
        let camera = user.editor.look().camera;
        assert!(
            camera.target[0] < -0.1 && (camera.position[0] - camera.target[0]).abs() < 1e-5,
            "{camera:?}"
        );
        user.frame(key(Key::V));
        assert_eq!(user.editor.look().camera, home);
    }
    user.frame(vec![Event::PointerMoved(from)]);
    let (unit, source, phase) =
        (egui::MouseWheelUnit::Point, egui::MouseWheelSource::Unknown, egui::TouchPhase::Move);
    let delta = egui::Vec2::new(0.0, 100.0);
    user.frame(vec![Event::MouseWheel { unit, source, phase, delta, modifiers: Default::default() }]);
    (0..20).for_each(|_| user.frame(Vec::new()));
    let nearer = user.editor.look().camera;
    assert!((1.0..2.9).contains(&nearer.position[2]), "{nearer:?}");
    // Beside the picture, and where the view is fixed, nothing moves.
    let below = Pos2::new(4.0, picture.bottom() + 8.0);
    user.drag(PointerButton::Primary, below, below + egui::Vec2::new(200.0, 0.0));
    assert_eq!(user.editor.look().camera, nearer);
    let mut user = User::new(editor(false));
    user.drag(PointerButton::Primary, from, to);
    user.frame(key(Key::V));
    assert_eq!(user.editor.look().camera, user.editor.scene().camera);
}

#[test]
fn the_picture_fills_the_room_that_there_is() {
    let mut user = User::before(lit(false), None);
    let expect = |user: &User, width: f32| {
        let picture = user.mirror.rect("picture");
        assert_eq!(picture.min, Pos2::ZERO);
        assert_eq!(picture.width(), width, "as far as the panel");
        assert!(picture.height() > 700.0 && picture.height() < 800.0, "{picture}: as far as the line below");
        assert_eq!(user.wishes.picture, Some([picture.width() as u32, picture.height() as u32]));
    };
    expect(&user, 1200.0 - 344.0);
    // Twice as many pixels on the display.
    user.mirror.context().set_zoom_factor(1.25);
    (0..3).for_each(|_| user.frame(Vec::new()));
    let picture = user.mirror.rect("picture");
    let [width, height] = user.wishes.picture.unwrap();
    let scale = user.mirror.context().pixels_per_point();
    assert_eq!(
        [picture.width() * scale, picture.height() * scale].map(f32::round),
        [width, height].map(|n| n as f32)
    );
    // What has a size of its own keeps it.
    let user = User::new(editor(false));
    assert_eq!(user.wishes.picture, None);
    assert!(user.mirror.rect("picture").min.x >= 12.0);
}
