//! The receivers' bitmaps on the GPU: what they are computed from, and the pass that does.

use super::CAPS;
use super::gpu_data::{Batch, Lobes};
use super::receivers::Receivers;
use crate::error::Result;
use crate::gpu::{Gpu, Passes};
use relume_formats::basis::cap::ROWS;
use relume_formats::evaluate::sphere_shadows::Spheres;
use relume_formats::{Error as FormatError, Place};
use std::ops::Range;
use wgpu::BufferUsages;

/// Receivers of a workgroup that computes bitmaps, as in the shader.
const WORKGROUP: u32 = 64;
/// Bytes of a bitmap.
const BITMAP_BYTES: u64 = (ROWS * size_of::<u32>()) as u64;

/// Receivers, spheres and bitmaps.
pub(super) struct Blockers {
    positions: wgpu::Buffer,
    normals: wgpu::Buffer,
    /// [`Lobes`] of each receiver.
    pub(super) lobes: wgpu::Buffer,
    spheres: wgpu::Buffer,
    pipeline: wgpu::ComputePipeline,
    pub(super) batches: Vec<Bitmaps>,
}

/// The bitmaps of a batch.
pub(super) struct Bitmaps {
    /// How many receivers it has.
    pub(super) count: u32,
    /// The struct [`Batch`].
    pub(super) uniform: wgpu::Buffer,
    /// [192, count] rows of 32 texels.
    pub(super) rows: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Blockers {
    /// Uploads `receivers` as they stand; `positions` is what their meshes are drawn from.
    ///
    /// # Errors
    /// If an object has more spheres than the GPU can bind a table of neighbours for.
    pub(super) fn new(
        gpu: &Gpu,
        receivers: &Receivers,
        positions: &wgpu::Buffer,
        place: &Place,
    ) -> Result<Self> {
        let (owns, near) = neighbourhoods(receivers);
        let bytes = size_of_val(&near[..]) as u64;
        if bytes > gpu.binding_bytes {
            let (name, most) = (&gpu.name, gpu.binding_bytes);
            let reason = format!(
                "{bytes} bytes for which spheres overlap, GPU {name} binds at most {most}; bake with fewer spheres"
            );
            return Err(FormatError::unsupported(place, reason).into());
        }
        let (owns, near) = (gpu.storage("own spheres", &owns), gpu.storage("near spheres", &near));
        let (count, usage) = (receivers.now().len() as u64, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let spheres = receivers.sets().iter().map(|set| set.now.len()).sum::<usize>();
        let mut blockers = Self {
            positions: positions.clone(),
            normals: gpu.buffer("normals", count * size_of::<[f32; 3]>() as u64, usage),
            lobes: gpu.buffer("lobes", count * size_of::<Lobes>() as u64, usage),
            spheres: gpu.buffer("spheres", (spheres.max(1) * size_of::<[f32; 4]>()) as u64, usage),
            pipeline: gpu.compute_pipeline(CAPS, "block"),
            batches: Vec::new(),
        };
        let most = (gpu.binding_bytes / BITMAP_BYTES).max(1) as u32;
        let batch =
            |first: u32| Batch { first, count: most.min(count as u32 - first), spheres: spheres as u32 };
        let batches = (0..count as u32).step_by(most as usize).map(batch);
        blockers.batches = batches.map(|batch| blockers.batch(gpu, &batch, &owns, &near)).collect();
        blockers.upload(gpu, receivers, 0..receivers.now().len());
        blockers.upload_spheres(gpu, receivers);
        Ok(blockers)
    }

    fn batch(&self, gpu: &Gpu, batch: &Batch, owns: &wgpu::Buffer, near: &wgpu::Buffer) -> Bitmaps {
        let uniform =
            gpu.buffer("batch", size_of::<Batch>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        gpu.write(&uniform, 0, bytemuck::bytes_of(batch));
        let rows = gpu.buffer(
            "bitmaps",
            u64::from(batch.count) * BITMAP_BYTES,
            BufferUsages::STORAGE | BufferUsages::COPY_SRC,
        );
        let resources = [&uniform, &self.positions, &self.normals, owns, &self.spheres, near, &rows];
        let bindings =
            gpu.bind(&self.pipeline.get_bind_group_layout(0), resources.map(wgpu::Buffer::as_entire_binding));
        Bitmaps {
            count: batch.count,
            uniform,
            rows,
            bindings,
            workgroups: gpu.workgroups(batch.count, WORKGROUP),
        }
    }

    /// Uploads the receivers of a range, but for their positions, for what is submitted next.
    pub(super) fn upload(&self, gpu: &Gpu, receivers: &Receivers, range: Range<usize>) {
        let (first, of) = (range.start as u64, &receivers.now()[range]);
        let normals: Vec<[f32; 3]> = of.iter().map(|receiver| receiver.normal.to_array()).collect();
        let lobes = of
            .iter()
            .map(|r| Lobes { rows: r.lobes.map(|(row, _)| row), weights: r.lobes.map(|(_, weight)| weight) });
        gpu.queue.write_buffer(
            &self.normals,
            first * size_of::<[f32; 3]>() as u64,
            bytemuck::cast_slice(&normals),
        );
        gpu.queue.write_buffer(
            &self.lobes,
            first * size_of::<Lobes>() as u64,
            bytemuck::cast_slice(&lobes.collect::<Vec<Lobes>>()),
        );
    }

    /// Uploads all spheres, for what is submitted next.
    pub(super) fn upload_spheres(&self, gpu: &Gpu, receivers: &Receivers) {
        let spheres: Vec<[f32; 4]> =
            receivers.sets().iter().flat_map(|set| set.now.iter().copied()).collect();
        gpu.queue.write_buffer(&self.spheres, 0, bytemuck::cast_slice(&spheres));
    }

    /// Encodes the pass that brings the bitmaps up to date.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("caps");
        pass.set_pipeline(&self.pipeline);
        for Bitmaps { bindings, workgroups: [x, y], .. } in &self.batches {
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(*x, *y, 6);
        }
    }

    /// Bytes of all bitmaps.
    pub(super) fn bytes(&self) -> u64 {
        self.batches.iter().map(|batch| u64::from(batch.count) * BITMAP_BYTES).sum()
    }
}

/// For each receiver its own set's first sphere, the one behind the last, and where its sphere's row begins
/// in the table of neighbours; and that table, a row of bits for each sphere. A receiver without a set has an
/// empty one.
fn neighbourhoods(receivers: &Receivers) -> (Vec<[u32; 4]>, Vec<u32>) {
    let (mut near, mut sets) = (Vec::new(), Vec::new());
    let mut first = 0;
    for Spheres { now, neighbours } in receivers.sets() {
        let (start, words) = (near.len(), now.len().div_ceil(32));
        sets.push((first, first + now.len(), start, words));
        first += now.len();
        near.resize(start + words * now.len(), 0u32);
        for (row, others) in near[start..].chunks_exact_mut(words.max(1)).zip(neighbours) {
            others.iter().for_each(|other| row[*other as usize / 32] |= 1 << (other % 32));
        }
    }
    let own = |own: relume_formats::evaluate::sphere_shadows::Own| {
        let (first, end, start, words) = sets[own.set as usize];
        [first as u32, end as u32, (start + words * own.sphere as usize) as u32, 0]
    };
    (receivers.now().iter().map(|receiver| receiver.own.map_or([0; 4], own)).collect(), near)
}
