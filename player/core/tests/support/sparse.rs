//! A synthetic bundle of the method sparse-transfer: random rows on a grid of vertices, and maps that are
//! hard to follow.
#![allow(dead_code, reason = "each test binary uses its own part")]

use super::Random;
use half::f16;
use relume_formats::Place;
use relume_formats::basis::{EquirectMap, Filter, Texture, Wrap};
use relume_formats::bundle::Scope;
use relume_formats::container::Stored;
use relume_formats::display::Tonemap;
use relume_formats::kinds::manifest::{FileEntry, Manifest, MethodEntry};
use relume_formats::kinds::scene::{self, EnvironmentLook, StoredMaterial, StoredObject};
use relume_formats::kinds::sparse_transfer::{Block, BlockShape, Meta, Steps};
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::kinds::{Environment, SparseTransfer, StoredScene, Textures};
use relume_formats::method::SPARSE_TRANSFER;
use relume_formats::state::{Animation, BlinnPhong, Brdf, Camera};
use std::collections::BTreeMap;
use std::path::Path;

/// Film size of the scene.
pub const SIZE: [u32; 2] = [30, 20];
/// Diffuse reflectance of the grid.
pub const ALBEDO: [f32; 3] = [0.8, 0.4, 0.2];

/// Turns the light, changes its map and moves the camera.
pub const TURN: &str = "duration_s = 1.0\n[[key]]\nt_s = 0\nenvironment = { map = \"noise\", rotation_deg = 0.0, gain = [1.0, 1.0, 1.0] }\n\
                        camera.position = [0.0, 0.0, 3.0]\n[[key]]\nt_s = 1\n\
                        environment = { map = \"sun\", rotation_deg = 90.0, gain = [2.0, 1.0, 0.0] }\ncamera.position = [1.0, 0.0, 3.0]\n";

/// Rows of `vertices` against a light of `n` texels a side: a wide block, three of bytes, and a wide one
/// again.
pub fn transfer(vertices: u32, n: u32, rgb: bool) -> SparseTransfer {
    let mut random = Random(u64::from(vertices * n) + u64::from(rgb));
    let shapes = [(3, true), (5, false), (1, false), (4, false), (2, true)];
    let meta = Meta {
        vertices,
        face_size: n,
        bounces: u32::from(rgb),
        rgb,
        unit: 0.0003,
        blocks: shapes.map(|(terms, wide)| BlockShape { terms, wide }).to_vec(),
        rays_per_texel: 1,
    };
    let block = |shape: &BlockShape| {
        let rows = (shape.terms * vertices) as usize;
        let count = rows * meta.channels();
        // Coarse functions are more common, as they are in a bake; the first coefficient of a face is that of
        // its mean.
        let index = |random: &mut Random| (random.unit().powi(4) * meta.coefficients() as f32) as u16;
        let indices = (0..rows).map(|_| {
            if random.bits().is_multiple_of(4) {
                (random.bits() % 6) as u16 * (n * n) as u16
            } else {
                index(&mut random)
            }
        });
        let indices = indices.collect();
        // An all-zero row is legal.
        let scale = |random: &mut Random| {
            if random.bits().is_multiple_of(9) { f16::ZERO } else { f16::from_f32(random.unit()) }
        };
        let scales = (0..vertices).map(|_| scale(&mut random)).collect();
        let steps = if shape.wide {
            Steps::Wide((0..count).map(|_| random.bits() as i16).collect())
        } else {
            Steps::Bytes((0..count).map(|_| random.bits() as i8).collect())
        };
        Block { indices, scales, steps }
    };
    let blocks = meta.blocks.iter().map(block).collect();
    SparseTransfer { meta: meta.clone(), blocks }
}

/// Rows that give every vertex the same radiance `white`·L where the light is L from everywhere, and about
/// that in any other light.
pub fn even_transfer(vertices: u32, n: u32, white: f32) -> SparseTransfer {
    let meta = Meta {
        vertices,
        face_size: n,
        bounces: 0,
        rgb: false,
        unit: white / (6 * n) as f32 / f32::from(i8::MAX),
        blocks: vec![BlockShape { terms: 6, wide: false }],
        rays_per_texel: 1,
    };
    let indices =
        (0..6).flat_map(|face| std::iter::repeat_n((face * n * n) as u16, vertices as usize)).collect();
    SparseTransfer {
        meta,
        blocks: vec![Block {
            indices,
            scales: vec![f16::ONE; vertices as usize],
            steps: Steps::Bytes(vec![i8::MAX; 6 * vertices as usize]),
        }],
    }
}

fn map(name: &str, [width, height]: [u32; 2], mut texel: impl FnMut(usize) -> [f32; 3]) -> Environment {
    let texels = (0..(width * height) as usize).map(&mut texel).collect();
    Environment { name: name.to_owned(), map: EquirectMap { width, height, texels } }.rounded()
}

/// Noise; a dim sky with one texel of 10⁵; nothing at all; and a sky that is the same everywhere.
pub fn maps() -> Vec<Environment> {
    let mut random = Random(5);
    vec![
        map("noise", [64, 32], |_| std::array::from_fn(|_| random.unit())),
        map("sun", [128, 64], |i| if i == 128 * 20 + 3 { [1e5, 9e4, 8e4] } else { [0.2, 0.3, 0.5] }),
        map("black", [8, 4], |_| [0.0; 3]),
        map("even", [16, 8], |_| [2.0, 1.0, 0.5]),
    ]
}

/// A grid of `columns` × `rows` vertices on the square [−1, 1]² at z = 0, its front towards +Z, and a camera
/// before it.
pub fn scene([columns, rows]: [u32; 2]) -> StoredScene {
    let at = |i: u32, count: u32| 2.0 * i as f32 / (count - 1) as f32 - 1.0;
    let corner = |i: u32| [at(i % columns, columns), at(i / columns, rows), 0.0];
    let cell = |i: u32| {
        let first = i / (columns - 1) * columns + i % (columns - 1);
        [[first, first + 1, first + columns], [first + 1, first + columns + 1, first + columns]]
    };
    let triangles: Vec<_> = (0..(columns - 1) * (rows - 1)).flat_map(cell).collect();
    let brdf = Brdf::BlinnPhong(BlinnPhong { kd: ALBEDO, ks: [0.1; 3], shininess: 9.0 });
    let meta = scene::Meta {
        name: "lit".to_owned(),
        camera: Camera { position: [0.0, 0.0, 3.0], target: [0.0; 3], fov_deg: 30.0, exposure_ev: 0.0 },
        tonemap: Tonemap::Neutral,
        size: SIZE,
        varies_light: true,
        varies_view: true,
        varies_shape: false,
        shapes: Vec::new(),
        environment: Some(EnvironmentLook { map: "noise".to_owned(), gain: [1.0; 3], rotation_deg: 0.0 }),
        // `a` is for the animation `glow`, which another method of the bundle could play.
        materials: [("grid", false), ("a", true)]
            .map(|(name, varies)| {
                let (name, sharpest) = (name.to_owned(), brdf.model().usual_sharpest());
                StoredMaterial { name, brdf, varies, textured: false, sharpest }
            })
            .to_vec(),
        objects: vec![StoredObject {
            name: "grid".to_owned(),
            material: 0,
            triangles: triangles.len() as u32,
        }],
    };
    let vertices = columns * rows;
    StoredScene {
        meta,
        positions: (0..vertices).map(corner).collect(),
        normals: vec![[0.0, 0.0, 1.0]; vertices as usize],
        triangles,
    }
}

/// What may be set of [`scene`] among [`maps`].
pub fn scope() -> Scope {
    let maps = maps().into_iter().map(|map| map.name).collect();
    Scope { scene: scene([2, 2]).meta, card: &SPARSE_TRANSFER, maps }
}

/// A texture for the grid of [`scene`], with holes, over two repetitions mirrored one way.
pub fn textures(scene: &StoredScene, filter: Filter) -> Textures {
    let mut random = Random(11);
    let mut texel = |i: usize| {
        let [r, g, b, ..] = random.bits().to_le_bytes();
        [r, g, b, if i.is_multiple_of(5) { 0 } else { 255 }]
    };
    let texture = Texture {
        size: [8, 4],
        wrap: [Wrap::Mirror, Wrap::Repeat],
        filter,
        texels: (0..32).map(&mut texel).collect(),
    };
    let uvs = scene.positions.iter().map(|[x, y, _]| [x + 0.3, 0.4 - y]).collect();
    Textures { uvs, textures: vec![MaterialTexture { material: 0, alpha_cutoff: Some(0.5), texture }] }
}

/// A bundle on disk, removed with this value.
pub struct Bundle {
    folder: tempfile::TempDir,
    pub scene: StoredScene,
    pub maps: Vec<Environment>,
    pub transfer: SparseTransfer,
    pub manifest: Manifest,
}

impl Bundle {
    /// A bundle of random rows, with an animation `turn` of the light and one, `glow`, of a material that
    /// only another method of the bundle varies.
    pub fn write(n: u32, rgb: bool) -> Self {
        Self::of(scene([11, 7]), maps(), None, transfer(77, n, rgb))
    }

    /// A bundle of these parts.
    pub fn of(
        mut scene: StoredScene,
        maps: Vec<Environment>,
        textures: Option<&Textures>,
        transfer: SparseTransfer,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let entry = |name: &str, bytes: Vec<u8>| FileEntry::of(name, &bytes);
        scene.meta.materials[0].textured = textures.is_some();
        let mut files = Vec::new();
        for (number, map) in maps.iter().enumerate() {
            let name = format!("map-{number}.relume");
            files.push(("environment".to_owned(), entry(&name, map.write_file(&at(&name)).unwrap())));
        }
        if let Some(textures) = textures {
            files.push((
                "textures".to_owned(),
                entry("textures.relume", textures.write_file(&at("textures.relume")).unwrap()),
            ));
        }
        files.push((
            "sparse-transfer".to_owned(),
            entry("rows.relume", transfer.write_file(&at("rows.relume")).unwrap()),
        ));
        let animation = |name: &str, text: &str| {
            let file = format!("{name}.relume");
            let animation = Animation::parse(name, text, &Place::file(name)).unwrap();
            (name.to_owned(), entry(&file, animation.write_file(&at(&file)).unwrap()))
        };
        let method = |name: &str, files| MethodEntry {
            reads: "0".repeat(32),
            name: name.to_owned(),
            files,
            settings: BTreeMap::new(),
            errors: BTreeMap::new(),
            measured_on: String::new(),
        };
        let manifest = Manifest {
            version: 0,
            scene: "lit".to_owned(),
            scene_hash: "0".repeat(32),
            scene_file: entry("scene.relume", scene.write_file(&at("scene.relume")).unwrap()),
            animations: BTreeMap::from([animation("glow", super::ANIMATION), animation("turn", TURN)]),
            sphere_sets: BTreeMap::new(),
            methods: [("sparse-transfer", files), ("transfer-images", Vec::new())]
                .map(|(name, files)| method(name, files))
                .to_vec(),
        };
        manifest.write(folder.path()).unwrap();
        Self { folder, scene, maps, transfer, manifest }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The map called `name`.
    pub fn map(&self, name: &str) -> &EquirectMap {
        &self.maps.iter().find(|map| map.name == name).unwrap().map
    }
}
