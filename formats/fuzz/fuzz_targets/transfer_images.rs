//! Files of kind `transfer-images`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::TransferImages;
use relume_formats_fuzz::playing::play_images;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<TransferImages>(data, play_images));
