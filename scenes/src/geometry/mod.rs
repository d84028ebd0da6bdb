//! Triangle geometry: from files and shapes, in their own spaces, to one clean [`Mesh`] in world space.

mod builder;
mod gltf_buffers;
mod gltf_file;
mod normals;
mod obj_file;

pub(crate) use builder::{MeshBuilder, Part};

use crate::library::has_extension;
use crate::scene::Mesh;
use glam::DAffine3;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Largest geometry file that is read.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Largest number of vertices, and of triangles, in one object: their index must fit the tracer's 32 bits with room to spare.
const MAX_ELEMENTS: usize = 1 << 26;

/// Reads the geometry of `path` (of one glTF node if `node` is given) into world space. Adds what was mended to `warnings`.
pub(crate) fn load_file(path: &Path, node: Option<&str>, world_from_file: &DAffine3, warnings: &mut Vec<String>) -> Result<Mesh> {
    let place = Place::file(path);
    let mut builder = MeshBuilder::default();
    if has_extension(path, "gltf") || has_extension(path, "glb") {
        gltf_file::append(&mut builder, path, node, world_from_file)?;
    } else if !has_extension(path, "obj") {
        return Err(Error::unsupported(&place, "not a geometry file this version reads; it reads .gltf, .glb and .obj"));
    } else if let Some(node) = node {
        return Err(Error::invalid(&place, format!("node `{node}` is named, but an OBJ file has no nodes; remove `node`")));
    } else {
        obj_file::append(&mut builder, path, world_from_file)?;
    }
    builder.finish(&place, warnings)
}

/// Reads a file of bounded size.
fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let place = Place::file(path);
    let length = std::fs::metadata(path).map_err(|e| Error::io(&place, e))?.len();
    if length > MAX_FILE_BYTES {
        return Err(Error::invalid(&place, format!("{length} bytes, more than the {MAX_FILE_BYTES} that a geometry file may have")));
    }
    std::fs::read(path).map_err(|e| Error::io(&place, e))
}

#[cfg(test)]
mod tests;
