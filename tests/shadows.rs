//! sphere-shadows from bake to radiance: closed forms, the path tracer, poses, files that repeat, and what is
//! refused.

use crate::support::{expect_exit, mean_radiance, run, scene, write_scene};
use glam::Vec3A;
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::evaluate::sparse_transfer::light as coefficients_of;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::evaluate::sphere_shadows::{
    CasterMeshes, Casters, Levels, Spheres, light, lobe, radiance, receivers,
};
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::kinds::sphere_shadows::Casts;
use relume_formats::kinds::{Environment, HaarTable, Manifest, SphereSet, SphereShadows, StoredScene};
use relume_formats::shape::{DeformingMesh, Rims, ShadingNormals};
use relume_formats::state::{Posed, ShapeState, State};
use relume_scenes::Scene;
use std::path::Path;

/// A ball 1 m above the middle of a plane, which one sphere covers.
pub const BALL: &str = "
    [vary]
    light = true
    view = true
    shape = true
    [render]
    size = [32, 24]
    reflections = 1
    [camera]
    position = [0.0, 2.0, 5.0]
    target = [0.0, 0.5, 0.0]
    fov_deg = 40.0
    [materials.white]
    brdf = 'blinn-phong'
    kd = [1.0, 1.0, 1.0]
    [[object]]
    name = 'plane'
    shape = 'quad'
    segments = 12
    material = 'white'
    transform = { scale = 4.0 }
    [[object]]
    name = 'blocker'
    shape = 'sphere'
    subdivisions = 3
    material = 'white'
    spheres = 1
    transform = { translation = [0.0, 1.0, 0.0], scale = 0.4 }
    [environment]
";
/// Vertices along a side of the plane.
pub const SIDE: usize = 13;

/// The same with a small knot that twists.
pub fn knot() -> String {
    let ball = "shape = 'sphere'\n    subdivisions = 3";
    assert!(BALL.contains(ball));
    BALL.replace(ball, "shape = 'torus-knot'\n    segments = 48\n    sides = 6\n    tube = 0.2\n    twist_deg = 160.0\n    twist_s = 2.0")
        .replace("spheres = 1", "spheres = 12")
}

/// What a bundle holds.
pub struct Bundle {
    folder: tempfile::TempDir,
    pub manifest: Manifest,
    pub stored: StoredScene,
    pub shadows: SphereShadows,
    pub set: SphereSet,
    map: Environment,
}

impl Bundle {
    /// Bakes the scene in `text`.
    pub fn bake(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = write_scene(folder.path(), text);
        let out = folder.path().join("bundle");
        expect_exit(
            "bake",
            &["run", path.to_str().unwrap(), "-o", out.to_str().unwrap(), "--progress", "none"],
            0,
        );
        let file = |name: &str| out.join(name);
        Self {
            manifest: Manifest::read(&out).unwrap(),
            stored: StoredScene::read_file(&file("scene.relume")).unwrap(),
            shadows: SphereShadows::read_file(&file("sphere-shadows.relume")).unwrap(),
            set: SphereSet::read_file(&file("spheres-blocker.relume")).unwrap(),
            map: Environment::read_file(&file("environment-0.relume")).unwrap(),
            folder,
        }
    }

    fn file(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join("bundle").join(name)
    }

    /// Radiance with all terms at all vertices, at rest or in a pose, with shadows of the blocker's spheres alone.
    pub fn radiance(&self, rotation_deg: f32, pose: Option<&Posed>) -> Vec<[f32; 3]> {
        let mut by_spheres = self.shadows.clone();
        by_spheres.meta.objects.iter_mut().for_each(|object| {
            object.casts = if object.sphere_set { Casts::Spheres } else { Casts::Nothing };
        });
        self.posed(&by_spheres, rotation_deg, pose)
    }

    /// The same with the shadows that the bake has chosen.
    pub fn shown(&self, rotation_deg: f32, pose: Option<&Posed>) -> Vec<[f32; 3]> {
        self.posed(&self.shadows, rotation_deg, pose)
    }

    fn posed(&self, shadows: &SphereShadows, rotation_deg: f32, pose: Option<&Posed>) -> Vec<[f32; 3]> {
        let (mut positions, mut normals) = (self.stored.positions.clone(), self.stored.normals.clone());
        let mut spheres = Spheres::at_rest(&self.set);
        if let Some(pose) = pose {
            let shape = DeformingMesh::read_file(&self.file("shape-blocker.relume")).unwrap();
            let own = &self.shadows.meta.objects[1];
            let range = own.first_vertex as usize..(own.first_vertex + own.vertices) as usize;
            let triangles: Vec<[u32; 3]> =
                self.stored.triangles.iter().map(|t| t.map(|v| v.wrapping_sub(own.first_vertex))).collect();
            let resting = ShadingNormals::new(&positions[range.clone()], &normals[range.clone()], &triangles);
            let (mut moved, mut turned) = (Vec::new(), Vec::new());
            shape.positions(&shape.pose_of(Some(pose)), &mut moved);
            resting.at(&moved, &mut turned);
            Follower::new(&self.set).follow(&moved, &mut spheres.now).unwrap();
            positions.splice(range.clone(), moved);
            normals.splice(range, turned);
        }
        let by_spheres = shadows.meta.objects.iter().any(|object| object.casts == Casts::Spheres);
        let mut casters =
            Casters { spheres: by_spheres.then_some(spheres).into_iter().collect(), triangles: Vec::new() };
        let meshes = CasterMeshes::new(shadows, &self.stored.positions);
        meshes.place(&positions, &normals, &mut casters.triangles);
        self.shaded(shadows, (&positions, &normals), rotation_deg, &casters)
    }

    /// The same at rest without anything that casts.
    pub fn open_radiance(&self, rotation_deg: f32) -> Vec<[f32; 3]> {
        let places = (&self.stored.positions[..], &self.stored.normals[..]);
        self.shaded(&self.shadows, places, rotation_deg, &Casters::default())
    }

    fn shaded(
        &self,
        shadows: &SphereShadows,
        (positions, normals): (&[[f32; 3]], &[[f32; 3]]),
        rotation_deg: f32,
        casters: &Casters,
    ) -> Vec<[f32; 3]> {
        let places = Rims::new(positions.len(), &self.stored.triangles).received(positions);
        let receivers = receivers(shadows, std::slice::from_ref(&self.set), &places, normals);
        let lobes: Vec<_> =
            (0..self.shadows.normals.len()).map(|row| lobe(self.shadows.lobe(row).to_vec(), None)).collect();
        let look = EnvironmentLook { map: String::new(), gain: [1.0; 3], rotation_deg };
        let light = light(coefficients_of(&self.map.map, &look, 32), None);
        radiance(&receivers, casters, &lobes, &light, Levels::All, &HaarTable::bake())
    }
}

/// A sphere that lies wholly above the horizon of a point hides sin²α · cos θ of an even sky.
#[test]
fn a_ball_hides_its_form_factor() {
    let bundle = Bundle::bake(BALL);
    let [x, y, z, radius] = bundle.set.spheres[0].map(f64::from);
    assert!(
        (radius - 0.4).abs() < 0.004 && (y - 1.0).abs() < 0.004,
        "one sphere is the ball: {:?}",
        bundle.set.spheres
    );
    let mut off = 0.0;
    for (position, shown) in bundle.stored.positions.iter().zip(bundle.radiance(0.0, None)).take(SIDE * SIDE)
    {
        let [px, py, pz] = position.map(f64::from);
        let squared = (x - px).powi(2) + (y - py).powi(2) + (z - pz).powi(2);
        let error = f64::from(shown[0]) - (1.0 - radius * radius / squared * (y - py) / squared.sqrt());
        // Each texel at the rim, 2π·sin α of the sky long, is wrong by up to half of itself, 1/16 wide, with
        // either sign; near the ball at most a fifth of that remains.
        let rim = 2.0 * radius / squared.sqrt() / 16.0;
        assert!(error.abs() < 0.2 * rim, "{position:?}: {error}, rim {rim}");
        off += error;
    }
    assert!((off / (SIDE * SIDE) as f64).abs() < 5e-4, "rims cancel: {off}");
    // What the manifest says is what the path tracer finds. The sky is even, so terms and levels lose nothing.
    let [told, all_terms] = ["relative_l2_median", "relative_l2_median_all_terms"]
        .map(|name| bundle.manifest.methods[0].errors[name]);
    let some: Vec<usize> = (0..bundle.stored.positions.len()).step_by(7).collect();
    let found = against_tracer(&scene(BALL), &bundle.shown(0.0, None), &some);
    // Of texels, which are seen whole or not at all, the manifest says nothing.
    assert!(
        told < 0.01 && (told - found).abs() < 0.005 && (told - all_terms).abs() < 1e-3,
        "{told} {all_terms}, found {found}"
    );
}

/// What the path tracer sees of a white vertex, with its standard error.
pub fn true_radiance(scene: &Scene, vertex: usize) -> (f64, f64) {
    let place = |of: fn(&relume_scenes::Mesh) -> &Vec<[f32; 3]>| {
        Vec3A::from(*scene.objects.iter().flat_map(|object| of(&object.mesh)).nth(vertex).unwrap())
    };
    let (position, normal) = (place(|mesh| &mesh.positions), place(|mesh| &mesh.normals));
    mean_radiance(scene, 1, 1 << 14, |_| (position + normal * 1e-3 + Vec3A::new(1e-5, 0.0, 2e-5), -normal))
}

/// Where the path tracer has other radiance than the bundle, relative L2 over some vertices; the tracer knows
/// nothing of cubes, bases or spheres.
pub fn against_tracer(scene: &Scene, shown: &[[f32; 3]], vertices: &[usize]) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for vertex in vertices {
        let (mean, noise) = true_radiance(scene, *vertex);
        off += (f64::from(shown[*vertex][1]) - mean).powi(2) - noise * noise;
        norm += mean * mean;
    }
    (off.max(0.0) / norm).sqrt()
}

#[test]
fn vertices_show_what_the_path_tracer_sees() {
    let text = format!("{BALL} file = 'lamps'\n rotation_deg = 25.0\n");
    let (bundle, scene) = (Bundle::bake(&text), scene(&text));
    let plane = [6 * SIDE + 6, 3 * SIDE + 4, 2 * SIDE + 10, 11 * SIDE + 6, 7 * SIDE + 5, 5 * SIDE + 6];
    let ball = [SIDE * SIDE + 100, SIDE * SIDE + 333, SIDE * SIDE + 500];
    let shown = bundle.shown(25.0, None);
    // Lamps are some texels of 2.8° wide, so an edge of a lamp's shadow is off by up to half a texel of it;
    // on the ball the normals' grid adds 2 %.
    let error = against_tracer(&scene, &shown, &plane);
    assert!(error < 0.03, "plane: {error}");
    let error = against_tracer(&scene, &shown, &ball);
    assert!(error < 0.04, "ball: {error}");
}

#[test]
fn poses_of_a_bundle_throw_the_shadows_of_the_posed_mesh() {
    let text = knot();
    let (bundle, scene) = (Bundle::bake(&text), scene(&text));
    let vertices: Vec<usize> = (0..SIDE * SIDE).step_by(17).collect();
    for time_s in [0.0, 0.5, 1.1] {
        let change = ShapeState { time_s: Some(time_s), ..ShapeState::default() };
        let state = State { shapes: [("blocker".to_owned(), change)].into(), ..State::default() };
        let posed = scene.with_state(&state, &Place::file("test")).unwrap();
        let clip = bundle.stored.meta.shapes[0].clips[0].name.clone();
        let shown = bundle.shown(0.0, Some(&Posed { clip, time_s }));
        let error = against_tracer(&posed, &shown, &vertices);
        println!("{time_s} s: {error}");
        // What was asked for, and as much again for texels.
        assert!(error < 0.02, "{time_s} s: {error}");
        assert!(vertices.iter().any(|v| shown[*v][0] < 0.93), "there is a shadow");
    }
}

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let file = |e: std::fs::DirEntry| {
        (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap_or_default())
    };
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| file(e.unwrap()))
        .filter(|(name, _)| name != "report.json")
        .collect();
    files.sort();
    files
}

#[test]
fn bundles_repeat_are_reused_and_verified() {
    let bundle = Bundle::bake(&knot());
    let method = &bundle.manifest.methods[0];
    assert_eq!(method.name, "sphere-shadows", "chosen because shapes vary");
    let kinds: Vec<&str> = method.files.iter().map(|(kind, _)| kind.as_str()).collect();
    assert_eq!(kinds, ["environment", "shape", "sphere-shadows"]);
    let text = |name: &str| bundle.folder.path().join(name).to_str().unwrap().to_owned();
    let bake = |name: &str, more: &[&str]| {
        let (scene, out) = (text("scene.toml"), text(name));
        let output = run("bake", &[&["run", &scene, "-o", &out, "--progress", "none"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    bake("one", &["--threads", "1"]);
    assert_eq!(
        contents(Path::new(&text("one"))),
        contents(Path::new(&text("bundle"))),
        "any number of threads gives the same bytes"
    );
    let again = bake("one", &[]);
    assert!(
        again.contains("spheres up to date, reused") && again.contains("sphere-shadows up to date, reused"),
        "{again}"
    );
    let scene = std::fs::read_to_string(text("scene.toml")).unwrap();
    std::fs::write(text("scene.toml"), scene.replace("spheres = 12", "spheres = 13")).unwrap();
    assert!(bake("one", &[]).contains("sphere-shadows baked"), "errors are those of the spheres");
    std::fs::write(text("scene.toml"), scene.replace("'plane'", "'floor'")).unwrap();
    assert!(bake("one", &[]).contains("sphere-shadows baked"), "the file holds names");
    expect_exit("bake", &["verify", &text("one")], 0);

    let out = text("bundle");
    expect_exit("bake", &["verify", &out], 0);
    expect_exit("bake", &["export", &out, "-o", &text("exported")], 0);
    for file in ["sphere-shadows/lobes.npy", "shape-blocker/shape.json", "spheres-blocker/spheres.npy"] {
        assert!(Path::new(&text("exported")).join(file).exists(), "{file}");
    }
    let verdict = |change: &dyn Fn(&mut Manifest)| {
        let mut broken = bundle.manifest.clone();
        change(&mut broken);
        broken.write(Path::new(&out)).unwrap();
        expect_exit("bake", &["verify", &out], 2)
    };
    let files = "its files are not one or more environment, perhaps textures, any number of shape, sphere-shadows, in this order";
    for (missing, message) in [(0, files), (1, "needs the shape of object `blocker` before it"), (2, files)] {
        let stderr = verdict(&|m| drop(m.methods[0].files.remove(missing)));
        assert!(stderr.contains(message), "{stderr}");
    }
    let stderr = verdict(&|m| m.methods[0].files.swap(0, 1));
    assert!(stderr.contains("in this order"), "{stderr}");
    let stderr = verdict(&|m| m.sphere_sets.clear());
    assert!(
        stderr.contains("object `blocker` has a sphere set here or in the manifest, but not in both"),
        "{stderr}"
    );

    let rewritten = |file: &str, bytes: Vec<u8>| {
        let entry = relume_formats::kinds::manifest::FileEntry::of(file, &bytes);
        verdict(&|m| {
            m.methods[0]
                .files
                .iter_mut()
                .filter(|(_, e)| e.file == file)
                .for_each(|(_, e)| *e = entry.clone())
        })
    };
    let path = bundle.file("shape-blocker.relume");
    let shape = DeformingMesh::read_file(&path).unwrap();
    let mut moved = shape.clone();
    moved.positions[5][1] += 0.01;
    let stderr = rewritten("shape-blocker.relume", moved.write_file(&path).unwrap());
    shape.write_file(&path).unwrap();
    assert!(stderr.contains("vertex 5 does not rest where object `blocker` has it"), "{stderr}");
    let mut shadows = bundle.shadows.clone();
    shadows.meta.objects[0].name = "flat".to_owned();
    let stderr = rewritten(
        "sphere-shadows.relume",
        shadows.write_file(&bundle.file("sphere-shadows.relume")).unwrap(),
    );
    assert!(stderr.contains("its objects are not those of the scene"), "{stderr}");
}

#[test]
fn scenes_that_do_not_fit_get_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let lamp = "\n[[light]]\n name = 'bulb'\n kind = 'point'\n intensity = [1.0, 1.0, 1.0]\n";
    let cases = [
        (format!("{BALL} {lamp}"), "light `bulb`: sphere-shadows lights by the environment alone"),
        (BALL.replace("[environment]", ""), "has no [environment]"),
        (BALL.replace("reflections = 1", "reflections = 2"), "models direct light only; set it to 1"),
    ];
    for (text, expected) in cases {
        let path = write_scene(folder.path(), &text);
        let out = folder.path().join("bundle");
        let stderr = expect_exit("bake", &["run", path.to_str().unwrap(), "-o", out.to_str().unwrap()], 2);
        assert!(stderr.contains(expected), "{stderr} for {expected}");
        assert!(!out.join("manifest.json").exists());
    }
}
