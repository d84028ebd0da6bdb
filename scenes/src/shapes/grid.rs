//! Surfaces over a grid that closes in both directions.

use crate::geometry::Part;
use glam::DVec3;
use std::f64::consts::TAU;

/// The surface with `rows` × `columns` faces at evenly spaced angles; `vertex` gives position and unit
/// normal, and the surface's outside must be ∂row × ∂column. A texture repeats `repeats` times over the rows
/// and once over the columns, and stands upright if columns go up. Where the grid closes, vertices lie on
/// each other, for their texture coordinates differ.
pub(super) fn closed_grid(
    rows: u32,
    columns: u32,
    repeats: f64,
    vertex: impl Fn(f64, f64) -> (DVec3, DVec3),
) -> Part {
    let mut part = Part::default();
    // The last vertex is computed as the first one, not a turn later, so that their positions are equal to
    // the bit.
    let angle = |index: u32, count: u32| TAU * f64::from(index % count) / f64::from(count);
    let index = |row: u32, column: u32| row * (columns + 1) + column;
    for row in 0..=rows {
        for column in 0..=columns {
            let (position, normal) = vertex(angle(row, rows), angle(column, columns));
            part.positions.push(position.as_vec3().to_array());
            part.normals.push(normal.as_vec3().to_array());
            let (along, across) = (f64::from(row) / f64::from(rows), f64::from(column) / f64::from(columns));
            part.uvs.push([(repeats * along) as f32, (1.0 - across) as f32]);
        }
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b] = [index(row, column), index(row + 1, column)];
        let [c, d] = [index(row + 1, column + 1), index(row, column + 1)];
        part.triangles.extend([[a, b, c], [a, c, d]]);
    }
    part
}
