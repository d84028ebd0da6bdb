//! sparse-transfer from bake to radiance: closed forms, the path tracer, files that repeat.

use crate::support::relit::{BALL, Baked, bake, wanted};
use crate::support::waiting::wait_for;
use crate::support::{command, expect_exit, mean_radiance, relative_l2, run, scene, write_scene};
use glam::Vec3A;
use relume_bake::methods::sparse_transfer::{Settings, SparseTransferMethod, Terms};
use relume_formats::container::Stored;
use relume_formats::kinds::{Manifest, SparseTransfer, StoredScene};
use relume_scenes::Scene;
use std::path::Path;

/// A ball that lies wholly above the horizon of a point hides sin²α · cos θ of the light that would reach it
/// evenly from the upper half: the form factor of a sphere.
#[test]
fn a_ball_hides_its_form_factor() {
    let scene = scene(BALL);
    for (rays, bound) in [(1, 4e-3), (16, 1.2e-3)] {
        let baked = bake(&scene, wanted(rays, 1024));
        let shown = baked.under(&baked.maps[0].map, 0.0);
        let mut worst = 0.0_f64;
        for vertex in baked.plane() {
            let [x, _, z] = baked.stored.positions[vertex].map(f64::from);
            let squared = x * x + z * z + 1.0;
            let hidden = 0.16 / squared / squared.sqrt();
            worst = worst.max((f64::from(shown[vertex][1]) - (1.0 - hidden)).abs());
        }
        // At the edge of the ball's disc, of 2π·23° in texels of 1.4°, each texel is off by half of itself
        // with one ray and by an eighth with 4 × 4: as random numbers that is 70 texels of 1.9e-4, 8e-4 and
        // 2e-4, three times as much at worst; flat triangles take 6e-4 off the ball.
        assert!(worst < bound, "{rays} rays: {worst}");
    }
}

/// Vertices against the path tracer, which knows nothing of cubes or bases.
#[test]
fn vertices_show_what_the_path_tracer_sees() {
    for reflections in 1..=3 {
        let mut scene = scene(&format!("{BALL} file = 'lamps'\n rotation_deg = 25.0\n"));
        scene.reflections = reflections;
        let baked = bake(&scene, wanted(16, 1024));
        assert_eq!(baked.transfer.meta.rgb, reflections > 1);
        let shown = baked.under(&baked.maps[0].map, 25.0);
        let albedo = scene
            .materials
            .iter()
            .map(|m| (m.name.as_str(), m.brdf.diffuse_albedo()))
            .collect::<std::collections::BTreeMap<_, _>>();
        let (mut difference, mut norm) = (0.0, 0.0);
        for vertex in
            [6 * 13 + 6, 3 * 13 + 4, 2 * 13 + 10, 11 * 13 + 6, 13 * 13 + 100, 13 * 13 + 333, 13 * 13 + 500]
        {
            let [position, normal] =
                [baked.stored.positions[vertex], baked.stored.normals[vertex]].map(Vec3A::from);
            let name = if vertex < 13 * 13 { "plane" } else { "ball" };
            // From just above the vertex, at a point of its own triangles; the tracer's surface is flat
            // there, ours smooth.
            let (mean, error) = mean_radiance(&scene, reflections, 1 << 14, |_| {
                (position + normal * 1e-3 + Vec3A::new(1e-5, 0.0, 2e-5), -normal)
            });
            let ours = f64::from(shown[vertex][1] * albedo[name][1]);
            difference += (ours - mean).powi(2) - error * error;
            norm += mean * mean;
        }
        // The light of 6 × 16 × 16 that bounces are baked for blurs the lamps' shadows, the finer one of
        // direct light hardly does.
        let bound = if reflections == 1 { 0.02 } else { 0.05 };
        let error = (difference.max(0.0) / norm).sqrt();
        assert!(error < bound, "{reflections} reflections: {error}");
        if reflections > 1 {
            let direct = bake(&Scene { reflections: 1, ..scene.clone() }, wanted(16, 1024))
                .under(&baked.maps[0].map, 25.0);
            assert!(
                relative_l2(&direct, &shown) > 2.0 * bound,
                "bounces must matter here, or nothing is tested"
            );
        }
    }
}

/// More terms leave less error, the file says how much, and asking for an error gives the terms for it.
#[test]
fn terms_are_chosen_by_error_and_errors_are_true() {
    let scene = scene(&format!("{BALL} file = 'clear-sky'\n others = ['lamps']\n"));
    let error = |baked: &Baked, name: &str| baked.manifest.methods[0].errors[name];
    let worst = |terms| error(&bake(&scene, wanted(4, terms)), "relative_l2_worst");
    let errors = [16, 64, 256, 1024].map(worst);
    assert!(errors.windows(2).all(|w| w[1] < w[0]), "{errors:?}");

    let asked = SparseTransferMethod { settings: Settings { rays_per_texel: 4, terms: Terms::Error(0.08) } };
    let baked = bake(&scene, asked);
    let terms = baked.transfer.meta.terms();
    let found = error(&baked, "relative_l2_worst");
    assert!(found <= 0.08 && worst(terms * 4 / 5) > 0.08 / 1.06, "{terms} terms give {found}");
    assert!(found / error(&baked, "relative_l2_worst_before_rounding") < 1.1);

    // The stored error, measured afresh under the two maps unturned: the first held-out lights.
    let whole = bake(&scene, wanted(4, 1024));
    for map in &baked.maps {
        let difference = baked.error_under(&whole, &map.map);
        assert!(difference < 1.2 * found, "{}: {difference} where {found} is claimed", map.name);
    }
}

#[test]
fn any_prefix_of_blocks_is_a_coarser_bake() {
    let scene = scene(&format!("{BALL} file = 'lamps'\n"));
    let baked = bake(&scene, wanted(1, 200));
    let whole = baked.under(&baked.maps[0].map, 0.0);
    let mut last = f64::INFINITY;
    for blocks in [1, 3, 5, 9, baked.transfer.blocks.len()] {
        let mut prefix = baked.transfer.clone();
        prefix.blocks.truncate(blocks);
        prefix.meta.blocks.truncate(blocks);
        let coarser = Baked {
            transfer: prefix,
            stored: baked.stored.clone(),
            maps: Vec::new(),
            manifest: baked.manifest.clone(),
        };
        let error = relative_l2(&coarser.under(&baked.maps[0].map, 0.0), &whole);
        assert!(error < last || error == 0.0, "{blocks} blocks: {error} after {last}");
        last = error;
    }
    assert_eq!(last, 0.0);
}

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap());
    let file = |e: std::fs::DirEntry| {
        (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap_or_default())
    };
    let mut files: Vec<_> = entries.filter(|e| e.file_name() != "report.json").map(file).collect();
    files.sort();
    files
}

#[test]
fn bytes_repeat_at_any_thread_count_and_after_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_scene(
        folder.path(),
        &format!("{BALL} file = 'clear-sky'\n").replace("reflections = 1", "reflections = 2"),
    );
    let scene = path.to_str().unwrap();
    let bundle = |name: &str| folder.path().join(name);
    let arguments = |name: &str, more: &[&str]| -> Vec<String> {
        let bundle = bundle(name);
        let all = [
            &[
                "run",
                scene,
                "-o",
                bundle.to_str().unwrap(),
                "--terms",
                "40",
                "--spp",
                "16",
                "--progress",
                "none",
            ],
            more,
        ]
        .concat();
        all.into_iter().map(str::to_owned).collect()
    };
    let bake = |name: &str, more: &[&str]| {
        let arguments = arguments(name, more);
        expect_exit("bake", &arguments.iter().map(String::as_str).collect::<Vec<_>>(), 0)
    };
    bake("one", &["--threads", "1"]);
    bake("two", &["--threads", "2"]);
    let expected = contents(&bundle("one"));
    assert_eq!(contents(&bundle("two")), expected);

    // On one thread, which is far from done when the first piece is.
    let mut child = command("bake").args(arguments("killed", &["--threads", "1"])).spawn().unwrap();
    let log = bundle("killed").join("unfinished/sparse-transfer.log");
    wait_for(&mut child, "rows in the log", || std::fs::metadata(&log).ok().filter(|file| file.len() > 16));
    child.kill().unwrap();
    child.wait().unwrap();
    // Another method leaves the unfinished work of this one alone.
    let other = arguments("killed", &["--method", "transfer-images"]);
    let other: Vec<&str> =
        other.iter().map(String::as_str).filter(|a| !["--terms", "40"].contains(a)).collect();
    std::fs::write(
        &path,
        std::fs::read_to_string(&path).unwrap().replace("view = true", "view = true\n materials = ['ball']"),
    )
    .unwrap();
    expect_exit("bake", &other, 0);
    assert!(log.exists());
    std::fs::write(&path, std::fs::read_to_string(&path).unwrap().replace("\n materials = ['ball']", ""))
        .unwrap();
    let refused = arguments("killed", &[]);
    let stderr = expect_exit("bake", &refused.iter().map(String::as_str).collect::<Vec<_>>(), 2);
    assert!(stderr.contains("--resume") && stderr.contains("--force"), "{stderr}");
    bake("killed", &["--resume"]);
    assert_eq!(contents(&bundle("killed")), expected);
    let output = run("bake", &["verify", bundle("killed").to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn two_methods_share_a_bundle_in_the_order_given() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{BALL} file = 'lamps'\n")
        .replace("view = true", "view = true\n materials = ['ball']")
        .replace("segments = 12", "segments = 3");
    let path = write_scene(folder.path(), &text);
    let bundle = folder.path().join("bundle");
    let run = |methods: &[&str], code: i32| {
        let mut arguments = vec![
            "run",
            path.to_str().unwrap(),
            "-o",
            bundle.to_str().unwrap(),
            "--spp",
            "4",
            "--progress",
            "none",
        ];
        methods.iter().for_each(|method| arguments.extend(["--method", method]));
        expect_exit("bake", &arguments, code)
    };
    let stderr = run(&["transfer-images", "sparse-transfer"], 0);
    assert!(
        stderr.contains("keeps the light as the scene has it")
            && stderr.contains("keeps materials as the scene has them"),
        "{stderr}"
    );
    let names = || Manifest::read(&bundle).unwrap().methods.into_iter().map(|m| m.name).collect::<Vec<_>>();
    assert_eq!(names(), ["transfer-images", "sparse-transfer"]);
    let before = contents(&bundle);
    run(&["sparse-transfer", "transfer-images"], 0);
    assert_eq!(names(), ["sparse-transfer", "transfer-images"]);
    let files = |all: Vec<(String, Vec<u8>)>| {
        all.into_iter().filter(|(name, _)| name.ends_with(".relume")).collect::<Vec<_>>()
    };
    assert_eq!(files(contents(&bundle)), files(before), "both were finished, so nothing is baked again");
    let output = crate::support::run("bake", &["verify", bundle.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let stderr = run(&["sparse-transfer", "sparse-transfer"], 2);
    assert!(stderr.contains("given twice"), "{stderr}");
}

#[test]
fn scenes_that_do_not_fit_get_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let lamp = "\n[[light]]\n name = 'bulb'\n kind = 'point'\n intensity = [1.0, 1.0, 1.0]\n";
    let cases = [
        (format!("{BALL} {lamp}"), vec![], "light `bulb`: sparse-transfer lights by the environment alone"),
        (BALL.replace("[environment]", ""), vec![], "has no [environment]"),
        (BALL.replace("reflections = 1", "reflections = 4"), vec![], "models at most 3"),
        (
            BALL.replace("view = true", "shape = true"),
            vec!["--method", "sparse-transfer"],
            "keeps shapes fixed",
        ),
        (format!("{BALL} file = 'lampss'\n"), vec![], "did you mean `lamps`"),
        (
            format!("{BALL} file = 'lamps'\n others = ['clear-sky', 'lamps']\n"),
            vec![],
            "two environment maps are called `lamps`",
        ),
        (format!("{BALL} gain = [-1.0, 1.0, 1.0]\n"), vec![], "gain"),
        (BALL.to_owned(), vec!["--bases", "5"], "--bases"),
        (BALL.to_owned(), vec!["--terms", "1025"], "1..=1024"),
        (BALL.to_owned(), vec!["--method", "sparse"], "sparse-transfer"),
        (BALL.to_owned(), vec!["--method", "transfer-images"], "names no materials"),
    ];
    for (text, more, expected) in cases {
        let path = write_scene(folder.path(), &text);
        let bundle = folder.path().join("bundle");
        let stderr = expect_exit(
            "bake",
            &[&["run", path.to_str().unwrap(), "-o", bundle.to_str().unwrap()], &more[..]].concat(),
            2,
        );
        assert!(
            stderr.contains(expected) && stderr.lines().filter(|l| l.starts_with("error")).count() == 1,
            "{stderr} for {expected}"
        );
        assert!(!bundle.join("manifest.json").exists());
    }
}

#[test]
fn exports_and_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_scene(
        folder.path(),
        &format!("{BALL} file = 'lamps'\n").replace("segments = 12", "segments = 3"),
    );
    let text = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let bundle = text("bundle");
    expect_exit(
        "bake",
        &[
            "run",
            path.to_str().unwrap(),
            "-o",
            &bundle,
            "--terms",
            "24",
            "--quality",
            "draft",
            "--progress",
            "none",
        ],
        0,
    );
    let (rows, stored) = (
        SparseTransfer::read_file(Path::new(&text("bundle/sparse-transfer.relume"))).unwrap(),
        StoredScene::read_file(Path::new(&text("bundle/scene.relume"))).unwrap(),
    );

    expect_exit("bake", &["export", &bundle, "-o", &text("out")], 0);
    let vertices = stored.positions.len();
    let array = |name: &str, shape: String| {
        let bytes = std::fs::read(text(&format!("out/sparse-transfer/{name}"))).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let described = String::from_utf8_lossy(&bytes[..header]).into_owned();
        assert!(described.contains(&format!("'shape': ({shape}, ")), "{name}: {described}");
        bytes[header..].to_vec()
    };
    let index = array("index.npy", format!("24, {vertices}"));
    let value = array("value.npy", format!("24, {vertices}"));
    array("positions.npy", format!("{vertices}, 3"));
    array("normals.npy", format!("{vertices}, 3"));
    // The third block of 8 columns begins with column 8: its second column is the ninth.
    for vertex in [0, vertices / 2, vertices - 1] {
        let at = 9 * vertices + vertex;
        assert_eq!(
            u16::from_le_bytes([index[2 * at], index[2 * at + 1]]),
            rows.blocks[2].indices[vertices + vertex]
        );
        let exported = f32::from_le_bytes(value[4 * at..4 * at + 4].try_into().unwrap());
        assert_eq!(exported, rows.blocks[2].value(&rows.meta, 1, vertex)[0]);
    }
    let info = run("bake", &["info", &bundle, "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    let of_rows = info["files"].as_array().unwrap().iter().find(|f| f["kind"] == "sparse-transfer").unwrap();
    assert_eq!(
        (of_rows["details"]["terms"].as_u64(), of_rows["details"]["rows"].as_u64()),
        (Some(24), Some(vertices as u64))
    );

    let sound = Manifest::read(Path::new(&bundle)).unwrap();
    let verdict = |change: &dyn Fn(&mut Manifest)| {
        let mut broken = sound.clone();
        change(&mut broken);
        // As other programs could write it.
        std::fs::write(Path::new(&bundle).join("manifest.json"), serde_json::to_string(&broken).unwrap())
            .unwrap();
        expect_exit("bake", &["verify", &bundle], 2)
    };
    let no_map = verdict(&|m| drop(m.methods[0].files.remove(0)));
    assert!(no_map.contains("its files are not one or more environment, perhaps textures"), "{no_map}");
    let twice = verdict(&|m| m.methods[0].files.insert(0, sound.methods[0].files[0].clone()));
    assert!(twice.contains(&format!("`{}` is listed twice", sound.methods[0].files[0].1.file)), "{twice}");
    let other = verdict(&|m| m.methods[0].name = "photon-volume".to_owned());
    assert!(other.contains("unknown to this program"), "{other}");
}
