//! Files of kind `textures`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::Textures;
use relume_formats_fuzz::playing::play_textures;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<Textures>(data, play_textures));
