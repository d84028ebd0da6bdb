//! First scenes for models, and looks at scenes: `bake new`, and `bake run` and `bake plan` of a model.

use crate::support::{command, expect_exit, library_scene, scene};
use relume_bake::probe::Probe;
use relume_scenes::starter::{Look, Starter};
use std::path::Path;

/// A box from `low` to `high` as an OBJ file; flat where both are the same.
fn obj_of_box(low: [f64; 3], high: [f64; 3]) -> String {
    let corner = |i: usize| {
        (0..3)
            .map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }.to_string())
            .collect::<Vec<_>>()
            .join(" ")
    };
    let vertices: String = (0..8).map(|i| format!("v {}\n", corner(i))).collect();
    vertices + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// The first scene of the model in `file`, for a file beside it.
fn first_scene(file: &Path) -> relume_scenes::Scene {
    let starter = Starter::of(file, &file.with_extension("toml"), None).unwrap();
    let plain = starter.scene(None).unwrap();
    let probe = Probe::new(&plain, plain.size).unwrap();
    starter.scene(Some(&Look { exposure_ev: probe.exposure_ev(), seen: probe.seen() })).unwrap()
}

#[test]
fn models_of_all_sorts_are_in_view_and_lit() {
    let folder = tempfile::tempdir().unwrap();
    for (what, low, high, least) in [
        ("a cube", [-1.0; 3], [1.0; 3], 0.1),
        ("tiny", [-2e-7; 3], [2e-7; 3], 0.1),
        ("huge", [-4e8; 3], [4e8; 3], 0.1),
        ("lying flat", [-3.0, 0.0, -3.0], [3.0, 0.0, 3.0], 0.05),
        ("standing flat", [-3.0, 0.0, 0.0], [3.0, 6.0, 0.0], 0.05),
        ("a pole", [-0.05, 0.0, -0.05], [0.05, 6.0, 0.05], 0.003),
        ("far from the origin", [3e5, 1e5, -7e5], [3e5 + 2.0, 1e5 + 2.0, -7e5 + 2.0], 0.1),
    ] {
        let file = folder.path().join(format!("{what}.obj"));
        std::fs::write(&file, obj_of_box(low, high)).unwrap();
        let scene = first_scene(&file);
        let probe = Probe::new(&scene, scene.size).unwrap();
        assert_eq!(probe.warnings(), Vec::<String>::new(), "{what}");
        let seen = probe.seen();
        let pixels = |name: &str| seen.iter().find(|(seen, _)| seen == name).map_or(0, |(_, pixels)| *pixels);
        let share = f64::from(pixels("model")) / 4096.0;
        assert!(share > least && share < 0.6, "{what}: {share}");
        assert_eq!(pixels("model") + pixels("ground"), 4096, "{what}: the ground fills the rest");
        assert_eq!((scene.varying_names(), probe.exposure_ev()), (vec!["model"], 0.0), "{what}");
    }
}

/// What lamps of a file make too bright is brought back by exposure, and the first scene says so before it is
/// baked.
#[test]
fn exposure_brings_grey_surfaces_to_the_middle() {
    let text = |intensity: f64, ev: f64| {
        format!(
            "[render]\nsize = [32, 32]\n[camera]\nposition = [0, 3, 3]\ntarget = [0, 0, 0]\nfov_deg = 30\nexposure_ev = {ev}\n\
             [[object]]\nname = 'floor'\nshape = 'quad'\nmaterial = 'm'\ntransform = {{ scale = 20 }}\n[materials.m]\nbrdf = 'ggx'\n\
             [[light]]\nname = 'l'\nkind = 'directional'\nirradiance = [{intensity}, {intensity}, {intensity}]\n\
             transform = {{ rotation_deg = [-90, 0, 0] }}\n"
        )
    };
    // Light straight down with irradiance E leaves grey of albedo ½ with radiance E/2π.
    let middle = 0.4 * std::f64::consts::TAU;
    for steps in [-7.0, -2.5, 0.0, 3.0, 9.5] {
        let scene = scene(&text(middle * f64::exp2(-steps), 0.0));
        let probe = Probe::new(&scene, scene.size).unwrap();
        assert_eq!(f64::from(probe.exposure_ev()), steps);
        let is_told = probe.warnings().iter().any(|warning| warning.contains("far too"));
        assert_eq!(is_told, f64::abs(steps) > 4.0, "{steps}: {:?}", probe.warnings());
    }
    let exposed = scene(&text(middle * 512.0, -9.0));
    assert!(
        Probe::new(&exposed, exposed.size).unwrap().warnings().is_empty(),
        "exposure makes up for bright lamps"
    );
}

#[test]
fn black_pictures_are_told_of() {
    let black = "[render]\nsize = [32, 32]\n[camera]\nposition = [0, 1, 3]\ntarget = [0, 0, 0]\nfov_deg = 30\n\
                 [[object]]\nname = 'floor'\nshape = 'quad'\nmaterial = 'm'\n[materials.m]\nbrdf = 'ggx'\n";
    let scene = scene(black);
    let probe = Probe::new(&scene, scene.size).unwrap();
    let [warning] = &probe.warnings()[..] else { panic!("{:?}", probe.warnings()) };
    assert!(warning.contains("the picture is black, no light reaches what the camera sees"), "{warning}");
    assert_eq!(probe.exposure_ev(), 0.0);
}

/// A small thing between the pixels of the picture is found, one behind another is not.
#[test]
fn small_things_are_in_view_and_hidden_ones_are_not() {
    let text = |z: f64| {
        format!(
            "[vary]\nmaterials = ['bead']\n[render]\nsize = [64, 64]\n[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_deg = 40\n\
             [environment]\n[materials.wall]\nbrdf = 'ggx'\n[materials.bead]\nbrdf = 'ggx'\n\
             [[object]]\nname = 'wall'\nshape = 'quad'\nmaterial = 'wall'\ntransform = {{ scale = 4, rotation_deg = [90, 0, 0] }}\n\
             [[object]]\nname = 'bead'\nshape = 'sphere'\nsubdivisions = 2\nmaterial = 'bead'\n\
             transform = {{ scale = 0.001, translation = [0.11, 0.13, {z}] }}\n"
        )
    };
    let warnings = |z: f64| {
        let scene = scene(&text(z));
        Probe::new(&scene, scene.size).unwrap().warnings()
    };
    assert_eq!(warnings(0.5), Vec::<String>::new());
    // With the wall behind the camera there is nothing else to see.
    let alone = scene(
        &text(0.5).replace("rotation_deg = [90, 0, 0]", "rotation_deg = [90, 0, 0], translation = [0, 0, 9]"),
    );
    let tiny = Probe::new(&alone, alone.size).unwrap().warnings();
    assert!(
        tiny.len() == 1 && tiny[0].contains("hardly anything of the picture shows a surface"),
        "{tiny:?}"
    );
    let hidden = warnings(-0.5);
    assert!(
        hidden.len() == 1
            && hidden[0].contains("material `bead` varies, but nothing that wears it is in view"),
        "{hidden:?}"
    );
}

#[test]
fn scenes_of_the_library_are_looked_at_without_a_word() {
    for name in ["cornell-knot", "ring", "showroom", "statue-hall", "knot-outdoors", "knot-twist"] {
        let scene = library_scene(name);
        assert_eq!(Probe::new(&scene, scene.size).unwrap().warnings(), Vec::<String>::new(), "{name}");
    }
}

/// A model is made a scene, looked at, baked and played by one command, without a file that anybody wrote.
#[test]
fn a_model_becomes_a_scene_and_a_bundle() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("it's a box.obj"), obj_of_box([0.0; 3], [60.0, 180.0, 40.0])).unwrap();
    let bake =
        |arguments: &[&str]| command("bake").args(arguments).current_dir(folder.path()).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();

    let output = bake(&["new", "it's a box.obj", "-o", "first"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).starts_with("first/scene.toml\nfirst/preview.png\n"),
        "{}",
        text(&output.stdout)
    );
    let written = std::fs::read_to_string(at("first/scene.toml")).unwrap();
    assert!(
        written.contains("taken for centimetres: 0.6 m × 1.8 m × 0.4 m")
            && written.contains("\nscale = 0.01\n"),
        "{written}"
    );
    assert!(written.contains("\nfile = \"../it's a box.obj\"  #"), "{written}");
    assert!(std::fs::read(at("first/preview.png")).unwrap().starts_with(b"\x89PNG"));
    let again = bake(&["new", "it's a box.obj", "-o", "first"]);
    assert_eq!(again.status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(at("first/scene.toml")).unwrap(), written, "nothing is overwritten");
    assert_eq!(bake(&["new", "it's a bxo.obj", "-o", "second"]).status.code(), Some(2));
    assert!(!at("second").exists(), "nothing is left of what failed");

    let plan = bake(&["plan", "it's a box.obj"]);
    assert!(
        plan.status.success() && text(&plan.stdout).contains("chosen: transfer-images"),
        "{}",
        text(&plan.stderr)
    );
    let wrong = bake(&["run", "it's a box.obj", "--max-error", "-1"]);
    assert!(
        wrong.status.code() == Some(2) && !at("baked").exists(),
        "options are looked at before anything is written"
    );
    let run = ["run", "it's a box.obj", "--size", "32x32", "--spp", "1", "--progress", "none"];
    let first = bake(&run);
    assert!(first.status.success(), "{}", text(&first.stderr));
    assert!(
        text(&first.stderr).contains("note: wrote baked/it's a box.toml, a first scene for it's a box.obj"),
        "{}",
        text(&first.stderr)
    );
    let scene_file = at("baked/it's a box.toml");
    // Another scene that is called the same would go to the same folder.
    std::fs::create_dir(at("other")).unwrap();
    std::fs::copy(at("it's a box.obj"), at("other/it's a box.obj")).unwrap();
    let same_name = std::fs::read_to_string(&scene_file).unwrap().replace("\"../it's", "\"./it's");
    std::fs::write(at("other/it's a box.toml"), same_name).unwrap();
    for other in ["other/it's a box.toml", "other/it's a box.obj"] {
        let refused = bake(&["run", other, "--size", "32x32", "--spp", "1", "--progress", "none"]);
        let told = text(&refused.stderr);
        assert!(refused.status.code() == Some(2) && told.contains("give another folder with -o"), "{told}");
    }
    let changed = std::fs::read_to_string(&scene_file).unwrap().replace("roughness = 0.5", "roughness = 0.6");
    std::fs::write(&scene_file, &changed).unwrap();
    let second = bake(&[&run[..], &["--force"]].concat());
    assert!(
        text(&second.stderr).contains("note: bakes baked/it's a box.toml, which is there already"),
        "{}",
        text(&second.stderr)
    );
    assert_eq!(std::fs::read_to_string(&scene_file).unwrap(), changed, "what was edited stays");
    // Written anew as the note says: not over a bundle that may be anybody's, unless that is asked for.
    std::fs::remove_file(&scene_file).unwrap();
    let refused = bake(&run);
    assert!(
        refused.status.code() == Some(2) && text(&refused.stderr).contains("or add --force to replace it")
    );
    assert!(!scene_file.exists(), "nothing is written");
    assert!(bake(&[&run[..], &["--force"]].concat()).status.success());
    assert!(std::fs::read_to_string(&scene_file).unwrap().contains("roughness = 0.5"));
    let bundle = at("baked/it's a box");
    expect_exit("bake", &["verify", bundle.to_str().unwrap()], 0);
    let frame = at("frame.png");
    expect_exit("player", &[bundle.to_str().unwrap(), "--headless", "--frames", frame.to_str().unwrap()], 0);
    assert!(frame.exists());
}
