//! Files of kind `region-images`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::RegionImages;
use relume_formats_fuzz::playing::play_regions;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<RegionImages>(data, play_regions));
