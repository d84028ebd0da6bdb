//! Rays through the hierarchy beside obvhs's own traversal with the same triangle test, on one thread: million
//! rays a second, nearest hit and occlusion, in the order of a film and in none. `cargo bench -p relume-bake
//! --bench rays`; after `make assets` with the armadillo. With `-- write` it times nothing, but leaves triangles, rays
//! and what they hit in `target/rays`, for `embree.py`.

#![allow(clippy::unwrap_used, reason = "a bench fails by panicking")]

mod support;

use glam::{UVec2, Vec3A};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, traverse};
use relume_bake::trace::triangle::ShearedRay;
use relume_bake::trace::world::World;
use relume_scenes::{Mesh, Scene};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use support::{Random, field, mesh, soup};

/// Rays of a run.
const RAYS: usize = 1 << 17;
/// How many of them are timed at once.
const CHUNK: usize = 1 << 12;
/// Runs of each, in turns; the best counts.
const ROUNDS: usize = 7;

impl Random {
    fn direction(&mut self) -> Vec3A {
        loop {
            let point = self.point();
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }
}

/// obvhs as it comes, with the triangle test that both use.
struct Rival {
    hierarchy: CwBvh,
    triangles: Vec<[Vec3A; 3]>,
}

impl Rival {
    fn new(triangles: &[[Vec3A; 3]]) -> Self {
        let boxes: Vec<Triangle> =
            triangles.iter().map(|[v0, v1, v2]| Triangle { v0: *v0, v1: *v1, v2: *v2 }).collect();
        let hierarchy = build_cwbvh(
            &boxes,
            BvhBuildParams { pre_split: false, ..BvhBuildParams::slow_build() },
            &mut Duration::default(),
        );
        let triangles = hierarchy.primitive_indices.iter().map(|i| triangles[*i as usize]).collect();
        Self { hierarchy, triangles }
    }

    fn nearest(&self, origin: Vec3A, direction: Vec3A) -> Option<f32> {
        let mut ray = Ray::new(origin, direction, 0.0, f32::INFINITY);
        let sheared = ShearedRay::new(origin, direction);
        let (mut state, mut nearest) = (self.hierarchy.new_traversal(direction), None);
        let mut node;
        traverse!(self.hierarchy, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            if let Some(hit) = sheared.intersect(&self.triangles[state.primitive_id as usize], ray.tmax) {
                ray.tmax = hit.t;
                nearest = Some(hit.t);
            }
        });
        nearest
    }

    fn occluded(&self, origin: Vec3A, direction: Vec3A) -> bool {
        let ray = Ray::new(origin, direction, 0.0, f32::INFINITY);
        let sheared = ShearedRay::new(origin, direction);
        let (mut state, mut blocked) = (self.hierarchy.new_traversal(direction), false);
        let mut node;
        traverse!(self.hierarchy, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            if sheared.intersect(&self.triangles[state.primitive_id as usize], f32::INFINITY).is_some() {
                blocked = true;
                break;
            }
        });
        blocked
    }
}

/// Seconds of one run.
fn seconds(run: impl FnOnce() -> usize) -> f64 {
    let start = Instant::now();
    black_box(run());
    start.elapsed().as_secs_f64()
}

/// Each chunk's best time counts, in turns, so that other work on the machine is not measured.
fn compare(
    what: &str,
    rays: &[(Vec3A, Vec3A)],
    ours: impl Fn(Vec3A, Vec3A) -> bool,
    theirs: impl Fn(Vec3A, Vec3A) -> bool,
) {
    let ours = |rays: &[(Vec3A, Vec3A)]| rays.iter().filter(|(origin, way)| ours(*origin, *way)).count();
    let theirs = |rays: &[(Vec3A, Vec3A)]| rays.iter().filter(|(origin, way)| theirs(*origin, *way)).count();
    assert_eq!(ours(rays).abs_diff(theirs(rays)) * 10_000 / RAYS, 0, "{what}: other rays are hit");
    let mut best = vec![[f64::INFINITY; 2]; rays.len().div_ceil(CHUNK)];
    for _ in 0..ROUNDS {
        for (best, rays) in best.iter_mut().zip(rays.chunks(CHUNK)) {
            best[0] = best[0].min(seconds(|| ours(rays)));
        }
        for (best, rays) in best.iter_mut().zip(rays.chunks(CHUNK)) {
            best[1] = best[1].min(seconds(|| theirs(rays)));
        }
    }
    let [ours, theirs] =
        [0, 1].map(|k| RAYS as f64 / best.iter().map(|seconds| seconds[k]).sum::<f64>() / 1e6);
    println!("{what:44} {ours:8.2} {theirs:8.2} Mray/s, {:.2} ×", ours / theirs);
}

type Rays = Vec<(Vec3A, Vec3A)>;

fn bench(name: &str, mesh: Mesh) {
    let mut scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
    scene.objects.truncate(1);
    scene.lights.clear();
    let low = mesh.positions.iter().map(|p| Vec3A::from(*p)).fold(Vec3A::INFINITY, Vec3A::min);
    let high = mesh.positions.iter().map(|p| Vec3A::from(*p)).fold(Vec3A::NEG_INFINITY, Vec3A::max);
    let triangles: Vec<[Vec3A; 3]> =
        mesh.triangles.iter().map(|t| t.map(|i| Vec3A::from(mesh.positions[i as usize]))).collect();
    scene.objects[0].mesh = Arc::new(mesh);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let rays = [("film", film(middle, half)), ("none", anywhere(middle, half))];
    let world = World::new(&scene);
    if std::env::args().any(|argument| argument == "write") {
        write(name, &world, &triangles, &rays);
    } else {
        let rival = Rival::new(&triangles);
        println!("{name}: {} triangles", triangles.len());
        for (order, rays) in &rays {
            compare_rays(order, &world, &rival, rays);
        }
    }
}

/// In the order of a film.
fn film(middle: Vec3A, half: Vec3A) -> Rays {
    let eye = middle + Vec3A::new(0.1, 0.7, 2.0) * half.max_element() * 1.3;
    let side = (RAYS as f64).sqrt() as usize;
    let ray = |i: usize| {
        let place = |k: usize| (k as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        let at = middle + Vec3A::new(place(i % side), place(i / side), 0.0) * half;
        (eye, (at - eye).normalize())
    };
    (0..RAYS).map(ray).collect()
}

/// In no order.
fn anywhere(middle: Vec3A, half: Vec3A) -> Rays {
    let mut random = Random(7);
    (0..RAYS).map(|_| (middle + random.point() * half, random.direction())).collect()
}

fn compare_rays(order: &str, world: &World, rival: &Rival, rays: &Rays) {
    compare(
        &format!("  nearest, order: {order}"),
        rays,
        |origin, way| world.meet(origin, way).is_some(),
        |origin, way| rival.nearest(origin, way).is_some(),
    );
    compare(
        &format!("  occlusion, order: {order}"),
        rays,
        |origin, way| world.occluded(origin, way, f32::INFINITY),
        |origin, way| rival.occluded(origin, way),
    );
}

/// Leaves corners, rays (origin, direction) and the numbers of the triangles they meet (the largest number if none) for
/// others to read, all little-endian without a header.
fn write(name: &str, world: &World, triangles: &[[Vec3A; 3]], rays: &[(&str, Rays)]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/rays");
    std::fs::create_dir_all(&folder).unwrap();
    let numbers = |file: String, numbers: Vec<[u8; 4]>| {
        std::fs::write(folder.join(format!("{name}.{file}")), numbers.as_flattened()).unwrap();
    };
    let floats =
        |points: Vec<Vec3A>| points.iter().flat_map(|p| p.to_array().map(f32::to_le_bytes)).collect();
    numbers("triangles".into(), floats(triangles.concat()));
    for (order, rays) in rays {
        numbers(format!("{order}.rays"), floats(rays.iter().flat_map(|(from, way)| [*from, *way]).collect()));
        let met = |(from, way): &(Vec3A, Vec3A)| world.meet(*from, *way).map_or(u32::MAX, |met| met.triangle);
        numbers(format!("{order}.met"), rays.iter().map(|ray| met(ray).to_le_bytes()).collect());
    }
}

fn main() {
    println!("{:44} {:>8} {:>8}", "", "ours", "obvhs");
    let knot = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
    let joined = |scene: &Scene| {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for object in &scene.objects {
            let first = positions.len() as u32;
            positions.extend_from_slice(&object.mesh.positions);
            triangles.extend(object.mesh.triangles.iter().map(|t| t.map(|i| i + first)));
        }
        mesh(positions, triangles)
    };
    bench("cornell-knot", joined(&knot));
    if let Ok(scene) = relume_scenes::load(&relume_scenes::resolve("armadillo-plane").unwrap()) {
        bench("armadillo-plane", joined(&scene));
    }
    bench("height-field", field(500));
    bench("no-order", soup(500_000));
}
