//! Environment maps in Radiance's format.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> = LazyLock::new(|| Stage::of_environment("hdr", "sky.hdr"));

fuzz_target!(|data: &[u8]| {
    STAGE.write("sky.hdr", data);
    STAGE.load();
});
