//! What may be said of a material of any model, in states, animations and scenes.

use crate::support::{samples, scenes};
use relume_formats::bundle::expect_images;
use relume_formats::kinds::scene::StoredMaterial;
use relume_formats::state::{Animation, BlinnPhong, Brdf, CookTorrance, Ggx, State, parse_toml};
use relume_formats::{Place, Result};

const BLINN_PHONG: Brdf = Brdf::BlinnPhong(BlinnPhong { kd: [0.2; 3], ks: [0.3; 3], shininess: 50.0 });
const GROOVES: Brdf = grooves(0.8, 0.3);
const GGX: Brdf = Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.25, roughness: 0.5 });

fn place() -> Place {
    Place::file("state.toml")
}

/// `brdf` with the leaves that the text of a state sets for material `a`.
fn with(brdf: &Brdf, leaves: &str) -> Result<Brdf> {
    let state: State = parse_toml(&format!("[materials.a]\n{leaves}"), &place())?;
    brdf.with(&state.materials["a"], "a", &place())
}

fn ggx(metallic: f32, roughness: f32) -> Brdf {
    Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic, roughness })
}

const fn grooves(fresnel: f32, roughness: f32) -> Brdf {
    Brdf::CookTorrance(CookTorrance { kd: [0.2; 3], ks: [0.3; 3], fresnel, roughness })
}

fn blinn_phong(shininess: f32) -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd: [0.2; 3], ks: [0.3; 3], shininess })
}

#[test]
fn leaves_replace_what_they_name_and_nothing_else() {
    let changed = with(&GGX, "base_color = [0.1, 0.2, 0.3]").unwrap();
    assert_eq!(changed, Brdf::Ggx(Ggx { base_color: [0.1, 0.2, 0.3], metallic: 0.25, roughness: 0.5 }));
    assert_eq!(with(&GGX, "metallic = 1\nroughness = 0.32").unwrap(), ggx(1.0, 0.32));
    assert_eq!(with(&BLINN_PHONG, "shininess = 200").unwrap(), blinn_phong(200.0));
    assert_eq!(with(&GGX, "").unwrap(), GGX);
    assert_eq!(with(&GROOVES, "fresnel = 0.04\nroughness = 0.1").unwrap(), grooves(0.04, 0.1));
}

/// A text with an ending is the file of a texture; as such it is written again, and an animation holds it until
/// the next.
#[test]
fn leaves_may_be_files_of_textures() {
    let text = "[materials.a]\nkd = \"kd.png\"\nks = [0.1, 0.2, 0.25]\nshininess = \"maps/s.v2.exr\"\n";
    let state: State = parse_toml(text, &place()).unwrap();
    let change = &state.materials["a"];
    assert_eq!((change.kd, change.ks, change.shininess), (None, Some([0.1, 0.2, 0.25]), None));
    let files: Vec<_> = change.textures.iter().map(|(key, file)| (*key, file.as_str())).collect();
    assert_eq!(files, [("kd", "kd.png"), ("shininess", "maps/s.v2.exr")]);
    let again: State = parse_toml(&toml::to_string(&state).unwrap(), &place()).unwrap();
    assert_eq!(again, state);

    let keys = "duration_s = 2\n[[key]]\nt_s = 0\nmaterials.a.kd = 'a.png'\nmaterials.a.shininess = 10\n\
                [[key]]\nt_s = 1\nmaterials.a.kd = 'b.png'\nmaterials.a.shininess = 20\n";
    let animation = Animation::parse("turn", keys, &place()).unwrap();
    for (time_s, file, shininess) in [(0.0, "a.png", 10.0), (0.75, "a.png", 17.5), (1.5, "b.png", 20.0)] {
        let change = &animation.sample(time_s).unwrap().materials["a"];
        assert_eq!((change.textures["kd"].as_str(), change.shininess), (file, Some(shininess)));
    }
}

/// A bundle knows no textures.
#[test]
fn stored_materials_refuse_textures() {
    let (name, brdf) = ("a".to_owned(), BLINN_PHONG);
    let stored = StoredMaterial { name, brdf, varies: true, textured: false, sharpest: 200.0 };
    let state: State = parse_toml("[materials.a]\nshininess = 's.png'", &place()).unwrap();
    let refused = stored.with(&BLINN_PHONG, &state.materials["a"], &place()).unwrap_err().to_string();
    assert_eq!(
        refused,
        "state.toml: material `a`: `s.png` is a texture for shininess, but this bundle shows materials as wholes; write a number, or see it painted by \
         `bake reference`"
    );
}

#[test]
fn a_leaf_of_another_model_is_refused_with_the_right_ones() {
    let has_ggx = "is \"ggx\", which has base_color, metallic and roughness, not";
    let has_blinn_phong = "is \"blinn-phong\", which has kd, ks and shininess, not";
    let has_grooves = "is \"cook-torrance\", which has kd, ks, fresnel and roughness, not";
    let cases = [
        (GROOVES, "kd = [0.1, 0.1, 0.1]\nshininess = 10", format!("{has_grooves} `shininess`")),
        (GROOVES, "metallic = 1", format!("{has_grooves} `metallic`")),
        (GGX, "fresnel = 0.1", format!("{has_ggx} `fresnel`")),
        (BLINN_PHONG, "fresnel = 0.1", format!("{has_blinn_phong} `fresnel`")),
        (GGX, "kd = [0.1, 0.1, 0.1]", format!("{has_ggx} `kd`")),
        (GGX, "ks = [0.1, 0.1, 0.1]", format!("{has_ggx} `ks`")),
        (GGX, "roughness = 0.5\nshininess = 10", format!("{has_ggx} `shininess`")),
        (BLINN_PHONG, "base_color = [0.1, 0.1, 0.1]", format!("{has_blinn_phong} `base_color`")),
        (BLINN_PHONG, "metallic = 0", format!("{has_blinn_phong} `metallic`")),
        (BLINN_PHONG, "kd = [0.0, 0.0, 0.0]\nroughness = 0.5", format!("{has_blinn_phong} `roughness`")),
    ];
    for (brdf, leaves, expected) in cases {
        assert_eq!(
            with(&brdf, leaves).unwrap_err().to_string(),
            format!("state.toml: material `a`: {expected}")
        );
    }
}

#[test]
fn values_outside_their_range_are_refused() {
    let cases = [
        (
            GGX,
            "base_color = [0.1, 1.01, 0.1]",
            "base_color [0.1, 1.01, 0.1] and metallic 0.25 must be numbers of 0 to 1",
        ),
        (GGX, "base_color = [nan, 0.1, 0.1]", "must be numbers of 0 to 1"),
        (GGX, "metallic = -0.01", "metallic -0.01 must be numbers of 0 to 1"),
        (GGX, "metallic = inf", "metallic inf must be numbers of 0 to 1"),
        (GGX, "roughness = 0.1", "roughness 0.1 is outside 0.12..1"),
        (GGX, "roughness = 1.5", "roughness 1.5 is outside 0.12..1"),
        (GGX, "roughness = nan", "roughness NaN is outside 0.12..1"),
        (GROOVES, "fresnel = 1.01", "fresnel 1.01 must be a number of 0 to 1"),
        (GROOVES, "fresnel = nan", "fresnel NaN must be a number of 0 to 1"),
        (GROOVES, "roughness = 0.01", "roughness 0.01 is outside 0.015..1"),
        (GROOVES, "ks = [0.9, 0.3, 0.3]", "kd + ks = 1.1 exceeds 1"),
        (BLINN_PHONG, "shininess = 0.5", "shininess 0.5 is outside 1..10000"),
        (BLINN_PHONG, "kd = [0.2, 0.8, 0.2]", "kd + ks = 1.1 exceeds 1"),
        (GGX, "base_colour = [0.1, 0.1, 0.1]", "unknown key `base_colour`; did you mean `base_color`?"),
    ];
    for (brdf, leaves, expected) in cases {
        let message = with(&brdf, leaves).unwrap_err().to_string();
        assert!(message.starts_with("state.toml: ") && message.contains(expected), "{leaves}: {message}");
    }
}

/// Bases span fewer lobes than rays can follow.
#[test]
fn what_varies_is_kept_within_the_range_of_bases() {
    let fixed_only = [
        ggx(0.0, 0.12),
        ggx(1.0, 0.3199),
        blinn_phong(10_000.0),
        blinn_phong(200.1),
        grooves(0.0, 0.015),
        grooves(1.0, 0.0999),
    ];
    let both = [
        ggx(0.0, 0.32),
        ggx(1.0, 1.0),
        blinn_phong(200.0),
        blinn_phong(1.0),
        grooves(0.0, 0.1),
        grooves(1.0, 1.0),
    ];
    for (brdf, may_vary) in
        fixed_only.into_iter().map(|b| (b, false)).chain(both.into_iter().map(|b| (b, true)))
    {
        let sharpest = brdf.model().usual_sharpest();
        let material =
            |varies| StoredMaterial { name: "a".to_owned(), brdf, varies, textured: false, sharpest };
        assert!(material(false).validate(&brdf, &place()).is_ok(), "{brdf:?}");
        assert_eq!(material(true).validate(&brdf, &place()).is_ok(), may_vary, "{brdf:?}");
    }
}

#[test]
fn a_textured_metal_cannot_vary() {
    let check = |brdf: Brdf, varies, textured| {
        let (name, sharpest) = ("a".to_owned(), brdf.model().usual_sharpest());
        StoredMaterial { name, brdf, varies, textured, sharpest }.validate(&brdf, &place())
    };
    let message = check(GGX, true, true).unwrap_err().to_string();
    assert!(
        message.starts_with("state.toml: material `a`: metallic 0.25 with a textured base colour"),
        "{message}"
    );
    assert!(message.ends_with("set metallic to 0 or remove the texture"), "{message}");
    assert!(check(GGX, true, false).is_ok() && check(GGX, false, true).is_ok());
    assert!(check(ggx(0.0, 0.5), true, true).is_ok());
    // A diffuse texture beside a grey highlight is no product of two textures.
    assert!(check(BLINN_PHONG, true, true).is_ok() && check(GROOVES, true, true).is_ok());
}

/// A file may not say that it goes where its basis does not follow, or nobody could ask for.
#[test]
fn scenes_go_no_farther_than_their_basis() {
    let mut meta = scenes::scene(1).meta;
    let material = |sharpest, varies| {
        let (name, brdf) = ("m0".to_owned(), blinn_phong(20.0));
        StoredMaterial { name, brdf, varies, textured: false, sharpest }
    };
    let mut message = |sharpest: f32, varies: bool| {
        meta.materials = vec![material(sharpest, varies)];
        (meta.objects, meta.shapes) = (Vec::new(), Vec::new());
        meta.validate(&place()).err().map(|error| error.to_string())
    };
    assert_eq!((message(200.0, true), message(2000.0, true), message(200.0, false)), (None, None, None));
    for (sharpest, varies, expected) in [
        (5001.0, true, "material `m0`: sharpest lobe 5001 is outside 200..5000"),
        (199.0, true, "sharpest lobe 199 is outside"),
        (f32::NAN, true, "sharpest lobe NaN is outside"),
        (2000.0, false, "sharpest lobe 2000 is of a material that varies"),
    ] {
        let found = message(sharpest, varies).unwrap();
        assert!(found.contains(expected), "{found}");
    }
    let (head, basis) = (samples::images(1, 1, 6, true, [4, 4]).head, samples::basis(1, 6, true));
    meta.size = [4, 4];
    for (sharpest, is_sound) in [(200.0, true), (201.0, false)] {
        meta.materials = vec![material(sharpest, true)];
        let found = expect_images(&head, &basis, &meta, &place()).err().map(|error| error.to_string());
        assert_eq!(found.is_none(), is_sound, "{found:?}");
        assert!(found.is_none_or(|found| found.contains("`m0` goes up to 201, the BRDF basis to 200")));
    }
}

/// A scene may ask for sharper lobes; what it asked for is what states are held to.
#[test]
fn asked_for_materials_that_vary_may_be_sharper() {
    let check = |brdf: Brdf, sharpest: f32| {
        let stored = StoredMaterial { name: "a".to_owned(), brdf, varies: true, textured: false, sharpest };
        stored.validate(&brdf, &place()).map_err(|error| error.to_string())
    };
    for (brdf, usual, asked) in
        [(blinn_phong(1999.0), 200.0, 2000.0), (ggx(1.0, 0.15), 0.32, 0.14), (grooves(1.0, 0.03), 0.1, 0.02)]
    {
        assert_eq!(check(brdf, asked), Ok(()));
        assert!(check(brdf, usual).unwrap_err().contains("is outside"));
    }
    let message = check(blinn_phong(2001.0), 2000.0).unwrap_err();
    for part in [
        "state.toml: material `a`: shininess 2001 is outside 1..2000",
        "[vary] shininess_max lets transfer-images go up to 5000",
    ] {
        assert!(message.contains(part), "{message}");
    }
    let message = check(ggx(1.0, 0.13), 0.14).unwrap_err();
    assert!(message.contains("0.13 is outside 0.14..1") && !message.contains("[vary]"), "{message}");
}

#[test]
fn ggx_leaves_are_animated_each_on_its_own() {
    let text = "
        duration_s = 2.0
        [[key]]
        t_s = 0
        materials.a.base_color = [0.0, 0.2, 0.4]
        materials.a.metallic = 0
        [[key]]
        t_s = 1.0
        materials.a.metallic = 1
        materials.a.roughness = 0.4
        [[key]]
        t_s = 2.0
        materials.a.base_color = [0.4, 0.2, 0.0]
        materials.a.roughness = 0.8
    ";
    let animation = Animation::parse("turn", text, &Place::file("turn.toml")).unwrap();
    // In between the metal stays at 1 and the roughness is still its first.
    let hand = [
        (0.5, [0.1, 0.2, 0.3], 0.5, 0.4),
        (1.5, [0.3, 0.2, 0.1], 1.0, 0.6),
        (9.0, [0.4, 0.2, 0.0], 1.0, 0.8),
    ];
    for (time_s, base_color, metallic, roughness) in hand {
        let state = animation.sample(time_s).unwrap();
        let Ok(Brdf::Ggx(worn)) = GGX.with(&state.materials["a"], "a", &place()) else {
            panic!("at {time_s} s")
        };
        let values = worn.base_color.into_iter().chain([worn.metallic, worn.roughness]);
        for (value, expected) in values.zip(base_color.into_iter().chain([metallic, roughness])) {
            assert!((value - expected).abs() < 1e-6, "at {time_s} s: {worn:?}");
        }
        assert!(BLINN_PHONG.with(&state.materials["a"], "a", &place()).is_err());
    }
}
