//! The committed invalid files in `corpus/invalid`: each of them stays refused, for its own reason, for ever.
//!
//! To add one, add a case here and run `cargo test --release -p relume-formats --test formats corpus --
//! --ignored`, which writes the files that are missing and leaves the others alone.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::refusal;
use crate::support::{relighting, samples, scenes, shadows, spheres};
use half::f16;
use relume_formats::Place;
use relume_formats::basis::microfacet::Facets;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::scene::StoredMaterial;
use relume_formats::kinds::sphere_shadows::{COEFFICIENTS, ORDERED};
use relume_formats::kinds::{self, Manifest, StoredScene};
use relume_formats::state::{Brdf, Ggx};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name, the kind it is read as, what the error says, and how it was made.
type Case = (&'static str, Kind, &'static str, fn() -> Vec<u8>);

const CASES: [Case; 43] = [
    ("empty.relume", Kind::Scene, "the file ends early", Vec::new),
    ("text-mode-transfer.relume", Kind::Scene, "wrong magic", || {
        let mut file = triangle().bytes();
        file.splice(7..8, *b"\r\n");
        file
    }),
    ("future-container.relume", Kind::Scene, "container version 1000", || {
        RawFile { container_version: 1000, ..triangle() }.bytes()
    }),
    ("future-kind.relume", Kind::Scene, "kind number 1000 is unknown", || {
        RawFile { kind: 1000, ..triangle() }.bytes()
    }),
    ("future-kind-version.relume", Kind::Scene, "version 1000", || {
        RawFile { kind_version: 1000, ..triangle() }.bytes()
    }),
    ("cut-short.relume", Kind::Scene, "cut short", || {
        let file = triangle().bytes();
        file[..file.len() - 3].to_vec()
    }),
    ("flipped-payload-bit.relume", Kind::Scene, "section `triangles`: checksum does not match", || {
        let mut file = triangle().bytes();
        *file.last_mut().unwrap() ^= 16;
        file
    }),
    ("shape-product-wraps.relume", Kind::Scene, "does not make 0 bytes", || {
        let section = RawSection::new("meta", 4, &[1 << 33, 1 << 33], 0, &[]);
        RawFile::new(1, vec![section]).bytes()
    }),
    ("decompression-bomb.relume", Kind::BrdfBasis, "section `meta`: cannot be decompressed", || {
        let mut section = RawSection::new("meta", 0, &[1 << 20], 0, &[0; 1 << 20]);
        (section.shape, section.raw_bytes) = (vec![49], 49);
        RawFile::new(3, vec![section]).bytes()
    }),
    ("overlapping-sections.relume", Kind::Scene, "sections must be contiguous", || {
        let mut file = triangle();
        file.sections[2].offset_error = u64::MAX;
        file.bytes()
    }),
    ("vertex-index-out-of-range.relume", Kind::Scene, "names a vertex that is not there", || {
        let mut file = triangle();
        let mut indices = file.sections[3].raw();
        indices[8] = 3;
        file.sections[3].set_raw(&indices);
        file.bytes()
    }),
    ("deeply-nested-leaf.relume", Kind::Animation, "a track's leaf has 100000 names", || {
        let mut animation = scenes::animation(1);
        animation.tracks[0].leaf = vec![String::new(); 100_000];
        written(&animation)
    }),
    ("fragment-outside-film.relume", Kind::TransferImages, "a fragment lies outside the film", || {
        let mut images = samples::images(1, 1, 2, true, [1, 1]);
        let head = Arc::make_mut(&mut images.head);
        (head.pixel, head.class, head.coverage) = (vec![1], vec![0], vec![f16::ONE]);
        head.meta.editable_fragments = 1;
        images.images.clear();
        written(&images)
    }),
    ("bases-without-lobes.relume", Kind::BrdfBasis, "holds 1 bases", || {
        let mut basis = samples::basis(1, 2, true);
        (basis.parameters, basis.coefficients) = (vec![1.0, 200.0], vec![1.0; 2]);
        basis.functions = Functions::BlinnPhong { lobes: Vec::new() };
        written(&basis)
    }),
    ("ggx-without-weights.relume", Kind::BrdfBasis, "section `weights` is missing", || {
        let mut file = RawFile::parse(&written(&samples::ggx_basis(1, 2, 1)));
        file.sections.pop();
        file.section_count = 4;
        file.bytes()
    }),
    ("ggx-weights-of-another-shape.relume", Kind::BrdfBasis, "section `weights`: has shape", || {
        let mut file = RawFile::parse(&written(&samples::ggx_basis(1, 3, 2)));
        file.sections[4].shape = vec![10];
        file.bytes()
    }),
    (
        "ggx-with-coefficients-of-one-part.relume",
        Kind::BrdfBasis,
        "section `coefficients`: has shape [2, 1, 2], expected [2, 2, 2]",
        || {
            let mut basis = samples::ggx_basis(1, 2, 1);
            (basis.parameters, basis.coefficients) = (vec![0.32, 1.0], vec![0.5; 8]);
            let mut file = RawFile::parse(&written(&basis));
            file.sections[2] = RawSection::new("coefficients", 4, &[2, 1, 2], 1, &[0; 16]);
            file.bytes()
        },
    ),
    ("ggx-mirror.relume", Kind::BrdfBasis, "values of 0.14 to 1", || {
        let mut basis = samples::ggx_basis(1, 2, 1);
        basis.functions =
            Functions::Microfacet { facets: Facets::Ggx, roughness: vec![0.0], weights: vec![1.0; 3] };
        written(&basis)
    }),
    ("table-of-one-bitmap.relume", Kind::HaarTable, "has shape [16, 1], expected [16, 65536]", || {
        RawFile::new(5, vec![RawSection::new("coefficients", 3, &[16, 1], 1, &[0; 32])]).bytes()
    }),
    (
        "visibility-of-one-direction.relume",
        Kind::VisibilityTable,
        "has shape [1, 6144], expected [136, 6144]",
        || RawFile::new(10, vec![RawSection::new("rings", 0, &[1, 6144], 0, &[32; 6144])]).bytes(),
    ),
    ("parameters-fall.relume", Kind::BrdfBasis, "needs 2 to 4096 increasing parameters", || {
        let mut basis = samples::ggx_basis(1, 2, 1);
        basis.parameters.reverse();
        written(&basis)
    }),
    ("unknown-model.relume", Kind::Scene, "section `meta`: is malformed", || {
        let mut file = triangle();
        let mut meta = file.sections[0].raw();
        // After the name of 11 bytes, the camera of 8 numbers, the curve, the film size, what varies, no
        // environment, the number of materials, and the first
        // one's name of 2.
        let at = 8 + 11 + 4 * 8 + 4 + 8 + 3 + 1 + 8 + 8 + 2;
        assert!(meta[at] < 3 && meta[at + 1..at + 4] == [0; 3], "the model stands there");
        meta[at] = 3;
        file.sections[0].set_raw(&meta);
        file.bytes()
    }),
    ("negative-radiance.relume", Kind::Environment, "a radiance is outside 0..1e12", || {
        let mut environment = relighting::environment(1, false);
        environment.map.texels[0] = [0.0, -1.0, 0.0];
        written(&environment)
    }),
    ("two-textures-of-one-material.relume", Kind::Textures, "two textures are of one material", || {
        let mut textures = (0..).map(relighting::textures).find(|t| t.textures.len() > 1).unwrap();
        textures.textures[1].material = textures.textures[0].material;
        written(&textures)
    }),
    (
        "coefficient-beyond-the-light.relume",
        Kind::SparseTransfer,
        "an index is beyond the light's coefficients",
        || {
            let mut rows = relighting::rows(1, 2, 2, false, &[(3, true)]);
            rows.blocks[0].indices[4] = 24;
            written(&rows)
        },
    ),
    ("sphere-of-no-size.relume", Kind::SphereSet, "sphere 1 has a radius that is not above 0", || {
        let mut set = spheres::sphere_set(1, 3, 5, 2, 0.5);
        set.spheres[1][3] = 0.0;
        written(&set)
    }),
    ("point-of-no-sphere.relume", Kind::SphereSet, "point 4 belongs to a sphere that is not there", || {
        let mut set = spheres::sphere_set(1, 3, 5, 2, 0.5);
        set.clusters[4] = 2;
        written(&set)
    }),
    ("fit-that-got-worse.relume", Kind::SphereSet, "rises from element 0 to the next", || {
        let mut set = spheres::sphere_set(1, 3, 5, 2, 0.5);
        set.history = vec![0.25, 0.5];
        written(&set)
    }),
    (
        "shadows-of-vertices-of-nobody.relume",
        Kind::SphereShadows,
        "2 vertices from 3 on, which do not follow",
        || first_sections(2, |shadows| shadows.meta.objects[1].first_vertex = 3),
    ),
    ("shadows-of-another-cube.relume", Kind::SphereShadows, "faces of 33554432 texels", || {
        first_sections(2, |shadows| shadows.meta.face_size = 1 << 25)
    }),
    (
        "shadows-without-grid.relume",
        Kind::SphereShadows,
        "section `normals`: has shape [2, 3], expected [384 to 4096, 3]",
        || first_sections(3, |shadows| shadows.normals.truncate(2)),
    ),
    ("textured-metal-varies.relume", Kind::Scene, "metallic 0.5 with a textured base colour", || {
        let mut scene: StoredScene = scenes::scene(3);
        let brdf = Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.5, roughness: 0.5 });
        scene.meta.materials[0] = StoredMaterial {
            name: "line\nbreak".to_owned(),
            brdf,
            varies: true,
            textured: true,
            sharpest: 0.32,
        };
        written(&scene)
    }),
    ("normal-of-no-length.relume", Kind::Scene, "the normal of vertex 1 is of length 0, not 1", || {
        changed(&triangle(), "normals", |values| values[3..6].fill(0.0))
    }),
    (
        "vertex-beyond-the-world.relume",
        Kind::Scene,
        "element 4 is 1e30, farther from the origin than 1e9 m",
        || changed(&triangle(), "positions", |values| values[4] = 1e30),
    ),
    (
        "name-that-steers-a-terminal.relume",
        Kind::Scene,
        r"the name `a\u{1b}[2J` of the scene has control characters",
        || {
            let mut scene: StoredScene = scenes::scene(3);
            scene.meta.name = "a\u{1b}[2J".to_owned();
            written(&scene)
        },
    ),
    (
        "basis-of-one-exponent.relume",
        Kind::BrdfBasis,
        "section `parameters`: runs from 1 to 1.1, expected 1 to 200",
        || {
            let mut basis = samples::basis(1, 2, true);
            (basis.parameters, basis.coefficients) = (vec![1.0, 1.1], vec![1.0; 4]);
            written(&basis)
        },
    ),
    (
        "coefficients-that-overflow.relume",
        Kind::BrdfBasis,
        "section `coefficients`: element 0, 3e38, is beyond 10000.0",
        || {
            let mut basis = samples::basis(1, 2, true);
            basis.coefficients[0] = 3e38;
            written(&basis)
        },
    ),
    (
        "coverage-above-the-pixel.relume",
        Kind::TransferImages,
        "the fragments of pixel 0 cover 1.25 of it",
        || written(&covered([0.75, 0.5], 1.0)),
    ),
    (
        "scale-that-overflows.relume",
        Kind::TransferImages,
        "section `scales`: element 0, 3e38, is beyond 1e18",
        || written(&covered([0.75, 0.25], 3e38)),
    ),
    ("radiance-that-overflows.relume", Kind::Environment, "a radiance is outside 0..1e12", || {
        let mut environment = relighting::environment(1, false);
        environment.map.texels[0] = [1e38, 0.0, 0.0];
        written(&environment)
    }),
    (
        "unit-that-overflows.relume",
        Kind::SparseTransfer,
        "section `scale/0000`: the values of vertex 0 reach",
        || {
            let mut rows = relighting::rows(1, 2, 2, false, &[(3, true)]);
            rows.meta.unit = 1e38;
            written(&rows)
        },
    ),
    ("sphere-as-large-as-the-sky.relume", Kind::SphereSet, "sphere 0 of radius 1e30 about [", || {
        let mut set = spheres::sphere_set(1, 3, 5, 2, 0.5);
        set.spheres[0][3] = 1e30;
        written(&set)
    }),
    ("sphere-of-other-points.relume", Kind::SphereSet, "outside its sphere", || {
        let mut set = spheres::sphere_set(1, 3, 5, 2, 0.5);
        set.spheres.iter_mut().for_each(|sphere| sphere[3] = 1e-3);
        written(&set)
    }),
];

/// Manifests, read as `manifest.json`.
const MANIFESTS: [(&str, &str, &str); 3] = [
    (
        "manifest-leaves-the-bundle.json",
        "no plain file name",
        r#"{"version":0,"scene":"a","scene_hash":"0","scene_file":{"file":"../a","bytes":1,"hash":"0"},"animations":{},"methods":[]}"#,
    ),
    ("manifest-of-the-future.json", "manifest version 1000", r#"{"version":1000}"#),
    ("manifest-cut-short.json", "ends early, at line 1", r#"{"version":0,"scene":"a","#),
];

fn written(value: &impl Stored) -> Vec<u8> {
    value.to_bytes_unchecked(Place::file("a.relume")).unwrap()
}

/// `file` with the floats of one section changed.
fn changed(file: &RawFile, section: &str, change: impl FnOnce(&mut [f32])) -> Vec<u8> {
    let mut file = file.clone();
    let section = file.sections.iter_mut().find(|s| s.name == section).unwrap();
    let mut values: Vec<f32> =
        section.raw().as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    change(&mut values);
    section.set_raw(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
    file.bytes()
}

/// Images of one pixel that an editable material and a fixed one cover, their first scale `scale`.
fn covered(coverage: [f32; 2], scale: f32) -> kinds::TransferImages {
    let mut images = samples::images(1, 1, 2, true, [1, 1]);
    let head = Arc::make_mut(&mut images.head);
    (head.pixel, head.class, head.coverage) = (vec![0; 2], vec![0, 1], coverage.map(f16::from_f32).to_vec());
    head.meta.editable_fragments = 1;
    head.scales[0] = scale;
    images.images.clear();
    images
}

/// The first sections of shadows, for all of them are large; what is wrong with these is noticed before the
/// end.
fn first_sections(count: usize, change: fn(&mut kinds::SphereShadows)) -> Vec<u8> {
    let mut shadows = shadows::sphere_shadows(1, &[2, 2], 0);
    change(&mut shadows);
    shadows.lobes.resize(shadows.normals.len() * COEFFICIENTS, 0.0);
    shadows.order.resize(shadows.normals.len() * ORDERED, 0);
    let mut file = RawFile::parse(&written(&shadows));
    file.sections.truncate(count);
    file.section_count = count as u64;
    file.bytes()
}

/// A sound scene of one triangle.
fn triangle() -> RawFile {
    let mut scene: StoredScene = scenes::scene(3);
    scene.meta.environment = None;
    scene.meta.objects.truncate(1);
    scene.meta.objects[0].triangles = 1;
    scene.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    scene.normals = vec![[0.0, 0.0, 1.0]; 3];
    scene.triangles = vec![[0, 1, 2]];
    RawFile::parse(&written(&scene))
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/invalid")
}

#[test]
fn every_file_is_refused_for_its_own_reason() {
    for (name, kind, expected, _) in CASES {
        let message = refusal(kind, &std::fs::read(folder().join(name)).expect(name)).to_string();
        assert!(message.contains(expected), "{name}: {message}");
    }
    for (name, expected, _) in MANIFESTS {
        let bundle = tempfile::tempdir().unwrap();
        std::fs::copy(folder().join(name), bundle.path().join("manifest.json")).expect(name);
        let message = Manifest::read(bundle.path()).unwrap_err().to_string();
        assert!(message.contains(expected), "{name}: {message}");
    }
}

#[test]
fn every_file_is_small_and_has_a_case() {
    for entry in std::fs::read_dir(folder()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let listed = CASES.iter().map(|c| c.0).chain(MANIFESTS.iter().map(|m| m.0)).any(|n| n == name);
        assert!(listed, "{name} has no case in this test");
        assert!(entry.metadata().unwrap().len() < 1024, "{name} is too large for the corpus");
        // Whatever it is read as, a broken container is refused.
        if name.ends_with(".relume") {
            let bytes = std::fs::read(entry.path()).unwrap();
            for kind in Kind::ALL {
                refusal(kind, &bytes);
            }
        }
    }
}

#[test]
#[ignore = "writes into the source tree: the files of the corpus that are missing"]
fn write_missing_files() {
    let texts = MANIFESTS.map(|(name, _, text)| (name, text.as_bytes().to_vec()));
    for (name, bytes) in CASES.map(|(name, _, _, make)| (name, make())).into_iter().chain(texts) {
        let path = folder().join(name);
        if !path.exists() {
            std::fs::write(path, bytes).unwrap();
        }
    }
}
