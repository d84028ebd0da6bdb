//! What frames of `transfer-tensor` take when nothing has changed since the last one, the view, a material, or the
//! light: a synthetic bundle of the size of a bake, at 512 x 512. Prints for each the least of all frames, and what
//! the device itself says of its passes, if that can be believed.
#![allow(clippy::unwrap_used, reason = "a program that only developers run")]
#![allow(clippy::disallowed_methods, reason = "it has files and waits, which the library has not")]
#![allow(clippy::disallowed_types, reason = "and a clock")]

#[path = "../tests/support/mod.rs"]
mod support;

use relume_formats::Place;
use relume_formats::kinds::manifest::{FILE_NAME, Manifest};
use relume_formats::kinds::transfer_tensor::Meta;
use relume_formats::state::Brdf;
use relume_playback::{Incoming, Look, Options, Player, Playlist, Progress};
use std::collections::BTreeMap;
use std::time::Instant;
use support::tensors::{self, Bundle, COLUMNS};

/// Frames of each kind.
const FRAMES: usize = 12;
/// Vertices, and those of a cluster, terms, and functions of a cluster, as bakes have them (thesis, table 5-1).
const GRID: [u32; 2] = [130, 100];
const VERTICES: u32 = GRID[0] * GRID[1];
const OF_CLUSTER: u32 = 1000;
const BLOCKS: [u32; 6] = [16; 6];
const RANKS: [u32; 2] = [32, 32];
const VECTORS: u32 = 16;

/// What is done to a look before a frame.
type Change = fn(&mut Look, f32);

const CHANGES: [(&str, Change); 4] = [
    ("nothing", |_, _| {}),
    ("view", |look, frame| look.camera.position[0] = 0.01 * frame),
    ("material", |look, frame| {
        if let Brdf::BlinnPhong(mut brdf) = look.materials["a"] {
            brdf.shininess = 20.0 + frame;
            look.materials.set("a", Brdf::BlinnPhong(brdf));
        }
    }),
    ("light", |look, frame| {
        look.environment.iter_mut().for_each(|environment| environment.rotation_deg = frame);
    }),
];

/// The player of `bundle`, all of it loaded.
fn load(device: &wgpu::Device, queue: &wgpu::Queue, bundle: &Bundle) -> Player {
    let manifest = Manifest::read(bundle.folder()).unwrap();
    let place = Place::file(bundle.folder().join(FILE_NAME));
    let playlist = Playlist::of(&manifest, &place, None, None).unwrap();
    let mut player = Player::new(device, queue, &playlist, Options::default()).unwrap();
    let mut source = Incoming::new(&playlist);
    for item in &playlist.items {
        source.push(&std::fs::read(&item.place.file).unwrap());
        while matches!(player.advance(&mut source).unwrap(), Progress::Arrived) {}
    }
    source.end();
    while !matches!(player.advance(&mut source).unwrap(), Progress::Loaded { .. }) {}
    player
}

fn main() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let required_features = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
    let descriptor = wgpu::DeviceDescriptor { required_features, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let transfer = tensors::random_transfer(Meta {
        vertices: VERTICES,
        columns: COLUMNS,
        blocks: BLOCKS.to_vec(),
        unit: 1e-4,
        rays_per_texel: 1,
        reflections: 3,
        sources: tensors::sources(),
        clusters: VERTICES / OF_CLUSTER,
        ranks: RANKS,
        vectors: VECTORS,
    });
    let parts = (tensors::spaces(), tensors::bases());
    let mut scene = tensors::sheet(GRID, 1e-3);
    scene.meta.size = [512; 2];
    let bundle = Bundle::of(scene, support::sparse::maps(), parts, transfer);
    let start = Instant::now();
    let mut player = load(&device, &queue, &bundle);
    println!("{}; loaded in {:.0} ms", adapter.get_info().name, 1e3 * start.elapsed().as_secs_f64());
    let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
    let mut look = player.controls().unwrap().base().clone();
    for (what, change) in CHANGES {
        let mut waited_ms = f64::MAX;
        // The least of each pass.
        let mut passes: BTreeMap<&str, f64> = BTreeMap::new();
        for frame in 0..FRAMES {
            change(&mut look, (frame + 1) as f32);
            let mut encoder = device.create_command_encoder(&Default::default());
            player.draw(&mut encoder, &look).unwrap();
            let start = Instant::now();
            queue.submit([encoder.finish()]);
            device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            waited_ms = waited_ms.min(1e3 * start.elapsed().as_secs_f64());
            for (pass, ms) in player.times().into_iter().flat_map(|times| times.passes) {
                let least = passes.entry(pass).or_insert(f64::MAX);
                *least = least.min(ms);
            }
        }
        println!("{what:10}{waited_ms:9.3} ms");
        if !is_software {
            passes.iter().for_each(|(pass, ms)| println!("    {pass:16}{ms:9.3} ms"));
        }
    }
}
