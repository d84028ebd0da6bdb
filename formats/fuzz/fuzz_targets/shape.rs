//! Files of kind `shape`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::shape::DeformingMesh;
use relume_formats_fuzz::playing::play_shape;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<DeformingMesh>(data, play_shape));
