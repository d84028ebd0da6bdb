//! A synthetic bundle of the method transfer-tensor: random tensors on a crumpled sheet of three materials, one of each
//! model.
#![allow(dead_code, reason = "each test binary uses its own part")]

use super::sparse::{self, SIZE};
use super::{Random, basis, microfacet_basis};
use glam::Vec3;
use half::f16;
use relume_formats::basis::hemisphere::TEXELS;
use relume_formats::basis::microfacet::Facets;
use relume_formats::basis::sh;
use relume_formats::container::Stored;
use relume_formats::evaluate::transfer_tensor::Parts;
use relume_formats::kinds::brdf_tensor::angles::NODES;
use relume_formats::kinds::brdf_tensor::{self, Cone, Samples};
use relume_formats::kinds::manifest::{FileEntry, Manifest, MethodEntry};
use relume_formats::kinds::scene::{StoredMaterial, StoredObject};
use relume_formats::kinds::transfer_tensor::{
    Block, Meta, ONCE_LIGHT, Once, Source, TWICE_LIGHT, TransferTensor, Twice,
};
use relume_formats::kinds::{BrdfBasis, BrdfTensor, Environment, StoredScene};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx, Model};
use std::collections::BTreeMap;
use std::path::Path;

/// Azimuthal orders of the profiles; with the diffuse part they make [`COLUMNS`].
const ORDERS: [u32; 5] = [0, 1, 2, 0, 7];
pub const COLUMNS: u32 = 9;
/// Width, tilt and side of the cones, degrees.
const CONES_DEG: [[f32; 3]; 5] =
    [[3.0, 0.0, 0.0], [6.0, -20.0, 0.0], [6.0, 10.0, 0.0], [12.0, 5.0, 20.0], [24.0, -40.0, 0.0]];
/// Rows of vertices of the sheet.
const ROWS: u32 = 10;

/// Between −1 and 1.
fn signed(random: &mut Random) -> f32 {
    2.0 * random.unit() - 1.0
}

/// A space of a model: cones whose shares are at times 0, and a residual.
pub fn space(model: Model) -> BrdfTensor {
    let mut random = Random(model as u64 + 40);
    let corners = |least: f32| Samples::Plane {
        points: vec![[0.0, least], [1.0, least], [1.0, 1.0], [0.0, 1.0], [0.4, 0.5]],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    };
    let samples = match model {
        Model::BlinnPhong => Samples::Line(vec![1.0, 30.0, 200.0]),
        Model::Ggx => corners(0.32),
        Model::CookTorrance => corners(0.1),
    };
    let (count, profiles) = (samples.count(), ORDERS.len());
    let ranks = [2, 3, profiles];
    let mut table = |count: usize| -> Vec<f32> { (0..count).map(|_| signed(&mut random)).collect() };
    let share = |share: f32| (share - 0.3).max(0.0);
    BrdfTensor {
        meta: brdf_tensor::Meta {
            model,
            residual: 1.0,
            materials: 0.1,
            outgoing: 0.1,
            incoming: 0.1,
            whole: 0.2,
        },
        orders: ORDERS.to_vec(),
        core: table(ranks.iter().product()),
        materials: table(count * ranks[0]),
        outgoing: table(NODES * ranks[1]),
        incoming: table(NODES * profiles),
        cones: CONES_DEG
            .map(|[width_deg, tilt_deg, side_deg]| Cone { width_deg, tilt_deg, side_deg })
            .to_vec(),
        shares: table(count * NODES * CONES_DEG.len()).into_iter().map(share).collect(),
        even: match model {
            Model::Ggx => table(NODES).into_iter().map(|value| 0.5 + 0.5 * value.abs()).collect(),
            _ => vec![1.0; NODES],
        },
        samples,
        ranks,
    }
}

/// One space for each model.
pub fn spaces() -> Vec<BrdfTensor> {
    [Model::CookTorrance, Model::BlinnPhong, Model::Ggx].map(space).to_vec()
}

/// One basis for each model.
pub fn bases() -> Vec<BrdfBasis> {
    vec![microfacet_basis(Facets::Ggx), basis(), microfacet_basis(Facets::CookTorrance)]
}

/// The materials of the sheet: one of each model, and one that nothing wears.
pub fn materials() -> Vec<StoredMaterial> {
    let ks = [0.5, 0.3, 0.2];
    let named = [
        ("a", Brdf::BlinnPhong(BlinnPhong { kd: [0.4, 0.5, 0.3], ks, shininess: 77.0 })),
        ("b", Brdf::Ggx(Ggx { base_color: [0.9, 0.6, 0.1], metallic: 0.6, roughness: 0.44 })),
        ("c", Brdf::CookTorrance(CookTorrance { kd: [0.1, 0.2, 0.3], ks, fresnel: 0.3, roughness: 0.2 })),
        ("fixed", Brdf::BlinnPhong(BlinnPhong { kd: [0.4; 3], ks: [0.0; 3], shininess: 1.0 })),
    ];
    let material = |(name, brdf): (&str, Brdf)| StoredMaterial {
        name: name.to_owned(),
        brdf,
        varies: name != "fixed",
        textured: false,
        sharpest: brdf.model().usual_sharpest(),
    };
    named.map(material).to_vec()
}

/// A sheet of `vertices` vertices, a multiple of [`ROWS`].
pub fn scene(vertices: u32) -> StoredScene {
    let mut scene = sheet([vertices / ROWS, ROWS], 0.1);
    scene.normals[1] = [0.6, 0.8, -0.0];
    scene.normals[2] = [0.0, 0.0, -1.0];
    scene
}

/// A sheet of so many vertices two ways, up to `height` above and below a plane, whose normals point hither and thither.
pub fn sheet(vertices: [u32; 2], height: f32) -> StoredScene {
    let mut random = Random(9);
    let mut scene = sparse::scene(vertices);
    for (place, normal) in scene.positions.iter_mut().zip(&mut scene.normals) {
        place[2] = height * signed(&mut random);
        let turned = Vec3::new(signed(&mut random), signed(&mut random), 0.3 + random.unit());
        *normal = turned.normalize().to_array();
    }
    scene.meta.materials = materials();
    let triangles = scene.triangles.len() as u32;
    let part = |(material, name): (u32, &str)| StoredObject {
        name: name.to_owned(),
        material,
        triangles: if material < 2 { triangles / 3 } else { triangles - triangles / 3 * 2 },
    };
    scene.meta.objects = (0..).zip(["left", "middle", "right"]).map(part).collect();
    scene
}

pub fn sources() -> Vec<Source> {
    let source = |material, basis, channel| Source { material, basis, channel };
    vec![
        source(None, 0, Some(0)),
        source(None, 0, Some(1)),
        source(None, 0, Some(2)),
        source(Some(0), 0, None),
        source(Some(0), 2, None),
        source(Some(1), 1, Some(0)),
        source(Some(1), 1, Some(2)),
        source(Some(2), 3, None),
    ]
}

/// Tensors of three clusters, of which the last has one vertex: blocks of an odd and of an even number of terms, ranks
/// that fill no words.
pub fn transfer(vertices: u32) -> TransferTensor {
    let mut transfer = random_transfer(Meta {
        vertices,
        columns: COLUMNS,
        blocks: vec![5, 2, 4],
        unit: 2e-4,
        rays_per_texel: 1,
        reflections: 3,
        sources: sources(),
        clusters: 3,
        ranks: [6, 5],
        vectors: 7,
    });
    let clusters = transfer.once.iter_mut().flat_map(|once| &mut once.clusters).enumerate();
    clusters
        .for_each(|(vertex, cluster)| *cluster = if vertex == 70 { 2 } else { vertex as u16 * 37 % 53 % 2 });
    transfer
}

/// Tensors of random numbers that say `meta`, of three reflections; clusters are of neighbours.
pub fn random_transfer(meta: Meta) -> TransferTensor {
    let mut random = Random(u64::from(meta.vertices));
    let (v, k) = (meta.vertices as usize, meta.columns as usize);
    let blocks = meta.blocks.iter().map(|terms| block(&mut random, *terms as usize, v, k)).collect();
    let [m, n] = meta.ranks.map(|rank| rank as usize);
    let (s, c, vectors) = (meta.sources.len(), meta.clusters as usize, meta.vectors as usize);
    let halves = |random: &mut Random, count: usize, scale: f32| -> Vec<f16> {
        (0..count).map(|_| f16::from_f32(scale * signed(random))).collect()
    };
    let bytes = |random: &mut Random, count: usize| -> Vec<i8> {
        (0..count).map(|_| (random.bits() as i8).max(-127)).collect()
    };
    TransferTensor {
        blocks,
        seen: (0..v * TEXELS).map(|_| random.bits() as u8).collect(),
        once: Some(Once {
            clusters: (0..v).map(|vertex| (vertex * c / v) as u16).collect(),
            shares: bytes(&mut random, v * s * m),
            core: halves(&mut random, c * s * m * n * sh::COUNT, 1.0),
            light: halves(&mut random, c * s * n * ONCE_LIGHT, 0.01),
        }),
        twice: Some(Twice {
            shares: bytes(&mut random, v * vectors),
            vectors: halves(&mut random, c * vectors * TWICE_LIGHT * meta.pairs().len(), 0.2),
        }),
        meta,
    }
}

/// Tensors whose vertices are all as the first one.
pub fn even_transfer(vertices: u32) -> TransferTensor {
    let mut transfer = transfer(vertices);
    let count = vertices as usize;
    fn repeat<T: Copy>(values: &mut Vec<T>, count: usize) {
        let of_first = values[..values.len() / count].to_vec();
        *values = of_first.repeat(count);
    }
    for (block, terms) in transfer.blocks.iter_mut().zip(&transfer.meta.blocks) {
        repeat(&mut block.scales, count);
        let (terms, columns) = (*terms as usize, COLUMNS as usize);
        let first = |term: usize| block.indices[term * count];
        let indices: Vec<u16> = (0..terms).flat_map(|term| vec![first(term); count]).collect();
        let steps =
            (0..terms).flat_map(|term| block.steps[term * count * columns..][..columns].repeat(count));
        (block.steps, block.indices) = (steps.collect(), indices);
    }
    repeat(&mut transfer.seen, count);
    if let Some(once) = &mut transfer.once {
        repeat(&mut once.clusters, count);
        repeat(&mut once.shares, count);
    }
    transfer.twice.iter_mut().for_each(|twice| repeat(&mut twice.shares, count));
    transfer
}

fn block(random: &mut Random, terms: usize, vertices: usize, columns: usize) -> Block {
    Block {
        // Coarse functions are more common, as they are in a bake.
        indices: (0..terms * vertices).map(|_| (random.unit().powi(4) * 24_576.0) as u16).collect(),
        scales: (0..vertices * columns).map(|_| f16::from_f32(random.unit())).collect(),
        steps: (0..terms * vertices * columns).map(|_| random.bits() as i8).collect(),
    }
}

/// A bundle on disk, removed with this value.
pub struct Bundle {
    folder: tempfile::TempDir,
    pub scene: StoredScene,
    pub maps: Vec<Environment>,
    pub spaces: Vec<BrdfTensor>,
    pub bases: Vec<BrdfBasis>,
    pub transfer: TransferTensor,
}

impl Bundle {
    /// Of a sheet of 150 vertices.
    pub fn write() -> Self {
        Self::of(scene(150), sparse::maps(), (spaces(), bases()), transfer(150))
    }

    /// A bundle of these parts.
    pub fn of(
        scene: StoredScene,
        maps: Vec<Environment>,
        (spaces, bases): (Vec<BrdfTensor>, Vec<BrdfBasis>),
        transfer: TransferTensor,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut files = Vec::new();
        let mut write = |kind: &str, number: usize, write: &dyn Fn(&Path) -> Vec<u8>| {
            let name = format!("{kind}-{number}.relume");
            files.push((kind.to_owned(), FileEntry::of(&name, &write(&folder.path().join(&name)))));
        };
        maps.iter()
            .enumerate()
            .for_each(|(n, map)| write("environment", n, &|at| map.write_file(at).unwrap()));
        spaces
            .iter()
            .enumerate()
            .for_each(|(n, space)| write("brdf-tensor", n, &|at| space.write_file(at).unwrap()));
        bases
            .iter()
            .enumerate()
            .for_each(|(n, basis)| write("brdf-basis", n, &|at| basis.write_file(at).unwrap()));
        write("transfer-tensor", 0, &|at| transfer.write_file(at).unwrap());
        let scene_file =
            FileEntry::of("scene.relume", &scene.write_file(&folder.path().join("scene.relume")).unwrap());
        let manifest = Manifest {
            version: 0,
            scene: scene.meta.name.clone(),
            scene_hash: "0".repeat(32),
            scene_file,
            animations: BTreeMap::new(),
            sphere_sets: BTreeMap::new(),
            methods: vec![MethodEntry {
                reads: "0".repeat(32),
                name: "transfer-tensor".to_owned(),
                files,
                settings: BTreeMap::new(),
                errors: BTreeMap::new(),
                measured_on: String::new(),
            }],
        };
        manifest.write(folder.path()).unwrap();
        Self { folder, scene, maps, spaces, bases, transfer }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// What the CPU evaluates.
    pub fn parts<'a>(&'a self, transfer: &'a TransferTensor) -> Parts<'a> {
        Parts { scene: &self.scene, spaces: &self.spaces, bases: &self.bases, transfer }
    }

    /// Film size of the scene.
    pub fn size(&self) -> [u32; 2] {
        SIZE
    }
}
