//! Surfaces over a grid that closes in both directions.

use crate::geometry::Part;
use glam::DVec3;
use std::f64::consts::TAU;

/// The surface with `rows` × `columns` vertices at evenly spaced angles; `vertex` gives position and unit normal, and the surface's
/// outside must be ∂row × ∂column.
pub(super) fn closed_grid(rows: u32, columns: u32, vertex: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Part {
    let mut part = Part::default();
    let angle = |index: u32, count: u32| TAU * f64::from(index) / f64::from(count);
    // Wrapping the indices, not the angles, shares the vertices of the seams.
    let index = |row: u32, column: u32| (row % rows) * columns + column % columns;
    for row in 0..rows {
        for column in 0..columns {
            let (position, normal) = vertex(angle(row, rows), angle(column, columns));
            part.positions.push(position.as_vec3().to_array());
            part.normals.push(normal.as_vec3().to_array());
            let [a, b] = [index(row, column), index(row + 1, column)];
            let [c, d] = [index(row + 1, column + 1), index(row, column + 1)];
            part.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    part
}
