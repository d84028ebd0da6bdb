//! Environment maps as cones see them: filtered on the CPU, each when it first shines.

use crate::gpu::Gpu;
use relume_formats::basis::blurred::{blurred, size};
use relume_formats::basis::suns::split;
use relume_formats::kinds::Environment;
use wgpu::Buffer;

/// What filters maps.
pub(super) struct Blurs {
    widths_deg: Vec<f32>,
    /// By map, unless it is filtered.
    waiting: Vec<Option<Environment>>,
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
    pub(super) fn new(widths_deg: Vec<f32>, maps: Vec<Environment>) -> Self {
        Self { widths_deg, waiting: maps.into_iter().map(Some).collect() }
    }

    /// Takes map number `index`, which is one of those that there are or the next.
    pub(super) fn set(&mut self, index: usize, map: &Environment) {
        match self.waiting.get_mut(index) {
            Some(waiting) => *waiting = Some(map.clone()),
            None => self.waiting.push(Some(map.clone())),
        }
    }

    /// Where it is filtered for cones of `width_deg`, if it is.
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

    /// Filters map number `index`, without its suns; `None` if that has been done.
    pub(super) fn filtered(&mut self, gpu: &Gpu, index: usize) -> Option<Buffer> {
        let map = self.waiting.get_mut(index)?.take()?;
        let rest = split(&map.map).rest;
        let filtered = self.widths_deg.iter().flat_map(|width_deg| blurred(&rest, *width_deg).texels);
        let texels: Vec<[f32; 4]> = filtered.map(|[r, g, b]| [r, g, b, 0.0]).collect();
        Some(gpu.storage("filtered map", &texels))
    }
}
