//! What vertices see through the texels of a cube, beside a ray through each, on one thread: microseconds a
//! vertex. `cargo bench -p relume-bake --bench cubes`; after `make assets` with the bunny and the armadillo.

#![allow(clippy::unwrap_used, reason = "a bench fails by panicking")]

mod support;

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
use support::{field, soup};

/// Vertices of a scene that are looked from.
const VERTICES: usize = 96;
/// Rounds of each, in turns; the best counts.
const ROUNDS: usize = 5;

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
