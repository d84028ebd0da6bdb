//! Stored scenes, animations, environments and textures.

use super::out::{Out, file_name_part};
use super::ply::{PlyMesh, WORLD_SPACE};
use relume_formats::Result;
use relume_formats::kinds::manifest::is_plain_name;
use relume_formats::kinds::scene::Meta;
use relume_formats::kinds::{Environment, StoredScene, Textures};
use relume_formats::state::{Animation, BlinnPhong, Brdf, Camera, Ggx, TrackValues};
use serde::Serialize;
use serde_json::{Value, json};

/// `mesh.ply` with the indices of object and material on every face, `scene.json`, `camera.json`, `materials.json`.
pub(super) fn scene(scene: &StoredScene, out: &mut Out) -> Result<()> {
    let meta = &scene.meta;
    let labels: Vec<[u32; 2]> =
        (0..).zip(&meta.objects).flat_map(|(index, o)| std::iter::repeat_n([index, o.material], o.triangles as usize)).collect();
    let mesh = PlyMesh {
        comment: WORLD_SPACE,
        positions: &scene.positions,
        normals: &scene.normals,
        colours: None,
        triangles: &scene.triangles,
        labels: Some((["object", "material"], &labels)),
    };
    out.bytes("mesh.ply", &mesh.encode())?;
    out.json("camera.json", &CameraFile { camera: meta.camera, tonemap: meta.tonemap.name(), size: meta.size })?;
    let materials: Vec<_> = meta.materials.iter().map(|m| MaterialFile::new(&m.name, m.brdf, m.textured, m.varies)).collect();
    out.json("materials.json", &materials)?;
    out.json("scene.json", &json!({ "name": meta.name, "mesh": "mesh.ply", "objects": objects(meta) }))
}

/// A material as JSON.
#[derive(Serialize)]
pub(super) struct MaterialFile<'a> {
    name: &'a str,
    brdf: &'static str,
    #[serde(flatten)]
    parameters: Parameters,
    textured: bool,
    varies: bool,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Parameters {
    BlinnPhong(BlinnPhong),
    Ggx(Ggx),
}

impl<'a> MaterialFile<'a> {
    pub fn new(name: &'a str, brdf: Brdf, textured: bool, varies: bool) -> Self {
        let parameters = match brdf {
            Brdf::BlinnPhong(parameters) => Parameters::BlinnPhong(parameters),
            Brdf::Ggx(parameters) => Parameters::Ggx(parameters),
        };
        Self { name, brdf: brdf.model().name(), parameters, textured, varies }
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
    let mut describe = |o: &relume_formats::kinds::scene::StoredObject| {
        let material = meta.materials.get(o.material as usize).map(|m| &m.name);
        let value = json!({ "name": o.name, "material": material, "first_triangle": first, "triangles": o.triangles });
        first += u64::from(o.triangles);
        value
    };
    meta.objects.iter().map(&mut describe).collect()
}

/// `environment.exr`, `environment.json`.
pub(super) fn environment(environment: &Environment, out: &mut Out) -> Result<()> {
    let map = &environment.map;
    let plane = |channel: usize| -> Vec<f32> { map.texels.iter().map(|texel| texel[channel]).collect() };
    let (red, green, blue) = (plane(0), plane(1), plane(2));
    out.exr("environment.exr", [map.width, map.height], &[("R", &red), ("G", &green), ("B", &blue)])?;
    out.json(
        "environment.json",
        &json!({
            "name": environment.name,
            "mapping": "equirectangular: u = 0.5 + atan2(x, -z)/2pi, v = acos(y)/pi; radiance in W/(sr m^2)",
            "width": map.width,
            "height": map.height,
        }),
    )
}

/// `uvs.npy` [vertices, 2], `texture_<n>.npy` [height, width, 4], `textures.json`.
pub(super) fn textures(textures: &Textures, out: &mut Out) -> Result<()> {
    out.npy("uvs.npy", &[textures.uvs.len(), 2], textures.uvs.as_flattened().iter().copied())?;
    let mut list = Vec::new();
    for (index, stored) in textures.textures.iter().enumerate() {
        let file = format!("texture_{index}.npy");
        let [width, height] = stored.texture.size.map(|n| n as usize);
        out.npy(&file, &[height, width, 4], stored.texture.texels.as_flattened().iter().copied())?;
        list.push(json!({ "file": file, "material": stored.material, "alpha_cutoff": stored.alpha_cutoff, "wrap": stored.texture.wrap }));
    }
    out.json("textures.json", &list)
}

/// `animation_<name>.json`.
pub(super) fn animation(animation: &Animation, out: &mut Out) -> Result<()> {
    // Those of a bundle are called plainly, and no two the same.
    let plain = format!("animation_{}.json", animation.name);
    let file = if is_plain_name(&plain) { plain } else { format!("animation_{}.json", file_name_part(&animation.name)) };
    out.json(&file, &AnimationFile::new(animation))
}

/// An animation as JSON.
#[derive(Serialize)]
struct AnimationFile<'a> {
    name: &'a str,
    duration_s: f32,
    #[serde(rename = "loop")]
    looping: bool,
    tracks: Vec<TrackFile<'a>>,
}

#[derive(Serialize)]
struct TrackFile<'a> {
    leaf: &'a [String],
    times_s: &'a [f32],
    values: ValuesFile<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ValuesFile<'a> {
    Scalar(&'a [f32]),
    Vector(&'a [Vec<f32>]),
    Name(&'a [String]),
}

impl<'a> AnimationFile<'a> {
    fn new(animation: &'a Animation) -> Self {
        let tracks = animation.tracks.iter().map(|track| {
            let values = match &track.values {
                TrackValues::Scalar(v) => ValuesFile::Scalar(v),
                TrackValues::Vector(v) => ValuesFile::Vector(v),
                TrackValues::Name(v) => ValuesFile::Name(v),
            };
            TrackFile { leaf: &track.leaf, times_s: &track.times_s, values }
        });
        Self { name: &animation.name, duration_s: animation.duration_s, looping: animation.looping, tracks: tracks.collect() }
    }
}
