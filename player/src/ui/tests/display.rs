//! The curve of the display and the exposure; maps from outside.

use super::*;
use relume_formats::display::Tonemap;

#[test]
fn the_curve_obeys_the_same_rule() {
    let mut user = User::new(editor(false));
    assert!(user.mirror.is_disabled("Reset display"));
    for (name, tonemap) in [
        ("AgX", Tonemap::Agx),
        ("clamp", Tonemap::Clamp),
        ("neutral", Tonemap::Neutral),
        ("AgX", Tonemap::Agx),
    ] {
        user.click(name);
        assert_eq!(user.editor.look().tonemap, tonemap);
    }
    let text = toml::to_string(&user.editor.state()).unwrap();
    assert_eq!(text, "[view]\ntonemap = \"agx\"\n");
    user.click("Reset display");
    assert_eq!(
        (user.editor.look(), user.editor.state()),
        (Look::default_of(user.editor.scene()), State::default())
    );

    let flip = "duration_s = 2.0\n[[key]]\nt_s = 0\nview.tonemap = 'clamp'\n[[key]]\nt_s = 1\nview.tonemap = 'agx'\n";
    let flip = Animation::parse("flip", flip, &Place::file("flip.toml")).unwrap();
    let placed = PlacedAnimation { animation: flip, place: Place::file("flip.toml") };
    let scope = support::scope(support::scene_meta());
    let mut editor =
        Editor::new(&Controls::new(scope, &PlacedState::default(), Some(placed), Vec::new()).unwrap());
    let mut at = |time_s| {
        editor.scrub(time_s);
        editor.look().tonemap
    };
    // A name is held until the next.
    assert_eq!(
        [at(0.0), at(0.99), at(1.0), at(2.0)],
        [Tonemap::Clamp, Tonemap::Clamp, Tonemap::Agx, Tonemap::Agx]
    );
    editor.set_tonemap(Tonemap::Neutral);
    assert!(editor.is_held(&Part::Tonemap) && editor.look().tonemap == Tonemap::Neutral);
    editor.reset_tonemap();
    assert_eq!(editor.look().tonemap, Tonemap::Agx);
}

#[test]
fn exposure_is_metered_when_that_is_asked_for() {
    let mut user = User::new(editor(false));
    user.editor.metered(Some(3.0));
    assert_eq!(user.editor.look().camera.exposure_ev, 0.5, "nobody asked");
    user.click("Auto");
    assert_eq!(user.editor.metering(), Some(Metering::Now));
    user.editor.metered(Some(-3.25));
    assert_eq!((user.editor.look().camera.exposure_ev, user.editor.metering()), (-3.25, None));
    // A black picture says nothing.
    user.click("Auto");
    user.editor.metered(None);
    assert_eq!((user.editor.look().camera.exposure_ev, user.editor.metering()), (-3.25, None));
    // What the player was started with lies below an animation; an edit holds against it.
    let mut editor = editor(false);
    editor.choose(Some(FADE));
    editor.scrub(1.0);
    editor.meter(Metering::WhenWhole);
    editor.metered(Some(7.0));
    assert!((editor.look().camera.exposure_ev + 2.0).abs() < 1e-6 && !editor.is_held(&Part::Exposure));
    editor.choose(None);
    assert_eq!(editor.look().camera.exposure_ev, 7.0);
}

#[test]
fn maps_from_outside_are_on_offer_and_told_apart() {
    let mut user = User::before(lit::lit(false), None);
    assert!(!user.shows("not the bundle's own map"));
    user.editor.add_map("/home/me/maps/my sky.exr");
    user.editor.add_map("/home/me/maps/my sky.exr");
    assert_eq!(user.editor.scope().maps.len(), 5);
    user.click("map");
    user.click("my sky.exr (file)");
    assert_eq!(user.editor.look().environment.unwrap().map, "/home/me/maps/my sky.exr");
    user.facts.map_from_outside = true;
    user.settle();
    assert!(user.shows("not the bundle's own map: its stated error was measured under others"));
}

#[test]
fn an_exposure_set_by_hand_is_not_overwritten_by_the_one_asked_for_at_the_start() {
    let mut editor = editor(false);
    editor.meter(Metering::WhenWhole);
    editor.set_exposure(5.5);
    editor.commit();
    editor.metered(Some(0.9));
    assert_eq!((editor.look().camera.exposure_ev, editor.metering()), (5.5, None));
    assert_eq!(editor.undo().as_deref(), Some("the exposure"));
    assert_eq!(editor.look().camera.exposure_ev, 0.5);
}
