//! Files of kind `sparse-transfer`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::SparseTransfer;
use relume_formats_fuzz::playing::play_rows;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<SparseTransfer>(data, play_rows));
