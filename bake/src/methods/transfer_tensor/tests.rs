use super::*;
use crate::trace::lights::Lights;
use crate::trace::path::PathTracer;
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::sampler::PixelSampler;
use crate::trace::world::World;
use glam::{DVec3, Vec3};
use relume_formats::basis::{EquirectMap, cubemap, sh};
use relume_scenes::{Mesh, Scene};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

const REST: &str = "
    [render]
    size = [16, 16]
    reflections = 2
    [camera]
    position = [0.0, 1.0, 4.0]
    target = [0.0, 0.4, 0.0]
    fov_deg = 45.0
    [environment]
    file = 'lamps'
";

pub(super) fn scene(text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("{text}{REST}")).unwrap();
    relume_scenes::load(&path).unwrap()
}

/// What a gather needs of a scene.
pub(super) struct Whole {
    pub(super) scene: Scene,
    pub(super) world: World,
    pub(super) receivers: Vec<Receiver>,
    pub(super) arriving: Arriving,
    pub(super) classes: Classes,
}

impl Whole {
    pub(super) fn new(scene: Scene) -> Self {
        let (world, receivers) = (World::new(&scene), receivers(&scene));
        let arriving = Arriving::new(&receivers, &world, FACE_SIZE);
        let classes = Classes::new(&scene).unwrap();
        Self { scene, world, receivers, arriving, classes }
    }

    pub(super) fn gather(&self, rays: u32) -> Gather<'_> {
        let places = (&self.world, &self.receivers[..]);
        Gather::new(&self.scene, places, &self.arriving, &self.classes, 1).with_rays(rays)
    }

    fn tensor(&self, rays: u32, vertex: usize) -> Vec<f32> {
        let gather = self.gather(rays);
        let mut tensor = vec![0.0; gather.shape().iter().product()];
        gather.tensor(vertex, &mut tensor);
        tensor
    }

    /// Harmonics of what arrives at `vertex` of `column` from a white sky.
    fn under_white(&self, rays: u32, vertex: usize, column: usize) -> [f64; sh::COUNT] {
        let tensor = self.tensor(rays, vertex);
        let of_column = self.arriving.texels() * sh::COUNT;
        let mut sums = [0.0; sh::COUNT];
        for row in tensor[column * of_column..][..of_column].chunks_exact(sh::COUNT) {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        sums
    }
}

/// ∫ radiance · ω dω, as the second band tells it exactly.
fn vector(harmonics: &[f64; sh::COUNT]) -> DVec3 {
    DVec3::new(harmonics[3], harmonics[1], harmonics[2]) / 0.488_602_511_902_919_9
}

/// A white square of 1 m, 1 m above a point that looks at it, which sees the sky below its rim: it reflects 1
/// of a white sky wherever it is met, so that harmonics tell its solid angle and its form factor, both in
/// closed form (four rectangles with a corner above the point). Of the √N × √N strata of N = 65,536 rays some
/// 640 lie on the rim of the square, each of which has its ray inside or not: with a sixth for a variance
/// that is 10 of 8,400 rays that are to hit, 0.12 %, and the bound three times that. What it reflects is
/// summed over 24,576 texels, to 0.02 %.
#[test]
fn a_patch_above_another_has_its_form_factor() {
    let whole = Whole::new(scene(
        "
        [vary]
        materials = ['paper']
        [materials.paper]
        brdf = 'blinn-phong'
        kd = [1.0, 1.0, 1.0]
        [materials.dust]
        brdf = 'blinn-phong'
        kd = [0.0, 0.0, 0.0]
        [[object]]
        name = 'above'
        shape = 'quad'
        material = 'paper'
        transform = { translation = [0.0, 1.0, 0.0], rotation_deg = [180.0, 0.0, 0.0] }
        [[object]]
        name = 'below'
        shape = 'quad'
        material = 'dust'
        transform = { scale = 0.001 }
        ",
    ));
    let below = whole.receivers.iter().position(|r| r.normal.y > 0.5).unwrap();
    let harmonics = whole.under_white(65_536, below, 0);
    let solid_angle = 4.0 * (0.25 / 1.5f64.sqrt()).atan();
    let side = 0.5 / 1.25f64.sqrt();
    let form_factor = 4.0 / std::f64::consts::TAU * 2.0 * side * side.atan();
    let found = [harmonics[0] / 0.282_094_791_773_878_14, vector(&harmonics).y / std::f64::consts::PI];
    for (found, expected) in found.into_iter().zip([solid_angle, form_factor]) {
        assert!((found / expected - 1.0).abs() < 0.004, "{found} {expected}");
    }
    // A fixed material that is black reflects nothing, and no other column has anything.
    for column in 5..whole.classes.columns.len() {
        assert_eq!(whole.under_white(64, below, column), [0.0; sh::COUNT]);
    }
}

/// What of a sphere of 1 m around the origin lies at most `most_deg` from its lowest point, seen from inside.
fn cavity(most_deg: f32, rings: u32) -> Mesh {
    let around = 2 * rings;
    let mut mesh = Mesh::default();
    for (ring, k) in (0..=rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        // Of the rings at the poles all points but the first would be the same.
        if (ring == 0 || (ring == rings && most_deg == 180.0)) && k > 0 {
            continue;
        }
        let (theta, phi) =
            ((most_deg * ring as f32 / rings as f32).to_radians(), TAU * k as f32 / around as f32);
        let point = Vec3::new(theta.sin() * phi.cos(), -theta.cos(), theta.sin() * phi.sin());
        mesh.positions.push(point.to_array());
        mesh.normals.push((-point).to_array());
    }
    let last = mesh.positions.len() as u32 - 1;
    let vertex = |ring: u32, k: u32| match ring {
        0 => 0,
        _ => (1 + (ring - 1) * around + k % around).min(last),
    };
    for (ring, k) in (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let [a, b, c, d] =
            [vertex(ring, k), vertex(ring, k + 1), vertex(ring + 1, k + 1), vertex(ring + 1, k)];
        for [a, b, c] in [[a, b, c], [a, c, d]] {
            if a != b && b != c && a != c {
                let [p, q, r] = [a, b, c].map(|i| Vec3::from(mesh.positions[i as usize]));
                let inward = (q - p).cross(r - p).dot(p) < 0.0;
                mesh.triangles.push(if inward { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    mesh
}

pub(super) fn cavity_scene(most_deg: f32) -> Whole {
    let mut scene = scene(
        "
        [vary]
        light = true
        [materials.chalk]
        brdf = 'blinn-phong'
        kd = [0.7, 0.5, 0.3]
        [[object]]
        name = 'cavity'
        shape = 'quad'
        material = 'chalk'
        ",
    );
    scene.objects[0].mesh = Arc::new(cavity(most_deg, 24));
    Whole::new(scene)
}

/// Between any two places inside a sphere form factors are the area over that of the sphere. So every place
/// of half a sphere sees sky in half of its cosine-weighted hemisphere, and the bowl, which reflects a/2 of a
/// white sky, in the other: π·a/4 arrives as irradiance after one reflection. A mesh of facets of 3.75° errs
/// by some (1 − cos 3.75°) = 0.2 % of a sphere, and by what a place sees of facets around it at a grazing
/// angle.
#[test]
fn a_white_furnace_of_half_a_sphere_is_even() {
    let whole = cavity_scene(90.0);
    let vertices = whole.receivers.len();
    for vertex in [0, 7, vertices / 3, vertices / 2, vertices - 100] {
        for (channel, albedo) in [0.7, 0.5, 0.3].into_iter().enumerate() {
            let arriving = vector(&whole.under_white(4096, vertex, channel));
            let found = arriving.dot(whole.receivers[vertex].normal.as_dvec3());
            let expected = std::f64::consts::FRAC_PI_4 * albedo;
            assert!((found / expected - 1.0).abs() < 0.015, "vertex {vertex}: {found} {expected}");
        }
    }
}

#[test]
fn no_light_gets_into_a_closed_sphere() {
    let whole = cavity_scene(180.0);
    for vertex in [0, 100, whole.receivers.len() - 1] {
        assert!(whole.arriving.at(vertex).is_empty());
        assert!(whole.tensor(256, vertex).iter().all(|value| *value == 0.0));
    }
}

pub(super) const CORNER: &str = "
    [vary]
    materials = ['wall']
    [materials.wall]
    brdf = 'blinn-phong'
    kd = [0.3, 0.4, 0.2]
    ks = [0.4, 0.3, 0.5]
    shininess = 30.0
    [materials.floor]
    brdf = 'blinn-phong'
    kd = [0.5, 0.3, 0.2]
    ks = [0.2, 0.2, 0.4]
    shininess = 12.0
    [[object]]
    name = 'floor'
    shape = 'quad'
    segments = 20
    material = 'floor'
    transform = { scale = 2.0 }
    [[object]]
    name = 'wall'
    shape = 'quad'
    segments = 20
    material = 'wall'
    transform = { translation = [0.0, 1.0, -1.0], rotation_deg = [90.0, 0.0, 0.0], scale = 2.0 }
";

/// A map of `width` columns that is even over each of 6×8×8 texels but for its own resolution.
pub(super) fn even_over_texels(width: u32) -> EquirectMap {
    let height = width / 2;
    let radiance = |i: u32| {
        let (u, v) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let (phi, theta) = (TAU * (u / width as f32 - 0.5), PI * v / height as f32);
        let towards = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        let texel = cubemap::texel_of(towards, FACE_SIZE) as u32;
        let value = |channel| PixelSampler::new(11, texel).sample(0).pair(channel)[0].powi(3);
        [value(0), value(1), value(2)]
    };
    EquirectMap { width, height, texels: (0..width * height).map(radiance).collect() }
}

/// Radiance that arrives after one reflection, times harmonics, [channels, harmonics], by the path tracer,
/// and its standard deviation: from `groups` groups of `count` paths, which are independent of each other.
fn traced(whole: &Whole, vertex: usize, groups: u32, count: u32) -> [[[f64; sh::COUNT]; 3]; 2] {
    let lights = Lights::new(&whole.scene, &whole.world);
    // One reflection on the way is two with that of a film before the vertex.
    let tracer = PathTracer::new(&whole.scene, &whole.world, &lights, [1, 1], 1, 0);
    let Receiver { origin, normal } = whole.receivers[vertex];
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (mut sum, mut squares) = ([[0.0; sh::COUNT]; 3], [[0.0; sh::COUNT]; 3]);
    for group in 0..groups {
        let sampler = PixelSampler::new(5, group);
        let mut mean = [[0.0; sh::COUNT]; 3];
        for index in 0..count {
            let sample = sampler.sample(index);
            let [u, cos] = sample.pair(0);
            let (sin, phi) = ((1.0 - cos * cos).sqrt(), TAU * u);
            let direction = normal * cos + (tangent * phi.cos() + bitangent * phi.sin()) * sin;
            if whole.world.meet(origin, direction).is_none() {
                continue;
            }
            let radiance = tracer.radiance(origin, direction, &sample) * (TAU / count as f32);
            let values = sh::evaluate(direction.into());
            for (c, mean) in mean.iter_mut().enumerate() {
                mean.iter_mut().zip(values).for_each(|(m, y)| *m += f64::from(radiance[c] * y));
            }
        }
        for c in 0..3 {
            for k in 0..sh::COUNT {
                sum[c][k] += mean[c][k];
                squares[c][k] += mean[c][k].powi(2);
            }
        }
    }
    let n = f64::from(groups);
    let deviation =
        |c: usize, k: usize| ((squares[c][k] / n - (sum[c][k] / n).powi(2)).max(0.0) / (n - 1.0)).sqrt();
    [
        sum.map(|of_channel| of_channel.map(|s| s / n)),
        std::array::from_fn(|c| std::array::from_fn(|k| deviation(c, k))),
    ]
}

/// The whole, materials and light applied, against paths. Noise is told by the paths themselves, norm by
/// norm; a norm of 48 numbers, as many as count, is hardly ever twice what is expected. Half a per cent is
/// for what is beside it: vertices stand for what is between them, visibility and lobe are multiplied texel
/// by texel, and on the wall five functions stand for its lobe.
#[test]
fn light_after_one_reflection_is_that_of_paths() {
    let mut scene = scene(CORNER);
    let map = even_over_texels(1024);
    let environment = scene.environment.as_mut().unwrap();
    environment.map.map = Arc::new(map.clone());
    (environment.gain, environment.rotation_deg) = ([1.0; 3], 0.0);
    let whole = Whole::new(scene);
    let light = cubemap::from_equirect(&map, 0.0, FACE_SIZE);
    let wall = whole.scene.materials.iter().position(|m| m.name == "wall").unwrap();
    let weights = whole.classes.weights(&[whole.scene.materials[wall].brdf]).unwrap();
    let of_object = whole.scene.objects[0].mesh.positions.len();
    for vertex in [210, 60, 120, of_object + 220, of_object + 45] {
        let tensor = whole.tensor(8192, vertex);
        let mut found = [[0.0f64; sh::COUNT]; 3];
        for (index, values) in tensor.chunks_exact(sh::COUNT).enumerate() {
            let (column, texel) = (index / light.len(), index % light.len());
            for (c, found) in found.iter_mut().enumerate() {
                let by = f64::from(weights[column][c] * light[texel][c]);
                found.iter_mut().zip(values).for_each(|(sum, value)| *sum += by * f64::from(*value));
            }
        }
        let [expected, deviation] = traced(&whole, vertex, 32, 8192);
        let norm = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
            (0..3)
                .flat_map(|c| (0..sh::COUNT).map(move |k| (c, k)))
                .map(|(c, k)| of(c, k).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let size = norm(&|c, k| expected[c][k]);
        let off = norm(&|c, k| found[c][k] - expected[c][k]) / size;
        let noise = norm(&|c, k| deviation[c][k]) / size;
        println!("vertex {vertex}: {size:.4}, off by {off:.4}, noise {noise:.4}");
        assert!(
            size > 0.1 && noise < 0.015 && off < 2.0 * noise + 0.005,
            "vertex {vertex}: {off}, noise {noise}"
        );
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let whole = Whole::new(scene(CORNER));
            let gather = whole.gather(128);
            let clusters =
                cluster::of_vertices(&whole.receivers, &gather, &whole.arriving, (300, 8, 4)).unwrap();
            let near = cluster::near(&whole.receivers, (300, 8)).unwrap();
            let tensors = cluster::tensors(&clusters[0][..20], &gather);
            let small = cluster::Small::new(&tensors, [4, 6], cluster::Bases::Shared).unwrap();
            ([clusters, near], tensors, small.parts[0].core.clone())
        })
    };
    let (one, two) = (on(1), on(2));
    assert!(one.0.iter().all(|clusters| clusters.len() > 1) && one.1.iter().any(|value| *value != 0.0));
    assert!(one == two);
}

/// Decompositions of full rank give the light of the tensors, whichever bases are shared.
#[test]
fn light_of_a_cluster_is_that_of_its_tensors() {
    let whole = Whole::new(scene(CORNER));
    let tensors = cluster::tensors(&(200..230).collect::<Vec<_>>(), &whole.gather(64));
    let lights = ndarray::Array2::from_shape_fn((384, 2), |(l, k)| ((l * 7 + k * 3) % 11) as f64);
    let exact = cluster::lit(&tensors, &lights);
    let largest = exact.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for bases in [cluster::Bases::OfColumns, cluster::Bases::Shared] {
        let small = cluster::Small::new(&tensors, [30, 384], bases).unwrap();
        let off = (&small.lit(&lights) - &exact).iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(off < 1e-9 * largest, "{bases:?}: {off} of {largest}");
    }
}
