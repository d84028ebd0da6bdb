//! Somebody else's program that shows a bundle in a texture of its own: `embed BUNDLE PICTURE.png
//! [STATE.toml]`. The device, the files, the texture and the waiting are the program's; the library gets
//! bytes and encodes commands.
#![allow(clippy::disallowed_methods, reason = "files and waiting are the program's, not the library's")]

use relume_formats::Place;
use relume_formats::kinds::manifest::Manifest;
use relume_formats::state::parse_toml;
use relume_playback::{Incoming, Options, PlacedState, Player, Playlist, Progress};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, picture, state @ ..] = &arguments[..] else {
        return Err("embed BUNDLE PICTURE.png [STATE.toml]".into());
    };
    let mut placed = PlacedState::default();
    if let [file, ..] = state {
        placed.place = Place::file(file);
        placed.state = parse_toml(&std::fs::read_to_string(file)?, &placed.place)?;
    }

    // The program's own device.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;

    // Bytes, here of files; a web page would fetch them, and draw whenever `player.is_ready()`.
    let manifest_file = Path::new(folder).join("manifest.json");
    let place = Place::file(&manifest_file);
    let manifest = Manifest::parse(&std::fs::read_to_string(&manifest_file)?, &place)?;
    let playlist = Playlist::of(&manifest, &place, None, None)?;
    let mut player =
        Player::new(&device, &queue, &playlist, Options { state: placed, ..Options::default() })?;
    let mut source = Incoming::new(&playlist);
    for item in &playlist.items {
        source.push(&std::fs::read(Path::new(folder).join(&item.file))?);
        while matches!(player.advance(&mut source)?, Progress::Arrived) {}
    }
    source.end();
    while !matches!(player.advance(&mut source)?, Progress::Loaded { .. }) {}

    // A frame into the program's own texture.
    let [width, height] = player.film().ok_or("no film")?.size;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let look = player.controls().ok_or("no controls")?.base().clone();
    let mut encoder = device.create_command_encoder(&Default::default());
    player.draw(&mut encoder, &look)?;
    player.show(&mut encoder, &texture.create_view(&Default::default()), look.display())?;

    // Read back, for this program writes a file.
    let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let size = u64::from(row_bytes * height);
    let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
    let buffer = device.create_buffer(&descriptor);
    let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(row_bytes), ..Default::default() };
    let copy = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, texture.size());
    encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., |_| {});
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let rows = buffer.get_mapped_range(..)?;
    let pixels =
        rows.chunks_exact(row_bytes as usize).flat_map(|row| row[..4 * width as usize].to_vec()).collect();
    image::RgbaImage::from_raw(width, height, pixels).ok_or("no picture")?.save(picture)?;
    Ok(())
}
