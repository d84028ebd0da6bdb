//! The angles from the normal that lobes are tabulated at, evenly spaced from 0 to 90 degrees, both included.

use std::f32::consts::FRAC_PI_2;

/// Nodes.
pub const NODES: usize = 31;

/// The angle of a node, radians.
pub fn theta(node: usize) -> f64 {
    std::f64::consts::FRAC_PI_2 * node as f64 / (NODES - 1) as f64
}

/// The node before the angle `theta`, radians, and the share that the next one has: what lies between is
/// linear. Angles below the horizon are taken for the horizon.
pub fn locate(theta: f32) -> (usize, f32) {
    let at = (theta / FRAC_PI_2 * (NODES - 1) as f32).clamp(0.0, (NODES - 1) as f32);
    let node = (at as usize).min(NODES - 2);
    (node, at - node as f32)
}

/// A row of a table [[`NODES`], `columns`] at an angle.
pub(super) fn row(table: &[f32], columns: usize, theta: f32) -> Vec<f32> {
    let (node, share) = locate(theta);
    let mut rows = table.chunks_exact(columns.max(1)).skip(node);
    let (before, after) = (rows.next().unwrap_or_default(), rows.next().unwrap_or_default());
    before.iter().zip(after).map(|(a, b)| a + share * (b - a)).collect()
}
