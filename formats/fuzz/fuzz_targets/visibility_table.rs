//! Files of kind `visibility-table`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::VisibilityTable;
use relume_formats_fuzz::playing::play_visibility;
use relume_formats_fuzz::read_and_play;

fuzz_target!(|data: &[u8]| read_and_play::<VisibilityTable>(data, play_visibility));
