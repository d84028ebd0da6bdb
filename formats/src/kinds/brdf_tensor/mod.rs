//! Kind `brdf-tensor`, version 0: the glossy lobes of one BRDF model for all materials, outgoing and incoming
//! directions at once (thesis §5.3.1, §5.3.3.1): a few cones, and a residual of low rank.
//!
//! | section     | type | shape             | content |
//! |-------------|------|-------------------|---------|
//! | `meta`      | u8   | record            | [`Meta`] |
//! | `exponents` | f32  | [samples]         | Blinn-Phong: the samples, increasing, 1 to 200 |
//! | `points`    | f32  | [samples, 2]      | microfacets, instead: reflectance, 0 to 1, and roughness or slope |
//! | `triangles` | u32  | [triangles, 3]    | after `points`: samples between which materials lie |
//! | `orders`    | u32  | [c]               | m, azimuthal order of each incoming profile |
//! | `core`      | f32  | [a, b, c]         | D |
//! | `materials` | f32  | [samples, a]      | U^h |
//! | `outgoing`  | f32  | [31, b]           | U^ωo, by nodes of [`angles`] |
//! | `incoming`  | f32  | [31, c]           | U^ωi, the profiles, by nodes of [`angles`] |
//! | `cones`     | f32  | [cones, 3]        | width, tilt and side of each, degrees: [`Cone`] |
//! | `shares`    | f32  | [samples, 31, cones] | what each cone reflects, by angle of the outgoing direction |
//! | `even`      | f32  | [31]              | what the diffuse lobe of a white surface reflects of a white sky |
//!
//! With θ angles from the normal and φ azimuths about it, the lobe of a material h of strength 1, times the
//! cosine of the incoming direction, is
//!
//! f(h, ω_o, ω_i)·cos θ_i = Σ_t a_t(h, θ_o)·G_t(ω_o, ω_i) + cos θ_i · Σ_k R_k(h, θ_o)·I_k(θ_i)·cos m_k(φ_i − φ_o),
//!
//! R_k(h, θ_o) = Σ_ij U^h_hi D_ijk U^ωo_oj, in sr⁻¹. Tables are linear between nodes, and so are materials
//! between samples. G_t is the mean of the [`Cone`]'s Gaussians, each of integral 1 over the sphere and seen as
//! far as it is above the surface: a cone reflects its share of the radiance filtered so, and no cosine
//! multiplies it again. The unit lobe is (s + 2)/2π · cosˢδ of Blinn-Phong and F·D·V of microfacets, F from the
//! reflectance at normal incidence to 1. Triangles are counter-clockwise in the plane of reflectance and ln
//! roughness.
//!
//! What a surface receives of a profile needs no more than one number for m = 0, and two for m > 0, of the
//! cosine and the sine of m·φ, whatever direction it is seen from ([`BrdfTensor::column_values`]).

pub mod angles;
mod check;
mod cone;
mod space;

pub use cone::Cone;
pub use space::Samples;

use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::Result;
use crate::state::{Brdf, Model, Rgb};
use angles::NODES;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;

/// Most cones.
pub const MAX_CONES: u64 = 32;
/// Most samples.
pub const MAX_SAMPLES: u64 = 4096;
/// Most incoming profiles, each of which costs a vertex one or two columns, and most columns of materials.
pub const MAX_PROFILES: u64 = 16;
/// Largest azimuthal order.
pub const MAX_ORDER: u32 = 48;

/// What is left out, in squared norms, in parts of the lobe's, mean over samples. A squared norm is what of the
/// reflected radiance is expected to be off, squared, under random lights of natural spectrum: of the spherical
/// harmonics of lobe times cosine, those of band l, up to 48, count 1/(1 + l)²; angles θ_o count sin θ_o cos θ_o and
/// a little more.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// The model.
    pub model: Model,
    /// What cones leave.
    pub residual: f64,
    /// What of that is lost if `materials` alone is truncated.
    pub materials: f64,
    /// The same of `outgoing`.
    pub outgoing: f64,
    /// The same of `incoming`.
    pub incoming: f64,
    /// What is lost by all.
    pub whole: f64,
}

/// The lobes of a model as cones and a residual.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfTensor {
    /// What is left out.
    pub meta: Meta,
    /// The materials that were decomposed.
    pub samples: Samples,
    /// Azimuthal order of each incoming profile, [c].
    pub orders: Vec<u32>,
    /// Columns of `materials`, of `outgoing` and of `incoming`.
    pub ranks: [usize; 3],
    /// Row-major [ranks].
    pub core: Vec<f32>,
    /// Row-major [samples, a].
    pub materials: Vec<f32>,
    /// Row-major [[`NODES`], b].
    pub outgoing: Vec<f32>,
    /// Row-major [[`NODES`], c].
    pub incoming: Vec<f32>,
    /// The cones.
    pub cones: Vec<Cone>,
    /// Row-major [samples, [`NODES`], cones].
    pub shares: Vec<f32>,
    /// What the diffuse lobe reflects of a white sky, by angle of the outgoing direction, [[`NODES`]]: below 1
    /// for GGX, whose highlight takes the rest.
    pub even: Vec<f32>,
}

/// How strong the glossy lobe of a material is in each channel, in parts of the unit lobe: ks. Of GGX 1, for its
/// colours are those of the samples that it lies between.
pub fn strength(material: &Brdf) -> Rgb {
    match material {
        Brdf::BlinnPhong(brdf) => brdf.ks,
        Brdf::Ggx(_) => [1.0; 3],
        Brdf::CookTorrance(brdf) => brdf.ks,
    }
}

/// The angle of a direction from the normal +Z, radians.
pub fn theta(direction: Vec3) -> f32 {
    direction.truncate().length().atan2(direction.z)
}

impl BrdfTensor {
    /// The samples that the glossy lobe of `material` in one channel lies between, and how much each counts,
    /// see [`Samples::mixture`]; `None` if it is of another model.
    pub fn mixture(&self, material: &Brdf, channel: usize) -> Option<Vec<(usize, f32)>> {
        if material.model() == self.meta.model { self.samples.mixture(material, channel) } else { None }
    }

    /// The core times the row of a material, Σ_i U^h_i D_ijk: row-major [b, c]. `mixture` are samples and how
    /// much each counts, see [`BrdfTensor::mixture`].
    pub fn core_of(&self, mixture: &[(usize, f32)]) -> Vec<f32> {
        let [of_materials, b, c] = self.ranks;
        let mut core = vec![0.0; b * c];
        for (sample, share) in mixture {
            let row = self.materials.chunks_exact(of_materials.max(1)).nth(*sample).unwrap_or_default();
            for (weight, slice) in row.iter().zip(self.core.chunks_exact(core.len().max(1))) {
                core.iter_mut().zip(slice).for_each(|(sum, value)| *sum += share * weight * value);
            }
        }
        core
    }

    /// How much each incoming profile counts for a material by angle of the outgoing direction, R_k: row-major
    /// [[`NODES`], c].
    pub fn weights_of(&self, mixture: &[(usize, f32)]) -> Vec<f32> {
        let [_, b, c] = self.ranks;
        let core = self.core_of(mixture);
        let mut weights = vec![0.0; NODES * c];
        for (to, row) in weights.chunks_exact_mut(c.max(1)).zip(self.outgoing.chunks_exact(b.max(1))) {
            for (value, slice) in row.iter().zip(core.chunks_exact(c.max(1))) {
                to.iter_mut().zip(slice).for_each(|(sum, core)| *sum += value * core);
            }
        }
        weights
    }

    /// How much each cone reflects for a material by angle of the outgoing direction: row-major [[`NODES`],
    /// cones].
    pub fn shares_of(&self, mixture: &[(usize, f32)]) -> Vec<f32> {
        let mut shares = vec![0.0; NODES * self.cones.len()];
        for (sample, part) in mixture {
            let stored = self.shares.chunks_exact(shares.len().max(1)).nth(*sample).unwrap_or_default();
            shares.iter_mut().zip(stored).for_each(|(sum, value)| *sum += part * value);
        }
        shares
    }

    /// A row of a table by angle of the outgoing direction, as [`BrdfTensor::weights_of`],
    /// [`BrdfTensor::shares_of`] and `even` are, where it is seen from `outgoing`, a unit vector about the normal +Z.
    pub fn seen_from(table: &[f32], outgoing: Vec3) -> Vec<f32> {
        angles::row(table, table.len() / NODES, theta(outgoing))
    }

    /// The unit lobe of a material without cones, sr⁻¹; unit vectors about the normal +Z. `weights` is
    /// [`BrdfTensor::weights_of`] it.
    pub fn residual(&self, weights: &[f32], outgoing: Vec3, incoming: Vec3) -> f32 {
        let turned = azimuth(incoming) - azimuth(outgoing);
        let weights = Self::seen_from(weights, outgoing);
        let profiles = Self::seen_from(&self.incoming, incoming);
        let of_profile = |((weight, profile), order): ((&f32, f32), &u32)| {
            weight * profile * (*order as f32 * turned).cos()
        };
        weights.iter().zip(profiles).zip(&self.orders).map(of_profile).sum()
    }

    /// How many numbers a vertex has of what it receives: one of the diffuse lobe, then one of each profile of
    /// order 0 and two of each other.
    pub fn columns(&self) -> usize {
        1 + self.orders.iter().map(|order| if *order == 0 { 1 } else { 2 }).sum::<usize>()
    }

    /// The functions that those numbers are of, [[`BrdfTensor::columns`]], sr⁻¹: 1/π, then I_k(θ)·cos mφ and, for
    /// m > 0, I_k(θ)·sin mφ, at a unit vector about the normal +Z, φ from +X towards +Y. What arrives is multiplied
    /// with them and with the cosine.
    pub fn column_values(&self, incoming: Vec3) -> Vec<f32> {
        let profiles = Self::seen_from(&self.incoming, incoming);
        std::iter::once(FRAC_1_PI).chain(self.turned(&profiles, azimuth(incoming))).collect()
    }

    /// What the numbers of a vertex are multiplied with, but for the first, [[`BrdfTensor::columns`] − 1], so that
    /// their sum is what the residual of the unit lobe reflects towards `outgoing`: R_k·cos mφ_o and R_k·sin mφ_o.
    /// `weights` is [`BrdfTensor::weights_of`] a material.
    pub fn column_weights(&self, weights: &[f32], outgoing: Vec3) -> Vec<f32> {
        self.turned(&Self::seen_from(weights, outgoing), azimuth(outgoing)).collect()
    }

    /// Each value times cos mφ and, for m > 0, times sin mφ.
    fn turned(&self, values: &[f32], azimuth: f32) -> impl Iterator<Item = f32> {
        values.iter().zip(&self.orders).flat_map(move |(value, order)| {
            let (sin, cos) = (*order as f32 * azimuth).sin_cos();
            std::iter::once(value * cos).chain((*order > 0).then_some(value * sin))
        })
    }
}

fn azimuth(direction: Vec3) -> f32 {
    direction.y.atan2(direction.x)
}

impl Stored for BrdfTensor {
    const KIND: Kind = Kind::BrdfTensor;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let [a, b, c] = self.ranks.map(|rank| rank as u64);
        let (samples, nodes, cones) = (self.samples.count() as u64, NODES as u64, self.cones.len() as u64);
        out.record("meta", &self.meta)?;
        self.samples.encode(out)?;
        out.u32s("orders", &[c], &self.orders)?;
        out.f32s("core", &[a, b, c], &self.core)?;
        out.f32s("materials", &[samples, a], &self.materials)?;
        out.f32s("outgoing", &[nodes, b], &self.outgoing)?;
        out.f32s("incoming", &[nodes, c], &self.incoming)?;
        let of_cone = |cone: &Cone| [cone.width_deg, cone.tilt_deg, cone.side_deg];
        out.f32s("cones", &[cones, 3], &self.cones.iter().flat_map(of_cone).collect::<Vec<f32>>())?;
        out.f32s("shares", &[samples, nodes, cones], &self.shares)?;
        out.f32s("even", &[nodes], &self.even)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let of_meta = sections.take("meta")?;
        let meta: Meta = of_meta.record()?;
        of_meta.expect(check::fault_of(&meta))?;
        let samples = Samples::decode(meta.model, sections)?;
        let orders = check::orders(&sections.take("orders")?)?;
        let section = sections.take("core")?;
        let ranks = check::ranks(&section, orders.len())?;
        let core = check::bounded(&section)?;
        let count = samples.count() as u64;
        let mut matrix =
            |name, rows: u64, columns: usize| check::matrix(sections, name, [rows, columns as u64]);
        let materials = matrix("materials", count, ranks[0])?;
        let outgoing = matrix("outgoing", NODES as u64, ranks[1])?;
        let incoming = matrix("incoming", NODES as u64, ranks[2])?;
        let cones = check::cones(&sections.take("cones")?)?;
        let section = sections.take("shares")?;
        section.expect_shape(&[count, NODES as u64, cones.len() as u64])?;
        let shares = check::shares(&section)?;
        let even = check::even(&sections.take("even")?)?;
        Ok(Self { meta, samples, orders, ranks, core, materials, outgoing, incoming, cones, shares, even })
    }
}
