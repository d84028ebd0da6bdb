//! Hashes of the parts of a scene, so that every step of a bake is done again when something changes that it
//! reads, and only then.
//!
//! In no part are parameters of materials that vary but those that [`Part::Albedos`] has, animations,
//! exposure, the curve of the display, and names of objects and lights: changing
//! these re-traces nothing.

use relume_formats::shape::{DeformingMesh, Influences, MorphTarget, Track};
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx};
use relume_scenes::{Cone, Emitter, Glow, Material, NamedMap, Scene, Texture};
use std::collections::HashMap;
use xxhash_rust::xxh3::Xxh3;

/// What a step may read of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Meshes at rest, in world space, with normals and texture coordinates.
    Geometry,
    /// How objects deform, clips included.
    Shapes,
    /// Textures and cut-outs, and which object has which material.
    Textures,
    /// Diffuse albedos of all materials, which other surfaces reflect.
    Albedos,
    /// Materials that stay, names of those that vary, and textures.
    Surfaces,
    /// Lights but the environment.
    Lights,
    /// Where the camera is.
    Camera,
    /// How often light is reflected.
    Reflections,
    /// The environment map that the scene shows, its gain and rotation.
    Environment,
    /// All environment maps, with their names.
    Maps,
}

impl Part {
    /// Those that are no part of another.
    const WHOLE: [Self; 8] = [
        Self::Geometry,
        Self::Shapes,
        Self::Surfaces,
        Self::Lights,
        Self::Camera,
        Self::Reflections,
        Self::Environment,
        Self::Maps,
    ];
}

/// xxh3-128 over some parts of `scene`.
pub fn hash_of(scene: &Scene, parts: &[Part]) -> u128 {
    let mut hash = Hasher(Xxh3::new());
    for part in parts {
        // Parts have no fixed lengths.
        hash.text(&format!("{part:?}"));
        hash.part(*part, scene);
    }
    hash.0.digest128()
}

/// xxh3-128 over everything of `scene` that results of any method depend on.
pub fn scene_hash(scene: &Scene) -> u128 {
    hash_of(scene, &Part::WHOLE)
}

struct Hasher(Xxh3);

impl Hasher {
    fn part(&mut self, part: Part, scene: &Scene) {
        match part {
            Part::Geometry => self.geometry(scene),
            Part::Shapes => {
                for (index, object) in
                    scene.objects.iter().enumerate().filter(|(_, object)| object.shape.is_some())
                {
                    self.number(index as u64);
                    self.shape(object.shape.as_deref());
                }
            }
            Part::Textures => {
                self.assignment(scene);
                for (index, material) in
                    scene.materials.iter().enumerate().filter(|(_, material)| material.texture.is_some())
                {
                    self.number(index as u64);
                    self.cutout_and_texture(material);
                }
            }
            Part::Albedos => {
                self.assignment(scene);
                scene.materials.iter().for_each(|material| self.floats(&material.brdf.diffuse_albedo()));
            }
            Part::Surfaces => self.surfaces(scene),
            Part::Lights => {
                self.number(scene.lights.len() as u64);
                scene.lights.iter().for_each(|light| self.emitter(&light.emitter));
            }
            Part::Camera => {
                self.vectors(&[&scene.camera.position, &scene.camera.target, &[scene.camera.fov_deg]])
            }
            Part::Reflections => self.number(scene.reflections.into()),
            Part::Environment => {
                if let Some(environment) = &scene.environment {
                    self.vectors(&[&environment.gain, &[environment.rotation_deg]]);
                    self.map(&environment.map);
                }
            }
            Part::Maps => {
                for map in scene.environment.iter().flat_map(|e| [&e.map].into_iter().chain(&e.others)) {
                    self.text(&map.name);
                    self.map(map);
                }
            }
        }
    }

    fn geometry(&mut self, scene: &Scene) {
        self.number(scene.objects.len() as u64);
        for object in &scene.objects {
            self.floats(object.mesh.positions.as_flattened());
            self.floats(object.mesh.normals.as_flattened());
            self.floats(object.mesh.uvs.as_flattened());
            self.bytes(bytemuck::cast_slice(&object.mesh.triangles));
        }
    }

    /// Which object has which material.
    fn assignment(&mut self, scene: &Scene) {
        self.number(scene.objects.len() as u64);
        scene.objects.iter().for_each(|object| self.number(object.material as u64));
    }

    fn surfaces(&mut self, scene: &Scene) {
        self.assignment(scene);
        self.number(scene.materials.len() as u64);
        let classes: HashMap<usize, usize> = scene.vary.materials.iter().copied().zip(1..).collect();
        for (index, material) in scene.materials.iter().enumerate() {
            let class = classes.get(&index);
            self.number(class.map_or(0, |c| *c as u64));
            match class {
                Some(_) => {
                    self.text(&material.name);
                    self.floats(&[scene.vary.sharpest(material.brdf.model())]);
                }
                None => self.brdf(&material.brdf),
            }
            self.number(material.brdf.model() as u64);
            self.cutout_and_texture(material);
        }
    }

    fn cutout_and_texture(&mut self, material: &Material) {
        if let Some(texture) = &material.texture {
            self.floats(&[material.alpha_cutoff.unwrap_or(-1.0)]);
            self.texture(texture);
        }
    }

    fn map(&mut self, NamedMap { map, .. }: &NamedMap) {
        self.number(map.width.into());
        self.floats(map.texels.as_flattened());
    }

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

    /// Nothing for an object that does not deform.
    fn shape(&mut self, shape: Option<&DeformingMesh>) {
        let Some(shape) = shape else { return };
        self.text(&format!("{:?} {:?}", shape.nodes, shape.joints));
        self.floats(shape.positions.as_flattened());
        for Influences { joints, weights } in &shape.influences {
            self.bytes(bytemuck::cast_slice(joints));
            self.floats(weights);
        }
        for MorphTarget { rest_weight, vertices, deltas } in &shape.morph_targets {
            self.vectors(&[&[*rest_weight], deltas.as_flattened()]);
            self.bytes(bytemuck::cast_slice(vertices));
        }
        for clip in &shape.clips {
            self.text(&clip.name);
            self.floats(&[clip.duration_s]);
            for Track { property, interpolation, times_s, values } in &clip.tracks {
                self.text(&format!("{property:?} {interpolation:?}"));
                self.vectors(&[times_s, values]);
            }
        }
        // What came before has no fixed length.
        self.text("shape");
    }

    fn texture(&mut self, texture: &Texture) {
        self.text(&format!("{:?} {:?} {:?}", texture.size, texture.wrap, texture.filter));
        self.bytes(texture.texels.as_flattened());
    }

    fn brdf(&mut self, brdf: &Brdf) {
        match brdf {
            Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) => self.vectors(&[kd, ks, &[*shininess]]),
            Brdf::Ggx(Ggx { base_color, metallic, roughness }) => {
                self.vectors(&[base_color, &[*metallic, *roughness]])
            }
            Brdf::CookTorrance(CookTorrance { kd, ks, fresnel, roughness }) => {
                self.vectors(&[kd, ks, &[*fresnel, *roughness]])
            }
        }
    }

    fn emitter(&mut self, emitter: &Emitter) {
        match emitter {
            Emitter::Area { corner, edge_u, edge_v, radiance } => {
                self.vectors(&[corner, edge_u, edge_v, radiance])
            }
            Emitter::Mesh { object, radiance, glow } => {
                self.number(*object as u64);
                self.floats(radiance);
                if let Some(Glow { texture, uvs }) = glow {
                    self.texture(texture);
                    self.floats(uvs.as_flattened());
                }
            }
            Emitter::Point { position, intensity, cone } => {
                self.vectors(&[position, intensity]);
                if let Some(Cone { direction, cos_inner, cos_outer }) = cone {
                    self.vectors(&[direction, &[*cos_inner, *cos_outer]]);
                }
            }
            Emitter::Directional { direction, irradiance } => self.vectors(&[direction, irradiance]),
        }
        // What came before has no fixed length.
        self.text(match emitter {
            Emitter::Area { .. } => "area",
            Emitter::Mesh { .. } => "mesh",
            Emitter::Point { .. } => "point",
            Emitter::Directional { .. } => "directional",
        });
    }

    fn vectors(&mut self, vectors: &[&[f32]]) {
        vectors.iter().for_each(|v| self.floats(v));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn everything_that_moves_a_shape_counts() {
        let scene = relume_scenes::load(&relume_scenes::resolve("knot-twist").unwrap()).unwrap();
        let hash_after = |change: &dyn Fn(&mut DeformingMesh)| {
            let mut scene = scene.clone();
            change(Arc::make_mut(scene.objects[0].shape.as_mut().unwrap()));
            scene_hash(&scene)
        };
        let target = || MorphTarget { rest_weight: 0.5, vertices: vec![0, 1], deltas: vec![[1.0; 3]; 2] };
        let mut hashes = vec![
            scene_hash(&scene),
            hash_after(&|s| s.positions[7][0] += 0.1),
            hash_after(&|s| s.influences[7].joints[0] += 1),
            hash_after(&|s| s.influences[7].weights[0] += 0.1),
            hash_after(&|s| s.nodes[3].parent = None),
            hash_after(&|s| s.joints[3].node_from_mesh.translation.x = 1e-12),
            hash_after(&|s| s.clips[0].name = "Turn".to_owned()),
            hash_after(&|s| s.clips[0].duration_s = 5.0),
            hash_after(&|s| s.clips[0].tracks[3].times_s[2] += 0.001),
            hash_after(&|s| s.clips[0].tracks[3].values[2] += 0.001),
            hash_after(&|s| s.clips[0].tracks.truncate(32)),
            hash_after(&|s| s.clips.clear()),
            hash_after(&|s| s.morph_targets.push(target())),
            hash_after(&|s| s.morph_targets.push(MorphTarget { vertices: vec![0, 2], ..target() })),
        ];
        let mut still = scene.clone();
        still.objects[0].shape = None;
        hashes.push(scene_hash(&still));
        let count = hashes.len();
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), count);
        assert_eq!(hash_after(&|_| ()), scene_hash(&scene));
    }
}
