//! Stored scenes: meshes, camera and materials.

use super::out::Out;
use super::ply::{PlyMesh, WORLD_SPACE};
use super::words::{list, many, pixels};
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::StoredScene;
use relume_formats::kinds::scene::{Meta, StoredMaterial, StoredObject};
use relume_formats::state::{BlinnPhong, Brdf, Camera, CookTorrance, Ggx};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::Scene, describe, export };

#[derive(Serialize)]
struct Details {
    name: String,
    size: [u32; 2],
    camera: Camera,
    vertices: usize,
    triangles: usize,
    objects: Vec<String>,
    materials: Vec<StoredMaterial>,
}

fn describe(path: &Path) -> Result<Described> {
    let scene = StoredScene::read_file(path)?;
    let details = Details {
        size: scene.meta.size,
        camera: scene.meta.camera,
        vertices: scene.positions.len(),
        triangles: scene.triangles.len(),
        objects: scene.meta.objects.into_iter().map(|o| o.name).collect(),
        materials: scene.meta.materials,
        name: scene.meta.name,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let Details { name, size, camera, vertices, triangles, objects, materials } = details;
    vec![
        ("name", name.clone()),
        ("size", pixels(*size)),
        (
            "camera",
            format!("position {:?}, target {:?}, fov {}°", camera.position, camera.target, camera.fov_deg),
        ),
        (
            "geometry",
            format!(
                "{}, {}",
                many(*vertices, "vertex", "vertices"),
                many(*triangles, "triangle", "triangles")
            ),
        ),
        ("objects", list(objects.iter().cloned())),
        ("varies", list(materials.iter().filter(|m| m.varies).map(|m| m.name.clone()))),
        ("fixed", list(materials.iter().filter(|m| !m.varies).map(|m| m.name.clone()))),
    ]
}

/// `mesh.ply` with the indices of object and material on every face, `scene.json`, `camera.json`,
/// `materials.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let scene = StoredScene::read_file(path)?;
    let meta = &scene.meta;
    let labels: Vec<[u32; 2]> = (0..)
        .zip(&meta.objects)
        .flat_map(|(index, o)| std::iter::repeat_n([index, o.material], o.triangles as usize))
        .collect();
    let mesh = PlyMesh {
        comment: WORLD_SPACE,
        positions: &scene.positions,
        normals: &scene.normals,
        colours: None,
        triangles: &scene.triangles,
        labels: Some((["object", "material"], &labels)),
    };
    out.bytes("mesh.ply", &mesh.encode())?;
    out.json(
        "camera.json",
        &CameraFile { camera: meta.camera, tonemap: meta.tonemap.name(), size: meta.size },
    )?;
    let material = |m: &'_ StoredMaterial| {
        let sharpest = m.varies.then_some(m.sharpest);
        json!(MaterialFile::new(&m.name, m.brdf, m.textured, sharpest))
    };
    let materials: Vec<Value> = meta.materials.iter().map(material).collect();
    out.json("materials.json", &materials)?;
    out.json("scene.json", &json!({ "name": meta.name, "mesh": "mesh.ply", "objects": objects(meta) }))
}

/// A material as JSON.
#[derive(Serialize)]
pub(crate) struct MaterialFile<'a> {
    name: &'a str,
    brdf: &'static str,
    #[serde(flatten)]
    parameters: Parameters,
    textured: bool,
    varies: bool,
    /// What its exponent, roughness or slope may be edited to, if it varies.
    #[serde(skip_serializing_if = "Option::is_none")]
    sharpest: Option<f32>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Parameters {
    BlinnPhong(BlinnPhong),
    Ggx(Ggx),
    CookTorrance(CookTorrance),
}

impl<'a> MaterialFile<'a> {
    /// `sharpest` is what its lobe may be edited to, if it varies.
    pub fn new(name: &'a str, brdf: Brdf, textured: bool, sharpest: Option<f32>) -> Self {
        let parameters = match brdf {
            Brdf::BlinnPhong(parameters) => Parameters::BlinnPhong(parameters),
            Brdf::Ggx(parameters) => Parameters::Ggx(parameters),
            Brdf::CookTorrance(parameters) => Parameters::CookTorrance(parameters),
        };
        Self { name, brdf: brdf.model().name(), parameters, textured, varies: sharpest.is_some(), sharpest }
    }
}

/// The camera and its film.
#[derive(Serialize)]
struct CameraFile {
    #[serde(flatten)]
    camera: Camera,
    tonemap: &'static str,
    size: [u32; 2],
}

fn objects(meta: &Meta) -> Vec<Value> {
    let mut first = 0;
    let mut describe = |o: &StoredObject| {
        let material = meta.materials.get(o.material as usize).map(|m| &m.name);
        let value = json!({ "name": o.name, "material": material, "first_triangle": first, "triangles": o.triangles });
        first += u64::from(o.triangles);
        value
    };
    meta.objects.iter().map(&mut describe).collect()
}
