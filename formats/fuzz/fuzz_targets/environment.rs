//! Files of kind `environment`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::Environment;
use relume_formats_fuzz::playing::play_environment;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<Environment>(data, play_environment));
