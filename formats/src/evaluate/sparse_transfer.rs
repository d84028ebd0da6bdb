//! Method `sparse-transfer`: the radiance of a vertex is the sum over its terms of value × coefficient of the
//! light; the direct light of [suns](super::suns) comes on top of it.

use crate::basis::suns::split;
use crate::basis::{EquirectMap, cubemap, haar};
use crate::kinds::SparseTransfer;
use crate::kinds::scene::EnvironmentLook;
use crate::kinds::sparse_transfer::Meta;
use crate::state::Rgb;

/// Haar coefficients of the light that `map` sends, as a cube of `face_size`² texels a face: gain and
/// rotation are those of `look`. One plane per channel, each of 6·`face_size`² coefficients.
pub fn light(map: &EquirectMap, look: &EnvironmentLook, face_size: usize) -> [Vec<f32>; 3] {
    let texels = cubemap::from_equirect(map, look.rotation_deg, face_size);
    std::array::from_fn(|channel| {
        let mut plane: Vec<f32> = texels.iter().map(|t| t[channel] * look.gain[channel]).collect();
        haar::forward_cube(&mut plane, face_size);
        plane
    })
}

/// What rows of `meta` are multiplied with, one plane per channel: the [`light`] of `map` without its suns, and,
/// where light bounces, of the whole map behind it.
pub fn lights(map: &EquirectMap, look: &EnvironmentLook, meta: &Meta) -> [Vec<f32>; 3] {
    let n = meta.face_size as usize;
    let mut planes = light(&split(map).rest, look, n);
    if meta.bounces > 0 {
        planes.iter_mut().zip(light(map, look, n)).for_each(|(plane, mut whole)| plane.append(&mut whole));
    }
    planes
}

/// Linear radiance that a white diffuse surface would show at every vertex, W/(sr·m²), of the light of
/// [`lights`].
pub fn radiance(bundle: &SparseTransfer, light: &[Vec<f32>; 3]) -> Vec<Rgb> {
    let vertices = bundle.meta.vertices as usize;
    let mut sums = vec![[0.0; 3]; vertices];
    for (block, shape) in bundle.blocks.iter().zip(&bundle.meta.blocks) {
        for term in 0..shape.terms as usize {
            for (vertex, sum) in sums.iter_mut().enumerate() {
                let index = usize::from(block.indices[term * vertices + vertex]);
                let value = block.value(&bundle.meta, term, vertex);
                (0..3).for_each(|c| sum[c] += value[c] * light[c][index]);
            }
        }
    }
    sums
}
