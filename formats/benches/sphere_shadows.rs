//! Frames per second of the fast path of sphere-shadows on the source's scene: a plane of 16,384 receivers
//! under the spheres of a torus knot (sphere shadows §5, table 2). Prints the best of several rounds, with
//! the part that is not caps and counting, and the time of folding the light.

#![allow(missing_docs, reason = "a program")]

use glam::Vec3;
use relume_formats::basis::diffuse::{self, NODES, blend, grid_normal};
use relume_formats::basis::haar::forward_cube;
use relume_formats::evaluate::sphere_shadows::{
    Casters, Function, Levels, Receiver, Sides, Spheres, Triangle, light, lobe, neighbours,
};
use relume_formats::fast::sphere_shadows::{Shading, order};
use relume_formats::kinds::HaarTable;
use std::f32::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

/// Receivers along a side of the plane.
const SIDE: usize = 128;
const ROUNDS: usize = 30;

/// `count` spheres along a (2, 3) torus knot about 2.2 m wide, 1 m above the plane.
fn knot(count: usize) -> Spheres {
    let sphere = |k: usize| {
        let at = TAU * k as f32 / count as f32;
        let (around, out) = (2.0 * at, 0.75 + 0.3 * (3.0 * at).cos());
        [out * around.cos(), 1.0 + 0.3 * (3.0 * at).sin(), out * around.sin(), 0.15 + 2.0 / count as f32]
    };
    let now: Vec<[f32; 4]> = (0..count).map(sphere).collect();
    Spheres { neighbours: neighbours(&now), now }
}

/// About `count` triangles of a tube along the same knot, closed: half of them count for a receiver outside.
fn tube(count: usize) -> Casters {
    let sides = 6;
    let rings = count / (2 * sides);
    let around = |k: usize| TAU * k as f32 / rings as f32;
    let middle = |k: usize| {
        let at = 2.0 * around(k % rings);
        let out = 0.75 + 0.3 * (1.5 * at).cos();
        Vec3::new(out * at.cos(), 1.0 + 0.3 * (1.5 * at).sin(), out * at.sin())
    };
    let corner = |k: usize, side: usize| {
        let along = (middle(k + 1) - middle(k + rings - 1)).normalize();
        let up = along.any_orthonormal_pair();
        let turn = TAU * side as f32 / sides as f32;
        (middle(k) + 0.12 * (turn.cos() * up.0 + turn.sin() * up.1)).to_array()
    };
    let triangle = |corners: [[f32; 3]; 3]| {
        let [a, b, c] = corners.map(Vec3::from);
        let sides = [0.01, f32::INFINITY]
            .map(|above| Sides { above, below: if above < 1.0 { f32::INFINITY } else { 1e-6 } });
        Triangle { corners, normal: (b - a).cross(c - a).normalize().to_array(), object: 1, sides }
    };
    let quad = |k: usize| {
        let (ring, side) = (k / sides, k % sides);
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, s)| corner(ring + r, side + s));
        [triangle([a, b, c]), triangle([a, c, d])]
    };
    Casters { spheres: Vec::new(), triangles: (0..rings * sides).flat_map(quad).collect() }
}

/// A plane of 4 m × 4 m whose receivers use a lobe of their own; or, `blended`, a bowl whose receivers each
/// blend four.
fn receivers(blended: bool) -> Vec<Receiver> {
    let at = |k: usize| 4.0 * k as f32 / (SIDE - 1) as f32 - 2.0;
    let receiver = |i: usize| {
        let position = Vec3::new(at(i % SIDE), 0.0, at(i / SIDE));
        let normal =
            if blended { Vec3::new(-0.2 * position.x, 1.0, -0.2 * position.z).normalize() } else { Vec3::Y };
        let own = [(NODES as u32, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        Receiver { position, normal, lobes: if blended { blend(normal) } else { own }, object: 0, own: None }
    };
    (0..SIDE * SIDE).map(receiver).collect()
}

/// A sky with a sun, a window and a good deal of detail.
fn sky(terms: usize) -> [Function; 3] {
    let mut state = 1u64;
    let texel = |i: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let d = relume_formats::basis::cubemap::direction(
            i / 1024,
            32,
            (i % 32) as f64 + 0.5,
            (i / 32 % 32) as f64 + 0.5,
        )
        .as_vec3();
        let sun = if d.dot(Vec3::new(0.36, 0.8, 0.48)) > 0.995 { 200.0 } else { 0.0 };
        let window = if d.dot(Vec3::new(-0.6, 0.64, -0.48)) > 0.95 { 10.0 } else { 0.0 };
        sun + window + 0.5 + 0.4 * d.y + (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut texels: Vec<f32> = (0..6 * 1024).map(texel).collect();
    forward_cube(&mut texels, 32);
    light([1.0, 0.9, 0.7].map(|gain| texels.iter().map(|t| t * gain).collect()), Some(terms))
}

/// Least seconds of several rounds.
fn best(mut work: impl FnMut()) -> f64 {
    let round = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..ROUNDS).map(round).fold(f64::MAX, f64::min)
}

/// Prints a line for each number of terms and levels, a column for each number of spheres.
fn print_table(name: &str, receivers: &[Receiver], lobes: &[Vec<f32>], table: &HaarTable) {
    // Without lobes only caps and counts are left.
    let unlit: Vec<Receiver> = receivers.iter().map(|r| Receiver { lobes: [(0, 0.0); 4], ..*r }).collect();
    let mut out = vec![[0.0; 3]; receivers.len()];
    println!(
        "{name}: milliseconds a frame of 16,384 receivers, of which sums, and frames per second, under 0, 32, 64, 96 and 128 spheres"
    );
    for terms in [50, 100, 200] {
        let lobes: Vec<Function> =
            lobes.iter().map(|coefficients| lobe(coefficients.clone(), Some(terms))).collect();
        let light = sky(terms);
        for levels in [Levels::One, Levels::Two] {
            let folding = best(|| drop(black_box(Shading::new(&lobes, &light, levels))));
            let shading = Shading::new(&lobes, &light, levels);
            print!("{terms:4} terms {levels:?}:");
            for count in [0, 32, 64, 96, 128] {
                let casters = Casters { spheres: vec![knot(count)], triangles: Vec::new() };
                let [whole, caps] = [receivers, &unlit].map(|receivers| {
                    best(|| shading.radiance(receivers, &casters, table, black_box(&mut out)))
                });
                print!("{:7.2} {:5.2} {:6.1};", 1e3 * whole, 1e3 * (whole - caps), 1.0 / whole);
            }
            println!(" folding {:.2} ms for {} lobes", 1e3 * folding, lobes.len());
        }
    }
}

/// Prints what triangles cost beside as many spheres, in turns.
fn print_triangles(receivers: &[Receiver], table: &HaarTable) {
    let unlit: Vec<Receiver> = receivers.iter().map(|r| Receiver { lobes: [(0, 0.0); 4], ..*r }).collect();
    let shading = Shading::new(&[], &sky(200), Levels::Two);
    let mut out = vec![[0.0; 3]; receivers.len()];
    println!(
        "milliseconds a frame for bitmaps alone of 16,384 receivers; nanoseconds a receiver and caster, both cores"
    );
    for count in [64, 256, 1024] {
        let spheres = Casters { spheres: vec![knot(count.min(128))], triangles: Vec::new() };
        let triangles = tube(count);
        let [by_spheres, by_triangles] = [&spheres, &triangles]
            .map(|casters| best(|| shading.radiance(&unlit, casters, table, black_box(&mut out))));
        let each = |seconds: f64, count: usize| 1e9 * seconds / (receivers.len() * count) as f64;
        println!(
            "{:4} spheres {:7.2} ms, {:5.2} ns; {:4} triangles {:7.2} ms, {:5.2} ns",
            count.min(128),
            1e3 * by_spheres,
            each(by_spheres, count.min(128)),
            triangles.triangles.len(),
            1e3 * by_triangles,
            each(by_triangles, triangles.triangles.len())
        );
    }
}

fn in_order(receivers: &[Receiver]) -> Vec<Receiver> {
    let positions: Vec<Vec3> = receivers.iter().map(|r| r.position).collect();
    order(&positions).into_iter().map(|k| receivers[k as usize]).collect()
}

fn main() {
    let table = HaarTable::bake();
    let lobes: Vec<Vec<f32>> = (0..NODES).map(grid_normal).chain([Vec3::Y]).map(diffuse::lobe).collect();
    let [plane, bowl] = [false, true].map(receivers);
    // Steps of a prime number of receivers.
    let scattered: Vec<Receiver> = (0..plane.len()).map(|k| plane[k * 7919 % plane.len()]).collect();
    print_triangles(&in_order(&plane), &table);
    print_table("plane", &in_order(&plane), &lobes, &table);
    print_table("bowl, four lobes each", &in_order(&bowl), &lobes, &table);
    print_table("plane in rows, not in order", &plane, &lobes, &table);
    print_table("plane in no order", &scattered, &lobes, &table);
}
