//! Pictures: PNG and JPEG.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::{MATERIAL, QUAD, Stage};
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> =
    LazyLock::new(|| Stage::new("texture", &format!("{MATERIAL}texture = \"paint.png\"\n{QUAD}")));

fuzz_target!(|data: &[u8]| {
    STAGE.write("paint.png", data);
    STAGE.load();
});
