//! Frames of other sizes than the first.

use super::*;
use crate::testing::{read_radiance, wait};
use relume_formats::state::Posed;

/// The film and what is shown of it, after a frame of `look`.
fn drawn(gpu: &Gpu, player: &mut Player, look: &Look) -> (Vec<Rgb>, Vec<[u8; 4]>) {
    let shown = shown(gpu, player, look);
    (read_radiance(gpu, &player.film().unwrap().bands), shown)
}

/// Looks that differ in light, view and shape, one after the other.
fn looks(player: &Player) -> Vec<Look> {
    let base = player.controls().unwrap().base().clone();
    let mut turned = base.clone();
    let light = turned.environment.as_mut().unwrap();
    (light.rotation_deg, light.gain) = (50.0, [1.0, 2.0, 0.5]);
    let mut moved = turned.clone();
    moved.camera.position[0] += 0.5;
    moved.shapes.insert("worm".to_owned(), Posed { clip: "Turn".to_owned(), time_s: 0.4 });
    if !player.controls().unwrap().scope().scene.varies_shape {
        moved.shapes.clear();
    }
    vec![base, turned, moved]
}

/// Asserts that `player`, brought to `size`, draws what a player does that was started at it.
fn expect_as_if_started_at(gpu: &Gpu, folder: &Path, player: &mut Player, size: [u32; 2]) {
    player.resize(size).unwrap();
    assert_eq!(player.film().unwrap().size, size);
    let mut fresh = play(gpu, folder, Options { size: Some(size), ..Default::default() }).unwrap();
    for look in looks(&fresh) {
        assert!(drawn(gpu, player, &look) == drawn(gpu, &mut fresh, &look), "{size:?}");
    }
}

#[test]
fn a_player_of_another_size_draws_as_if_started_at_it() {
    let Some(gpu) = gpu() else { return };
    let (rows, shadows) = (sparse::Bundle::write(16, true), shadows::Bundle::write(true));
    for folder in [rows.folder(), shadows.folder()] {
        let mut player = play(&gpu, folder, Options::default()).unwrap();
        let looks = looks(&player);
        let first = drawn(&gpu, &mut player, &looks[2]);
        let size = player.film().unwrap().size;
        // Grown, shrunk, odd, no more than a pixel, and back.
        for size in [[61, 47], [13, 29], [1, 1], [300, 2]] {
            expect_as_if_started_at(&gpu, folder, &mut player, size);
        }
        player.resize(size).unwrap();
        assert!(drawn(&gpu, &mut player, &looks[2]) == first);
    }
}

#[test]
fn a_film_of_several_bands_comes_and_goes() {
    let Some(gpu) = gpu() else { return };
    let bundle = sparse::Bundle::write(16, false);
    let mut player = play(&gpu, bundle.folder(), Options::default()).unwrap();
    let look = player.controls().unwrap().base().clone();
    let bytes = |player: &mut Player| {
        drawn(&gpu, player, &look);
        wait(&gpu);
        gpu.device.generate_allocator_report().map(|report| report.total_allocated_bytes)
    };
    let (small, large) = ([24, 16], [2048, 520]);
    player.resize(small).unwrap();
    let least = bytes(&mut player);
    player.resize(large).unwrap();
    assert!(player.film().unwrap().bands.len() == 2);
    let of_large = drawn(&gpu, &mut player, &look);
    let mut fresh = play(&gpu, bundle.folder(), Options { size: Some(large), ..Default::default() }).unwrap();
    assert!(of_large == drawn(&gpu, &mut fresh, &look));
    drop(fresh);
    player.resize(small).unwrap();
    // The large film takes 17 MB, and its targets 80 more. Where blocks lie tells how they are padded.
    let (least, most) = (least.unwrap_or_default(), bytes(&mut player).unwrap_or_default());
    assert!(least.abs_diff(most) < 4096, "{least} bytes have become {most}");
}

#[test]
fn a_size_is_taken_before_there_is_a_film() {
    let Some(gpu) = gpu() else { return };
    let bundle = sparse::Bundle::write(16, false);
    let playlist = playlist(bundle.folder(), None);
    let mut source = Incoming::new(&playlist);
    let mut player = Player::new(&gpu.device, &gpu.queue, &playlist, Options::default()).unwrap();
    assert!(matches!(player.resize([5, 4]), Err(Error::NothingThere)));
    source.push(&bytes(&playlist));
    while player.resize([5, 4]).is_err() {
        player.advance(&mut source).unwrap();
    }
    assert!(player.film().is_none());
    while !matches!(player.advance(&mut source).unwrap(), Progress::Loaded { .. }) {}
    assert_eq!(player.film().unwrap().size, [5, 4]);
}

#[test]
fn sizes_that_cannot_be_drawn_are_refused_and_nothing_changes() {
    let Some(gpu) = gpu() else { return };
    let (images, rows) = (Bundle::write(true), sparse::Bundle::write(16, false));
    let mut player = play(&gpu, images.folder(), Options::default()).unwrap();
    assert_eq!((player.method().resizes, player.drawable_size([64, 32])), (false, None));
    player.resize(support::SIZE).unwrap();
    assert!(player.resize([64, 32]).unwrap_err().to_string().contains("baked at 37x23"));
    let mut player = play(&gpu, rows.folder(), Options::default()).unwrap();
    let look = player.controls().unwrap().base().clone();
    let before = drawn(&gpu, &mut player, &look);
    let most = gpu.device.limits().max_texture_dimension_2d / 2;
    for (size, part) in [
        ([0, 5], "size 0x5 has no pixels"),
        ([5, 0], "size 5x0 has no pixels"),
        ([20_000, 1], "is too large"),
        ([1, u32::MAX], "is too large"),
        ([u32::MAX; 2], "is too large"),
        ([(most + 1).min(16_384), 1], if most < 16_384 { "pixels a row" } else { "" }),
    ] {
        if !part.is_empty() {
            let refused = player.resize(size).unwrap_err().to_string();
            assert!(refused.contains(part), "{size:?}: {refused}");
        }
    }
    assert!(drawn(&gpu, &mut player, &look) == before);
}

#[test]
fn what_is_too_large_is_drawn_smaller_in_its_shape() {
    let Some(gpu) = gpu() else { return };
    let bundle = sparse::Bundle::write(16, false);
    let player = play(&gpu, bundle.folder(), Options::default()).unwrap();
    let limits = gpu.device.limits();
    for size in [[1, 1], [37, 23], [1920, 1080], [1, 4096], [3840, 2160]] {
        assert_eq!(player.drawable_size(size), Some(size));
    }
    assert_eq!(player.drawable_size([0, 7]), Some([1, 7]));
    for size in [[100_000, 50_000], [u32::MAX; 2], [3, u32::MAX], [u32::MAX, 3], [16_384, 16_384]] {
        let [width, height] = player.drawable_size(size).unwrap();
        crate::lit::expect_drawable(&gpu, [width, height]).unwrap();
        assert!(width.max(height) <= limits.max_texture_dimension_2d);
        let padded = u64::from((4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT));
        assert!(padded * u64::from(height) <= limits.max_buffer_size);
        // Each side is that of the exact shape but for less than a pixel, or the least there is.
        let share = f64::from(width) / f64::from(size[0]);
        let of_height = share * f64::from(size[1]);
        let slack = 1.0 + f64::from(size[1]) / f64::from(size[0]);
        assert!((f64::from(height) - of_height).abs() <= slack || width.min(height) == 1, "{size:?}");
        assert!(width.max(height) > 4000, "{size:?} need not become {width}x{height}");
    }
}
