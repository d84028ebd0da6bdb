//! Pictures: PNG and JPEG.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

static STAGE: LazyLock<Stage> = LazyLock::new(|| {
    Stage::new(
        "texture",
        "[materials.a]\nkd = [0.5, 0.5, 0.5]\ntexture = \"paint.png\"\n[[object]]\nname = \"a\"\nmaterial = \"a\"\nshape = \"quad\"\n",
    )
});

fuzz_target!(|data: &[u8]| {
    STAGE.write("paint.png", data);
    STAGE.load();
});
