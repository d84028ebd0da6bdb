//! What the tests of this crate do with a GPU.

use crate::gpu::Gpu;
use crate::stream::{Arrival, Event, Incoming, Playlist, Source as _};
use crate::support::gpu_there;
use relume_formats::Place;
use relume_formats::container::Kind;
use relume_formats::kinds::manifest::{FILE_NAME, Manifest};
use relume_formats::state::Rgb;
use std::path::Path;
use wgpu::BufferUsages;

/// The most promising device, with timestamps if it has them.
pub(crate) fn gpu() -> Option<Gpu> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    if !gpu_there(|| adapter.as_ref().map(|_| ()).map_err(|e| e.to_string())) {
        return None;
    }
    let adapter = adapter.unwrap();
    let required_features = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
    let descriptor = wgpu::DeviceDescriptor { required_features, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some(Gpu::new(&device, &queue, false).unwrap())
}

/// Waits until everything submitted is done.
pub(crate) fn wait(gpu: &Gpu) {
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
}

fn read(gpu: &Gpu, host: &wgpu::Buffer) -> Vec<u8> {
    host.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    wait(gpu);
    host.get_mapped_range(..).unwrap().to_vec()
}

/// Waits for a buffer that can be copied from; what it holds.
pub(crate) fn read_values<T: bytemuck::AnyBitPattern>(gpu: &Gpu, source: &wgpu::Buffer) -> Vec<T> {
    let host = gpu.buffer("read-back", source.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &host, 0, source.size());
    gpu.queue.submit([encoder.finish()]);
    read(gpu, &host).chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

/// Waits for buffers of four floats for each colour; the first three floats of each, buffer by buffer.
pub(crate) fn read_radiance<'a>(gpu: &Gpu, sources: impl IntoIterator<Item = &'a wgpu::Buffer>) -> Vec<Rgb> {
    let of = |source| read_values(gpu, source).into_iter().map(|[r, g, b, _]: [f32; 4]| [r, g, b]);
    sources.into_iter().flat_map(of).collect()
}

/// A texture to draw on and to read.
pub(crate) fn target(gpu: &Gpu, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// The four bytes of every texel, row by row.
pub(crate) fn read_bytes(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<[u8; 4]> {
    read_texels(gpu, texture)
}

/// Every texel, row by row.
pub(crate) fn read_texels<T: bytemuck::AnyBitPattern>(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<T> {
    let (width, height) = (texture.width(), texture.height());
    let row_bytes = (width * size_of::<T>() as u32).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let host =
        gpu.buffer("copy", u64::from(row_bytes * height), BufferUsages::COPY_DST | BufferUsages::MAP_READ);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &host, layout },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let row = |row: &[u8]| {
        row.chunks_exact(size_of::<T>())
            .take(width as usize)
            .map(bytemuck::pod_read_unaligned)
            .collect::<Vec<T>>()
    };
    read(gpu, &host).chunks_exact(row_bytes as usize).flat_map(row).collect()
}

/// The files to play of the bundle in `folder`.
pub(crate) fn playlist(folder: &Path, first: Option<&str>) -> Playlist {
    Playlist::of(&Manifest::read(folder).unwrap(), &Place::file(folder.join(FILE_NAME)), None, first).unwrap()
}

/// All bytes of `playlist`, one file after another.
pub(crate) fn bytes(playlist: &Playlist) -> Vec<u8> {
    playlist.items.iter().flat_map(|item| std::fs::read(&item.place.file).unwrap()).collect()
}

/// Every section of the bundle in `folder`, without animations, behind the scene's.
pub(crate) fn arrivals(folder: &Path) -> Vec<Arrival> {
    let playlist = playlist(folder, None);
    let mut source = Incoming::new(&playlist);
    source.push(&bytes(&playlist));
    let mut arrivals = Vec::new();
    loop {
        match source.poll().unwrap() {
            Event::Section(arrival) if matches!(arrival.kind, Kind::Scene | Kind::Animation) => {}
            Event::Section(arrival) => arrivals.push(arrival),
            Event::Waiting => panic!("all bytes are there"),
            Event::End { complete } => {
                assert!(complete);
                return arrivals;
            }
        }
    }
}
