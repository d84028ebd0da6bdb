//! The GPU that the program opens and waits for: choice of an adapter, the device and its failures,
//! read-back.

mod adapter;
mod priority;
mod readback;

pub use adapter::list;
pub use priority::give_way;
pub use readback::{PictureReadback, Readback};

use crate::error::{Error, Result};
use relume_playback::methods::Method;
use std::sync::{Arc, Mutex, PoisonError};

/// Where methods are to do their sums.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sums {
    /// On the device, which was asked for by its name.
    OnDevice,
    /// On the CPU, as was asked for.
    OnCpu,
    /// Where they take less time.
    WhereFaster,
}

impl Sums {
    /// What is asked for by the name of an adapter, if any.
    fn asked(adapter: Option<&str>) -> Self {
        match adapter {
            None => Self::WhereFaster,
            name if adapter::is_cpu(name) => Self::OnCpu,
            Some(_) => Self::OnDevice,
        }
    }
}

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
    sums: Sums,
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the adapter whose name contains `adapter` in any case, or the one that promises most speed.
    /// `cpu` is the software adapter, which then draws what methods compute on the CPU; it does so, too, if nothing
    /// is asked for and no other adapter is there.
    ///
    /// # Errors
    /// [`Error::Usage`] if several adapters match or none; [`Error::Failed`] if there is no adapter or it
    /// cannot be opened.
    pub fn open(adapter: Option<&str>) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        Self::open_adapter(adapter::choose(&instance, None, adapter)?, Sums::asked(adapter))
    }

    /// Like [`Gpu::open`], among the adapters that can show on `surface`.
    pub fn open_for(
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
        adapter: Option<&str>,
    ) -> Result<Self> {
        Self::open_adapter(adapter::choose(instance, Some(surface), adapter)?, Sums::asked(adapter))
    }

    /// Another device on the same adapter: what is done on one waits for nothing on the other. It has an
    /// instance of its own, for Mesa's software adapter draws one thing at a time for all devices of an
    /// instance. The threads of a software adapter give way to others, see [`give_way`].
    pub fn again(&self) -> Result<Self> {
        if !self.is_software() {
            return self.open_again();
        }
        // Threads are as those that start them.
        let opening = || {
            give_way();
            self.open_again()
        };
        let failed =
            || Err(Error::Failed("the thread that opens the GPU has failed; please report this".to_owned()));
        std::thread::scope(|scope| scope.spawn(opening).join()).unwrap_or_else(|_| failed())
    }

    fn open_again(&self) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let same = adapter::same_as(&instance, &self.adapter.get_info());
        Self::open_adapter(same.unwrap_or_else(|| self.adapter.clone()), self.sums)
    }

    fn open_adapter(adapter: wgpu::Adapter, sums: Sums) -> Result<Self> {
        let info = adapter.get_info();
        // A film or a window may be larger than the textures that every device has.
        let max_texture_dimension_2d = adapter.limits().max_texture_dimension_2d;
        let limits = wgpu::Limits { max_texture_dimension_2d, ..Default::default() };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("relume player"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
            Error::Failed(format!(
                "cannot open GPU adapter {}: {e}; choose another with --adapter",
                info.name
            ))
        })?;
        let failure = Arc::new(Mutex::new(None));
        let first = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            // What follows the first error is mostly its consequence.
            first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        Ok(Self { device, queue, info, adapter, sums, failure })
    }

    /// Whether `method` does its sums on the CPU, so that the device only draws, as its name tells from then on.
    ///
    /// # Errors
    /// [`Error::Usage`] if that is asked for and the method cannot.
    pub fn leaves_sums_of(&mut self, method: &Method) -> Result<bool> {
        if self.sums == Sums::OnCpu && !method.on_cpu {
            let able = adapter::able_on_cpu();
            let name = method.card.name;
            return Err(Error::Usage(format!(
                "--adapter cpu is for the method {able}, not {name}; choose another adapter, --list-adapters tells which"
            )));
        }
        // Cores do the work of a software adapter, too, but in shaders that were made for others.
        let leaves = match self.sums {
            Sums::OnDevice => false,
            Sums::OnCpu => true,
            Sums::WhereFaster => self.is_software() && method.on_cpu,
        };
        if leaves {
            self.info.name = format!("{} ({} draws)", adapter::CPU, self.adapter.get_info().name);
        }
        Ok(leaves)
    }

    /// Fails if anything went wrong on the device since it was opened.
    pub fn check(&self) -> Result<()> {
        match &*self.failure.lock().unwrap_or_else(PoisonError::into_inner) {
            None => Ok(()),
            Some(error) => Err(Error::Failed(format!("GPU {}: {error}", self.info.name))),
        }
    }

    /// A texture of 8-bit sRGB values to draw on and to read back.
    pub fn picture(&self, [width, height]: [u32; 2]) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Whether the "GPU" is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Lets the device report what has been done, without waiting for more.
    pub fn poll(&self) -> Result<()> {
        self.device
            .poll(wgpu::PollType::Poll)
            .map_err(|e| Error::Failed(format!("GPU {}: {e}", self.info.name)))?;
        self.check()
    }

    /// Waits until everything submitted is done.
    pub fn wait(&self) -> Result<()> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| Error::Failed(format!("GPU {}: {e}", self.info.name)))?;
        self.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_error_is_reported() {
        if !crate::support::gpu_there(|| list().map(|_| ()).map_err(|e| e.to_string())) {
            return;
        }
        let gpu = Gpu::open(None).unwrap();
        gpu.check().unwrap();
        let size = 1 << 60;
        let usage = wgpu::BufferUsages::STORAGE;
        let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        });
        assert_eq!(gpu.check().unwrap_err().exit_code(), 1);
    }
}
