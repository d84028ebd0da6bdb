//! `[[object]]`: a mesh, from a file or a shape, and its material.

use super::imported::ImportedObject;
use super::{Context, expect_unique};
use crate::description::ObjectFile;
use crate::geometry::{self, Deforming, MeshBuilder, is_gltf};
use crate::library::{expect_file, locate};
use crate::scene::{MAX_SPHERES, Material, Object};
use crate::shapes::{Shape, Twist};
use crate::suggest::Names;
use glam::DAffine3;
use relume_formats::kinds::manifest::is_plain_name;
use relume_formats::name::shortened;
use relume_formats::shape::DeformingMesh;
use relume_formats::{Error, Place, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Every object, in file order. `imported` gives the objects that stand for an `[[object]]` without a
/// material, by its index.
pub(super) fn build(
    files: &[ObjectFile],
    mut imported: Vec<Vec<ImportedObject>>,
    materials: &[Material],
    context: &mut Context<'_>,
) -> Result<Vec<Object>> {
    let names = Names::new("material", materials.iter().map(|m| m.name.as_str()));
    // Cheap mistakes first, before any mesh is read.
    let index = |file: &ObjectFile| {
        let name = file.material.as_ref();
        name.map(|name| names.index_of(name, &place_of(file, context))).transpose()
    };
    let indices = files.iter().map(index).collect::<Result<Vec<_>>>()?;
    let mut objects = Vec::new();
    for (position, (file, material)) in files.iter().zip(indices).enumerate() {
        let place = place_of(file, context);
        if let Some(material) = material {
            let Deforming { rest, shape } = geometry_of(file, &place, context)?;
            if file.shape.is_none() {
                context.room.take(rest.positions.len() as u64, rest.triangles.len() as u64, &place)?;
            }
            let shape = Some(shape).filter(|shape| !shape.clips.is_empty()).map(Arc::new);
            if let Some(shape) = &shape {
                expect_file_name(file, "that deforms", &place)?;
                shape.validate(&place)?;
            }
            objects.push(Object {
                name: file.name.clone(),
                material,
                mesh: Arc::new(rest),
                shape,
                spheres: file.spheres,
            });
        }
        for part in imported.get_mut(position).map(std::mem::take).unwrap_or_default() {
            let material = names.index_of(&part.material, &place)?;
            objects.push(Object {
                material,
                name: part.name,
                mesh: part.mesh,
                shape: None,
                spheres: file.spheres,
            });
        }
    }
    expect_unique(objects.iter().map(|o| o.name.as_str()), "object", &context.place)?;
    objects.iter().try_for_each(|object| expect_uvs(object, materials, &context.place))?;
    Ok(objects)
}

/// Checks what can be checked before any file is read.
pub(super) fn check(files: &[ObjectFile], context: &mut Context<'_>) -> Result<()> {
    if files.is_empty() {
        return Err(Error::invalid(&context.place, "the scene has no object; add an [[object]]"));
    }
    expect_unique(files.iter().map(|o| o.name.as_str()), "object", &context.place)?;
    for file in files {
        let place = place_of(file, context);
        if file.file.is_some() == file.shape.is_some() {
            return Err(Error::invalid(&place, "give either `file` or `shape`"));
        }
        if let Some(stranger) = file.given_parameters().next().filter(|_| file.shape.is_none()) {
            return Err(Error::invalid(
                &place,
                format!("`{stranger}` belongs to a shape, but the object is a file; remove it"),
            ));
        }
        if file.node.is_some() && file.shape.is_some() {
            return Err(Error::invalid(&place, "`node` belongs to a glTF file, but the object is a shape"));
        }
        if let (Some(node), Some(name)) = (&file.node, &file.file)
            && !is_gltf(Path::new(name))
        {
            let reason = format!(
                "node `{}` is named, but only a glTF file has nodes, and `{name}` is none; remove `node`",
                shortened(node)
            );
            return Err(Error::invalid(&place, reason));
        }
        if file.lights.is_some() && file.material.is_some() {
            return Err(Error::invalid(
                &place,
                "`lights` belongs to a glTF file that brings its materials; remove it, or `material`",
            ));
        }
        file.transform.expect_extent(&place)?;
        check_crease(file, &place)?;
        check_spheres(file, &place)?;
        check_twist(file, &place, context.shapes_vary)?;
        if let Some(shape) = file.shape {
            let shape = Shape::from_object(shape, file, &place)?;
            context.room.take(shape.vertices(), shape.triangles(), &place)?;
        }
    }
    Ok(())
}

fn check_crease(file: &ObjectFile, place: &Place) -> Result<()> {
    match file.crease_deg {
        Some(_) if file.shape.is_some() => Err(Error::invalid(
            place,
            "`crease_deg` belongs to a file without normals, but the object is a shape; remove it",
        )),
        Some(angle) if !(0.0..=180.0).contains(&angle) => Err(Error::invalid(
            place,
            format!("crease_deg {angle} is outside 0..180; 0 makes every face flat, 180 everything smooth"),
        )),
        _ => Ok(()),
    }
}

fn check_twist(file: &ObjectFile, place: &Place, shapes_vary: bool) -> Result<()> {
    let given = [("twist_deg", file.twist_deg), ("twist_s", file.twist_s)]
        .into_iter()
        .find(|(_, value)| value.is_some());
    match given {
        Some((name, _)) if file.shape.is_none() => Err(Error::invalid(
            place,
            format!("`{name}` belongs to a shape, but the object is a file; remove it"),
        )),
        Some(_) if !shapes_vary => Err(Error::invalid(
            place,
            "twists, but nothing deforms; add shape = true to [vary], or remove twist_deg and twist_s",
        )),
        Some(_) => {
            expect_file_name(file, "that deforms", place)?;
            Twist::from_keys(file.twist_deg, file.twist_s, place).map(drop)
        }
        None => Ok(()),
    }
}

/// A file is made of the set.
fn check_spheres(file: &ObjectFile, place: &Place) -> Result<()> {
    let refuse = |reason: String| Err(Error::invalid(place, reason));
    match file.spheres {
        None => Ok(()),
        Some(n) if !(1..=MAX_SPHERES).contains(&n) => {
            refuse(format!("spheres {n} is outside 1..{MAX_SPHERES}"))
        }
        Some(_) => expect_file_name(file, "with `spheres`", place),
    }
}

/// Files of a bundle are called after some objects.
fn expect_file_name(file: &ObjectFile, which: &str, place: &Place) -> Result<()> {
    if is_plain_name(&file.name) {
        return Ok(());
    }
    let reason = format!(
        "the name of an object {which} has only a-z A-Z 0-9 . _ - and blanks, as a file is called after it; rename it"
    );
    Err(Error::invalid(place, reason))
}

pub(super) fn place_of(file: &ObjectFile, context: &Context<'_>) -> Place {
    context.place.part(format!("object `{}`", file.name))
}

/// The path of the file that an object names, which is there.
pub(super) fn path_of(name: &str, place: &Place, context: &Context<'_>) -> Result<PathBuf> {
    let path = locate(context.folder, name);
    expect_file(&path, name, place)?;
    Ok(path)
}

/// The mesh of an object, and what moves it; a shape without clips if nothing does.
fn geometry_of(object: &ObjectFile, place: &Place, context: &mut Context<'_>) -> Result<Deforming> {
    let world_from_local = object.transform.world_from_local(place)?;
    let Some(name) = &object.file else { return procedural(object, &world_from_local, place, context) };
    let (path, node) = (path_of(name, place, context)?, object.node.as_deref());
    if context.shapes_vary && is_gltf(&path) {
        return geometry::load_placed(
            &path,
            node,
            &world_from_local,
            object.crease_deg,
            &mut context.warnings,
        );
    }
    let rest = geometry::load_file(&path, node, &world_from_local, object.crease_deg, &mut context.warnings)?;
    Ok(Deforming { rest, shape: DeformingMesh::default() })
}

fn procedural(
    object: &ObjectFile,
    world_from_local: &DAffine3,
    place: &Place,
    context: &mut Context<'_>,
) -> Result<Deforming> {
    let shape = object.shape.ok_or_else(|| Error::invalid(place, "give either `file` or `shape`"))?;
    let part = Shape::from_object(shape, object, place)?.part();
    let mut builder = MeshBuilder::default();
    builder.append(&part, world_from_local, place)?;
    let (rest, origins) = builder.finish_and_tell(place, &mut context.warnings)?;
    let Some(twist) = Twist::from_keys(object.twist_deg, object.twist_s, place)? else {
        return Ok(Deforming { rest, shape: DeformingMesh::default() });
    };
    let kept = origins.iter().filter_map(|vertex| part.positions.get(*vertex as usize).copied());
    let shape = twist.apply(kept.collect(), world_from_local, place)?;
    Ok(Deforming { rest, shape })
}

/// A texture lies somewhere only where there are texture coordinates.
fn expect_uvs(object: &Object, materials: &[Material], place: &Place) -> Result<()> {
    match materials.get(object.material) {
        Some(material) if material.texture.is_some() && object.mesh.uvs.is_empty() => {
            let reason = format!(
                "its material `{}` has a texture, but its mesh has no texture coordinates; export it with some, or remove the texture",
                material.name
            );
            Err(Error::invalid(&place.part(format!("object `{}`", object.name)), reason))
        }
        _ => Ok(()),
    }
}
