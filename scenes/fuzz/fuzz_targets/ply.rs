//! PLY, as text and binary.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> = LazyLock::new(|| Stage::of_mesh("ply", "mesh.ply"));

fuzz_target!(|data: &[u8]| {
    STAGE.write("mesh.ply", data);
    STAGE.load();
});
