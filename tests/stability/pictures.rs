//! The pictures of docs/STABILITY.md: each failure as the player shows it, the path-traced reference, and
//! their difference.
//!
//! `cargo test --release -p relume-tests stability::pictures -- --ignored --nocapture` makes them all in
//! docs/images/stability and prints the figures that the page quotes: relative L2 of the whole image, and how
//! many times the difference is magnified. `PICTURES=ring,roof` makes those whose names contain one of these.

use crate::support::{expect_exit, radiance_in, relative_l2, write_scene};
use relume_bake::exr_file::write_exr;
use relume_chart::metrics::Pair;
use relume_chart::picture::beside;
use std::path::Path;

/// Width and height of an image, pixels.
const SIDE: usize = 144;

/// One row of a picture.
struct Row {
    /// The scene that is baked.
    scene: String,
    /// More arguments of `bake run`.
    bake: &'static [&'static str],
    /// The scene of the reference, if it is another one.
    reference: Option<String>,
    /// More arguments of `bake reference`.
    trace: &'static [&'static str],
    /// The state of both.
    state: &'static str,
}

impl Row {
    /// Of a scene whose reference is the same scene with direct light alone.
    fn direct(scene: String, bake: &'static [&'static str]) -> Self {
        Self { scene, bake, reference: None, trace: &["--reflections", "1", "--spp", "256"], state: "" }
    }
}

/// A scene of the given objects, seen from the front, 5 m away.
fn scene(vary: &str, head: &str, environment: &str, objects: &str) -> String {
    format!(
        "[vary]\n{vary}\n[render]\nsize = [{SIDE}, {SIDE}]\n{head}\n[camera]\nposition = [0, 2.4, 4.4]\ntarget = [0, 0.35, 0]\nfov_deg = 30\n\
         [materials.plane]\nbrdf = 'blinn-phong'\nkd = [0.6, 0.6, 0.6]\n[materials.thing]\nbrdf = 'blinn-phong'\nkd = [0.7, 0.35, 0.2]\n\
         {environment}\n{objects}"
    )
}

fn plane(segments: u32) -> String {
    format!(
        "[[object]]\nname = 'plane'\nshape = 'quad'\nsegments = {segments}\nmaterial = 'plane'\ntransform = {{ scale = 4 }}\n"
    )
}

fn thing(name: &str, keys: &str, transform: &str) -> String {
    format!("[[object]]\nname = '{name}'\n{keys}\nmaterial = 'thing'\ntransform = {{ {transform} }}\n")
}

const SUN: &str = "[environment]\nfile = 'sun.exr'";
const LAMP: &str = "[environment]\nfile = 'lamp.exr'";
const SKY: &str = "[environment]\nfile = 'clear-sky'";
const LAMPS: &str = "[environment]\nfile = 'lamps'";
const WHITE: &str = "[environment]";
const WHITE_AND_SUN: &str = "[environment]\nothers = ['sun.exr']";

/// Light and view vary.
fn relit(environment: &str, objects: &str) -> String {
    scene("light = true\nview = true", "reflections = 1", environment, objects)
}

/// Shapes vary too; the plane has the 128 × 128 vertices that docs/reference/sphere-shadows.md advises.
fn shadowed(environment: &str, objects: &str) -> String {
    scene("light = true\nview = true\nshape = true", "reflections = 1", environment, &(plane(127) + objects))
}

fn ball() -> String {
    thing("ball", "shape = 'sphere'\nsubdivisions = 3", "translation = [0, 0.8, 0], scale = 0.4")
}

/// Writes what scenes refer to: a grey sky with a sun of 10⁵ W/(sr·m²) in one texel of half a degree, the same with
/// a lamp of 10°, as strong in all, around it, and a bowl that is open above.
fn write_files(folder: &Path) {
    let (width, height) = (720, 360);
    for (name, reach) in [("sun.exr", 0.0), ("lamp.exr", 10.0)] {
        let mut texels = vec![0.1f32; width * height];
        // Rows are 38° above the horizon there, and columns that much nearer to each other.
        let near = |x: usize, y: usize| ((x as f32 - 250.0) * 0.788).hypot(y as f32 - 76.0) <= reach;
        let lit: Vec<usize> = (0..width * height).filter(|i| near(i % width, i / width)).collect();
        lit.iter().for_each(|i| texels[*i] = 1e5 / lit.len() as f32);
        let channels = ["R", "G", "B"].map(|name| (name, texels.as_slice()));
        write_exr(&folder.join(name), width, height, &channels).unwrap();
    }
    let (around, up) = (24, 6);
    let mut bowl = "v 0 -1 0\n".to_owned();
    for (ring, k) in (1..=up).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let (polar, azimuth) = (
            std::f64::consts::FRAC_PI_2 * f64::from(ring) / f64::from(up),
            std::f64::consts::TAU * f64::from(k) / f64::from(around),
        );
        bowl +=
            &format!("v {} {} {}\n", polar.sin() * azimuth.sin(), -polar.cos(), polar.sin() * azimuth.cos());
    }
    let vertex =
        |ring: u32, k: u32| if ring == 0 { 1 } else { 2 + (ring - 1) * around as u32 + k % around as u32 };
    for (ring, k) in (0..up as u32).flat_map(|ring| (0..around as u32).map(move |k| (ring, k))) {
        let [a, b, c, d] =
            [vertex(ring, k), vertex(ring, k + 1), vertex(ring + 1, k + 1), vertex(ring + 1, k)];
        bowl += &if ring == 0 { format!("f {a} {d} {c}\n") } else { format!("f {a} {d} {c} {b}\n") };
    }
    std::fs::write(folder.join("bowl.obj"), bowl).unwrap();
}

/// What the player shows, and the reference.
fn played_and_traced(row: &Row) -> [Vec<[f32; 3]>; 2] {
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (bundle, state, size) = (file("bundle"), file("state.toml"), format!("{SIDE}x{SIDE}"));
    std::fs::write(&state, row.state).unwrap();
    let path = write_scene(folder.path(), &row.scene);
    let scene = path.to_str().unwrap();
    expect_exit(
        "bake",
        &[&["run", scene, "-o", &bundle, "--size", &size, "--progress", "none"], row.bake].concat(),
        0,
    );
    let (played, traced) = (file("played.exr"), file("traced.exr"));
    expect_exit("player", &[&bundle, "--headless", "--size", &size, "--state", &state, "--exr", &played], 0);
    let mut trace = vec!["reference", scene, "--size", &size, "-o", &traced, "--progress", "none"];
    if let Some(reference) = &row.reference {
        write_scene(folder.path(), reference);
    } else {
        trace.extend(["--state", &state]);
    }
    expect_exit("bake", &[&trace, row.trace].concat(), 0);
    [radiance_in(Path::new(&played)), radiance_in(Path::new(&traced))]
}

/// Makes docs/images/stability/`name`.png, unless others are asked for.
fn picture(name: &str, exposure_ev: f32, rows: &[Row]) {
    let asked = std::env::var("PICTURES").unwrap_or_default();
    if !asked.split(',').any(|part| name.contains(part)) {
        return;
    }
    let images: Vec<_> = rows.iter().map(played_and_traced).collect();
    let counted = vec![true; SIDE * SIDE];
    let pairs: Vec<Pair<'_>> =
        images.iter().map(|[ours, truth]| Pair { ours, truth, counted: &counted, exposure_ev }).collect();
    let (png, factor) = beside(&pairs, [SIDE as u32; 2]).unwrap();
    let errors: Vec<String> =
        images.iter().map(|[ours, truth]| format!("{:.2} %", 100.0 * relative_l2(ours, truth))).collect();
    println!("{name}: relative L2 {}, difference × {factor}, {} kB", errors.join(", "), png.len() / 1000);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/images/stability");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(format!("{name}.png")), png).unwrap();
}

/// The library's ring with a lamp of `gain` times its radiance, and its plane replaced.
fn ring(gain: f64) -> String {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/library/ring/scene.toml"),
    )
    .unwrap();
    assert!(text.contains("[3500.0, 3500.0, 3500.0]"));
    text.replace("[3500.0, 3500.0, 3500.0]", &format!("{:?}", [3500.0 * gain; 3]))
}

/// Same paths as the bake's.
const OWN_PATHS: &[&str] = &["--paths", "gather", "--reflections", "2", "--spp", "256"];

#[test]
#[ignore = "makes pictures of docs/STABILITY.md"]
fn of_transfer_images() {
    let end = "[materials.plane]\nkd = [0.02, 0.02, 0.02]\nks = [0.6, 0.6, 0.6]\nshininess = 200.0\n[materials.ring]\nshininess = 200.0\n";
    let with = |bake| Row { scene: ring(1.0), bake, reference: None, trace: OWN_PATHS, state: end };
    picture("images-end-of-range", 1.0, &[with(&["--bases", "6"]), with(&["--bases", "9"])]);

    let floor = |keys: &str, vary: &str| {
        let lamp = "[[light]]\nname = 'lamp'\nkind = 'area'\nradiance = [9, 8, 6]\ntransform = { translation = [-0.8, 1.6, -1.2], rotation_deg = [-30, -145, 0], scale = 0.6 }";
        let text = scene(
            vary,
            "reflections = 2",
            "[environment]\ngain = [0.1, 0.12, 0.16]",
            &(plane(1) + &ball() + lamp),
        );
        text.replace("kd = [0.6, 0.6, 0.6]", &format!("kd = [0.1, 0.1, 0.1]\nks = [0.8, 0.8, 0.8]\n{keys}"))
    };
    let sharpest = Row {
        scene: floor("shininess = 200.0", "materials = ['plane']"),
        bake: &["--bases", "9", "--spp", "256"],
        reference: Some(floor("shininess = 5000.0", "")),
        trace: &["--reflections", "2", "--spp", "256"],
        state: "",
    };
    let asked = Row {
        scene: floor("shininess = 5000.0", "materials = ['plane']\nshininess_max = 5000"),
        bake: &["--bases", "16", "--spp", "256"],
        reference: None,
        trace: sharpest.trace,
        state: "",
    };
    picture("images-near-mirror", 0.0, &[sharpest, asked]);

    let bright =
        Row { scene: ring(1e7), bake: &["--bases", "9"], reference: None, trace: OWN_PATHS, state: "" };
    picture("images-bright-caustic", -22.5, &[bright]);

    let room = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/library/cornell-knot/scene.toml"),
    )
    .unwrap();
    let bounces = Row {
        scene: room.replace("[render]", "[render]\nreflections = 2"),
        bake: &["--bases", "9", "--spp", "256"],
        reference: None,
        trace: &["--spp", "256"],
        state: "[materials.walls]\nkd = [0.8, 0.8, 0.8]\n",
    };
    picture("images-two-reflections", 0.0, &[bounces]);
}

#[test]
#[ignore = "makes pictures of docs/STABILITY.md"]
fn of_sparse_transfer() {
    let few = |bake| Row::direct(relit(SUN, &(plane(40) + &ball())), bake);
    picture(
        "transfer-sun-few-terms",
        -1.0,
        &[few(&["--terms", "50", "--quality", "draft"]), few(&["--terms", "1024", "--quality", "draft"])],
    );
    let mesh = |segments| {
        Row::direct(relit(SKY, &(plane(segments) + &ball())), &["--terms", "1024", "--quality", "draft"])
    };
    picture("transfer-coarse-mesh", -0.5, &[mesh(10), mesh(40)]);
    let objects = plane(40) + &ball();
    let bounced = Row {
        trace: &["--reflections", "2", "--spp", "256"],
        ..Row::direct(
            relit(LAMPS, &objects).replace("reflections = 1", "reflections = 2"),
            &["--terms", "1024", "--quality", "draft"],
        )
    };
    picture(
        "transfer-bounced-lamps",
        -1.5,
        &[Row::direct(relit(LAMPS, &objects), &["--terms", "1024", "--quality", "draft"]), bounced],
    );
    // As the player finds it: a state that names a map beside it.
    let alien = |baked_under| Row {
        reference: Some(relit(SUN, &objects)),
        state: "[environment]\nmap = 'sun.exr'\n",
        ..Row::direct(relit(baked_under, &objects), &["--quality", "draft"])
    };
    picture("transfer-map-of-ones-own", -1.0, &[alien(WHITE), alien(WHITE_AND_SUN)]);
    let glossy = relit(SKY, &objects)
        .replace("kd = [0.7, 0.35, 0.2]", "kd = [0.4, 0.2, 0.1]\nks = [0.4, 0.4, 0.4]\nshininess = 60.0");
    picture(
        "transfer-no-highlights",
        -0.5,
        &[Row::direct(glossy, &["--terms", "400", "--quality", "draft"])],
    );
}

#[test]
#[ignore = "makes pictures of docs/STABILITY.md"]
fn of_sphere_shadows() {
    let one = |environment, object: String| Row::direct(shadowed(environment, &object), &[]);
    let cube = |height: f32| {
        one(
            SKY,
            thing(
                "cube",
                "shape = 'box'\nspheres = 32",
                &format!("translation = [0, {height}, 0], scale = 0.7"),
            ),
        )
    };
    picture("shadows-contact", -0.5, &[cube(0.35), cube(0.45)]);
    let knot = thing(
        "knot",
        "shape = 'torus-knot'\nradius = 0.5\ntube = 0.14",
        "translation = [0, 0.75, 0], rotation_deg = [70, 0, 0]",
    );
    let within = |max_error| Row::direct(shadowed(WHITE, &knot), max_error);
    picture("shadows-error-asked-for", -0.5, &[within(&["--max-error", "0.3"]), within(&[])]);
    let ball = thing("ball", "shape = 'sphere'\nsubdivisions = 4", "translation = [0, 0.5, 0], scale = 0.4");
    picture("shadows-wide-lamp", -1.0, &[one(LAMP, ball.clone()), one(SUN, ball.clone())]);
    let far = ball
        + "[[object]]\nname = 'far'\nshape = 'box'\nmaterial = 'plane'\n\
        transform = { translation = [0, -51, -400], scale = 100 }\n";
    picture("shadows-wide-scene", -1.0, &[one(SUN, far)]);
    picture(
        "shadows-open-bowl",
        -0.5,
        &[one(WHITE, thing("bowl", "file = 'bowl.obj'", "translation = [0, 0.9, 0], scale = 0.6"))],
    );
}
