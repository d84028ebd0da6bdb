//! What a vertex sees of the environment: one row of the transfer matrix (sparse-transfer eq. 2, the
//! receiver's albedo left out).
//!
//! Rays, or what gives the same, tell bits, [`look`]; the row follows from them and the normal alone, [`row_of`], so that a log of bits
//! is one of rows.

use super::texels::{FACE_SIZE, Texels};
use crate::compress::bits::{BitReader, pack};
use crate::compress::frame::{grow, shrink};
use crate::trace::receivers::Receiver;
use crate::trace::spans::{Eye, TexelSet};
use crate::trace::world::World;
use glam::Vec3A;

/// What a receiver sees.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// The texels whose centre is above the horizon and unblocked.
    pub centres: TexelSet,
    /// The same of the directions above the horizon within texels at whose border that changes, in their
    /// order.
    pub points: Vec<bool>,
}

/// Finds what `receiver` sees: the centre of every texel above its horizon, and the grid within those at
/// whose border visibility changes.
pub fn look(receiver: &Receiver, world: &World, texels: &Texels) -> Seen {
    let Receiver { origin, normal } = *receiver;
    let eye = |rays, within| Eye { origin, horizon: Some(normal), rays, within };
    let mut centres = texels.centres.above(normal);
    world.see(eye(&texels.centres, None), &mut centres);
    if !texels.are_refined() {
        return Seen { centres, points: Vec::new() };
    }
    let refined = texels.borders(&centres);
    let asked = within(&refined, normal, texels);
    let mut seen = asked.clone();
    world.see(eye(texels.fine(), Some(&refined)), &mut seen);
    let mut points = Vec::new();
    for point in refined.members().flat_map(|texel| texels.points(texel)) {
        let (row, x) = (point / asked.face_size(), point % asked.face_size());
        if asked.has(row, x) {
            points.push(seen.has(row, x));
        }
    }
    Seen { points, centres }
}

/// The directions within `refined` texels that are above the horizon of `normal`.
fn within(refined: &TexelSet, normal: Vec3A, texels: &Texels) -> TexelSet {
    let mut asked = TexelSet::none(texels.fine().face_size());
    for texel in refined.members() {
        // From its centre to a corner a texel measures no more than √2/64.
        let is_above = cosine(normal, texels.centres.directions()[texel]) > 0.04;
        for point in texels.points(texel) {
            if is_above || cosine(normal, texels.fine().directions()[point]) > 0.0 {
                asked.insert(point / asked.face_size(), point % asked.face_size());
            }
        }
    }
    asked
}

/// Transfer from every texel of the light to a receiver with `normal` that sees `centres`, and `points` one
/// after the other: V·max(0, n·ω)·dω/π, for a texel at whose border visibility changes the mean over the
/// directions within it. `row` has as many values as there are texels.
pub fn row_of(
    normal: Vec3A,
    centres: &TexelSet,
    points: &mut BitReader<'_>,
    texels: &Texels,
    row: &mut [f32],
) {
    row.fill(0.0);
    for texel in centres.members() {
        row[texel] = cosine(normal, texels.centres.directions()[texel]) * texels.weights[texel];
    }
    if !texels.are_refined() {
        return;
    }
    for texel in texels.borders(centres).members() {
        let seen = texels.points(texel).map(|point| texels.point(point));
        let seen = seen.filter(|(d, _)| cosine(normal, *d) > 0.0 && points.take());
        row[texel] = seen.map(|(d, share)| share * cosine(normal, d)).sum::<f32>() * texels.weights[texel];
    }
}

fn cosine(normal: Vec3A, direction: Vec3A) -> f32 {
    normal.dot(direction).max(0.0)
}

/// Transfer from every texel to `receiver`, traced here and now; see [`row_of`].
pub fn transfer_row(receiver: &Receiver, world: &World, texels: &Texels, row: &mut [f32]) {
    let Seen { centres, points } = look(receiver, world, texels);
    row_of(receiver.normal, &centres, &mut BitReader::new(&pack(&points)), texels, row);
}

/// What some receivers see, as bytes for the log: the centres of each, then the points of all.
///
/// # Errors
/// If there is no memory for it.
pub fn encode(seen: &[Seen]) -> relume_formats::Result<Vec<u8>> {
    let mut bytes: Vec<u8> = seen.iter().flat_map(|seen| seen.centres.to_bytes()).collect();
    bytes.extend(pack(&seen.iter().flat_map(|seen| seen.points.iter().copied()).collect::<Vec<_>>()));
    shrink(&bytes)
}

/// Gives the rows of `receivers`, whose bits [`encode`] has made into `bytes`, one after the other; `None` if
/// `bytes` are those of others.
pub fn rows_of(
    bytes: &[u8],
    receivers: &[Receiver],
    texels: &Texels,
    mut give: impl FnMut(&[f32]),
) -> Option<()> {
    let of_one = texels.weights.len() / 8;
    let of_centres = receivers.len() * of_one;
    let bytes = grow(bytes, of_centres + receivers.len() * texels.most_points().div_ceil(8))?;
    let (centres, points) = bytes.split_at_checked(of_centres)?;
    let mut points = BitReader::new(points);
    let mut row = vec![0.0; texels.weights.len()];
    for (receiver, centres) in receivers.iter().zip(centres.chunks_exact(of_one)) {
        let centres = TexelSet::from_bytes(FACE_SIZE, centres)?;
        row_of(receiver.normal, &centres, &mut points, texels, &mut row);
        give(&row);
    }
    points.is_at_end().then_some(())
}

#[cfg(test)]
mod tests {
    use super::super::test_scene::test_scene;
    use super::*;
    use crate::trace::receivers::receivers;
    use crate::trace::world::{reset_ray_counts, take_ray_count};

    /// The row as a ray at a time gives it, without bits between.
    fn by_rays(receiver: &Receiver, world: &World, texels: &Texels) -> Vec<f32> {
        let cosine = |direction: Vec3A| receiver.normal.dot(direction).max(0.0);
        let sees = |direction: Vec3A| !world.occluded(receiver.origin, direction, f32::INFINITY);
        let lit: Vec<bool> =
            texels.centres.directions().iter().map(|d| cosine(*d) > 0.0 && sees(*d)).collect();
        let value = |texel: usize| {
            let border = texels.neighbours(texel).into_iter().any(|other| lit[other] != lit[texel]);
            let inside = texels.points(texel).map(|point| texels.point(point));
            let inside = inside.filter(|(d, _)| cosine(*d) > 0.0 && sees(*d));
            match (texels.are_refined() && border, lit[texel]) {
                (true, _) => inside.map(|(d, share)| share * cosine(d)).sum(),
                (false, true) => cosine(texels.centres.directions()[texel]),
                (false, false) => 0.0,
            }
        };
        (0..lit.len()).map(|texel| value(texel) * texels.weights[texel]).collect()
    }

    #[test]
    fn rows_of_a_log_are_those_that_rays_give_bit_for_bit() {
        let scene = test_scene();
        let (world, receivers) = (World::new(&scene), receivers(&scene));
        for side in [1, 2, 4] {
            let texels = Texels::new(side);
            let seen: Vec<Seen> = receivers.iter().map(|r| look(r, &world, &texels)).collect();
            assert_eq!(seen.iter().any(|seen| !seen.points.is_empty()), side > 1);
            let bytes = encode(&seen).unwrap();
            reset_ray_counts();
            let mut rows = Vec::new();
            rows_of(&bytes, &receivers, &texels, |row| rows.push(row.to_vec())).unwrap();
            assert_eq!(take_ray_count(), 0);
            assert_eq!(rows.len(), receivers.len());
            let mut row = vec![0.0; texels.weights.len()];
            for (receiver, from_log) in receivers.iter().zip(&rows) {
                let expected = by_rays(receiver, &world, &texels);
                // Where the ball touches the floor there is no light.
                let is_lit = expected.iter().any(|v| *v > 0.0);
                assert!(expected.contains(&0.0) && (is_lit || receiver.origin.y < 0.02), "{receiver:?}");
                transfer_row(receiver, &world, &texels, &mut row);
                for row in [from_log, &row] {
                    assert!(row.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits()), "{side}");
                }
            }
            let (fewer, more) = (&receivers[1..], [&receivers[..1], &receivers].concat());
            assert!(rows_of(&bytes, &more, &texels, |_| ()).is_none(), "bits are missing");
            assert!(rows_of(&bytes, fewer, &texels, |_| ()).is_none(), "bits are left over");
            assert!(rows_of(&bytes[1..], &receivers, &texels, |_| ()).is_none(), "no frame");
        }
    }
}
