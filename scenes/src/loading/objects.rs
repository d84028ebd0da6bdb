//! `[[object]]`: a mesh, from a file or a shape, and its material.

use super::{expect_unique, index_of};
use crate::description::ObjectFile;
use crate::geometry::{self, MeshBuilder};
use crate::library::{expect_file, locate};
use crate::scene::{Mesh, Object};
use crate::shapes::Shape;
use relume_formats::{Error, Place, Result};
use std::path::Path;
use std::sync::Arc;

/// Every object, in file order.
pub(super) fn build(
    files: &[ObjectFile],
    materials: &[&str],
    folder: &Path,
    scene_place: &Place,
    warnings: &mut Vec<String>,
) -> Result<Vec<Object>> {
    if files.is_empty() {
        return Err(Error::invalid(scene_place, "the scene has no object; add an [[object]]"));
    }
    expect_unique(files.iter().map(|o| o.name.as_str()), "object", scene_place)?;
    // Cheap mistakes first, before any mesh is read.
    let indices = files.iter().map(|o| index_of(&o.material, "material", materials, &object_place(o, scene_place)));
    let indices = indices.collect::<Result<Vec<_>>>()?;
    let object = |(file, material): (&ObjectFile, usize)| {
        let mesh = mesh(file, folder, &object_place(file, scene_place), warnings)?;
        Ok(Object { name: file.name.clone(), material, mesh: Arc::new(mesh) })
    };
    files.iter().zip(indices).map(object).collect()
}

fn object_place(file: &ObjectFile, scene_place: &Place) -> Place {
    scene_place.part(format!("object `{}`", file.name))
}

fn mesh(object: &ObjectFile, folder: &Path, place: &Place, warnings: &mut Vec<String>) -> Result<Mesh> {
    let world_from_local = object.transform.world_from_local(place)?;
    match (&object.file, object.shape) {
        (Some(name), None) => {
            if let Some(stranger) = object.given_parameters().next() {
                return Err(Error::invalid(place, format!("`{stranger}` belongs to a shape, but the object is a file; remove it")));
            }
            let path = locate(folder, name);
            expect_file(&path, name, place)?;
            geometry::load_file(&path, object.node.as_deref(), &world_from_local, warnings)
        }
        (None, Some(_)) if object.node.is_some() => Err(Error::invalid(place, "`node` belongs to a glTF file, but the object is a shape")),
        (None, Some(shape)) => {
            let mut builder = MeshBuilder::default();
            builder.append(&Shape::from_object(shape, object, place)?.part(), &world_from_local, place)?;
            builder.finish(place, warnings)
        }
        _ => Err(Error::invalid(place, "give either `file` or `shape`")),
    }
}
