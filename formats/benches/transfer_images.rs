//! How fast images of transfer-images are read on one thread: a film of 512 × 512, two materials that vary and six
//! bases, of smooth light, edges and noise rounded as bakes round it. Prints megabytes of halves a second, the
//! best of several rounds, beside those of copying them, and bytes a half in the file.

#![allow(missing_docs, reason = "a program")]

use half::f16;
use relume_formats::Place;
use relume_formats::container::{Reader, Stored as _};
use relume_formats::kinds::TransferImages;
use relume_formats::kinds::transfer_images::{Head, Image, Layout, Meta};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const SIDE: u32 = 512;
const ROUNDS: usize = 10;

/// Light on a wall with an edge, a ripple, and noise of one per cent, in steps of a 2048th of its middle.
fn value(pixel: u32, slot: usize, channel: usize) -> f16 {
    let (x, y) = ((pixel % SIDE) as f32, (pixel / SIDE) as f32);
    let smooth = 1.0 + 0.5 * (0.01 * x + slot as f32).sin() * (0.013 * y).cos();
    let shadow = if (x - 200.0).hypot(y - 300.0) < 120.0 { 0.3 } else { 1.0 };
    let noise = (pixel.wrapping_mul(0x9e37_79b9) ^ slot as u32).wrapping_mul(0x85eb_ca6b) >> 16;
    let light = smooth * shadow * (1.0 + 0.02 * (noise as f32 / 65_536.0 - 0.5)) * [1.0, 0.8, 0.5][channel];
    f16::from_f32((light * 2048.0).round() * 8.0)
}

fn images() -> TransferImages {
    let (materials, bases) = (2, 6);
    let layout = Layout::new(materials, bases, true, None);
    let fragments = SIDE * SIDE;
    let meta = Meta {
        size: [SIDE, SIDE],
        materials: vec!["a".to_owned(), "b".to_owned()],
        bases: bases as u32,
        chromaticity: Some([1.0, 0.8, 0.5]),
        samples: 256,
        seed: 0,
        editable_fragments: fragments,
    };
    let image = |(slot, meaning): (usize, &relume_formats::kinds::transfer_images::Slot)| {
        let channel = |channel| (0..fragments).map(move |pixel| value(pixel, slot, channel));
        Image { slot, values: (0..meaning.channels()).flat_map(channel).collect() }
    };
    let head = Head {
        meta,
        later: None,
        pixel: (0..fragments).collect(),
        class: (0..fragments).map(|pixel| (pixel % SIDE / 300) as u16).collect(),
        coverage: vec![f16::ONE; fragments as usize],
        scales: vec![1.0; layout.slots.len()],
    };
    TransferImages { head: Arc::new(head), images: layout.slots.iter().enumerate().map(image).collect() }
}

/// Seconds of the fastest round.
fn best<T>(mut round: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        black_box(round());
        start.elapsed().as_secs_f64()
    };
    (0..ROUNDS).map(time).fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), relume_formats::Error> {
    let (images, place) = (images(), Place::file("images"));
    let bytes = images.to_bytes(place.clone())?;
    let halves: Vec<&[f16]> = images.images.iter().map(|image| &image.values[..]).collect();
    let megabytes = 2.0 * halves.iter().map(|values| values.len()).sum::<usize>() as f64 / 1e6;
    let read = || Reader::new(&bytes[..], bytes.len() as u64, place.clone())?.read(TransferImages::decode);
    assert!(read()? == images, "what is read is not what was written");
    let reading = best(read);
    let copying = best(|| halves.iter().map(|values| values.to_vec()).collect::<Vec<_>>());
    println!(
        "{megabytes:.0} MB of halves, {:.2} bytes each in the file",
        2e-6 * bytes.len() as f64 / megabytes
    );
    println!("read and checked: {:.0} MB/s; copied: {:.0} MB/s", megabytes / reading, megabytes / copying);
    Ok(())
}
