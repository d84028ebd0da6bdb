//! What is set, taken along to another bake of the scene.

use super::*;
use relume_formats::state::EnvironmentState;

#[test]
fn another_bake_on_disk_is_told_and_shown_when_asked_for() {
    let mut user = User::new(editor(false));
    assert!(!user.shows("was baked again"));
    user.facts.rebaked = true;
    user.frame(Vec::new());
    assert!(user.shows("synthetic was baked again; press F5 to show it"));
    user.frame(key(Key::F5));
    assert_eq!(user.wishes, Wishes { reload: true, ..Wishes::default() });
    user.click("Show");
    assert_eq!(user.wishes, Wishes { reload: true, ..Wishes::default() });
}

#[test]
fn edits_go_along_as_one_step() {
    let mut old = editor(true);
    old.advance(0.125);
    old.edit("b", &set_kd([0.0, 0.0, 0.6]));
    old.set_exposure(-3.0);
    old.edit("a", &set_kd([0.0, 0.7, 0.0]));
    old.select(Some("b"));
    old.commit();
    let mut new = editor(false);
    let start = new.look();
    assert_eq!(new.keep(old.kept()), Vec::<String>::new());
    assert_eq!((new.look(), new.time_s(), new.is_playing()), (old.look(), old.time_s(), false));
    assert_eq!(new.animation().unwrap().name, "glow");
    assert_eq!(new.selected().unwrap().name, "b");
    assert!(new.unsaved().is_some(), "as it was");
    new.undo();
    assert_eq!((new.look(), new.undoes()), (start, None));
    // What was saved is still saved.
    old.mark_saved();
    let mut new = editor(false);
    new.keep(old.kept());
    assert_eq!(new.unsaved(), None);
}

#[test]
fn what_does_not_fit_another_bake_is_named() {
    let mut meta = support::scene_meta();
    let mut old = Editor::new(&controls(&meta, State::default(), false));
    old.edit("a", &MaterialState { ks: Some([0.9; 3]), ..Default::default() });
    old.edit("b", &set_kd([0.0, 0.0, 0.6]));
    old.set_exposure(-3.0);
    let own = "duration_s = 1\n[[key]]\nt_s = 0\nmaterials.a.kd = [0, 0, 0]\n";
    old.take_animation(Animation::parse("own", own, &Place::file("own")).unwrap(), &Place::file("own"))
        .unwrap();
    meta.materials.iter_mut().find(|material| material.name == "a").unwrap().varies = false;
    let place = Place::file("glow");
    let plain = Controls::new(
        support::scope(meta),
        &PlacedState { state: State::default(), place: place.clone() },
        None,
        Vec::new(),
    );
    let mut new = Editor::new(&plain.unwrap());
    assert_eq!(new.keep(old.kept()), ["material a", "animation own"]);
    assert_eq!((kd(&new, "b"), new.look().camera.exposure_ev), ([0.0, 0.0, 0.6], -3.0));
    assert_eq!((new.active(), new.undo().as_deref()), (None, Some("material b, the exposure")));

    // Parameters that are only legal together; parts of the light, each by itself.
    let mut old = lit::lit(false);
    old.edit_light(&EnvironmentState {
        map: Some("sun".to_owned()),
        gain: Some([2.0; 3]),
        rotation_deg: None,
    });
    let mut kept = old.kept();
    kept.state.environment.as_mut().unwrap().map = Some("gone.exr".to_owned());
    let mut new = lit::lit(false);
    assert_eq!(new.keep(kept), ["the map"]);
    assert_eq!(new.look().environment.unwrap().gain, [2.0; 3]);
}
