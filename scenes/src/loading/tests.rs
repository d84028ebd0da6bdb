use super::*;
use crate::scene::{ALL_REFLECTIONS, Emitter};
use crate::test_support::Scratch;
use relume_formats::display::Tonemap;
use relume_formats::state::{BlinnPhong, Brdf, State};
use std::sync::Arc;

const TEXT: &str = r#"
[vary]
materials = ["clay"]
[render]
size = [64, 32]
[camera]
position = [0, 1, 4]
target = [0, 1, 0]
fov_deg = 40
[materials.clay]
brdf = "blinn-phong"
[materials.gold]
brdf = "blinn-phong"
kd = [0.1, 0.1, 0.1]
ks = [0.5, 0.4, 0.2]
shininess = 80
[[object]]
name = "ball"
shape = "sphere"
subdivisions = 1
material = "clay"
[[object]]
name = "floor"
shape = "quad"
transform = { scale = 4 }
material = "gold"
[[light]]
name = "lamp"
kind = "area"
radiance = [1, 2, 3]
transform = { translation = [0, 3, 0], rotation_deg = [-90, 0, 0], scale = 2 }
"#;

/// The error of `TEXT` with `from` replaced by `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(TEXT.contains(from), "{from}");
    one_line_error(&Scratch::scene(&TEXT.replacen(from, to, 1)))
}

fn one_line_error(scratch: &Scratch) -> String {
    let error = scratch.load().unwrap_err();
    let message = error.to_string();
    assert!(!message.contains('\n') && error.is_bad_input(), "{message}");
    message
}

#[test]
fn reflections_are_a_number_or_all() {
    let loaded = |vary: &str, line: &str| {
        let text = TEXT
            .replace("materials = [\"clay\"]", vary)
            .replace("size = [64, 32]", &format!("size = [64, 32]\n{line}"));
        Scratch::scene(&text).load().map(|scene| scene.reflections)
    };
    let materials = "materials = [\"clay\"]";
    for (vary, line, expected) in [
        (materials, "", ALL_REFLECTIONS),
        ("materials = [\"clay\"]\nview = true", "", 2),
        ("", "", 2),
        (materials, "reflections = \"all\"", ALL_REFLECTIONS),
        (materials, "reflections = 1", 1),
        ("light = true", "reflections = \"all\"", ALL_REFLECTIONS),
    ] {
        assert_eq!(loaded(vary, line).unwrap(), expected, "{vary} {line}");
    }
    for wrong in ["\"any\"", "1.5", "-1", "[1]", "true"] {
        let error = loaded(materials, &format!("reflections = {wrong}")).unwrap_err().to_string();
        assert!(
            error.contains("a whole number, or \"all\"") && error.contains("reflections"),
            "{wrong}: {error}"
        );
    }
}

#[test]
fn a_scene_loads_with_its_defaults() {
    let scratch = Scratch::scene(TEXT);
    let scene = scratch.load().unwrap();
    assert_eq!(scene.name, scratch.path("").file_name().unwrap().to_string_lossy());
    assert_eq!((scene.size, scene.reflections, scene.max_error), ([64, 32], ALL_REFLECTIONS, 0.01));
    assert_eq!(scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["clay", "gold"]);
    assert_eq!(
        scene.materials[0].brdf,
        Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks: [0.0; 3], shininess: 10.0 })
    );
    assert_eq!((scene.vary.materials.as_slice(), scene.varying_names()), (&[0][..], vec!["clay"]));
    assert_eq!(scene.objects[1].material, 1);
    assert!(scene.objects[1].mesh.positions.iter().all(|p| p[0].abs() == 2.0 && p[2].abs() == 2.0));
    assert!(scene.environment.is_none() && scene.animations.is_empty() && scene.warnings.is_empty());
}

#[test]
fn mistakes_are_one_line_with_file_and_place() {
    for (from, to, part) in [
        ("fov_deg", "fov", "line 9, column 1: camera: unknown key `fov`; did you mean `fov_deg`?"),
        (
            "size = [64, 32]",
            "size = [64, 32]\nsamples = 4",
            "line 6, column 1: render: unknown key `samples`; there are: `size`, `reflections`",
        ),
        ("subdivisions", "subdivision", "did you mean `subdivisions`?"),
        ("\"area\"", "\"aera\"", "did you mean `area`?"),
        (
            "\"blinn-phong\"",
            "\"phong\"",
            "materials.clay.brdf: no `phong`; did you mean `blinn-phong`? There are: `blinn-phong`, `ggx`, `cook-torrance`",
        ),
        (
            "brdf = \"blinn-phong\"",
            "brdf = \"ggx\"\nroughness = 0.3",
            "material `clay`: roughness 0.3 is outside 0.32..1",
        ),
        (
            "ks = ",
            "metallic = 1\nks = ",
            "material `gold`: is \"blinn-phong\", which has kd, ks and shininess, not `metallic`",
        ),
        (
            "[vary]",
            "[vary]\nshininess_max = 100",
            "[vary]: `shininess_max` 100 is outside 200..5000 of materials that are \"blinn-phong\"",
        ),
        ("[vary]", "[vary]\nshininess_max = 5001", "[vary]: `shininess_max` 5001 is outside 200..5000"),
        ("[vary]", "[vary]\nshininess_max = nan", "[vary]: `shininess_max` NaN is outside 200..5000"),
        (
            "[vary]",
            "[vary]\nroughness_min = 0.2",
            "[vary]: `roughness_min`: no material that varies is \"ggx\" or \"cook-torrance\"; remove it",
        ),
        ("kd = [0.1, 0.1, 0.1]", "kd = [0.6, 0.1, 0.1]", "material `gold`: kd + ks = 1.1 exceeds 1"),
        ("shininess = 80", "shininess = 20000", "shininess 20000 is outside"),
        ("position = [0, 1, 4]", "position = [0, 1, 0]", "position and target coincide"),
        ("[64, 32]", "[64, 0]", "line 5: [render]: size [64, 0] is outside 1..16384"),
        ("[64, 32]", "[64, 16385]", "[render]: size [64, 16385] is outside"),
        ("[64, 32]", "[64, 32]\nreflections = 0", "[render]: reflections 0"),
        ("\"floor\"", "\"ball\"", "two objects are called `ball`"),
        (
            "material = \"gold\"",
            "material = \"golf\"",
            "object `floor`: no material `golf`; did you mean `gold`?",
        ),
        ("[\"clay\"]", "[\"clya\"]", "[vary] materials: no material `clya`; did you mean `clay`?"),
        ("[\"clay\"]", "[\"clay\", \"clay\"]", "`clay` is listed twice; remove one"),
        ("shape = \"quad\"", "", "object `floor`: give either `file` or `shape`"),
        (
            "shape = \"quad\"",
            "shape = \"quad\"\nfile = \"a.obj\"",
            "object `floor`: give either `file` or `shape`",
        ),
        ("shape = \"quad\"", "shape = \"quad\"\nnode = \"a\"", "`node` belongs to a glTF file"),
        (
            "shape = \"quad\"",
            "shape = \"quad\"\ncrease_deg = 9.0",
            "object `floor`: `crease_deg` belongs to a file without normals",
        ),
        (
            "shape = \"quad\"",
            "file = \"a.obj\"\ncrease_deg = 181.0",
            "crease_deg 181 is outside 0..180; 0 makes every face flat",
        ),
        ("shape = \"sphere\"", "file = \"a.obj\"", "object `ball`: `subdivisions` belongs to a shape"),
        (
            "shape = \"quad\"",
            "file = \"a.obj\"",
            "object `floor`: no such file: `a.obj`; correct the path or add the file",
        ),
        ("shape = \"quad\"", "file = \"assets/a.obj\"", "run `make assets` to fetch it"),
        (
            "scale = 4",
            "scale = 0",
            "line 25: object `floor`: transform: scale 0 leaves no surface of it; give numbers other than 0",
        ),
        (
            "scale = 4",
            "scale = [0, 2, 0]",
            "object `floor`: transform: scale [0.0, 2.0, 0.0] leaves no surface of it",
        ),
        ("scale = 4", "scale = [4, 1, 0]", "object `floor`: no usable triangle (2 degenerate)"),
        (
            "shape = \"quad\"",
            "file = \"a.obj\"\nnode = \"a\"",
            "object `floor`: node `a` is named, but only a glTF file has nodes, and `a.obj` is none; remove `node`",
        ),
        (
            "scale = 4",
            "scale = 1e39",
            "object `floor`: vertex 0 at [-0.5, 0.0, -0.5] comes to lie farther from the origin than 1e9 m; lower its scale",
        ),
        ("scale = 4", "scale = inf", "object `floor`: transform: every value must be a finite number"),
        (
            "radiance = [1, 2, 3]",
            "radiance = [1, -2, 3]",
            "light `lamp`: radiance [1.0, -2.0, 3.0] must be numbers of 0 to 1e12",
        ),
        ("radiance = [1, 2, 3]", "radiance = [1, inf, 3]", "light `lamp`: radiance"),
        ("radiance", "intensity", "an area light is measured by `radiance`, not by `intensity`"),
        ("radiance = [1, 2, 3]", "", "an area light needs `radiance`"),
        ("scale = 2", "scale = [2, 0, 1]", "light `lamp`: its area is 0 m²"),
        ("[[light]]", "[error]\nmax = 0\n[[light]]", "[error]: max 0 must be a number above 0"),
        (
            "[[light]]",
            "[environment]\ngain = [1, -1, 1]\n[[light]]",
            "environment: gain [1.0, -1.0, 1.0] is outside 0..1000000000",
        ),
        (
            "[[light]]",
            "[environment]\nrotation_deg = nan\n[[light]]",
            "environment: rotation_deg must be a finite number",
        ),
        ("[[light]]", "[environment]\nfile = \"sky.exr\"\n[[light]]", "no such file: `sky.exr`"),
    ] {
        let message = refusal(from, to);
        assert!(message.contains(part) && message.contains("scene.toml"), "{to}: {message}");
    }
    let twice = format!("{TEXT}\n[[light]]\nname = 'lamp'\nkind = 'point'\nintensity = [1, 1, 1]");
    assert!(
        one_line_error(&Scratch::scene(&twice))
            .ends_with("two lights are called `lamp`; rename or remove one")
    );
    let no_object = TEXT.split("[[object]]").next().unwrap();
    assert!(
        one_line_error(&Scratch::scene(no_object)).ends_with("the scene has no object; add an [[object]]")
    );
    assert!(load(Path::new("nowhere/scene.toml")).unwrap_err().is_bad_input());
}

fn light(text: &str) -> Emitter {
    let lights = TEXT.split("[[light]]").next().unwrap().to_owned() + "[[light]]\nname = 'lamp'\n" + text;
    Scratch::scene(&lights).load().unwrap().lights[0].emitter.clone()
}

#[test]
fn area_lights_emit_along_their_minus_z() {
    // Straight, turned to face down, mirrored along x (still down), and mirrored along z (then up).
    for (transform, centre, normal) in [
        ("translation = [1, 2, 3]", [1.0, 2.0, 3.0], [0.0, 0.0, -1.0]),
        ("translation = [0, 3, 0], rotation_deg = [-90, 0, 0]", [0.0, 3.0, 0.0], [0.0, -1.0, 0.0]),
        ("rotation_deg = [-90, 0, 0], scale = [-1, 1, 1]", [0.0; 3], [0.0, -1.0, 0.0]),
        ("rotation_deg = [-90, 0, 0], scale = [1, 1, -1]", [0.0; 3], [0.0, 1.0, 0.0]),
    ] {
        let emitter = light(&format!("kind = 'area'\nradiance = [1, 1, 1]\ntransform = {{ {transform} }}"));
        let Emitter::Area { corner, edge_u, edge_v, .. } = emitter else { panic!("{emitter:?}") };
        let (corner, u, v) = (glam::Vec3::from(corner), glam::Vec3::from(edge_u), glam::Vec3::from(edge_v));
        assert_eq!((corner + 0.5 * u + 0.5 * v).to_array(), centre, "{transform}");
        assert_eq!(u.cross(v).to_array(), normal, "{transform}");
    }
}

#[test]
fn point_and_directional_lights() {
    let point = light("kind = 'point'\nintensity = [4, 5, 6]\ntransform = { translation = [1, 2, 3] }");
    assert_eq!(point, Emitter::Point { position: [1.0, 2.0, 3.0], intensity: [4.0, 5.0, 6.0], cone: None });
    let sun = light(
        "kind = 'directional'\nirradiance = [4, 5, 6]\ntransform = { rotation_deg = [-90, 0, 0], scale = 3 }",
    );
    assert_eq!(sun, Emitter::Directional { direction: [0.0, -1.0, 0.0], irradiance: [4.0, 5.0, 6.0] });
}

#[test]
fn idle_parts_are_reported() {
    let text = TEXT.replace(
        "materials = [\"clay\"]",
        "materials = [\"clay\", \"gold\"]\nlight = true\nview = true\nshape = true",
    );
    let text = text.split("[[light]]").next().unwrap().replace("material = \"gold\"", "material = \"clay\"");
    let scene = Scratch::scene(&text).load().unwrap();
    assert!(scene.vary.light && scene.vary.view && scene.vary.shape);
    assert!(scene.warnings[0].ends_with("neither a light nor an environment, everything is black"));
    assert!(scene.warnings[1].ends_with("material `gold` varies, but no object wears it"));
    assert!(scene.warnings[2].contains("[vary] shape = true, but no object deforms; "));
}

#[test]
fn an_environment_without_a_file_is_white() {
    let scene = Scratch::scene(&format!("{TEXT}\n[environment]\ngain = [1, 2, 3]\nrotation_deg = 30"))
        .load()
        .unwrap();
    let environment = scene.environment.unwrap();
    assert_eq!((environment.gain, environment.rotation_deg), ([1.0, 2.0, 3.0], 30.0));
    assert_eq!(
        environment.map.map.texels.len(),
        (environment.map.map.width * environment.map.map.height) as usize
    );
    assert!(environment.map.map.texels.iter().all(|t| *t == [1.0; 3]));
}

#[test]
fn states_choose_among_the_maps_of_a_scene() {
    let text = format!("{TEXT}\n[environment]\nfile = 'lamps'\nothers = ['clear-sky']\nrotation_deg = 30");
    let scene = Scratch::scene(&text).load().unwrap();
    let place = Place::file("s.toml");
    let shown = |text: &str| scene.with_state(&state(text), &place).map(|s| s.environment.unwrap());
    let sky = shown("environment = { map = 'clear-sky', rotation_deg = -90 }").unwrap();
    let own = scene.environment.as_ref().unwrap();
    assert_eq!(
        (sky.map.name.as_str(), sky.rotation_deg, sky.map.map == own.others[0].map),
        ("clear-sky", -90.0, true)
    );
    assert_eq!(shown("environment.gain = [2, 2, 2]").unwrap().map.name, "lamps");
    assert_eq!(
        shown("environment.map = 'white'").unwrap().map.name,
        "white",
        "procedural maps need not be listed"
    );
    let message = shown("environment.map = 'clear-skies'").unwrap_err().to_string();
    assert!(message.contains("did you mean `clear-sky`"), "{message}");
}

#[test]
fn animations_are_read_in_name_order_and_checked_at_every_key() {
    let scratch = Scratch::scene(TEXT);
    let animation =
        |kd: &str| format!("duration_s = 1\n[[key]]\nt_s = 0\n[[key]]\nt_s = 0.5\nmaterials.clay.kd = {kd}");
    scratch.write("animations/b.toml", animation("[0.1, 0.1, 0.1]"));
    scratch.write("animations/a.toml", animation("[0.2, 0.1, 0.1]"));
    scratch.write("animations/notes.txt", "");
    scratch.write("animations/.b.toml", "of an editor");
    let scene = scratch.load().unwrap();
    assert_eq!(scene.animations.iter().map(|a| a.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    scratch.write("animations/b.toml", animation("[1.1, 0.1, 0.1]"));
    let message = one_line_error(&scratch);
    assert!(
        message.contains("b.toml: line 6: at 0.5 s: material `clay`: kd + ks = 1.1 exceeds 1"),
        "{message}"
    );
    scratch.write("animations/b.toml", animation("[0.1, 0.1, 0.1]").replace("clay", "day"));
    assert!(one_line_error(&scratch).contains("no material `day`; did you mean `clay`?"));
}

fn state(text: &str) -> State {
    parse_toml(text, &Place::file("s.toml")).unwrap()
}

#[test]
fn a_state_changes_what_it_names_and_nothing_else() {
    let scene = Scratch::scene(&format!("{TEXT}\n[environment]")).load().unwrap();
    let text = "environment = { rotation_deg = 20, gain = [2, 2, 2] }\ncamera = { fov_deg = 50 }\nlights.lamp.gain = [2, 1, 0]\n\
                materials.gold = { shininess = 5 }";
    let changed = scene.with_state(&state(text), &Place::file("s.toml")).unwrap();
    assert_eq!((changed.camera.fov_deg, changed.camera.position), (50.0, scene.camera.position));
    let gold = BlinnPhong { kd: [0.1; 3], ks: [0.5, 0.4, 0.2], shininess: 5.0 };
    assert_eq!(changed.materials[1].brdf, Brdf::BlinnPhong(gold));
    assert_eq!(changed.materials[0], scene.materials[0]);
    let Emitter::Area { radiance, .. } = changed.lights[0].emitter else { panic!() };
    assert_eq!(radiance, [2.0, 2.0, 0.0]);
    let environment = changed.environment.unwrap();
    assert_eq!((environment.gain, environment.rotation_deg), ([2.0; 3], 20.0));
    assert!(Arc::ptr_eq(&changed.objects[0].mesh, &scene.objects[0].mesh));
}

#[test]
fn scenes_are_shown_by_the_neutral_curve_unless_they_say_otherwise() {
    let scene = Scratch::scene(TEXT).load().unwrap();
    assert_eq!(scene.tonemap, Tonemap::Neutral);
    let agx = Scratch::scene(&format!("{TEXT}\n[view]\ntonemap = 'agx'\n")).load().unwrap();
    assert_eq!(agx.tonemap, Tonemap::Agx);
    let changed = agx.with_state(&state("view.tonemap = 'clamp'"), &Place::file("s.toml")).unwrap();
    assert_eq!(
        (changed.tonemap, agx.with_state(&state("[view]"), &Place::file("s.toml")).unwrap().tonemap),
        (Tonemap::Clamp, Tonemap::Agx)
    );
    let message = one_line_error(&Scratch::scene(&format!("{TEXT}\n[view]\ntonemap = 'filmic'\n")));
    assert!(message.contains("view.tonemap: no `filmic`; there are: `clamp`, `neutral`, `agx`"), "{message}");
}

#[test]
fn maps_are_sought_beside_the_state_then_beside_the_scene() {
    let map = |value: u8| {
        let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
        bytes.extend([value, value, value, 128].repeat(2));
        bytes
    };
    let scratch = Scratch::scene(TEXT);
    scratch.write("sky.hdr", map(64));
    let scene = scratch.load().unwrap();
    let change = state("environment.map = 'sky.hdr'");
    let place = Place::file(scratch.path("states/s.toml"));
    let texel = || scene.with_state(&change, &place).unwrap().environment.unwrap().map.map.texels[0][0];
    assert_eq!(texel(), 0.25);
    scratch.write("states/sky.hdr", map(128));
    assert_eq!(texel(), 0.5);
}

#[test]
fn states_that_do_not_fit_are_refused() {
    let scene = Scratch::scene(TEXT).load().unwrap();
    for (text, part) in [
        ("materials.gild.ks = [0, 0, 0]", "s.toml: no material `gild`; did you mean `gold`?"),
        ("materials.gold.shininess = 0.5", "shininess 0.5 is outside"),
        ("lights.lump.gain = [1, 1, 1]", "no light `lump`; did you mean `lamp`?"),
        ("lights.lamp.gain = [-1, 1, 1]", "light `lamp`: gain [-1.0, 1.0, 1.0] must be numbers of 0 to 1e12"),
        ("camera.fov_deg = 180", "fov_deg 180 is outside"),
        ("shapes.fox.time_s = 1", "sets shape `fox`, but no object deforms; add shape = true to [vary]"),
        ("environment.rotation_deg = 1", "but the scene has none"),
        ("environment.map = 'gone.exr'", "s.toml: no such file: `gone.exr`"),
    ] {
        let message = scene.with_state(&state(text), &Place::file("s.toml")).unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
    let text = TEXT.replace("materials = [\"clay\"]", "materials = [\"clay\"]\nshape = true");
    let (scene, object) = (Scratch::scene(&text).load().unwrap(), "give a shape twist_deg, or a glTF object");
    let name = scene.objects[0].name.clone();
    let of =
        |name: &str| scene.with_state(&state(&format!("shapes.{name}.time_s = 1")), &Place::file("s.toml"));
    assert!(of(&name).unwrap_err().to_string().contains(object));
    assert!(!of("nobody").unwrap_err().to_string().contains(object));
}
