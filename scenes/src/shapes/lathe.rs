//! The lathe: a profile turned about +Y, as cups, knobs and chessmen are made.
//!
//! The profile is taken for a curve through its points: where two chords meet, the normal is that of the circle
//! through their three points, which is exact for arcs however their points are spaced. Chords that turn by
//! more than files without normals are smooth over meet in a hard edge; so does what comes to the axis, with
//! its mirror image there.

use crate::geometry::{DEFAULT_CREASE_DEG, Part};
use glam::{DVec2, DVec3};
use relume_formats::state::MAX_COORDINATE;
use relume_formats::{Error, Place, Result};
use std::f64::consts::TAU;

/// Most points of a profile.
const MAX_POINTS: usize = 4096;

/// See the module.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lathe {
    /// (radius, height), with the outside to the right of the way from first to last. Only the ends have
    /// radius 0; where the ends are the same point, the profile is closed.
    points: Vec<DVec2>,
    /// Corners of each circle.
    segments: u32,
}

/// A circle of vertices, or one for each segment on the axis.
struct Row {
    /// Radius and height.
    point: DVec2,
    /// Of the profile, outwards and up; unit.
    normal: DVec2,
    /// Length of the profile up to here.
    along: f64,
}

impl Lathe {
    /// What a profile of (radius, height) gives, whichever end comes first: the outside is away from the axis,
    /// and up for one without volume.
    ///
    /// # Errors
    /// `Invalid` for a profile that bounds nothing or runs into the axis on its way.
    pub fn new(profile: &[[f64; 2]], segments: u32, place: &Place) -> Result<Self> {
        check(profile).map_err(|reason| Error::invalid(place, reason))?;
        let mut points: Vec<DVec2> = profile.iter().copied().map(DVec2::from).collect();
        let sum = |of: &dyn Fn(DVec2, DVec2) -> f64| points.windows(2).map(|w| of(w[0], w[1])).sum::<f64>();
        let volume = sum(&|a, b| (b.y - a.y) * (a.x * a.x + a.x * b.x + b.x * b.x));
        let spread = sum(&|a, b| b.x - a.x);
        if volume < 0.0 || (volume == 0.0 && spread > 0.0) {
            points.reverse();
        }
        Ok(Self { points, segments })
    }

    /// How many triangles [`Lathe::part`] gives.
    pub fn triangles(&self) -> u64 {
        let ends = [self.points.first(), self.points.last()].into_iter().flatten();
        let on_axis = ends.filter(|end| end.x == 0.0).count() as u64;
        (2 * (self.points.len() as u64 - 1) - on_axis) * u64::from(self.segments)
    }

    /// How many vertices [`Lathe::part`] gives.
    pub fn vertices(&self) -> u64 {
        self.rows().0.iter().map(|row| u64::from(self.corners(row))).sum()
    }

    /// The triangles. A texture goes once along the profile, its top at the upper end, and repeats around the
    /// axis as often as leaves it least stretched where the radius is largest.
    pub fn part(&self) -> Part {
        let (rows, bands) = self.rows();
        let length = rows.last().map_or(0.0, |row| row.along);
        let radius = self.points.iter().fold(0.0, |largest: f64, point| largest.max(point.x));
        let repeats = (TAU * radius / length).round().max(1.0);
        let mut part = Part::default();
        let mut firsts = Vec::with_capacity(rows.len());
        for row in &rows {
            firsts.push(part.positions.len() as u32);
            self.add_row(&mut part, row, repeats, length);
        }
        for [lower, upper] in bands {
            let on_axis = [lower, upper].map(|row| rows[row].point.x == 0.0);
            self.add_band(&mut part, [firsts[lower], firsts[upper]], on_axis);
        }
        part
    }

    /// The circles from first to last, and the two that each chord lies between. A circle serves two chords
    /// if these have one normal there.
    fn rows(&self) -> (Vec<Row>, Vec<[usize; 2]>) {
        let (mut rows, mut bands): (Vec<Row>, Vec<_>) = (Vec::new(), Vec::new());
        let mut along = 0.0;
        for (chord, ends) in self.points.windows(2).enumerate() {
            let [first, last] = self.normals(chord);
            if rows.last().is_none_or(|row| row.normal != first) {
                rows.push(Row { point: ends[0], normal: first, along });
            }
            along += ends[0].distance(ends[1]);
            rows.push(Row { point: ends[1], normal: last, along });
            bands.push([rows.len() - 2, rows.len() - 1]);
        }
        (rows, bands)
    }

    /// Normals of the profile at both ends of a chord.
    fn normals(&self, chord: usize) -> [DVec2; 2] {
        let last = self.points.len() - 2;
        let of = |chord: usize| self.points[chord + 1] - self.points[chord];
        let is_closed = self.points[0] == self.points[last + 1];
        let this = of(chord);
        // At the end of the profile: what comes round, or from beyond the axis, or nothing that turns.
        let beyond = |end: DVec2, other: usize| match end.x {
            _ if is_closed => of(other),
            0.0 => DVec2::new(this.x, -this.y),
            _ => this,
        };
        let before = if chord > 0 { of(chord - 1) } else { beyond(self.points[0], last) };
        let after = if chord < last { of(chord + 1) } else { beyond(self.points[last + 1], 0) };
        let flat = outward(this.normalize());
        [(before, this), (this, after)].map(|(a, b)| smooth_normal(a, b).unwrap_or(flat))
    }

    fn corners(&self, row: &Row) -> u32 {
        if row.point.x == 0.0 { self.segments } else { self.segments + 1 }
    }

    fn add_row(&self, part: &mut Part, row: &Row, repeats: f64, length: f64) {
        // What meets on the axis belongs to the middles of segments.
        let middle = if row.point.x == 0.0 { 0.5 } else { 0.0 };
        for corner in 0..self.corners(row) {
            let share = |corner: u32| (f64::from(corner) + middle) / f64::from(self.segments);
            // The last direction is computed as the first one, so that their positions are equal to the bit.
            let (sin, cos) = (TAU * share(corner % self.segments)).sin_cos();
            let turned = |p: DVec2| DVec3::new(cos * p.x, p.y, -sin * p.x).as_vec3().to_array();
            part.positions.push(turned(row.point));
            part.normals.push(turned(row.normal));
            part.uvs.push([(repeats * share(corner)) as f32, (1.0 - row.along / length) as f32]);
        }
    }

    /// The triangles between two rows that begin at the vertices `first`.
    fn add_band(&self, part: &mut Part, [lower, upper]: [u32; 2], on_axis: [bool; 2]) {
        for segment in 0..self.segments {
            let (a, d) = (lower + segment, upper + segment);
            match on_axis {
                [true, _] => part.triangles.push([a, d + 1, d]),
                [_, true] => part.triangles.push([a, a + 1, d]),
                _ => part.triangles.extend([[a, a + 1, d + 1], [a, d + 1, d]]),
            }
        }
    }
}

/// Why a profile bounds no surface, counting points from 1.
fn check(profile: &[[f64; 2]]) -> std::result::Result<(), String> {
    if !(2..=MAX_POINTS).contains(&profile.len()) {
        return Err(format!(
            "the profile has {} of 2 to {MAX_POINTS} points; add or remove some",
            profile.len()
        ));
    }
    let (inner, limit) = (1..profile.len() - 1, f64::from(MAX_COORDINATE));
    for (index, [radius, height]) in profile.iter().copied().enumerate() {
        let number = index + 1;
        if !(0.0..=limit).contains(&radius) {
            return Err(format!(
                "the radius {radius} of point {number} of the profile must be a number of 0 to {limit:e} m"
            ));
        }
        if !(-limit..=limit).contains(&height) {
            return Err(format!(
                "the height {height} of point {number} of the profile must be a number within {limit:e} m"
            ));
        }
        if radius == 0.0 && inner.contains(&index) {
            return Err(format!(
                "point {number} of the profile lies on the axis, where only its ends may; make it two objects"
            ));
        }
        if index > 0 && profile[index - 1] == [radius, height] {
            return Err(format!("points {index} and {number} of the profile are the same; remove one"));
        }
    }
    if profile.iter().all(|[radius, _]| *radius == 0.0) {
        return Err("the whole profile lies on the axis; give a point a radius above 0".to_owned());
    }
    Ok(())
}

/// The normal where two chords meet, unless the edge is hard: across the tangent of the circle through their
/// three points, which divides the turn between them in the proportion of their lengths.
fn smooth_normal(before: DVec2, after: DVec2) -> Option<DVec2> {
    let (length_before, length_after) = (before.length(), after.length());
    let (before, after) = (before / length_before, after / length_after);
    let is_smooth = before.dot(after) >= DEFAULT_CREASE_DEG.to_radians().cos();
    is_smooth.then(|| outward((before * length_after + after * length_before).normalize()))
}

/// To the right of a direction.
fn outward(direction: DVec2) -> DVec2 {
    DVec2::new(direction.y, -direction.x)
}
