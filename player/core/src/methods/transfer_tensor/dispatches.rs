//! A pipeline, and what it is dispatched over.

use crate::gpu::{Gpu, Passes};
use wgpu::{BindGroup, Buffer, BufferUsages, ComputePipeline};

/// One pipeline, over one piece after the other.
pub(super) struct Dispatches {
    label: &'static str,
    pipeline: ComputePipeline,
    pieces: Vec<(BindGroup, [u32; 2])>,
}

impl Dispatches {
    /// No pieces yet for the entry point `label` of `shader`.
    pub(super) fn new(gpu: &Gpu, shader: &str, label: &'static str) -> Self {
        Self { label, pipeline: gpu.compute_pipeline(shader, label), pieces: Vec::new() }
    }

    /// Adds a piece with `buffers` in the order of the shader's bindings.
    pub(super) fn push(&mut self, gpu: &Gpu, buffers: &[&Buffer], workgroups: [u32; 2]) {
        let resources = buffers.iter().map(|buffer| buffer.as_entire_binding());
        self.pieces.push((gpu.bind(&self.pipeline.get_bind_group_layout(0), resources), workgroups));
    }

    /// Encodes all of them.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        self.encode_with(passes, None);
    }

    /// Encodes all of them with what they have in common.
    pub(super) fn encode_with(&self, passes: &mut Passes<'_>, common: Option<&BindGroup>) {
        let mut pass = passes.compute(self.label);
        pass.set_pipeline(&self.pipeline);
        if let Some(common) = common {
            pass.set_bind_group(1, common, &[]);
        }
        for (bindings, [x, y]) in &self.pieces {
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }

    /// What pieces have in common: `buffer`.
    pub(super) fn common(&self, gpu: &Gpu, buffer: &Buffer) -> BindGroup {
        gpu.bind(&self.pipeline.get_bind_group_layout(1), [buffer.as_entire_binding()])
    }
}

/// A uniform buffer that holds `value`.
pub(super) fn uniform<T: bytemuck::Pod>(gpu: &Gpu, label: &str, value: &T) -> Buffer {
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let buffer = gpu.buffer(label, size_of::<T>() as u64, usage);
    gpu.write(&buffer, 0, bytemuck::bytes_of(value));
    buffer
}
