//! Environment maps as cones see them: filtered on the CPU, each when it first shines, and kept.

use super::dispatches::uniform;
use crate::gpu::Gpu;
use crate::lit::Bound;
use relume_formats::basis::blurred::{blurred, size};
use relume_formats::basis::suns::split;
use relume_formats::kinds::Environment;
use wgpu::{Buffer, TextureView};

/// What filters maps, and the one that shines.
pub(super) struct Blurs {
    widths_deg: Vec<f32>,
    maps: Vec<Map>,
    /// The map that shines for all widths, one below the other.
    texture: TextureView,
    size: [u32; 2],
    /// Sine and cosine of what it is turned by.
    rotation: Buffer,
}

/// A map as it comes, or filtered: rows of all widths, each filled up to the longest.
enum Map {
    Whole(Environment),
    Filtered(Vec<[f32; 4]>),
}

impl Blurs {
    /// Of `maps` for cones of `widths_deg`; none is filtered yet.
    pub(super) fn new(gpu: &Gpu, widths_deg: Vec<f32>, maps: Vec<Environment>) -> Self {
        let sizes = widths_deg.iter().map(|width_deg| size(*width_deg));
        let size = sizes.fold([1, 0], |[most, rows], [width, height]| [width.max(most), rows + height]);
        let size = [size[0], size[1].max(1)];
        let dark = vec![[0.0_f32; 4]; size[0] as usize * size[1] as usize];
        let format = wgpu::TextureFormat::Rgba32Float;
        Self {
            widths_deg,
            maps: maps.into_iter().map(Map::Whole).collect(),
            texture: gpu.texture("filtered map", size, format, bytemuck::cast_slice(&dark)),
            size,
            rotation: uniform(gpu, "rotation", &[0.0_f32, 1.0]),
        }
    }

    /// Takes map number `index`, which is one of those that there are or the next.
    pub(super) fn set(&mut self, index: usize, map: &Environment) {
        let map = Map::Whole(map.clone());
        match self.maps.get_mut(index) {
            Some(known) => *known = map,
            None => self.maps.push(map),
        }
    }

    /// Where maps are filtered for cones of `width_deg`, or the next narrower ones, or the narrowest: the row where they
    /// begin, columns and rows.
    pub(super) fn place(&self, width_deg: f32) -> [u32; 3] {
        let number = self.widths_deg.iter().rposition(|known| *known <= width_deg).unwrap_or(0);
        let before = self.widths_deg.iter().take(number).map(|known| size(*known)[1]).sum();
        let [width, height] = self.widths_deg.get(number).map_or([1; 2], |known| size(*known));
        [before, width, height]
    }

    /// What shaders take of the map that shines, by number of the binding.
    pub(super) fn bound(&self) -> [(u32, Bound); 2] {
        [(12, Bound::Buffer(self.rotation.clone())), (13, Bound::Texture(self.texture.clone()))]
    }

    /// Lets map number `index` shine, filtered without its suns and turned so far.
    pub(super) fn shine(&mut self, gpu: &Gpu, index: usize, rotation_deg: f32) {
        let (sin, cos) = rotation_deg.to_radians().sin_cos();
        gpu.queue.write_buffer(&self.rotation, 0, bytemuck::bytes_of(&[sin, cos]));
        let ([width, height], Some(map)) = (self.size, self.maps.get_mut(index)) else { return };
        if let Map::Whole(environment) = map {
            let rest = split(&environment.map).rest;
            let mut texels = Vec::new();
            for filtered in self.widths_deg.iter().map(|width_deg| blurred(&rest, *width_deg)) {
                for row in filtered.texels.chunks_exact(filtered.width as usize) {
                    let end = texels.len() + width as usize;
                    texels.extend(row.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]));
                    texels.resize(end, [0.0; 4]);
                }
            }
            *map = Map::Filtered(texels);
        }
        if let Map::Filtered(texels) = map {
            write(gpu, &self.texture, [width, height], texels);
        }
    }
}

/// Writes all texels of a texture of `size`, row by row.
pub(super) fn write(gpu: &Gpu, texture: &TextureView, [width, height]: [u32; 2], texels: &[[f32; 4]]) {
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        return;
    }
    let row_bytes = width * size_of::<[f32; 4]>() as u32;
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    gpu.queue.write_texture(texture.texture().as_image_copy(), bytemuck::cast_slice(texels), layout, size);
}
