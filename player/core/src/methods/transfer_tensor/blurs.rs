//! Environment maps as cones see them.

use crate::gpu::Gpu;
use relume_formats::basis::blurred::blurred;
use relume_formats::basis::suns::split;
use relume_formats::kinds::Environment;

/// Where a map, filtered for cones of one width, is in its buffer, in texels, and its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) first: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

/// A map without its suns filtered for cones of each of `widths_deg`, one after the other, and where each is; the
/// same places for any map.
pub(super) fn blurs(gpu: &Gpu, map: &Environment, widths_deg: &[f32]) -> (wgpu::Buffer, Vec<Place>) {
    let rest = split(&map.map).rest;
    let (mut texels, mut places) = (Vec::new(), Vec::new());
    for width_deg in widths_deg {
        let map = blurred(&rest, *width_deg);
        places.push(Place { first: texels.len() as u32, width: map.width, height: map.height });
        texels.extend(map.texels.iter().map(|[r, g, b]| [*r, *g, *b, 0.0f32]));
    }
    (gpu.storage("blurred map", &texels), places)
}
