//! How many functions and vectors of clusters reflected light is stored by: what fewer of them leave out, at
//! some vertices of every cluster, under the held-out lights and by random materials; and the smallest file
//! that keeps all errors together below a bound.

use super::bake::columns_of;
use super::classes::{Classes, pair_weight};
use super::packed::{LIGHTS, RANKS, SECOND_RANK};
use super::settings::materials_of_vertices;
use super::sizes::Sizes;
use super::spaces::Columns;
use super::stages::{OncePiece, TwicePiece};
use crate::error::{BakeError, Result};
use crate::methods::sparse_transfer::{Errors, Terms, keeps};
use crate::methods::spread::spread;
use crate::methods::transfer_images::held_out::random_state;
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES};
use crate::trace::receivers::Receiver;
use half::f16;
use ndarray::{Array1, Array2, ArrayView2, Axis};
use relume_formats::Place;
use relume_formats::basis::cubemap::FACES;
use relume_formats::basis::sh;
use relume_formats::kinds::transfer_tensor::{Once, Twice};
use relume_formats::kinds::{BrdfTensor, Environment};
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use std::f64::consts::{PI, TAU};

/// Vertices of a cluster whose tensors are kept whole until ranks are chosen.
pub const SAMPLED: usize = 6;
/// Functions of vertices, functions of light, and vectors that a file may have; the last are those of the
/// pieces.
const OF_VERTICES: [usize; 6] = [8, 12, 16, 20, 24, RANKS[0]];
const OF_LIGHT: [usize; 4] = [8, 16, 24, RANKS[1]];
const VECTORS: [usize; 4] = [4, 8, 12, SECOND_RANK];

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
                let lights = HeldOutLights::new(environments, (coefficients / FACES).isqrt(), true);
                // Those of the whole maps are behind those without suns.
                Array2::from_shape_fn((coefficients, RADIANCES), |(k, state)| {
                    lights.coefficients[(coefficients + k) * RADIANCES + state]
                })
            }),
        })
    }

    /// Squared error at `vertex` where what arrives is `off` by these harmonics, [16, [`RADIANCES`]]: of what a
    /// white diffuse surface shows; where the material may shine, of one that is half that and half a mirror
    /// seen from anywhere.
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

    /// What `source` counts for, [[`RADIANCES`]].
    fn weights_of(&self, source: usize) -> Array1<f32> {
        self.weights.iter().flat_map(|weights| weights[source]).collect()
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
        let samples = sampled(members.len());
        let arriving = arriving(piece, states);
        for (column, of_light) in OF_LIGHT.into_iter().enumerate() {
            let cores = lit_cores(piece, of_light, states);
            for (member, arriving) in samples.iter().zip(&arriving) {
                let (mut missing, mut left) = (arriving.clone(), cores.iter().enumerate());
                for (row, of_vertices) in OF_VERTICES.into_iter().enumerate() {
                    let known = if row == 0 { 0 } else { OF_VERTICES[row - 1] };
                    for (function, cores) in left.by_ref().take(of_vertices - known) {
                        for (source, core) in cores.iter().enumerate() {
                            let at = (member * cores.len() + source) * RANKS[0] + function;
                            missing.scaled_add(-f32::from(piece.shares[at]) / 127.0, core);
                        }
                    }
                    let squares = states.squares(members[*member], &missing);
                    add(&mut self.squares[row * OF_LIGHT.len() + column], &squares);
                }
            }
        }
        self.vertices += samples.len();
    }
}

/// What arrives at the [`sampled`] members of `piece`, of all sources together, [16, [`RADIANCES`]] each.
fn arriving(piece: &OncePiece, states: &States<'_>) -> Vec<Array2<f32>> {
    let of_source = LIGHTS[0] * sh::COUNT;
    let of_member = |tensors: &[f16]| {
        let mut all = Array2::zeros((sh::COUNT, RADIANCES));
        for (source, tensor) in tensors.chunks_exact(of_source).enumerate() {
            let lit = matrix(tensor, [LIGHTS[0], sh::COUNT]).t().dot(&states.lights[0]);
            all += &(lit * &states.weights_of(source));
        }
        all
    };
    piece.sampled.chunks_exact(of_source * states.weights[0].len()).map(of_member).collect()
}

/// The same of the functions of vertices of `piece`, by `of_light` functions of light, [functions][sources].
fn lit_cores(piece: &OncePiece, of_light: usize, states: &States<'_>) -> Vec<Vec<Array2<f32>>> {
    let [m, n] = RANKS;
    let lit =
        |light: &[f16]| matrix(&light[..of_light * LIGHTS[0]], [of_light, LIGHTS[0]]).dot(&states.lights[0]);
    let lit: Vec<_> = piece.light.chunks_exact(n * LIGHTS[0]).map(lit).collect();
    let core = |function: usize, source: usize| {
        let core = &piece.core[(source * m + function) * n * sh::COUNT..][..of_light * sh::COUNT];
        matrix(core, [of_light, sh::COUNT]).t().dot(&lit[source]) * &states.weights_of(source)
    };
    (0..m).map(|function| (0..lit.len()).map(|source| core(function, source)).collect()).collect()
}

impl Tried<usize> {
    /// Nothing measured yet.
    pub fn twice() -> Self {
        Self { choices: VECTORS.to_vec(), squares: vec![[0.0; STATES]; VECTORS.len()], vertices: 0 }
    }

    /// Measures `piece`, of a cluster of so many members.
    pub fn add(&mut self, piece: &TwicePiece, members: usize, states: &States<'_>) {
        let (pairs, samples) = (states.pairs.len(), sampled(members));
        let weight = |pair: usize, k: usize| pair_weight(states.pairs[pair], &states.weights[k / 3])[k % 3];
        let weights = Array2::from_shape_fn((pairs, RADIANCES), |(pair, k)| weight(pair, k));
        let shown = |tensor: &[f16]| -> Array1<f32> {
            let lit = matrix(tensor, [LIGHTS[1], pairs]).t().dot(&states.lights[1]);
            (lit * &weights).sum_axis(Axis(0))
        };
        let vectors: Vec<_> = piece.vectors.chunks_exact(LIGHTS[1] * pairs).map(shown).collect();
        let exact = piece.sampled.chunks_exact(LIGHTS[1] * pairs).map(shown);
        for (member, mut missing) in samples.iter().zip(exact) {
            let shares = &piece.shares[member * SECOND_RANK..][..SECOND_RANK];
            for (number, (share, vector)) in shares.iter().zip(&vectors).enumerate() {
                missing.scaled_add(-f32::from(*share) / 127.0, vector);
                if let Some(step) = VECTORS.iter().position(|vectors| *vectors == number + 1) {
                    let square =
                        |state: usize| (0..3).map(|c| f64::from(missing[3 * state + c]).powi(2)).sum();
                    add(&mut self.squares[step], &std::array::from_fn(square));
                }
            }
        }
        self.vertices += samples.len();
    }
}

impl<T: Copy> Tried<T> {
    /// Mean squared errors in parts of `norm`, of each choice; `nothing` where nothing was measured, and NaN under
    /// lights that show nothing, as direct light has it.
    fn relative(&self, norm: &Errors, nothing: T) -> Vec<(T, Errors)> {
        if self.vertices == 0 {
            return vec![(nothing, [0.0; STATES])];
        }
        let whole = norm.map(|norm| if norm > 0.0 { norm * self.vertices as f64 } else { f64::NAN });
        let relative = |squares: &Errors| std::array::from_fn(|state| squares[state] / whole[state]);
        self.choices.iter().copied().zip(self.squares.iter().map(relative)).collect()
    }
}

/// The smallest file whose errors, direct light's `by_terms` and reflected light's `once` and `twice` together,
/// are as `terms` wants in every state. `norm` is the mean square of what errors are in parts of. Where reflected
/// light alone is beyond that, or a number of terms is wanted, there is as much of it as was made, and of direct
/// light what it needs by itself.
pub fn choose(
    by_terms: &[Errors],
    (once, twice): (&Tried<[usize; 2]>, &Tried<usize>),
    norm: &Errors,
    sizes: &Sizes,
    terms: Terms,
) -> Choice {
    let (once, twice) = (once.relative(norm, [0; 2]), twice.relative(norm, 0));
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
    let most = choice(&once[once.len() - 1], &twice[twice.len() - 1]);
    let fitting = all.filter_map(|choice| {
        let Terms::Error(max) = terms else { return None };
        let fits = |direct: &Errors| keeps(&together(direct, &choice.reflected), max);
        Some(Choice { terms: 1 + by_terms.iter().position(fits)?, ..choice })
    });
    fitting.min_by(|a, b| bytes(a).total_cmp(&bytes(b))).unwrap_or(most)
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

fn add(sums: &mut Errors, squares: &Errors) {
    sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
}

#[cfg(test)]
mod tests;
