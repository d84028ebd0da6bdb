//! A small room, and a folder to bake it in.

use super::{expect_exit, write_scene};

/// A room small enough to bake in a second.
pub const ROOM: &str = "
    [vary]
    materials = ['ball', 'room']
    [render]
    size = [48, 40]
    reflections = 2
    [camera]
    position = [0.0, 1.0, 3.5]
    target = [0.0, 0.8, 0.0]
    fov_deg = 45.0
    [materials.ball]
    brdf = 'blinn-phong'
    kd = [0.2, 0.3, 0.4]
    ks = [0.3, 0.3, 0.3]
    shininess = 20.0
    [materials.room]
    brdf = 'blinn-phong'
    kd = [0.6, 0.6, 0.6]
    [materials.wall]
    brdf = 'blinn-phong'
    kd = [0.7, 0.1, 0.1]
    [[object]]
    name = 'ball'
    shape = 'sphere'
    material = 'ball'
    transform = { translation = [0.1, 0.5, 0.0], scale = 0.5 }
    [[object]]
    name = 'floor'
    shape = 'quad'
    material = 'room'
    transform = { scale = 4.0 }
    [[object]]
    name = 'wall'
    shape = 'quad'
    material = 'wall'
    transform = { translation = [-1.0, 1.0, 0.0], rotation_deg = [0.0, 0.0, -90.0], scale = 2.0 }
    [[light]]
    name = 'lamp'
    kind = 'area'
    radiance = [10.0, 9.0, 8.0]
    transform = { translation = [0.0, 2.5, 0.5], rotation_deg = [-90.0, 0.0, 0.0] }
";

/// Makes the ball duller, then glossier.
const ANIMATION: &str = "
    duration_s = 0.5
    loop = true
    [[key]]
    t_s = 0.0
    materials.ball.shininess = 5.0
    [[key]]
    t_s = 0.5
    materials.ball.shininess = 150.0
";

/// A folder with the room in it, and its path as text.
pub struct Workshop {
    /// The folder.
    pub folder: tempfile::TempDir,
}

impl Workshop {
    pub fn new() -> Self {
        let workshop = Self { folder: tempfile::tempdir().unwrap() };
        write_scene(workshop.folder.path(), ROOM);
        std::fs::create_dir(workshop.folder.path().join("animations")).unwrap();
        workshop.write("animations/shine.toml", ANIMATION);
        workshop
    }

    /// The path of `name` in the folder.
    pub fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    /// Writes a file; returns its path.
    pub fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.folder.path().join(name), text).unwrap();
        self.path(name)
    }

    /// Bakes the room into `bundle` and expects success.
    pub fn bake(&self, bundle: &str, more: &[&str]) {
        let (scene, output) = (self.path("scene.toml"), self.path(bundle));
        expect_exit("bake", &[&["run", &scene, "-o", &output, "--progress", "none"], more].concat(), 0);
    }
}
