//! What triangles cover of the unit square.

use super::Corners;

/// How many triangles cover the middle of each cell of a grid. Edges are cut the same way from either side, so that
/// of two triangles that share one exactly one has a middle that lies on it.
pub(super) struct Cover {
    side: u32,
    /// Row by row.
    pub counts: Vec<u8>,
    once: u32,
    twice: u32,
}

impl Cover {
    /// Of `side` × `side` cells that nothing covers.
    pub fn new(side: u32) -> Self {
        Self { side, counts: vec![0; (side * side) as usize], once: 0, twice: 0 }
    }

    /// Adds a triangle.
    pub fn add(&mut self, corners: &Corners) {
        let scaled = corners.map(|corner| corner.map(|x| f64::from(x) * f64::from(self.side) - 0.5));
        let rows = scaled.map(|[_, y]| y);
        let (low, high) =
            (rows.iter().copied().fold(f64::INFINITY, f64::min), rows.iter().copied().fold(0.0, f64::max));
        let (first, last) = (self.row(low), self.row(high).min(self.side));
        for row in first..last {
            let mut crossings =
                (0..3).filter_map(|k| crossing(scaled[k], scaled[(k + 1) % 3], f64::from(row)));
            if let Some((a, b)) = crossings.next().zip(crossings.next()) {
                self.fill(row, self.row(a.min(b)), self.row(a.max(b)).min(self.side));
            }
        }
    }

    /// The first row, or column, at or after `x`.
    fn row(&self, x: f64) -> u32 {
        x.ceil().clamp(0.0, f64::from(self.side)) as u32
    }

    fn fill(&mut self, row: u32, from: u32, to: u32) {
        for column in from..to {
            let count = &mut self.counts[(row * self.side + column) as usize];
            *count = count.saturating_add(1);
            match *count {
                1 => self.once += 1,
                2 => self.twice += 1,
                _ => {}
            }
        }
    }

    /// What part of the square is covered at all.
    pub fn once(&self) -> f64 {
        f64::from(self.once) / f64::from(self.side * self.side)
    }

    /// What part of it is so twice, or more often.
    pub fn twice(&self) -> f64 {
        f64::from(self.twice) / f64::from(self.side * self.side)
    }
}

/// Where an edge crosses a row, if it does: from the row of its upper end on, before that of its lower one.
fn crossing(a: [f64; 2], b: [f64; 2], row: f64) -> Option<f64> {
    // Either side of an edge has its ends in another order.
    let (a, b) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
    (a[1] <= row && row < b[1]).then(|| a[0] + (b[0] - a[0]) * ((row - a[1]) / (b[1] - a[1])))
}

/// Of a triangle, in parts of the square; positive if its corners go clockwise in a picture.
pub(super) fn signed_area([a, b, c]: &Corners) -> f64 {
    let [a, b, c] = [a, b, c].map(|corner| corner.map(f64::from));
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}
