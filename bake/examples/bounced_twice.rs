//! The figures of docs/notes/TRANSFER-TENSOR.md on what light after one and two reflections costs to make,
//! and what is lost of it as it is stored:
//!
//! `cargo run --release --example bounced_twice -- SCENE [blinn-phong|ggx|cook-torrance]`
//!
//! SCENE is a `scene.toml`, or the name of a scene of the library, with an environment; with a model, all
//! materials that vary are of it.

use half::f16;
use ndarray::{Array2, Array3, ArrayView3, Axis};
use rayon::prelude::*;
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::transfer_images::held_out::random_state;
use relume_bake::methods::transfer_tensor::classes::pair_weight;
use relume_bake::methods::transfer_tensor::cluster::{VERTICES, lit, near, tensors};
use relume_bake::methods::transfer_tensor::packed::{LIGHTS, Packed, PackedSecond, RANKS, coarse};
use relume_bake::methods::transfer_tensor::{Arriving, Classes, FACE_SIZE, Gather, SECOND_RAYS, Second};
use relume_bake::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES};
use relume_bake::trace::receivers::{Receiver, receivers};
use relume_bake::trace::world::World;
use relume_formats::basis::{haar, sh};
use relume_formats::state::{Brdf, CookTorrance, Ggx, Rgb};
use relume_scenes::Scene;
use std::error::Error;
use std::time::Instant;

/// Seed of the rays.
const SEED: u64 = 1;
/// Vertices at which light after two reflections is compared with that of more rays.
const LOOKED_AT: usize = 200;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (name, model) = match &arguments[..] {
        [name] => (name, "blinn-phong"),
        [name, model] => (name, model.as_str()),
        _ => return Err("usage: bounced_twice SCENE [blinn-phong|ggx|cook-torrance]".into()),
    };
    let mut scene = relume_scenes::load(&relume_scenes::resolve(name)?)?;
    for material in scene.vary.materials.clone() {
        let brdf = match model {
            "ggx" => Brdf::Ggx(Ggx { base_color: [0.7, 0.5, 0.3], metallic: 0.5, roughness: 0.4 }),
            "cook-torrance" => {
                let (kd, ks) = ([0.3, 0.2, 0.1], [0.5; 3]);
                Brdf::CookTorrance(CookTorrance { kd, ks, fresnel: 0.5, roughness: 0.2 })
            }
            _ => scene.materials[material].brdf,
        };
        scene.materials[material].brdf = brdf;
    }
    Measured::new(&scene)?.all()
}

/// Sums of squares: of errors, and of what they are errors of.
#[derive(Clone, Copy, Default)]
struct Squares {
    off: f64,
    whole: f64,
}

impl Squares {
    fn add(&mut self, found: f64, exact: f64) {
        self.off += (found - exact) * (found - exact);
        self.whole += exact * exact;
    }

    fn per_cent(&self) -> f64 {
        100.0 * (self.off / self.whole).sqrt()
    }
}

/// Tells what took how long.
struct Clock(Instant);

impl Clock {
    fn tell(&mut self, what: &str) {
        println!("{what}: {:.2} s", self.0.elapsed().as_secs_f64());
        self.0 = Instant::now();
    }
}

/// A scene, and states that errors are measured in.
struct Measured<'a> {
    scene: &'a Scene,
    world: World,
    receivers: Vec<Receiver>,
    classes: Classes,
    /// By state, what each column counts for.
    weights: Vec<Vec<Rgb>>,
}

impl<'a> Measured<'a> {
    fn new(scene: &'a Scene) -> Result<Self> {
        let classes = Classes::new(scene)?;
        let of_state = |state: usize| classes.weights(&random_state(state as u32, scene));
        let weights = (0..STATES).map(of_state).collect::<Option<_>>().ok_or("no basis for a material")?;
        Ok(Self { scene, world: World::new(scene), receivers: receivers(scene), classes, weights })
    }

    /// The held-out lights at `face_size`, [texels, states · channels].
    fn lights(&self, face_size: usize) -> Result<Array2<f32>> {
        let lights = HeldOutLights::new(&environments(self.scene), face_size, false);
        Ok(Array2::from_shape_vec((lights.whole.len() / RADIANCES, RADIANCES), lights.whole)?)
    }

    fn all(&self) -> Result<()> {
        let mut clock = Clock(Instant::now());
        let places = (&self.world, &self.receivers[..]);
        println!("{} vertices, {} columns", self.receivers.len(), self.classes.columns.len());
        let arriving = Arriving::new(&self.receivers, &self.world, FACE_SIZE);
        clock.tell("visibility");
        let gather = Gather::new(self.scene, places, &arriving, &self.classes, SEED);
        clock.tell("tables");
        let clusters = near(&self.receivers, (VERTICES, RANKS[0]))?;
        clock.tell(&format!("{} clusters", clusters.len()));
        let mut all_coarse = vec![Vec::new(); self.receivers.len()];
        let mut errors = [Squares::default(); 4];
        let mut seconds = [0.0; 3];
        for members in &clusters {
            let started = Instant::now();
            let tensors = tensors(members, &gather);
            seconds[0] += started.elapsed().as_secs_f64();
            let started = Instant::now();
            let coarse: Vec<Vec<f16>> =
                (0..members.len()).into_par_iter().map(|k| coarse(&tensors.index_axis(Axis(0), k))).collect();
            members.iter().zip(coarse).for_each(|(vertex, coarse)| all_coarse[*vertex] = coarse);
            seconds[1] += started.elapsed().as_secs_f64();
            let started = Instant::now();
            let packed = Packed::new(&tensors, RANKS)?;
            seconds[2] += started.elapsed().as_secs_f64();
            let exact = lit(&tensors, &self.lights(FACE_SIZE)?.mapv(f64::from));
            drop(tensors);
            for (packed, errors) in [&packed, &rounded(&packed)].into_iter().zip(errors.chunks_exact_mut(2)) {
                let found = packed.lit(&in_haar(self.lights(FACE_SIZE)?, FACE_SIZE)).mapv(f64::from);
                self.compare(members, &found, &exact, errors);
            }
        }
        clock.tell("one reflection, with errors");
        let [gathered, coarse, decomposed] = seconds;
        println!(
            "of which tensors {gathered:.1} s, coarse ones {coarse:.1} s, decompositions {decomposed:.1} s"
        );
        let [a, b, c, d] = errors.map(|errors| errors.per_cent());
        println!("error of irradiance and harmonics: {a:.2} {b:.2} %, rounded {c:.2} {d:.2} %");
        self.second(&clusters, &all_coarse.concat(), &mut clock)
    }

    /// Adds errors of irradiance and of all harmonics of light at `members`, [vertices, columns, harmonics,
    /// states].
    fn compare(
        &self,
        members: &[usize],
        found: &ndarray::Array4<f64>,
        exact: &ndarray::Array4<f64>,
        errors: &mut [Squares],
    ) {
        for (k, vertex) in members.iter().enumerate() {
            let weights = sh::irradiance(self.receivers[*vertex].normal.into()).map(f64::from);
            let all = [found, exact].map(|all| self.radiance(&all.index_axis(Axis(0), k)));
            for (found, exact) in all[0].columns().into_iter().zip(all[1].columns()) {
                let irradiance = |values: &ndarray::ArrayView1<'_, f64>| {
                    values.iter().zip(weights).map(|(a, b)| a * b).sum()
                };
                errors[0].add(irradiance(&found), irradiance(&exact));
                found.iter().zip(exact).for_each(|(a, b)| errors[1].add(*a, *b));
            }
        }
    }

    /// Columns with the weights of each state's materials, [harmonics, states].
    fn radiance(&self, lit: &ArrayView3<'_, f64>) -> Array2<f64> {
        let mut all = Array2::zeros((lit.dim().1, lit.dim().2));
        for (column, of_column) in lit.outer_iter().enumerate() {
            let weights = (0..RADIANCES).map(|k| f64::from(self.weights[k / 3][column][k % 3]));
            all += &(&of_column * &ndarray::Array1::from_iter(weights));
        }
        all
    }

    fn second(&self, clusters: &[Vec<usize>], coarse: &[f16], clock: &mut Clock) -> Result<()> {
        let places = (&self.world, &self.receivers[..]);
        let second = || Second::new(self.scene, places, &self.classes, coarse, SEED);
        let usual = second()?;
        clock.tell("tables of harmonics");
        let lights = in_haar(self.lights(2)?, 2);
        let mut errors = [Squares::default(); 2];
        for members in clusters {
            let exact = of_vertices(&usual, members);
            let packed = PackedSecond::new(&exact.view())?;
            let vectors = packed.vectors.mapv(|x| f16::from_f32(x).to_f32());
            let rounded = PackedSecond { u: packed.u.mapv(|x| (x * 127.0).round() / 127.0), vectors };
            for (packed, errors) in [&packed, &rounded].into_iter().zip(&mut errors) {
                let found = packed.whole().permuted_axes([0, 2, 1]);
                for (found, exact) in found.outer_iter().zip(exact.outer_iter()) {
                    self.compare_irradiance([&found, &exact.view()], &lights, errors);
                }
            }
        }
        clock.tell(&format!("two reflections, {} pairs, with errors", usual.shape()[0]));
        let [packed, rounded] = errors.map(|errors| errors.per_cent());
        println!("error of 16 vectors {packed:.2} %, rounded {rounded:.2} %");
        let step = self.receivers.len().div_ceil(LOOKED_AT);
        let some: Vec<usize> = (0..self.receivers.len()).step_by(step).collect();
        let most = of_vertices(&second()?.with_rays(16 * SECOND_RAYS), &some);
        for rays in [SECOND_RAYS / 4, SECOND_RAYS, 4 * SECOND_RAYS] {
            let found = of_vertices(&second()?.with_rays(rays), &some);
            let mut errors = Squares::default();
            for (found, exact) in found.outer_iter().zip(most.outer_iter()) {
                self.compare_irradiance([&found, &exact], &lights, &mut errors);
            }
            println!("{rays} rays: {:.2} % against {}", errors.per_cent(), 16 * SECOND_RAYS);
        }
        Ok(())
    }

    /// Adds errors of irradiance of a vertex, [pairs, 24] of each, in all states.
    fn compare_irradiance(
        &self,
        tensors: [&ndarray::ArrayView2<'_, f32>; 2],
        lights: &Array2<f32>,
        errors: &mut Squares,
    ) {
        let pairs = self.classes.pairs();
        let irradiance = |tensor: &ndarray::ArrayView2<'_, f32>| -> Vec<f64> {
            let lit = tensor.dot(lights);
            let of = |k: usize| {
                let weight = |pair: &[usize; 2]| pair_weight(*pair, &self.weights[k / 3])[k % 3];
                pairs.iter().zip(lit.column(k)).map(|(pair, lit)| f64::from(weight(pair) * lit)).sum()
            };
            (0..RADIANCES).map(of).collect()
        };
        let [found, exact] = tensors.map(irradiance);
        found.iter().zip(&exact).for_each(|(a, b)| errors.add(*a, *b));
    }
}

/// [vertices, pairs, 24].
fn of_vertices(second: &Second<'_>, vertices: &[usize]) -> Array3<f32> {
    let [pairs, lights] = second.shape();
    let mut all = Array3::zeros((vertices.len(), pairs, lights));
    let each: Vec<_> = all.outer_iter_mut().zip(vertices).collect();
    each.into_par_iter().for_each(|(mut tensor, vertex)| {
        if let Some(values) = tensor.as_slice_mut() {
            second.tensor(*vertex, values);
        }
    });
    all
}

/// Coefficients of vertices in eight bits, all else in sixteen.
fn rounded(packed: &Packed) -> Packed {
    Packed {
        u: packed.u.mapv(|x| (x * 127.0).round() / 127.0),
        core: packed.core.mapv(|x| f16::from_f32(x).to_f32()),
        light: packed.light.mapv(|x| f16::from_f32(x).to_f32()),
    }
}

/// Columns of texels as Haar coefficients.
fn in_haar(mut texels: Array2<f32>, face_size: usize) -> Array2<f32> {
    debug_assert!(LIGHTS.contains(&texels.nrows()));
    for mut column in texels.columns_mut() {
        let mut values = column.to_vec();
        haar::forward_cube(&mut values, face_size);
        column.assign(&ndarray::ArrayView1::from(&values));
    }
    texels
}
