//! Kind `brdf-tensor`, version 0: the glossy lobes of one BRDF model for all materials, outgoing and incoming
//! directions at once (thesis §5.3.1, §5.3.3.1), of low rank beside mirror terms.
//!
//! | section     | type | shape             | content |
//! |-------------|------|-------------------|---------|
//! | `meta`      | u8   | record            | [`Meta`] |
//! | `exponents` | f32  | [samples]         | Blinn-Phong: the samples, increasing, 1 to 200 |
//! | `points`    | f32  | [samples, 2]      | microfacets, instead: reflectance, 0 to 1, and roughness or slope |
//! | `triangles` | u32  | [triangles, 3]    | after `points`: samples between which materials lie |
//! | `core`      | f32  | [a, b, c]         | D |
//! | `materials` | f32  | [samples, a]      | U^h |
//! | `outgoing`  | f32  | [576, b]          | U^ωo, by cells of [`crate::basis::disc`] |
//! | `incoming`  | f32  | [576, 1 + c]      | the diffuse lobe, 1/π, then U^ωi |
//! | `widths`    | f32  | [terms]           | standard deviations of the mirror terms, degrees, increasing |
//! | `mirror`    | f32  | [samples, 12, terms] | what each mirror term reflects, by ring of the outgoing direction |
//!
//! A lobe of unit strength is f(h, ω_o, ω_i) = Σ_ijk D_ijk U^h_hi U^ωo_oj U^ωi_ik plus mirror terms, in sr⁻¹
//! without the cosine; a material between samples is the same mixture of them. The unit lobe is (s + 2)/2π ·
//! cosˢδ of Blinn-Phong and F·D·V of microfacets, F from the reflectance at normal incidence to 1. Triangles
//! are counter-clockwise in the plane of reflectance and ln roughness.
//!
//! **Mirror terms** are Gaussians of the angle to the mirror direction of ω_o, each of integral 1 over the
//! sphere, seen as far as they are above the surface: a term reflects its share of the radiance from there
//! filtered so, and no cosine multiplies it again. A width of 0 is a mirror. Between rings shares are linear
//! in the radius of ω_o on the disc.
//!
//! The columns of `outgoing`, and of `incoming` but for the first, are orthonormal over cells, weighed by
//! their areas.

mod space;

pub use space::Samples;

use crate::basis::disc::{self, AZIMUTHS, CELLS, RINGS};
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::Result;
use crate::state::{Brdf, Model};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;

/// Most mirror terms.
pub const MAX_TERMS: u64 = 8;
/// Largest standard deviation of a mirror term, degrees: what is broader is no mirror's.
const MAX_WIDTH_DEG: f32 = 90.0;
/// Most samples.
pub const MAX_SAMPLES: u64 = 4096;
/// Most columns of a matrix.
pub const MAX_RANK: u64 = 64;
/// Largest value of `core` and of `materials`: lobes reach 10³ sr⁻¹.
const MAX_VALUE: f32 = 1e6;
/// Largest share of a mirror term: a lobe of Blinn-Phong reflects up to four times what it receives from
/// above, and some more along the surface.
const MAX_SHARE: f32 = 64.0;
/// How far products of columns may be off.
const ORTHONORMAL: f64 = 1e-3;

/// What is left out, in squared norms over directions, weighed by both cosines, and samples, each of which
/// counts alike, in parts of that of the lobes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// The model.
    pub model: Model,
    /// What mirror terms leave.
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

/// Lobes of low rank and mirror terms.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfTensor {
    /// What is left out.
    pub meta: Meta,
    /// The materials that were decomposed.
    pub samples: Samples,
    /// Columns of `materials`, of `outgoing`, and of `incoming` but for the diffuse one.
    pub ranks: [usize; 3],
    /// Row-major [ranks].
    pub core: Vec<f32>,
    /// Row-major [samples, ranks[0]].
    pub materials: Vec<f32>,
    /// Row-major [[`CELLS`], ranks[1]].
    pub outgoing: Vec<f32>,
    /// Row-major [[`CELLS`], 1 + ranks[2]].
    pub incoming: Vec<f32>,
    /// Standard deviations of the mirror terms, degrees.
    pub widths_deg: Vec<f32>,
    /// Row-major [samples, [`RINGS`], terms].
    pub mirror: Vec<f32>,
}

impl BrdfTensor {
    /// The samples that the glossy lobe of `material` in one channel lies between, and how much each counts,
    /// see [`Samples::mixture`]; `None` if it is of another model.
    pub fn mixture(&self, material: &Brdf, channel: usize) -> Option<Vec<(usize, f32)>> {
        if material.model() == self.meta.model { self.samples.mixture(material, channel) } else { None }
    }

    /// The core times the row of a material, Σ_i U^h_i D_ijk: row-major [ranks[1], ranks[2]]. `mixture` are
    /// samples and how much each counts, see [`BrdfTensor::mixture`].
    pub fn core_of(&self, mixture: &[(usize, f32)]) -> Vec<f32> {
        let [of_materials, ..] = self.ranks;
        let mut core = vec![0.0; self.core.len() / of_materials.max(1)];
        for (sample, share) in mixture {
            let row = self.materials.chunks_exact(of_materials).nth(*sample).unwrap_or_default();
            for (weight, slice) in row.iter().zip(self.core.chunks_exact(core.len().max(1))) {
                core.iter_mut().zip(slice).for_each(|(sum, value)| *sum += share * weight * value);
            }
        }
        core
    }

    /// The unit lobe of a material without mirror terms, sr⁻¹; unit vectors about the normal +Z. `core` is
    /// [`BrdfTensor::core_of`] it.
    pub fn residual(&self, core: &[f32], outgoing: DVec3, incoming: DVec3) -> f32 {
        let [_, of_outgoing, of_incoming] = self.ranks;
        let out = at(&self.outgoing, of_outgoing, outgoing);
        let from = at(&self.incoming, 1 + of_incoming, incoming);
        let rows = out.iter().zip(core.chunks_exact(of_incoming.max(1)));
        rows.map(|(o, row)| o * row.iter().zip(from.iter().skip(1)).map(|(d, i)| d * i).sum::<f32>()).sum()
    }

    /// Shares of the mirror terms of a material seen from `outgoing`, a unit vector about the normal +Z.
    pub fn shares(&self, mixture: &[(usize, f32)], outgoing: DVec3) -> Vec<f32> {
        let at = (outgoing.truncate().length() * RINGS as f64 - 0.5).clamp(0.0, (RINGS - 1) as f64);
        let ring = (at as usize).min(RINGS - 2);
        let between = [(ring, 1.0 - (at - ring as f64) as f32), (ring + 1, (at - ring as f64) as f32)];
        let terms = self.widths_deg.len();
        let mut shares = vec![0.0; terms];
        for ((sample, part), (ring, share)) in mixture.iter().flat_map(|m| between.map(|b| (m, b))) {
            let stored =
                self.mirror.chunks_exact(terms.max(1)).nth(sample * RINGS + ring).unwrap_or_default();
            shares.iter_mut().zip(stored).for_each(|(sum, value)| *sum += part * share * value);
        }
        shares
    }
}

/// The row of `matrix` at a direction, between those of cells.
fn at(matrix: &[f32], columns: usize, direction: DVec3) -> Vec<f32> {
    let mut row = vec![0.0; columns];
    for (cell, share) in disc::locate(direction) {
        let stored = matrix.chunks_exact(columns.max(1)).nth(cell).unwrap_or_default();
        row.iter_mut().zip(stored).for_each(|(sum, value)| *sum += share * value);
    }
    row
}

impl Stored for BrdfTensor {
    const KIND: Kind = Kind::BrdfTensor;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let [a, b, c] = self.ranks.map(|rank| rank as u64);
        let (samples, cells) = (self.samples.count() as u64, CELLS as u64);
        out.record("meta", &self.meta)?;
        self.samples.encode(out)?;
        out.f32s("core", &[a, b, c], &self.core)?;
        out.f32s("materials", &[samples, a], &self.materials)?;
        out.f32s("outgoing", &[cells, b], &self.outgoing)?;
        out.f32s("incoming", &[cells, 1 + c], &self.incoming)?;
        let terms = self.widths_deg.len() as u64;
        out.f32s("widths", &[terms], &self.widths_deg)?;
        out.f32s("mirror", &[samples, RINGS as u64, terms], &self.mirror)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let of_meta = sections.take("meta")?;
        let meta: Meta = of_meta.record()?;
        of_meta.expect(meta.fault())?;
        let samples = Samples::decode(meta.model, sections)?;
        let count = samples.count() as u64;
        let section = sections.take("core")?;
        let ranks = ranks(&section)?;
        let core = bounded(&section, MAX_VALUE)?;
        let materials = matrix(sections, "materials", [count, ranks[0] as u64])?.1;
        let (section, outgoing) = matrix(sections, "outgoing", [CELLS as u64, ranks[1] as u64])?;
        section.expect(fault_of_columns(&outgoing, ranks[1], 0))?;
        let (section, incoming) = matrix(sections, "incoming", [CELLS as u64, 1 + ranks[2] as u64])?;
        section.expect(fault_of_columns(&incoming, 1 + ranks[2], 1))?;
        let diffuse = incoming.iter().step_by(1 + ranks[2]).all(|value| *value == FRAC_1_PI);
        section.expect((!diffuse).then(|| "the first column is not the diffuse lobe, 1/π".to_owned()))?;
        let widths_deg = widths(&sections.take("widths")?)?;
        let section = sections.take("mirror")?;
        section.expect_shape(&[count, RINGS as u64, widths_deg.len() as u64])?;
        let mirror = bounded(&section, MAX_SHARE)?;
        let negative = mirror.iter().position(|share| *share < 0.0);
        section.expect(negative.map(|at| format!("element {at} is a share below 0")))?;
        Ok(Self { meta, samples, ranks, core, materials, outgoing, incoming, widths_deg, mirror })
    }
}

impl Meta {
    fn fault(&self) -> Option<String> {
        let Self { residual, materials, outgoing, incoming, whole, .. } = *self;
        let errors = [residual, materials, outgoing, incoming, whole];
        let sound = errors.iter().all(|error| error.is_finite() && *error >= 0.0);
        if !sound {
            return Some(format!("errors {errors:?} are no numbers of at least 0"));
        }
        // Rounded sums of the same squares.
        let most = residual * (1.0 + 1e-6) + 1e-9;
        let beyond = [materials, outgoing, incoming, whole].into_iter().find(|error| *error > most)?;
        Some(format!("an error of {beyond}, above what mirror terms leave, {residual}"))
    }
}

/// The shape of the core, whose dimensions are 1 to [`MAX_RANK`].
fn ranks(core: &Section) -> Result<[usize; 3]> {
    match core.info.shape[..] {
        [a, b, c] if [a, b, c].iter().all(|rank| (1..=MAX_RANK).contains(rank)) => {
            Ok([a, b, c].map(|rank| rank as usize))
        }
        _ => Err(core.invalid(format!(
            "has shape {:?}, expected three dimensions of 1 to {MAX_RANK}",
            core.info.shape
        ))),
    }
}

/// Standard deviations of 1 to [`MAX_TERMS`] mirror terms, degrees.
fn widths(section: &Section) -> Result<Vec<f32>> {
    let terms = section.length()?;
    let strange = !(1..=MAX_TERMS).contains(&terms);
    section.expect(strange.then(|| format!("holds {terms} mirror terms, 1 to {MAX_TERMS} are allowed")))?;
    let widths = bounded(section, MAX_WIDTH_DEG)?;
    let sound = widths.is_sorted_by(|a, b| a < b) && widths.iter().all(|width| *width >= 0.0);
    section.expect((!sound).then(|| "widths must increase, from 0 on".to_owned()))?;
    Ok(widths)
}

fn bounded(section: &Section, most: f32) -> Result<Vec<f32>> {
    let values = section.f32s()?;
    section.expect_at_most(&values, most)?;
    Ok(values)
}

fn matrix(sections: &mut Sections<'_>, name: &str, shape: [u64; 2]) -> Result<(Section, Vec<f32>)> {
    let section = sections.take(name)?;
    section.expect_shape(&shape)?;
    let values = bounded(&section, MAX_VALUE)?;
    Ok((section, values))
}

/// That the columns from `first` on are not orthonormal over cells, weighed by areas.
fn fault_of_columns(matrix: &[f32], columns: usize, first: usize) -> Option<String> {
    let product = |a: usize, b: usize| -> f64 {
        let rows = matrix.chunks_exact(columns).enumerate();
        let of_row = |(cell, row): (usize, &[f32])| {
            let value = |column: usize| row.get(column).copied().map_or(0.0, f64::from);
            disc::weight(cell / AZIMUTHS) * value(a) * value(b)
        };
        rows.map(of_row).sum()
    };
    let pairs = (first..columns).flat_map(|a| (first..=a).map(move |b| (a, b)));
    let off = |(a, b): &(usize, usize)| (product(*a, *b) - f64::from(u8::from(a == b))).abs();
    let worst = pairs.map(|pair| (off(&pair), pair)).find(|(off, _)| *off > ORTHONORMAL)?;
    let (off, (a, b)) = worst;
    Some(format!(
        "the product of columns {a} and {b} is off by {off:.1e}, as of columns that are not orthonormal"
    ))
}
