//! A synthetic bundle of the method sphere-shadows: a floor, a ball with spheres, and a worm with spheres
//! that deforms.
#![allow(dead_code, reason = "each test binary uses its own part")]

use super::{Random, sparse};
use relume_formats::basis::diffuse::{NODES, grid_normal, lobe};
use relume_formats::container::Stored;
use relume_formats::kinds::manifest::{FileEntry, Manifest, MethodEntry, SphereSetEntry, sphere_set_file};
use relume_formats::kinds::scene::{StoredClip, StoredObject, StoredShape};
use relume_formats::kinds::sphere_set::{Protrusion, Quality, Solid};
use relume_formats::kinds::sphere_shadows::{self, Casts, NO_ROW, ShadowObject, order};
use relume_formats::kinds::{Environment, SphereSet, SphereShadows, StoredScene, sphere_set};
use relume_formats::shape::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, MorphTarget, Node, Property, Track, Transform,
};
use std::collections::BTreeMap;
use std::path::Path;

/// A bundle on disk, removed with this value.
pub struct Bundle {
    folder: tempfile::TempDir,
    pub scene: StoredScene,
    pub maps: Vec<Environment>,
    pub sets: BTreeMap<String, SphereSet>,
    pub shape: DeformingMesh,
    pub bake: SphereShadows,
    pub manifest: Manifest,
}

/// Positions, normals, triangles.
type Mesh = (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A ball of rings about the Y axis.
fn ball(centre: [f32; 3], radius: [f32; 3]) -> Mesh {
    const RINGS: u32 = 6;
    const SPOKES: u32 = 9;
    let direction = |i: u32| {
        let theta = std::f32::consts::PI * ((i / SPOKES) as f32 + 0.5) / RINGS as f32;
        let phi = std::f32::consts::TAU * (i % SPOKES) as f32 / SPOKES as f32;
        [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()]
    };
    let directions: Vec<[f32; 3]> = (0..RINGS * SPOKES).map(direction).collect();
    let positions =
        directions.iter().map(|d| std::array::from_fn(|k| centre[k] + radius[k] * d[k])).collect();
    let normals = directions.iter().map(|d| {
        let n = glam::Vec3::from(*d) / glam::Vec3::from(radius);
        n.normalize().to_array()
    });
    let normals = normals.collect();
    let cell = |i: u32| {
        let (a, b) = (i, i / SPOKES * SPOKES + (i + 1) % SPOKES);
        [[a, b, a + SPOKES], [b, b + SPOKES, a + SPOKES]]
    };
    (positions, normals, (0..(RINGS - 1) * SPOKES).flat_map(cell).collect())
}

/// The floor of 7 × 6 vertices, a ball, and a worm.
fn scene() -> StoredScene {
    let mut scene = sparse::scene([7, 6]);
    for (position, normal) in scene.positions.iter_mut().zip(&mut scene.normals) {
        (*position, *normal) = ([2.0 * position[0], 0.0, -2.0 * position[1]], [0.0, 1.0, 0.0]);
    }
    scene.meta.camera.position = [0.0, 2.0, 5.0];
    scene.meta.varies_shape = true;
    for (name, centre, radius) in
        [("ball", [-0.7, 0.7, 0.2], [0.5; 3]), ("worm", [0.6, 0.8, 0.0], [0.25, 0.7, 0.25])]
    {
        let (positions, normals, triangles) = ball(centre, radius);
        let first = scene.positions.len() as u32;
        scene.meta.objects.push(StoredObject {
            name: name.to_owned(),
            material: 0,
            triangles: triangles.len() as u32,
        });
        scene.positions.extend(positions);
        scene.normals.extend(normals);
        scene.triangles.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    let clips = ["Turn", "Swell"].map(|name| StoredClip { name: name.to_owned(), duration_s: 1.0 });
    scene.meta.shapes = vec![StoredShape { object: "worm".to_owned(), clips: clips.to_vec() }];
    scene
}

/// Vertices of each object of [`scene`].
const COUNTS: [usize; 3] = [42, 54, 54];

/// The worm's shape: a node that turns, and a target that moves every vertex its own way.
fn worm(positions: &[[f32; 3]]) -> DeformingMesh {
    let mut random = Random(31);
    let count = positions.len();
    let track = |property, values: &[f32]| Track {
        property,
        interpolation: Interpolation::Linear,
        times_s: vec![0.0, 1.0],
        values: values.to_vec(),
    };
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let clip = |name: &str, tracks| Clip { name: name.to_owned(), duration_s: 1.0, tracks };
    DeformingMesh {
        positions: positions.to_vec(),
        influences: vec![Influences::rigid(0); count],
        joints: vec![Joint { node: 0, node_from_mesh: glam::DAffine3::IDENTITY }],
        nodes: vec![Node {
            parent: None,
            rest: Transform::Parts { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] },
        }],
        morph_targets: vec![MorphTarget {
            rest_weight: 0.0,
            vertices: (0..count as u32).collect(),
            deltas: (0..count).map(|_| std::array::from_fn(|_| 0.3 * (random.unit() - 0.5))).collect(),
        }],
        clips: vec![
            clip(
                "Turn",
                vec![
                    track(Property::Rotation(0), &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]),
                    track(Property::Translation(0), &[0.0, 0.0, 0.0, 0.5, 0.3, 0.0]),
                ],
            ),
            clip("Swell", vec![track(Property::MorphWeight(0), &[0.0, 1.0])]),
        ],
    }
}

/// Of the box around `points`.
fn diagonal(points: &[[f32; 3]]) -> f32 {
    let along = |axis: usize| points.iter().map(move |p| p[axis]);
    let side = |axis: usize| {
        along(axis).fold(f32::NEG_INFINITY, f32::max) - along(axis).fold(f32::INFINITY, f32::min)
    };
    glam::Vec3::new(side(0), side(1), side(2)).length()
}

/// `count` spheres about `vertices`, each vertex of the nearest.
fn spheres(name: &str, vertices: &[[f32; 3]], count: usize) -> SphereSet {
    let distance = |a: &[f32; 3], b: &[f32; 3]| glam::Vec3::from(*a).distance(glam::Vec3::from(*b));
    let middle: [f32; 3] =
        std::array::from_fn(|k| vertices.iter().map(|v| v[k]).sum::<f32>() / vertices.len() as f32);
    let centre = |k: usize| {
        let v = vertices[k * vertices.len() / count];
        std::array::from_fn(|axis| 0.6 * v[axis] + 0.4 * middle[axis])
    };
    let centres: Vec<[f32; 3]> = (0..count).map(centre).collect();
    let nearest = |v: &[f32; 3]| {
        (0..count).min_by(|a, b| distance(&centres[*a], v).total_cmp(&distance(&centres[*b], v))).unwrap()
            as u32
    };
    let clusters: Vec<u32> = vertices.iter().map(nearest).collect();
    let radius = |k: usize| {
        let own = vertices.iter().zip(&clusters).filter(|(_, cluster)| **cluster as usize == k);
        own.map(|(v, _)| distance(v, &centres[k])).fold(0.05, f32::max) * 1.0001
    };
    SphereSet {
        meta: sphere_set::Meta {
            mesh: name.to_owned(),
            vertices: vertices.len() as u32,
            triangles: 1,
            seed: 0,
            iterations: 1,
            tight: 0.0,
            poses: 0,
            solid: Solid::Closed,
            diagonal: diagonal(vertices),
            volume: 1.0,
            outside_volume: 1.0,
            quality: Quality {
                coverage_surface: 1.0,
                coverage_volume: 1.0,
                protrusion: Protrusion { mean: 0.0, p95: 0.0, max: 0.0 },
                largest_gap: 0.0,
                overlap: 0.0,
            },
        },
        spheres: (0..count).map(|k| [centres[k][0], centres[k][1], centres[k][2], radius(k)]).collect(),
        points: vertices.to_vec(),
        point_vertices: (0..vertices.len() as u32).map(|v| [v; 3]).collect(),
        point_weights: vec![[1.0, 0.0, 0.0]; vertices.len()],
        clusters,
        history: vec![1.0],
    }
}

/// The lobes of the grid and of the floor, which is the first object; `blocks` says whether the others have
/// spheres.
fn bake(blocks: bool) -> SphereShadows {
    let normals: Vec<[f32; 3]> =
        (0..NODES).map(|node| grid_normal(node).to_array()).chain([[0.0, 1.0, 0.0]]).collect();
    let lobes: Vec<f32> = normals.iter().flat_map(|normal| lobe((*normal).into())).collect();
    let order = lobes.chunks_exact(sphere_shadows::COEFFICIENTS).flat_map(order).collect();
    let mut first_vertex = 0;
    let objects = ["grid", "ball", "worm"].into_iter().zip(COUNTS).map(|(name, count)| {
        let first = first_vertex;
        first_vertex += count as u32;
        let (sphere_set, deforms) = (blocks && name != "grid", name == "worm");
        ShadowObject {
            name: name.to_owned(),
            first_vertex: first,
            vertices: count as u32,
            sphere_set,
            casts: if sphere_set { Casts::Spheres } else { Casts::Nothing },
            deforms,
        }
    });
    let objects = objects.collect();
    let rows = [vec![NODES as u32; COUNTS[0]], vec![NO_ROW; COUNTS[1] + COUNTS[2]]].concat();
    SphereShadows {
        meta: sphere_shadows::Meta { face_size: 32, normal_grid: 8, terms: 200, second_level: true, objects },
        rows,
        normals,
        lobes,
        order,
        casters: Vec::new(),
        caster_offsets: Vec::new(),
        caster_errors: Vec::new(),
    }
}

/// Lets the floor and the worm cast by their meshes, of which the worm's counts as closed; the ball keeps its
/// spheres.
pub fn cast_by_meshes(bake: &mut SphereShadows) {
    let mut end = 0;
    for (at, (object, casting)) in scene().meta.objects.iter().zip(&mut bake.meta.objects).enumerate() {
        let triangles = &scene().triangles[end..end + object.triangles as usize];
        end += triangles.len();
        if at != 1 {
            casting.casts = Casts::Mesh { triangles: triangles.len() as u32, closed: at == 2 };
            bake.casters.extend_from_slice(triangles);
            // The same at a vertex for all triangles that have it.
            let offset = |v: &u32| 0.02 * (*v % 5) as f32 - 0.04;
            bake.caster_offsets.extend(triangles.iter().map(|t| t.each_ref().map(offset)));
            bake.caster_errors.extend(triangles.iter().map(|t| 0.01 * (t[0] % 3) as f32));
        }
    }
}

impl Bundle {
    /// The scene, with spheres or without.
    pub fn write(blocks: bool) -> Self {
        Self::with(|_| {}, blocks)
    }

    /// The scene after `change`.
    pub fn with(change: impl FnOnce(&mut SphereShadows), blocks: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let entry = |name: &str, bytes: Vec<u8>| FileEntry::of(name, &bytes);
        let (scene, maps, mut bake) = (scene(), sparse::maps(), bake(blocks));
        change(&mut bake);
        let (ball, worms) = (&scene.positions[42..96], &scene.positions[96..]);
        let shape = worm(worms);
        let mut sets = BTreeMap::new();
        if blocks {
            sets.insert("ball".to_owned(), spheres("ball", ball, 5));
            sets.insert("worm".to_owned(), spheres("worm", worms, 7));
        }
        let mut files = Vec::new();
        for (number, map) in maps.iter().enumerate() {
            let name = format!("map-{number}.relume");
            files.push(("environment".to_owned(), entry(&name, map.write_file(&at(&name)).unwrap())));
        }
        files.push((
            "shape".to_owned(),
            entry("shape-worm.relume", shape.write_file(&at("shape-worm.relume")).unwrap()),
        ));
        files.push((
            "sphere-shadows".to_owned(),
            entry("main.relume", bake.write_file(&at("main.relume")).unwrap()),
        ));
        let set_entry = |(name, set): (&String, &SphereSet)| {
            let file = sphere_set_file(name);
            let file = entry(&file, set.write_file(&at(&file)).unwrap());
            (name.clone(), SphereSetEntry { file, settings: BTreeMap::new() })
        };
        let manifest = Manifest {
            version: 0,
            scene: "lit".to_owned(),
            scene_hash: "0".repeat(32),
            scene_file: entry("scene.relume", scene.write_file(&at("scene.relume")).unwrap()),
            animations: BTreeMap::new(),
            sphere_sets: sets.iter().map(set_entry).collect(),
            methods: vec![MethodEntry {
                reads: "0".repeat(32),
                name: "sphere-shadows".to_owned(),
                files,
                settings: BTreeMap::new(),
                errors: BTreeMap::new(),
                measured_on: String::new(),
            }],
        };
        manifest.write(folder.path()).unwrap();
        Self { folder, scene, maps, sets, shape, bake, manifest }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Bytes of all files.
    pub fn bytes(&self) -> u64 {
        self.manifest.entries().map(|entry| entry.bytes).sum()
    }
}
