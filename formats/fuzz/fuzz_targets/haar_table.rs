//! Files of kind `haar-table`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::HaarTable;
use relume_formats_fuzz::playing::play_table;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<HaarTable>(data, play_table));
