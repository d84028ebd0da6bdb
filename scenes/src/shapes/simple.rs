//! Flat shapes: the quad and the box.

use crate::geometry::Part;
use glam::Vec3;

/// Adds the square `centre` ± ½ u ± ½ v, facing u × v, in `segments` × `segments` smaller ones. A texture
/// covers it once and stands upright seen from the front, with the world's up above, or −Z on what faces up
/// and +Z on what faces down.
fn add_square(part: &mut Part, centre: Vec3, u: Vec3, v: Vec3, segments: u32) {
    let first = part.positions.len() as u32;
    let normal = u.cross(v);
    let up = if normal.y == 0.0 { Vec3::Y } else { Vec3::NEG_Z * normal.y };
    let right = up.cross(normal);
    let place = |index: u32| index as f32 / segments as f32 - 0.5;
    for (b, a) in (0..=segments).flat_map(|b| (0..=segments).map(move |a| (b, a))) {
        let offset = u * place(a) + v * place(b);
        part.positions.push((centre + offset).to_array());
        part.normals.push(normal.to_array());
        part.uvs.push([0.5 + right.dot(offset), 0.5 - up.dot(offset)]);
    }
    for (b, a) in (0..segments).flat_map(|b| (0..segments).map(move |a| (b, a))) {
        let corner = first + b * (segments + 1) + a;
        let (right, above, across) = (corner + 1, corner + segments + 1, corner + segments + 2);
        part.triangles.extend([[corner, right, across], [corner, across, above]]);
    }
}

/// The unit square in the XZ plane, facing +Y, in `segments` × `segments` smaller ones.
pub(super) fn quad(segments: u32) -> Part {
    let mut part = Part::default();
    add_square(&mut part, Vec3::ZERO, Vec3::Z, Vec3::X, segments);
    part
}

/// The unit cube; every face has its own corners and a flat normal.
pub(super) fn cube() -> Part {
    let mut part = Part::default();
    for (u, v) in [(Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X), (Vec3::X, Vec3::Y)] {
        let outward = u.cross(v) * 0.5;
        add_square(&mut part, outward, u, v, 1);
        add_square(&mut part, -outward, v, u, 1);
    }
    part
}
