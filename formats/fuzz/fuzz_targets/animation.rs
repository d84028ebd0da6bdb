//! Files of kind `animation`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::state::Animation;
use relume_formats_fuzz::playing::play_animation;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<Animation>(data, play_animation));
