//! The texels of a cube of 32 × 32 a face whose centres a triangle covers, seen from the origin: what a piece
//! of a mesh blocks.
//!
//! A direction d meets the triangle with corners A, B, C if it lies on the inner side of the three planes
//! through the origin and an edge. On a face d = (s, t, 1) in the face's own frame, so with (a, b, g) the
//! normal of such a plane, inwards, that is a·s + b·t + g ≥ 0: along a row each edge bounds s from one side,
//! and what is left is one interval. Nothing needs clipping, for of two opposite directions only one is inside.
//!
//! Two triangles that share an edge compute its plane from the same corners in opposite order, which negates
//! every number exactly. So a centre on the edge, to rounding, belongs to one of them: a closed mesh has no
//! cracks.
//!
//! All is branch-free arithmetic on plain `f32`, without fused multiplications, so that the same code gives
//! the same bits in scalar and in vector form.

use super::cap::{Bitmap, edge, from, whole};
use super::cubemap::FRAMES;
use super::two_level::SIDE;
use glam::Vec3;

/// Texels from the middle of a face to its border.
const HALF: f32 = SIDE as f32 / 2.0;
/// Beyond every texel, and farther than any [`Edge`] that passes between some.
const FAR: f32 = 1e30;
/// The flattest that the plane of an edge stands against a row, in parts of its other coordinates: below, it
/// counts as parallel to it.
const PARALLEL: f32 = 1e-12;
/// How much farther than a triangle reaches rows are looked at: a hundredth of one, far more than roundings.
const MARGIN: f32 = 0.01;

/// An edge of a triangle, as the rows of a face see it: it passes the row at t behind `slope`·t + start texel
/// centres. The inner side is either that of larger s or the other one.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Edge {
    pub(crate) slope: f32,
    /// Where the inner side begins at t = 0; nowhere before the first texel if that is no question of this edge.
    pub(crate) begin: f32,
    /// Where it ends.
    pub(crate) end: f32,
}

impl Edge {
    /// Of the plane with the inward normal (`a`, `b`, `g`) in the face's frame.
    #[inline(always)]
    pub(crate) fn new([a, b, g]: [f32; 3]) -> Self {
        let least = PARALLEL * (b.abs() + g.abs());
        // Opposite for the opposite plane.
        let direction = if b != 0.0 { b } else { g };
        let a = if a.abs() > least { a } else { least.copysign(direction) };
        let scale = HALF / a;
        let start = HALF - g * scale;
        let is_low = a > 0.0;
        Self {
            slope: -b * scale,
            begin: if is_low { start } else { -FAR },
            end: if is_low { FAR } else { start },
        }
    }
}

/// The texels of the row at `t` that lie within three edges, a bit each.
#[inline(always)]
pub(crate) fn span(edges: &[Edge; 3], t: f32) -> u32 {
    let (mut begin, mut end) = (0.0, SIDE as f32);
    for edge in edges {
        let way = edge.slope * t;
        begin = at_least(way + edge.begin, begin);
        end = at_most(way + edge.end, end);
    }
    from(whole(at_most(begin, SIDE as f32))) & !from(whole(at_least(end, 0.0)))
}

/// The normal, towards the inner side, of the plane through the origin and the edge from `p` to `q`, of a
/// triangle that turns to the origin the side to which `sign` is 1 (its corners seen counter-clockwise) or −1.
#[inline(always)]
pub(crate) fn plane(p: [f32; 3], q: [f32; 3], sign: f32) -> [f32; 3] {
    [
        sign * (q[1] * p[2] - q[2] * p[1]),
        sign * (q[2] * p[0] - q[0] * p[2]),
        sign * (q[0] * p[1] - q[1] * p[0]),
    ]
}

/// Whether a triangle may reach into the pyramid over a face; `corners` in the face's frame, each of them
/// anywhere within `around` of where it is.
#[inline(always)]
pub(crate) fn may_reach(corners: &[[f32; 3]; 3], around: [f32; 3]) -> bool {
    let [across, down, along] = around;
    let [[a, b, g], others @ ..] = corners;
    let (mut ahead, mut right, mut left, mut lower, mut upper) = (*g, g + a, g - a, g + b, g - b);
    for [a, b, g] in others {
        ahead = at_least(*g, ahead);
        right = at_least(g + a, right);
        left = at_least(g - a, left);
        lower = at_least(g + b, lower);
        upper = at_least(g - b, upper);
    }
    let (sideways, vertical) = (-(along + across), -(along + down));
    (ahead > -along) & (right >= sideways) & (left >= sideways) & (lower >= vertical) & (upper >= vertical)
}

/// First row that a triangle may reach on a face, and the one behind the last, 0..=32; none if the first is not
/// below. `corners` in the face's frame, each of them anywhere within `around` of where it is.
#[inline(always)]
pub(crate) fn row_range(corners: &[[f32; 3]; 3], around: [f32; 3]) -> [u32; 2] {
    let (mut low, mut high) = (4.0, -4.0);
    let [_, down, along] = around;
    for [_, b, g] in *corners {
        let (near, far) = (g - along, g + along);
        let (least, most) = (b - down, b + down);
        let first = least * (1.0 / if least > 0.0 { far } else { near });
        let last = most * (1.0 / if most > 0.0 { near } else { far });
        // A corner that is not in front leaves rows open on both sides.
        let in_front = near > 0.0;
        let (first, last) = (if in_front { first } else { -4.0 }, if in_front { last } else { 4.0 });
        low = if first < low { first } else { low };
        high = at_least(high, last);
    }
    [edge(low - MARGIN / 16.0), edge(high + MARGIN / 16.0)]
}

/// The larger of both, in one instruction.
#[inline(always)]
fn at_least(x: f32, least: f32) -> f32 {
    if x > least { x } else { least }
}

/// The smaller of both, in one instruction.
#[inline(always)]
fn at_most(x: f32, most: f32) -> f32 {
    if x < most { x } else { most }
}

/// Where the centres of a row of texels are on a face.
#[inline(always)]
pub(crate) fn centre(row: usize) -> f32 {
    (2 * row + 1) as f32 / SIDE as f32 - 1.0
}

/// Adds the texels that a triangle covers, of the given corners from the origin, which its normal (B − A) ×
/// (C − A) points towards (`sign` 1) or away from (−1).
pub fn add_triangle(bitmap: &mut Bitmap, [a, b, c]: [Vec3; 3], sign: f32) {
    let planes = [(a, b), (b, c), (c, a)].map(|(p, q)| plane(p.to_array(), q.to_array(), sign));
    let (faces, _) = bitmap.as_chunks_mut::<SIDE>();
    for (frame, rows) in FRAMES.iter().zip(faces) {
        let on_face = |v: [f32; 3]| frame.map(|(axis, sign)| sign * v[axis]);
        let corners = [a, b, c].map(|corner| on_face(corner.to_array()));
        if may_reach(&corners, [0.0; 3]) {
            let edges = planes.map(|plane| Edge::new(on_face(plane)));
            let [first, end] = row_range(&corners, [0.0; 3]);
            (first as usize..end as usize).for_each(|y| rows[y] |= span(&edges, centre(y)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::cap::ROWS;
    use crate::basis::cubemap::direction;
    use crate::basis::test_bitmaps::{bit, centres};
    use proptest::prelude::*;

    fn towards(corners: [Vec3; 3]) -> f32 {
        let [a, b, c] = corners.map(|v| v.as_dvec3());
        if (b - a).cross(c - a).dot(a) < 0.0 { 1.0 } else { -1.0 }
    }

    fn covered(corners: [Vec3; 3]) -> Bitmap {
        let mut bitmap = [0; ROWS];
        add_triangle(&mut bitmap, corners, towards(corners));
        bitmap
    }

    /// Compares with rays in f64 (Möller and Trumbore 1997); rounding may decide on rays that pass an edge
    /// within `tolerance` radians.
    fn check(corners: [Vec3; 3], tolerance: f64) {
        let (bitmap, [a, b, c]) = (covered(corners), corners.map(|v| v.as_dvec3()));
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(q).normalize());
        let whole = a.dot(b.cross(c)).signum();
        for (texel, d) in centres().iter().enumerate() {
            let inside = sides.map(|side| whole * side.dot(*d)).into_iter().fold(f64::MAX, f64::min);
            assert!(
                inside.abs() < tolerance || bit(&bitmap, texel) == (inside > 0.0),
                "texel {texel} is {inside} inside {corners:?}"
            );
        }
    }

    #[test]
    fn a_face_s_own_square_covers_it() {
        for face in 0..6 {
            let at = |x: f64, y: f64| (2.0 * direction(face, 1, x, y)).as_vec3();
            let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
            let halves = [covered([a, b, c]), covered([a, c, d])];
            for (row, (one, other)) in halves[0].iter().zip(&halves[1]).enumerate() {
                let expected = if row / SIDE == face { u32::MAX } else { 0 };
                assert_eq!(one | other, expected, "face {face}, row {row}");
                assert_eq!(one & other, 0, "no texel twice: face {face}, row {row}");
            }
        }
    }

    /// A tetrahedron, an octahedron and a cube about the origin, in any place, cover all directions once.
    #[test]
    fn closed_meshes_have_no_cracks() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        for k in 0..60 {
            let turn = glam::Quat::from_scaled_axis(Vec3::new(0.1, 0.7, 0.3) * (k / 4) as f32);
            let shift = 0.05 * Vec3::new((k % 3) as f32, (k % 5) as f32, (k % 2) as f32);
            let scale = [1e-3, 1.0, 1.0, 1e4][k % 4];
            let mut all = [0; ROWS];
            for signs in 0..8 {
                let corner = |axis: usize| {
                    scale * (turn * axes[axis] * if signs >> axis & 1 == 1 { 1.0 } else { -1.0 } + shift)
                };
                let one = covered([corner(0), corner(1), corner(2)]);
                for (all, one) in all.iter_mut().zip(one) {
                    assert_eq!(*all & one, 0, "{k}: a texel is covered twice");
                    *all |= one;
                }
            }
            assert_eq!(all, [u32::MAX; ROWS], "{k}: a texel is not covered");
        }
    }

    #[test]
    fn both_windings_and_any_first_corner_cover_the_same() {
        let corners = [Vec3::new(1.0, 0.2, -0.3), Vec3::new(0.4, 1.5, 0.6), Vec3::new(-0.2, 0.3, 1.0)];
        let [a, b, c] = corners;
        let once = covered(corners);
        for other in [[b, c, a], [c, a, b], [c, b, a], [b, a, c]] {
            assert_eq!(covered(other), once);
        }
        assert!(once.iter().any(|row| *row != 0));
    }

    #[test]
    fn places_that_vary_only_look_at_more() {
        let corners = [[0.3, 0.5, 1.0], [0.4, 0.6, 1.1], [0.2, 0.9, 1.3]];
        assert!(
            may_reach(&corners, [0.0; 3]) && !may_reach(&corners.map(|[a, b, g]| [a - 3.0, b, g]), [0.0; 3])
        );
        assert!(may_reach(&corners.map(|[a, b, g]| [a - 3.0, b, g]), [2.0, 0.0, 0.0]));
        let [exact, around] = [[0.0; 3], [0.1, 0.1, 0.1]].map(|around| row_range(&corners, around));
        assert_eq!(exact, [24, 27], "t from 0.5 to 0.69");
        assert!(around[0] < exact[0] && around[1] > exact[1]);
        assert_eq!(row_range(&corners, [0.0, 0.0, 1.0]), [0, 32]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn any_triangle_is_that_of_rays(
            a in proptest::array::uniform3(-1.0f32..1.0),
            b in proptest::array::uniform3(-1.0f32..1.0),
            c in proptest::array::uniform3(-1.0f32..1.0),
            size in -6i32..3,
        ) {
            // Large and around the origin, or small and before it.
            let small = 4f32.powi(size);
            let [a, b, c] = [a, b, c].map(Vec3::from);
            let corners = if size > 0 { [a, b, c] } else { [a, a + small * (b - a), a + small * (c - a)] };
            let [p, q, r] = corners.map(|v| v.as_dvec3());
            let flat = (q - p).cross(r - p).normalize_or_zero().dot(p).abs();
            prop_assume!(flat > 1e-3 && p.length().min(q.length()).min(r.length()) > 0.05);
            // A plane is off by some roundings over the angle between its corners.
            let least = [(p, q), (q, r), (r, p)].map(|(p, q)| p.angle_between(q).sin()).into_iter().fold(1.0, f64::min);
            check(corners, 1e-6 / least.max(1e-3));
        }
    }
}
