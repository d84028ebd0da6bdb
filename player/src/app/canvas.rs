//! The window's surface, and the renderer that draws on it.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use egui::TextureId;
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use std::sync::Arc;
use wgpu::{CurrentSurfaceTexture, Surface, SurfaceConfiguration, SurfaceTexture, TextureFormat};
use winit::dpi::PhysicalSize;
use winit::window::Window;

/// What egui has to show.
pub struct Drawing {
    /// What to draw.
    pub primitives: Vec<egui::ClippedPrimitive>,
    /// Textures that have changed.
    pub textures: egui::TexturesDelta,
    /// Pixels of the display for a point.
    pub pixels_per_point: f32,
}

/// What became of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Painted {
    /// It is shown, or cannot be seen anyway.
    Yes,
    /// It was not shown; draw again.
    TryAgain,
    /// There is no window any more.
    WindowGone,
}

/// A surface and its renderer.
pub struct Canvas {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: Surface<'static>,
    config: SurfaceConfiguration,
    renderer: Renderer,
    /// The bundle's picture, and what egui calls it.
    picture: Option<(wgpu::Texture, TextureId)>,
    /// How often in a row the surface was lost.
    losses: u32,
}

impl Canvas {
    /// Draws on `surface`, which is that of `window`.
    pub fn new(
        gpu: &Gpu,
        window: Arc<Window>,
        instance: wgpu::Instance,
        surface: Surface<'static>,
    ) -> Result<Self> {
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| {
                Error::Failed(format!(
                    "GPU {} cannot draw on this display; choose another with --adapter",
                    gpu.info.name
                ))
            })?;
        // Values that are sRGB-encoded already must pass unchanged.
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let plain = [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm]
            .into_iter()
            .find(|format| formats.contains(format));
        config.format = plain.unwrap_or(config.format);
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&gpu.device, &config);
        // Dithering would change the picture by a step here and there.
        let options = RendererOptions { dithering: false, ..RendererOptions::default() };
        let renderer = Renderer::new(&gpu.device, config.format, options);
        Ok(Self { window, instance, surface, config, renderer, picture: None, losses: 0 })
    }

    /// Takes a new picture of `size` pixels, sRGB-encoded RGBA, row by row; returns what egui is to call it.
    pub fn take_picture(&mut self, gpu: &Gpu, size: [u32; 2], pixels: &[u8]) -> TextureId {
        let texture = match self.picture.take() {
            Some((texture, id)) if [texture.width(), texture.height()] == size => (texture, id),
            other => self.new_picture(gpu, size, other.map(|(_, id)| id)),
        };
        let [width, height] = size;
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None };
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        gpu.queue.write_texture(texture.0.as_image_copy(), pixels, layout, extent);
        self.picture.insert(texture).1
    }

    fn new_picture(
        &mut self,
        gpu: &Gpu,
        [width, height]: [u32; 2],
        old: Option<TextureId>,
    ) -> (wgpu::Texture, TextureId) {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        old.iter().for_each(|id| self.renderer.free_texture(id));
        let id = self.renderer.register_native_texture(&gpu.device, &view, wgpu::FilterMode::Linear);
        (texture, id)
    }

    /// Shows `drawing` in the window, which is of this `size`. A window without an area shows nothing.
    pub fn paint(&mut self, gpu: &Gpu, size: PhysicalSize<u32>, drawing: &Drawing) -> Painted {
        // Textures change once only, even if this frame is never seen.
        for (id, deltas) in &drawing.textures.set {
            deltas.iter().for_each(|delta| self.renderer.update_texture(&gpu.device, &gpu.queue, *id, delta));
        }
        let painted = if self.follow(gpu, size) { self.paint_frame(gpu, drawing) } else { Painted::Yes };
        drawing.textures.free.iter().for_each(|id| self.renderer.free_texture(id));
        painted
    }

    fn paint_frame(&mut self, gpu: &Gpu, drawing: &Drawing) -> Painted {
        match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(frame) => self.present(gpu, frame, drawing),
            CurrentSurfaceTexture::Suboptimal(frame) => {
                self.present(gpu, frame, drawing);
                self.surface.configure(&gpu.device, &self.config);
            }
            CurrentSurfaceTexture::Outdated => {
                self.surface.configure(&gpu.device, &self.config);
                return Painted::TryAgain;
            }
            CurrentSurfaceTexture::Lost => return self.recreate(gpu),
            // The display is busy; nothing else may come that would draw the same again.
            CurrentSurfaceTexture::Timeout => return Painted::TryAgain,
            // Hidden: there will be a reason to draw again.
            CurrentSurfaceTexture::Occluded | CurrentSurfaceTexture::Validation => return Painted::Yes,
        }
        self.losses = 0;
        Painted::Yes
    }

    /// Adapts the surface to the size of the window. Returns whether that has any area.
    fn follow(&mut self, gpu: &Gpu, size: PhysicalSize<u32>) -> bool {
        let most = gpu.device.limits().max_texture_dimension_2d;
        if size.width == 0 || size.height == 0 {
            return false;
        }
        let size = (size.width.min(most), size.height.min(most));
        if size != (self.config.width, self.config.height) {
            (self.config.width, self.config.height) = size;
            self.surface.configure(&gpu.device, &self.config);
        }
        true
    }

    /// A window that was closed from outside loses its surface too. The news of that comes soon, so the first
    /// loss only waits for it; a new surface that is lost at once says the same.
    fn recreate(&mut self, gpu: &Gpu) -> Painted {
        self.losses += 1;
        match self.losses {
            1 => return Painted::TryAgain,
            2 => {}
            _ => return Painted::WindowGone,
        }
        match self.instance.create_surface(self.window.clone()) {
            Ok(surface) if gpu.adapter.is_surface_supported(&surface) => {
                surface.configure(&gpu.device, &self.config);
                self.surface = surface;
                Painted::TryAgain
            }
            _ => Painted::WindowGone,
        }
    }

    fn present(&mut self, gpu: &Gpu, frame: SurfaceTexture, drawing: &Drawing) {
        let screen = ScreenDescriptor {
            size_in_pixels: [self.config.width, self.config.height],
            pixels_per_point: drawing.pixels_per_point,
        };
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("window") });
        let extra =
            self.renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &drawing.primitives, &screen);
        let view = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, &drawing.primitives, &screen);
        drop(pass);
        gpu.queue.submit(extra.into_iter().chain([encoder.finish()]));
        self.window.pre_present_notify();
        gpu.queue.present(frame);
    }
}
