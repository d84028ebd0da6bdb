//! Environment maps as cones see them: filtered on the CPU, each when it first shines, and kept.

use crate::gpu::Gpu;
use relume_formats::basis::blurred::{blurred, size};
use relume_formats::basis::suns::split;
use relume_formats::kinds::Environment;
use wgpu::{Buffer, BufferUsages};

/// What filters maps, and the one that shines.
pub(super) struct Blurs {
    widths_deg: Vec<f32>,
    maps: Vec<Map>,
    /// [texels] of all widths, four floats of which the last is unused: the map that shines.
    pub(super) buffer: Buffer,
}

/// A map as it comes, or filtered.
enum Map {
    Whole(Environment),
    Filtered(Vec<[f32; 4]>),
}

/// Where a map, filtered for cones of one width, is in its buffer, in texels, and its size: the same for all maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) first: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Blurs {
    /// Of `maps` for cones of `widths_deg`; none is filtered yet.
    pub(super) fn new(gpu: &Gpu, widths_deg: Vec<f32>, maps: Vec<Environment>) -> Self {
        let texels: u32 = widths_deg.iter().map(|width_deg| size(*width_deg).iter().product::<u32>()).sum();
        let bytes = u64::from(texels) * size_of::<[f32; 4]>() as u64;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = gpu.buffer("filtered map", bytes.max(size_of::<[f32; 4]>() as u64), usage);
        Self { widths_deg, maps: maps.into_iter().map(Map::Whole).collect(), buffer }
    }

    /// Takes map number `index`, which is one of those that there are or the next.
    pub(super) fn set(&mut self, index: usize, map: &Environment) {
        let map = Map::Whole(map.clone());
        match self.maps.get_mut(index) {
            Some(known) => *known = map,
            None => self.maps.push(map),
        }
    }

    /// Where maps are filtered for cones of `width_deg`, if they are.
    pub(super) fn place(&self, width_deg: f32) -> Option<Place> {
        let mut first = 0;
        for known in &self.widths_deg {
            let [width, height] = size(*known);
            if *known == width_deg {
                return Some(Place { first, width, height });
            }
            first += width * height;
        }
        None
    }

    /// Lets map number `index` shine, filtered without its suns.
    pub(super) fn shine(&mut self, gpu: &Gpu, index: usize) {
        let Some(map) = self.maps.get_mut(index) else { return };
        if let Map::Whole(environment) = map {
            let rest = split(&environment.map).rest;
            let filtered = self.widths_deg.iter().flat_map(|width_deg| blurred(&rest, *width_deg).texels);
            let texels = filtered.map(|[r, g, b]| [r, g, b, 0.0]).collect();
            *map = Map::Filtered(texels);
        }
        if let Map::Filtered(texels) = map {
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(texels));
        }
    }
}
