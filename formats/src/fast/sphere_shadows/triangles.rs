//! The triangles of meshes in the bitmaps of a group of receivers.
//!
//! Receivers of a group are near each other, so most of what has to be found out of a triangle is the same for all
//! of them: whether it counts for any, which faces it may reach, and which rows there. That is found for a box
//! around the group, for sixteen triangles at once ([`Block`]). What is left of a triangle is then added to the
//! rows of all receivers at once, exactly.

#![allow(clippy::needless_range_loop, reason = "loops over lanes and axes of many arrays become vector code")]

use super::caps::{Group, Rows, all_if};
use super::{LANES, Lanes};
use crate::basis::cubemap::{FACES, FRAMES};
use crate::basis::span::{Edge, centre, may_reach, plane, row_range, span};
use crate::basis::two_level::SIDE;
use crate::evaluate::sphere_shadows::{Sides, Triangle};

/// Room for roundings in the box around a group, in parts of the largest coordinate.
const ROUNDING: f32 = 1.0 / (1 << 20) as f32;

/// Triangles, a lane each; lanes beyond the last are of a triangle that has no plane and so counts nowhere.
pub(super) struct Block {
    corners: [[Lanes<f32>; 3]; 3],
    normal: [Lanes<f32>; 3],
    object: Lanes<u32>,
    /// For receivers of its own object, and for others.
    above: [Lanes<f32>; 2],
    below: [Lanes<f32>; 2],
}

impl Block {
    /// All of `triangles`, sixteen a block.
    pub(super) fn of_all(triangles: &[Triangle]) -> Vec<Self> {
        triangles.chunks(LANES).map(Self::new).collect()
    }

    fn new(triangles: &[Triangle]) -> Self {
        let mut block = Self {
            corners: [[[0.0; LANES]; 3]; 3],
            normal: [[f32::NAN; LANES]; 3],
            object: [0; LANES],
            above: [[f32::INFINITY; LANES]; 2],
            below: [[f32::INFINITY; LANES]; 2],
        };
        for (lane, triangle) in triangles.iter().enumerate() {
            for axis in 0..3 {
                for corner in 0..3 {
                    block.corners[corner][axis][lane] = triangle.corners[corner][axis];
                }
                block.normal[axis][lane] = triangle.normal[axis];
            }
            block.object[lane] = triangle.object;
            for (k, Sides { above, below }) in triangle.sides.iter().enumerate() {
                (block.above[k][lane], block.below[k][lane]) = (*above, *below);
            }
        }
        block
    }

    /// The triangle of a lane.
    #[inline(always)]
    fn triangle(&self, lane: usize) -> Triangle {
        let side = |k: usize| Sides { above: self.above[k][lane], below: self.below[k][lane] };
        Triangle {
            corners: self.corners.each_ref().map(|corner| corner.each_ref().map(|axis| axis[lane])),
            normal: self.normal.each_ref().map(|axis| axis[lane]),
            object: self.object[lane],
            sides: [side(0), side(1)],
        }
    }
}

/// A box around the receivers of a group.
struct Around {
    centre: [f32; 3],
    half: [f32; 3],
}

impl Around {
    #[inline(always)]
    fn new(group: &Group) -> Self {
        let (mut centre, mut half) = ([0.0; 3], [0.0; 3]);
        let mut largest = 0.0f32;
        for axis in 0..3 {
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for x in group.position[axis] {
                low = low.min(x);
                high = high.max(x);
            }
            centre[axis] = 0.5 * (low + high);
            half[axis] = 0.5 * (high - low);
            largest = largest.max(low.abs()).max(high.abs());
        }
        Self { centre, half: half.map(|half| half + ROUNDING * (largest + half)) }
    }
}

/// What of a block a group may see.
struct Reached {
    /// For each face the triangles that may reach it, all ones, and the rows that they may reach.
    faces: [Lanes<u32>; FACES],
    first: [Lanes<u32>; FACES],
    end: [Lanes<u32>; FACES],
    /// The triangles of any.
    any: u32,
}

/// Adds what `blocks` block of the view of each receiver of `group`.
#[inline(always)]
pub(super) fn add(rows: &mut Rows, group: &Group, blocks: &[Block]) {
    let around = Around::new(group);
    for block in blocks {
        let reached = reached(block, &around);
        let mut left = reached.any;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            add_triangle(rows, group, &block.triangle(lane), &reached, lane);
        }
    }
}

#[inline(always)]
fn reached(block: &Block, around: &Around) -> Reached {
    let mut found =
        Reached { faces: [[0; LANES]; FACES], first: [[0; LANES]; FACES], end: [[0; LANES]; FACES], any: 0 };
    let mut corners = [[[0.0; LANES]; 3]; 3];
    for corner in 0..3 {
        for axis in 0..3 {
            for lane in 0..LANES {
                corners[corner][axis][lane] = block.corners[corner][axis][lane] - around.centre[axis];
            }
        }
    }
    let counts = counts(block, &corners[0], around);
    for (face, frame) in FRAMES.iter().enumerate() {
        let half = frame.map(|(axis, _)| around.half[axis]);
        let mut placed = [[[0.0; LANES]; 3]; 3];
        for corner in 0..3 {
            for (k, (axis, sign)) in frame.iter().enumerate() {
                for lane in 0..LANES {
                    placed[corner][k][lane] = sign * corners[corner][*axis][lane];
                }
            }
        }
        let [[a, b, g], [d, e, h], [i, j, k]] = &placed;
        let mut any = 0;
        for lane in 0..LANES {
            let corners =
                [[a[lane], b[lane], g[lane]], [d[lane], e[lane], h[lane]], [i[lane], j[lane], k[lane]]];
            let reached = counts[lane] & all_if(may_reach(&corners, half));
            found.faces[face][lane] = reached;
            any |= reached;
        }
        if any == 0 {
            continue;
        }
        for lane in 0..LANES {
            let corners =
                [[a[lane], b[lane], g[lane]], [d[lane], e[lane], h[lane]], [i[lane], j[lane], k[lane]]];
            let [first, end] = row_range(&corners, half);
            (found.first[face][lane], found.end[face][lane]) = (first, end);
        }
        for lane in 0..LANES {
            found.any |= found.faces[face][lane] & (1 << lane);
        }
    }
    found
}

/// Which triangles may count for a receiver of the group, all ones.
#[inline(always)]
fn counts(block: &Block, first_corner: &[Lanes<f32>; 3], around: &Around) -> Lanes<u32> {
    let mut counts = [0; LANES];
    for lane in 0..LANES {
        let normal = [block.normal[0][lane], block.normal[1][lane], block.normal[2][lane]];
        let first = [first_corner[0][lane], first_corner[1][lane], first_corner[2][lane]];
        let height = Triangle::height(normal, first);
        let reach = normal[0].abs() * around.half[0]
            + normal[1].abs() * around.half[1]
            + normal[2].abs() * around.half[2];
        let above = least(block.above[0][lane], block.above[1][lane]);
        let below = least(block.below[0][lane], block.below[1][lane]);
        counts[lane] = all_if((height + reach > above) | (reach - height > below));
    }
    counts
}

#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Adds a triangle, lane `at` of what is `reached`.
#[inline(always)]
fn add_triangle(rows: &mut Rows, group: &Group, triangle: &Triangle, reached: &Reached, at: usize) {
    let mut corners = [[[0.0; LANES]; 3]; 3];
    let (mut counts, mut sign, mut any) = ([0; LANES], [0.0; LANES], 0);
    for lane in 0..LANES {
        let mut highest = 0.0f32;
        for corner in 0..3 {
            let [x, y, z] = triangle.corners[corner];
            let offset =
                [x - group.position[0][lane], y - group.position[1][lane], z - group.position[2][lane]];
            let above = group.normal[0][lane] * offset[0]
                + group.normal[1][lane] * offset[1]
                + group.normal[2][lane] * offset[2];
            highest = if above > highest { above } else { highest };
            for axis in 0..3 {
                corners[corner][axis][lane] = offset[axis];
            }
        }
        let height = Triangle::height(
            triangle.normal,
            [corners[0][0][lane], corners[0][1][lane], corners[0][2][lane]],
        );
        let is_own = group.object[lane] == triangle.object;
        let [own, others] = triangle.sides;
        let above = if is_own { own.above } else { others.above };
        let below = if is_own { own.below } else { others.below };
        counts[lane] = all_if(Sides { above, below }.count_from(height) & (highest > 0.0));
        sign[lane] = if height > 0.0 { 1.0 } else { -1.0 };
        any |= counts[lane];
    }
    if any == 0 {
        return;
    }
    let planes = planes(&corners, &sign);
    for (face, (rows, frame)) in rows.as_chunks_mut::<SIDE>().0.iter_mut().zip(&FRAMES).enumerate() {
        if reached.faces[face][at] != 0 {
            let range = reached.first[face][at] as usize..reached.end[face][at] as usize;
            add_to_face(&mut rows[range.clone()], range.start, frame, &planes, &counts);
        }
    }
}

/// The planes of the three edges, for each receiver.
#[inline(always)]
fn planes(corners: &[[Lanes<f32>; 3]; 3], sign: &Lanes<f32>) -> [[Lanes<f32>; 3]; 3] {
    let mut planes = [[[0.0; LANES]; 3]; 3];
    for edge in 0..3 {
        for lane in 0..LANES {
            let of = |corner: &[Lanes<f32>; 3]| [corner[0][lane], corner[1][lane], corner[2][lane]];
            let plane = plane(of(&corners[edge]), of(&corners[(edge + 1) % 3]), sign[lane]);
            for axis in 0..3 {
                planes[edge][axis][lane] = plane[axis];
            }
        }
    }
    planes
}

/// Adds what lies within `planes` to `rows`, of one face with the given frame, from the `first` on, for the
/// receivers that are all ones in `counts`.
#[inline(always)]
fn add_to_face(
    rows: &mut [Lanes<u32>],
    first: usize,
    [s, t, n]: &[(usize, f32); 3],
    planes: &[[Lanes<f32>; 3]; 3],
    counts: &Lanes<u32>,
) {
    let (mut slope, mut begin, mut end) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for edge in 0..3 {
        let plane = &planes[edge];
        for lane in 0..LANES {
            let on_face = [s.1 * plane[s.0][lane], t.1 * plane[t.0][lane], n.1 * plane[n.0][lane]];
            let found = Edge::new(on_face);
            (slope[edge][lane], begin[edge][lane], end[edge][lane]) = (found.slope, found.begin, found.end);
        }
    }
    for (y, row) in (first..).zip(rows) {
        let t = centre(y);
        for lane in 0..LANES {
            let edge = |k: usize| Edge { slope: slope[k][lane], begin: begin[k][lane], end: end[k][lane] };
            row[lane] |= span(&[edge(0), edge(1), edge(2)], t) & counts[lane];
        }
    }
}
