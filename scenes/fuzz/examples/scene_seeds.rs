//! Writes sound files into the corpus of every target, for the fuzzer to start from.

use base64::Engine;
use image::{ImageFormat, Rgb, Rgb32FImage, RgbImage};
use std::error::Error;
use std::io::Cursor;
use std::path::Path;

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 3/2/1 2/3/1\nf 1 2 4\nf 1 4 3\nf -3 -2 -1\n";
const OFF: &str = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\nproperty float v\n\
                   element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n0 0 1 1 1\n\
                   3 0 2 1\n4 0 1 3 2\n";
const PLY_BINARY: &str = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                          element face 4\nproperty list uchar ushort vertex_indices\nend_header\n";

/// With a material, a texture and two lights; BUFFER and IMAGE stand for what they hold.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2]}],
"extensionsUsed":["KHR_lights_punctual","KHR_materials_emissive_strength","KHR_texture_transform"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0.2],"intensity":3},
{"type":"spot","intensity":2,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.5}}]}},
"nodes":[{"mesh":0,"scale":[2,2,2]},{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[0,3,0]},
{"extensions":{"KHR_lights_punctual":{"light":1}},"rotation":[0,0.7071068,0,0.7071068]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"material":0},
{"attributes":{"POSITION":0},"indices":1,"material":1}]}],
"materials":[{"name":"paint","alphaMode":"MASK","alphaCutoff":0.4,"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicFactor":0,
"roughnessFactor":0.5}},{"name":"lamp","emissiveFactor":[1,1,1],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":5}}}],
"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33071,"wrapT":33648}],"images":[{IMAGE}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"},{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24},{"buffer":0,"byteOffset":72,"byteLength":32}],
"buffers":[{BUFFER"byteLength":104}]}"#;

/// A skin of two joints, a morph target in a sparse accessor, and two clips; BUFFER as above.
const DEFORMING: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2,3]}],
"nodes":[{"children":[1]},{"translation":[0,1,0],"rotation":[0,0,0.7071068,0.7071068]},{"mesh":0,"skin":0},{"mesh":1,"weights":[0.5]}],
"skins":[{"joints":[0,1],"inverseBindMatrices":4}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1}]},
{"primitives":[{"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":5}]}]}],
"animations":[{"name":"Bend","samplers":[{"input":6,"output":7},{"input":6,"output":8,"interpolation":"CUBICSPLINE"}],
"channels":[{"sampler":0,"target":{"node":1,"path":"rotation"}},{"sampler":1,"target":{"node":0,"path":"translation"}}]},
{"name":"Breathe","samplers":[{"input":6,"output":9,"interpolation":"STEP"}],"channels":[{"sampler":0,"target":{"node":3,"path":"weights"}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"},
{"bufferView":2,"componentType":5121,"count":4,"type":"VEC4"},
{"bufferView":3,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"},
{"bufferView":4,"componentType":5126,"count":2,"type":"MAT4"},
{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":5,"componentType":5121},"values":{"bufferView":0}}},
{"bufferView":6,"componentType":5126,"count":2,"type":"SCALAR"},{"bufferView":7,"componentType":5126,"count":2,"type":"VEC4"},
{"bufferView":8,"componentType":5126,"count":6,"type":"VEC3"},{"bufferView":6,"componentType":5126,"count":2,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24},{"buffer":0,"byteOffset":72,"byteLength":16},
{"buffer":0,"byteOffset":88,"byteLength":16},{"buffer":0,"byteOffset":104,"byteLength":128},{"buffer":0,"byteOffset":232,"byteLength":4},
{"buffer":0,"byteOffset":236,"byteLength":8},{"buffer":0,"byteOffset":244,"byteLength":32},{"buffer":0,"byteOffset":276,"byteLength":72}],
"buffers":[{BUFFER"byteLength":348}]}"#;

type Outcome = Result<(), Box<dyn Error>>;

fn seed(target: &str, name: &str, content: impl AsRef<[u8]>) -> Outcome {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    std::fs::create_dir_all(&folder)?;
    Ok(std::fs::write(folder.join(name), content)?)
}

fn picture(format: ImageFormat) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = Cursor::new(Vec::new());
    RgbImage::from_fn(4, 3, |x, y| Rgb([60 * x as u8, 80 * y as u8, 128])).write_to(&mut bytes, format)?;
    Ok(bytes.into_inner())
}

/// Positions and indices.
fn tetrahedron() -> Vec<u8> {
    let floats = POSITIONS.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    floats.chain(FACES.as_flattened().iter().flat_map(|i| i.to_le_bytes())).collect()
}

/// The tetrahedron, then texture coordinates.
fn textured() -> Vec<u8> {
    tetrahedron().into_iter().chain([0.5f32; 8].into_iter().flat_map(f32::to_le_bytes)).collect()
}

/// The tetrahedron; joints, weights and inverse bind matrices; sparse indices; times, rotations, and a spline
/// of translations.
fn deforming() -> Vec<u8> {
    let identity = [1.0f32, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let joints = [0, 1, 0, 0].repeat(4).into_iter().chain([128, 127, 0, 0].repeat(4));
    let keys = [0.0f32, 1.0].into_iter().chain([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).chain([0.25; 18]);
    let matrices = identity.repeat(2).into_iter().flat_map(f32::to_le_bytes);
    tetrahedron()
        .into_iter()
        .chain(joints)
        .chain(matrices)
        .chain([1, 3, 0, 0])
        .chain(keys.flat_map(f32::to_le_bytes))
        .collect()
}

/// `json`, whose BUFFER stands for the place of `buffer`, as text and as binary.
fn text_and_binary(json: &str, buffer: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let uri = format!("\"uri\":\"data:application/octet-stream;base64,{}\",", base64(buffer));
    let text = json.replace("BUFFER", &uri).into_bytes();
    let mut json = json.replace("BUFFER", "").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind, bytes].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", buffer)].concat();
    (text, [b"glTF", &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks[..]].concat())
}

fn base64(bytes: &[u8]) -> String {
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

fn gltf() -> Outcome {
    let image = format!("\"uri\":\"data:image/png;base64,{}\"", base64(&picture(ImageFormat::Png)?));
    for (name, json, buffer) in [
        ("mode", GLTF.replace("IMAGE", &image), textured()),
        ("deforming", DEFORMING.to_owned(), deforming()),
    ] {
        let (text, glb) = text_and_binary(&json, &buffer);
        for (mode, file) in [(0, &text), (1, &glb), (2, &text), (3, &glb)] {
            seed("gltf", &format!("{name}-{mode}"), [&[mode], &file[..]].concat())?;
        }
    }
    Ok(())
}

fn environments() -> Outcome {
    let mut bytes = Cursor::new(Vec::new());
    Rgb32FImage::from_fn(8, 4, |x, y| Rgb([x as f32, y as f32, 0.5]))
        .write_to(&mut bytes, ImageFormat::Hdr)?;
    seed("environment_hdr", "sky", bytes.into_inner())?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/environment_exr");
    std::fs::create_dir_all(&folder)?;
    exr::prelude::write_rgb_file(folder.join("sky"), 8, 4, |x, y| (x as f32, y as f32, 0.5f32))?;
    Ok(())
}

fn library() -> Outcome {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../library"))? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            seed(
                "scene_toml",
                &entry.file_name().to_string_lossy(),
                std::fs::read(entry.path().join("scene.toml"))?,
            )?;
        }
    }
    Ok(())
}

fn main() -> Outcome {
    seed("obj", "tetrahedron", OBJ)?;
    seed("off", "tetrahedron", OFF)?;
    seed("ply", "text", PLY)?;
    let faces = FACES.iter().flat_map(|f| [3].into_iter().chain(f.iter().flat_map(|i| i.to_le_bytes())));
    let binary =
        PLY_BINARY.bytes().chain(POSITIONS.as_flattened().iter().flat_map(|x| x.to_le_bytes())).chain(faces);
    seed("ply", "binary", binary.collect::<Vec<u8>>())?;
    seed("texture", "png", picture(ImageFormat::Png)?)?;
    seed("texture", "jpeg", picture(ImageFormat::Jpeg)?)?;
    gltf()?;
    environments()?;
    library()
}
