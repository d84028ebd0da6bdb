//! What a vertex sees of the environment: one row of the transfer matrix (sparse-transfer eq. 2, the
//! receiver's albedo left out).

use super::texels::Texels;
use crate::trace::receivers::Receiver;
use crate::trace::world::World;
use glam::Vec3A;

/// Transfer from every texel of the light to `receiver`: V·max(0, n·ω)·dω/π, for a texel at whose border
/// visibility changes the mean over the directions within it. `row` has as many values as there are texels.
pub fn transfer_row(receiver: &Receiver, world: &World, texels: &Texels, row: &mut [f32]) {
    let cosine = |direction: Vec3A| receiver.normal.dot(direction).max(0.0);
    let sees = |direction: Vec3A| !world.occluded(receiver.origin, direction, f32::INFINITY);
    let lit: Vec<bool> = texels.directions.iter().map(|d| cosine(*d) > 0.0 && sees(*d)).collect();
    for (texel, value) in row.iter_mut().enumerate() {
        let changes = || texels.neighbours(texel).into_iter().any(|other| lit[other] != lit[texel]);
        let projected = if texels.are_refined() && changes() {
            texels
                .points(texel)
                .iter()
                .filter(|(d, _)| cosine(*d) > 0.0 && sees(*d))
                .map(|(d, share)| share * cosine(*d))
                .sum()
        } else if lit[texel] {
            cosine(texels.directions[texel])
        } else {
            0.0
        };
        *value = projected * texels.weights[texel];
    }
}
