//! What vertices see through the texels of a cube, beside a ray through each, on one thread: microseconds a
//! vertex. `cargo bench -p relume-bake --bench cubes`; after `make assets` with the bunny and the armadillo.

#![allow(clippy::unwrap_used, reason = "a bench fails by panicking")]

use relume_bake::methods::sparse_transfer::texels::Texels;
use relume_bake::methods::sparse_transfer::visibility::{Seen, look};
use relume_bake::trace::receivers::{Receiver, receivers};
use relume_bake::trace::spans::{Eye, TexelRays, TexelSet};
use relume_bake::trace::world::{World, take_ray_count};
use relume_scenes::Scene;
use std::hint::black_box;
use std::time::Instant;

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
    world.see(Eye { origin: receiver.origin, horizon: Some(receiver.normal), rays }, &mut seen);
    seen
}

/// Microseconds a receiver.
fn microseconds<T>(receivers: &[Receiver], of: impl Fn(&Receiver) -> T) -> f64 {
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
        take_ray_count();
        let points: usize = some.iter().map(|r| look(r, &world, &texels).points.len()).sum();
        let rays = take_ray_count() / some.len() as u64;
        let best = (0..ROUNDS)
            .map(|_| microseconds(&some, |r| -> Seen { look(r, &world, &texels) }))
            .fold(f64::INFINITY, f64::min);
        println!(
            "  a row with {side}² rays a texel: {best:7.0} µs, {rays} rays, {} within",
            points / some.len()
        );
    }
}

fn main() {
    for name in ["knot-outdoors", "bunny-plane", "armadillo-plane", "cornell-knot"] {
        if let Ok(scene) = relume_scenes::load(&relume_scenes::resolve(name).unwrap()) {
            bench(name, &scene);
        }
    }
}
