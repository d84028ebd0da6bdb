//! glTF 2.0: the first byte says whether the rest is text or binary, and whether the file brings its own
//! materials and lights.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

/// Of the file's geometry alone, at rest and as a shape that deforms, then of all that it brings; as text,
/// then as binary.
static STAGES: LazyLock<[(Stage, &str); 4]> = LazyLock::new(|| {
    let whole = |file| format!("[[object]]\nname = \"a\"\nfile = \"{file}\"\nlights = true\n");
    [
        (Stage::of_mesh("gltf", "mesh.gltf"), "mesh.gltf"),
        (Stage::of_mesh("glb", "mesh.glb"), "mesh.glb"),
        (Stage::new("whole-gltf", &whole("mesh.gltf")), "mesh.gltf"),
        (Stage::new("whole-glb", &whole("mesh.glb")), "mesh.glb"),
    ]
});

fuzz_target!(|data: &[u8]| {
    let Some((mode, data)) = data.split_first() else { return };
    let (stage, file) = &STAGES[usize::from(mode % 4)];
    stage.write(file, data);
    stage.load();
    if mode % 4 < 2 {
        stage.load_deforming(file);
    }
});
