//! Kind `sphere-shadows`, version 0: the receivers of the method `sphere-shadows` and the diffuse lobes of their normals (sphere shadows §4.1).
//!
//! | section   | type | shape        | content |
//! |-----------|------|--------------|---------|
//! | `meta`    | u8   | record       | [`Meta`]: the grids, and the objects in the order of the scene |
//! | `rows`    | u32  | [vertices]   | the row of each receiver's lobe, or [`NO_ROW`]: blend the grid's |
//! | `normals` | f32  | [rows, 3]    | unit normals of the rows, world space: first the 384 nodes of the grid, then others |
//! | `lobes`   | f32  | [rows, 6144] | Haar coefficients of ρ̃ = max(0, n·ω)/π · dω in the order of [`crate::basis::haar`], 6 × 32 × 32, to 10⁻⁶ |
//! | `order`   | u16  | [rows, 200]  | the coefficients of each row that matter most, as [`order`] finds them |
//! | `casters` | u32  | [triangles, 3] | corners of the triangles that cast shadows, vertices of the scene: those of each object that casts by its mesh, in order |
//! | `caster_offsets` | f32 | [triangles, 3] | how far each corner is before its vertex, metres along the vertex's normal |
//! | `caster_errors` | f32 | [triangles] | how far, metres, vertices of its object may be from the surface that a triangle stands for, in all poses |
//!
//! Receivers are the vertices of the scene's meshes. Grid and blending are those of [`crate::basis::diffuse`]. A row beyond the grid is exact for its normal
//! and serves receivers that never turn: those of an object that deforms have none. A lobe is cut to its k largest terms by taking the first k of its order;
//! a reader compares all of it, and every lobe with that of its normal. The sphere sets are files of their own, and so are the shapes of objects that deform.

use super::names::fault_of_names;
use crate::basis::cubemap::FACES;
use crate::basis::diffuse::{self, GRID, NODES, grid_normal};
use crate::basis::two_level::SIDE;
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::Result;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Of a receiver whose lobe is blended from the grid's.
pub const NO_ROW: u32 = u32::MAX;
/// Coefficients of a lobe.
pub const COEFFICIENTS: usize = FACES * SIDE * SIDE;
/// Coefficients of a row that are put in order.
pub const ORDERED: usize = 200;
/// Most triangles that cast shadows, of all objects together.
pub const MAX_CASTERS: u64 = 1 << 20;
/// Most rows: their lobes are one section.
pub const MAX_ROWS: u64 = 4096;
/// How far the length of a normal may be from 1, and each coordinate of a node from where the grid has it.
const NORMAL_TOLERANCE: f32 = 1e-5;
/// How far a coefficient of a lobe may be from what its normal gives: some roundings of the largest, 0.04,
/// and what other mathematical libraries make of it.
const LOBE_TOLERANCE: f32 = 1e-6;

/// The receivers of a scene, and the lobes of their normals.
#[derive(Debug, Clone, PartialEq)]
pub struct SphereShadows {
    /// The grids and the objects.
    pub meta: Meta,
    /// For each vertex the row of its lobe, or [`NO_ROW`].
    pub rows: Vec<u32>,
    /// Unit normals of the rows, world space, the nodes of the grid first.
    pub normals: Vec<[f32; 3]>,
    /// Row-major [rows, [`COEFFICIENTS`]].
    pub lobes: Vec<f32>,
    /// Row-major [rows, [`ORDERED`]]: what [`order`] makes of each row.
    pub order: Vec<u16>,
    /// Triangles that cast shadows, by vertices of the scene: those of each object that casts by its mesh.
    pub casters: Vec<[u32; 3]>,
    /// How far their corners are before the vertices, along these' normals, metres.
    pub caster_offsets: Vec<[f32; 3]>,
    /// For each of them how far vertices of its object are at most from where it stands for the surface,
    /// metres.
    pub caster_errors: Vec<f32>,
}

/// The small print.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Meta {
    /// Texels along a side of the faces of lobes, light and visibility: 32.
    pub face_size: u32,
    /// Nodes along a side of the faces of the grid of normals: 8.
    pub normal_grid: u32,
    /// Terms that are kept of the light and of each lobe, over the whole cube: [`FACES`] to [`ORDERED`].
    pub terms: u32,
    /// Whether the sum over terms of the light uses the second level of visibility (the source's "II").
    pub second_level: bool,
    /// The objects in the order of the scene, which own all vertices in turn.
    pub objects: Vec<ShadowObject>,
}

/// An object: a range of vertices, and what is done with them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShadowObject {
    /// Name, unique in the scene.
    pub name: String,
    /// The first vertex, which follows the previous object's last.
    pub first_vertex: u32,
    /// Number of vertices.
    pub vertices: u32,
    /// Whether the bundle has a sphere set of it.
    pub sphere_set: bool,
    /// What it casts shadows by.
    pub casts: Casts,
    /// Whether it deforms.
    pub deforms: bool,
}

/// What an object casts shadows by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Casts {
    /// It casts none.
    Nothing,
    /// Its sphere set.
    Spheres,
    /// Some triangles of its mesh.
    Mesh {
        /// How many.
        triangles: u32,
        /// Whether they are the skin of solids that stand apart, corners counter-clockwise from outside: then no
        /// receiver is within, and one side of them is enough.
        closed: bool,
    },
}

/// The [`ORDERED`] coefficients of `lobe` that matter most: the scaling functions of the faces in their
/// order, for they carry the light as a whole, then wavelets by |coefficient|, the largest first; of equals
/// the one of lower index.
///
/// # Panics
/// If `lobe` has not [`COEFFICIENTS`] elements.
pub fn order(lobe: &[f32]) -> [u16; ORDERED] {
    assert_eq!(lobe.len(), COEFFICIENTS, "a cube of 32 × 32 a face");
    let key = |(index, value): (usize, &f32)| match index % (SIDE * SIDE) {
        0 => index as u64,
        // Bits of positive floats are ordered as the floats are; the upper half of the key is never 0 here.
        _ => (u64::from(!value.abs().to_bits()) << 32) | index as u64,
    };
    let mut keys: Vec<u64> = lobe.iter().enumerate().map(key).collect();
    let (first, ..) = keys.select_nth_unstable(ORDERED);
    first.sort_unstable();
    std::array::from_fn(|k| first[k] as u16)
}

impl SphereShadows {
    /// The Haar coefficients of a row's lobe, [[`COEFFICIENTS`]].
    ///
    /// # Panics
    /// If there is no such row.
    pub fn lobe(&self, row: usize) -> &[f32] {
        &self.lobes[row * COEFFICIENTS..][..COEFFICIENTS]
    }

    /// The coefficients of a row that matter most, in order, [[`ORDERED`]].
    ///
    /// # Panics
    /// If there is no such row.
    pub fn terms(&self, row: usize) -> &[u16] {
        &self.order[row * ORDERED..][..ORDERED]
    }
}

impl Meta {
    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Self = section.record()?;
        match meta.fault() {
            None => Ok(meta),
            Some(fault) => Err(section.invalid(fault)),
        }
    }

    fn fault(&self) -> Option<String> {
        if [self.face_size, self.normal_grid] != [SIDE as u32, GRID as u32] {
            let (face_size, grid) = (self.face_size, self.normal_grid);
            return Some(format!(
                "faces of {face_size} texels and a grid of {grid} nodes a side, expected {SIDE} and {GRID}"
            ));
        }
        if !(FACES..=ORDERED).contains(&(self.terms as usize)) {
            return Some(format!("keeps {} terms, expected {FACES} to {ORDERED}", self.terms));
        }
        let mut next = Some(0u32);
        for ShadowObject { name, first_vertex, vertices, sphere_set, casts, .. } in &self.objects {
            match casts {
                Casts::Spheres if !sphere_set => {
                    return Some(format!("object `{name}` casts shadows by spheres and has none"));
                }
                Casts::Mesh { triangles: 0, .. } => {
                    return Some(format!(
                        "object `{name}` casts shadows by its mesh, but by no triangle of it"
                    ));
                }
                _ => {}
            }
            if *vertices == 0 || Some(*first_vertex) != next {
                return Some(format!(
                    "object `{name}` has {vertices} vertices from {first_vertex} on, which do not follow those before"
                ));
            }
            next = first_vertex.checked_add(*vertices);
        }
        if self.objects.is_empty() {
            return Some("there are no objects".to_owned());
        }
        fault_of_names("objects", self.objects.iter().map(|object| object.name.as_str()))
    }

    /// Triangles that cast shadows, of all objects.
    pub fn casters(&self) -> u64 {
        let of = |object: &ShadowObject| match object.casts {
            Casts::Mesh { triangles, .. } => u64::from(triangles),
            _ => 0,
        };
        self.objects.iter().map(of).sum()
    }

    /// Of all objects.
    pub fn vertices(&self) -> u64 {
        self.objects.iter().map(|object| u64::from(object.vertices)).sum()
    }
}

impl Stored for SphereShadows {
    const KIND: Kind = Kind::SphereShadows;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let rows = self.normals.len() as u64;
        out.record("meta", &self.meta)?;
        out.u32s("rows", &[self.rows.len() as u64], &self.rows)?;
        out.f32s("normals", &[rows, 3], self.normals.as_flattened())?;
        out.f32s("lobes", &[rows, COEFFICIENTS as u64], &self.lobes)?;
        out.u16s("order", &[rows, ORDERED as u64], &self.order)?;
        out.u32s("casters", &[self.casters.len() as u64, 3], self.casters.as_flattened())?;
        out.f32s(
            "caster_offsets",
            &[self.caster_offsets.len() as u64, 3],
            self.caster_offsets.as_flattened(),
        )?;
        out.f32s("caster_errors", &[self.caster_errors.len() as u64], &self.caster_errors)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let meta = Meta::decode(sections)?;
        let rows_section = sections.take("rows")?;
        rows_section.expect_shape(&[meta.vertices()])?;
        let rows = rows_section.u32s()?;
        let normals = decode_normals(&sections.take("normals")?)?;
        if let Some(fault) = fault_of_rows(&meta, &rows, normals.len()) {
            return Err(rows_section.invalid(fault));
        }
        let section = sections.take("lobes")?;
        section.expect_shape(&[normals.len() as u64, COEFFICIENTS as u64])?;
        let lobes = section.f32s()?;
        section.expect_finite(&lobes)?;
        section.expect(fault_of_lobes(&lobes, &normals))?;
        let order = decode_order(&sections.take("order")?, &lobes)?;
        let casters = decode_casters(&sections.take("casters")?, &meta)?;
        let offsets = sections.take("caster_offsets")?;
        offsets.expect_shape(&[meta.casters(), 3])?;
        let caster_offsets: Vec<[f32; 3]> = offsets.f32_rows()?;
        offsets.expect_finite(caster_offsets.as_flattened())?;
        let caster_errors = decode_caster_errors(&sections.take("caster_errors")?, &meta)?;
        Ok(Self { meta, rows, normals, lobes, order, casters, caster_offsets, caster_errors })
    }
}

fn decode_normals(section: &Section) -> Result<Vec<[f32; 3]>> {
    match section.info.shape[..] {
        [rows, 3] if (NODES as u64..=MAX_ROWS).contains(&rows) => {}
        _ => {
            return Err(section.invalid(format!(
                "has shape {:?}, expected [{NODES} to {MAX_ROWS}, 3]",
                section.info.shape
            )));
        }
    }
    let normals: Vec<[f32; 3]> = section.f32_rows()?;
    // Not so with NaN either.
    let is_unit = |n: &[f32; 3]| (Vec3::from(*n).length() - 1.0).abs() <= NORMAL_TOLERANCE;
    if let Some(row) = normals.iter().position(|n| !is_unit(n)) {
        return Err(section.invalid(format!("the normal of row {row} is not of length 1")));
    }
    let is_node =
        |(node, n): (usize, &[f32; 3])| Vec3::from(*n).abs_diff_eq(grid_normal(node), NORMAL_TOLERANCE);
    match normals.iter().take(NODES).enumerate().position(|node| !is_node(node)) {
        None => Ok(normals),
        Some(node) => Err(section.invalid(format!("row {node} is not that node of the grid"))),
    }
}

/// Lobes follow from their normals, so every value can be compared.
fn fault_of_lobes(lobes: &[f32], normals: &[[f32; 3]]) -> Option<String> {
    let is_off = |(stored, right): (&f32, &f32)| (stored - right).abs() > LOBE_TOLERANCE;
    let mut rows = lobes.as_chunks::<COEFFICIENTS>().0.iter().zip(normals).enumerate();
    rows.find_map(|(row, (lobe, normal))| {
        let at = lobe.iter().zip(&diffuse::lobe((*normal).into())).position(is_off)?;
        Some(format!(
            "coefficient {at} of row {row} is {}, which is not that of the lobe of its normal",
            lobe[at]
        ))
    })
}

fn fault_of_rows(meta: &Meta, rows: &[u32], count: usize) -> Option<String> {
    let exact = NODES as u32..count as u32;
    if let Some(vertex) = rows.iter().position(|row| *row != NO_ROW && !exact.contains(row)) {
        return Some(format!(
            "vertex {vertex} has row {}, expected one of {NODES}..{count} or none",
            rows[vertex]
        ));
    }
    let range = |object: &ShadowObject| {
        object.first_vertex as usize..(object.first_vertex + object.vertices) as usize
    };
    let turns = meta
        .objects
        .iter()
        .filter(|object| object.deforms)
        .find(|object| rows[range(object)].iter().any(|row| *row != NO_ROW));
    turns.map(|object| {
        format!("object `{}` deforms, so its vertices cannot have rows of their own", object.name)
    })
}

fn decode_order(section: &Section, lobes: &[f32]) -> Result<Vec<u16>> {
    let lobes = lobes.as_chunks::<COEFFICIENTS>().0;
    section.expect_shape(&[lobes.len() as u64, ORDERED as u64])?;
    let terms = section.u16s()?;
    match terms.as_chunks::<ORDERED>().0.iter().zip(lobes).position(|(terms, lobe)| *terms != order(lobe)) {
        None => Ok(terms),
        Some(row) => {
            Err(section.invalid(format!("the terms of row {row} are not the largest of its lobe in order")))
        }
    }
}

fn decode_casters(section: &Section, meta: &Meta) -> Result<Vec<[u32; 3]>> {
    let count = meta.casters();
    if count > MAX_CASTERS {
        return Err(section.invalid(format!(
            "{count} triangles cast shadows, at most {MAX_CASTERS} may; bake with a larger error"
        )));
    }
    section.expect_shape(&[count, 3])?;
    let casters = section.u32_rows()?;
    let mut next = casters.iter().enumerate();
    for object in &meta.objects {
        let Casts::Mesh { triangles, .. } = object.casts else { continue };
        let own = object.first_vertex..object.first_vertex + object.vertices;
        let is_fine = |[a, b, c]: &[u32; 3]| {
            [a, b, c].iter().all(|vertex| own.contains(vertex)) && a != b && b != c && c != a
        };
        let mut of_object = next.by_ref().take(triangles as usize);
        if let Some((at, triangle)) = of_object.find(|(_, triangle)| !is_fine(triangle)) {
            let name = &object.name;
            return Err(section.invalid(format!(
                "triangle {at} has the corners {triangle:?}, which are not three vertices of object `{name}`"
            )));
        }
    }
    Ok(casters)
}

fn decode_caster_errors(section: &Section, meta: &Meta) -> Result<Vec<f32>> {
    section.expect_shape(&[meta.casters()])?;
    let errors = section.f32s()?;
    match errors.iter().position(|error| !(error.is_finite() && *error >= 0.0)) {
        None => Ok(errors),
        Some(at) => {
            Err(section.invalid(format!("the error of triangle {at} is {}, expected metres", errors[at])))
        }
    }
}
