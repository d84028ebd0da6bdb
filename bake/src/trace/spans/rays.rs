//! Rays from one point through the texels of a cube, ready for the test of triangles, eight at a time.

use super::edges::Edges;
use super::face::Face;
use super::set::TexelSet;
use crate::trace::triangle::ShearedRay;
use crate::trace::wide::lanes::{LANES, Plain};
use glam::Vec3A;
use relume_formats::basis::cubemap::{self, FACES};

/// The directions through the texels of a cube of n × n texels a face, in their order.
pub struct TexelRays {
    face_size: usize,
    directions: Vec<Vec3A>,
    eights: Vec<Eight>,
}

/// The shear of [`ShearedRay`] for eight texels of a row.
pub(super) struct Eight {
    /// What the axis of the face adds to the two others, in the order of [`super::face::Face::sheared`].
    pub across: [[f32; LANES]; 2],
    /// Inverse length along that axis.
    pub along: [f32; LANES],
}

impl TexelRays {
    /// With unit `directions`, within the texels of faces of `face_size`², which is a multiple of 8: six
    /// faces of rows.
    pub fn new(face_size: usize, directions: Vec<Vec3A>) -> Self {
        let eight = |directions: &[Vec3A; LANES]| {
            let shears = directions.map(|direction| ShearedRay::new(Vec3A::ZERO, direction).shear());
            let across = [0, 1].map(|axis| shears.map(|(_, across, _)| across[axis]));
            Eight { across, along: shears.map(|(_, _, along)| along) }
        };
        let eights = directions.as_chunks().0.iter().map(eight).collect();
        Self { face_size, directions, eights }
    }

    /// Through the middles of texels.
    pub fn centres(face_size: usize) -> Self {
        let n = face_size;
        let centre =
            |i: usize| cubemap::direction(i / (n * n), n, (i % n) as f64 + 0.5, (i / n % n) as f64 + 0.5);
        Self::new(n, (0..FACES * n * n).map(|i| centre(i).as_vec3a()).collect())
    }

    /// Texels along a side of a face.
    pub fn face_size(&self) -> usize {
        self.face_size
    }

    /// Unit directions, row by row, face by face.
    pub fn directions(&self) -> &[Vec3A] {
        &self.directions
    }

    /// The eight texels of which that at (`row`, `x`) is one, rows of all faces counted.
    pub(super) fn eight(&self, row: usize, x: usize) -> &Eight {
        &self.eights[(row * self.face_size + x) / LANES]
    }

    /// The texels above the horizon of `normal`.
    pub fn above(&self, normal: Vec3A) -> TexelSet {
        let mut above = TexelSet::none(self.face_size);
        let is_above = |row: usize, x: usize| normal.dot(self.directions[row * self.face_size + x]) > 0.0;
        for number in 0..FACES {
            let face = Face { number, size: self.face_size, origin: [0.0; 3] };
            let horizon = Edges::horizon(&face, normal);
            for first in (0..self.face_size).step_by(LANES) {
                let spans = horizon.spans(Plain, &face, first);
                for lane in 0..LANES {
                    let row = number * self.face_size + first + lane;
                    let within = |[from, to]: [i32; 2]| [from.max(0), to.min(self.face_size as i32 - 1)];
                    let ([from, to], sure) = (within(spans.may_be(lane)), within(spans.is(lane)));
                    if sure[0] <= sure[1] {
                        above.insert_all(row, sure.map(|x| x as usize));
                    }
                    let unclear = |x: &i32| !(sure[0]..=sure[1]).contains(x);
                    for x in (from..=to).filter(unclear).map(|x| x as usize).filter(|x| is_above(row, *x)) {
                        above.insert(row, x);
                    }
                }
            }
        }
        above
    }
}
