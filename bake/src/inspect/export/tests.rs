//! Exported files read back by small parsers of their own, and put together again to what the bundle means.

mod shadows;
mod shapes;
mod spheres;

use super::super::test_bundle::TestBundle;
use super::*;
use crate::exr_file::read_exr;
use relume_formats::basis::brdf_grid::{NODES, cos_half_angle};
use relume_formats::container::Stored;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::{HaarTable, VisibilityTable};
use relume_formats::state::{BlinnPhong, Brdf};
use relume_scenes::{
    Emitter, Environment, EquirectMap, Light, Material, Mesh, NamedMap, Object, Scene, Vary,
};
use serde_json::Value;
use std::sync::Arc;

/// Shape, NumPy type and payload of a version 1.0 file in row-major order (NEP 1).
struct Npy {
    shape: Vec<usize>,
    descr: String,
    payload: Vec<u8>,
}

impl Npy {
    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let header_length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + header_length) % 64, 0, "the payload is aligned");
        let header = std::str::from_utf8(&bytes[10..10 + header_length]).unwrap();
        let after = |key: &str| header.split_once(&format!("'{key}':")).unwrap().1.trim_start();
        assert!(after("fortran_order").starts_with("False"));
        let list = after("shape").strip_prefix('(').unwrap().split_once(')').unwrap().0;
        let shape =
            list.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.parse().unwrap()).collect();
        let descr = after("descr").split('\'').nth(1).unwrap().to_owned();
        Self { shape, descr, payload: bytes[10 + header_length..].to_vec() }
    }

    fn f32s(path: &Path) -> (Vec<usize>, Vec<f32>) {
        let npy = Self::read(path);
        assert_eq!(npy.descr, "<f4");
        let values: Vec<f32> = npy.payload.as_chunks().0.iter().map(|c| f32::from_le_bytes(*c)).collect();
        assert_eq!(values.len() * 4, npy.payload.len());
        assert_eq!(values.len(), npy.shape.iter().product::<usize>());
        (npy.shape, values)
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn names(files: &[PathBuf], folder: &Path) -> Vec<String> {
    files.iter().map(|f| f.strip_prefix(folder).unwrap().display().to_string()).collect()
}

/// The bundle, the folder it stands in, and where it was exported to.
fn exported() -> (TestBundle, tempfile::TempDir, PathBuf, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let (bundle, out) = (TestBundle::new(), folder.path().join("out"));
    bundle.write(folder.path());
    let files = export_file(folder.path(), &out).unwrap();
    (bundle, folder, out, files)
}

#[test]
fn every_file_is_listed_once_and_none_else_is_left() {
    let (_, folder, out, files) = exported();
    let listed: BTreeSet<_> = names(&files, &out).into_iter().collect();
    assert_eq!(listed.len(), files.len());
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(&out).unwrap().map(|e| e.unwrap()) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            found.extend(
                std::fs::read_dir(entry.path())
                    .unwrap()
                    .map(|f| format!("{name}/{}", f.unwrap().file_name().display())),
            );
        } else {
            found.insert(name);
        }
    }
    assert_eq!(found, listed);
    for name in [
        "bundle.json",
        "scene/mesh.ply",
        "scene/camera.json",
        "brdf-basis/basis.npy",
        "transfer-images/transfer_editable.npy",
    ] {
        assert!(listed.contains(name), "{name}");
    }
    assert!(listed.contains("animation-glow/animation_glow.json"));
    // A second export replaces the first.
    assert_eq!(export_file(folder.path(), &out).unwrap(), files);
}

#[test]
fn the_basis_stands_on_the_grid_and_its_samples_come_first_diffuse_then_glossy() {
    let (bundle, _folder, out, _) = exported();
    let out = out.join("brdf-basis");
    let (shape, grid) = Npy::f32s(&out.join("basis.npy"));
    assert_eq!(shape, [3, 30, 30, 60]);
    for (i, o, p) in [(0, 0, 0), (1, 2, 3), (29, 29, 59), (17, 4, 58)] {
        let at = (i * 30 + o) * 60 + p;
        // The test's lobes are x and x² of the chord, whose square is 1 − cos δ. Between two of the 4097
        // nodes x² errs by 1/(4·4096²).
        let chord = (1.0 - cos_half_angle(i, o, p)).sqrt();
        for (basis, expected) in [std::f64::consts::FRAC_1_PI, chord, chord * chord].into_iter().enumerate() {
            let value = f64::from(grid[basis * NODES + at]);
            // The cosine is rounded to f32 first: 6e-8 near 1 are 2.5e-4 of the chord.
            assert!(
                (value - expected).abs() < 3e-4,
                "basis {basis} at {i} {o} {p}: {value} is not {expected}"
            );
        }
    }
    let (shape, parameters) = Npy::f32s(&out.join("parameters.npy"));
    // Exponent 50.5 is no sample, but it is a node of the look-up.
    assert_eq!((shape, parameters), (vec![3, 3], vec![1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 200.0]));
    let (shape, coefficients) = Npy::f32s(&out.join("coefficients.npy"));
    let stored = &bundle.basis.coefficients;
    assert_eq!(
        (shape, coefficients),
        (vec![3, 3], [&[1.0, 0.0, 0.0][..], &stored[..3], &stored[6..]].concat())
    );
    assert_eq!(Npy::f32s(&out.join("exponents.npy")), (vec![3], vec![1.0, 50.5, 200.0]));
    assert_eq!(Npy::f32s(&out.join("exponent_coefficients.npy")), (vec![3, 3], stored.clone()));
    let metadata = json(&out.join("brdf.json"));
    assert_eq!(metadata["axes"][2]["values"].as_array().unwrap().len(), 60);
    assert_eq!(
        (&metadata["shared_diffuse"], &metadata["errors"]["between_them"]["mean"]),
        (&Value::from(true), &Value::from(0.0015))
    );
}

/// Follows `transfer-images.json` and nothing else from the arrays to an image, as somebody with NumPy would.
fn recombine(out: &Path, on_bases: &[Vec<[f32; 3]>]) -> Vec<[f32; 3]> {
    let metadata = json(&out.join("transfer-images.json"));
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let pixel: Vec<u32> = Npy::read(&out.join("fragments_pixel.npy"))
        .payload
        .as_chunks()
        .0
        .iter()
        .map(|c| u32::from_le_bytes(*c))
        .collect();
    let class: Vec<u16> = Npy::read(&out.join("fragments_class.npy"))
        .payload
        .as_chunks()
        .0
        .iter()
        .map(|c| u16::from_le_bytes(*c))
        .collect();
    let editable = number(&metadata["fragments"]["editable"]);
    let names: Vec<&str> =
        metadata["materials"].as_array().unwrap().iter().map(|m| m.as_str().unwrap()).collect();
    let mut film = vec![[0.0; 3]; number(&metadata["size"][0]) * number(&metadata["size"][1])];
    for path in metadata["paths"].as_array().unwrap() {
        let (shape, values) = Npy::f32s(&out.join(path["array"].as_str().unwrap()));
        let start = if path["surface"] == "editable" { 0 } else { editable };
        let grey = path["channels"].as_array().unwrap().len() == 1;
        for column in 0..shape[1] {
            for channel in 0..3 {
                let row = number(&path["first_row"]) + if grey { 0 } else { channel };
                let mut value = values[row * shape[1] + column];
                if let Some(basis) = path["eye_basis"].as_u64() {
                    value *= on_bases[usize::from(class[start + column])][basis as usize][channel];
                }
                if path["first"]["on"] == "editable" {
                    let material = names.iter().position(|n| path["first"]["material"] == **n).unwrap();
                    value *= on_bases[material][number(&path["first"]["basis"])][channel];
                }
                if grey {
                    value *= metadata["chromaticity"][channel].as_f64().unwrap() as f32;
                }
                film[pixel[start + column] as usize][channel] += value;
            }
        }
    }
    film
}

#[test]
fn arrays_and_metadata_are_enough_to_make_the_image() {
    let (bundle, _folder, out, _) = exported();
    let materials = [
        Brdf::BlinnPhong(BlinnPhong { kd: [0.1, 0.5, 0.9], ks: [0.2, 0.3, 0.1], shininess: 25.5 }),
        Brdf::BlinnPhong(BlinnPhong { kd: [0.0, 0.7, 0.2], ks: [0.9, 0.1, 0.3], shininess: 125.0 }),
    ];
    let on_bases: Vec<_> = materials.iter().map(|m| bundle.basis.coefficients_of(m).unwrap()).collect();
    let expected = evaluate(&bundle.images, &on_bases);
    let film = recombine(&out.join("transfer-images"), &on_bases);
    assert_eq!(film.len(), expected.len());
    for (a, b) in film.iter().flatten().zip(expected.iter().flatten()) {
        // Sums of fewer than 100 terms, each below 1e4.
        assert!((a - b).abs() < 1e-2 && b.abs() > 1.0, "{a} is not {b}");
    }
}

#[test]
fn pictures_are_the_fragments_summed_into_pixels() {
    let (bundle, _folder, out, files) = exported();
    let out = out.join("transfer-images");
    let head = &bundle.images.head;
    let metadata = json(&out.join("transfer-images.json"));
    let paths = metadata["paths"].as_array().unwrap();
    // 3 bases × (direct, fixed, 2 materials × 3 bases) for editable fragments, and one of each first
    // reflection for fixed ones.
    assert_eq!(paths.len(), 3 * 8 + 8);
    assert_eq!(files.iter().filter(|f| f.extension().is_some_and(|e| e == "exr")).count(), paths.len());
    for path in paths {
        let slot = path["slot"].as_u64().unwrap() as usize;
        let image = bundle.images.images.iter().find(|i| i.slot == slot).unwrap();
        let planes = read_exr(&out.join(path["file"].as_str().unwrap())).unwrap();
        assert_eq!((planes.width, planes.height), (3, 2));
        let channels = path["channels"].as_array().unwrap();
        let fragments = image.values.len() / channels.len();
        let fixed = path["surface"] == "fixed";
        for (channel, name) in channels.iter().enumerate() {
            let mut expected = [0.0; 6];
            for fragment in (0..fragments).filter(|f| (*f >= 4) == fixed) {
                expected[head.pixel[fragment] as usize] +=
                    image.values[channel * fragments + fragment].to_f32() * head.scales[slot];
            }
            assert_eq!(planes.channel(name.as_str().unwrap()).unwrap(), expected, "{path}");
        }
    }
    let listed: Vec<_> = paths.iter().map(|p| p["file"].as_str().unwrap()).collect();
    for name in [
        "image_0000_eye-b0_direct.exr",
        "image_0000_fixed_direct.exr",
        "image_0001_fixed_first-fixed.exr",
        "image_0003_eye-b0_first-___knot-b1.exr",
    ] {
        assert!(listed.contains(&name), "{name} is not in {listed:?}");
    }
}

#[test]
fn meshes_carry_normals_and_labels() {
    let (bundle, _folder, out, _) = exported();
    let file = std::fs::read(out.join("scene/mesh.ply")).unwrap();
    let end = file.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&file[..end]).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    let declared = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        element face 3\nproperty list uchar int vertex_indices\nproperty int object\nproperty int material\nend_header\n";
    assert!(header.ends_with(declared), "{header}");
    let (vertices, faces) = file[end..].split_at(4 * 24);
    let floats: Vec<f32> = vertices.as_chunks().0.iter().map(|c| f32::from_le_bytes(*c)).collect();
    for (index, row) in floats.chunks_exact(6).enumerate() {
        assert_eq!(*row, *[bundle.scene.positions[index], bundle.scene.normals[index]].as_flattened());
    }
    let faces: Vec<_> = faces
        .chunks_exact(21)
        .map(|f| (f[0], f[1..].as_chunks().0.iter().map(|c| i32::from_le_bytes(*c)).collect::<Vec<_>>()))
        .collect();
    assert_eq!(faces, [(3, vec![0, 1, 2, 0, 0]), (3, vec![1, 2, 3, 1, 1]), (3, vec![3, 0, 2, 1, 1])]);

    let materials = json(&out.join("scene/materials.json"));
    assert_eq!(
        (&materials[1]["name"], &materials[1]["varies"]),
        (&Value::from("../knot"), &Value::from(true))
    );
    assert_eq!(json(&out.join("scene/camera.json"))["fov_deg"], 40.0);
    assert_eq!(json(&out.join("scene/scene.json"))["objects"][1]["first_triangle"], 1);
    let animation = json(&out.join("animation-glow/animation_glow.json"));
    assert_eq!(animation["tracks"][0]["leaf"], serde_json::json!(["materials", "../knot", "kd"]));
    assert_eq!(
        (&animation["tracks"][1]["values"][0], &animation["loop"]),
        (&Value::from(3.5), &Value::from(true))
    );
}

#[test]
fn names_cannot_leave_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let mut bundle = TestBundle::new();
    bundle.animation.name = "../../escaped".to_owned();
    let path = folder.path().join("a.relume");
    bundle.animation.write_file(&path).unwrap();
    let out = folder.path().join("out/deep");
    assert_eq!(names(&export_file(&path, &out).unwrap(), &out), ["animation_______escaped.json"]);
}

#[test]
fn a_scene_is_exported_as_loaded() {
    let stored = TestBundle::new().scene;
    let mesh = Arc::new(Mesh {
        positions: stored.positions,
        normals: stored.normals,
        uvs: Vec::new(),
        triangles: stored.triangles,
    });
    let texels: Vec<[f32; 3]> = (0..8).map(|i| [i as f32, 0.5, 1e4 / (1 + i) as f32]).collect();
    let (edge_u, edge_v) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let area = Emitter::Area { corner: [0.0, 2.0, 0.0], edge_u, edge_v, radiance: [10.0, 9.0, 8.0] };
    let point = Emitter::Point { position: [1.0; 3], intensity: [2.5; 3], cone: None };
    let scene = Scene {
        name: "loaded".to_owned(),
        file: PathBuf::from("scene.toml"),
        size: [3, 2],
        reflections: 2,
        max_error: 0.01,
        vary: Vary { materials: vec![1], ..Vary::default() },
        camera: stored.meta.camera,
        tonemap: stored.meta.tonemap,
        materials: stored
            .meta
            .materials
            .iter()
            .map(|m| Material {
                name: m.name.clone(),
                brdf: m.brdf,
                texture: None,
                paint: None,
                alpha_cutoff: None,
            })
            .collect(),
        objects: ["ring", "ring/2"]
            .map(|name| Object {
                name: name.to_owned(),
                material: 1,
                mesh: mesh.clone(),
                shape: None,
                spheres: None,
            })
            .to_vec(),
        lights: [("lamp", area), ("bulb", point)]
            .map(|(name, emitter)| Light { name: name.to_owned(), emitter })
            .to_vec(),
        environment: Some(Environment {
            map: NamedMap {
                name: "map.exr".to_owned(),
                map: Arc::new(EquirectMap { width: 4, height: 2, texels: texels.clone() }),
            },
            others: Vec::new(),
            gain: [2.0; 3],
            rotation_deg: 30.0,
        }),
        animations: vec![TestBundle::new().animation],
        warnings: vec!["a warning".to_owned()],
    };
    let folder = tempfile::tempdir().unwrap();
    let files = export_scene(&scene, folder.path()).unwrap();
    assert_eq!(
        names(&files, folder.path()),
        [
            "object_000_ring.ply",
            "object_001_ring_2.ply",
            "environment.exr",
            "animation_glow.json",
            "scene.json"
        ]
    );

    let value = json(&folder.path().join("scene.json"));
    assert_eq!(
        (&value["vary"]["materials"][0], &value["objects"][1]["material"]),
        (&"../knot".into(), &"../knot".into())
    );
    let varies: Vec<_> =
        value["materials"].as_array().unwrap().iter().map(|m| m["varies"].as_bool().unwrap()).collect();
    assert_eq!(varies, [false, true, false]);
    assert_eq!(
        (&value["lights"][0]["kind"], &value["lights"][0]["radiance"][2]),
        (&"area".into(), &8.0.into())
    );
    assert_eq!(
        (&value["lights"][1]["kind"], &value["lights"][1]["intensity"][0]),
        (&"point".into(), &2.5.into())
    );
    assert_eq!(
        (&value["environment"]["rotation_deg"], &value["warnings"][0]),
        (&30.0.into(), &"a warning".into())
    );
    let planes = read_exr(&folder.path().join("environment.exr")).unwrap();
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        assert_eq!(
            planes.channel(name).unwrap(),
            texels.iter().map(|t| t[channel]).collect::<Vec<_>>(),
            "without gain and rotation"
        );
    }
    let ply = std::fs::read(&files[0]).unwrap();
    // The header, 4 vertices of 24 bytes, 3 triangles of 13.
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    assert_eq!(ply.len() - end, 4 * 24 + 3 * 13);
}

/// Both tables in a new folder of `folder`.
fn tables(folder: &Path, name: &str) -> [PathBuf; 2] {
    let output = folder.join(name);
    std::fs::create_dir(&output).unwrap();
    let [haar, visibility] = ["haar-table.relume", "visibility-table.relume"].map(|name| output.join(name));
    HaarTable::bake().write_file(&haar).unwrap();
    VisibilityTable::bake().write_file(&visibility).unwrap();
    [haar, visibility]
}

#[test]
fn tables_are_sound_and_always_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (tables(folder.path(), "a"), tables(folder.path(), "b"));
    let described = [
        "16 Haar coefficients of each of 65,536 bitmaps",
        "136 directions, which the symmetries of the cube make all of",
    ];
    for (table, description) in first.iter().zip(described) {
        let checked = verify(table).unwrap();
        assert!(checked.ends_with("-table, 1 section, every checksum and value checked\n"), "{checked}");
        assert!(super::super::info(table, false).unwrap().contains(description));
    }
    for (first, second) in first.iter().zip(&second) {
        assert_eq!(std::fs::read(first).unwrap(), std::fs::read(second).unwrap());
    }
}

#[test]
fn the_haar_table_comes_out_whole() {
    let folder = tempfile::tempdir().unwrap();
    let [first, _] = tables(folder.path(), "a");
    let out = folder.path().join("out");
    let files = export_file(&first, &out).unwrap();
    assert_eq!(names(&files, &out), ["table.npy", "table.json"]);
    let (shape, values) = Npy::f32s(&files[0]);
    assert_eq!(shape, [65_536, 16]);
    // Bit 0 is the upper left texel, bit 7 the right end of the second row: 1/4, its signs, and 1/2 in the
    // quarter it stands in.
    let expected = |nonzero: &[(usize, f32)]| {
        (0..16).map(|k| nonzero.iter().find(|n| n.0 == k).map_or(0.0, |n| n.1)).collect::<Vec<_>>()
    };
    assert_eq!(
        values[16..32],
        expected(&[(0, 0.25), (1, 0.25), (2, 0.25), (3, 0.25), (4, 0.5), (8, 0.5), (12, 0.5)])
    );
    assert_eq!(
        values[128 * 16..129 * 16],
        expected(&[(0, 0.25), (1, -0.25), (2, 0.25), (3, -0.25), (5, -0.5), (9, -0.5), (13, 0.5)])
    );
}

#[test]
fn the_visibility_table_comes_out_whole() {
    let folder = tempfile::tempdir().unwrap();
    let [_, table] = tables(folder.path(), "a");
    let out = folder.path().join("out");
    let files = export_file(&table, &out).unwrap();
    assert_eq!(
        names(&files, &out),
        ["visibility.npy", "directions.npy", "texels.npy", "radii.npy", "visibility.json"]
    );
    let [bitmaps, directions, texels, radii] = [0, 1, 2, 3].map(|file| Npy::read(&files[file]));
    assert_eq!(
        [&bitmaps.shape, &directions.shape, &texels.shape, &radii.shape],
        [&[136, 32, 768][..], &[136, 3], &[136], &[32]]
    );
    assert_eq!(
        [&bitmaps.descr, &directions.descr, &texels.descr, &radii.descr],
        ["|u1", "<f8", "<u4", "<f8"]
    );
    // One row by its definition: the last direction is the middle of +X, the widest cap all but a ring of the
    // half-space x > 0.
    let f64s =
        |npy: &Npy| npy.payload.as_chunks().0.iter().map(|v| f64::from_le_bytes(*v)).collect::<Vec<_>>();
    let (directions, radii) = (f64s(&directions), f64s(&radii));
    let (v, r) = (&directions[135 * 3..], radii[31]);
    assert!((r - (90.0f64 * 31.5 / 32.0).to_radians().sin()).abs() < 1e-12);
    assert!((v[1] - v[2]).abs() < 1e-12 && (v[0] - 32.0 * v[1]).abs() < 1e-12, "{v:?}");
    assert_eq!(texels.payload[135 * 4..], (15u32 * 32 + 15).to_le_bytes());
    for texel in 0..6 * 32 * 32 {
        let centre = relume_formats::basis::cubemap::direction(
            texel / 1024,
            32,
            (texel % 32) as f64 + 0.5,
            (texel / 32 % 32) as f64 + 0.5,
        );
        let blocked = centre.x * v[0] + centre.y * v[1] + centre.z * v[2] >= (1.0 - r * r).sqrt();
        let bit = bitmaps.payload[(135 * 32 + 31) * 768 + texel / 8] >> (texel % 8) & 1;
        assert_eq!(bit == 1, blocked, "texel {texel}");
    }
}
