//! The GPU: device, buffers, read-back, timestamps. Only what every WebGPU device offers is required; timestamps are used where they exist.

mod adapter;
mod film;
#[cfg(test)]
pub(crate) mod layout;
mod passes;
mod readback;
mod tonemap;

pub use adapter::list;
pub use film::Film;
pub use passes::{PassTimes, Passes, Timer};
pub use readback::Readback;
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
    /// Whether methods are to do their sums on the CPU, and the device only draws.
    pub radiance_on_cpu: bool,
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the adapter whose name contains `adapter` in any case, or the one that promises most speed. `cpu` is the software adapter, which then draws
    /// what methods compute on the CPU.
    ///
    /// # Errors
    /// [`Error::Usage`] if several adapters match or none; [`Error::Failed`] if there is no adapter or it cannot be opened.
    pub fn open(adapter: Option<&str>) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        Self::open_adapter(adapter::choose(&instance, None, adapter)?, adapter::is_cpu(adapter))
    }

    /// Like [`Gpu::open`], among the adapters that can show on `surface`.
    pub fn open_for(instance: &wgpu::Instance, surface: &wgpu::Surface<'_>, adapter: Option<&str>) -> Result<Self> {
        Self::open_adapter(adapter::choose(instance, Some(surface), adapter)?, adapter::is_cpu(adapter))
    }

    fn open_adapter(adapter: wgpu::Adapter, radiance_on_cpu: bool) -> Result<Self> {
        let mut info = adapter.get_info();
        if radiance_on_cpu {
            info.name = format!("{} ({} draws)", adapter::CPU, info.name);
        }
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
        Ok(Self { device, queue, info, adapter, binding_bytes, workgroups_per_dimension, radiance_on_cpu, failure })
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

    /// A texture of `size` texels that holds `bytes`, row by row.
    pub fn texture(&self, label: &str, size: [u32; 2], format: wgpu::TextureFormat, bytes: &[u8]) -> wgpu::TextureView {
        let [width, height] = size;
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let row_bytes = bytes.len() as u32 / height.max(1);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), bytes, layout, size);
        // As with buffers, the copy of `bytes` is not to stay.
        self.queue.submit([]);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// A texture of `size` texels to draw on and then to read.
    pub fn target(&self, label: &str, size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureView {
        let [width, height] = size;
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// The compute pipeline of `entry_point` in the shader `source`; its bindings follow from what it uses.
    pub fn compute_pipeline(&self, source: &str, entry_point: &'static str) -> wgpu::ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: None,
            module: &self.shader(entry_point, source),
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    }

    /// A shader, called `label` in messages.
    pub fn shader(&self, label: &str, source: &str) -> wgpu::ShaderModule {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
    }

    /// Binds `resources` in the order of the shader's bindings, from 0 on.
    pub fn bind<'a>(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
    ) -> wgpu::BindGroup {
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &(0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect::<Vec<_>>(),
        })
    }

    /// Whether the "GPU" is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
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
