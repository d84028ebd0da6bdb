//! Kind `transfer-tensor`, version 0: for every vertex what it makes of any environment and, by way of materials that
//! vary, of what other surfaces reflect (thesis §5.3.3).
//!
//! | section       | type | shape                            | content |
//! |---------------|------|----------------------------------|---------|
//! | `meta`        | u8   | record                           | [`Meta`] |
//! | `index/NNNN`  | u16  | [terms, vertices]                | block NNNN: which coefficient of the light each term multiplies |
//! | `scale/NNNN`  | f16  | [vertices, columns]              | what a step of the block's values is worth, in [`Meta::unit`]; at least 0 |
//! | `value/NNNN`  | i8   | [terms, vertices, columns]       | its values in steps |
//! | `seen`        | u8   | [vertices, 576]                  | behind block 0: the visible part of each texel of [`crate::basis::hemisphere`], 255 is all |
//! | `cluster`     | u16  | [vertices]                       | with reflected light: the cluster of each vertex |
//! | `share`       | i8   | [vertices, sources, M]           | how much of each of its cluster's functions a vertex has, in 127ths |
//! | `core`        | f16  | [clusters, sources, M, N, 16]    | what they are made of, by functions of the light and spherical harmonics |
//! | `light`       | f16  | [clusters, sources, N, 384]      | the functions of the light, by Haar coefficients of 8 × 8 texels a face |
//! | `twice-share` | i8   | [vertices, vectors]              | the same of light that was reflected twice |
//! | `twice`       | f16  | [clusters, vectors, 24, pairs]   | by Haar coefficients of 2 × 2 texels a face |
//!
//! **Direct light.** A vertex has [`Meta::columns`] numbers for each channel: ∫ L·V·cosθ·c_k dω with c_k the columns of the BRDF space of
//! its material ([`super::BrdfTensor::columns`]), the first of which, 1/π, gives the radiance of a white diffuse surface. L is the map
//! without its suns, Haar-transformed as for kind `sparse-transfer`, on faces of 64 × 64 texels. Columns that a vertex's space does not have are 0.
//! Blocks come with the most important terms first: any number of whole blocks is a coarser bake.
//!
//! **Reflected light** is lit by the whole map. A *source* is what reflected it: a function of a material that varies, or the fixed materials
//! together in one channel ([`Source`]). The radiance that arrives after one reflection is Σ weight(source) · share · core · light ·
//! coefficient, as 16 spherical harmonics in world space ([`crate::basis::sh`]); of light that was reflected twice, irradiance over π is
//! stored, by [`Meta::pairs`] of sources.

mod direct;
mod reflected;

pub use direct::{BLOCK_SECTIONS, Block};
pub use reflected::{ONCE_SECTIONS, Once, Source, TWICE_SECTIONS, Twice, pairs, weights};

use crate::basis::cubemap::FACES;
use crate::basis::hemisphere;
use crate::basis::sh;
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// Texels along a side of a face of the light that shines directly.
pub const FACE_SIZE: usize = 64;
/// The same of the light that other surfaces reflect once (thesis §5.3.3.4).
pub const ONCE_FACE_SIZE: usize = 8;
/// The same of what they reflect twice.
pub const TWICE_FACE_SIZE: usize = 2;
/// Haar coefficients of the light that is reflected once.
pub const ONCE_LIGHT: usize = FACES * ONCE_FACE_SIZE * ONCE_FACE_SIZE;
/// The same of what is reflected twice.
pub const TWICE_LIGHT: usize = FACES * TWICE_FACE_SIZE * TWICE_FACE_SIZE;
/// Most reflections.
pub const MAX_REFLECTIONS: u32 = 3;
/// Most columns of a vertex.
pub const MAX_COLUMNS: u32 = 33;
/// Most terms of a row.
pub const MAX_TERMS: u64 = 1024;
/// Most sources of reflected light.
pub const MAX_SOURCES: usize = 64;
/// Most clusters.
pub const MAX_CLUSTERS: u32 = 1 << 12;
/// Most functions of a cluster, of either kind.
pub const MAX_RANK: u32 = 128;

/// The small print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Number of vertices.
    pub vertices: u32,
    /// Numbers that direct light has at a vertex, for each channel.
    pub columns: u32,
    /// Terms of each block, in the order of the file.
    pub blocks: Vec<u32>,
    /// What a stored 1 is worth.
    pub unit: f32,
    /// Rays a texel where visibility changes.
    pub rays_per_texel: u32,
    /// Reflections, the one towards the eye included: 1 to [`MAX_REFLECTIONS`].
    pub reflections: u32,
    /// What reflects; nothing where light reflects once.
    pub sources: Vec<Source>,
    /// Number of clusters of vertices; 0 without sources.
    pub clusters: u32,
    /// Functions of a cluster for each source: of vertices, M, and of the light, N.
    pub ranks: [u32; 2],
    /// Vectors of a cluster for light that was reflected twice; 0 where there is none.
    pub vectors: u32,
}

/// A whole file.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferTensor {
    /// The small print.
    pub meta: Meta,
    /// As many blocks as the meta lists.
    pub blocks: Vec<Block>,
    /// Row-major [vertices, [`hemisphere::TEXELS`]].
    pub seen: Vec<u8>,
    /// Light reflected once before it arrives.
    pub once: Option<Once>,
    /// Light reflected twice.
    pub twice: Option<Twice>,
}

impl Meta {
    /// Number of terms of a row.
    pub fn terms(&self) -> usize {
        self.blocks.iter().map(|terms| *terms as usize).sum()
    }

    /// The pairs of sources of light that was reflected twice, see [`pairs`].
    pub fn pairs(&self) -> Vec<[usize; 2]> {
        pairs(&self.sources)
    }

    /// Reads the first section.
    ///
    /// # Errors
    /// If it is broken.
    pub fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Self = section.record()?;
        section.expect(meta.fault())?;
        Ok(meta)
    }

    fn fault(&self) -> Option<String> {
        let terms: u64 = self.blocks.iter().map(|terms| u64::from(*terms)).sum();
        let empty = self.blocks.is_empty() || self.blocks.contains(&0);
        if self.vertices == 0 || empty || terms > MAX_TERMS {
            return Some(format!(
                "{} vertices of {terms} terms; a row has 1 to {MAX_TERMS}, and no block is empty",
                self.vertices
            ));
        }
        let unit = self.unit.is_finite() && self.unit > 0.0;
        if !unit || !(1..=MAX_COLUMNS).contains(&self.columns) {
            return Some(format!("{} columns in units of {} are out of range", self.columns, self.unit));
        }
        self.fault_of_reflections()
    }

    fn fault_of_reflections(&self) -> Option<String> {
        let Self { reflections, clusters, ranks: [m, n], vectors, .. } = *self;
        if !(1..=MAX_REFLECTIONS).contains(&reflections) || self.sources.len() > MAX_SOURCES {
            return Some(format!(
                "{reflections} reflections by {} sources are out of range",
                self.sources.len()
            ));
        }
        let once = reflections > 1;
        let fits =
            |count: u32, most: u32, there: bool| if there { (1..=most).contains(&count) } else { count == 0 };
        let sound = self.sources.is_empty() != once
            && fits(clusters, MAX_CLUSTERS, once)
            && fits(m, MAX_RANK, once)
            && fits(n, MAX_RANK, once)
            && fits(vectors, MAX_RANK, reflections > 2);
        if !sound {
            return Some(format!(
                "{reflections} reflections, {} sources, {clusters} clusters of {m}, {n} and {vectors} functions do not \
                 go together",
                self.sources.len()
            ));
        }
        self.sources.iter().find_map(Source::fault)
    }

    fn expect_clusters(&self, section: &Section, clusters: &[u16]) -> Result<()> {
        let strange = clusters.iter().position(|cluster| u32::from(*cluster) >= self.clusters);
        section.expect(strange.map(|vertex| format!("vertex {vertex} is of a cluster that is not there")))
    }
}

impl TransferTensor {
    /// Checks all sections, one after the other, and returns the small print.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn checked_meta(sections: &mut Sections<'_>) -> Result<Meta> {
        let meta = Meta::decode(sections)?;
        for number in 0..meta.blocks.len() {
            meta.decode_block(number, sections)?;
            if number == 0 {
                meta.decode_seen(sections)?;
            }
        }
        meta.decode_once(sections)?;
        meta.decode_twice(sections)?;
        Ok(meta)
    }
}

impl Meta {
    /// Reads what vertices see, [vertices, [`hemisphere::TEXELS`]], which stands behind the first block.
    ///
    /// # Errors
    /// If it is of another size.
    pub fn decode_seen(&self, sections: &mut Sections<'_>) -> Result<Vec<u8>> {
        let section = sections.take("seen")?;
        section.expect_shape(&[u64::from(self.vertices), hemisphere::TEXELS as u64])?;
        section.u8s()
    }

    /// Reads the light that was reflected once, if there is any.
    ///
    /// # Errors
    /// If it is broken.
    pub fn decode_once(&self, sections: &mut Sections<'_>) -> Result<Option<Once>> {
        if self.reflections < 2 {
            return Ok(None);
        }
        let [v, s, c] = [self.vertices, self.sources.len() as u32, self.clusters].map(u64::from);
        let [m, n] = self.ranks.map(u64::from);
        let section = sections.take("cluster")?;
        section.expect_shape(&[v])?;
        let clusters = section.u16s()?;
        self.expect_clusters(&section, &clusters)?;
        let section = sections.take("share")?;
        section.expect_shape(&[v, s, m])?;
        let shares = section.i8s()?;
        let core = halves(sections, "core", &[c, s, m, n, sh::COUNT as u64])?;
        let light = halves(sections, "light", &[c, s, n, ONCE_LIGHT as u64])?;
        Ok(Some(Once { clusters, shares, core, light }))
    }

    /// Reads the light that was reflected twice, if there is any.
    ///
    /// # Errors
    /// If it is broken.
    pub fn decode_twice(&self, sections: &mut Sections<'_>) -> Result<Option<Twice>> {
        if self.reflections < 3 {
            return Ok(None);
        }
        let [v, c, vectors] = [self.vertices, self.clusters, self.vectors].map(u64::from);
        let section = sections.take("twice-share")?;
        section.expect_shape(&[v, vectors])?;
        let shares = section.i8s()?;
        let pairs = self.pairs().len() as u64;
        let vectors = halves(sections, "twice", &[c, vectors, TWICE_LIGHT as u64, pairs])?;
        Ok(Some(Twice { shares, vectors }))
    }
}

fn halves(sections: &mut Sections<'_>, name: &str, shape: &[u64]) -> Result<Vec<half::f16>> {
    let section = sections.take(name)?;
    section.expect_shape(shape)?;
    let values = section.f16s()?;
    let strange = values.iter().position(|value| !value.is_finite());
    section.expect(strange.map(|at| format!("element {at} is not a finite number")))?;
    Ok(values)
}

impl Stored for TransferTensor {
    const KIND: Kind = Kind::TransferTensor;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let Meta { vertices, columns, clusters, ranks, vectors, .. } = self.meta;
        let [v, k, c, vectors] = [vertices, columns, clusters, vectors].map(u64::from);
        let ([m, n], s) = (ranks.map(u64::from), self.meta.sources.len() as u64);
        out.record("meta", &self.meta)?;
        for (number, (block, terms)) in self.blocks.iter().zip(&self.meta.blocks).enumerate() {
            let terms = u64::from(*terms);
            out.u16s(&format!("index/{number:04}"), &[terms, v], &block.indices)?;
            out.f16s(&format!("scale/{number:04}"), &[v, k], &block.scales)?;
            out.i8s(&format!("value/{number:04}"), &[terms, v, k], &block.steps)?;
            if number == 0 {
                out.u8s("seen", &[v, hemisphere::TEXELS as u64], &self.seen)?;
            }
        }
        if let Some(Once { clusters, shares, core, light }) = &self.once {
            out.u16s("cluster", &[v], clusters)?;
            out.i8s("share", &[v, s, m], shares)?;
            out.f16s("core", &[c, s, m, n, sh::COUNT as u64], core)?;
            out.f16s("light", &[c, s, n, ONCE_LIGHT as u64], light)?;
        }
        if let Some(twice) = &self.twice {
            out.i8s("twice-share", &[v, vectors], &twice.shares)?;
            let pairs = self.meta.pairs().len() as u64;
            out.f16s("twice", &[c, vectors, TWICE_LIGHT as u64, pairs], &twice.vectors)?;
        }
        Ok(())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let meta = Meta::decode(sections)?;
        let (mut blocks, mut seen) = (Vec::new(), Vec::new());
        for number in 0..meta.blocks.len() {
            blocks.push(meta.decode_block(number, sections)?);
            if number == 0 {
                seen = meta.decode_seen(sections)?;
            }
        }
        let once = meta.decode_once(sections)?;
        let twice = meta.decode_twice(sections)?;
        Ok(Self { meta, blocks, seen, once, twice })
    }

    fn check(sections: &mut Sections<'_>) -> Result<()> {
        Self::checked_meta(sections).map(drop)
    }
}
