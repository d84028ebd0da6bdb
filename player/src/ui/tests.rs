//! The editor by itself, and through the screen as a user works it.

mod display;
mod hands;
mod help;
mod history;
mod holding;
mod kept;
mod lit;
mod places;
mod shapes;
mod user;

use super::*;
use crate::support::mirror::{Mirror, chord, key, press, release};
use crate::support::{self, Bundle, blinn_phong};
use egui::{Event, Key, PointerButton, Pos2, TextureId};
use relume_formats::Place;
use relume_formats::kinds::scene;
use relume_formats::state::{Animation, Brdf, CookTorrance, MaterialState, State};
use relume_playback::{Controls, Look, PlacedAnimation, PlacedState};
use relume_playback::{Seen, Surfaces};
use user::User;

/// Places of the animations in the list.
const FADE: usize = 0;
const GLOW: usize = 1;

/// Controls of `meta`, with the animation `glow` playing if `plays`, else on offer, and a second one on
/// offer.
fn controls(meta: &scene::Meta, state: State, plays: bool) -> Controls {
    let placed = |name: &str, text: &str| {
        let place = Place::file(name);
        PlacedAnimation { animation: Animation::parse(name, text, &place).unwrap(), place }
    };
    let (glow, fade) = (placed("glow", support::ANIMATION), placed("fade", support::FADE));
    let state = PlacedState { state, place: Place::file("state") };
    let (first, others) = if plays { (Some(glow), vec![fade]) } else { (None, vec![fade, glow]) };
    Controls::new(support::scope(meta.clone()), &state, first, others).unwrap()
}

fn editor(plays: bool) -> Editor {
    Editor::new(&controls(&support::scene_meta(), State::default(), plays))
}

fn kd(editor: &Editor, name: &str) -> [f32; 3] {
    blinn_phong(editor.look().materials[name]).kd
}

fn set_kd(kd: [f32; 3]) -> MaterialState {
    MaterialState { kd: Some(kd), ..Default::default() }
}

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn time_passes_as_the_animation_says() {
    let mut editor = editor(true);
    assert!(editor.is_playing() && close(kd(&editor, "a"), [0.1, 0.2, 0.3]));
    editor.advance(0.125);
    assert!(close(kd(&editor, "a"), [0.3, 0.2, 0.15]), "halfway to the key at 0.25 s");
    editor.advance(0.5);
    assert!((editor.time_s() - 0.125).abs() < 1e-9, "it loops after half a second");
    editor.play_or_pause();
    editor.advance(3.0);
    assert!((editor.time_s() - 0.125).abs() < 1e-9 && !editor.is_playing());
    // The second one does not loop: it stops at its end, and plays from the start again.
    editor.choose(Some(FADE));
    editor.advance(100.0);
    assert_eq!((editor.time_s(), editor.is_playing(), editor.look().camera.exposure_ev), (2.0, false, -4.0));
    editor.play_or_pause();
    assert_eq!((editor.time_s(), editor.is_playing()), (0.0, true));
    editor.choose(Some(7));
    assert_eq!((editor.active(), editor.is_playing()), (None, false));
    editor.advance(1.0);
    editor.play_or_pause();
    editor.scrub(1.0);
    assert_eq!((editor.time_s(), editor.look()), (0.0, Look::default_of(editor.scene())));
}

#[test]
fn scrubbing_pauses_and_stays_within_the_animation() {
    let mut editor = editor(true);
    for (to, is) in [(0.25, 0.25), (-1.0, 0.0), (9.0, 0.5), (f64::NAN, 0.5)] {
        editor.play_or_pause();
        editor.scrub(to);
        assert_eq!((editor.time_s(), editor.is_playing()), (is, false));
    }
}

#[test]
fn an_edit_holds_against_the_animation_until_reset() {
    let mut editor = editor(true);
    editor.edit("a", &set_kd([0.0, 0.7, 0.0]));
    assert!(
        !editor.is_playing() && editor.is_held(&Part::Material("a".to_owned(), "kd")),
        "editing what moves pauses it"
    );
    editor.scrub(0.25);
    assert_eq!(kd(&editor, "a"), [0.0, 0.7, 0.0]);
    editor.play_or_pause();
    assert_eq!(kd(&editor, "a"), [0.0, 0.7, 0.0], "what was edited by hand is kept while it plays");
    editor.reset("a");
    assert!(
        close(kd(&editor, "a"), [0.5, 0.2, 0.0])
            && editor.is_playing()
            && !editor.is_held(&Part::Material("a".to_owned(), "kd"))
    );
    // What the animation does not drive is edited while it plays.
    editor.edit("b", &set_kd([0.0, 0.0, 0.6]));
    assert!(editor.is_playing() && !editor.is_held(&Part::Material("b".to_owned(), "kd")));
    assert_eq!(kd(&editor, "b"), [0.0, 0.0, 0.6]);
    editor.reset("b");
    assert_eq!(editor.look().materials["b"], editor.scene().materials[1].brdf);
}

#[test]
fn exposure_obeys_the_same_rule() {
    let mut editor = editor(false);
    editor.choose(Some(FADE));
    editor.advance(1.0);
    assert!((editor.look().camera.exposure_ev + 2.0).abs() < 1e-6);
    editor.set_exposure(3.0);
    assert_eq!((editor.look().camera.exposure_ev, editor.is_playing()), (3.0, false));
    editor.play_or_pause();
    assert_eq!(editor.look().camera.exposure_ev, 3.0);
    editor.reset_exposure();
    assert!((editor.look().camera.exposure_ev + 2.0).abs() < 1e-6);
    editor.choose(None);
    assert_eq!(editor.look().camera.exposure_ev, 0.5);
    // An edit from before the animation was chosen is covered by it, and still there without it.
    editor.set_exposure(3.0);
    editor.choose(Some(FADE));
    editor.advance(1.0);
    assert_eq!(
        (editor.covered(), (editor.look().camera.exposure_ev + 2.0).abs() < 1e-6),
        (vec![Part::Exposure], true)
    );
    editor.choose(None);
    assert_eq!((editor.covered(), editor.look().camera.exposure_ev), (Vec::new(), 3.0));
    editor.set_exposure(f32::NAN);
    editor.set_exposure(1e9);
    assert_eq!(editor.look().camera.exposure_ev, 32.0);
    editor.reset_exposure();
    assert_eq!(editor.look().camera.exposure_ev, 0.5);
}

#[test]
fn an_animation_over_an_edit_stays_legal() {
    let mut editor = editor(false);
    editor.edit("a", &MaterialState { ks: Some([0.9; 3]), ..Default::default() });
    editor.choose(Some(GLOW));
    for step in 0..50 {
        editor.advance(0.01);
        let look = editor.look();
        for material in editor.materials() {
            material.validate(&look.materials[&material.name], &Place::file("look")).unwrap();
        }
        let a = blinn_phong(look.materials["a"]);
        assert!(
            a.kd.iter().zip(a.ks).all(|(kd, ks)| (ks - f32::min(0.9, 1.0 - kd)).abs() < 1e-6),
            "{step}: {a:?}"
        );
    }
}

#[test]
fn only_what_varies_is_selected_or_edited() {
    let mut editor = editor(false);
    let before = editor.look();
    editor.select(Some("fixed"));
    editor.edit("fixed", &set_kd([0.0; 3]));
    editor.edit("nobody", &set_kd([0.0; 3]));
    editor.reset("fixed");
    assert_eq!((editor.selected(), editor.look()), (None, before));
    assert_eq!(editor.materials().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["b", "a"]);
}

#[test]
fn a_saved_state_leads_to_the_same_look() {
    assert_eq!(toml::to_string(&editor(false).state()).unwrap(), "", "the scene itself needs no words");
    let mut editor = editor(true);
    editor.scrub(0.1);
    editor.edit("b", &MaterialState { shininess: Some(1.0 / 3.0 + 7.0), ..Default::default() });
    editor.set_exposure(-1.1);
    let text = toml::to_string(&editor.state()).unwrap();
    let state: State = relume_formats::state::parse_toml(&text, &Place::file("saved")).unwrap();
    assert_eq!(*controls(&support::scene_meta(), state, false).base(), editor.look(), "{text}");
}

#[test]
fn a_click_on_the_picture_selects_what_is_there() {
    let mut user = User::new(editor(false));
    user.click_at(user.pixel_of(|seen| seen == Seen::Material("a")));
    assert_eq!(user.editor.selected().unwrap().name, "a");
    user.click_at(user.pixel_of(|seen| seen == Seen::Material("b")));
    assert_eq!(user.editor.selected().unwrap().name, "b");
    // What is fixed says so and leaves the selection alone.
    user.click_at(user.pixel_of(|seen| seen == Seen::Fixed));
    assert_eq!(user.editor.selected().unwrap().name, "b");
    user.click("a");
    assert_eq!(user.editor.selected().unwrap().name, "a", "by its name in the list");
}

#[test]
fn sliders_edit_the_selected_material() {
    let mut user = User::new(editor(false));
    user.click("a");
    let before = blinn_phong(user.editor.look().materials["a"]);
    user.slide("shininess", 1.0);
    let after = blinn_phong(user.editor.look().materials["a"]);
    assert_eq!((after.shininess, after.kd, after.ks), (200.0, before.kd, before.ks));
    assert!(user.shows("a  (edited)"));
    user.slide("exposure", 0.0);
    assert_eq!(user.editor.look().camera.exposure_ev, -9.5, "ten EV below the scene's");
    user.click("Reset material");
    assert_eq!(user.editor.look().materials["a"], Brdf::BlinnPhong(before));
    assert!(!user.shows("(edited)") && user.mirror.is_disabled("Reset material"));
}

#[test]
fn merely_showing_a_material_changes_nothing() {
    let mut user = User::new(editor(false));
    for name in ["a", "b"] {
        user.click(name);
        user.click("kd");
        (0..5).for_each(|_| user.frame(vec![Event::PointerMoved(Pos2::new(3.0, 3.0))]));
        user.frame(key(Key::Escape));
    }
    assert_eq!(user.editor.look(), Look::default_of(user.editor.scene()));
}

#[test]
fn the_reflectance_that_gives_way_is_told() {
    let mut user = User::new(editor(false));
    user.click("a");
    let field = user.mirror.rect("kd R").center();
    user.frame(press(field));
    user.frame(vec![Event::PointerMoved(field + egui::Vec2::new(400.0, 0.0))]);
    user.frame(release(field + egui::Vec2::new(400.0, 0.0)));
    let a = blinn_phong(user.editor.look().materials["a"]);
    assert_eq!((a.kd[0], a.ks[0]), (1.0, 0.0));
    user.frame(Vec::new());
    assert!(user.shows("glossy was lowered"));
    (0..60).for_each(|_| user.frame(Vec::new()));
    assert!(!user.shows("glossy was lowered"), "for a while only");
}

#[test]
fn animation_controls() {
    let mut user = User::new(editor(true));
    user.click("Pause");
    assert!(!user.editor.is_playing());
    user.slide("time", 0.5);
    assert!((user.editor.time_s() - 0.25).abs() < 0.01, "{}", user.editor.time_s());
    user.click("Play");
    user.frame(key(Key::Space));
    assert!(!user.editor.is_playing());
    user.click("a");
    assert!(user.shows("moved by the animation"));
    user.slide("shininess", 0.3);
    assert!(!user.shows("held by hand") && user.shows("moved by the animation"), "it moves something else");
    let field = user.mirror.rect("kd R").center();
    user.drag(PointerButton::Primary, field, field + egui::Vec2::new(20.0, 0.0));
    assert!(user.shows("held by hand: diffuse"));
    user.click("fade");
    assert_eq!((user.editor.active(), user.editor.is_playing()), (Some(FADE), true));
    user.click("none");
    assert_eq!(user.editor.active(), None);
}

#[test]
fn an_animation_that_is_shown_plays_on() {
    let mut user = User::new(editor(true));
    for _ in 0..20 {
        user.editor.advance(0.012_345);
        user.frame(Vec::new());
    }
    assert!(
        user.editor.is_playing() && (user.editor.time_s() - 20.0 * 0.012_345).abs() < 1e-9,
        "{}",
        user.editor.time_s()
    );
}

#[test]
fn keys_and_buttons_ask_for_the_same() {
    let mut user = User::new(editor(false));
    for (key_of, button, what) in
        [(Key::S, "PNG", Save::Png), (Key::E, "EXR", Save::Exr), (Key::T, "State", Save::State)]
    {
        user.frame(key(key_of));
        assert_eq!(user.wishes, Wishes { save: vec![what], ..Wishes::default() });
        user.click(button);
        assert_eq!(user.wishes, Wishes { save: vec![what], ..Wishes::default() });
    }
    user.frame(chord(egui::Modifiers::COMMAND, Key::O));
    assert_eq!(user.wishes, Wishes { open: true, ..Wishes::default() });
    user.click("Open…");
    assert_eq!(user.wishes, Wishes { open: true, ..Wishes::default() });
    user.frame(key(Key::Escape));
    assert_eq!(user.wishes, Wishes::default(), "Escape only cancels");
    user.frame(key(Key::Q));
    assert_eq!(user.wishes, Wishes { close: true, ..Wishes::default() });
}

#[test]
fn a_still_screen_asks_for_no_frames() {
    let mut user = User::new(editor(false));
    user.click("a");
    (0..60).for_each(|_| user.frame(Vec::new()));
    assert!(!user.mirror.restless);
}

#[test]
fn a_textured_metal_is_refused_with_the_reason() {
    let meta = Bundle::write_ggx().scene_meta();
    let state = PlacedState { state: State::default(), place: Place::file("defaults") };
    let mut user = User::new(Editor::new(
        &Controls::new(support::scope(meta.clone()), &state, None, Vec::new()).unwrap(),
    ));
    user.click("a");
    assert!(user.mirror.is_disabled("metallic"));
    user.slide("metallic", 1.0);
    assert_eq!(user.editor.look().materials["a"], meta.materials[2].brdf);
    user.frame(vec![Event::PointerMoved(user.mirror.rect("metallic").center())]);
    (0..20).for_each(|_| user.frame(Vec::new()));
    assert!(user.shows("not linear in what was baked"), "{:?}", user.mirror.names());
    user.slide("roughness", 0.0);
    let Brdf::Ggx(a) = user.editor.look().materials["a"] else { panic!() };
    assert_eq!((a.roughness, a.metallic), (0.32, 0.0));
    user.click("b");
    user.slide("metallic", 0.0);
    let Brdf::Ggx(b) = user.editor.look().materials["b"] else { panic!() };
    assert_eq!(b.metallic, 0.0);
}

#[test]
fn sliders_of_cook_and_torrance_stay_within_the_bake() {
    let meta = Bundle::write_cook_torrance().scene_meta();
    let state = PlacedState { state: State::default(), place: Place::file("defaults") };
    let mut user =
        User::new(Editor::new(&Controls::new(support::scope(meta), &state, None, Vec::new()).unwrap()));
    user.click("b");
    for (name, share) in [("roughness", 0.0), ("fresnel", 1.0)] {
        user.slide(name, share);
    }
    let worn = user.editor.look().materials["b"];
    assert_eq!(
        worn,
        Brdf::CookTorrance(CookTorrance { roughness: 0.1, fresnel: 1.0, ..support::COOK_TORRANCE })
    );
    let bright = MaterialState { kd: Some([0.9, 0.3, 0.1]), ..Default::default() };
    user.editor.edit("b", &bright);
    let Brdf::CookTorrance(worn) = user.editor.look().materials["b"] else { panic!() };
    assert_eq!((worn.kd, worn.ks), ([0.9, 0.3, 0.1], [1.0 - 0.9, 0.5, 0.4]));
}

#[test]
fn what_is_fixed_names_the_entry_that_lets_it_vary() {
    let user = User::new(editor(false));
    assert!(user.shows("view = true") && !user.shows("materials = ["), "{:?}", user.mirror.names());
    let user = User::before(lit::lit(false), None);
    assert!(
        user.shows("materials = [\"NAME\"]") && !user.shows("view = true") && !user.shows("light = true")
    );
}

#[test]
fn the_screen_can_be_made_larger() {
    let mut user = User::new(editor(false));
    let scale = user.mirror.context().pixels_per_point();
    user.frame(chord(egui::Modifiers::COMMAND, Key::Plus));
    user.settle();
    assert!(user.mirror.context().pixels_per_point() > scale);
    user.frame(chord(egui::Modifiers::COMMAND, Key::Num0));
    user.settle();
    assert_eq!(user.mirror.context().pixels_per_point(), scale);
}

#[test]
fn how_loading_stands_is_told() {
    let mut user = User::new(editor(false));
    for (loading, text) in [
        (Loading::Arriving, "loading"),
        (Loading::Prefix, "the first 3 of 12 images"),
        (Loading::Failed("images.relume: checksum".to_owned()), "images.relume: checksum"),
    ] {
        user.facts.loading = loading;
        user.frame(Vec::new());
        assert!(user.shows(text), "{text}: {:?}", user.mirror.names());
    }
    assert!(user.shows("3.0 of 12.0 MB") && user.shows("3 of 12") && user.shows("an adapter"));
    user.facts.loading = Loading::Arriving;
    user.editor.select(Some("a"));
    assert_eq!(user.screen.title(Some(&user.editor), &user.facts), "synthetic - a - loading - Relume player");
    assert_eq!(user.screen.title(None, &user.facts), "loading - Relume player");
}
