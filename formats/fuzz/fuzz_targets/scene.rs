//! Files of kind `scene`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::StoredScene;
use relume_formats_fuzz::playing::play_scene;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<StoredScene>(data, play_scene));
