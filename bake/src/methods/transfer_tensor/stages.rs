//! The stages of a bake: what vertices see, and the light that reaches the vertices of a cluster after one and after two
//! reflections. Nothing in their logs depends on a map.

use super::packed::{Packed, PackedSecond, RANKS, SECOND_RANK, coarse, whole};
use super::ranks::sampled;
use super::second::Second;
use super::settings::{NAME, REVISION, Settings};
use super::{Arriving, Classes, Gather, cluster};
use crate::compress::frame::{grow, shrink};
use crate::error::Result;
use crate::methods::receiver_pieces::Pieces;
use crate::methods::sparse_transfer::texels::Texels;
use crate::methods::sparse_transfer::visibility::{encode, look};
use crate::scene_hash::{Part, hash_of};
use crate::stage::Stage;
use crate::trace::receivers::Receiver;
use crate::trace::world::World;
use crate::work_log::WorkLog;
use half::f16;
use ndarray::{Array3, Axis};
use relume_formats::Error;
use relume_formats::basis::sh;
use relume_formats::kinds::transfer_tensor::{ONCE_LIGHT, TWICE_LIGHT};
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// What runs a stage: the log that has all pieces, or `None` if others make some.
pub type Run<'a> = &'a dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>;

/// The key of the stage called `name`, which reads `parts` of the scene beside its meshes.
fn key(scene: &Scene, name: &str, parts: &[Part], settings: &str) -> u128 {
    let reads = hash_of(scene, &[&[Part::Geometry, Part::Textures][..], parts].concat());
    xxh3_128(format!("{reads:032x} {name} {settings} {REVISION}").as_bytes())
}

/// What vertices see of the environment, as [`rows_of`](crate::methods::sparse_transfer::visibility::rows_of) reads it.
///
/// # Errors
/// If the log cannot be written, or the user interrupts.
pub fn seen(
    scene: &Scene,
    (world, receivers): (&World, &[Receiver]),
    texels: &Texels,
    settings: &Settings,
    run: Run<'_>,
) -> Result<Option<WorkLog>> {
    let bytes = |receivers: &[Receiver]| {
        let seen = receivers.iter().map(|receiver| look(receiver, world, texels));
        Ok(encode(&seen.collect::<Vec<_>>())?)
    };
    let key = key(scene, NAME, &[], &settings.rays_per_texel.to_string());
    run(&Pieces { receivers, name: NAME.to_owned(), label: "tracing", key, bytes })
}

/// Light after one reflection, a piece for each cluster.
pub struct Once<'a> {
    gather: Gather<'a>,
    clusters: &'a [Vec<usize>],
    key: u128,
}

/// A piece of it.
pub struct OncePiece {
    /// [members, sources, M], in 127ths.
    pub shares: Vec<i8>,
    /// [sources, M, N, 16].
    pub core: Vec<f16>,
    /// [sources, N, 384].
    pub light: Vec<f16>,
    /// [members, 16, sources, 24].
    pub coarse: Vec<f16>,
    /// The tensors of [`sampled`] members, [some members, sources, 384 Haar coefficients, 16].
    pub sampled: Vec<f16>,
}

impl<'a> Once<'a> {
    /// For the `clusters` of the vertices of `scene`, under what arrives at them.
    pub fn new(
        scene: &'a Scene,
        places: (&'a World, &'a [Receiver]),
        (arriving, classes): (&'a Arriving, &'a Classes),
        clusters: &'a [Vec<usize>],
        settings: &Settings,
    ) -> Self {
        let name = format!("{NAME}-once");
        let of_settings = format!("{} {} {}", settings.rays_per_texel, settings.samples, settings.seed);
        let gather = Gather::new(scene, places, arriving, classes, settings.seed).with_rays(settings.samples);
        Self { gather, clusters, key: key(scene, &name, &[Part::Surfaces], &of_settings) }
    }

    fn sizes(&self, members: usize) -> [usize; 5] {
        let ([sources, ..], [m, n]) = (self.gather.shape(), RANKS);
        let some = sampled(members).len();
        [
            members * sources * m,
            sources * m * n * sh::COUNT,
            sources * n * ONCE_LIGHT,
            members * sh::COUNT * sources * TWICE_LIGHT,
            some * sources * ONCE_LIGHT * sh::COUNT,
        ]
    }

    /// Piece number `number` of `log`.
    ///
    /// # Errors
    /// If it cannot be read, or is of other clusters.
    pub fn read(&self, log: &WorkLog, number: usize) -> Result<OncePiece> {
        let [shares, core, light, coarse, some] = self.sizes(self.clusters.get(number).map_or(0, Vec::len));
        let bytes = opened(log, number, shares + 2 * (core + light + coarse + some))?;
        let (shares, rest) = bytes.split_at(shares);
        let (of_core, rest) = rest.split_at(2 * core);
        let (of_light, rest) = rest.split_at(2 * light);
        let (of_coarse, of_some) = rest.split_at(2 * coarse);
        Ok(OncePiece {
            shares: shares.iter().map(|byte| *byte as i8).collect(),
            core: halves_of(of_core),
            light: halves_of(of_light),
            coarse: halves_of(of_coarse),
            sampled: halves_of(of_some),
        })
    }
}

impl Stage for Once<'_> {
    fn name(&self) -> String {
        format!("{NAME}-once")
    }

    fn label(&self) -> Option<&'static str> {
        Some("bouncing")
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        self.clusters.len() as u32
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let members = self.clusters.get(number as usize).map_or(&[][..], Vec::as_slice);
        let tensors = cluster::tensors(members, &self.gather);
        let packed = Packed::new(&tensors, RANKS)?;
        let mut shares = packed.u.view();
        shares.swap_axes(0, 1);
        let mut bytes: Vec<u8> = shares.iter().map(|share| (127.0 * share).round() as i8 as u8).collect();
        let rounded = |value: &f32| f16::from_f32(*value).to_le_bytes();
        bytes.extend(packed.core.iter().chain(&packed.light).flat_map(rounded));
        for tensor in tensors.axis_iter(Axis(0)) {
            bytes.extend(coarse(&tensor).into_iter().flat_map(f16::to_le_bytes));
        }
        for member in sampled(members.len()) {
            bytes.extend(whole(&tensors.index_axis(Axis(0), member)).flat_map(f16::to_le_bytes));
        }
        Ok(shrink(&bytes)?)
    }

    fn keeps_log(&self) -> bool {
        true
    }
}

/// Light after two reflections, a piece for each cluster.
pub struct Twice<'a> {
    second: Second<'a>,
    pairs: usize,
    clusters: &'a [Vec<usize>],
    key: u128,
}

/// A piece of it.
pub struct TwicePiece {
    /// [members, vectors], in 127ths.
    pub shares: Vec<i8>,
    /// [vectors, 24, pairs].
    pub vectors: Vec<f16>,
    /// The tensors of [`sampled`] members, [some members, 24, pairs].
    pub sampled: Vec<f16>,
}

impl<'a> Twice<'a> {
    /// Behind `once`, whose light by its coarse texels, [vertices, 16, sources, 24], is `coarse`.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn new(
        scene: &'a Scene,
        places: (&'a World, &'a [Receiver]),
        classes: &'a Classes,
        coarse: &'a [f16],
        once: &Once<'a>,
        settings: &Settings,
    ) -> Result<Self> {
        let second = Second::new(scene, places, classes, coarse, settings.seed)?;
        let key = xxh3_128(format!("{:032x} twice {REVISION}", once.key).as_bytes());
        Ok(Self { second, pairs: classes.pairs().len(), clusters: once.clusters, key })
    }

    /// Piece number `number` of `log`.
    ///
    /// # Errors
    /// If it cannot be read, or is of other clusters.
    pub fn read(&self, log: &WorkLog, number: usize) -> Result<TwicePiece> {
        let members = self.clusters.get(number).map_or(0, Vec::len);
        let (shares, tensor) = (SECOND_RANK * members, TWICE_LIGHT * self.pairs);
        let some = sampled(members).len();
        let bytes = opened(log, number, shares + 2 * (SECOND_RANK + some) * tensor)?;
        let (shares, rest) = bytes.split_at(shares);
        let (vectors, some) = rest.split_at(2 * SECOND_RANK * tensor);
        Ok(TwicePiece {
            shares: shares.iter().map(|byte| *byte as i8).collect(),
            vectors: halves_of(vectors),
            sampled: halves_of(some),
        })
    }
}

impl Stage for Twice<'_> {
    fn name(&self) -> String {
        format!("{NAME}-twice")
    }

    fn label(&self) -> Option<&'static str> {
        Some("bouncing again")
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        self.clusters.len() as u32
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let members = self.clusters.get(number as usize).map_or(&[][..], Vec::as_slice);
        let mut tensors = Array3::zeros((members.len(), self.pairs, TWICE_LIGHT));
        for (mut tensor, vertex) in tensors.outer_iter_mut().zip(members) {
            if let Some(values) = tensor.as_slice_mut() {
                self.second.tensor(*vertex, values);
            }
        }
        let packed = PackedSecond::new(&tensors.view())?;
        let mut bytes: Vec<u8> = packed.u.iter().map(|share| (127.0 * share).round() as i8 as u8).collect();
        let rounded = |value: &f32| f16::from_f32(*value).to_le_bytes();
        bytes.extend(packed.vectors.iter().flat_map(rounded));
        for member in sampled(members.len()) {
            bytes.extend(tensors.index_axis(Axis(0), member).t().iter().flat_map(rounded));
        }
        Ok(shrink(&bytes)?)
    }

    fn keeps_log(&self) -> bool {
        true
    }
}

/// The bytes of a piece, which are to be `length`.
fn opened(log: &WorkLog, number: usize, length: usize) -> Result<Vec<u8>> {
    let bytes = grow(&log.read(number as u32)?, length).filter(|bytes| bytes.len() == length);
    let refuse = || -> Error { log.refuse("holds light of other clusters; bake again with --force") };
    Ok(bytes.ok_or_else(refuse)?)
}

fn halves_of(bytes: &[u8]) -> Vec<f16> {
    bytes.as_chunks().0.iter().map(|pair| f16::from_le_bytes(*pair)).collect()
}
