//! Kind `brdf-basis`, version 0: a linear basis of one BRDF model's space (thesis §4.1.2).
//!
//! | section        | type | shape                       | content |
//! |----------------|------|-----------------------------|---------|
//! | `meta`         | u8   | record                      | [`Meta`] |
//! | `parameters`   | f32  | [nodes]                     | sharpness of the lobe, increasing: exponent s, or roughness |
//! | `coefficients` | f32  | [nodes, parts, bases]       | coefficients of each part of the unit lobe at each node |
//! | `lobes`        | f32  | [bases − 1, table]          | Blinn-Phong: glossy basis functions over the half angle, see [`crate::basis::lobe_table`] |
//! | `roughness`    | f32  | [samples]                   | GGX, instead of `lobes`: the samples that basis functions combine |
//! | `weights`      | f32  | [bases − 1, 1 + 2·samples]  | GGX: of the diffuse lobe, of every D·V·(1 − w), of every D·V·w, w = (1 − v·h)⁵ |
//!
//! Basis 0 is diffuse: 1/π, for GGX (1 − w)/π. Between nodes coefficients c are interpolated linearly.
//!
//! * Blinn-Phong has one part: ρ ≈ kd·b₀ + ks·Σⱼ cⱼ(s)·bⱼ.
//! * GGX has two, the lobe at f₀ = 1 but for Schlick's weight, and that with it: ρ ≈ d·b₀ + Σⱼ (f₀·cⱼ(r) + eⱼ(r))·bⱼ, see [`Ggx`].
//!
//! Basis functions may be negative and reflect more than they receive; nothing may clamp them.

use crate::basis::{Angles, lobe_table, microfacet};
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::{Error, Result};
use crate::state::{BlinnPhong, Brdf, Ggx, Model, Rgb};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;

/// Most bases that a file may hold.
pub const MAX_BASES: usize = 32;
/// Most samples that basis functions of GGX may combine.
pub const MAX_SAMPLES: usize = 64;

/// Errors of the basis: relative L2 over directions, for Blinn-Phong on the angle grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BasisError {
    /// Mean over the tested parameters.
    pub mean: f64,
    /// Worst of the tested parameters.
    pub worst: f64,
    /// The exponent or roughness at which it is worst.
    pub worst_at: f64,
}

/// The small print of a basis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// True if glossy lobes use the diffuse basis too, which costs nothing and halves the error of broad lobes.
    /// A textured diffuse basis cannot be shared, for the texture would show in the highlight.
    pub shared_diffuse: bool,
    /// Error at the samples that the basis was made from: for Blinn-Phong all integer exponents 1..=200.
    pub error_at_samples: BasisError,
    /// Error between them, which adds the interpolation of coefficients.
    pub error_between: BasisError,
}

/// The basis functions but for the diffuse one.
#[derive(Debug, Clone, PartialEq)]
pub enum Functions {
    /// Row-major [bases − 1, [`lobe_table::NODES`]].
    BlinnPhong {
        /// Values over the half angle, sr⁻¹.
        lobes: Vec<f32>,
    },
    /// Combinations of the analytic lobes of some roughnesses.
    Ggx {
        /// The samples' roughnesses.
        roughness: Vec<f32>,
        /// Row-major [bases − 1, 1 + 2·samples].
        weights: Vec<f32>,
    },
}

/// A basis of the space of one model.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfBasis {
    /// How it was made and what it misses.
    pub meta: Meta,
    /// Exponents or roughnesses at which coefficients are stored, increasing.
    pub parameters: Vec<f32>,
    /// Row-major [nodes, parts, bases].
    pub coefficients: Vec<f32>,
    /// What the coefficients multiply.
    pub functions: Functions,
}

impl Functions {
    /// The model whose lobes these approximate.
    pub fn model(&self) -> Model {
        match self {
            Self::BlinnPhong { .. } => Model::BlinnPhong,
            Self::Ggx { .. } => Model::Ggx,
        }
    }

    /// Parts of a lobe that have coefficients of their own.
    fn parts(&self) -> usize {
        match self {
            Self::BlinnPhong { .. } => 1,
            Self::Ggx { .. } => 2,
        }
    }

    fn glossy_bases(&self) -> usize {
        match self {
            Self::BlinnPhong { lobes } => lobes.len() / lobe_table::NODES,
            Self::Ggx { roughness, weights } => weights.len() / (1 + 2 * roughness.len()),
        }
    }
}

impl BrdfBasis {
    /// Number of bases, the diffuse one included.
    pub fn bases(&self) -> usize {
        1 + self.functions.glossy_bases()
    }

    /// Coefficients of part `part` of the unit lobe at `parameter`; outside the stored range the nearest node's.
    pub fn lobe_coefficients(&self, part: usize, parameter: f32) -> Vec<f32> {
        let (bases, parts) = (self.bases(), self.functions.parts());
        let after = self.parameters.partition_point(|s| *s <= parameter).clamp(1, self.parameters.len() - 1);
        let (s0, s1) = (self.parameters[after - 1], self.parameters[after]);
        let mix = ((parameter - s0) / (s1 - s0)).clamp(0.0, 1.0);
        let row = |node: usize| &self.coefficients[(node * parts + part) * bases..][..bases];
        row(after - 1).iter().zip(row(after)).map(|(a, b)| a + (b - a) * mix).collect()
    }

    /// RGB coefficients of a material on every basis (thesis eq. 4-22); `None` if it is of another model.
    pub fn coefficients_of(&self, material: &Brdf) -> Option<Vec<Rgb>> {
        match material {
            Brdf::BlinnPhong(material) if self.functions.model() == Model::BlinnPhong => Some(self.of_blinn_phong(material)),
            Brdf::Ggx(material) if self.functions.model() == Model::Ggx => Some(self.of_ggx(material)),
            _ => None,
        }
    }

    fn of_blinn_phong(&self, material: &BlinnPhong) -> Vec<Rgb> {
        let lobe = self.lobe_coefficients(0, material.shininess);
        with_diffuse(material.kd, lobe.iter().map(|c| material.ks.map(|ks| ks * c)).collect())
    }

    fn of_ggx(&self, material: &Ggx) -> Vec<Rgb> {
        let [at_f0, schlick] = [0, 1].map(|part| self.lobe_coefficients(part, material.roughness));
        let f0 = material.f0();
        with_diffuse(material.diffuse(), at_f0.iter().zip(&schlick).map(|(c, e)| f0.map(|f0| f0 * c + e)).collect())
    }

    /// Values of every basis function, in sr⁻¹, written to `out` ([`BrdfBasis::bases`] long).
    pub fn evaluate(&self, angles: &Angles, out: &mut [f32]) {
        match &self.functions {
            Functions::BlinnPhong { lobes } => {
                let (node, mix) = lobe_table::locate(angles.cos_half);
                out[0] = FRAC_1_PI;
                for (value, lobe) in out[1..].iter_mut().zip(lobes.chunks_exact(lobe_table::NODES)) {
                    *value = lobe[node] + (lobe[node + 1] - lobe[node]) * mix;
                }
            }
            Functions::Ggx { roughness, weights } => evaluate_ggx(roughness, weights, angles, out),
        }
    }
}

fn with_diffuse(diffuse: Rgb, mut coefficients: Vec<Rgb>) -> Vec<Rgb> {
    for (sum, kd) in coefficients[0].iter_mut().zip(diffuse) {
        *sum += kd;
    }
    coefficients
}

fn evaluate_ggx(roughness: &[f32], weights: &[f32], angles: &Angles, out: &mut [f32]) {
    let mut lobes = [0.0; MAX_SAMPLES];
    let lobes = &mut lobes[..roughness.len()];
    for (lobe, roughness) in lobes.iter_mut().zip(roughness) {
        let alpha = roughness * roughness;
        *lobe = microfacet::distribution_visibility(alpha * alpha, angles);
    }
    let w = microfacet::schlick(angles.cos_difference);
    let diffuse = FRAC_1_PI * (1.0 - w);
    out[0] = diffuse;
    for (value, row) in out[1..].iter_mut().zip(weights.chunks_exact(1 + 2 * roughness.len())) {
        let (at_f0, schlick) = row[1..].split_at(roughness.len());
        *value = row[0] * diffuse + (1.0 - w) * dot(at_f0, lobes) + w * dot(schlick, lobes);
    }
}

/// Summed in four lanes, which vector units do at once.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0; 4];
    let (a4, a_rest) = a.as_chunks::<4>();
    let (b4, b_rest) = b.as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for k in 0..4 {
            lanes[k] += a[k] * b[k];
        }
    }
    let rest: f32 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

impl Stored for BrdfBasis {
    const KIND: Kind = Kind::BrdfBasis;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let (nodes, bases) = (self.parameters.len() as u64, self.bases() as u64);
        out.record("meta", &self.meta)?;
        out.f32s("parameters", &[nodes], &self.parameters)?;
        out.f32s("coefficients", &[nodes, self.functions.parts() as u64, bases], &self.coefficients)?;
        match &self.functions {
            Functions::BlinnPhong { lobes } => out.f32s("lobes", &[bases - 1, lobe_table::NODES as u64], lobes),
            Functions::Ggx { roughness, weights } => {
                let samples = roughness.len() as u64;
                out.f32s("roughness", &[samples], roughness)?;
                out.f32s("weights", &[bases - 1, 1 + 2 * samples], weights)
            }
        }
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let meta = sections.take("meta")?.record()?;
        let section = sections.take("parameters")?;
        let nodes = section.length()?;
        let parameters = if (2..=65_536).contains(&nodes) { section.f32s()? } else { Vec::new() };
        if parameters.is_empty() || !parameters.is_sorted_by(|a, b| a < b) {
            return Err(section.invalid("needs 2 to 65536 increasing parameters"));
        }
        section.expect_finite(&parameters)?;

        let section = sections.take("coefficients")?;
        let coefficients = section.f32s()?;
        section.expect_finite(&coefficients)?;
        let functions = decode_functions(sections)?;
        let bases = 1 + functions.glossy_bases() as u64;
        if !(2..=MAX_BASES as u64).contains(&bases) {
            return Err(section.invalid(format!("holds {bases} bases, 2 to {MAX_BASES} are allowed")));
        }
        section.expect_shape(&[nodes, functions.parts() as u64, bases])?;
        Ok(Self { meta, parameters, coefficients, functions })
    }
}

fn decode_functions(sections: &mut Sections<'_>) -> Result<Functions> {
    let finite = |section: &Section| {
        let values = section.f32s()?;
        section.expect_finite(&values)?;
        Ok(values)
    };
    let first = sections.take_any()?;
    let first = first.ok_or_else(|| Error::invalid(&sections.place, "section `lobes` is missing; the file is damaged, bake it again"))?;
    match first.info.name.as_str() {
        "lobes" => {
            let lobes = finite(&first)?;
            first.expect_shape(&[(lobes.len() / lobe_table::NODES) as u64, lobe_table::NODES as u64])?;
            Ok(Functions::BlinnPhong { lobes })
        }
        "roughness" => {
            let roughness = finite(&first)?;
            let samples = first.length()?;
            if !(1..=MAX_SAMPLES as u64).contains(&samples) || !roughness.iter().all(|r| (0.0..=1.0).contains(r) && *r > 0.0) {
                return Err(first.invalid(format!("needs 1 to {MAX_SAMPLES} roughnesses above 0, up to 1")));
            }
            let section = sections.take("weights")?;
            let weights = finite(&section)?;
            let row = 1 + 2 * samples;
            section.expect_shape(&[weights.len() as u64 / row, row])?;
            Ok(Functions::Ggx { roughness, weights })
        }
        _ => Err(first.invalid("expected section `lobes` or `roughness` here; the file is damaged, bake it again")),
    }
}
