//! The figures of docs/notes/TRANSFER-TENSOR.md on light after one reflection:
//!
//! `cargo run --release --example bounced_tensor -- SCENE [made|small]`
//!
//! SCENE is a `scene.toml`, or the name of a scene of the library, with an environment; those of the note are
//! `bake/examples/open-box/scene.toml` and `coarse.toml` beside it. `made` prints what limits the tensors
//! themselves, `small` what is lost by making them small; without either, both.

use ndarray::{Array2, Array3, Array4, ArrayView3, Axis, s, stack};
use rayon::prelude::*;
use relume_bake::compress::moving_basis::{moving_basis, shares};
use relume_bake::compress::tucker2::tucker2;
use relume_bake::methods::environment_lit::environments;
use relume_bake::methods::transfer_images::held_out::random_state;
use relume_bake::methods::transfer_tensor::cluster::{
    Bases, ROUNDS, Small, VERTICES, lit, near, of_vertices, places, tensors,
};
use relume_bake::methods::transfer_tensor::{Arriving, Classes, FACE_SIZE, Gather, RAYS};
use relume_bake::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES};
use relume_bake::trace::receivers::{Receiver, receivers, triangles};
use relume_bake::trace::world::World;
use relume_formats::basis::sh;
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use std::collections::BTreeSet;
use std::error::Error;
use std::time::Instant;

/// Vertices that the tensors themselves are looked at.
const LOOKED_AT: usize = 200;
/// Seed of the rays.
const SEED: u64 = 1;
/// Ranks of vertices and light: first those that all clusters are decomposed to, then those of the source's
/// figures 5-9 and 5-10, and more with shared bases.
const RANKS: [([usize; 2], Bases); 12] = [
    ([32, 64], Bases::OfColumns),
    ([32, 64], Bases::Shared),
    ([64, 64], Bases::Shared),
    ([8, 64], Bases::OfColumns),
    ([16, 64], Bases::OfColumns),
    ([32, 16], Bases::OfColumns),
    ([32, 32], Bases::OfColumns),
    ([32, 96], Bases::OfColumns),
    ([64, 64], Bases::OfColumns),
    ([64, 32], Bases::Shared),
    ([96, 64], Bases::Shared),
    ([96, 96], Bases::Shared),
];
/// How many of these.
const WHOLE: usize = 3;
/// Of so many clusters one is decomposed to the others, too.
const SWEPT: usize = 4;
/// Ranks of the basis that moves, the nodes around a vertex whose bases are its own, and turns to find it.
const MOVING: [usize; 2] = [32, 64];
const NODES_AROUND: usize = 4;
const TURNS: usize = 8;
const HEAD: &str = "| bases | vertices / light | irradiance, % | harmonics, % | bytes a vertex, 16 bits \
                    | 8 bits | across a seam / inside | s a 1,000 vertices |\n|---|---|---|---|---|---|---|---|";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (name, what) = match &arguments[..] {
        [name] => (name, None),
        [name, what] if ["made", "small"].contains(&what.as_str()) => (name, Some(what.as_str())),
        _ => return Err("usage: bounced_tensor SCENE [made|small]".into()),
    };
    let scene = relume_scenes::load(&relume_scenes::resolve(name)?)?;
    if scene.environment.is_none() {
        return Err(format!("{name} has no environment to be lit by; name a scene with one").into());
    }
    let measured = Measured::new(&scene)?;
    if what != Some("small") {
        measured.made()?;
    }
    if what != Some("made") {
        measured.small()?;
    }
    Ok(())
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

/// What arrives at some vertices in all states: [vertices, harmonics, states · channels].
type Radiance = Array3<f64>;

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

impl<'a> Measured<'a> {
    fn new(scene: &'a Scene) -> Result<Self> {
        let classes = Classes::new(scene)?;
        let of_state = |state: usize| classes.weights(&random_state(state as u32, scene));
        let weights =
            (0..STATES).map(of_state).collect::<Option<_>>().ok_or("materials are of several models")?;
        let world = World::new(scene);
        Ok(Self { scene, world, receivers: receivers(scene), classes, weights })
    }

    fn gather<'b>(&'b self, arriving: &'b Arriving, rays: u32) -> Gather<'b> {
        Gather::new(self.scene, (&self.world, &self.receivers), arriving, &self.classes, SEED).with_rays(rays)
    }

    /// The held-out lights at `face_size`, [texels, states · channels].
    fn lights(&self, face_size: usize) -> Result<Array2<f64>> {
        let lights = HeldOutLights::new(&environments(self.scene), face_size, false);
        let texels = lights.whole.iter().map(|value| f64::from(*value)).collect::<Vec<_>>();
        Ok(Array2::from_shape_vec((texels.len() / RADIANCES, RADIANCES), texels)?)
    }

    /// Columns with the weights of each state's materials.
    fn radiance(&self, lit: &Array4<f64>) -> Radiance {
        let (vertices, _, harmonics, states) = lit.dim();
        let mut all = Array3::zeros((vertices, harmonics, states));
        for (column, of_column) in lit.axis_iter(Axis(1)).enumerate() {
            let weights: Vec<f64> =
                (0..states).map(|k| f64::from(self.weights[k / 3][column][k % 3])).collect();
            let weights = ndarray::ArrayView1::from(&weights);
            all += &(&of_column * &weights);
        }
        all
    }

    /// What `vertices` receive under a light of `face_size`.
    fn of(&self, vertices: &[usize], fine: &Arriving, face_size: usize, rays: u32) -> Result<Radiance> {
        let arriving = fine.coarser(face_size);
        let (gather, lights) = (self.gather(&arriving, rays), self.lights(face_size)?);
        let mut all = Array3::zeros((vertices.len(), sh::COUNT, RADIANCES));
        // A few at a time, for the tensors of a fine light are large.
        for (chunk, vertices) in vertices.chunks(8).enumerate() {
            let radiance = self.radiance(&lit(&tensors(vertices, &gather), &lights));
            let at = 8 * chunk;
            all.slice_mut(s![at..at + vertices.len(), .., ..]).assign(&radiance);
        }
        Ok(all)
    }

    /// Rays and the light's resolution (the source's Fig. 5-8).
    fn made(&self) -> Result<()> {
        let count = self.receivers.len();
        let step = count.div_ceil(LOOKED_AT).max(1);
        let vertices: Vec<usize> = (0..count).step_by(step).collect();
        let fine = Arriving::new(&self.receivers, &self.world, 32);
        println!("\n{count} vertices, {} looked at\n", vertices.len());
        println!(
            "| light | rays | against | irradiance, % | harmonics, % | seconds |\n|---|---|---|---|---|---|"
        );
        let most = self.of(&vertices, &fine, FACE_SIZE, 16 * RAYS)?;
        for rays in [RAYS / 4, RAYS / 2, RAYS, 2 * RAYS, 4 * RAYS] {
            let what = format!("6×{FACE_SIZE}² | {rays} | {} rays", 16 * RAYS);
            self.row(&what, &most, || self.of(&vertices, &fine, FACE_SIZE, rays))?;
        }
        let finest = self.of(&vertices, &fine, 32, RAYS)?;
        for face_size in [4, 8, 16] {
            let what = format!("6×{face_size}² | {RAYS} | a light of 6×32²");
            self.row(&what, &finest, || self.of(&vertices, &fine, face_size, RAYS))?;
        }
        Ok(())
    }

    fn row(&self, what: &str, exact: &Radiance, found: impl Fn() -> Result<Radiance>) -> Result<()> {
        let started = Instant::now();
        let found = found()?;
        let seconds = started.elapsed().as_secs_f64();
        let (mut of_irradiance, mut of_harmonics) = (Squares::default(), Squares::default());
        let step = self.receivers.len().div_ceil(LOOKED_AT).max(1);
        for (k, vertex) in (0..self.receivers.len()).step_by(step).enumerate() {
            let pair = [&found, exact].map(|all| all.index_axis(Axis(0), k).to_owned());
            let [a, b] = pair.each_ref().map(|of| self.irradiance(vertex, &of.view()));
            a.iter().zip(&b).for_each(|(a, b)| of_irradiance.add(*a, *b));
            pair[0].iter().zip(&pair[1]).for_each(|(a, b)| of_harmonics.add(*a, *b));
        }
        println!(
            "| {what} | {:.2} | {:.2} | {seconds:.1} |",
            of_irradiance.per_cent(),
            of_harmonics.per_cent()
        );
        Ok(())
    }

    /// Irradiance at `vertex` in all states and channels, of its harmonics [harmonics, states · channels].
    fn irradiance(&self, vertex: usize, harmonics: &ndarray::ArrayView2<'_, f64>) -> Vec<f64> {
        let weights = sh::irradiance(self.receivers[vertex].normal.into()).map(f64::from);
        ndarray::ArrayView1::from(&weights).dot(harmonics).to_vec()
    }

    /// What is lost by clusters and ranks (the source's Figs. 5-9 and 5-10), and by bases that move.
    fn small(&self) -> Result<()> {
        let mut clock = Clock::new();
        let arriving = Arriving::new(&self.receivers, &self.world, FACE_SIZE);
        clock.tell("visibility");
        let (gather, lights) = (self.gather(&arriving, RAYS), self.lights(FACE_SIZE)?);
        // A bake has those of a cluster only at once.
        let all = tensors(&(0..self.receivers.len()).collect::<Vec<_>>(), &gather);
        clock.tell("tensors");
        for (rounds, ranks) in [(ROUNDS, &RANKS[..]), (0, &RANKS[..WHOLE])] {
            let clusters = match rounds {
                0 => near(&self.receivers, (VERTICES, 32))?,
                _ => of_vertices(&self.receivers, &gather, &arriving, (VERTICES, 32, rounds))?,
            };
            clock.tell("clusters");
            self.clustered(&all, &clusters, &lights, ranks)?;
            clock.tell("all decompositions");
            if rounds == 0 {
                self.moving(&all, &clusters, &lights)?;
                clock.tell("moving bases");
            }
        }
        Ok(())
    }

    fn clustered(
        &self,
        all: &Array4<f32>,
        clusters: &[Vec<usize>],
        lights: &Array2<f64>,
        ranks: &[([usize; 2], Bases)],
    ) -> Result<()> {
        let sizes = || clusters.iter().map(Vec::len);
        let (least, most) = (sizes().min().unwrap_or(0), sizes().max().unwrap_or(0));
        println!(
            "\n{} vertices, {} columns, {} clusters of {least} to {most}\n",
            self.receivers.len(),
            all.dim().1,
            clusters.len()
        );
        println!("{HEAD}");
        let of = |members: &Vec<usize>| self.radiance(&lit(&all.select(Axis(0), members), lights));
        let exact: Vec<Radiance> = clusters.iter().map(of).collect();
        for (number, (ranks, bases)) in ranks.iter().enumerate() {
            let mut row = Row::new(self.receivers.len());
            let step = if number < WHOLE { 1 } else { SWEPT };
            for (members, exact) in clusters.iter().zip(&exact).step_by(step) {
                let tensors = all.select(Axis(0), members);
                let started = Instant::now();
                let small = Small::new(&tensors, *ranks, *bases)?;
                row.seconds += started.elapsed().as_secs_f64();
                row.numbers += small.numbers().iter().sum::<usize>();
                self.compare(members, &self.radiance(&small.lit(lights)), exact, &mut row);
            }
            self.print(&row, &format!("{bases:?} | {} / {}", ranks[0], ranks[1]), clusters);
        }
        Ok(())
    }

    /// Bases that move between the middles of `clusters`, of the ranks of [`MOVING`].
    fn moving(&self, all: &Array4<f32>, clusters: &[Vec<usize>], lights: &Array2<f64>) -> Result<()> {
        let (vertices, columns, texels, harmonics) = all.dim();
        let places = places(&self.receivers);
        let mean = |members: &Vec<usize>| places.select(Axis(0), members).mean_axis(Axis(0));
        let means = clusters.iter().map(mean).collect::<Option<Vec<_>>>().ok_or("an empty cluster")?;
        let centres = stack(Axis(0), &means.iter().map(|mean| mean.view()).collect::<Vec<_>>())?;
        let shares = shares(&places.view(), &centres.view(), NODES_AROUND);
        let [rank, of_light] = MOVING;
        // One basis of light for all, which some vertices tell well enough.
        let light = tucker2(&all.slice(s![..;8, .., .., ..]), MOVING)?.second;
        let started = Instant::now();
        let single = light.mapv(|x| x as f32);
        let third = columns * harmonics;
        let mut rows = Array2::<f32>::zeros((vertices, of_light * third));
        let each: Vec<_> = rows.rows_mut().into_iter().zip(all.outer_iter()).collect();
        each.into_par_iter().for_each(|(mut to, from)| {
            for (column, slice) in from.outer_iter().enumerate() {
                let at = column * harmonics * of_light;
                let values = slice.t().dot(&single);
                to.slice_mut(s![at..at + values.len()]).assign(&values.flatten());
            }
        });
        let found = moving_basis(&rows.view(), &shares, (clusters.len(), rank), TURNS)?;
        let mut row = Row::new(vertices);
        row.seconds = started.elapsed().as_secs_f64();
        row.numbers = texels * of_light + found.nodes.len() + found.coefficients.len();
        // Nodes under all lights, [nodes · rank, columns · harmonics · states].
        let nodes =
            found.nodes.mapv(f64::from).into_shape_with_order((clusters.len() * rank * third, of_light))?;
        let nodes = nodes
            .dot(&light.t().dot(lights))
            .into_shape_with_order((clusters.len() * rank, third * RADIANCES))?;
        for members in clusters {
            let exact = self.radiance(&lit(&all.select(Axis(0), members), lights));
            let mut factors = Array2::<f64>::zeros((members.len(), clusters.len() * rank));
            for (mut to, vertex) in factors.rows_mut().into_iter().zip(members) {
                let own = found.coefficients.row(*vertex).mapv(f64::from);
                for (node, share) in &shares[*vertex] {
                    to.slice_mut(s![node * rank..(node + 1) * rank]).scaled_add(f64::from(*share), &own);
                }
            }
            let shape = (members.len(), columns, harmonics, RADIANCES);
            let lit = factors.dot(&nodes).into_shape_with_order(shape)?;
            self.compare(members, &self.radiance(&lit), &exact, &mut row);
        }
        self.print(&row, &format!("Moving | {rank} / {of_light}"), clusters);
        Ok(())
    }

    fn compare(&self, members: &[usize], found: &Radiance, exact: &Radiance, row: &mut Row) {
        let irradiance = |all: &Radiance, k: usize| self.irradiance(members[k], &all.index_axis(Axis(0), k));
        let both: Vec<[Vec<f64>; 2]> = (0..members.len())
            .into_par_iter()
            .map(|k| [found, exact].map(|all| irradiance(all, k)))
            .collect();
        for (vertex, [a, b]) in members.iter().zip(both) {
            a.iter().zip(&b).for_each(|(a, b)| row.irradiance.add(*a, *b));
            row.errors[*vertex] = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        }
        let add = |(a, b): (ArrayView3<'_, f64>, ArrayView3<'_, f64>), to: &mut Squares| {
            a.iter().zip(&b).for_each(|(a, b)| to.add(*a, *b));
        };
        add((found.view(), exact.view()), &mut row.harmonics);
    }

    fn print(&self, row: &Row, what: &str, clusters: &[Vec<usize>]) {
        let vertices = row.errors.iter().filter(|errors| !errors.is_empty()).count();
        let bytes = row.numbers as f64 / vertices as f64;
        let seam = match self.jumps(&row.errors, clusters) {
            [across, inside] if vertices == row.errors.len() => format!("{:.2}", across / inside),
            _ => String::new(),
        };
        println!(
            "| {what} | {:.2} | {:.2} | {:.0} | {bytes:.0} | {seam} | {:.1} |",
            row.irradiance.per_cent(),
            row.harmonics.per_cent(),
            2.0 * bytes,
            1000.0 * row.seconds / vertices as f64
        );
    }

    /// Root mean square of what errors of irradiance differ by along edges of triangles between clusters and
    /// within.
    fn jumps(&self, errors: &[Vec<f64>], clusters: &[Vec<usize>]) -> [f64; 2] {
        let mut cluster_of = vec![0; errors.len()];
        clusters.iter().enumerate().for_each(|(c, members)| members.iter().for_each(|v| cluster_of[*v] = c));
        let triangles = triangles(self.scene);
        let edges: BTreeSet<[u32; 2]> = triangles
            .iter()
            .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]].map(|[a, b]| [*a.min(b), *a.max(b)]))
            .collect();
        let mut sums = [[0.0; 2]; 2];
        for [a, b] in edges.into_iter().map(|edge| edge.map(|vertex| vertex as usize)) {
            // Nothing, where clusters were left out.
            let jump: f64 = errors[a].iter().zip(&errors[b]).map(|(a, b)| (a - b) * (a - b)).sum();
            let [sum, count] = &mut sums[usize::from(cluster_of[a] == cluster_of[b])];
            (*sum, *count) = (*sum + jump, *count + 1.0);
        }
        sums.map(|[sum, count]| (sum / count).sqrt())
    }
}

/// A row of the table.
struct Row {
    irradiance: Squares,
    harmonics: Squares,
    /// By vertex, of irradiance in all states.
    errors: Vec<Vec<f64>>,
    numbers: usize,
    seconds: f64,
}

impl Row {
    fn new(vertices: usize) -> Self {
        let (irradiance, harmonics) = (Squares::default(), Squares::default());
        Self { irradiance, harmonics, errors: vec![Vec::new(); vertices], numbers: 0, seconds: 0.0 }
    }
}

/// Tells what took how long.
struct Clock(Instant);

impl Clock {
    fn new() -> Self {
        Self(Instant::now())
    }

    fn tell(&mut self, what: &str) {
        println!("\n{what}: {:.1} s", self.0.elapsed().as_secs_f64());
        self.0 = Instant::now();
    }
}
