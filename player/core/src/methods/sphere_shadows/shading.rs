//! Light and lobes on the GPU: the light's terms, the folded weights, and the pass that makes radiance of
//! bitmaps.
//!
//! Why folding gives the sums of the source's loops is told in [`relume_formats::fast::sphere_shadows`]: with
//! light and lobe given these are linear in the coefficients and means of visibility, whatever terms and
//! levels are kept. So the loops over terms run once per change of the light and for each of a few hundred
//! lobes, not for each of the receivers, for which a dot product with the tiles of its bitmap remains.

use super::blockers::Blockers;
use super::gpu_data::Keep;
use super::{FOLD, SHADE, TERMS};
use crate::gpu::{Gpu, Passes};
use half::f16;
use relume_formats::evaluate::sphere_shadows::{Detail, Function, Levels};
use relume_formats::kinds::HaarTable;
use relume_formats::kinds::sphere_shadows::COEFFICIENTS;
use relume_formats::state::Rgb;
use wgpu::BufferUsages;

/// Receivers of a workgroup that shades, as in the shader.
const WORKGROUP: u32 = 32;
/// Squares over which means are taken, of a cube.
const MEANS: u64 = 6 * 341;
/// Tiles of 4 × 4 texels, of a cube.
const TILES: u64 = 6 * 64;
/// Words of the lists of tiles with fine terms: for each face a count, and room for all.
const TILE_LISTS: u64 = 6 * 65;

/// Everything between light, bitmaps and radiance.
pub(super) struct Shading {
    detail: Detail,
    keep: wgpu::Buffer,
    prepare: (wgpu::ComputePipeline, wgpu::BindGroup),
    fold: (wgpu::ComputePipeline, wgpu::BindGroup),
    fold_workgroups: [u32; 2],
    shade: wgpu::ComputePipeline,
    /// By batch of receivers.
    batches: Vec<(wgpu::BindGroup, [u32; 2])>,
    weight_bytes: u64,
}

impl Shading {
    /// Of `lobes`, cut to the terms of `detail`, in the light of these `coefficients`, for the bitmaps of
    /// `blockers`, to `radiance`.
    pub(super) fn new(
        gpu: &Gpu,
        detail: Detail,
        lobes: &[Function],
        coefficients: &wgpu::Buffer,
        blockers: &Blockers,
        radiance: &wgpu::Buffer,
    ) -> Self {
        let vectors = |label, count: u64| {
            gpu.buffer(label, count * size_of::<[f32; 4]>() as u64, BufferUsages::STORAGE)
        };
        let (means, kept) = (vectors("light means", MEANS), vectors("light terms", COEFFICIENTS as u64));
        let weights = vectors("weights", lobes.len() as u64 * TILES);
        let tiles = gpu.buffer("fine tiles", TILE_LISTS * size_of::<u32>() as u64, BufferUsages::STORAGE);
        let lobe_means =
            gpu.storage("lobe means", &lobes.iter().flat_map(Function::psums).copied().collect::<Vec<f32>>());
        let lobe_terms = gpu.storage("lobe terms", &lobes.iter().flat_map(dense_terms).collect::<Vec<f32>>());
        let table = gpu.storage(
            "Haar table",
            &HaarTable::bake().coefficients().iter().map(|c| f16::from_f32(*c)).collect::<Vec<f16>>(),
        );
        let keep =
            gpu.buffer("kept", size_of::<Keep>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let pass = |shader, entry, buffers: &[&wgpu::Buffer]| {
            let pipeline = gpu.compute_pipeline(shader, entry);
            let bindings = gpu.bind(
                &pipeline.get_bind_group_layout(0),
                buffers.iter().map(|buffer| buffer.as_entire_binding()),
            );
            (pipeline, bindings)
        };
        let prepare = pass(TERMS, "prepare", &[&keep, coefficients, &means, &kept, &tiles]);
        let fold = pass(FOLD, "fold", &[coefficients, &means, &kept, &lobe_terms, &lobe_means, &weights]);
        let shade = gpu.compute_pipeline(SHADE, "shade");
        let batch = |bitmaps: &super::blockers::Bitmaps| {
            let buffers = [
                &bitmaps.uniform,
                &bitmaps.rows,
                &blockers.lobes,
                &weights,
                &lobe_means,
                &kept,
                &tiles,
                &table,
                radiance,
            ];
            let bindings =
                gpu.bind(&shade.get_bind_group_layout(0), buffers.map(wgpu::Buffer::as_entire_binding));
            (bindings, gpu.workgroups(bitmaps.count, WORKGROUP))
        };
        let batches = blockers.batches.iter().map(batch).collect();
        let fold_workgroups = gpu.workgroups(6 * lobes.len() as u32, 1);
        Self { detail, keep, prepare, fold, fold_workgroups, shade, batches, weight_bytes: weights.size() }
    }

    /// Sets the factor on the light, which decides with its size what is kept of it.
    pub(super) fn set_gain(&self, gpu: &Gpu, gain: Rgb) {
        let terms = self.detail.terms.unwrap_or(COEFFICIENTS) as u32;
        let keep = Keep { gain, terms, fine: u32::from(self.detail.levels == Levels::Two), unused: [0; 3] };
        gpu.queue.write_buffer(&self.keep, 0, bytemuck::bytes_of(&keep));
    }

    /// Encodes the passes that fold the light into the lobes.
    pub(super) fn encode_fold(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("fold");
        let [x, y] = self.fold_workgroups;
        for ((pipeline, bindings), [x, y]) in [(&self.prepare, [1, 1]), (&self.fold, [x, y])] {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
    }

    /// Encodes the pass that makes radiance of bitmaps.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("shade");
        pass.set_pipeline(&self.shade);
        for (bindings, [x, y]) in &self.batches {
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }

    /// Bytes of the folded weights.
    pub(super) fn bytes(&self) -> u64 {
        self.weight_bytes
    }
}

/// Its coefficients, with zeros where they are not kept.
fn dense_terms(function: &Function) -> Vec<f32> {
    let mut dense = vec![0.0; COEFFICIENTS];
    for (index, value) in function.terms() {
        dense.get_mut(*index as usize).into_iter().for_each(|coefficient| *coefficient = *value);
    }
    dense
}
