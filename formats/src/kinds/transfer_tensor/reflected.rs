//! Light that arrives by way of other surfaces.

use crate::state::Rgb;
use half::f16;
use serde::{Deserialize, Serialize};

/// Number of sections of light reflected once.
pub const ONCE_SECTIONS: usize = 4;
/// The same of light reflected twice.
pub const TWICE_SECTIONS: usize = 2;

/// What reflected light: a function of a material, or the fixed materials together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// Index of the material in the scene; `None` for the fixed ones.
    pub material: Option<u32>,
    /// Which function of kind `brdf-basis`; 0 for the fixed ones.
    pub basis: u32,
    /// The channel that this is alone for, if what reflects has colours of its own; else it is for all three.
    pub channel: Option<u32>,
}

/// Light reflected once before it arrives.
#[derive(Debug, Clone, PartialEq)]
pub struct Once {
    /// The cluster of each vertex.
    pub clusters: Vec<u16>,
    /// Row-major [vertices, sources, M], in 127ths.
    pub shares: Vec<i8>,
    /// Row-major [clusters, sources, M, N, 16].
    pub core: Vec<f16>,
    /// Row-major [clusters, sources, N, [`super::ONCE_LIGHT`]].
    pub light: Vec<f16>,
}

/// Light reflected twice: irradiance over π.
#[derive(Debug, Clone, PartialEq)]
pub struct Twice {
    /// Row-major [vertices, vectors], in 127ths.
    pub shares: Vec<i8>,
    /// Row-major [clusters, vectors, [`super::TWICE_LIGHT`], pairs].
    pub vectors: Vec<f16>,
}

impl Source {
    pub(super) fn fault(&self) -> Option<String> {
        let strange =
            self.channel.is_some_and(|channel| channel > 2) || (self.material.is_none() && self.basis > 0);
        strange.then(|| format!("{self:?} is no source of reflected light"))
    }

    /// What this counts for in each channel if it counts for `weight` by its material.
    fn alone(&self, weight: Rgb) -> Rgb {
        std::array::from_fn(
            |c| if self.channel.is_none_or(|only| only as usize == c) { weight[c] } else { 0.0 },
        )
    }

    /// Whether light can be reflected by both, one after the other, in one channel.
    fn meets(&self, other: &Self) -> bool {
        self.channel.is_none() || other.channel.is_none() || self.channel == other.channel
    }
}

/// The pairs of `sources` that can reflect one after the other, the one nearer to the light first.
pub fn pairs(sources: &[Source]) -> Vec<[usize; 2]> {
    let indices = 0..sources.len();
    let all = indices.clone().flat_map(|first| indices.clone().map(move |second| [first, second]));
    all.filter(|[first, second]| sources[*first].meets(&sources[*second])).collect()
}

/// What each of `sources` counts for in each channel, where `coefficients` gives those of a material, by index, on the
/// functions of the basis.
pub fn weights(sources: &[Source], coefficients: impl Fn(u32) -> Option<Vec<Rgb>>) -> Vec<Rgb> {
    let weight = |source: &Source| {
        let of_material = source.material.and_then(|material| {
            coefficients(material).and_then(|all| all.get(source.basis as usize).copied())
        });
        source.alone(if source.material.is_some() { of_material.unwrap_or_default() } else { [1.0; 3] })
    };
    sources.iter().map(weight).collect()
}
