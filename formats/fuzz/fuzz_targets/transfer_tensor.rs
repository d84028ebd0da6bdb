//! Files of kind `transfer-tensor`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::TransferTensor;
use relume_formats_fuzz::playing::play_received;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<TransferTensor>(data, play_received));
