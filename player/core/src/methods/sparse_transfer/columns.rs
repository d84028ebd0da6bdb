//! The columns that have arrived, and the pass that sums them up.

use super::ACCUMULATE;
use super::gpu_data::Dispatch;
use super::storage;
use crate::error::Result;
use crate::gpu::{Gpu, Passes};
use relume_formats::kinds::sparse_transfer::{Block, Meta};
use relume_formats::{Error as FormatError, Place};
use std::ops::Range;
use wgpu::BufferUsages;

/// Columns, and the radiance at every vertex.
pub(super) struct Columns {
    meta: Meta,
    blocks_arrived: usize,
    bands: Vec<Band>,
    pipeline: wgpu::ComputePipeline,
    radiance: wgpu::Buffer,
}

/// Tiles that share a storage buffer.
struct Band {
    tiles: Range<u32>,
    words: wgpu::Buffer,
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Columns {
    /// No columns yet of those that `meta` announces, to be multiplied with `light`.
    ///
    /// # Errors
    /// If there are more vertices than the GPU can bind.
    pub(super) fn new(gpu: &Gpu, meta: Meta, light: &wgpu::Buffer, place: &Place) -> Result<Self> {
        let radiance_bytes = u64::from(meta.vertices) * size_of::<[f32; 4]>() as u64;
        let too_much = |bytes: u64| {
            let (name, most) = (&gpu.name, gpu.binding_bytes);
            let reason = format!("needs {bytes} bytes in one piece, GPU {name} binds at most {most}");
            FormatError::unsupported(place, format!("{reason}; use a coarser mesh"))
        };
        let bands = storage::arrange(&meta, gpu.binding_bytes).map_err(too_much)?;
        if radiance_bytes > gpu.binding_bytes {
            return Err(too_much(radiance_bytes).into());
        }
        let usage = BufferUsages::STORAGE | BufferUsages::VERTEX | BufferUsages::COPY_SRC;
        let radiance = gpu.buffer("radiance", radiance_bytes, usage);
        let pipeline = gpu.compute_pipeline(ACCUMULATE, "accumulate");
        let layout = pipeline.get_bind_group_layout(0);
        let band = |tiles: Range<u32>| {
            let count = tiles.len() as u32;
            let units = gpu.storage("units", &storage::units(&meta, meta.blocks.len(), count));
            let copied = |label, bytes, usage| gpu.buffer(label, bytes, usage | BufferUsages::COPY_DST);
            let bytes = u64::from(count) * storage::tile_bytes(&meta, meta.blocks.len());
            let words = copied("columns", bytes, BufferUsages::STORAGE);
            let uniform = copied("dispatch", size_of::<Dispatch>() as u64, BufferUsages::UNIFORM);
            let resources = [&uniform, &units, &words, light, &radiance].map(wgpu::Buffer::as_entire_binding);
            let bindings = gpu.bind(&layout, resources);
            Band { tiles, words, uniform, bindings, workgroups: gpu.workgroups(count, 1) }
        };
        let bands = bands.into_iter().map(band).collect();
        Ok(Self { meta, blocks_arrived: 0, bands, pipeline, radiance })
    }

    /// Uploads the next block.
    pub(super) fn block_arrived(&mut self, gpu: &Gpu, block: &Block) {
        let number = self.blocks_arrived;
        self.blocks_arrived += 1;
        for Band { tiles, words, uniform, .. } in &self.bands {
            let count = tiles.len() as u32;
            let before = u64::from(count) * storage::tile_bytes(&self.meta, number);
            gpu.write(words, before, &storage::pack(&self.meta, number, block, tiles.clone()));
            let dispatch = Dispatch {
                vertices: self.meta.vertices,
                first_tile: tiles.start,
                tiles: count,
                units: storage::units(&self.meta, self.blocks_arrived, count).len() as u32,
                channels: self.meta.channels() as u32,
                unit: self.meta.unit,
            };
            gpu.write(uniform, 0, bytemuck::bytes_of(&dispatch));
        }
    }

    /// Encodes the pass over all that has arrived.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("accumulate");
        pass.set_pipeline(&self.pipeline);
        for band in &self.bands {
            pass.set_bind_group(0, &band.bindings, &[]);
            pass.dispatch_workgroups(band.workgroups[0], band.workgroups[1], 1);
        }
    }

    /// Announced blocks.
    pub(super) fn meta(&self) -> &Meta {
        &self.meta
    }

    /// Number of blocks that have arrived.
    pub(super) fn blocks_arrived(&self) -> usize {
        self.blocks_arrived
    }

    /// Bytes of columns that the pass reads.
    pub(super) fn bytes(&self) -> u64 {
        let tile = storage::tile_bytes(&self.meta, self.blocks_arrived);
        self.bands.iter().map(|band| band.tiles.len() as u64 * tile).sum()
    }

    /// By vertex: W/(sr·m²) before the light's gain, four floats of which the last is unused.
    pub(super) fn radiance(&self) -> &wgpu::Buffer {
        &self.radiance
    }
}
