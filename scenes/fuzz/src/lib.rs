//! What the fuzz targets share: a scene in a temporary folder that names the fuzzed file, and what must hold
//! of it once it is loaded.

use relume_scenes::{Mesh, Scene, load, load_deforming};
use std::path::{Path, PathBuf};

/// Camera and film of every scene.
const VIEW: &str = "[render]\nsize = [8, 8]\n[camera]\nposition = [0.0, 1.0, 4.0]\ntarget = [0.0, 1.0, 0.0]\nfov_deg = 40.0\n";

/// A material for whatever needs one.
pub const MATERIAL: &str =
    "[materials.a]\nbrdf = \"blinn-phong\"\nkd = [0.5, 0.5, 0.5]\nks = [0.0, 0.0, 0.0]\nshininess = 10.0\n";

/// An object that wears it.
pub const QUAD: &str = "[[object]]\nname = \"quad\"\nmaterial = \"a\"\nshape = \"quad\"\n";

/// A folder with a `scene.toml`, in memory where the system has a file system there.
pub struct Stage(PathBuf);

impl Stage {
    /// A scene of the given parts; `name` tells the folder from those of other targets.
    pub fn new(name: &str, parts: &str) -> Self {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
        let folder = parent.join(format!("relume-fuzz-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        let stage = Self(folder);
        stage.write("scene.toml", format!("{VIEW}{parts}").as_bytes());
        stage
    }

    /// A scene of one object, whose file is `mesh`.
    pub fn of_mesh(name: &str, mesh: &str) -> Self {
        Self::new(name, &format!("{MATERIAL}[[object]]\nname = \"a\"\nmaterial = \"a\"\nfile = \"{mesh}\"\n"))
    }

    /// A scene lit by the environment map `map`.
    pub fn of_environment(name: &str, map: &str) -> Self {
        Self::new(name, &format!("{MATERIAL}{QUAD}[environment]\nfile = \"{map}\"\n"))
    }

    /// Puts a file beside the scene.
    pub fn write(&self, name: &str, content: &[u8]) {
        std::fs::write(self.0.join(name), content).expect("a temporary file");
    }

    /// Loads the scene: a sound one, or an error of one line. Returns the error, if any.
    pub fn load(&self) -> Option<String> {
        match load(&self.0.join("scene.toml")) {
            Ok(scene) => {
                check(&scene);
                None
            }
            Err(error) => {
                assert!(!error.to_string().contains('\n'), "`{error}`");
                Some(error.to_string())
            }
        }
    }

    /// Loads `name`, a file beside the scene, as a shape that deforms: a sound one, or an error of one line.
    /// Returns the error, if any.
    pub fn load_deforming(&self, name: &str) -> Option<String> {
        let deforming = match load_deforming(&self.0.join(name), &mut Vec::new()) {
            Ok(deforming) => deforming,
            Err(error) => {
                assert!(!error.to_string().contains('\n'), "`{error}`");
                return Some(error.to_string());
            }
        };
        check_mesh(&deforming.rest);
        let (shape, mut positions) = (&deforming.shape, Vec::new());
        shape.positions(&shape.rest_pose(), &mut positions);
        assert_eq!(positions, deforming.rest.positions);
        for clip in &shape.clips {
            for time_s in [-1.0, 0.0, 0.5 * clip.duration_s, clip.duration_s, f32::MAX] {
                shape.positions_at(clip, time_s, &mut positions);
                assert_eq!(positions.len(), deforming.rest.positions.len());
            }
        }
        None
    }
}

fn check(scene: &Scene) {
    for object in &scene.objects {
        assert!(object.material < scene.materials.len());
        check_mesh(&object.mesh);
    }
    for texture in scene.materials.iter().filter_map(|m| m.texture.as_ref()) {
        assert_eq!(texture.texels.len() as u64, u64::from(texture.size[0]) * u64::from(texture.size[1]));
    }
    if let Some(environment) = &scene.environment {
        for map in [&environment.map].into_iter().chain(&environment.others).map(|named| &named.map) {
            assert_eq!(map.texels.len() as u64, u64::from(map.width) * u64::from(map.height));
            assert!(map.texels.as_flattened().iter().all(|x| x.is_finite() && *x >= 0.0));
        }
    }
    assert!(scene.warnings.iter().all(|w| !w.contains('\n')), "{:?}", scene.warnings);
}

fn check_mesh(mesh: &Mesh) {
    assert!(mesh.triangles.as_flattened().iter().all(|i| (*i as usize) < mesh.positions.len()));
    assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    for normal in &mesh.normals {
        let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 1e-3, "a normal of length {length}");
    }
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == mesh.positions.len());
    assert!(mesh.uvs.as_flattened().iter().all(|x| x.is_finite()));
}
