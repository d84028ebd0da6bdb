//! A pipeline, and what it is dispatched over.

use crate::gpu::{Gpu, Passes};
use crate::lit::Bound;
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
        let bound = (0..).zip(buffers.iter().map(|buffer| Bound::Buffer((*buffer).clone())));
        self.push_at(gpu, bound, workgroups);
    }

    /// Adds a piece with what the shader takes at the numbers of its bindings.
    pub(super) fn push_at(
        &mut self,
        gpu: &Gpu,
        bound: impl IntoIterator<Item = (u32, Bound)>,
        workgroups: [u32; 2],
    ) {
        let bound: Vec<(u32, Bound)> = bound.into_iter().collect();
        let resources = bound.iter().map(|(binding, bound)| (*binding, bound.resource()));
        self.pieces.push((gpu.bind_at(&self.pipeline.get_bind_group_layout(0), resources), workgroups));
    }

    /// Encodes all of them.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute(self.label);
        pass.set_pipeline(&self.pipeline);
        for (bindings, [x, y]) in &self.pieces {
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }
}

/// A uniform buffer that holds `value`.
pub(super) fn uniform<T: bytemuck::Pod>(gpu: &Gpu, label: &str, value: &T) -> Buffer {
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let buffer = gpu.buffer(label, size_of::<T>() as u64, usage);
    gpu.write(&buffer, 0, bytemuck::bytes_of(value));
    buffer
}
