//! A scene as it was loaded.

use crate::inspected::animation_json;
use crate::inspected::out::{Out, file_name_part};
use crate::inspected::ply::{PlyMesh, WORLD_SPACE};
use crate::inspected::scene::MaterialFile;
use relume_formats::Result;
use relume_formats::state::{Camera, Rgb};
use relume_scenes::{ALL_REFLECTIONS, Cone, Emitter, Environment, Scene};
use serde::Serialize;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// `scene.json`.
#[derive(Serialize)]
struct SceneFile<'a> {
    name: &'a str,
    size: [u32; 2],
    /// A number, or "all".
    reflections: serde_json::Value,
    max_error: f64,
    vary: VaryFile<'a>,
    camera: Camera,
    tonemap: &'static str,
    materials: Vec<MaterialFile<'a>>,
    objects: Vec<ObjectFile<'a>>,
    lights: Vec<LightFile<'a>>,
    environment: Option<EnvironmentFile>,
    warnings: &'a [String],
}

#[derive(Serialize)]
struct VaryFile<'a> {
    light: bool,
    view: bool,
    shape: bool,
    materials: Vec<&'a str>,
    painted: Vec<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shininess_max: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    roughness_min: Option<f32>,
}

#[derive(Serialize)]
struct ObjectFile<'a> {
    name: &'a str,
    file: String,
    material: Option<&'a str>,
    vertices: usize,
    triangles: usize,
}

#[derive(Serialize)]
struct LightFile<'a> {
    name: &'a str,
    #[serde(flatten)]
    emitter: EmitterFile,
}

/// Metres; area lights in W/(sr·m²), points in W/sr, directional ones in W/m².
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum EmitterFile {
    Area {
        corner: [f32; 3],
        edge_u: [f32; 3],
        edge_v: [f32; 3],
        radiance: Rgb,
    },
    /// The front of an object, which reflects as well; `textured` if a texture says where how much of
    /// `radiance` is emitted.
    Mesh {
        object: String,
        radiance: Rgb,
        textured: bool,
    },
    Point {
        position: [f32; 3],
        intensity: Rgb,
    },
    Spot {
        position: [f32; 3],
        intensity: Rgb,
        direction: [f32; 3],
        cos_inner: f32,
        cos_outer: f32,
    },
    Directional {
        direction: [f32; 3],
        irradiance: Rgb,
    },
}

#[derive(Serialize)]
struct EnvironmentFile {
    file: &'static str,
    mapping: &'static str,
    width: u32,
    height: u32,
    gain: Rgb,
    rotation_deg: f32,
}

/// Exports a loaded scene into the folder `out`: `scene.json`, a PLY file for each object in world space,
/// `environment.exr` without gain and rotation, and animations. Existing files of the same names are
/// replaced. Returns the files written.
///
/// # Errors
/// If a file cannot be written.
pub fn export_scene(scene: &Scene, out: &Path) -> Result<Vec<PathBuf>> {
    let mut out = Out::new(out)?;
    let mut objects = Vec::new();
    for (index, object) in scene.objects.iter().enumerate() {
        let mesh = &object.mesh;
        let file = format!("object_{index:03}_{}.ply", file_name_part(&object.name));
        let ply = PlyMesh {
            comment: WORLD_SPACE,
            positions: &mesh.positions,
            normals: &mesh.normals,
            colours: None,
            triangles: &mesh.triangles,
            labels: None,
        };
        out.bytes(&file, &ply.encode())?;
        let material = scene.materials.get(object.material).map(|m| m.name.as_str());
        objects.push(ObjectFile {
            name: &object.name,
            file,
            material,
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
        });
    }
    let environment = scene.environment.as_ref().map(|e| environment(e, &mut out)).transpose()?;
    scene.animations.iter().try_for_each(|animation| animation_json(animation, &mut out))?;
    out.json("scene.json", &scene_file(scene, objects, environment))?;
    Ok(out.written())
}

fn scene_file<'a>(
    scene: &'a Scene,
    objects: Vec<ObjectFile<'a>>,
    environment: Option<EnvironmentFile>,
) -> SceneFile<'a> {
    let vary = &scene.vary;
    let varying = vary
        .materials
        .iter()
        .filter_map(|index| scene.materials.get(*index))
        .map(|m| m.name.as_str())
        .collect();
    let painted = vary.painted.iter().filter_map(|index| scene.materials.get(*index));
    let indices: HashSet<usize> = vary.materials.iter().copied().collect();
    let materials = (0..)
        .zip(&scene.materials)
        .map(|(index, m)| {
            let sharpest = indices.contains(&index).then(|| vary.sharpest(m.brdf.model()));
            MaterialFile::new(&m.name, m.brdf, m.texture.is_some(), sharpest)
        })
        .collect();
    SceneFile {
        name: &scene.name,
        size: scene.size,
        reflections: match scene.reflections {
            ALL_REFLECTIONS => "all".into(),
            number => number.into(),
        },
        max_error: scene.max_error,
        vary: VaryFile {
            light: vary.light,
            view: vary.view,
            shape: vary.shape,
            materials: varying,
            painted: painted.map(|m| m.name.as_str()).collect(),
            shininess_max: vary.shininess_max,
            roughness_min: vary.roughness_min,
        },
        camera: scene.camera,
        tonemap: scene.tonemap.name(),
        materials,
        objects,
        lights: scene
            .lights
            .iter()
            .map(|l| LightFile { name: &l.name, emitter: emitter(&l.emitter, scene) })
            .collect(),
        environment,
        warnings: &scene.warnings,
    }
}

fn emitter(emitter: &Emitter, scene: &Scene) -> EmitterFile {
    match *emitter {
        Emitter::Area { corner, edge_u, edge_v, radiance } => {
            EmitterFile::Area { corner, edge_u, edge_v, radiance }
        }
        Emitter::Mesh { object, radiance, ref glow } => {
            let object = scene.objects.get(object).map(|object| object.name.clone()).unwrap_or_default();
            EmitterFile::Mesh { object, radiance, textured: glow.is_some() }
        }
        Emitter::Point { position, intensity, cone: None } => EmitterFile::Point { position, intensity },
        Emitter::Point { position, intensity, cone: Some(Cone { direction, cos_inner, cos_outer }) } => {
            EmitterFile::Spot { position, intensity, direction, cos_inner, cos_outer }
        }
        Emitter::Directional { direction, irradiance } => EmitterFile::Directional { direction, irradiance },
    }
}

fn environment(environment: &Environment, out: &mut Out) -> Result<EnvironmentFile> {
    let map = &environment.map.map;
    let plane = |channel: usize| -> Vec<f32> { map.texels.iter().map(|texel| texel[channel]).collect() };
    let (red, green, blue) = (plane(0), plane(1), plane(2));
    let file = "environment.exr";
    out.exr(file, [map.width, map.height], &[("R", &red), ("G", &green), ("B", &blue)])?;
    Ok(EnvironmentFile {
        file,
        mapping: "equirectangular: u = 0.5 + atan2(x, -z)/2pi, v = acos(y)/pi; a positive rotation is counter-clockwise seen from +Y",
        width: map.width,
        height: map.height,
        gain: environment.gain,
        rotation_deg: environment.rotation_deg,
    })
}
