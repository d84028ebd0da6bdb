//! Wavefront OBJ. All objects and groups of a file are one mesh; its materials are ignored.

use super::{MAX_ELEMENTS, MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;
use std::path::Path;

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    check_faces(&bytes, &place)?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    // A slice is a reader that knows how far it has come: what is left gives the line of an error.
    let mut rest: &[u8] = &bytes;
    let no_materials = |_: &Path| Ok((Vec::new(), HashMap::default()));
    let (models, _) = tobj::load_obj_buf(&mut rest, &options, no_materials).map_err(|e| {
        let read = bytes.get(..bytes.len() - rest.len()).unwrap_or_default();
        Error::invalid(&place.part(format!("line {}", line_count(read))), format!("{e}; mend or export the file again"))
    })?;
    for model in models {
        let place = place.part(format!("group `{}`", model.name));
        builder.append(&part(&model.mesh), world_from_file, &place)?;
    }
    Ok(())
}

fn part(mesh: &tobj::Mesh) -> Part {
    let positions: Vec<[f32; 3]> = mesh.positions.as_chunks().0.to_vec();
    // If only some corners name a normal or texture coordinates, which are whose is lost; the builder makes new ones.
    let complete = mesh.normals.len() == mesh.positions.len();
    let normals = if complete { mesh.normals.as_chunks().0.to_vec() } else { Vec::new() };
    let complete = mesh.texcoords.len() / 2 == positions.len();
    // OBJ's v goes up from the image's last row.
    let uvs = if complete { mesh.texcoords.as_chunks().0.iter().map(|[u, v]| [*u, 1.0 - v]).collect() } else { Vec::new() };
    Part { positions, normals, uvs, triangles: mesh.indices.as_chunks().0.to_vec() }
}

fn line_count(text: &[u8]) -> usize {
    text.split_inclusive(|b| *b == b'\n').count()
}

/// Refuses what the parser would allocate or compute without bounds: polygons in excess, indices of absurd length, and negative ones that count back
/// beyond the first vertex.
fn check_faces(bytes: &[u8], place: &Place) -> Result<()> {
    let mut corners = 0;
    // How many positions, texture coordinates and normals there have been, as the indices of a corner name them.
    let mut counts = [0_i64; 3];
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => counts[0] += 1,
            Some(b"vt") => counts[1] += 1,
            Some(b"vn") => counts[2] += 1,
            Some(b"f" | b"l") => {
                for word in words {
                    corners += 1;
                    let mut indices = word.split(|b| *b == b'/').zip(counts);
                    if indices.any(|(index, count)| index.len() > 10 || number_of(index).is_some_and(|i| i < -count)) {
                        return Err(Error::invalid(&place.part(format!("line {}", number + 1)), "face index out of bounds; mend the file"));
                    }
                }
            }
            _ => {}
        }
    }
    if corners > 3 * MAX_ELEMENTS {
        return Err(Error::invalid(place, format!("more than {MAX_ELEMENTS} triangles in one file; split or simplify it")));
    }
    Ok(())
}

fn number_of(text: &[u8]) -> Option<i64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}
