//! Files of kind `brdf-tensor`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::BrdfTensor;
use relume_formats_fuzz::playing::play_tensor;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<BrdfTensor>(data, play_tensor));
