//! Caps from the table of rounded directions and radii, which the product has replaced by exact ones.

use glam::Vec3;
use relume_formats::basis::cap::{self, Bitmap};
use relume_formats::evaluate::sphere_shadows::{Receiver, Spheres};
use relume_formats::kinds::VisibilityTable;

/// What [`blocked`](relume_formats::evaluate::sphere_shadows::blocked) does, with caps from the table; for
/// receivers that are on no object with spheres.
pub fn blocked_by_table(receiver: &Receiver, sets: &[Spheres], table: &VisibilityTable) -> Bitmap {
    let mut bytes = [0; 768];
    for [x, y, z, radius] in sets.iter().flat_map(|set| &set.now) {
        let offset = Vec3::new(*x, *y, *z) - receiver.position;
        if receiver.normal.dot(offset) <= -radius {
            continue;
        }
        let r = radius / offset.length();
        match table.look_up(offset, r) {
            _ if r >= 1.0 => bytes = [u8::MAX; 768],
            Some(cap) => bytes.iter_mut().zip(cap).for_each(|(all, one)| *all |= one),
            None => {}
        }
    }
    cap::rows(&bytes)
}
