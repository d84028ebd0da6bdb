//! Held-out lights: what methods that the environment lights choose their numbers of terms by, and measure
//! errors under.

use rayon::prelude::*;
use relume_formats::basis::suns::split;
use relume_formats::basis::{EquirectMap, haar};
use relume_formats::evaluate::sparse_transfer::light;
use relume_formats::kinds::environment::Environment;
use relume_formats::kinds::scene::EnvironmentLook;
use std::borrow::Cow;

/// Lights that errors are measured under.
pub const STATES: usize = 16;
/// Radiances of one receiver under all of them, row-major [states, 3].
pub const RADIANCES: usize = 3 * STATES;
/// Turn from one held-out light to the next, degrees: the golden section of a circle, so that any few of them
/// are spread evenly.
const TURN_DEG: f32 = 222.492_24;

/// The lights as rows to multiply with. What shines directly has no suns, whose light a player draws with shadows of
/// its own.
pub struct HeldOutLights {
    /// Haar coefficients, row-major [coefficients, [`RADIANCES`]]: of the maps without suns, and behind them, if
    /// that is asked for, of the whole maps.
    pub coefficients: Vec<f32>,
    /// Texels of the same, row-major [texels, [`RADIANCES`]].
    pub texels: Vec<f32>,
    /// Texels of the whole maps alone.
    pub whole: Vec<f32>,
}

/// Radiance of a receiver under all lights, from a row of all texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exact {
    /// Without the suns' direct light: what a method is to give.
    pub given: [f32; RADIANCES],
    /// With it: what is to be seen, and errors are relative to.
    pub seen: [f32; RADIANCES],
}

impl HeldOutLights {
    /// The maps by turns, each next one turned further. The first is the scene's own, unturned. `with_whole` asks
    /// for the whole maps behind those without suns.
    pub fn new(maps: &[Environment], face_size: usize, with_whole: bool) -> Self {
        Self::of(
            std::array::from_fn(|state| (&maps[state % maps.len()].map, (state as f32 * TURN_DEG) % 360.0)),
            face_size,
            with_whole,
        )
    }

    /// Each map at its rotation in degrees.
    pub fn of(states: [(&EquirectMap, f32); STATES], face_size: usize, with_whole: bool) -> Self {
        // States share a few maps.
        let mut rests: Vec<(&EquirectMap, Cow<'_, EquirectMap>)> = Vec::new();
        for (map, _) in states {
            if !rests.iter().any(|(known, _)| std::ptr::eq(*known, map)) {
                rests.push((map, split(map).rest));
            }
        }
        let of_state = |(map, rotation_deg): (&EquirectMap, f32)| {
            let look = EnvironmentLook { map: String::new(), gain: [1.0; 3], rotation_deg };
            let rest =
                rests.iter().find(|(known, _)| std::ptr::eq(*known, map)).map_or(map, |(_, rest)| rest);
            let [rest, whole] = [rest, map].map(|map| light(map, &look, face_size));
            std::iter::zip(rest, whole)
        };
        let (mut planes, whole): (Vec<_>, Vec<_>) = states.into_par_iter().flat_map_iter(of_state).unzip();
        if with_whole {
            planes.iter_mut().zip(&whole).for_each(|(plane, whole)| plane.extend(whole));
        }
        let texels_of = |planes: &[Vec<f32>]| {
            let texels = planes.par_iter().map(|plane| {
                let mut texels = plane.clone();
                haar::inverse_cube(&mut texels, face_size);
                texels
            });
            transposed(&texels.collect::<Vec<_>>())
        };
        Self { texels: texels_of(&planes), whole: texels_of(&whole), coefficients: transposed(&planes) }
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

/// Radiance under every held-out light of a row given by texels, one plane per channel, as many texels as the
/// lights have.
pub fn exact_radiances(planes: &[Vec<f32>], lights: &HeldOutLights) -> Exact {
    let (mut given, mut seen) = ([0.0; RADIANCES], [0.0; RADIANCES]);
    let mut value = [0.0; 3];
    let whole = lights.whole.chunks_exact(RADIANCES).cycle();
    for (texel, (light, whole)) in lights.texels.chunks_exact(RADIANCES).zip(whole).enumerate() {
        planes.iter().zip(&mut value).for_each(|(plane, v)| *v = plane[texel]);
        let value = &value[..planes.len()];
        if value.iter().any(|v| *v != 0.0) {
            add(&mut given, value, light);
            add(&mut seen, value, whole);
        }
    }
    Exact { given, seen }
}
