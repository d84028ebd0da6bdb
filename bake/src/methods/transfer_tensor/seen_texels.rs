//! What a vertex sees of the hemisphere about its normal, by texels of equal solid angle.

use crate::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use crate::trace::receivers::Receiver;
use glam::Vec3;
use relume_formats::basis::cubemap::texel_of;
use relume_formats::basis::hemisphere::{SIDE, TEXELS, direction};

/// Points along a side of a texel: as dense as texels of the cube, or denser.
const POINTS: usize = 6;
/// Where the cosine is below this, what part of a texel of the cube is visible follows from too small numbers; seen or not
/// is what is left of it.
const LEAST_COSINE: f32 = 0.02;

/// The visible part of each texel, 255 being all of it, from `row`, V·max(0, n·ω)·dω/π by texels of the cube.
pub fn seen<'a>(
    receiver: &Receiver,
    row: &'a [f32],
    texels: &'a Texels,
) -> impl Iterator<Item = u8> + use<'a> {
    let normal = receiver.normal;
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let part = move |place: [usize; 2]| {
        let [u, v] = place.map(|at| (at as f32 + 0.5) / (SIDE * POINTS) as f32);
        let local = direction(u, v);
        let towards = tangent * local.x + bitangent * local.y + normal * local.z;
        let texel = texel_of(Vec3::from(towards), FACE_SIZE);
        let cosine = normal.dot(texels.centres.directions()[texel]);
        if cosine > LEAST_COSINE {
            (row[texel] / (cosine * texels.weights[texel])).min(1.0)
        } else {
            f32::from(u8::from(row[texel] > 0.0))
        }
    };
    (0..TEXELS).map(move |texel| {
        let [x, y] = [texel % SIDE, texel / SIDE].map(|at| at * POINTS);
        let points = (0..POINTS * POINTS).map(|k| part([x + k % POINTS, y + k / POINTS]));
        (255.0 * points.sum::<f32>() / (POINTS * POINTS) as f32).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    /// All is seen of an open hemisphere but for texels at the horizon, which those of the cube cross; of one that a wall
    /// hides half of, half.
    #[test]
    fn open_and_half_hidden_hemispheres() {
        let texels = Texels::new(1);
        let receiver = Receiver { origin: Vec3A::ZERO, normal: Vec3A::new(0.48, 0.6, 0.64) };
        let across = receiver.normal.any_orthonormal_pair().0;
        for (wall, expected) in [(false, 1.0), (true, 0.5)] {
            let of_texel = |(d, weight): (&Vec3A, &f32)| {
                if wall && d.dot(across) < 0.0 { 0.0 } else { receiver.normal.dot(*d).max(0.0) * weight }
            };
            let row: Vec<f32> =
                texels.centres.directions().iter().zip(&texels.weights).map(of_texel).collect();
            let seen: Vec<u8> = seen(&receiver, &row, &texels).collect();
            let inner =
                (0..TEXELS).filter(|t| [t % SIDE, t / SIDE].iter().all(|at| (1..SIDE - 1).contains(at)));
            let mean = inner.clone().map(|t| f32::from(seen[t])).sum::<f32>() / inner.count() as f32 / 255.0;
            assert!((mean - expected).abs() < 0.01, "{wall}: {mean}");
        }
    }
}
