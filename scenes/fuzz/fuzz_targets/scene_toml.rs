//! `scene.toml`. Scenes that ask for many triangles are left out: they are legal, and would cost all the
//! time.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_scenes_fuzz::Stage;
use std::sync::LazyLock;

const MANY: i64 = 100_000;

static STAGE: LazyLock<Stage> = LazyLock::new(|| Stage::new("scene", ""));

/// About how many triangles the shapes of a scene have.
fn triangles(scene: &toml::Table) -> i64 {
    let objects = scene.get("object").and_then(toml::Value::as_array).into_iter().flatten();
    let cost = |object: &toml::Value| {
        let number = |key: &str, default: i64| {
            object.get(key).and_then(toml::Value::as_integer).unwrap_or(default).clamp(0, 10_000)
        };
        let sphere = 20 << (2 * number("subdivisions", 4)).min(40);
        sphere + 2 * number("segments", 300) * number("sides", 32)
    };
    objects.map(cost).sum()
}

fuzz_target!(|text: &str| {
    if toml::from_str(text).is_ok_and(|scene| triangles(&scene) > MANY) {
        return;
    }
    STAGE.write("scene.toml", text.as_bytes());
    STAGE.load();
});
