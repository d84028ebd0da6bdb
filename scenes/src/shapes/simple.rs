//! Flat shapes: the quad and the box.

use crate::geometry::Part;
use glam::Vec3;

/// Adds the square `centre` ± ½ u ± ½ v, facing u × v. A texture covers it once and stands upright seen from the front, with the world's up
/// above, or −Z on what faces up and +Z on what faces down.
fn add_square(part: &mut Part, centre: Vec3, u: Vec3, v: Vec3) {
    let first = part.positions.len() as u32;
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    part.positions.extend(corners.map(|(a, b)| (centre + u * a + v * b).to_array()));
    let normal = u.cross(v);
    let up = if normal.y == 0.0 { Vec3::Y } else { Vec3::NEG_Z * normal.y };
    let right = up.cross(normal);
    part.normals.extend([normal.to_array(); 4]);
    part.uvs.extend(corners.map(|(a, b)| u * a + v * b).map(|offset| [0.5 + right.dot(offset), 0.5 - up.dot(offset)]));
    part.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

/// The unit square in the XZ plane, facing +Y.
pub(super) fn quad() -> Part {
    let mut part = Part::default();
    add_square(&mut part, Vec3::ZERO, Vec3::Z, Vec3::X);
    part
}

/// The unit cube; every face has its own corners and a flat normal.
pub(super) fn cube() -> Part {
    let mut part = Part::default();
    for (u, v) in [(Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X), (Vec3::X, Vec3::Y)] {
        let outward = u.cross(v) * 0.5;
        add_square(&mut part, outward, u, v);
        add_square(&mut part, -outward, v, u);
    }
    part
}
