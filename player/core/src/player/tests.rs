//! Bundles played from their bytes.

mod resize;

use super::*;
use crate::Incoming;
use crate::support::{self, Bundle, shadows, sparse};
use crate::testing::{bytes, gpu, playlist, read_bytes, target};
use std::path::Path;

/// The bundle in `folder`, played from its bytes.
fn play(gpu: &Gpu, folder: &Path, options: Options) -> Result<Player> {
    let playlist = playlist(folder, None);
    let (mut player, mut source) =
        (Player::new(&gpu.device, &gpu.queue, &playlist, options)?, Incoming::new(&playlist));
    source.push(&bytes(&playlist));
    loop {
        match player.advance(&mut source)? {
            Progress::Loaded { complete } => {
                assert!(complete && player.is_ready());
                return Ok(player);
            }
            Progress::Arrived => {}
            Progress::Waiting => panic!("all bytes are there"),
        }
    }
}

/// What a frame of `look` shows.
fn shown(gpu: &Gpu, player: &mut Player, look: &Look) -> Vec<[u8; 4]> {
    let texture = target(gpu, player.film().unwrap().size, wgpu::TextureFormat::Rgba8Unorm);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    player.draw(&mut encoder, look).unwrap();
    player.show(&mut encoder, &texture.create_view(&Default::default()), look.display()).unwrap();
    gpu.queue.submit([encoder.finish()]);
    read_bytes(gpu, &texture)
}

#[test]
fn every_method_draws_into_a_texture_of_the_callers() {
    let Some(gpu) = gpu() else { return };
    let (images, rows, shadows) =
        (Bundle::write(true), sparse::Bundle::write(16, false), shadows::Bundle::write(true));
    for folder in [images.folder(), rows.folder(), shadows.folder()] {
        let mut player = play(&gpu, folder, Options::default()).unwrap();
        let look = player.controls().unwrap().base().clone();
        let darker = Display { exposure_ev: look.camera.exposure_ev - 3.0, tonemap: look.tonemap };
        let first = shown(&gpu, &mut player, &look);
        assert!(first.iter().any(|pixel| pixel[..3] != [0; 3]) && first.iter().all(|pixel| pixel[3] == 255));
        assert!(shown(&gpu, &mut player, &look) == first, "the same again");
        assert!(shown(&gpu, &mut player, &look.displayed(darker)) != first);
    }
}

#[test]
fn a_look_follows_from_a_state() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write(true);
    let mut player = play(&gpu, bundle.folder(), Options::default()).unwrap();
    let place = Place::file("state");
    let state = |text: &str| PlacedState {
        state: relume_formats::state::parse_toml(text, &place).unwrap(),
        place: place.clone(),
    };
    let controls = player.controls().unwrap();
    assert!(controls.look_of(&state("materials.fixed.kd = [0.1, 0.1, 0.1]")).is_err());
    let (base, look) =
        (controls.base().clone(), controls.look_of(&state("materials.a.kd = [0.0, 0.6, 0.0]")).unwrap());
    let (before, after) = (shown(&gpu, &mut player, &base), shown(&gpu, &mut player, &look));
    let map = player.materials().unwrap();
    assert!(before != after && map.size() == support::SIZE);
    // Light goes from one thing to another, but where nothing is seen there is none.
    for (pixel, seen) in map.pixels().enumerate().filter(|(_, seen)| *seen == crate::Seen::Nothing) {
        assert_eq!((before[pixel], after[pixel]), ([0, 0, 0, 255], [0, 0, 0, 255]), "{seen:?}");
    }
    assert!(map.pixels().any(|seen| seen == crate::Seen::Nothing));
}

#[test]
fn a_target_of_another_size_is_refused() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write(true);
    let mut player = play(&gpu, bundle.folder(), Options::default()).unwrap();
    let look = player.controls().unwrap().base().clone();
    let texture = target(&gpu, [8, 8], wgpu::TextureFormat::Rgba8Unorm);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let error =
        player.show(&mut encoder, &texture.create_view(&Default::default()), look.display()).unwrap_err();
    assert_eq!(error.to_string(), "the target has 8x8 pixels, the film 37x23");
}

#[test]
fn what_is_asked_for_in_vain_is_refused() {
    let Some(gpu) = gpu() else { return };
    let (images, rows) = (Bundle::write(true), sparse::Bundle::write(16, false));
    let refusal = |folder, options| play(&gpu, folder, options).err().unwrap().to_string();
    assert!(
        refusal(images.folder(), Options { size: Some([64, 32]), ..Default::default() })
            .contains("baked at 37x23")
    );
    assert!(
        refusal(rows.folder(), Options { size: Some([1 << 16; 2]), ..Default::default() })
            .contains("is too large")
    );
    assert!(
        refusal(rows.folder(), Options { radiance_on_cpu: true, ..Default::default() })
            .contains("sparse-transfer")
    );
    let playlist = playlist(rows.folder(), None);
    let mut player = Player::new(&gpu.device, &gpu.queue, &playlist, Options::default()).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    assert!(matches!(
        player.draw(&mut encoder, &Look::default_of(&rows.scene.meta)),
        Err(Error::NothingThere)
    ));
}

#[test]
fn a_map_that_comes_later_shines_as_one_of_the_bundles() {
    let Some(gpu) = gpu() else { return };
    let (images, rows, shadows) =
        (Bundle::write(true), sparse::Bundle::write(16, true), shadows::Bundle::write(true));
    let called = |name: &str, map: &Environment| Environment { name: name.to_owned(), ..map.clone() };
    for (folder, maps) in [(rows.folder(), &rows.maps), (shadows.folder(), &shadows.maps)] {
        let mut player = play(&gpu, folder, Options::default()).unwrap();
        let mut look = player.controls().unwrap().base().clone();
        let mut show = |player: &mut Player, map: &str| {
            look.environment.as_mut().unwrap().map = map.to_owned();
            let picture = shown(&gpu, player, &look);
            (picture, player.shows_map_from_outside())
        };
        let own: Vec<_> = maps[..2].iter().map(|map| show(&mut player, &map.name)).collect();
        assert!(own[0].0 != own[1].0 && own.iter().all(|(_, outside)| !outside));
        player.add_environment(&called("/mine.exr", &maps[1])).unwrap();
        assert!(player.controls().unwrap().scope().maps.contains(&"/mine.exr".to_owned()));
        assert!(show(&mut player, "/mine.exr") == (own[1].0.clone(), true));
        // Exchanged while it shines.
        player.add_environment(&called("/mine.exr", &maps[0])).unwrap();
        assert!(show(&mut player, "/mine.exr") == (own[0].0.clone(), true));
        player.add_environment(&called("/other.exr", &maps[1])).unwrap();
        assert!(
            show(&mut player, "/other.exr").0 == own[1].0 && show(&mut player, "/mine.exr").0 == own[0].0
        );
        assert!(show(&mut player, &maps[1].name) == own[1]);
        let error = player.add_environment(&maps[0]).unwrap_err().to_string();
        assert!(error.contains("itself; rename the file"), "{error}");
    }
    let mut fixed = play(&gpu, images.folder(), Options::default()).unwrap();
    let error = fixed.add_environment(&called("/mine.exr", &rows.maps[0])).unwrap_err().to_string();
    assert!(error.starts_with("this bundle does not vary the light"), "{error}");
}
