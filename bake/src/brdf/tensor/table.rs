//! Where lobes are evaluated, and their means over the cells of the disc.
//!
//! A cell holds a grid of points, evenly spaced in angle and azimuth, as fine as the sharpest lobes of the
//! spaces ask for. Points stand for the exact solid angle, and the exact area on the disc, of what is around
//! them.

use crate::brdf;
use glam::{DVec3, Vec3A};
use relume_formats::basis::disc::{self, AZIMUTHS, RINGS};
use relume_formats::state::Brdf;
use std::f64::consts::TAU;

/// Cells of a ring that mirror those of the other half, both ends included.
pub const HALF: usize = AZIMUTHS / 2 + 1;
/// Points across a ring.
const ACROSS: usize = 12;
/// Points along a cell, an even number.
const ALONG: usize = 4;

/// The points of half a hemisphere about +Z, y ≥ 0; each counts for the one that mirrors it, too.
pub struct Points {
    /// Unit vectors.
    pub directions: Vec<DVec3>,
    /// Solid angle, of both.
    pub solid_angle: Vec<f64>,
    /// Solid angle times cosine, of both.
    pub area: Vec<f64>,
    /// [ring, [`HALF`]].
    cell: Vec<usize>,
}

impl Points {
    /// As fine as the constants say.
    pub fn new() -> Self {
        let mut points =
            Self { directions: Vec::new(), solid_angle: Vec::new(), area: Vec::new(), cell: Vec::new() };
        let step = TAU / (AZIMUTHS * ALONG) as f64;
        for (ring, part) in (0..RINGS).flat_map(|ring| (0..ACROSS).map(move |part| (ring, part))) {
            let [inner, outer] = [ring, ring + 1].map(|edge| (edge as f64 / RINGS as f64).asin());
            let at = |share: f64| inner + (outer - inner) * (part as f64 + share) / ACROSS as f64;
            let [from, middle, to] = [0.0, 0.5, 1.0].map(at);
            for along in 0..AZIMUTHS * ALONG / 2 {
                let angle = step * (along as f64 + 0.5);
                let r = middle.sin();
                points.directions.push(DVec3::new(r * angle.cos(), r * angle.sin(), middle.cos()));
                points.solid_angle.push(2.0 * step * (from.cos() - to.cos()));
                points.area.push(step * (to.sin().powi(2) - from.sin().powi(2)));
                points.cell.push(ring * HALF + (along + ALONG / 2) / ALONG);
            }
        }
        points
    }

    /// What a lobe reflects towards `outgoing`, a unit vector in the azimuth of +X, of unit radiance from
    /// each point: the integral of BRDF and cosine over it.
    pub fn arriving(&self, lobe: &Brdf, outgoing: DVec3) -> Vec<f64> {
        let outgoing = outgoing.as_vec3a();
        let value = |(incoming, area): (&DVec3, &f64)| {
            let angles = brdf::angles(incoming.as_vec3a(), outgoing, Vec3A::Z);
            f64::from(brdf::evaluate(lobe, Vec3A::ONE, &angles).x) * area
        };
        self.directions.iter().zip(&self.area).map(value).collect()
    }

    /// Sums over the points of each cell, over its area: [ring, [`HALF`]].
    pub fn over_cells(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; RINGS * HALF];
        for (value, cell) in values.iter().zip(&self.cell) {
            if let Some(sum) = sums.get_mut(*cell) {
                *sum += value;
            }
        }
        // Points of inner azimuths count for two cells.
        let cells_of = |azimuth: usize| if azimuth == 0 || azimuth == HALF - 1 { 1.0 } else { 2.0 };
        let area = |cell: usize| disc::weight(cell / HALF) * cells_of(cell % HALF);
        sums.iter_mut().enumerate().for_each(|(cell, sum)| *sum /= area(cell));
        sums
    }
}

#[cfg(test)]
impl Points {
    /// The same value for all points of a cell, times their areas.
    pub fn spread(&self, over_cells: &[f64]) -> Vec<f64> {
        self.cell.iter().zip(&self.area).map(|(cell, area)| over_cells[*cell] * area).collect()
    }
}
