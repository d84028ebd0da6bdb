//! What PNG frames make of radiance.

use super::exr;
use crate::run::{expect_success, gpu_there, headless};
use crate::support::Bundle;
use relume_formats::basis::srgb_from_linear;
use relume_formats::display::{Display, Tonemap, auto_exposure_ev};

/// State, options, and the display that they make.
#[test]
fn frames_are_shown_as_state_and_options_say() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let at = |name: &str| bundle.folder().join(name);
    std::fs::write(at("state.toml"), "camera.exposure_ev = -1.5\nview.tonemap = 'agx'\n").unwrap();
    let state = ["--state", "@/state.toml"];
    expect_success(&headless(bundle.folder(), &["--exr", "@/linear.exr"]));
    let radiance = exr(&at("linear.exr"));
    let auto = auto_exposure_ev(&radiance).unwrap();
    for (options, exposure_ev, tonemap) in [
        (&[][..], 0.5, Tonemap::Neutral),
        (&["--tonemap", "clamp"], 0.5, Tonemap::Clamp),
        (&state, -1.5, Tonemap::Agx),
        (&[&state[..], &["--tonemap", "neutral"]].concat(), -1.5, Tonemap::Neutral),
        (&[&state[..], &["--exposure", "-0.25"]].concat(), -0.25, Tonemap::Agx),
        (&[&state[..], &["--exposure", "auto"]].concat(), auto, Tonemap::Agx),
    ] {
        expect_success(&headless(
            bundle.folder(),
            &[&["--frames", "@/f.png", "--exr", "@/f.exr"], options].concat(),
        ));
        assert_eq!(exr(&at("f.exr")), radiance, "{options:?}: EXR stays linear");
        let display = Display { exposure_ev, tonemap };
        let expected: Vec<[u8; 3]> =
            radiance.iter().map(|radiance| display.shown(*radiance).map(srgb_from_linear)).collect();
        let png = image::open(at("f.png")).unwrap().to_rgb8();
        assert!(png.pixels().map(|pixel| pixel.0).eq(expected), "{options:?}");
    }
    // An animation lies over both.
    let fade = "duration_s = 1.0\n[[key]]\nt_s = 0\ncamera.exposure_ev = 2.0\nview.tonemap = 'clamp'\n";
    std::fs::write(at("fade.toml"), fade).unwrap();
    let options = ["--animation", "@/fade.toml", "--exposure", "auto", "--tonemap", "agx", "--count", "1"];
    expect_success(&headless(bundle.folder(), &[&["--frames", "@/f.png"], &options[..]].concat()));
    let display = Display { exposure_ev: 2.0, tonemap: Tonemap::Clamp };
    let png = image::open(at("f.png")).unwrap().to_rgb8();
    assert!(
        png.pixels()
            .zip(&radiance)
            .all(|(pixel, radiance)| pixel.0 == display.shown(*radiance).map(srgb_from_linear))
    );
}
