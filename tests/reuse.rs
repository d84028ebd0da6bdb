//! What a change of a scene makes a bake trace again, counted in rays, and as docs/notes/REUSE.md has it.

mod kept;

use crate::support::{copy_folder, job, write_scene};
use relume_bake::bundle;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::registered::Registered;
use relume_bake::unfinished::Leftover;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Words in capitals stand for what a method needs.
const SCENE: &str = "
    [vary]
    VARY
    [render]
    size = [16, 16]
    reflections = REFLECTIONS
    [camera]
    position = [0.0, 1.0, 4.0]
    target = [0.0, 0.4, 0.0]
    fov_deg = 45.0
    [materials.clay]
    brdf = 'blinn-phong'
    kd = [0.5, 0.4, 0.3]
    [materials.slate]
    brdf = 'blinn-phong'
    kd = [0.2, 0.2, 0.25]
    [[object]]
    name = 'ball'
    shape = 'sphere'
    subdivisions = 1
    material = 'clay'
    SPHERES
    transform = { translation = [0.0, 0.5, 0.0], scale = 0.5 }
    [[object]]
    name = 'floor'
    shape = 'quad'
    segments = 4
    material = 'slate'
    transform = { scale = 4.0 }
    [environment]
    file = 'lamps'
    gain = [1.0, 1.0, 1.0]
    rotation_deg = 0.0
    LIGHT
";
const LAMP: &str = "[[light]]
    name = 'lamp'
    kind = 'point'
    intensity = [2.0, 2.0, 2.0]
    transform = { translation = [0.0, 3.0, 1.0] }";

/// A change: what it is, and what becomes of which words; where these are empty, an animation is added.
const CHANGES: [(&str, &str, &str); 14] = [
    ("the camera moves", "position = [0.0, 1.0, 4.0]", "position = [0.5, 1.0, 4.0]"),
    ("another film size", "size = [16, 16]", "size = [24, 16]"),
    ("another exposure", "fov_deg = 45.0", "fov_deg = 45.0\n    exposure_ev = 1.0"),
    (
        "another curve of the display",
        "    [environment]",
        "    [view]\n    tonemap = 'agx'\n    [environment]",
    ),
    ("an animation more", "", ""),
    ("gain of the environment", "gain = [1.0, 1.0, 1.0]", "gain = [2.0, 1.0, 1.0]"),
    ("rotation of the environment", "rotation_deg = 0.0", "rotation_deg = 30.0"),
    ("a further environment map", "file = 'lamps'", "file = 'lamps'\n    others = ['clear-sky']"),
    ("a default of a material that varies", "kd = [0.5, 0.4, 0.3]", "kd = [0.4, 0.4, 0.3]"),
    ("a material that stays", "kd = [0.2, 0.2, 0.25]", "kd = [0.2, 0.3, 0.25]"),
    ("its highlight", "kd = [0.2, 0.2, 0.25]", "kd = [0.2, 0.2, 0.25]\n    ks = [0.1, 0.1, 0.1]"),
    ("a light", "intensity = [2.0, 2.0, 2.0]", "intensity = [3.0, 2.0, 2.0]"),
    ("an object's transform", "translation = [0.0, 0.5, 0.0]", "translation = [0.1, 0.5, 0.0]"),
    ("an object's name", "name = 'ball'", "name = 'globe'"),
];

/// A method and how the scene suits it.
struct Column {
    title: &'static str,
    method: &'static str,
    vary: &'static str,
    reflections: u32,
}

const IMAGES: Column = Column {
    title: "transfer-images",
    method: "transfer-images",
    vary: "materials = ['clay']",
    reflections: 2,
};

/// Those whose logs are kept.
const SPARSE: [Column; 3] = [
    Column {
        title: "sparse-transfer",
        method: "sparse-transfer",
        vary: "light = true\nview = true\nmaterials = ['clay']",
        reflections: 1,
    },
    Column {
        title: "sparse-transfer, light bounces",
        method: "sparse-transfer",
        vary: "light = true\nview = true\nmaterials = ['clay']",
        reflections: 2,
    },
    Column {
        title: "sphere-shadows",
        method: "sphere-shadows",
        vary: "light = true\nview = true\nmaterials = ['clay']",
        reflections: 1,
    },
];

/// The scene of a column.
fn of_column(column: &Column) -> String {
    let (light, spheres) = if column.method == "transfer-images" { (LAMP, "") } else { ("", "spheres = 2") };
    SCENE
        .replace("VARY", column.vary)
        .replace("REFLECTIONS", &column.reflections.to_string())
        .replace("SPHERES", spheres)
        .replace("LIGHT", light)
}

/// Rays that the method traces for the bundle in `folder` of the scene that stands there; `None` if it reuses
/// the files that it has.
fn rays(folder: &Path, method: &str) -> Option<u64> {
    let scene = relume_scenes::load(&folder.join("scene.toml")).unwrap();
    let asked = Asked { samples: Some(4), bases: Some(3), terms: Some(8), ..Asked::of_scene(&scene) };
    let methods = [(Registered::find(method).unwrap().new)(&asked, &scene)];
    let (summary, _) =
        bundle::run(&scene, &methods, scene.size, &folder.join("out"), Leftover::Refuse, 0, &job()).unwrap();
    summary.methods[0].traced.map(|traced| traced.rays)
}

/// Where the scene and its bundle are in a folder: scenes are called after the folder that they are in.
fn home(folder: &tempfile::TempDir) -> PathBuf {
    let home = folder.path().join("scene");
    std::fs::create_dir_all(&home).unwrap();
    home
}

/// The scene of a column, baked once.
struct Baked {
    method: &'static str,
    text: String,
    folder: tempfile::TempDir,
}

impl Baked {
    fn new(column: &Column) -> Self {
        let text = of_column(column);
        let folder = tempfile::tempdir().unwrap();
        write_scene(&home(&folder), &text);
        assert!(rays(&home(&folder), column.method).is_some_and(|rays| rays > 0));
        assert_eq!(rays(&home(&folder), column.method), None, "the same scene again");
        Self { method: column.method, text, folder }
    }

    /// What the table says of a change, made to a copy of the bundle.
    fn after(&self, from: &str, to: &str) -> &'static str {
        if !self.text.contains(from) {
            return "-";
        }
        let folder = tempfile::tempdir().unwrap();
        let home_of_copy = home(&folder);
        write_scene(&home_of_copy, &self.text.replace(from, to));
        copy_folder(&home(&self.folder).join("out"), &home_of_copy.join("out"));
        if from.is_empty() {
            std::fs::create_dir(home_of_copy.join("animations")).unwrap();
            let animation = "duration_s = 1.0\n[[key]]\nt_s = 0\ncamera.exposure_ev = 1.0\n";
            std::fs::write(home_of_copy.join("animations/fade.toml"), animation).unwrap();
        }
        match rays(&home_of_copy, self.method) {
            None | Some(0) => "0 rays",
            Some(_) => "traced",
        }
    }
}

#[test]
fn a_change_traces_what_it_must_and_no_more() {
    let [direct, bounced, shadows] = SPARSE;
    let columns = [IMAGES, direct, bounced, shadows];
    let titles: String = columns.each_ref().map(|column| format!(" {} |", column.title)).concat();
    let mut table = format!("| change |{titles}\n|---|---|---|---|---|\n");
    let baked = columns.map(|column| Baked::new(&column));
    for (change, from, to) in CHANGES {
        let cells = baked.each_ref().map(|baked| format!(" {} |", baked.after(from, to)));
        let _ = writeln!(table, "| {change} |{}", cells.concat());
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/notes/REUSE.md");
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.contains(&table), "docs/notes/REUSE.md must have this table:\n{table}");
}
