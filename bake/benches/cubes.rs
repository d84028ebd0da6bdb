//! What vertices see through the texels of a cube, beside a ray through each, on one thread: microseconds a
//! vertex. `cargo bench -p relume-bake --bench cubes`; after `make assets` with the bunny and the armadillo.

#![allow(clippy::unwrap_used, reason = "a bench fails by panicking")]

use glam::Vec3A;
use relume_bake::methods::sparse_transfer::texels::Texels;
use relume_bake::methods::sparse_transfer::visibility::look;
use relume_bake::trace::receivers::{Receiver, receivers};
use relume_bake::trace::spans::{Eye, TexelRays, TexelSet};
use relume_bake::trace::world::World;
use relume_scenes::{Mesh, Scene};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Vertices of a scene that are looked from.
const VERTICES: usize = 96;
/// Rounds of each, in turns; the best counts.
const ROUNDS: usize = 5;

/// Numbers from 0 to 1 without order.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> Vec3A {
        Vec3A::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// The centres of `rays` above the horizon that a ray each finds unblocked.
fn by_rays(receiver: &Receiver, world: &World, rays: &TexelRays) -> TexelSet {
    let (n, above) = (rays.face_size(), rays.above(receiver.normal));
    let mut seen = TexelSet::none(n);
    for texel in above.members() {
        if !world.occluded(receiver.origin, rays.directions()[texel], f32::INFINITY) {
            seen.insert(texel / n, texel % n);
        }
    }
    seen
}

fn by_cubes(receiver: &Receiver, world: &World, rays: &TexelRays) -> TexelSet {
    let mut seen = rays.above(receiver.normal);
    world.see(Eye { origin: receiver.origin, horizon: Some(receiver.normal), rays, within: None }, &mut seen);
    seen
}

/// Microseconds a receiver.
fn microseconds<T>(receivers: &[Receiver], mut of: impl FnMut(&Receiver) -> T) -> f64 {
    let start = Instant::now();
    receivers.iter().for_each(|receiver| drop(black_box(of(receiver))));
    start.elapsed().as_secs_f64() * 1e6 / receivers.len() as f64
}

fn bench(name: &str, scene: &Scene) {
    let world = World::new(scene);
    let all = receivers(scene);
    let some: Vec<Receiver> = all.iter().step_by(all.len().div_ceil(VERTICES)).copied().collect();
    let triangles: usize = scene.objects.iter().map(|o| o.mesh.triangles.len()).sum();
    println!("{name}: {triangles} triangles, {} vertices", all.len());
    for face_size in [32, 64, 128, 256] {
        let rays = TexelRays::centres(face_size);
        assert!(some.iter().all(|r| by_rays(r, &world, &rays) == by_cubes(r, &world, &rays)));
        let mut best = [f64::INFINITY; 3];
        for _ in 0..ROUNDS {
            best[0] = best[0].min(microseconds(&some, |r| by_rays(r, &world, &rays)));
            best[1] = best[1].min(microseconds(&some, |r| by_cubes(r, &world, &rays)));
            best[2] = best[2].min(microseconds(&some, |r| rays.above(r.normal)));
        }
        let [rays, cubes, above] = best;
        println!(
            "  6 × {face_size:3}²: rays {rays:9.0} µs, cube {cubes:7.0} µs (horizon {above:5.0}), {:5.1} ×",
            rays / cubes
        );
    }
    for side in [1, 4] {
        let texels = Texels::new(side);
        let directions: Vec<Vec<Vec3A>> = some.iter().map(|r| asked(r, &world, &texels)).collect();
        let mut best = [f64::INFINITY; 2];
        for _ in 0..ROUNDS {
            let mut next = directions.iter();
            let blocked = |r: &Receiver| {
                let directions = next.next().unwrap().iter();
                directions.filter(|d| world.occluded(r.origin, **d, f32::INFINITY)).count()
            };
            best[0] = best[0].min(microseconds(&some, blocked));
            best[1] = best[1].min(microseconds(&some, |r| look(r, &world, &texels)));
        }
        let ([by_rays, by_cubes], rays) = (best, directions.iter().map(Vec::len).sum::<usize>() / some.len());
        println!(
            "  a row with {side}² rays a texel: {rays} rays {by_rays:9.0} µs, cubes {by_cubes:7.0} µs, {:5.1} ×",
            by_rays / by_cubes
        );
    }
}

/// The directions that a row asks for.
fn asked(receiver: &Receiver, world: &World, texels: &Texels) -> Vec<Vec3A> {
    let above = texels.centres.above(receiver.normal);
    let centres = above.members().map(|texel| texels.centres.directions()[texel]);
    let refined = texels.borders(&look(receiver, world, texels).centres);
    let points = refined.members().flat_map(|texel| texels.points(texel)).map(|point| texels.point(point).0);
    let points = points.filter(|d| receiver.normal.dot(*d) > 0.0);
    centres.chain(points).take(if texels.are_refined() { usize::MAX } else { above.count() }).collect()
}

fn soup(count: usize) -> Mesh {
    let mut random = Random(1);
    let corner = |random: &mut Random, middle: Vec3A| (middle + 0.01 * random.point()).to_array();
    let positions: Vec<[f32; 3]> = (0..count)
        .flat_map(|_| {
            let middle = random.point();
            [corner(&mut random, middle), corner(&mut random, middle), corner(&mut random, middle)]
        })
        .collect();
    mesh(positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn field(side: u32) -> Mesh {
    let height =
        |x: f32, z: f32| 0.1 * (9.0 * x).sin() * (7.0 * z).cos() + 0.01 * (90.0 * x + 60.0 * z).sin();
    let place = |k: u32| k as f32 / side as f32 * 2.0 - 1.0;
    let positions = (0..=side)
        .flat_map(|z| (0..=side).map(move |x| [place(x), height(place(x), place(z)), place(z)]))
        .collect();
    let at = |x: u32, z: u32| z * (side + 1) + x;
    let triangles = (0..side)
        .flat_map(|z| {
            (0..side).flat_map(move |x| {
                [[at(x, z), at(x, z + 1), at(x + 1, z)], [at(x + 1, z), at(x, z + 1), at(x + 1, z + 1)]]
            })
        })
        .collect();
    mesh(positions, triangles)
}

fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { normals: vec![[0.0, 1.0, 0.0]; positions.len()], uvs: Vec::new(), positions, triangles }
}

/// A scene of one object.
fn of_mesh(mesh: Mesh) -> Scene {
    let mut scene = relume_scenes::load(&relume_scenes::resolve("knot-outdoors").unwrap()).unwrap();
    scene.objects.truncate(1);
    scene.objects[0].mesh = Arc::new(mesh);
    scene
}

fn main() {
    for name in ["knot-outdoors", "bunny-plane", "armadillo-plane", "cornell-knot"] {
        if let Ok(scene) = relume_scenes::load(&relume_scenes::resolve(name).unwrap()) {
            bench(name, &scene);
        }
    }
    bench("a height field", &of_mesh(field(500)));
    bench("triangles without order", &of_mesh(soup(500_000)));
}
