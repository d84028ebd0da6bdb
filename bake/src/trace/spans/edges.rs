//! What a triangle covers of rows of a face: a span of each.
//!
//! Seen from the middle of the cube a triangle is what lies on the inner side of three planes through its
//! edges, and on a face these are straight lines. So a row has one span, between the lines that bound it from
//! the left and from the right.

use super::face::{Face, SLACK};
use crate::trace::wide::lanes::{LANES, Lanes};
use crate::trace::wide::leaves::Corners;
use glam::Vec3A;

/// How far the sides of a line may be mixed up, in parts of the product of the distances of the edge's ends:
/// projecting them is off by 7 ε of each (ε = 2⁻²⁴), that is 56 ε of the product, and what is computed here
/// by less than 16.
const MIXED: f32 = 128.0 / 16_777_216.0;

/// Products of smaller distances may lose bits below the smallest numbers; scenes are 2¹⁴ units large.
const NEAR: f32 = 1.0 / (1 << 20) as f32;

/// The lines of a triangle's edges on a face, positive inside: A·s + B·t + C at the place (s, t), which goes
/// from −1 to 1 across and down.
pub(super) struct Edges {
    /// [A, B, C] of each.
    lines: [[f32; 3]; 3],
    /// What is surely inside has more than that, what is surely outside less than its negative.
    mixed: [f32; 3],
}

/// Spans of eight rows: the first and the last texel of each.
pub(super) struct Spans {
    /// What may be inside.
    may_be: [[f32; LANES]; 2],
    /// What surely is.
    is: [[f32; LANES]; 2],
}

impl Spans {
    /// That of row `lane` of what may be inside; empty ones end before they begin.
    pub fn may_be(&self, lane: usize) -> [i32; 2] {
        [self.may_be[0][lane] as i32, self.may_be[1][lane] as i32]
    }

    /// That of row `lane` of what surely is inside; empty ones end before they begin.
    pub fn is(&self, lane: usize) -> [i32; 2] {
        [self.is[0][lane] as i32, self.is[1][lane] as i32]
    }
}

impl Edges {
    /// Of the triangle of `lane`; `None` if it is seen so nearly from the side that what is inside cannot be
    /// told.
    #[inline(always)]
    pub fn new(face: &Face, corners: &Corners, lane: usize) -> Option<Self> {
        let [a, b, c] = [0, 1, 2].map(|corner| face.at(corners, corner, lane));
        let lines = [cross(b, c), cross(c, a), cross(a, b)];
        let [far_a, far_b, far_c] = [far(a), far(b), far(c)];
        let volume = a[0] * lines[0][0] + a[1] * lines[0][1] + a[2] * lines[0][2];
        // The test of a ray sums three such products to tell what is in front of it from what is behind.
        let is_mixed = volume.abs() <= 2.0 * MIXED * far_a * far_b * far_c;
        if is_mixed || far_a.min(far_b).min(far_c) < NEAR {
            return None;
        }
        let side = volume.signum();
        let turned = |[a, b, c]: [f32; 3]| [side * a, side * b, side * c];
        let [of_a, of_b, of_c] = lines;
        Some(Self {
            lines: [turned(of_a), turned(of_b), turned(of_c)],
            mixed: [MIXED * far_b * far_c, MIXED * far_c * far_a, MIXED * far_a * far_b],
        })
    }

    /// What is above the horizon of the unit vector `normal`, which is one line, as surely as it is told from
    /// unit vectors.
    pub fn horizon(face: &Face, normal: Vec3A) -> Self {
        Self { lines: [face.turned(normal); 3], mixed: [MIXED; 3] }
    }

    /// The spans of row `first` and the seven that follow.
    #[inline(always)]
    pub fn spans<L: Lanes>(&self, simd: L, face: &Face, first: usize) -> Spans {
        let half = 0.5 * face.size as f32;
        let mut rows = [0.0; LANES];
        for (k, row) in rows.iter_mut().enumerate() {
            *row = ((first + k) as f32 + 0.5) / half - 1.0;
        }
        let rows = simd.load(&rows);
        let (mut left, mut right) = ([simd.splat(-2.0); 2], [simd.splat(2.0); 2]);
        for ([a, b, c], mixed) in self.lines.iter().zip(self.mixed) {
            let inverse = 1.0 / if a.abs() < f32::MIN_POSITIVE { f32::MIN_POSITIVE } else { *a };
            // Where the line is met if it is moved outwards, and inwards.
            let at = simd.sub(simd.mul(rows, simd.splat(-*b)), simd.splat(*c));
            let out = simd.mul(simd.sub(at, simd.splat(mixed)), simd.splat(inverse));
            let inner = simd.mul(simd.add(at, simd.splat(mixed)), simd.splat(inverse));
            if inverse > 0.0 {
                left = [simd.max(left[0], out), simd.max(left[1], inner)];
            } else {
                right = [simd.min(right[0], out), simd.min(right[1], inner)];
            }
        }
        Spans {
            may_be: [texel(simd, face, left[0], 1.0 - SLACK), texel(simd, face, right[0], SLACK)],
            is: [texel(simd, face, left[1], 1.0 + SLACK), texel(simd, face, right[1], -SLACK)],
        }
    }
}

/// The last texels whose middles come before places on a face that are moved by `slack` texels.
#[inline(always)]
fn texel<L: Lanes>(simd: L, face: &Face, place: L::F32, slack: f32) -> [f32; LANES] {
    let half = 0.5 * face.size as f32;
    // The middle of texel k is at k.
    simd.store(simd.floor(simd.add(simd.mul(place, simd.splat(half)), simd.splat(half - 0.5 + slack))))
}

#[inline(always)]
fn cross([ax, ay, az]: [f32; 3], [bx, by, bz]: [f32; 3]) -> [f32; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// The largest coordinate.
#[inline(always)]
fn far([x, y, z]: [f32; 3]) -> f32 {
    x.abs().max(y.abs()).max(z.abs())
}
