use super::super::packed::coarse;
use super::super::tests::{CORNER, Whole, cavity_scene, scene};
use super::*;
use crate::methods::transfer_tensor::classes::pair_weight;
use crate::trace::lights::Lights;
use crate::trace::path::PathTracer;
use crate::trace::sampler::PixelSampler;
use glam::Vec3;
use ndarray::ArrayView3;
use relume_formats::basis::{EquirectMap, cubemap, haar};
use relume_formats::state::Rgb;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Light after one reflection at all vertices.
fn first(whole: &Whole, rays: u32) -> Vec<f16> {
    let gather = whole.gather(rays);
    let of_vertex = |vertex: usize| {
        let mut tensor = vec![0.0; gather.shape().iter().product()];
        gather.tensor(vertex, &mut tensor);
        coarse(&ArrayView3::from_shape(gather.shape(), &tensor).unwrap())
    };
    (0..whole.receivers.len()).into_par_iter().flat_map_iter(of_vertex).collect()
}

fn second<'a>(whole: &'a Whole, coarse: &'a [f16], rays: u32) -> Second<'a> {
    let places = (&whole.world, &whole.receivers[..]);
    Second::new(&whole.scene, places, &whole.classes, coarse, 2).unwrap().with_rays(rays)
}

/// Irradiance over π at `vertex` after two reflections of `light`, texels of 6×2×2.
fn irradiance(second: &Second<'_>, vertex: usize, light: &[Rgb], weights: &[Rgb]) -> [f64; 3] {
    let mut tensor = vec![0.0; second.shape().iter().product()];
    second.tensor(vertex, &mut tensor);
    let mut sums = [0.0; 3];
    for (c, sum) in sums.iter_mut().enumerate() {
        let mut coefficients: Vec<f32> = light.iter().map(|texel| texel[c]).collect();
        haar::forward_cube(&mut coefficients, 2);
        for (pair, values) in second.pairs.iter().zip(tensor.chunks_exact(LIGHTS[1])) {
            let lit: f64 = values.iter().zip(&coefficients).map(|(t, c)| f64::from(t * c)).sum();
            *sum += f64::from(pair_weight(*pair, weights)[c]) * lit;
        }
    }
    sums
}

/// Half a sphere that is open to a white sky: every place sees it in half of its cosine-weighted hemisphere
/// and the bowl in the other, so that irradiance over π is ½, a/4, a²/8 after no, one and two reflections.
/// The mesh of facets costs what it does after one reflection, twice.
#[test]
fn a_white_furnace_of_half_a_sphere_is_even() {
    let whole = cavity_scene(90.0);
    let coarse = first(&whole, 256);
    let second = second(&whole, &coarse, 1024);
    let weights = whole.classes.weights(&[]).unwrap();
    for vertex in [0, 7, whole.receivers.len() / 2, whole.receivers.len() - 100] {
        let found = irradiance(&second, vertex, &[[1.0; 3]; 24], &weights);
        for (found, albedo) in found.into_iter().zip([0.7, 0.5, 0.3]) {
            let expected = albedo * albedo / 8.0;
            assert!((found / expected - 1.0).abs() < 0.03, "vertex {vertex}: {found} {expected}");
        }
    }
}

#[test]
fn no_light_gets_into_a_closed_sphere() {
    let whole = cavity_scene(180.0);
    let coarse = first(&whole, 16);
    let second = second(&whole, &coarse, 64);
    let mut tensor = vec![1.0; second.shape().iter().product()];
    second.tensor(100, &mut tensor);
    assert!(tensor.iter().all(|value| *value == 0.0));
}

/// A map of `width` columns that is even over each of 6×2×2 texels but for its own resolution.
fn map(width: u32) -> EquirectMap {
    let height = width / 2;
    let radiance = |i: u32| {
        let (u, v) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let (phi, theta) = (TAU * (u / width as f32 - 0.5), PI * v / height as f32);
        let towards = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        let texel = cubemap::texel_of(towards, 2) as u32;
        [0, 1, 2].map(|channel| PixelSampler::new(11, texel).sample(0).pair(channel)[0].powi(3))
    };
    EquirectMap { width, height, texels: (0..width * height).map(radiance).collect() }
}

/// Irradiance over π at `vertex` after exactly two reflections, by paths: those of at most two less those of
/// at most one, which are the same but for the last; and its standard deviation, from independent groups.
fn traced(whole: &Whole, vertex: usize, groups: u32, count: u32) -> [[f64; 3]; 2] {
    let lights = Lights::new(&whole.scene, &whole.world);
    let tracers = [2, 1].map(|most| PathTracer::new(&whole.scene, &whole.world, &lights, [1, 1], most, 0));
    let Receiver { origin, normal } = whole.receivers[vertex];
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
    for group in 0..groups {
        let sampler = PixelSampler::new(5, group);
        let mut mean = [0.0; 3];
        for index in 0..count {
            let sample = sampler.sample(index);
            let [u, v] = sample.pair(0);
            let (cos, sin, phi) = (v.sqrt(), (1.0 - v).sqrt(), TAU * u);
            let direction = normal * cos + (tangent * phi.cos() + bitangent * phi.sin()) * sin;
            let [two, one] = tracers.each_ref().map(|tracer| tracer.radiance(origin, direction, &sample));
            (0..3).for_each(|c| mean[c] += f64::from(two[c] - one[c]) / f64::from(count));
        }
        for c in 0..3 {
            (sum[c], squares[c]) = (sum[c] + mean[c], squares[c] + mean[c] * mean[c]);
        }
    }
    let n = f64::from(groups);
    let mean = sum.map(|s| s / n);
    [mean, [0, 1, 2].map(|c| ((squares[c] / n - mean[c] * mean[c]).max(0.0) / (n - 1.0)).sqrt())]
}

/// The whole, materials and light applied, in a corner of two planes with these exponents, against paths:
/// relative L2 over vertices and channels, and what of it the paths' own noise is.
fn off_from_paths(exponents: [&str; 2]) -> [f64; 2] {
    let [wall, floor] = exponents.map(|exponent| format!("shininess = {exponent}"));
    let text = CORNER.replace("shininess = 30.0", &wall).replace("shininess = 12.0", &floor);
    let mut scene = scene(&text);
    let map = map(1024);
    let environment = scene.environment.as_mut().unwrap();
    environment.map.map = Arc::new(map.clone());
    (environment.gain, environment.rotation_deg) = ([1.0; 3], 0.0);
    let whole = Whole::new(scene);
    let light = cubemap::from_equirect(&map, 0.0, 2);
    let own: Vec<_> = whole.scene.vary.materials.iter().map(|m| whole.scene.materials[*m].brdf).collect();
    let weights = whole.classes.weights(&own).unwrap();
    let coarse = first(&whole, 1024);
    let second = second(&whole, &coarse, 4096);
    let of_object = whole.scene.objects[0].mesh.positions.len();
    let mut squares = [0.0; 3];
    for vertex in [210, 60, 120, of_object + 220, of_object + 45] {
        let found = irradiance(&second, vertex, &light, &weights);
        let [expected, deviation] = traced(&whole, vertex, 32, 8192);
        println!("{exponents:?}, vertex {vertex}: {found:.5?}, {expected:.5?}, noise {deviation:.5?}");
        for c in 0..3 {
            let terms = [found[c] - expected[c], deviation[c], expected[c]];
            squares.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term * term);
        }
    }
    assert!(squares[2] > 1e-4);
    let found = [0, 1].map(|k: usize| (squares[k] / squares[2]).sqrt());
    println!("{exponents:?}: off by {:.4}, noise {:.4}", found[0], found[1]);
    found
}

/// Lobes of low exponents have hardly anything beyond four bands of harmonics, so that paths are met: what is
/// beside their noise is what bands lose of light that the horizon cuts off.
#[test]
fn light_after_two_reflections_is_that_of_paths() {
    let [off, noise] = off_from_paths(["2.0", "1.0"]);
    assert!(noise < 0.015 && off < 2.0 * noise + 0.02, "{off}, noise {noise}");
}

/// A lobe of exponent 30 is 0.36 wide: e^(−l²·0.36²/2) = 0.35 of the first band that is left out passes it,
/// and it meets light that a lobe of the other plane has made narrow, too. What then is lost of light after
/// two reflections is of the method, most at dark places; in all it is an eighth.
#[test]
fn four_bands_lose_some_light_between_glossy_planes() {
    let [off, noise] = off_from_paths(["30.0", "12.0"]);
    assert!(noise < 0.02 && off < 0.14, "{off}, noise {noise}");
}

/// Every pair of columns that some channel passes counts, and its weight is that of both.
#[test]
fn pairs_are_of_channels_that_meet() {
    let whole = Whole::new(scene(CORNER));
    let columns = whole.classes.columns.len();
    // Five functions of the wall, three channels of the floor, of which a pair meets but itself.
    let pairs = whole.classes.pairs();
    assert_eq!((columns, pairs.len()), (8, 8 * 8 - 3 * 2));
    let weights: Vec<Rgb> = (0..columns).map(|k| [1.0 + k as f32, 2.0, 3.0]).collect();
    assert_eq!(pair_weight([1, 4], &weights), [10.0, 4.0, 9.0]);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let whole = Whole::new(scene(CORNER));
            let coarse = first(&whole, 64);
            let second = second(&whole, &coarse, 64);
            let mut tensor = vec![0.0; second.shape().iter().product()];
            second.tensor(100, &mut tensor);
            (tensor, coarse)
        })
    };
    let (one, two) = (on(1), on(2));
    assert!(one.0.iter().any(|value| *value != 0.0));
    assert!(one == two);
}
