//! OFF.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> = LazyLock::new(|| Stage::of_mesh("off", "mesh.off"));

fuzz_target!(|data: &[u8]| {
    STAGE.write("mesh.off", data);
    STAGE.load();
});
