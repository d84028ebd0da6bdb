//! The caller's device, and what is made on it: buffers, pipelines, timed passes, the film and what a display
//! shows of it.
//!
//! Only what every WebGPU device offers is required; timestamps are used where they exist. Nothing here
//! waits: not for the GPU, nor for anything else.

mod film;
#[cfg(test)]
pub(crate) mod layout;
mod passes;
pub(crate) mod shader;
mod timer;
mod tonemap;

pub use film::Film;
pub(crate) use passes::Passes;
pub use timer::PassTimes;
pub(crate) use timer::Timer;
pub(crate) use tonemap::Tonemap;

use crate::error::{Error, Result};

/// No binding is larger than this, whatever the device allows: the smallest limit that a WebGPU device may
/// have.
const MAX_BINDING_BYTES: u64 = 128 << 20;

/// A device and how it is used.
pub(crate) struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// What the adapter is called, for messages.
    pub(crate) name: String,
    /// Largest storage binding to make, in bytes.
    pub(crate) binding_bytes: u64,
    /// Most workgroups along one dimension of a dispatch.
    pub(crate) workgroups_per_dimension: u32,
    /// Whether methods are to do their sums on the CPU, and the device only draws.
    pub(crate) radiance_on_cpu: bool,
}

impl Gpu {
    /// The device behind `queue`.
    ///
    /// # Errors
    /// If it was opened with lower limits than every WebGPU device has.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, radiance_on_cpu: bool) -> Result<Self> {
        let (limits, name) = (device.limits(), device.adapter_info().name);
        let mut short = None;
        wgpu::Limits::default().check_limits_with_fail_fn(&limits, false, |limit, needed, there| {
            short.get_or_insert(format!(
                "GPU {name}: limit {limit} is {there}, {needed} is needed; open the device with `wgpu::Limits::default()`"
            ));
        });
        if let Some(reason) = short {
            return Err(Error::Request(reason));
        }
        Ok(Self {
            binding_bytes: limits.max_storage_buffer_binding_size.min(MAX_BINDING_BYTES),
            workgroups_per_dimension: limits.max_compute_workgroups_per_dimension,
            device: device.clone(),
            queue: queue.clone(),
            name,
            radiance_on_cpu,
        })
    }

    /// A buffer of at least `bytes` bytes, all zero.
    pub(crate) fn buffer(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        // Bindings must not be empty, and copies go by four bytes.
        let size = bytes.next_multiple_of(4).max(4);
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// A storage buffer that holds `values`; room for one element at least, for bindings must not be empty.
    pub(crate) fn storage<T: bytemuck::Pod>(&self, label: &str, values: &[T]) -> wgpu::Buffer {
        let bytes = size_of_val(values).max(size_of::<T>()) as u64;
        let buffer = self.buffer(label, bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
        self.write(&buffer, 0, bytemuck::cast_slice(values));
        buffer
    }

    /// Writes `bytes`, a multiple of 4 long, into `buffer`, and sees to it that no copy of them stays behind.
    pub(crate) fn write(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.queue.write_buffer(buffer, offset, bytes);
            // wgpu keeps its copy until a submission has used it; a whole bundle would pile up otherwise.
            self.queue.submit([]);
        }
    }

    /// A texture of `size` texels that holds `bytes`, row by row.
    pub(crate) fn texture(
        &self,
        label: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        bytes: &[u8],
    ) -> wgpu::TextureView {
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
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), bytes, layout, size);
        // As with buffers, the copy of `bytes` is not to stay.
        self.queue.submit([]);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// A texture of `size` texels to draw on and then to read.
    pub(crate) fn target(
        &self,
        label: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> wgpu::TextureView {
        self.drawable(label, size, 1, format).create_view(&wgpu::TextureViewDescriptor::default())
    }

    fn drawable(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        layers: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    }

    /// A texture of `count` layers of `side`² texels to draw on and then to read: all of it, and by layer.
    pub(crate) fn layers(
        &self,
        label: &str,
        side: u32,
        count: u32,
        format: wgpu::TextureFormat,
    ) -> (wgpu::TextureView, Vec<wgpu::TextureView>) {
        let texture = self.drawable(label, [side; 2], count, format);
        let view = |dimension, layers: std::ops::Range<u32>| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer: layers.start,
                array_layer_count: Some(layers.end - layers.start),
                ..Default::default()
            })
        };
        let by_layer = (0..count).map(|layer| view(wgpu::TextureViewDimension::D2, layer..layer + 1));
        (view(wgpu::TextureViewDimension::D2Array, 0..count), by_layer.collect())
    }

    /// The compute pipeline of `entry_point` in the shader `source`; its bindings follow from what it uses.
    pub(crate) fn compute_pipeline(&self, source: &str, entry_point: &'static str) -> wgpu::ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: None,
            module: &self.shader(entry_point, source),
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    }

    /// A shader, called `label` in messages, with what it imports.
    pub(crate) fn shader(&self, label: &str, source: &str) -> wgpu::ShaderModule {
        let source = wgpu::ShaderSource::Wgsl(shader::expand(source).into());
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
    }

    /// Binds `resources` in the order of the shader's bindings, from 0 on.
    pub(crate) fn bind<'a>(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
    ) -> wgpu::BindGroup {
        self.bind_at(layout, (0..).zip(resources))
    }

    /// Binds resources at the numbers of their bindings, for entry points that leave some out.
    pub(crate) fn bind_at<'a>(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: impl IntoIterator<Item = (u32, wgpu::BindingResource<'a>)>,
    ) -> wgpu::BindGroup {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &resources.into_iter().map(entry).collect::<Vec<_>>(),
        })
    }

    /// Workgroups of `lanes` invocations each for `items` of them, in two dimensions where one does not
    /// reach.
    pub(crate) fn workgroups(&self, items: u32, lanes: u32) -> [u32; 2] {
        let groups = items.div_ceil(lanes);
        let rows = groups.div_ceil(self.workgroups_per_dimension).max(1);
        [groups.div_ceil(rows), rows]
    }
}
