//! What a player needs to know of a scene besides its light transport, as the bundle stores it.

use relume_formats::kinds::StoredScene;
use relume_formats::kinds::scene::{Meta, StoredClip, StoredMaterial, StoredObject, StoredShape};
use relume_formats::shape::Clip;
use relume_scenes::{Environment, Object, Scene};
use std::collections::HashSet;

/// `scene` for a player's film of `size`.
pub fn stored_scene(scene: &Scene, size: [u32; 2]) -> StoredScene {
    let mut stored = StoredScene {
        meta: Meta {
            name: scene.name.clone(),
            camera: scene.camera,
            tonemap: scene.tonemap,
            size,
            varies_light: scene.vary.light,
            varies_view: scene.vary.view,
            varies_shape: scene.vary.shape,
            environment: scene.environment.as_ref().map(Environment::look),
            materials: Vec::new(),
            objects: Vec::new(),
            shapes: scene.objects.iter().filter_map(stored_shape).collect(),
        },
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
    };
    let varying: HashSet<usize> = scene.vary.materials.iter().copied().collect();
    for (index, material) in scene.materials.iter().enumerate() {
        let varies = varying.contains(&index);
        stored.meta.materials.push(StoredMaterial {
            name: material.name.clone(),
            brdf: material.brdf,
            varies,
            textured: material.texture.is_some(),
            sharpest: scene.vary.sharpest_of(index, &material.brdf),
        });
    }
    for object in &scene.objects {
        let first = stored.positions.len() as u32;
        stored.positions.extend(&object.mesh.positions);
        stored.normals.extend(&object.mesh.normals);
        stored.triangles.extend(object.mesh.triangles.iter().map(|t| t.map(|i| i + first)));
        let triangles = object.mesh.triangles.len() as u32;
        stored.meta.objects.push(StoredObject {
            name: object.name.clone(),
            material: object.material as u32,
            triangles,
        });
    }
    stored
}

fn stored_shape(object: &Object) -> Option<StoredShape> {
    let clip = |clip: &Clip| StoredClip { name: clip.name.clone(), duration_s: clip.duration_s };
    let shape = object.shape.as_ref()?;
    Some(StoredShape { object: object.name.clone(), clips: shape.clips.iter().map(clip).collect() })
}
