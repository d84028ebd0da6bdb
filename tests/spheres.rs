//! Sphere sets as a user makes them: `bake spheres`, and objects of a scene that ask for some.

use crate::support::waiting::{interrupt, wait_for};
use crate::support::{command, expect_exit, run, write_scene};
use relume_formats::container::Stored;
use relume_formats::kinds::{Manifest, SphereSet};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;

/// A box of 2 × 1 × 1, its triangles facing outwards.
const BOX: &str = "v -1 -0.5 -0.5\nv 1 -0.5 -0.5\nv 1 0.5 -0.5\nv -1 0.5 -0.5\nv -1 -0.5 0.5\nv 1 -0.5 0.5\nv 1 0.5 0.5\nv -1 0.5 0.5\n\
                   f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

/// A folder with a mesh in it.
struct Workshop {
    folder: tempfile::TempDir,
}

impl Workshop {
    fn new() -> Self {
        let workshop = Self { folder: tempfile::tempdir().unwrap() };
        workshop.write("box.obj", BOX);
        workshop
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.folder.path().join(name), text).unwrap();
        self.path(name)
    }

    /// Fits `n` spheres to the box into the file `output`; returns its bytes.
    fn fit(&self, n: &str, output: &str, more: &[&str]) -> Vec<u8> {
        let (mesh, output) = (self.path("box.obj"), self.path(output));
        expect_exit(
            "bake",
            &[&["spheres", &mesh, "-n", n, "-o", &output, "--progress", "none"], more].concat(),
            0,
        );
        std::fs::read(output).unwrap()
    }

    fn files(&self) -> Vec<String> {
        let mut files: Vec<_> = std::fs::read_dir(&self.folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        files
    }
}

#[test]
fn a_set_of_a_mesh_file_and_what_other_commands_make_of_it() {
    let w = Workshop::new();
    w.fit("6", "deep/er/set.relume", &["--seed", "3", "--iterations", "20"]);
    let set_path = w.path("deep/er/set.relume");
    let set = SphereSet::read_file(Path::new(&set_path)).unwrap();
    assert_eq!((set.spheres.len(), set.meta.seed, set.meta.iterations, set.meta.tight), (6, 3, 20, 0.0));
    assert_eq!((set.meta.mesh.as_str(), set.meta.triangles), ("box.obj", 12));
    assert!((set.meta.volume - 2.0).abs() < 1e-6, "{}", set.meta.volume);

    expect_exit("bake", &["verify", &set_path], 0);
    let info: Value = serde_json::from_slice(&run("bake", &["info", &set_path, "--json"]).stdout).unwrap();
    assert_eq!((&info["kind"], &info["details"]["n"]), (&"sphere-set".into(), &6.into()));
    let export = w.path("export");
    expect_exit("bake", &["export", &set_path, "-o", &export], 0);
    for file in ["spheres.npy", "points.npy", "cluster.npy", "history.npy", "spheres.ply", "metrics.json"] {
        assert!(Path::new(&export).join(file).exists(), "{file}");
    }
    let report: Value =
        serde_json::from_slice(&std::fs::read(w.path("deep/er/report.json")).unwrap()).unwrap();
    assert!(report["spheres"]["set.relume"]["seconds"].is_number(), "{report}");
    assert!(report["spheres"]["set.relume"]["threads"].is_number(), "{report}");
}

/// A tetrahedron that clips of these names move, as glTF beside its `clips.bin`.
fn moving(w: &Workshop, names: &[&str]) -> String {
    let floats: [f32; 20] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 0., 0., 0., 3., 0., 0.];
    let indices: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let bytes =
        floats.iter().flat_map(|x| x.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes()));
    std::fs::write(w.path("clips.bin"), bytes.collect::<Vec<u8>>()).unwrap();
    let view = |offset: u32, length: u32| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let accessor = |view: u32, component: u32, count: u32, kind: &str| json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
    let (mut positions, mut times) = (accessor(0, 5126, 4, "VEC3"), accessor(1, 5126, 2, "SCALAR"));
    (positions["min"], positions["max"], times["min"], times["max"]) =
        (json!([0, 0, 0]), json!([1, 1, 1]), json!([0]), json!([1]));
    let clip = |name: &&str| json!({ "name": name, "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }], "samplers": [{ "input": 1, "output": 2 }] });
    let gltf = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 3 }] }],
        "buffers": [{ "uri": "clips.bin", "byteLength": 104 }],
        "bufferViews": [view(0, 48), view(48, 8), view(56, 24), view(80, 24)],
        "accessors": [positions, times, accessor(2, 5126, 2, "VEC3"), accessor(3, 5123, 12, "SCALAR")],
        "animations": names.iter().map(clip).collect::<Vec<Value>>(),
    });
    w.write("clips.gltf", &gltf.to_string())
}

#[test]
fn the_poses_of_clips_are_looked_at_and_broken_clips_keep_no_mesh_from_its_spheres() {
    let w = Workshop::new();
    for (names, broken, poses, warning) in [
        (&["Up"][..], false, 5, None),
        (&["Up"], true, 0, Some("fitted at rest, without a look at its clips")),
        (&[], false, 0, None),
    ] {
        let (mesh, output) = (moving(&w, names), w.path("set.relume"));
        if broken {
            // Places that are single numbers.
            let text = std::fs::read_to_string(&mesh).unwrap();
            w.write("clips.gltf", &text.replace("\"output\":2", "\"output\":1"));
        }
        let result = run(
            "bake",
            &["spheres", &mesh, "-n", "3", "--iterations", "8", "-o", &output, "--progress", "none"],
        );
        let errors = String::from_utf8(result.stderr).unwrap();
        assert!(result.status.success(), "{errors}");
        assert_eq!(SphereSet::read_file(Path::new(&output)).unwrap().meta.poses, poses, "{names:?}");
        assert_eq!(errors.contains("at its clips"), warning.is_some(), "{errors}");
        assert!(warning.is_none_or(|warning| errors.contains(warning)), "{errors}");
        expect_exit("bake", &["verify", &output], 0);
    }
}

#[test]
fn without_an_output_the_file_is_called_as_the_mesh() {
    let w = Workshop::new();
    let output = command("bake")
        .args(["spheres", "box.obj", "-n", "2"])
        .current_dir(w.folder.path())
        .output()
        .unwrap();
    assert!(output.status.success());
    assert_eq!(w.files(), ["box-spheres-2.relume", "box.obj", "report.json"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for part in ["E/V(T)", "coverage", "protrusion", "gap", "box-spheres-2.relume"] {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
}

#[test]
fn the_seed_decides_the_bytes_and_threads_do_not() {
    let w = Workshop::new();
    let one = w.fit("5", "one.relume", &["--threads", "1"]);
    assert_eq!(w.fit("5", "two.relume", &["--threads", "2"]), one);
    assert_eq!(w.fit("5", "again.relume", &["--threads", "1"]), one);
    assert_ne!(
        w.fit("5", "other.relume", &["--seed", "1"]),
        one,
        "the seed is on record, whatever the spheres"
    );
}

#[test]
fn bad_input_gets_one_line_and_leaves_nothing() {
    let w = Workshop::new();
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    w.write("empty.obj", "");
    w.write("vertices.obj", vertices);
    w.write("nan.obj", &BOX.replace("v 1 0.5 0.5", "v 1 nan 0.5"));
    w.write("flat.obj", &format!("{vertices}f 1 2 3 4\n"));
    w.write("box.stl", BOX);
    w.write("cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
    let before = w.files();
    // Mesh, options, and what the line must name.
    let cases: [(&str, &[&str], &[&str]); 13] = [
        ("missing.obj", &["-n", "8"], &["missing.obj"]),
        ("empty.obj", &["-n", "8"], &["empty.obj"]),
        ("vertices.obj", &["-n", "8"], &["vertices.obj"]),
        ("nan.obj", &["-n", "8"], &["nan.obj", "vertex"]),
        ("flat.obj", &["-n", "8"], &["flat.obj", "volume"]),
        ("box.stl", &["-n", "8"], &["box.stl", ".obj", ".glb"]),
        ("cut.ply", &["-n", "8"], &["cut.ply"]),
        ("box.obj", &["-n", "0"], &["0", "1..=4096"]),
        ("box.obj", &["-n", "5000"], &["5000", "1..=4096"]),
        ("box.obj", &["-n", "many"], &["many"]),
        ("box.obj", &[], &["-n"]),
        ("box.obj", &["-n", "8", "--tight", "2"], &["--tight", "0.1"]),
        ("box.obj", &["-n", "8", "--tight", "NaN"], &["--tight", "0.1"]),
    ];
    for (mesh, options, parts) in cases {
        let (mesh, output) = (w.path(mesh), w.path("bad.relume"));
        let stderr = expect_exit(
            "bake",
            &[&["spheres", &mesh, "-o", &output, "--progress", "none"], options].concat(),
            2,
        );
        let line = stderr.lines().find(|line| line.starts_with("error: ")).unwrap();
        parts.iter().for_each(|part| assert!(line.contains(part), "`{part}` is not in `{line}`"));
        assert_eq!(w.files(), before, "{line}");
    }
    let stderr =
        expect_exit("bake", &["spheres", &w.path("box.obj"), "-n", "8", "-o", &w.path("set.bin")], 2);
    assert!(stderr.contains("set.bin") && stderr.contains(".relume"), "{stderr}");
    assert_eq!(w.files(), before);
}

/// A torus of `around` × `along` quads.
fn torus_obj(around: usize, along: usize) -> String {
    let mut text = String::new();
    for i in 0..around {
        for j in 0..along {
            let turn = |k: usize, n: usize| (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            let ((su, cu), (sv, cv)) = (turn(i, around), turn(j, along));
            let ring = 1.0 + 0.35 * cv;
            writeln!(text, "v {} {} {}", ring * cu, ring * su, 0.35 * sv).unwrap();
        }
    }
    for i in 0..around {
        for j in 0..along {
            let vertex = |i: usize, j: usize| (i % around) * along + j % along + 1;
            writeln!(
                text,
                "f {} {} {} {}",
                vertex(i, j),
                vertex(i + 1, j),
                vertex(i + 1, j + 1),
                vertex(i, j + 1)
            )
            .unwrap();
        }
    }
    text
}

#[test]
fn an_interrupted_fit_leaves_no_file() {
    let w = Workshop::new();
    let mesh = w.write("torus.obj", &torus_obj(128, 64));
    let before = w.files();
    let output = w.path("set.relume");
    let arguments =
        ["spheres", &mesh, "-n", "1024", "--iterations", "1000000", "-o", &output, "--progress", "json"];
    let mut child =
        command("bake").args(arguments).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    // What the loader mended comes first.
    assert!(
        lines.any(|line| line.unwrap().contains("\"stage\"")),
        "the fit ended before it told of its progress"
    );
    assert!(
        std::process::Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .unwrap()
            .success()
    );
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("error: ")), "{rest:?}");
    assert_eq!(w.files(), before);
}

/// A ball over a floor under a lamp; the ball asks for spheres.
const SCENE: &str = "
    [vary]
    materials = ['clay']
    [render]
    size = [24, 16]
    [camera]
    position = [0.0, 1.0, 4.0]
    target = [0.0, 0.5, 0.0]
    fov_deg = 45.0
    [materials.clay]
    brdf = 'blinn-phong'
    kd = [0.5, 0.5, 0.5]
    [[object]]
    name = 'ball'
    shape = 'sphere'
    subdivisions = 2
    material = 'clay'
    transform = { translation = [0.5, 1.0, 0.0], scale = 0.5 }
    spheres = 8
    [[object]]
    name = 'floor'
    shape = 'quad'
    material = 'clay'
    transform = { scale = 4.0 }
    [[light]]
    name = 'lamp'
    kind = 'area'
    radiance = [10.0, 10.0, 10.0]
    transform = { translation = [0.0, 3.0, 0.0], rotation_deg = [-90.0, 0.0, 0.0] }
";

const RUN: [&str; 6] = ["--spp", "4", "--bases", "4", "--progress", "none"];

#[test]
fn an_object_of_a_scene_gets_its_spheres_once() {
    let w = Workshop::new();
    let bundle = w.path("bundle");
    let bake = |text: &str, more: &[&str]| {
        let scene = write_scene(w.folder.path(), text);
        let output =
            run("bake", &[&["run", scene.to_str().unwrap(), "-o", &bundle], &RUN[..], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    bake(SCENE, &[]);
    let folder = Path::new(&bundle);
    let manifest = Manifest::read(folder).unwrap();
    let entry = &manifest.sphere_sets["ball"];
    assert_eq!((entry.file.file.as_str(), &entry.settings["spheres"]), ("spheres-ball.relume", &8.into()));
    assert_eq!(manifest.sphere_sets.len(), 1);
    let path = folder.join("spheres-ball.relume");
    let set = SphereSet::read_file(&path).unwrap();
    assert_eq!((set.spheres.len(), set.meta.mesh.as_str()), (8, "ball"));
    // In world space: the points lie about the place that the scene gives the ball.
    let centre: [f32; 3] =
        std::array::from_fn(|k| set.points.iter().map(|p| p[k]).sum::<f32>() / set.points.len() as f32);
    assert!(centre.iter().zip([0.5, 1.0, 0.0]).all(|(is, wanted)| (is - wanted).abs() < 0.05), "{centre:?}");

    expect_exit("bake", &["verify", &bundle], 0);
    expect_exit("bake", &["export", &bundle, "-o", &w.path("export")], 0);
    assert!(folder.join("../export/spheres-ball/spheres.npy").exists());
    expect_exit("player", &[&bundle, "--headless", "--frames", &w.path("frame.png")], 0);

    // What the mesh does not depend on changes nothing of the spheres.
    let written = || std::fs::metadata(&path).unwrap().modified().unwrap();
    let (before, bytes) = (written(), std::fs::read(&path).unwrap());
    assert!(bake(SCENE, &[]).contains("spheres up to date, reused"));
    assert!(
        bake(&SCENE.replace("[10.0, 10.0, 10.0]", "[9.0, 9.0, 9.0]"), &[])
            .contains("spheres up to date, reused")
    );
    assert_eq!(written(), before);
    // The number of spheres, the seed, the mesh and --force do.
    bake(&SCENE.replace("spheres = 8", "spheres = 9"), &[]);
    assert_eq!(SphereSet::read_file(&path).unwrap().spheres.len(), 9);
    bake(SCENE, &["--seed", "5"]);
    assert_eq!(SphereSet::read_file(&path).unwrap().meta.seed, 5);
    bake(&SCENE.replace("[0.5, 1.0, 0.0]", "[0.5, 1.5, 0.0]"), &["--seed", "5"]);
    assert_ne!(std::fs::read(&path).unwrap(), bytes);
    let text = bake(SCENE, &["--force"]);
    assert!(!text.contains("spheres up to date"), "{text}");
    assert_eq!(std::fs::read(&path).unwrap(), bytes);

    // A set that is not the one of its object, and one that nobody wants any more.
    let listed = std::fs::read_to_string(folder.join("manifest.json")).unwrap();
    std::fs::write(folder.join("manifest.json"), listed.replace("\"ball\": {", "\"floor\": {")).unwrap();
    assert!(expect_exit("bake", &["verify", &bundle], 2).contains("holds the spheres of `ball`"));
    std::fs::write(folder.join("manifest.json"), listed).unwrap();
    bake(&SCENE.replace("    spheres = 8\n", ""), &[]);
    assert!(!path.exists());
    expect_exit("bake", &["verify", &bundle], 0);
}

/// Stopped while it traces, a bake goes on with the spheres that it has.
#[test]
fn an_interrupted_bake_keeps_its_spheres() {
    let w = Workshop::new();
    let scene = write_scene(w.folder.path(), SCENE);
    let arguments = |samples: &'static str, bundle: String, more: &[&'static str]| -> Vec<String> {
        let fixed = [
            "run",
            scene.to_str().unwrap(),
            "-o",
            &bundle,
            "--spp",
            samples,
            "--bases",
            "4",
            "--progress",
            "none",
        ];
        fixed.iter().chain(more).map(|a| (*a).to_owned()).collect()
    };
    let mut child = command("bake")
        .args(arguments("65536", w.path("bundle"), &[]))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let log = w.folder.path().join("bundle/unfinished/transfer-images.log");
    wait_for(&mut child, "the log of tiles", || log.exists().then_some(()));
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!w.folder.path().join("bundle/manifest.json").exists());
    let again = arguments("65536", w.path("bundle"), &[]);
    let again: Vec<&str> = again.iter().map(String::as_str).collect();
    assert!(expect_exit("bake", &again, 2).contains("--resume"));
    // Tracing goes on with other samples only after --force; the spheres' own log is what is asked about
    // here.
    std::fs::remove_file(&log).unwrap();
    let resumed = arguments("4", w.path("bundle"), &["--resume"]);
    let output = run("bake", &resumed.iter().map(String::as_str).collect::<Vec<_>>());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("spheres up to date, reused"), "{text}");
    let whole = arguments("4", w.path("whole"), &[]);
    expect_exit("bake", &whole.iter().map(String::as_str).collect::<Vec<_>>(), 0);
    for file in ["spheres-ball.relume", "manifest.json"] {
        let read = |bundle: &str| std::fs::read(w.folder.path().join(bundle).join(file)).unwrap();
        assert_eq!(read("bundle"), read("whole"), "{file}");
    }
}

#[test]
fn objects_that_cannot_have_spheres_are_refused() {
    let w = Workshop::new();
    let flat =
        SCENE.replace("    spheres = 8\n", "").replace("shape = 'quad'", "shape = 'quad'\n    spheres = 8");
    let cases = [
        (SCENE.replace("spheres = 8", "spheres = 0"), "spheres 0 is outside 1..4096"),
        (SCENE.replace("spheres = 8", "spheres = 4097"), "spheres 4097 is outside 1..4096"),
        (SCENE.replace("spheres = 8", "spheres = -1"), "-1"),
        (SCENE.replace("spheres = 8", "sphere = 8"), "did you mean `spheres`"),
        (SCENE.replace("name = 'ball'", "name = '../ball'"), "the name of an object with `spheres`"),
        (
            SCENE.replace("shape = 'sphere'\n    subdivisions = 2\n    material = 'clay'", "file = 'x.glb'"),
            "no such file: `x.glb`",
        ),
        (flat, "object `floor`"),
    ];
    for (text, part) in cases {
        let scene = write_scene(w.folder.path(), &text);
        let stderr = expect_exit(
            "bake",
            &[&["run", scene.to_str().unwrap(), "-o", &w.path("bad")], &RUN[..]].concat(),
            2,
        );
        assert!(stderr.contains(part), "`{part}` is not in `{stderr}`");
        assert!(!Path::new(&w.path("bad")).join("manifest.json").exists());
    }
}
