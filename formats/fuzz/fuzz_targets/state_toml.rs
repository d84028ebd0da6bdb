//! `STATE.toml`, and what a bundle does with it.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::state::{BlinnPhong, Brdf, Camera, CookTorrance, Ggx, State, Varies, parse_toml};
use relume_formats_fuzz::{check_refusal, place};

const CAMERA: Camera =
    Camera { position: [0.0, 1.0, 4.0], target: [0.0, 1.0, 0.0], fov_deg: 40.0, exposure_ev: 0.0 };
const MATERIALS: [Brdf; 3] = [
    Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks: [0.2; 3], shininess: 50.0 }),
    Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.5, roughness: 0.5 }),
    Brdf::CookTorrance(CookTorrance { kd: [0.5; 3], ks: [0.2; 3], fresnel: 0.5, roughness: 0.5 }),
];

fn play(state: &State) {
    if let Err(error) = state.expect_only(&Varies { materials: vec!["a"], ..Varies::default() }, &place()) {
        check_refusal(&error);
    }
    if let Some(camera) = state
        .camera
        .as_ref()
        .and_then(|change| CAMERA.with(change, &place()).map_err(|e| check_refusal(&e)).ok())
    {
        assert!(camera.film(640, 480).direction(0.5, 0.5).is_finite());
    }
    for (name, change) in &state.materials {
        for material in &MATERIALS {
            if let Err(error) = material
                .with(change, name, &place())
                .and_then(|brdf| brdf.validate_varying(true, brdf.model().usual_sharpest(), name, &place()))
            {
                check_refusal(&error);
            }
        }
    }
}

fuzz_target!(|text: &str| {
    match parse_toml::<State>(text, &place()) {
        Ok(state) => play(&state),
        Err(error) => check_refusal(&error),
    }
});
