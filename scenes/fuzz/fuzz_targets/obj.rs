//! Wavefront OBJ.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> = LazyLock::new(|| Stage::of_mesh("obj", "mesh.obj"));

fuzz_target!(|data: &[u8]| {
    STAGE.write("mesh.obj", data);
    STAGE.load();
});
