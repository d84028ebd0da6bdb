//! Environment maps in OpenEXR.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> = LazyLock::new(|| Stage::of_environment("exr", "sky.exr"));

fuzz_target!(|data: &[u8]| {
    STAGE.write("sky.exr", data);
    STAGE.load();
});
