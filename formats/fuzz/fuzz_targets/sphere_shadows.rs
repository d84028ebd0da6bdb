//! Files of kind `sphere-shadows`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::SphereShadows;
use relume_formats_fuzz::playing::play_shadows;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<SphereShadows>(data, play_shadows));
