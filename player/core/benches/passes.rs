//! The passes that read whole bakes every frame, beside a copy of as many bytes on the same device: how near
//! they come to the speed of its memory. Bundles are synthetic, of the sizes that bakes have. Prints, for each
//! pass, the bytes that it reads, the least of the device's own times, and what share of the copy's rate
//! that is.
#![allow(clippy::unwrap_used, reason = "a program that only developers run")]
#![allow(clippy::disallowed_methods, reason = "it has files and waits, which the library has not")]
#![allow(clippy::disallowed_types, reason = "and a clock")]

#[path = "../tests/support/mod.rs"]
mod support;

use half::f16;
use relume_formats::Place;
use relume_formats::kinds::manifest::{FILE_NAME, Manifest};
use relume_formats::kinds::sparse_transfer::{Block, BlockShape, Meta, Steps};
use relume_formats::kinds::transfer_images::{Head, Image, LARGEST_HALF, TransferImages};
use relume_formats::kinds::{SparseTransfer, transfer_images};
use relume_playback::{Incoming, Options, Player, Playlist, Progress};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use support::sparse;
use wgpu::BufferUsages;

/// Frames of a measurement, each beside a copy.
const FRAMES: usize = 30;
/// Texels along a side of the light of `sparse-transfer`.
const LIGHT_SIDE: u32 = 64;
/// Terms of each row, as a draft of knot-outdoors has.
const TERMS: u32 = 480;
/// Vertices of the grid, two ways: about as many as knot-outdoors has.
const GRID: [u32; 2] = [128, 120];

/// Copies as wide words as there are, a lane each.
const COPY: &str = "
@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> target_words: array<vec4<u32>>;

@compute @workgroup_size(256)
fn copy(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = (group.y * groups.x + group.x) * 256u + lane;
    if at < arrayLength(&source) {
        target_words[at] = source[at];
    }
}
";

/// A device, and whether its timestamps can be believed: those of software adapters tell when commands were
/// taken, not when they were done, so that there a clock around the whole submission has to do.
struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
    is_software: bool,
}

impl Device {
    /// Submits, waits, and tells how many milliseconds that took.
    fn finish(&self, encoder: wgpu::CommandEncoder) -> f64 {
        let commands = encoder.finish();
        let start = Instant::now();
        self.queue.submit([commands]);
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        1e3 * start.elapsed().as_secs_f64()
    }
}

/// A copy from buffer to buffer, timed by the device.
struct Copy {
    pipeline: wgpu::ComputePipeline,
    /// By pair of buffers.
    bindings: Vec<wgpu::BindGroup>,
    bytes: u64,
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    host: wgpu::Buffer,
}

/// The most that one binding holds.
const BINDING_BYTES: u64 = 128 << 20;

impl Copy {
    /// A copy of `bytes` bytes, at most as many in one go as a binding holds.
    fn new(Device { device, .. }: &Device, bytes: u64) -> Self {
        let source = wgpu::ShaderSource::Wgsl(COPY.into());
        let module =
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("copy"), source });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("copy"),
            layout: None,
            module: &module,
            entry_point: Some("copy"),
            compilation_options: Default::default(),
            cache: None,
        });
        let buffer = |size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let parts = bytes.div_ceil(BINDING_BYTES);
        let part = bytes.div_ceil(parts).next_multiple_of(16);
        let bind = |_| {
            let pair = [(); 2].map(|()| buffer(part, BufferUsages::STORAGE));
            let entries = [0, 1].map(|binding| wgpu::BindGroupEntry {
                binding,
                resource: pair[binding as usize].as_entire_binding(),
            });
            let layout = &pipeline.get_bind_group_layout(0);
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        Self {
            bindings: (0..parts).map(bind).collect(),
            bytes: part * parts,
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(16, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            host: buffer(16, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            pipeline,
        }
    }

    /// Copies, and tells how many milliseconds it took.
    fn ms(&self, device: &Device) -> f64 {
        let mut encoder = device.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        });
        pass.set_pipeline(&self.pipeline);
        let groups = (self.bytes / self.bindings.len() as u64).div_ceil(16 * 256) as u32;
        let rows = groups.div_ceil(65_535);
        for bindings in &self.bindings {
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(groups.div_ceil(rows), rows, 1);
        }
        drop(pass);
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.host, 0, 16);
        encoder.map_buffer_on_submit(&self.host, wgpu::MapMode::Read, .., |_| {});
        let waited_ms = device.finish(encoder);
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&self.host.get_mapped_range(..).unwrap());
        self.host.unmap();
        if device.is_software {
            return waited_ms;
        }
        (ticks[1] - ticks[0]) as f64 * f64::from(device.queue.get_timestamp_period()) * 1e-6
    }
}

/// The player of the bundle in `folder`, all of it loaded.
fn load(device: &Device, folder: &Path) -> Player {
    let manifest = Manifest::read(folder).unwrap();
    let place = Place::file(folder.join(FILE_NAME));
    let playlist = Playlist::of(&manifest, &place, None, None).unwrap();
    let mut player = Player::new(&device.device, &device.queue, &playlist, Options::default()).unwrap();
    let mut source = Incoming::new(&playlist);
    for item in &playlist.items {
        source.push(&std::fs::read(folder.join(&item.file)).unwrap());
        while matches!(player.advance(&mut source).unwrap(), Progress::Arrived) {}
    }
    source.end();
    while !matches!(player.advance(&mut source).unwrap(), Progress::Loaded { .. }) {}
    player
}

/// The least: what the machine does besides only ever adds.
fn least(values: Vec<f64>) -> f64 {
    values.into_iter().fold(f64::MAX, f64::min)
}

/// Draws a frame with the light turned by `frame` degrees, and tells how many milliseconds the passes called
/// `pass` took; on software adapters, all of it.
fn frame_ms(device: &Device, player: &mut Player, frame: usize, pass: &str) -> f64 {
    let mut look = player.controls().unwrap().base().clone();
    if let Some(environment) = &mut look.environment {
        environment.rotation_deg = frame as f32;
    }
    let mut encoder = device.device.create_command_encoder(&Default::default());
    player.draw(&mut encoder, &look).unwrap();
    let waited_ms = device.finish(encoder);
    let times = player.times();
    if device.is_software {
        return waited_ms;
    }
    times.iter().flat_map(|times| &times.passes).filter(|(label, _)| *label == pass).map(|(_, ms)| ms).sum()
}

/// Prints a line: the passes called `pass` of the bundle in `folder` beside a copy of as many bytes. The
/// bundle `without` is the same with less to read, so that its frames tell what else a frame takes.
fn measure(device: &Device, what: &str, pass: &str, folder: &Path, without: Option<&Path>) {
    let mut player = load(device, folder);
    let mut without = without.filter(|_| device.is_software).map(|folder| load(device, folder));
    let bytes = [Some(&player), without.as_ref()].map(|p| p.map_or(0, |p| p.pieces().bytes_per_frame));
    let bytes = bytes[0] - bytes[1];
    let copy = Copy::new(device, bytes);
    let mut times = [(); 3].map(|()| Vec::new());
    for frame in 0..FRAMES {
        times[0].push(frame_ms(device, &mut player, frame, pass));
        times[1].push(without.as_mut().map_or(0.0, |player| frame_ms(device, player, frame, pass)));
        times[2].push(copy.ms(device));
    }
    let [with, without, copy_ms] = times.map(least);
    let (ms, rate) = (with - without, |bytes: u64, ms: f64| bytes as f64 / ms * 1e-6);
    // A copy reads and writes.
    let [ours, copied] = [rate(bytes, ms), rate(2 * copy.bytes, copy_ms)];
    println!(
        "{what:40}{:8.1} MB {ms:9.3} ms {ours:8.1} GB/s; copy {copied:8.1} GB/s; {:5.1} %",
        bytes as f64 * 1e-6,
        100.0 * ours / copied
    );
}

/// A number that looks random.
fn hash(a: u32, b: u32) -> u32 {
    let mixed = (a ^ b.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x85eb_ca6b);
    (mixed ^ (mixed >> 15)).wrapping_mul(0xc2b2_ae35) >> 8
}

/// Rows in the blocks of a bake. A thousand neighbours share the terms that matter, each in an order of its
/// own.
fn rows(rgb: bool, terms: u32) -> SparseTransfer {
    let vertices = GRID[0] * GRID[1];
    let first = [4, 4, 8, 16].map(|terms| BlockShape { terms, wide: true });
    let others = (32..terms).step_by(16).map(|_| BlockShape { terms: 16, wide: false });
    let meta = Meta {
        vertices,
        face_size: LIGHT_SIDE,
        bounces: u32::from(rgb),
        rgb,
        unit: 1e-5,
        blocks: first.into_iter().chain(others).collect(),
        rays_per_texel: 1,
    };
    let (channels, coefficients) = (meta.channels() as u32, meta.coefficients() as u32);
    let mut term = 0;
    let mut block = |shape: &BlockShape| {
        let columns = || (term..term + shape.terms).flat_map(|k| (0..vertices).map(move |v| (k, v)));
        let values = || columns().flat_map(|(k, v)| (0..channels).map(move |c| hash(3 * k + c, v)));
        let index = |(k, v)| (hash(k + hash(k, v) % 32, v / 1024) % coefficients) as u16;
        let block = Block {
            indices: columns().map(index).collect(),
            scales: vec![f16::ONE; vertices as usize],
            steps: if shape.wide {
                Steps::Wide(values().map(|value| value as i16).collect())
            } else {
                Steps::Bytes(values().map(|value| value as i8).collect())
            },
        };
        term += shape.terms;
        block
    };
    let blocks = meta.blocks.iter().map(&mut block).collect();
    SparseTransfer { meta, blocks }
}

/// Images of `side` × `side` pixels: squares of the materials a, b and a fixed one, with pixels of two where
/// they meet.
fn images(side: u32) -> TransferImages {
    let class = |x: u32, y: u32| ((x / 32 + y / 32) % 3) as u16;
    let of_pixel = |pixel: u32| {
        let (x, y) = (pixel % side, pixel / side);
        let mut seen = vec![class(x, y)];
        if x.is_multiple_of(32) && x > 0 {
            seen.push(class(x - 1, y));
        }
        seen.sort_unstable();
        let coverage = f16::from_f32(1.0 / seen.len() as f32);
        seen.into_iter().map(move |class| (pixel, class, coverage))
    };
    let mut fragments: Vec<_> = (0..side * side).flat_map(of_pixel).collect();
    fragments.sort_by_key(|(_, class, _)| *class == 2);
    let meta = transfer_images::Meta {
        size: [side; 2],
        editable_fragments: fragments.iter().filter(|(_, class, _)| *class < 2).count() as u32,
        ..support::images(true).head.meta.clone()
    };
    let mut head = Head {
        meta,
        later: None,
        pixel: fragments.iter().map(|f| f.0).collect(),
        class: fragments.iter().map(|f| f.1).collect(),
        coverage: fragments.iter().map(|f| f.2).collect(),
        scales: Vec::new(),
    };
    let layout = head.layout();
    head.scales = vec![1.0 / LARGEST_HALF; layout.slots.len()];
    let image = |slot: usize| {
        let count = layout.slots[slot].channels() * head.fragments_of(&layout.slots[slot]);
        let value = |i: usize| f16::from_f32(LARGEST_HALF * ((i / 7 + slot) % 32 + 1) as f32 / 32.0);
        Image { slot, values: (0..count).map(value).collect() }
    };
    let images = (0..layout.slots.len()).map(image).collect();
    TransferImages { head: Arc::new(head), images }
}

fn main() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let descriptor =
        wgpu::DeviceDescriptor { required_features: wgpu::Features::TIMESTAMP_QUERY, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let info = adapter.get_info();
    println!("{}", info.name);
    let device = Device { device, queue, is_software: info.device_type == wgpu::DeviceType::Cpu };
    for (what, rgb) in [("rows, grey", false), ("rows, RGB", true)] {
        let [bundle, without] = [TERMS, 32]
            .map(|terms| sparse::Bundle::of(sparse::scene(GRID), sparse::maps(), None, rows(rgb, terms)));
        let what = format!("{what}: {} vertices x {TERMS} terms", GRID[0] * GRID[1]);
        measure(&device, &what, "accumulate", bundle.folder(), Some(without.folder()));
    }
    for side in [256, 1024] {
        let mut scene = support::scene();
        scene.meta.size = [side; 2];
        let bundle = support::Bundle::of(&scene, images(side), support::basis());
        measure(&device, &format!("images, {side}x{side}"), "sum slots", bundle.folder(), None);
    }
}
