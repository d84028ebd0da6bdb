//! The GPU: device, buffers, read-back, timestamps. Only what every WebGPU device offers is required; timestamps are used where they exist.

mod adapter;
mod readback;
mod timer;
mod tonemap;

pub use adapter::list;
pub use readback::Readback;
pub use timer::Timer;
pub use tonemap::Tonemap;

use crate::error::{Error, Result};
use std::sync::{Arc, Mutex, PoisonError};

/// No binding is larger than this, whatever the device allows: the smallest limit that a WebGPU device may have.
const MAX_BINDING_BYTES: u64 = 128 << 20;

/// An open device.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What the adapter says of itself.
    pub info: wgpu::AdapterInfo,
    /// The adapter that the device was opened on.
    pub adapter: wgpu::Adapter,
    /// Largest storage binding to make, in bytes.
    pub binding_bytes: u64,
    /// Most workgroups along one dimension of a dispatch.
    pub workgroups_per_dimension: u32,
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the adapter whose name contains `adapter` in any case, or the one that promises most speed.
    ///
    /// # Errors
    /// [`Error::Usage`] if several adapters match or none; [`Error::Failed`] if there is no adapter or it cannot be opened.
    pub fn open(adapter: Option<&str>) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        Self::open_adapter(adapter::choose(&instance, None, adapter)?)
    }

    /// Like [`Gpu::open`], among the adapters that can show on `surface`.
    pub fn open_for(instance: &wgpu::Instance, surface: &wgpu::Surface<'_>, adapter: Option<&str>) -> Result<Self> {
        Self::open_adapter(adapter::choose(instance, Some(surface), adapter)?)
    }

    fn open_adapter(adapter: wgpu::Adapter) -> Result<Self> {
        let info = adapter.get_info();
        // A film or a window may be larger than the textures that every device has.
        let max_texture_dimension_2d = adapter.limits().max_texture_dimension_2d;
        let limits = wgpu::Limits { max_texture_dimension_2d, ..Default::default() };
        let binding_bytes = limits.max_storage_buffer_binding_size.min(MAX_BINDING_BYTES);
        let workgroups_per_dimension = limits.max_compute_workgroups_per_dimension;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("relume player"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| Error::Failed(format!("cannot open GPU adapter {}: {e}; choose another with --adapter", info.name)))?;
        let failure = Arc::new(Mutex::new(None));
        let first = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            // What follows the first error is mostly its consequence.
            first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        Ok(Self { device, queue, info, adapter, binding_bytes, workgroups_per_dimension, failure })
    }

    /// Fails if anything went wrong on the device since it was opened.
    pub fn check(&self) -> Result<()> {
        match &*self.failure.lock().unwrap_or_else(PoisonError::into_inner) {
            None => Ok(()),
            Some(error) => Err(Error::Failed(format!("GPU {}: {error}", self.info.name))),
        }
    }

    /// A buffer of at least `bytes` bytes, all zero.
    pub fn buffer(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        // Bindings must not be empty, and copies go by four bytes.
        let size = bytes.next_multiple_of(4).max(4);
        self.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
    }

    /// A storage buffer that holds `values`; room for one element at least, for bindings must not be empty.
    pub fn storage<T: bytemuck::Pod>(&self, label: &str, values: &[T]) -> wgpu::Buffer {
        let bytes = size_of_val(values).max(size_of::<T>()) as u64;
        let buffer = self.buffer(label, bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
        self.write(&buffer, 0, bytemuck::cast_slice(values));
        buffer
    }

    /// Writes `bytes`, a multiple of 4 long, into `buffer`, and sees to it that no copy of them stays behind.
    pub fn write(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.queue.write_buffer(buffer, offset, bytes);
            // wgpu keeps its copy until a submission has used it; a whole bundle would pile up otherwise.
            self.queue.submit([]);
        }
    }

    /// Workgroups of `lanes` invocations each for `items` of them, in two dimensions where one does not reach.
    pub fn workgroups(&self, items: u32, lanes: u32) -> [u32; 2] {
        let groups = items.div_ceil(lanes);
        let rows = groups.div_ceil(self.workgroups_per_dimension).max(1);
        [groups.div_ceil(rows), rows]
    }

    /// Waits until everything submitted is done.
    pub fn wait(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| Error::Failed(format!("GPU {}: {e}", self.info.name)))?;
        self.check()
    }
}
