//! A hash of everything of a scene that baked results depend on.
//!
//! Left out on purpose: parameters of materials that vary, animations, exposure, and names of objects and lights. Changing these re-traces nothing.

use relume_scenes::{Emitter, Scene};
use xxhash_rust::xxh3::Xxh3;

/// xxh3-128 over the parts of `scene` that results depend on.
pub fn scene_hash(scene: &Scene) -> u128 {
    let mut hash = Hasher(Xxh3::new());
    hash.number(scene.reflections.into());
    hash.floats(&scene.camera.position);
    hash.floats(&scene.camera.target);
    hash.floats(&[scene.camera.fov_deg]);
    hash.number(scene.materials.len() as u64);
    for (index, material) in scene.materials.iter().enumerate() {
        let class = scene.vary.materials.iter().position(|m| *m == index);
        hash.number(class.map_or(0, |c| c as u64 + 1));
        match class {
            Some(_) => hash.text(&material.name),
            None => {
                hash.floats(&material.brdf.kd);
                hash.floats(&material.brdf.ks);
                hash.floats(&[material.brdf.shininess]);
            }
        }
    }
    hash.number(scene.objects.len() as u64);
    for object in &scene.objects {
        hash.number(object.material as u64);
        hash.floats(object.mesh.positions.as_flattened());
        hash.floats(object.mesh.normals.as_flattened());
        hash.bytes(bytemuck::cast_slice(&object.mesh.triangles));
    }
    hash.number(scene.lights.len() as u64);
    scene.lights.iter().for_each(|light| hash.emitter(&light.emitter));
    if let Some(environment) = &scene.environment {
        hash.floats(&environment.gain);
        hash.floats(&[environment.rotation_deg]);
        hash.number(environment.map.width.into());
        hash.floats(environment.map.texels.as_flattened());
    }
    hash.0.digest128()
}

struct Hasher(Xxh3);

impl Hasher {
    fn number(&mut self, n: u64) {
        self.0.update(&n.to_le_bytes());
    }

    /// Lengths go in front, so that no two scenes share a byte string.
    fn bytes(&mut self, bytes: &[u8]) {
        self.number(bytes.len() as u64);
        self.0.update(bytes);
    }

    fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    fn floats(&mut self, values: &[f32]) {
        self.bytes(bytemuck::cast_slice(values));
    }

    fn emitter(&mut self, emitter: &Emitter) {
        let (tag, vectors): (u64, [&[f32; 3]; 4]) = match emitter {
            Emitter::Area { corner, edge_u, edge_v, radiance } => (1, [corner, edge_u, edge_v, radiance]),
            Emitter::Point { position, intensity } => (2, [position, intensity, &[0.0; 3], &[0.0; 3]]),
            Emitter::Directional { direction, irradiance } => (3, [direction, irradiance, &[0.0; 3], &[0.0; 3]]),
        };
        self.number(tag);
        vectors.iter().for_each(|v| self.floats(*v));
    }
}
