//! The columns that have arrived, and the pass that sums them up.

use super::ACCUMULATE;
use super::gpu_data::{Dispatch, Run};
use super::storage::{self, Band};
use crate::error::Result;
use crate::gpu::{Gpu, Passes};
use relume_formats::kinds::sparse_transfer::{Block, Meta};
use relume_formats::{Error as FormatError, Place};
use wgpu::BufferUsages;

/// Invocations of a workgroup, as in the shader.
const WORKGROUP: u32 = 64;

/// Columns, and the radiance at every vertex.
pub(super) struct Columns {
    meta: Meta,
    blocks_arrived: usize,
    bands: Vec<Band>,
    /// Bands of which anything has arrived.
    work: Vec<Work>,
    pipeline: wgpu::ComputePipeline,
    radiance: wgpu::Buffer,
}

/// The GPU's side of a band.
struct Work {
    words: wgpu::Buffer,
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

impl Columns {
    /// No columns yet of those that `meta` announces.
    ///
    /// # Errors
    /// If there are more vertices than the GPU can bind.
    pub(super) fn new(gpu: &Gpu, meta: Meta, place: &Place) -> Result<Self> {
        let radiance_bytes = u64::from(meta.vertices) * size_of::<[f32; 4]>() as u64;
        let too_much = |bytes: u64| {
            let (name, most) = (&gpu.name, gpu.binding_bytes);
            FormatError::unsupported(
                place,
                format!(
                    "{bytes} bytes for all vertices, GPU {name} binds at most {most}; use a coarser mesh"
                ),
            )
        };
        let bands = storage::arrange(&meta, gpu.binding_bytes).map_err(too_much)?;
        if radiance_bytes > gpu.binding_bytes {
            return Err(too_much(radiance_bytes).into());
        }
        let usage = BufferUsages::STORAGE | BufferUsages::VERTEX | BufferUsages::COPY_SRC;
        Ok(Self {
            blocks_arrived: 0,
            bands,
            work: Vec::new(),
            pipeline: gpu.compute_pipeline(ACCUMULATE, "accumulate"),
            radiance: gpu.buffer("radiance", radiance_bytes, usage),
            meta,
        })
    }

    /// Uploads the next block, to be multiplied with `light`.
    pub(super) fn block_arrived(&mut self, gpu: &Gpu, block: &Block, light: &wgpu::Buffer) {
        let number = self.blocks_arrived;
        for (index, band) in self.bands.iter().enumerate() {
            let mut here = band.pieces.iter().filter(|piece| piece.block == number).peekable();
            if here.peek().is_none() {
                continue;
            }
            // Blocks come in their order, and so do bands.
            if index == self.work.len() {
                self.work.push(self.work_on(gpu, band, light));
            }
            let Some(work) = self.work.get(index) else { continue };
            for piece in here {
                gpu.write(
                    &work.words,
                    4 * u64::from(piece.run.indices),
                    &storage::pack(&self.meta, block, &piece.terms),
                );
            }
            let dispatch = Dispatch {
                vertices: self.meta.vertices,
                runs: band.pieces.iter().filter(|piece| piece.block <= number).count() as u32,
                channels: self.meta.channels() as u32,
                accumulate: u32::from(index > 0),
                unit: self.meta.unit,
            };
            gpu.write(&work.uniform, 0, bytemuck::bytes_of(&dispatch));
        }
        self.blocks_arrived += 1;
    }

    fn work_on(&self, gpu: &Gpu, band: &Band, light: &wgpu::Buffer) -> Work {
        let runs: Vec<Run> = band.pieces.iter().map(|piece| piece.run).collect();
        let runs = gpu.storage("runs", &runs);
        let words =
            gpu.buffer("columns", 4 * u64::from(band.words), BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let uniform = gpu.buffer(
            "dispatch",
            size_of::<Dispatch>() as u64,
            BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        );
        let resources = [&uniform, &runs, &words, light, &self.radiance].map(wgpu::Buffer::as_entire_binding);
        let bindings = gpu.bind(&self.pipeline.get_bind_group_layout(0), resources);
        Work { words, uniform, bindings }
    }

    /// Encodes the pass over all that has arrived: band by band, for later bands add to what earlier ones
    /// left.
    pub(super) fn encode(&self, gpu_workgroups: [u32; 2], passes: &mut Passes<'_>) {
        let mut pass = passes.compute("accumulate");
        pass.set_pipeline(&self.pipeline);
        for work in &self.work {
            pass.set_bind_group(0, &work.bindings, &[]);
            pass.dispatch_workgroups(gpu_workgroups[0], gpu_workgroups[1], 1);
        }
    }

    /// What [`Columns::encode`] dispatches.
    pub(super) fn workgroups(&self, gpu: &Gpu) -> [u32; 2] {
        gpu.workgroups(self.meta.vertices, WORKGROUP)
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
        let bytes = |band: &Band| {
            let missing = band.pieces.iter().find(|piece| piece.block >= self.blocks_arrived);
            4 * u64::from(missing.map_or(band.words, |piece| piece.run.indices))
        };
        self.bands.iter().map(bytes).sum()
    }

    /// By vertex: W/(sr·m²) before the light's gain, four floats of which the last is unused.
    pub(super) fn radiance(&self) -> &wgpu::Buffer {
        &self.radiance
    }
}
