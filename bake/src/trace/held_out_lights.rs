//! Held-out lights: what methods that the environment lights choose their numbers of terms by, and measure
//! errors under.

use rayon::prelude::*;
use relume_formats::basis::{EquirectMap, haar};
use relume_formats::evaluate::sparse_transfer::light;
use relume_formats::kinds::environment::Environment;
use relume_formats::kinds::scene::EnvironmentLook;

/// Lights that errors are measured under.
pub const STATES: usize = 16;
/// Radiances of one receiver under all of them, row-major [states, 3].
pub const RADIANCES: usize = 3 * STATES;
/// Turn from one held-out light to the next, degrees: the golden section of a circle, so that any few of them
/// are spread evenly.
const TURN_DEG: f32 = 222.492_24;

/// The lights as rows to multiply with.
pub struct HeldOutLights {
    /// Haar coefficients, row-major [coefficients, [`RADIANCES`]].
    pub coefficients: Vec<f32>,
    /// Texels, row-major [texels, [`RADIANCES`]].
    pub texels: Vec<f32>,
}

impl HeldOutLights {
    /// The maps by turns, each next one turned further. The first is the scene's own, unturned.
    pub fn new(maps: &[Environment], face_size: usize) -> Self {
        Self::of(
            std::array::from_fn(|state| (&maps[state % maps.len()].map, (state as f32 * TURN_DEG) % 360.0)),
            face_size,
        )
    }

    /// Each map at its rotation in degrees.
    pub fn of(states: [(&EquirectMap, f32); STATES], face_size: usize) -> Self {
        let of_state = |(map, rotation_deg)| {
            light(map, &EnvironmentLook { map: String::new(), gain: [1.0; 3], rotation_deg }, face_size)
        };
        let planes: Vec<Vec<f32>> = states.into_par_iter().flat_map_iter(of_state).collect();
        let texels = planes.par_iter().map(|plane| {
            let mut texels = plane.clone();
            haar::inverse_cube(&mut texels, face_size);
            texels
        });
        Self { texels: transposed(&texels.collect::<Vec<_>>()), coefficients: transposed(&planes) }
    }
}

/// Planes as columns.
fn transposed(planes: &[Vec<f32>]) -> Vec<f32> {
    let length = planes.first().map_or(0, Vec::len);
    (0..length * RADIANCES).map(|i| planes[i % RADIANCES][i / RADIANCES]).collect()
}

/// Adds `value` (one per channel, or one for all) times one row of [`HeldOutLights`] to `radiances`.
pub fn add(radiances: &mut [f32; RADIANCES], value: &[f32], light: &[f32]) {
    match *value {
        [grey] => radiances.iter_mut().zip(light).for_each(|(r, l)| *r += grey * l),
        [red, green, blue] => {
            for (r, l) in radiances.as_chunks_mut::<3>().0.iter_mut().zip(light.as_chunks::<3>().0) {
                *r = [r[0] + red * l[0], r[1] + green * l[1], r[2] + blue * l[2]];
            }
        }
        _ => {}
    }
}

/// Radiance under every held-out light of a row given by texels, one plane per channel.
pub fn exact_radiances(planes: &[Vec<f32>], lights: &HeldOutLights) -> [f32; RADIANCES] {
    let mut sums = [0.0; RADIANCES];
    let mut value = [0.0; 3];
    for (texel, light) in lights.texels.chunks_exact(RADIANCES).enumerate() {
        planes.iter().zip(&mut value).for_each(|(plane, v)| *v = plane[texel]);
        let value = &value[..planes.len()];
        if value.iter().any(|v| *v != 0.0) {
            add(&mut sums, value, light);
        }
    }
    sums
}
