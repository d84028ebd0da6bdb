//! Kind `brdf-basis`, version 0: a linear basis of one BRDF model's space (thesis §4.1.2).
//!
//! | section        | type | shape                       | content |
//! |----------------|------|-----------------------------|---------|
//! | `meta`         | u8   | record                      | [`Meta`] |
//! | `parameters`   | f32  | [nodes]                     | sharpness of the lobe, increasing: exponent s from 1 to 200, roughness from 0.32 to 1, or slope from 0.1 to 1, and as far as 5000, 0.14 or 0.02 |
//! | `coefficients` | f32  | [nodes, parts, bases]       | coefficients of each part of the unit lobe at each node, of at most [`MAX_COEFFICIENT`] |
//! | `lobes`        | f32  | [bases − 1, table]          | Blinn-Phong: glossy basis functions over the half angle, see [`crate::basis::lobe_table`] |
//! | `roughness`    | f32  | [samples]                   | GGX, instead of `lobes`: the samples that basis functions combine |
//! | `slopes`       | f32  | [samples]                   | Cook-Torrance, instead of `lobes`: the same |
//! | `weights`      | f32  | [bases − 1, 1 + 2·samples]  | both: of the diffuse lobe, of every D·V·(1 − w), of every D·V·w, w = (1 − v·h)⁵ |
//!
//! The first and the last parameter are the ends of the range of materials that vary, to 10⁻⁵ of themselves.
//!
//! Basis 0 is diffuse: 1/π, for GGX (1 − w)/π. Between nodes coefficients c are interpolated linearly.
//!
//! * Blinn-Phong has one part: ρ ≈ kd·b₀ + ks·Σⱼ cⱼ(s)·bⱼ.
//! * GGX has two, the lobe at f₀ = 1 but for Schlick's weight, and that with it: ρ ≈ d·b₀ + Σⱼ (f₀·cⱼ(r) +
//!   eⱼ(r))·bⱼ, see [`Ggx`].
//! * So has Cook-Torrance: ρ ≈ kd·b₀ + ks·Σⱼ (fresnel·cⱼ(m) + eⱼ(m))·bⱼ, see [`CookTorrance`].
//!
//! At every node the error of the lobe, relative L2, is at most 1.25 times the largest that is stored in
//! `meta` and 10⁻³: a reader measures it again.
//!
//! Basis functions may be negative and reflect more than they receive; nothing may clamp them.

mod residual;

use crate::basis::lanes::dot;
use crate::basis::microfacet::Facets;
use crate::basis::{Angles, lobe_table, microfacet};
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::{Error, Result};
use crate::state::{BlinnPhong, Brdf, CookTorrance, Ggx, Model, Rgb};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;

/// Most bases that a file may hold.
pub const MAX_BASES: usize = 32;
/// Most samples that basis functions of microfacets may combine.
pub const MAX_SAMPLES: usize = 64;

/// Most nodes: eight times as many as a bake writes. At each of them a reader compares the lobe.
pub const MAX_NODES: u64 = 4096;

/// Largest coefficient. Basis functions are scaled so that these are of the order of the BRDF, whose lobes
/// reach 800 sr⁻¹.
pub const MAX_COEFFICIENT: f32 = 1e4;
/// Largest value of a basis function, and largest weight. Bases of hardly any lobe are noise, scaled up; sums
/// of products are still numbers.
pub const MAX_VALUE: f32 = 1e30;
/// How far the ends of the range may be off, in parts of themselves.
const RANGE_TOLERANCE: f32 = 1e-5;

/// Errors of the basis: relative L2 over directions, for Blinn-Phong on the angle grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BasisError {
    /// Mean over the tested parameters.
    pub mean: f64,
    /// Worst of the tested parameters.
    pub worst: f64,
    /// The exponent, roughness or slope at which it is worst.
    pub worst_at: f64,
}

/// The small print of a basis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// True if glossy lobes use the diffuse basis too, which costs nothing and halves the error of broad
    /// lobes. A textured diffuse basis cannot be shared, for the texture would show in the highlight.
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
    Microfacet {
        /// Whose lobes.
        facets: Facets,
        /// The samples' roughnesses, or slopes.
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
    /// Exponents, roughnesses or slopes at which coefficients are stored, increasing.
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
            Self::Microfacet { facets, .. } => model_of(*facets),
        }
    }

    /// Parts of a lobe that have coefficients of their own.
    fn parts(&self) -> usize {
        match self {
            Self::BlinnPhong { .. } => 1,
            Self::Microfacet { .. } => 2,
        }
    }

    fn glossy_bases(&self) -> usize {
        match self {
            Self::BlinnPhong { lobes } => lobes.len() / lobe_table::NODES,
            Self::Microfacet { roughness, weights, .. } => weights.len() / (1 + 2 * roughness.len()),
        }
    }
}

/// The model whose facets these are.
pub fn model_of(facets: Facets) -> Model {
    match facets {
        Facets::Ggx => Model::Ggx,
        Facets::CookTorrance => Model::CookTorrance,
    }
}

impl BrdfBasis {
    /// Number of bases, the diffuse one included.
    pub fn bases(&self) -> usize {
        1 + self.functions.glossy_bases()
    }

    /// The exponent, roughness or slope of the sharpest lobe that it spans.
    pub fn sharpest(&self) -> f32 {
        let end = match self.functions {
            Functions::BlinnPhong { .. } => self.parameters.last(),
            Functions::Microfacet { .. } => self.parameters.first(),
        };
        end.copied().unwrap_or(f32::NAN)
    }

    /// Whether it spans lobes as sharp as `sharpest`.
    pub fn spans(&self, sharpest: f32) -> bool {
        let (end, tolerance) = (self.sharpest(), RANGE_TOLERANCE * sharpest);
        match self.functions {
            Functions::BlinnPhong { .. } => sharpest <= end + tolerance,
            Functions::Microfacet { .. } => sharpest >= end - tolerance,
        }
    }

    /// Largest relative L2 error of a lobe at any node, as a reader measures it: the errors that a basis
    /// states must not be much less.
    pub fn largest_error(&self) -> f64 {
        residual::largest(self)
    }

    /// Coefficients of part `part` of the unit lobe at `parameter`; outside the stored range the nearest
    /// node's.
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
            Brdf::BlinnPhong(material) if self.functions.model() == Model::BlinnPhong => {
                Some(self.of_blinn_phong(material))
            }
            Brdf::Ggx(material) if self.functions.model() == Model::Ggx => Some(self.of_ggx(material)),
            Brdf::CookTorrance(material) if self.functions.model() == Model::CookTorrance => {
                Some(self.of_cook_torrance(material))
            }
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
        with_diffuse(
            material.diffuse(),
            at_f0.iter().zip(&schlick).map(|(c, e)| f0.map(|f0| f0 * c + e)).collect(),
        )
    }

    fn of_cook_torrance(&self, material: &CookTorrance) -> Vec<Rgb> {
        let [at_f0, schlick] = [0, 1].map(|part| self.lobe_coefficients(part, material.roughness));
        let lobe = at_f0.iter().zip(&schlick).map(|(c, e)| material.fresnel * c + e);
        with_diffuse(material.kd, lobe.map(|c| material.ks.map(|ks| ks * c)).collect())
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
            Functions::Microfacet { facets, roughness, weights } => {
                evaluate_microfacet(*facets, roughness, weights, angles, out);
            }
        }
    }
}

fn with_diffuse(diffuse: Rgb, mut coefficients: Vec<Rgb>) -> Vec<Rgb> {
    for (sum, kd) in coefficients[0].iter_mut().zip(diffuse) {
        *sum += kd;
    }
    coefficients
}

fn evaluate_microfacet(facets: Facets, roughness: &[f32], weights: &[f32], angles: &Angles, out: &mut [f32]) {
    let mut lobes = [0.0; MAX_SAMPLES];
    let lobes = &mut lobes[..roughness.len()];
    for (lobe, roughness) in lobes.iter_mut().zip(roughness) {
        *lobe = facets.lobe(*roughness, angles);
    }
    let w = microfacet::schlick(angles.cos_difference);
    let diffuse = facets.diffuse(w);
    out[0] = diffuse;
    for (value, row) in out[1..].iter_mut().zip(weights.chunks_exact(1 + 2 * roughness.len())) {
        let (at_f0, schlick) = row[1..].split_at(roughness.len());
        *value = row[0] * diffuse + (1.0 - w) * dot(at_f0, lobes) + w * dot(schlick, lobes);
    }
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
            Functions::BlinnPhong { lobes } => {
                out.f32s("lobes", &[bases - 1, lobe_table::NODES as u64], lobes)
            }
            Functions::Microfacet { facets, roughness, weights } => {
                let samples = roughness.len() as u64;
                out.f32s(samples_section(*facets), &[samples], roughness)?;
                out.f32s("weights", &[bases - 1, 1 + 2 * samples], weights)
            }
        }
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let of_meta = sections.take("meta")?;
        let meta: Meta = of_meta.record()?;
        of_meta.expect(meta.fault())?;
        let of_parameters = sections.take("parameters")?;
        let nodes = of_parameters.length()?;
        let parameters = if (2..=MAX_NODES).contains(&nodes) { of_parameters.f32s()? } else { Vec::new() };
        if parameters.is_empty() || !parameters.is_sorted_by(|a, b| a < b) {
            return Err(of_parameters.invalid(format!("needs 2 to {MAX_NODES} increasing parameters")));
        }
        of_parameters.expect_finite(&parameters)?;

        let section = sections.take("coefficients")?;
        let coefficients = section.f32s()?;
        section.expect_at_most(&coefficients, MAX_COEFFICIENT)?;
        let functions = decode_functions(sections)?;
        let bases = 1 + functions.glossy_bases() as u64;
        if !(2..=MAX_BASES as u64).contains(&bases) {
            return Err(section.invalid(format!("holds {bases} bases, 2 to {MAX_BASES} are allowed")));
        }
        section.expect_shape(&[nodes, functions.parts() as u64, bases])?;
        of_parameters.expect(fault_of_range(&parameters, functions.model()))?;
        of_meta.expect(meta.fault_of_means())?;
        let basis = Self { meta, parameters, coefficients, functions };
        section.expect(residual::fault(&basis))?;
        Ok(basis)
    }
}

impl Meta {
    fn fault(&self) -> Option<String> {
        let BasisError { mean, worst, .. } = self.error_at_samples;
        let between = self.error_between;
        let errors = [mean, worst, between.mean, between.worst];
        let is_error = |e: &f64| e.is_finite() && *e >= 0.0;
        let places = [self.error_at_samples.worst_at, between.worst_at];
        let sound = errors.iter().all(is_error) && places.iter().all(|at| at.is_finite());
        (!sound).then(|| format!("errors {errors:?} at {places:?} are no numbers of at least 0"))
    }

    fn fault_of_means(&self) -> Option<String> {
        // A mean of equal numbers may be rounded up.
        let is_wrong = |error: &&BasisError| error.mean > error.worst * (1.0 + 1e-9);
        let wrong = [&self.error_at_samples, &self.error_between].into_iter().find(is_wrong)?;
        Some(format!("mean error {}, above the worst, {}", wrong.mean, wrong.worst))
    }
}

/// Materials may have any parameter of the range, and beyond the last node nothing is known of their lobes.
fn fault_of_range(parameters: &[f32], model: Model) -> Option<String> {
    let (first, last) = (*parameters.first()?, *parameters.last()?);
    let [least, most] = model.editable(model.usual_sharpest());
    let [asked_least, asked_most] = model.editable(model.most_sharpest());
    let within = |value: f32, a: f32, b: f32| {
        (a * (1.0 - RANGE_TOLERANCE)..=b * (1.0 + RANGE_TOLERANCE)).contains(&value)
    };
    let spans = within(first, asked_least, least) && within(last, most, asked_most);
    let most_of_all = format!("at most {asked_least} to {asked_most}");
    (!spans).then(|| format!("runs from {first} to {last}, expected {least} to {most}, {most_of_all}"))
}

/// All facets there are.
const FACETS: [Facets; 2] = [Facets::Ggx, Facets::CookTorrance];

/// The section that has the samples, which tells the model, too.
fn samples_section(facets: Facets) -> &'static str {
    match facets {
        Facets::Ggx => "roughness",
        Facets::CookTorrance => "slopes",
    }
}

fn decode_functions(sections: &mut Sections<'_>) -> Result<Functions> {
    let within = |section: &Section, most: f32| {
        let values = section.f32s()?;
        section.expect_at_most(&values, most)?;
        Ok(values)
    };
    let first = sections.take_any()?;
    let first = first.ok_or_else(|| {
        Error::invalid(&sections.place, "section `lobes` is missing; the file is damaged, bake it again")
    })?;
    match first.info.name.as_str() {
        "lobes" => {
            let lobes = within(&first, MAX_VALUE)?;
            first.expect_shape(&[(lobes.len() / lobe_table::NODES) as u64, lobe_table::NODES as u64])?;
            Ok(Functions::BlinnPhong { lobes })
        }
        name => {
            let facets = FACETS.into_iter().find(|facets| samples_section(*facets) == name);
            let unknown =
                "expected section `lobes`, `roughness` or `slopes` here; the file is damaged, bake it again";
            let facets = facets.ok_or_else(|| first.invalid(unknown))?;
            let (roughness, least) = (within(&first, f32::MAX)?, model_of(facets).most_sharpest());
            let samples = first.length()?;
            let legal = least * (1.0 - RANGE_TOLERANCE)..=1.0 + RANGE_TOLERANCE;
            if !(1..=MAX_SAMPLES as u64).contains(&samples) || !roughness.iter().all(|r| legal.contains(r)) {
                return Err(first.invalid(format!("needs 1 to {MAX_SAMPLES} values of {least} to 1")));
            }
            let section = sections.take("weights")?;
            let weights = within(&section, MAX_VALUE)?;
            let row = 1 + 2 * samples;
            section.expect_shape(&[weights.len() as u64 / row, row])?;
            Ok(Functions::Microfacet { facets, roughness, weights })
        }
    }
}
