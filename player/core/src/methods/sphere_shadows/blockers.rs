//! The receivers' bitmaps on the GPU: what they are computed from, and the passes that do.

use super::gpu_data::{Batch, Caster, Lobes, TRIANGLE_BYTES};
use super::poses::Poses;
use super::receivers::Receivers;
use super::{CAPS, PLACE};
use crate::error::Result;
use crate::gpu::{Gpu, Passes};
use relume_formats::basis::cap::ROWS;
use relume_formats::evaluate::sphere_shadows::{Own, Receiver, Spheres};
use relume_formats::shape::Pose;
use relume_formats::{Error as FormatError, Place};
use wgpu::BufferUsages;

/// Receivers of a workgroup that computes bitmaps, and triangles of one that places them, as in the shaders.
const WORKGROUP: u32 = 64;
/// Bytes of a bitmap.
const BITMAP_BYTES: u64 = (ROWS * size_of::<u32>()) as u64;

/// Receivers, spheres and bitmaps.
pub(super) struct Blockers {
    /// If there are shapes that deform.
    poses: Option<Poses>,
    positions: wgpu::Buffer,
    beside: wgpu::Buffer,
    normals: wgpu::Buffer,
    /// [`Lobes`] of each receiver.
    pub(super) lobes: wgpu::Buffer,
    spheres: wgpu::Buffer,
    /// Where triangles are now.
    triangles: wgpu::Buffer,
    placing: Placing,
    pipeline: wgpu::ComputePipeline,
    pub(super) batches: Vec<Bitmaps>,
}

/// What brings the triangles to where their vertices are.
struct Placing {
    pipeline: wgpu::ComputePipeline,
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
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
    /// Uploads `receivers` at rest; their meshes are drawn from these positions and normals.
    ///
    /// # Errors
    /// If an object has more spheres than the GPU can bind a table of neighbours for, or shapes are larger than it
    /// can bind.
    pub(super) fn new(
        gpu: &Gpu,
        receivers: &Receivers,
        [positions, normals]: [&wgpu::Buffer; 2],
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
        let (count, usage) = (receivers.now().len(), BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let lobes: Vec<Lobes> = receivers.now().iter().map(Lobes::new).collect();
        let lobes = gpu.storage("lobes", &lobes);
        let spheres = receivers.spheres().iter().map(|set| set.now.len()).sum::<usize>();
        // A triangle without area is seen from nowhere.
        let nothing = || vec![bytemuck::Zeroable::zeroed()];
        let casters: Vec<Caster> = receivers.casters().iter().map(Caster::new).collect();
        let casters = if casters.is_empty() { nothing() } else { casters };
        let bytes = casters.len() as u64 * TRIANGLE_BYTES;
        let triangles = gpu.buffer("triangles", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let placing = Placing::new(gpu, &casters, [positions, normals], &triangles);
        let mut blockers = Self {
            poses: Poses::new(gpu, receivers.moving(), [positions, normals, &lobes], place)?,
            positions: positions.clone(),
            beside: gpu.storage("vertices beside", receivers.rims().beside()),
            normals: normals.clone(),
            lobes,
            spheres: gpu.buffer("spheres", (spheres.max(1) * size_of::<[f32; 4]>()) as u64, usage),
            triangles,
            placing,
            pipeline: gpu.compute_pipeline(CAPS, "block"),
            batches: Vec::new(),
        };
        let most = (gpu.binding_bytes / BITMAP_BYTES).max(1) as u32;
        let batch =
            |first: u32| Batch { first, count: most.min(count as u32 - first), spheres: spheres as u32 };
        let batches = (0..count as u32).step_by(most as usize).map(batch);
        blockers.batches = batches.map(|batch| blockers.batch(gpu, &batch, &owns, &near)).collect();
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
        let Self { positions, normals, spheres, triangles, beside, .. } = self;
        let resources = [&uniform, positions, normals, owns, spheres, near, &rows, triangles, beside];
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

    /// Uploads all spheres, for what is submitted next.
    pub(super) fn upload_spheres(&self, gpu: &Gpu, receivers: &Receivers) {
        let spheres: Vec<[f32; 4]> =
            receivers.spheres().iter().flat_map(|set| set.now.iter().copied()).collect();
        gpu.queue.write_buffer(&self.spheres, 0, bytemuck::cast_slice(&spheres));
    }

    /// Brings the shape of this number to `pose`, for what is submitted next.
    pub(super) fn set_pose(&self, gpu: &Gpu, shape: usize, pose: &Pose) {
        if let Some(poses) = &self.poses {
            poses.set(gpu, shape, pose);
        }
    }

    /// Encodes the passes that bring shapes and bitmaps up to date.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        if let Some(poses) = &self.poses {
            poses.encode(passes);
        }
        self.placing.encode(passes);
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

impl Placing {
    fn new(
        gpu: &Gpu,
        casters: &[Caster],
        [positions, normals]: [&wgpu::Buffer; 2],
        triangles: &wgpu::Buffer,
    ) -> Self {
        let pipeline = gpu.compute_pipeline(PLACE, "place");
        let buffers = [&gpu.storage("casters", casters), positions, normals, triangles];
        let bindings =
            gpu.bind(&pipeline.get_bind_group_layout(0), buffers.map(wgpu::Buffer::as_entire_binding));
        Self { pipeline, bindings, workgroups: gpu.workgroups(casters.len() as u32, WORKGROUP) }
    }

    fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("place");
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        let [x, y] = self.workgroups;
        pass.dispatch_workgroups(x, y, 1);
    }
}

/// For each receiver its own set's first sphere, the one behind the last, where its sphere's row begins in the
/// table of neighbours, and its object; and that table, a row of bits for each sphere. A receiver without a set
/// has an empty one.
fn neighbourhoods(receivers: &Receivers) -> (Vec<[u32; 4]>, Vec<u32>) {
    let (mut near, mut sets) = (Vec::new(), Vec::new());
    let mut first = 0;
    for Spheres { now, neighbours } in receivers.spheres() {
        let (start, words) = (near.len(), now.len().div_ceil(32));
        sets.push((first, first + now.len(), start, words));
        first += now.len();
        near.resize(start + words * now.len(), 0u32);
        for (row, others) in near[start..].chunks_exact_mut(words.max(1)).zip(neighbours) {
            others.iter().for_each(|other| row[*other as usize / 32] |= 1 << (other % 32));
        }
    }
    let own = |own: Own| {
        let (first, end, start, words) = sets[own.set as usize];
        [first as u32, end as u32, (start + words * own.sphere as usize) as u32]
    };
    let of = |receiver: &Receiver| {
        let [first, end, row] = receiver.own.map_or([0; 3], own);
        [first, end, row, receiver.object]
    };
    (receivers.now().iter().map(of).collect(), near)
}
