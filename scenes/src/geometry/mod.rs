//! Triangle geometry: from files and shapes, in their own spaces, to one clean [`Mesh`] in world space.

mod builder;
mod concave;
mod gltf_buffers;
mod gltf_clips;
mod gltf_container;
mod gltf_deforming;
mod gltf_file;
mod gltf_instances;
mod gltf_json;
mod gltf_materials;
mod gltf_nodes;
mod gltf_primitives;
mod gltf_skins;
mod gltf_uris;
mod normals;
mod obj_file;
mod off_file;
mod ply_body;
mod ply_file;
mod ply_header;
mod polygons;
mod text;

pub(crate) use builder::{MeshBuilder, Part};
pub(crate) use gltf_deforming::load_placed;
pub use gltf_deforming::{Deforming, load_deforming};
pub(crate) use gltf_file::{GltfFile, MaterialPart};
pub(crate) use gltf_materials::{GltfMaterial, MaterialReader, tidy_name};
pub(crate) use gltf_nodes::PlacedNode;
pub(crate) use normals::DEFAULT_CREASE_DEG;

use crate::scene::Mesh;
use glam::DAffine3;
use relume_formats::has_extension;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Largest number of vertices, and of triangles, in one object: their index must fit the tracer's 32 bits
/// with room to spare.
const MAX_ELEMENTS: usize = 1 << 26;

/// Reads the geometry of `path` (of a glTF file only that of `node`, if given) into world space, with the
/// crease angle that the scene gives for faces without normals. Adds what was mended to `warnings`.
pub(crate) fn load_file(
    path: &Path,
    node: Option<&str>,
    world_from_file: &DAffine3,
    crease_deg: Option<f64>,
    warnings: &mut Vec<String>,
) -> Result<Mesh> {
    let place = Place::file(path);
    let mut builder = MeshBuilder::with_crease(crease_deg);
    if is_gltf(path) {
        let file = GltfFile::open(path, warnings)?;
        file.append(&file.nodes(node, world_from_file, warnings)?, &mut builder, |_, _| Ok(()))?;
        return builder.finish(&place, warnings);
    }
    let append = match extension_of(path).as_str() {
        "obj" => obj_file::append,
        "ply" => ply_file::append,
        "off" => off_file::append,
        _ => {
            return Err(Error::unsupported(
                &place,
                "not a geometry file this version reads; it reads .gltf, .glb, .obj, .ply and .off",
            ));
        }
    };
    append(&mut builder, path, world_from_file)?;
    builder.finish(&place, warnings)
}

/// Reads any geometry file that a scene may name: glTF, OBJ, PLY or OFF, where it lies and as it rests. Adds
/// what was mended to `warnings`.
///
/// # Errors
/// `Io` if the file cannot be read, `Unsupported` if it is of another kind, `Invalid` if it breaks the rules
/// of its own.
pub fn load_mesh(path: &Path, warnings: &mut Vec<String>) -> Result<Mesh> {
    load_file(path, None, &DAffine3::IDENTITY, None, warnings)
}

/// True if `path` is called as a glTF file.
pub(crate) fn is_gltf(path: &Path) -> bool {
    has_extension(path, "gltf") || has_extension(path, "glb")
}

fn extension_of(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod polygon_file_tests;

#[cfg(test)]
mod ply_off_tests;

#[cfg(test)]
mod obj_file_tests;

#[cfg(test)]
mod normals_tests;

#[cfg(test)]
mod deforming_tests;

#[cfg(test)]
mod interchange_tests;

#[cfg(test)]
mod gltf_nodes_tests;
