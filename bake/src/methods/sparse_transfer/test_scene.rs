//! A small scene for tests: a ball that stands on a floor, in the light of lamps.

use relume_scenes::Scene;

const SCENE: &str = "
    [vary]
    light = true
    [render]
    size = [16, 16]
    reflections = 3
    [camera]
    position = [0.0, 1.0, 4.0]
    target = [0.0, 0.4, 0.0]
    fov_deg = 45.0
    [materials.clay]
    brdf = 'blinn-phong'
    kd = [0.5, 0.4, 0.3]
    [[object]]
    name = 'ball'
    shape = 'sphere'
    subdivisions = 1
    material = 'clay'
    transform = { translation = [0.0, 0.5, 0.0], scale = 0.5 }
    [[object]]
    name = 'floor'
    shape = 'quad'
    segments = 3
    material = 'clay'
    transform = { scale = 2.0 }
    [environment]
    file = 'lamps'
";

/// The scene.
pub(super) fn test_scene() -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, SCENE).unwrap();
    relume_scenes::load(&path).unwrap()
}
