//! Files of kind `brdf-basis`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::BrdfBasis;
use relume_formats_fuzz::playing::play_basis;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<BrdfBasis>(data, play_basis));
