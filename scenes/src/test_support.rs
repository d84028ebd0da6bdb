//! Independent checks of meshes, and scratch scenes, for the tests of this crate.

use crate::scene::Mesh;
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::path::PathBuf;

/// Number of directed edges, keyed by the bits of their positions, that do not have their reverse exactly
/// once.
pub(crate) fn open_edges(mesh: &Mesh) -> usize {
    let key = |v: u32| mesh.positions[v as usize].map(f32::to_bits);
    let mut count: HashMap<_, usize> = HashMap::new();
    for t in &mesh.triangles {
        (0..3).for_each(|k| *count.entry((key(t[k]), key(t[(k + 1) % 3]))).or_default() += 1);
    }
    count.iter().filter(|((a, b), n)| **n != 1 || count.get(&(*b, *a)) != Some(&1)).count()
}

/// Signed volume by the divergence theorem; positive if the triangles face outwards.
pub(crate) fn enclosed_volume(mesh: &Mesh) -> f64 {
    let tetrahedron = |t: &[u32; 3]| {
        let [a, b, c]: [DVec3; 3] = t.map(|v| Vec3::from(mesh.positions[v as usize]).as_dvec3());
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles.iter().map(tetrahedron).sum()
}

/// A folder with a scene file in it, removed when dropped.
pub(crate) struct Scratch {
    folder: tempfile::TempDir,
}

impl Scratch {
    /// A new folder whose `scene.toml` is `text`.
    pub fn scene(text: &str) -> Self {
        let scratch = Self { folder: tempfile::tempdir().unwrap() };
        scratch.write("scene.toml", text);
        scratch
    }

    /// Writes a file, and the folders above it.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }

    /// The path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Loads the scene.
    pub fn load(&self) -> relume_formats::Result<crate::Scene> {
        crate::load(&self.path("scene.toml"))
    }
}
