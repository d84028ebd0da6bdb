//! A small synthetic bundle: every value known, nothing traced.

use half::f16;
use relume_formats::Place;
use relume_formats::basis::lobe_table;
use relume_formats::container::Stored;
use relume_formats::display::Tonemap;
use relume_formats::kinds::brdf_basis::{BasisError, Functions, Meta as BasisMeta};
use relume_formats::kinds::manifest::{FileEntry, Manifest, MethodEntry, VERSION};
use relume_formats::kinds::scene::{Meta as SceneMeta, StoredMaterial, StoredObject};
use relume_formats::kinds::transfer_images::{Head, Image, Meta as ImagesMeta};
use relume_formats::kinds::{BrdfBasis, StoredScene, TransferImages};
use relume_formats::state::{Animation, BlinnPhong, Brdf, Camera, SHININESS_MAX, Track, TrackValues};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// The parts of a bundle, to be changed before they are written.
pub(super) struct TestBundle {
    pub scene: StoredScene,
    pub animation: Animation,
    pub basis: BrdfBasis,
    pub images: TransferImages,
}

impl TestBundle {
    pub fn new() -> Self {
        Self { scene: scene(), animation: animation(), basis: basis(), images: images() }
    }

    /// Writes all files into `folder`, the manifest last.
    pub fn write(&self, folder: &Path) {
        let basis = put(&self.basis, folder, "brdf-basis.relume");
        let images = put(&self.images, folder, "transfer-images.relume");
        let animation = put(&self.animation, folder, "animation-glow.relume");
        let manifest = Manifest {
            version: VERSION,
            scene: "test room".to_owned(),
            scene_hash: "0123456789abcdef".repeat(2),
            scene_file: put(&self.scene, folder, "scene.relume"),
            animations: BTreeMap::from([("glow".to_owned(), animation)]),
            sphere_sets: BTreeMap::new(),
            methods: vec![MethodEntry {
                name: "transfer-images".to_owned(),
                reads: "0123456789abcdef".repeat(2),
                files: vec![("brdf-basis".to_owned(), basis), ("transfer-images".to_owned(), images)],
                settings: BTreeMap::from([("samples".to_owned(), 16.into())]),
                errors: BTreeMap::from([("relative_l2_median".to_owned(), 0.00125)]),
                measured_on: "16 states".to_owned(),
            }],
        };
        manifest.write(folder).unwrap();
    }
}

/// Writes a value, whether readers accept it or not.
fn put(value: &impl Stored, folder: &Path, file: &str) -> FileEntry {
    let bytes = value.to_bytes_unchecked(Place::file(file)).unwrap();
    std::fs::write(folder.join(file), &bytes).unwrap();
    FileEntry::of(file, &bytes)
}

fn scene() -> StoredScene {
    let material = |name: &str, varies| StoredMaterial {
        name: name.to_owned(),
        brdf: Brdf::BlinnPhong(BlinnPhong { kd: [0.5, 0.25, 0.125], ks: [0.25; 3], shininess: 20.0 }),
        varies,
        textured: false,
        sharpest: SHININESS_MAX,
    };
    let object =
        |name: &str, material, triangles| StoredObject { name: name.to_owned(), material, triangles };
    StoredScene {
        meta: SceneMeta {
            varies_shape: false,
            shapes: Vec::new(),
            name: "test room".to_owned(),
            camera: Camera {
                position: [0.0, 1.0, 4.0],
                target: [0.0, 1.0, 0.0],
                fov_deg: 40.0,
                exposure_ev: 0.0,
            },
            tonemap: Tonemap::Agx,
            size: [3, 2],
            varies_light: false,
            varies_view: false,
            environment: None,
            materials: vec![material("white", false), material("../knot", true), material("floor", true)],
            objects: vec![object("room", 0, 1), object("knot", 1, 2)],
        },
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, -2.0]],
        normals: vec![[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.6, 0.8]],
        triangles: vec![[0, 1, 2], [1, 2, 3], [3, 0, 2]],
    }
}

fn animation() -> Animation {
    let leaf = |name: &str| ["materials", "../knot", name].map(str::to_owned).to_vec();
    let tracks = vec![
        Track {
            leaf: leaf("kd"),
            times_s: vec![0.0, 2.0],
            values: TrackValues::Vector(vec![vec![0.75; 3], vec![0.0; 3]]),
        },
        Track { leaf: leaf("shininess"), times_s: vec![1.0], values: TrackValues::Scalar(vec![3.5]) },
    ];
    Animation { name: "glow".to_owned(), duration_s: 2.0, looping: true, tracks }
}

/// Two glossy lobes, x and x² of the table's abscissa: piecewise linear look-up of x is exact.
fn basis() -> BrdfBasis {
    let error = |mean| BasisError { mean, worst: 2.0 * mean, worst_at: 7.0 };
    let abscissa = |i: usize| i as f32 / (lobe_table::NODES - 1) as f32;
    let lobe = |power: i32| (0..lobe_table::NODES).map(move |i| abscissa(i).powi(power));
    let mut basis = BrdfBasis {
        meta: BasisMeta {
            shared_diffuse: true,
            error_at_samples: error(0.001),
            error_between: error(0.0015),
        },
        parameters: vec![1.0, 50.5, 200.0],
        coefficients: vec![0.0, 1.0, 2.0, 0.5, -1.0, 4.0, 0.25, 8.0, -16.0],
        functions: Functions::BlinnPhong { lobes: lobe(1).chain(lobe(2)).collect() },
    };
    // Its lobes are those of no model.
    basis.meta.error_between.worst = basis.largest_error();
    basis
}

fn images() -> TransferImages {
    let meta = ImagesMeta {
        size: [3, 2],
        materials: vec!["../knot".to_owned(), "floor".to_owned()],
        bases: 3,
        chromaticity: Some([1.0, 0.5, 0.25]),
        samples: 16,
        seed: 9,
        editable_fragments: 4,
    };
    // Pixel 1 is seen by both editable materials and by the fixed one.
    let mut head = Head {
        meta,
        later: None,
        pixel: vec![0, 1, 1, 4, 1, 2, 3, 5],
        class: vec![0, 0, 1, 1, 2, 2, 2, 2],
        coverage: vec![
            f16::ONE,
            f16::from_f32(0.25),
            f16::from_f32(0.5),
            f16::ONE,
            f16::from_f32(0.25),
            f16::ONE,
            f16::ONE,
            f16::ONE,
        ],
        scales: Vec::new(),
    };
    let layout = head.layout();
    head.scales = (0..layout.slots.len()).map(|slot| 0.5f32.powi(slot as i32 % 5 + 8)).collect();
    // The first is the largest of its image, and images of diffuse paths hold nothing below 0.
    let value = |slot: usize, i: usize| {
        let value = if i == 0 { 7.0 } else { ((slot * 37 + i * 11) % 64) as f32 / 8.0 - 1.0 };
        f16::from_f32(4096.0 * if layout.slots[slot].is_positive() { value.abs() } else { value })
    };
    let images = layout.slots.iter().enumerate().rev().map(|(slot, s)| Image {
        slot,
        values: (0..s.channels() * head.fragments_of(s)).map(|i| value(slot, i)).collect(),
    });
    let images = images.collect();
    TransferImages { head: Arc::new(head), images }
}
