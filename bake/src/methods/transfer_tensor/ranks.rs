//! How many functions and vectors of clusters reflected light is stored by: what fewer of them leave out, at some vertices
//! of every cluster, under the held-out lights and by random materials; and the smallest file that keeps all errors
//! together below a bound.

use super::bake::columns_of;
use super::classes::{Classes, pair_weight};
use super::packed::{LIGHTS, RANKS, SECOND_RANK};
use super::settings::materials_of_vertices;
use super::sizes::Sizes;
use super::spaces::Columns;
use super::stages::{OncePiece, TwicePiece};
use crate::compress::statistics::worst;
use crate::error::{BakeError, Result};
use crate::methods::sparse_transfer::{Errors, Terms};
use crate::methods::spread::spread;
use crate::methods::transfer_images::held_out::random_state;
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES};
use crate::trace::receivers::Receiver;
use half::f16;
use ndarray::{Array2, ArrayView2, s};
use relume_formats::Place;
use relume_formats::basis::sh;
use relume_formats::kinds::transfer_tensor::{Once, Twice};
use relume_formats::kinds::{BrdfTensor, Environment};
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use std::f64::consts::{PI, TAU};

/// Vertices of a cluster whose tensors are kept whole until ranks are chosen.
pub const SAMPLED: usize = 6;
/// Functions of vertices, functions of light, and vectors that a file may have; the last are those of the pieces.
const OF_VERTICES: [usize; 6] = [8, 12, 16, 20, 24, RANKS[0]];
const OF_LIGHT: [usize; 4] = [8, 16, 24, RANKS[1]];
const VECTORS: [usize; 4] = [4, 8, 12, SECOND_RANK];
/// What rounding direct light to bytes may add to an error, as a factor.
const ROUNDING: f64 = 1.05;

/// The members of a cluster of so many at which errors are measured.
pub fn sampled(members: usize) -> Vec<usize> {
    spread(SAMPLED, members)
}

/// States that errors are measured in, and what vertices make of light in them.
pub struct States<'a> {
    receivers: &'a [Receiver],
    /// By vertex, whether its material may reflect more than irradiance tells.
    shines: Vec<bool>,
    /// By state, what each source counts for.
    weights: Vec<Vec<Rgb>>,
    pairs: Vec<[usize; 2]>,
    /// Haar coefficients of the lights of one reflection and of two, [coefficients, [`RADIANCES`]].
    lights: [Array2<f32>; 2],
}

/// What is left out with each of some choices.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried<T> {
    /// The choices, the last leaving out least.
    pub choices: Vec<T>,
    /// Sums over `vertices` of squared errors of each, by state.
    pub squares: Vec<Errors>,
    /// How many vertices.
    pub vertices: usize,
}

/// What a file has of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// Terms of direct light.
    pub terms: usize,
    /// Functions of vertices and of light; 0 where nothing is reflected again.
    pub ranks: [usize; 2],
    /// Vectors; 0 where there is no second reflection.
    pub vectors: usize,
    /// Errors of reflected light by these, in parts of what direct light has errors in parts of.
    pub reflected: Errors,
}

impl<'a> States<'a> {
    /// Those of `scene`.
    ///
    /// # Errors
    /// If a material is of a model without a basis.
    pub fn new(
        (scene, receivers): (&Scene, &'a [Receiver]),
        classes: &Classes,
        spaces: &[BrdfTensor],
        environments: &[Environment],
    ) -> Result<Self> {
        let of_state = |state: usize| classes.weights(&random_state(state as u32, scene));
        let weights: Option<Vec<_>> = (0..STATES).map(of_state).collect();
        let strange = || BakeError::invalid(&Place::file(&scene.file), "a material that varies has no basis");
        let columns: Vec<Columns> =
            (0..scene.materials.len()).map(|material| columns_of(scene, material, spaces)).collect();
        let materials = materials_of_vertices(scene);
        Ok(Self {
            receivers,
            shines: materials.iter().map(|material| columns[*material].count() > 1).collect(),
            weights: weights.ok_or_else(strange)?,
            pairs: classes.pairs(),
            lights: LIGHTS.map(|coefficients| {
                let lights =
                    HeldOutLights::new(environments, ((coefficients / 6) as f64).sqrt() as usize, true);
                // Those of the whole maps are behind those without suns.
                Array2::from_shape_fn((coefficients, RADIANCES), |(k, state)| {
                    lights.coefficients[(coefficients + k) * RADIANCES + state]
                })
            }),
        })
    }

    /// Squared error at `vertex` where what arrives is `off` by these harmonics, [16, [`RADIANCES`]]: of what a white
    /// diffuse surface shows; where the material may shine, of one that is half that and half a mirror seen from anywhere.
    fn squares(&self, vertex: usize, off: &Array2<f32>) -> Errors {
        let normal = self.receivers[vertex].normal.into();
        let irradiance = ArrayView2::from(&sh::irradiance(normal).map(|weight| [weight])).t().dot(off);
        let of = |column: usize| {
            let diffuse = (f64::from(irradiance[[0, column]]) / PI).powi(2);
            let mirrored: f64 = off.column(column).iter().map(|x| f64::from(*x).powi(2)).sum();
            if self.shines[vertex] { 0.25 * (diffuse + mirrored / TAU) } else { diffuse }
        };
        std::array::from_fn(|state| (0..3).map(|channel| of(3 * state + channel)).sum())
    }

    /// What `source` counts for, by column of [`RADIANCES`].
    fn weight(&self, source: usize, column: usize) -> f32 {
        self.weights[column / 3][source][column % 3]
    }
}

impl Tried<[usize; 2]> {
    /// Nothing measured yet.
    pub fn once() -> Self {
        let choices: Vec<_> = OF_VERTICES.into_iter().flat_map(|m| OF_LIGHT.map(|n| [m, n])).collect();
        Self { squares: vec![[0.0; STATES]; choices.len()], choices, vertices: 0 }
    }

    /// Measures `piece`, of a cluster of `members`.
    pub fn add(&mut self, piece: &OncePiece, members: &[usize], states: &States<'_>) {
        let ([m, n], light) = (RANKS, &states.lights[0]);
        let sources = piece.light.len() / (n * LIGHTS[0]);
        let samples = sampled(members.len());
        let mut exact = vec![Array2::<f32>::zeros((sh::COUNT, RADIANCES)); samples.len()];
        let each = piece.sampled.chunks_exact(LIGHTS[0] * sh::COUNT);
        for (at, tensor) in each.enumerate() {
            let tensor = matrix(tensor, [LIGHTS[0], sh::COUNT]);
            add_weighted(&mut exact[at / sources], &tensor.t().dot(light), |k| {
                states.weight(at % sources, k)
            });
        }
        // What is still missing with so many functions of vertices, for each number of those of light.
        let mut missing = vec![exact; OF_LIGHT.len()];
        let mut cores = vec![vec![Array2::<f32>::zeros((m * sh::COUNT, RADIANCES)); sources]; OF_LIGHT.len()];
        for source in 0..sources {
            let lit =
                matrix(&piece.light[source * n * LIGHTS[0]..][..n * LIGHTS[0]], [n, LIGHTS[0]]).dot(light);
            for function in 0..m {
                let at = (source * m + function) * n * sh::COUNT;
                let core = matrix(&piece.core[at..][..n * sh::COUNT], [n, sh::COUNT]);
                for (of_light, cores) in OF_LIGHT.into_iter().zip(&mut cores) {
                    let core = core.slice(s![..of_light, ..]);
                    let sum = core.t().dot(&lit.slice(s![..of_light, ..]));
                    let mut to =
                        cores[source].slice_mut(s![function * sh::COUNT..(function + 1) * sh::COUNT, ..]);
                    to.assign(&sum);
                }
            }
        }
        for (step, of_vertices) in OF_VERTICES.into_iter().enumerate() {
            let first = if step == 0 { 0 } else { OF_VERTICES[step - 1] };
            for (of_light, (missing, cores)) in missing.iter_mut().zip(&cores).enumerate() {
                for (missing, member) in missing.iter_mut().zip(&samples) {
                    for (source, core) in cores.iter().enumerate() {
                        for function in first..of_vertices {
                            let share = piece.shares[(member * sources + source) * m + function];
                            let share = -f32::from(share) / 127.0;
                            let core = core.slice(s![function * sh::COUNT..(function + 1) * sh::COUNT, ..]);
                            add_weighted(missing, &core, |k| share * states.weight(source, k));
                        }
                    }
                    let squares = states.squares(members[*member], missing);
                    add(&mut self.squares[step * OF_LIGHT.len() + of_light], &squares);
                }
            }
        }
        self.vertices += samples.len();
    }
}

impl Tried<usize> {
    /// Nothing measured yet.
    pub fn twice() -> Self {
        Self { choices: VECTORS.to_vec(), squares: vec![[0.0; STATES]; VECTORS.len()], vertices: 0 }
    }

    /// Measures `piece`, of a cluster of so many members.
    pub fn add(&mut self, piece: &TwicePiece, members: usize, states: &States<'_>) {
        let (light, pairs) = (&states.lights[1], states.pairs.len());
        let samples = sampled(members);
        let weight = |pair: usize, k: usize| pair_weight(states.pairs[pair], &states.weights[k / 3])[k % 3];
        let shown = |values: &[f16]| -> Vec<f32> {
            let lit = matrix(values, [LIGHTS[1], pairs]).t().dot(light);
            let of = |k: usize| (0..pairs).map(|pair| weight(pair, k) * lit[[pair, k]]).sum();
            (0..RADIANCES).map(of).collect()
        };
        let vectors: Vec<_> = piece.vectors.chunks_exact(LIGHTS[1] * pairs).map(shown).collect();
        let exact = piece.sampled.chunks_exact(LIGHTS[1] * pairs).map(shown);
        for (member, mut missing) in samples.iter().zip(exact) {
            let shares = &piece.shares[member * SECOND_RANK..][..SECOND_RANK];
            for (number, (share, vector)) in shares.iter().zip(&vectors).enumerate() {
                let share = f32::from(*share) / 127.0;
                missing.iter_mut().zip(vector).for_each(|(missing, value)| *missing -= share * value);
                if let Some(step) = VECTORS.iter().position(|vectors| *vectors == number + 1) {
                    let squares = missing
                        .as_chunks::<3>()
                        .0
                        .iter()
                        .map(|rgb| rgb.map(|x| f64::from(x).powi(2)).iter().sum());
                    self.squares[step]
                        .iter_mut()
                        .zip(squares)
                        .for_each(|(sum, square): (_, f64)| *sum += square);
                }
            }
        }
        self.vertices += samples.len();
    }
}

impl<T: Copy> Tried<T> {
    /// Mean squared errors in parts of `norm`, of each choice; of nothing where nothing was measured.
    fn relative(&self, norm: &Errors, nothing: T) -> Vec<(T, Errors)> {
        if self.vertices == 0 {
            return vec![(nothing, [0.0; STATES])];
        }
        let relative = |squares: &Errors| {
            std::array::from_fn(|state| squares[state] / self.vertices as f64 / norm[state])
        };
        self.choices.iter().copied().zip(self.squares.iter().map(relative)).collect()
    }
}

/// The smallest file whose errors, direct light's `by_terms` and reflected light's `once` and `twice` together, are as `terms` wants
/// in every state. `squares` are the mean ones of what errors are in parts of. Where reflected light alone is beyond that, or
/// a number of terms is wanted, there is as much of it as was made, and of direct light what it needs by itself.
pub fn choose(
    by_terms: &[Errors],
    (once, twice): (&Tried<[usize; 2]>, &Tried<usize>),
    squares: &Errors,
    sizes: &Sizes,
    terms: Terms,
) -> Choice {
    let (once, twice) = (once.relative(squares, [0; 2]), twice.relative(squares, 0));
    let choice = |(ranks, of_once): &([usize; 2], Errors), (vectors, of_twice): &(usize, Errors)| Choice {
        terms: terms.of(by_terms),
        ranks: *ranks,
        vectors: *vectors,
        reflected: std::array::from_fn(|state| (of_once[state] + of_twice[state]).sqrt()),
    };
    let bytes = |choice: &Choice| {
        sizes.of_terms(choice.terms) + sizes.of_ranks(choice.ranks) + sizes.of_vectors(choice.vectors)
    };
    let all = once.iter().flat_map(|once| twice.iter().map(|twice| choice(once, twice)));
    let most = all.clone().last();
    let fitting = all.filter_map(|choice| {
        let Terms::Error(max) = terms else { return None };
        let fits = |direct: &Errors| worst(&together(direct, &choice.reflected)) * ROUNDING <= max;
        Some(Choice { terms: 1 + by_terms.iter().position(fits)?, ..choice })
    });
    let smallest = fitting.min_by(|a, b| bytes(a).total_cmp(&bytes(b)));
    smallest.or(most).unwrap_or(Choice {
        terms: terms.of(by_terms),
        ranks: [0; 2],
        vectors: 0,
        reflected: [0.0; STATES],
    })
}

/// Errors that have nothing to do with each other, of both together.
pub fn together(direct: &Errors, reflected: &Errors) -> Errors {
    std::array::from_fn(|state| direct[state].hypot(reflected[state]))
}

/// `once` with ranks `to` in place of `from`.
pub fn cut_once(once: &Once, from: [usize; 2], to: [usize; 2]) -> Once {
    let Once { clusters, shares, core, light } = once;
    let [of_light, of_core] = [LIGHTS[0], from[1] * sh::COUNT];
    let cores = core.chunks_exact(from[0] * of_core).map(|core| &core[..to[0] * of_core]);
    Once {
        clusters: clusters.clone(),
        shares: firsts(shares, from[0], to[0]),
        core: cores.flat_map(|core| firsts(core, of_core, to[1] * sh::COUNT)).collect(),
        light: firsts(light, from[1] * of_light, to[1] * of_light),
    }
}

/// `twice` of so many clusters with fewer vectors, \[before, after\].
pub fn cut_twice(twice: &Twice, clusters: usize, [from, to]: [usize; 2]) -> Twice {
    let vector = twice.vectors.len() / (clusters * from).max(1);
    Twice {
        shares: firsts(&twice.shares, from, to),
        vectors: firsts(&twice.vectors, from * vector, to * vector),
    }
}

/// The first `kept` of every `of`.
fn firsts<T: Copy>(values: &[T], of: usize, kept: usize) -> Vec<T> {
    values.chunks_exact(of.max(1)).flat_map(|chunk| &chunk[..kept]).copied().collect()
}

fn matrix(values: &[f16], shape: [usize; 2]) -> Array2<f32> {
    Array2::from_shape_fn(shape, |(row, column)| values[row * shape[1] + column].to_f32())
}

/// Adds `from`, [16, [`RADIANCES`]], each column by its weight.
fn add_weighted<S: ndarray::Data<Elem = f32>>(
    to: &mut Array2<f32>,
    from: &ndarray::ArrayBase<S, ndarray::Ix2>,
    weight: impl Fn(usize) -> f32,
) {
    for ((mut to, from), weight) in to.columns_mut().into_iter().zip(from.columns()).zip((0..).map(weight)) {
        to.scaled_add(weight, &from);
    }
}

fn add(sums: &mut Errors, squares: &Errors) {
    sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
}

#[cfg(test)]
mod tests;
