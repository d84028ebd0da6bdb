//! The surface where a mesh's winding number is 1/2, by marching tetrahedra (Doi and Koide 1991) on a grid:
//! closed whatever the mesh is like.

use super::super::triangle_tree::TriangleTree;
use glam::{DVec3, UVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Cells beyond the mesh's box on each side.
const PADDING: f64 = 2.0;
/// Where the grid starts within the padding, in cells: odd shares, so that planes of a mesh that is itself on
/// some grid do not meet its corners.
const SHIFT: DVec3 = DVec3::new(0.371, 0.413, 0.317);
/// Most halvings of a grid's edge on which the winding number jumps.
const HALVINGS: u32 = 8;
/// Where it differs by less along an edge it is taken for linear.
const SMOOTH: f64 = 0.1;
/// The six tetrahedra of a cell, around its diagonal: the axes in the order in which each walks them.
const WALKS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// An edge of the grid: its ends, the lower first.
type Edge = [u32; 2];

/// Winding numbers at the corners of a grid.
struct Grid<'a> {
    mesh: &'a TriangleTree,
    origin: DVec3,
    cell: f64,
    /// Corners along each axis.
    size: UVec3,
    /// Their winding numbers, x fastest.
    values: Vec<f64>,
}

/// Vertices, triangles that face outwards, and the side of a cell. Each edge of the triangles is run once
/// each way.
pub fn isosurface(mesh: &TriangleTree, cells: u32) -> (Vec<DVec3>, Vec<[u32; 3]>, f64) {
    let grid = Grid::new(mesh, cells);
    let edges: Vec<[Edge; 3]> =
        (0..grid.size.z.saturating_sub(1)).into_par_iter().flat_map_iter(|z| grid.slab(z)).collect();
    let mut index = HashMap::new();
    let mut unique = Vec::new();
    let mut number = |edge: Edge| {
        *index.entry(edge).or_insert_with(|| {
            unique.push(edge);
            unique.len() as u32 - 1
        })
    };
    let triangles = edges.iter().map(|t| t.map(&mut number)).collect();
    let vertices = unique.par_iter().map(|edge| grid.crossing(*edge)).collect();
    (vertices, triangles, grid.cell)
}

impl<'a> Grid<'a> {
    fn new(mesh: &'a TriangleTree, cells: u32) -> Self {
        let (min, max) = mesh.nodes.first().map_or((DVec3::ZERO, DVec3::ZERO), |root| (root.min, root.max));
        let cell = ((max - min).max_element() / f64::from(cells)).max(f64::MIN_POSITIVE);
        let size = ((max - min) / cell + 2.0 * PADDING + 2.0).ceil().as_uvec3();
        let mut grid = Self { mesh, origin: min - (SHIFT + PADDING) * cell, cell, size, values: Vec::new() };
        grid.values = (0..size.element_product()).into_par_iter().map(|i| grid.value(i)).collect();
        grid
    }

    fn value(&self, index: u32) -> f64 {
        let at = self.corner(index);
        // Nothing that a mesh encloses reaches here, so that the surface closes.
        if (at.cmpeq(UVec3::ZERO) | at.cmpeq(self.size - 1)).any() {
            0.0
        } else {
            self.mesh.winding_number(self.position(index))
        }
    }

    fn corner(&self, index: u32) -> UVec3 {
        UVec3::new(
            index % self.size.x,
            index / self.size.x % self.size.y,
            index / (self.size.x * self.size.y),
        )
    }

    fn index(&self, at: UVec3) -> u32 {
        at.x + self.size.x * (at.y + self.size.y * at.z)
    }

    fn position(&self, index: u32) -> DVec3 {
        self.origin + self.corner(index).as_dvec3() * self.cell
    }

    fn is_inside(&self, index: u32) -> bool {
        self.values[index as usize] >= 0.5
    }

    /// The triangles of one layer of cells, by the grid's edges that their corners lie on.
    fn slab(&self, z: u32) -> Vec<[Edge; 3]> {
        let mut found = Vec::new();
        for y in 0..self.size.y - 1 {
            for x in 0..self.size.x - 1 {
                self.add_cell(UVec3::new(x, y, z), &mut found);
            }
        }
        found
    }

    fn add_cell(&self, lowest: UVec3, found: &mut Vec<[Edge; 3]>) {
        for (i, walk) in WALKS.iter().enumerate() {
            let mut at = lowest;
            let mut corners = [self.index(at); 4];
            for (corner, axis) in corners[1..].iter_mut().zip(walk) {
                at[*axis] += 1;
                *corner = self.index(at);
            }
            // The first three orders are even permutations, with positive volume; the others are their
            // mirrors.
            if i >= 3 {
                corners.swap(2, 3);
            }
            self.add_tetrahedron(corners, found);
        }
    }

    /// `corners` have positive volume: seen from the first, the others run clockwise.
    fn add_tetrahedron(&self, corners: [u32; 4], found: &mut Vec<[Edge; 3]>) {
        let edge = |i: usize, j: usize| [corners[i].min(corners[j]), corners[i].max(corners[j])];
        // Even permutations of the corners, with those that are inside first.
        let inside = corners.map(|c| self.is_inside(c));
        let mut cut = |[a, b, c, d]: [usize; 4], count: usize| match count {
            1 => found.push([edge(a, b), edge(a, c), edge(a, d)]),
            2 => found.extend([[edge(a, c), edge(a, d), edge(b, d)], [edge(a, c), edge(b, d), edge(b, c)]]),
            _ => found.push([edge(d, a), edge(d, b), edge(d, c)]),
        };
        match inside {
            [true, false, false, false] => cut([0, 1, 2, 3], 1),
            [false, true, false, false] => cut([1, 0, 3, 2], 1),
            [false, false, true, false] => cut([2, 3, 0, 1], 1),
            [false, false, false, true] => cut([3, 2, 1, 0], 1),
            [true, true, false, false] => cut([0, 1, 2, 3], 2),
            [true, false, true, false] => cut([0, 2, 3, 1], 2),
            [true, false, false, true] => cut([0, 3, 1, 2], 2),
            [false, true, true, false] => cut([1, 2, 0, 3], 2),
            [false, true, false, true] => cut([1, 3, 2, 0], 2),
            [false, false, true, true] => cut([2, 3, 0, 1], 2),
            [true, true, true, false] => cut([0, 1, 2, 3], 3),
            [true, true, false, true] => cut([1, 0, 3, 2], 3),
            [true, false, true, true] => cut([2, 3, 0, 1], 3),
            [false, true, true, true] => cut([3, 2, 1, 0], 3),
            [false, false, false, false] | [true, true, true, true] => {}
        }
    }

    /// Where the winding number passes 1/2 on an edge: halved where it jumps, then linear.
    fn crossing(&self, edge: Edge) -> DVec3 {
        let mut ends = edge.map(|i| (self.position(i), self.values[i as usize]));
        for _ in 0..HALVINGS {
            if (ends[0].1 - ends[1].1).abs() < SMOOTH {
                break;
            }
            let middle = ends[0].0.midpoint(ends[1].0);
            let value = self.mesh.winding_number(middle);
            let side = usize::from((value >= 0.5) != (ends[0].1 >= 0.5));
            ends[side] = (middle, value);
        }
        let [(a, from), (b, to)] = ends;
        a.lerp(b, ((0.5 - from) / (to - from)).clamp(0.0, 1.0))
    }
}
