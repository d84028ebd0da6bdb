//! Kind `sphere-set`, version 0: spheres that cover a solid, and the points of its surface that they follow when it deforms (sphere shadows §3.2).
//!
//! | section          | type | shape       | content |
//! |------------------|------|-------------|---------|
//! | `meta`           | u8   | record      | [`Meta`]: the mesh, the settings of the fit, and how good the fit is |
//! | `spheres`        | f32  | [spheres, 4] | centre x, y, z and radius, mesh units; within two diagonals of the vertices' box, and no larger |
//! | `points`         | f32  | [points, 3] | where the points are at rest, mesh units |
//! | `point-vertices` | u32  | [points, 3] | the vertices of the mesh that a point is made of |
//! | `point-weights`  | f32  | [points, 3] | and the weights: at least 0, sum 1 |
//! | `clusters`       | u32  | [points]    | the sphere that a point belongs to; it lies in it, to 10⁻⁵ of the diagonal and what [`Meta::tight`] allows |
//! | `history`        | f32  | [iterations] | E/V(T) after each iteration of the fit, never rising, at the end that of the set; the mean over rest and the poses that the fit looked at |
//!
//! The mesh itself is not stored. Its vertices are the first points, in their order: vertex v is made of v, v, v with weights 1, 0, 0. Points within
//! triangles follow. T is the solid, E = Σ V(Sᵢ − T) the volume of the spheres outside it, each sphere counted by itself.
//! What the points are for stands in [`crate::evaluate::sphere_set`].

use super::names::fault_of_name;
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::Result;
use crate::state::MAX_COORDINATE;
use serde::{Deserialize, Serialize};

/// Most spheres of a set. Players compare every two of them.
pub const MAX_SPHERES: u64 = 4096;
/// How far spheres may be from the box of the vertices, and how large, in its diagonals. One diagonal covers
/// all there is.
const REACH: f64 = 2.0;
/// How far the diagonal of the vertices' box may be from what is stored, in parts of it: for rounding, and
/// for vertices that were moved to meet.
const DIAGONAL_TOLERANCE: f64 = 1e-4;
/// How far outside its sphere a point may lie for roundings, in parts of the diagonal.
const COVER_TOLERANCE: f64 = 1e-5;
/// How far the weights of a point may be from summing to 1.
const WEIGHT_SUM_TOLERANCE: f64 = 1e-5;
/// How far a point may be from where its vertices and weights put it, in parts of the largest coordinate and
/// the diagonal: what the tolerance of the sum and roundings to f32 can make.
const POINT_TOLERANCE: f64 = 2e-5;
/// How much `history` may rise, for its rounding to f32.
const HISTORY_TOLERANCE: f64 = 1e-6;

/// A set of spheres that covers a solid, fitted to its mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SphereSet {
    /// The mesh, the settings of the fit, and how good the fit is.
    pub meta: Meta,
    /// Centre x, y, z and radius of each sphere, mesh units.
    pub spheres: Vec<[f32; 4]>,
    /// The points that the spheres cover and follow, at rest, mesh units: the mesh's vertices in their order,
    /// then points within triangles.
    pub points: Vec<[f32; 3]>,
    /// The vertices that each point is made of; three times itself for a vertex.
    pub point_vertices: Vec<[u32; 3]>,
    /// Their weights, at least 0, sum 1; 1, 0, 0 for a vertex.
    pub point_weights: Vec<[f32; 3]>,
    /// Which sphere each point belongs to.
    pub clusters: Vec<u32>,
    /// What each iteration of the fit left, never rising; the last is that of the spheres stored: E/V(T), or
    /// where the fit looked at poses besides rest, the mean E over all of them, over V(T) at rest.
    pub history: Vec<f32>,
}

/// The small print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Name of the mesh.
    pub mesh: String,
    /// Vertices of the mesh.
    pub vertices: u32,
    /// Triangles of the mesh.
    pub triangles: u32,
    /// Of the random numbers.
    pub seed: u64,
    /// Most iterations that were asked for.
    pub iterations: u32,
    /// How far outside every sphere a point of the solid may lie, in parts of the diagonal; 0: complete
    /// coverage.
    pub tight: f32,
    /// How many poses of the mesh the fit looked at besides rest.
    pub poses: u32,
    /// What counts as the inside of the mesh.
    pub solid: Solid,
    /// Of the mesh's bounding box, mesh units.
    pub diagonal: f32,
    /// V(T): of the solid, cubic mesh units.
    pub volume: f64,
    /// E: the sum over the spheres of the volume that each has outside the solid, cubic mesh units.
    pub outside_volume: f64,
    /// How good the fit is.
    pub quality: Quality,
}

/// What counts as the inside of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solid {
    /// The mesh is closed and bounds its solid: volumes are exact up to rounding.
    Closed,
    /// The mesh is open or meets itself: inside is where the generalised winding number (Jacobson et al.
    /// 2013) is at least 1/2, on a grid.
    WindingNumber {
        /// Cells of the grid along the longest side.
        cells: u32,
    },
}

/// Measures of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Share of the surface's area that lies in a sphere, or within 10⁻⁵ of the diagonal of one.
    pub coverage_surface: f64,
    /// The same of the solid's volume.
    pub coverage_volume: f64,
    /// How far the spheres stand out.
    pub protrusion: Protrusion,
    /// Largest distance from a point of the solid to the nearest sphere, mesh units; 0 where all is covered.
    pub largest_gap: f64,
    /// Σ V(Sᵢ ∩ T) / V(T) − 1: how often the solid is covered more than once; below 0 where it is not covered
    /// whole.
    pub overlap: f64,
}

/// Distance to the mesh over those parts of the spheres' surfaces that lie outside the solid and every other
/// sphere, mesh units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Protrusion {
    /// Mean over the area.
    pub mean: f64,
    /// 95 % of the area is nearer.
    pub p95: f64,
    /// The farthest.
    pub max: f64,
}

impl Meta {
    /// E/V(T).
    pub fn relative_outside_volume(&self) -> f64 {
        self.outside_volume / self.volume
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Self = section.record()?;
        match meta.fault() {
            None => Ok(meta),
            Some(fault) => Err(section.invalid(fault)),
        }
    }

    fn fault(&self) -> Option<String> {
        let Self { vertices, triangles, diagonal, volume, .. } = self;
        if *vertices == 0 || *triangles == 0 || matches!(self.solid, Solid::WindingNumber { cells: 0 }) {
            return Some(format!(
                "{vertices} vertices, {triangles} triangles and {:?} are no solid",
                self.solid
            ));
        }
        if !(is_measure(f64::from(*diagonal)) && is_measure(*volume) && *diagonal > 0.0 && *volume > 0.0) {
            return Some(format!("diagonal {diagonal} and volume {volume} must be numbers above 0"));
        }
        if let Some(fault) = fault_of_name("the mesh", &self.mesh) {
            return Some(fault);
        }
        if !self.relative_outside_volume().is_finite() {
            return Some(format!("outside volume {} and volume {volume} have no ratio", self.outside_volume));
        }
        let measures = [("tight", f64::from(self.tight)), ("outside volume", self.outside_volume)];
        measures
            .into_iter()
            .chain(self.quality.measures())
            .find_map(|(name, value)| is_no_measure(name, value))
            .or_else(|| self.quality.fault())
    }
}

impl Quality {
    fn measures(&self) -> [(&'static str, f64); 6] {
        let Protrusion { mean, p95, max } = self.protrusion;
        [
            ("coverage of the surface", self.coverage_surface),
            ("coverage of the volume", self.coverage_volume),
            ("mean protrusion", mean),
            ("95 % of protrusions", p95),
            ("largest protrusion", max),
            ("largest gap", self.largest_gap),
        ]
    }

    fn fault(&self) -> Option<String> {
        let Protrusion { mean, p95, max } = self.protrusion;
        if self.coverage_surface > 1.0 || self.coverage_volume > 1.0 {
            return Some(format!(
                "coverages {} and {} must be at most 1",
                self.coverage_surface, self.coverage_volume
            ));
        }
        if !self.overlap.is_finite() || self.overlap < -1.0 {
            return Some(format!("overlap {} must be a number of at least -1", self.overlap));
        }
        // A mean of equal values may round up.
        (mean.max(p95) > max * (1.0 + 1e-9))
            .then(|| format!("protrusions {mean} and {p95} must be at most the largest, {max}"))
    }
}

fn is_measure(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

fn is_no_measure(name: &str, value: f64) -> Option<String> {
    (!is_measure(value)).then(|| format!("{name} {value} must be a number of at least 0"))
}

impl Stored for SphereSet {
    const KIND: Kind = Kind::SphereSet;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let points = self.points.len() as u64;
        out.record("meta", &self.meta)?;
        out.f32s("spheres", &[self.spheres.len() as u64, 4], self.spheres.as_flattened())?;
        out.f32s("points", &[points, 3], self.points.as_flattened())?;
        out.u32s("point-vertices", &[points, 3], self.point_vertices.as_flattened())?;
        out.f32s("point-weights", &[points, 3], self.point_weights.as_flattened())?;
        out.u32s("clusters", &[points], &self.clusters)?;
        out.f32s("history", &[self.history.len() as u64], &self.history)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let meta = Meta::decode(sections)?;
        let of_spheres = sections.take("spheres")?;
        let spheres = decode_spheres(&of_spheres)?;
        let points = decode_points(&sections.take("points")?, &meta)?;
        of_spheres.expect(fault_of_spheres(
            &spheres,
            points.get(..meta.vertices as usize).unwrap_or_default(),
            &meta,
        ))?;
        let point_vertices = decode_vertices(&sections.take("point-vertices")?, &meta, points.len())?;
        let point_weights =
            decode_weights(&sections.take("point-weights")?, &meta, &points, &point_vertices)?;
        let section = sections.take("clusters")?;
        section.expect_shape(&[points.len() as u64])?;
        let clusters = section.u32s()?;
        if let Some(at) = clusters.iter().position(|sphere| *sphere as usize >= spheres.len()) {
            return Err(section.invalid(format!("point {at} belongs to a sphere that is not there")));
        }
        of_spheres.expect(fault_of_cover(&spheres, &points, &clusters, &meta))?;
        let history = decode_history(&sections.take("history")?, &meta)?;
        Ok(Self { meta, spheres, points, point_vertices, point_weights, clusters, history })
    }
}

fn decode_spheres(section: &Section) -> Result<Vec<[f32; 4]>> {
    match section.info.shape[..] {
        [1..=MAX_SPHERES, 4] => {}
        _ => {
            return Err(section
                .invalid(format!("has shape {:?}, expected [1 to {MAX_SPHERES}, 4]", section.info.shape)));
        }
    }
    let spheres: Vec<[f32; 4]> = finite_rows(section)?;
    match spheres.iter().position(|[.., radius]| *radius <= 0.0) {
        None => Ok(spheres),
        Some(at) => Err(section.invalid(format!("sphere {at} has a radius that is not above 0"))),
    }
}

/// Spheres stand about their mesh. `vertices` are the mesh's, and their box has the diagonal that is stored.
fn fault_of_spheres(spheres: &[[f32; 4]], vertices: &[[f32; 3]], meta: &Meta) -> Option<String> {
    let along = |axis: usize| vertices.iter().map(move |v| f64::from(v[axis]));
    let low = [0, 1, 2].map(|axis| along(axis).fold(f64::INFINITY, f64::min));
    let high = [0, 1, 2].map(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max));
    let diagonal = (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f64>().sqrt();
    let stored = f64::from(meta.diagonal);
    if (diagonal - stored).abs() > DIAGONAL_TOLERANCE * stored {
        return Some(format!("a mesh of diagonal {stored} is covered, but that of the points is {diagonal}"));
    }
    let most = REACH * stored;
    let is_near = |s: &[f32; 4]| {
        (0..3).all(|k| (low[k] - most..=high[k] + most).contains(&f64::from(s[k]))) && f64::from(s[3]) <= most
    };
    let at = spheres.iter().position(|sphere| !is_near(sphere))?;
    let [x, y, z, radius] = spheres[at];
    Some(format!(
        "sphere {at} of radius {radius:?} about [{x:?}, {y:?}, {z:?}] is larger than {most}, or so far from the mesh"
    ))
}

/// Every point lies in its sphere, as far as the set promises.
fn fault_of_cover(
    spheres: &[[f32; 4]],
    points: &[[f32; 3]],
    clusters: &[u32],
    meta: &Meta,
) -> Option<String> {
    let allowed = (f64::from(meta.tight) + COVER_TOLERANCE) * f64::from(meta.diagonal);
    let outside = |point: &[f32; 3], [x, y, z, radius]: &[f32; 4]| {
        let squares = point.iter().zip([x, y, z]).map(|(p, c)| (f64::from(*p) - f64::from(*c)).powi(2));
        squares.sum::<f64>().sqrt() - f64::from(*radius)
    };
    points.iter().zip(clusters).enumerate().find_map(|(at, (point, cluster))| {
        let outside = spheres.get(*cluster as usize).map_or(f64::INFINITY, |sphere| outside(point, sphere));
        (outside > allowed)
            .then(|| format!("point {at} is {outside} outside its sphere {cluster}, {allowed} is allowed"))
    })
}

fn decode_points(section: &Section, meta: &Meta) -> Result<Vec<[f32; 3]>> {
    match section.info.shape[..] {
        [points, 3] if (u64::from(meta.vertices)..=u64::from(u32::MAX)).contains(&points) => {
            let points: Vec<[f32; 3]> = finite_rows(section)?;
            section.expect_at_most(points.as_flattened(), MAX_COORDINATE)?;
            Ok(points)
        }
        _ => Err(section.invalid(format!(
            "has shape {:?}, expected [at least {}, 3]",
            section.info.shape, meta.vertices
        ))),
    }
}

fn decode_vertices(section: &Section, meta: &Meta, points: usize) -> Result<Vec<[u32; 3]>> {
    section.expect_shape(&[points as u64, 3])?;
    let rows: Vec<[u32; 3]> = section.u32_rows()?;
    if let Some(at) = rows.iter().position(|row| row.iter().any(|v| *v >= meta.vertices)) {
        return Err(section.invalid(format!("point {at} names a vertex that is not there")));
    }
    if let Some((vertex, _)) = (0..meta.vertices).zip(&rows).find(|(vertex, row)| **row != [*vertex; 3]) {
        return Err(section.invalid(format!("point {vertex} is not vertex {vertex}")));
    }
    Ok(rows)
}

fn decode_weights(
    section: &Section,
    meta: &Meta,
    points: &[[f32; 3]],
    vertices: &[[u32; 3]],
) -> Result<Vec<[f32; 3]>> {
    section.expect_shape(&[points.len() as u64, 3])?;
    let rows: Vec<[f32; 3]> = finite_rows(section)?;
    let sum = |row: &[f32; 3]| row.iter().map(|w| f64::from(*w)).sum::<f64>();
    if let Some(at) = rows
        .iter()
        .position(|row| row.iter().any(|w| *w < 0.0) || (sum(row) - 1.0).abs() > WEIGHT_SUM_TOLERANCE)
    {
        return Err(section.invalid(format!("the weights of point {at} are below 0 or do not sum to 1")));
    }
    if let Some(vertex) = rows.iter().take(meta.vertices as usize).position(|row| *row != [1.0, 0.0, 0.0]) {
        return Err(section.invalid(format!("the weights of vertex {vertex} are not 1, 0, 0")));
    }
    let scale = points.as_flattened().iter().fold(f64::from(meta.diagonal), |m, x| m.max(f64::from(x.abs())));
    for (at, ((point, corners), weights)) in
        points.iter().zip(vertices).zip(&rows).enumerate().skip(meta.vertices as usize)
    {
        let made = |axis: usize| {
            corners
                .iter()
                .zip(weights)
                .map(|(v, w)| f64::from(points[*v as usize][axis]) * f64::from(*w))
                .sum::<f64>()
        };
        if (0..3).any(|axis| (made(axis) - f64::from(point[axis])).abs() > POINT_TOLERANCE * scale) {
            return Err(section.invalid(format!("point {at} is not where its vertices and weights put it")));
        }
    }
    Ok(rows)
}

fn decode_history(section: &Section, meta: &Meta) -> Result<Vec<f32>> {
    if section.length()? == 0 {
        return Err(section.invalid("is empty"));
    }
    let history = section.f32s()?;
    section.expect_finite(&history)?;
    let rises = |pair: &[f32]| f64::from(pair[1]) > f64::from(pair[0]) * (1.0 + HISTORY_TOLERANCE);
    match history.windows(2).position(rises) {
        _ if history.iter().any(|e| *e < 0.0) => Err(section.invalid("a volume is negative")),
        None => section.expect(fault_of_end(&history, meta)).map(|()| history),
        Some(at) => Err(section.invalid(format!("rises from element {at} to the next"))),
    }
}

/// The history ends with what the set has, unless it is one of poses too.
fn fault_of_end(history: &[f32], meta: &Meta) -> Option<String> {
    let (last, has) = (history.last().map_or(f64::NAN, |e| f64::from(*e)), meta.relative_outside_volume());
    let ends = meta.poses > 0 || (last - has).abs() <= HISTORY_TOLERANCE * (1.0 + has);
    (!ends).then(|| format!("ends with E/V(T) = {last}, but the set has {has}"))
}

fn finite_rows<const N: usize>(section: &Section) -> Result<Vec<[f32; N]>> {
    let rows: Vec<[f32; N]> = section.f32_rows()?;
    section.expect_finite(rows.as_flattened())?;
    Ok(rows)
}
