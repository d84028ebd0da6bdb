//! Kind `brdf-basis`, version 0: a linear basis of the Blinn-Phong space (thesis §4.1.2).
//!
//! | section        | type | shape            | content |
//! |----------------|------|------------------|---------|
//! | `meta`         | u8   | record           | [`Meta`] |
//! | `shininess`    | f32  | [nodes]          | exponents s, increasing |
//! | `coefficients` | f32  | [nodes, bases]   | coefficients of the unit glossy lobe (ks = 1, kd = 0) at each s |
//! | `lobes`        | f32  | [bases − 1, table] | glossy basis functions over the half angle, see [`crate::basis::lobe_table`] |
//!
//! Basis 0 is diffuse, 1/π. A material is ρ ≈ kd·b₀ + ks·Σⱼ cⱼ(s)·bⱼ with c(s) interpolated linearly between nodes.
//! Basis functions may be negative and reflect more than they receive; nothing may clamp them.

use crate::basis::lobe_table;
use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::Result;
use crate::state::{BlinnPhong, Rgb};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;

/// Most bases that a file may hold.
pub const MAX_BASES: usize = 32;

/// Errors of the basis against the tabulated BRDF: relative L2 over the angle grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BasisError {
    /// Mean over the tested exponents.
    pub mean: f64,
    /// Worst of the tested exponents.
    pub worst: f64,
    /// The exponent at which it is worst.
    pub worst_shininess: f64,
}

/// The small print of a basis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// True if glossy lobes use the diffuse basis too, which costs nothing and halves the error of broad lobes.
    /// A textured diffuse basis cannot be shared, for the texture would show in the highlight.
    pub shared_diffuse: bool,
    /// Error over all integer exponents 1..=200.
    pub error_at_integers: BasisError,
    /// Error between them, which adds the interpolation of coefficients.
    pub error_between: BasisError,
}

/// A basis of the Blinn-Phong space.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfBasis {
    /// How it was made and what it misses.
    pub meta: Meta,
    /// Exponents at which coefficients are stored, increasing.
    pub shininess: Vec<f32>,
    /// Row-major [nodes, bases].
    pub coefficients: Vec<f32>,
    /// Row-major [bases − 1, [`lobe_table::NODES`]].
    pub lobes: Vec<f32>,
}

impl BrdfBasis {
    /// Number of bases, the diffuse one included.
    pub fn bases(&self) -> usize {
        self.lobes.len() / lobe_table::NODES + 1
    }

    /// Coefficients of the unit glossy lobe of exponent `shininess`; outside the stored range the nearest node's.
    pub fn glossy_coefficients(&self, shininess: f32) -> Vec<f32> {
        let bases = self.bases();
        let after = self.shininess.partition_point(|s| *s <= shininess).clamp(1, self.shininess.len() - 1);
        let (s0, s1) = (self.shininess[after - 1], self.shininess[after]);
        let mix = ((shininess - s0) / (s1 - s0)).clamp(0.0, 1.0);
        let row = |node: usize| &self.coefficients[node * bases..(node + 1) * bases];
        row(after - 1).iter().zip(row(after)).map(|(a, b)| a + (b - a) * mix).collect()
    }

    /// RGB coefficients of `material` on every basis (thesis eq. 4-22).
    pub fn coefficients_of(&self, material: &BlinnPhong) -> Vec<Rgb> {
        let mut all: Vec<Rgb> = self.glossy_coefficients(material.shininess).iter().map(|c| material.ks.map(|ks| ks * c)).collect();
        for (sum, kd) in all[0].iter_mut().zip(material.kd) {
            *sum += kd;
        }
        all
    }

    /// Values of every basis function at half angle δ, in sr⁻¹, written to `out` ([`BrdfBasis::bases`] long).
    pub fn evaluate(&self, cos_delta: f32, out: &mut [f32]) {
        let (node, mix) = lobe_table::locate(cos_delta);
        out[0] = FRAC_1_PI;
        for (value, lobe) in out[1..].iter_mut().zip(self.lobes.chunks_exact(lobe_table::NODES)) {
            *value = lobe[node] + (lobe[node + 1] - lobe[node]) * mix;
        }
    }
}

impl Stored for BrdfBasis {
    const KIND: Kind = Kind::BrdfBasis;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let (nodes, bases) = (self.shininess.len() as u64, self.bases() as u64);
        out.record("meta", &self.meta)?;
        out.f32s("shininess", &[nodes], &self.shininess)?;
        out.f32s("coefficients", &[nodes, bases], &self.coefficients)?;
        out.f32s("lobes", &[bases - 1, lobe_table::NODES as u64], &self.lobes)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let meta = sections.take("meta")?.record()?;
        let section = sections.take("shininess")?;
        let shininess = section.f32s()?;
        let nodes = section.length()?;
        let increasing = shininess.windows(2).all(|w| w[0] < w[1]);
        if !(2..=65_536).contains(&nodes) || !increasing {
            return Err(section.invalid("needs 2 to 65536 increasing exponents"));
        }
        section.expect_finite(&shininess)?;

        let section = sections.take("coefficients")?;
        let coefficients = section.f32s()?;
        let bases = coefficients.len() as u64 / nodes;
        if !(2..=MAX_BASES as u64).contains(&bases) {
            return Err(section.invalid(format!("holds {bases} bases, 2 to {MAX_BASES} are allowed")));
        }
        section.expect_shape(&[nodes, bases])?;
        section.expect_finite(&coefficients)?;

        let section = sections.take("lobes")?;
        let lobes = section.f32s()?;
        section.expect_shape(&[bases - 1, lobe_table::NODES as u64])?;
        section.expect_finite(&lobes)?;
        Ok(Self { meta, shininess, coefficients, lobes })
    }
}
