//! What must agree between the files of the method sphere-shadows.

use super::sound;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::manifest::{Manifest, MethodEntry, shape_file};
use relume_formats::kinds::scene::StoredShape;
use relume_formats::kinds::sphere_shadows::{NO_ROW, ShadowObject};
use relume_formats::kinds::{Environment, SphereShadows, StoredScene, Textures};
use relume_formats::shape::DeformingMesh;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// How far a normal of a row may be from that of its receiver, for roundings.
const TOLERANCE: f32 = 1e-5;

/// Checks the files of `method`; returns a line for each, and the names of the environment maps.
pub(super) fn verify(
    method: &MethodEntry,
    manifest: &Manifest,
    scene: &StoredScene,
    folder: &Path,
    place: &Place,
) -> Result<(String, Vec<String>)> {
    expect_order(method, scene, place)?;
    let mut lines = String::new();
    let mut maps = Vec::new();
    let mut shapes = Vec::new();
    let mut shadows = None;
    for (kind, entry) in &method.files {
        let place = Place::file(folder.join(&entry.file));
        match Kind::ALL.into_iter().find(|k| k.name() == kind) {
            Some(Kind::Environment) => maps.push(Environment::read_file(&place.file)?.name),
            Some(Kind::Textures) => {
                Textures::read_file(&place.file)?.expect_scene(scene.positions.len(), scene.meta.materials.len(), &place)?;
            }
            Some(Kind::Shape) => shapes.push((DeformingMesh::read_file(&place.file)?, place.clone())),
            _ => shadows = Some((SphereShadows::read_file(&place.file)?, place.clone())),
        }
        lines += &sound(&place.file)?;
    }
    super::expect_maps(&maps, scene, place)?;
    if let Some((shadows, place)) = shadows {
        expect_receivers(&shadows, manifest, scene, &place)?;
        for ((shape, place), stored) in shapes.iter().zip(&scene.meta.shapes) {
            let object = shadows.meta.objects.iter().find(|object| object.name == stored.object);
            object.map_or(Ok(()), |object| expect_shape(shape, object, stored, scene, place))?;
        }
    }
    Ok((lines, maps))
}

/// A player needs light, textures and shapes before the receivers; shapes stand in the order of the objects.
fn expect_order(method: &MethodEntry, scene: &StoredScene, place: &Place) -> Result<()> {
    let files: Vec<(&str, &str)> = method.files.iter().map(|(kind, entry)| (kind.as_str(), entry.file.as_str())).collect();
    let environments = files.iter().take_while(|(kind, _)| *kind == Kind::Environment.name()).count();
    let rest = &files[environments..];
    let textured = rest.first().is_some_and(|(kind, _)| *kind == Kind::Textures.name());
    let rest = &rest[usize::from(textured)..];
    let names: Vec<String> = scene.meta.shapes.iter().map(|shape| shape_file(&shape.object)).collect();
    let shapes = names.iter().map(|name| (Kind::Shape.name(), name.as_str()));
    let is_main = |file: &(&str, &str)| file.0 == Kind::SphereShadows.name();
    let in_order = rest.split_last().is_some_and(|(main, before)| is_main(main) && before.iter().copied().eq(shapes));
    if environments > 0 && in_order {
        return Ok(());
    }
    let names = if names.is_empty() { "no shapes".to_owned() } else { names.join(", ") };
    let reason = format!("its files are not environments, perhaps textures, {names}, and sphere-shadows, in this order; bake it again");
    Err(Error::invalid(place, reason))
}

/// The receivers are the vertices of the scene, their objects those of scene and manifest, and exact rows have their normals.
fn expect_receivers(shadows: &SphereShadows, manifest: &Manifest, scene: &StoredScene, place: &Place) -> Result<()> {
    let refuse = |reason: String| Err(Error::invalid(place, format!("{reason}; bake it again")));
    let (rows, vertices) = (shadows.rows.len(), scene.positions.len());
    if rows != vertices {
        return refuse(format!("{rows} receivers, the scene has {vertices} vertices"));
    }
    if !shadows.meta.objects.iter().map(|o| &o.name).eq(scene.meta.objects.iter().map(|o| &o.name)) {
        return refuse("its objects are not those of the scene, in their order".to_owned());
    }
    for object in &shadows.meta.objects {
        let name = &object.name;
        if object.sphere_set != manifest.sphere_sets.contains_key(name) {
            return refuse(format!("object `{name}` has a sphere set here or in the manifest, but not in both"));
        }
        if object.deforms != scene.meta.shapes.iter().any(|shape| shape.object == *name) {
            return refuse(format!("object `{name}` deforms here or in the scene, but not in both"));
        }
    }
    let mut first_triangle = 0;
    for (object, stored) in shadows.meta.objects.iter().zip(&scene.meta.objects) {
        let own = object.first_vertex..object.first_vertex + object.vertices;
        let end = first_triangle + stored.triangles as usize;
        let triangles = scene.triangles.get(first_triangle..end).unwrap_or_default();
        if triangles.as_flattened().iter().any(|vertex| !own.contains(vertex)) {
            return refuse(format!("object `{}` has other vertices than in the scene", object.name));
        }
        first_triangle = end;
    }
    let is_near = |row: &[f32; 3], normal: &[f32; 3]| row.iter().zip(normal).all(|(a, b)| (a - b).abs() <= TOLERANCE);
    let exact = shadows.rows.iter().zip(&scene.normals).enumerate().filter(|(_, (row, _))| **row != NO_ROW);
    let mut wrong = exact.filter(|(_, (row, normal))| !shadows.normals.get(**row as usize).is_some_and(|n| is_near(n, normal)));
    wrong.next().map_or(Ok(()), |(vertex, _)| refuse(format!("vertex {vertex} has a row of another normal than its own")))
}

/// A shape rests where its object does, and shows what the scene says.
fn expect_shape(shape: &DeformingMesh, object: &ShadowObject, stored: &StoredShape, scene: &StoredScene, place: &Place) -> Result<()> {
    let refuse = |reason: String| Err(Error::invalid(place, format!("{reason}; bake it again")));
    let clips = shape.clips.iter().map(|clip| (&clip.name, clip.duration_s));
    if !clips.eq(stored.clips.iter().map(|clip| (&clip.name, clip.duration_s))) {
        return refuse(format!("its clips are not those that the scene lists of object `{}`", object.name));
    }
    let mut rest = Vec::new();
    shape.positions(&shape.rest_pose(), &mut rest);
    let first = object.first_vertex as usize;
    let here = scene.positions.get(first..first + object.vertices as usize).unwrap_or_default();
    if rest.len() != here.len() {
        return refuse(format!("{} vertices, object `{}` has {}", rest.len(), object.name, here.len()));
    }
    let extent = here.as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
    let is_off = |(a, b): (&f32, &f32)| (a - b).abs() > TOLERANCE * extent;
    match rest.as_flattened().iter().zip(here.as_flattened()).position(is_off) {
        None => Ok(()),
        Some(at) => refuse(format!("vertex {} does not rest where object `{}` has it", at / 3, object.name)),
    }
}
