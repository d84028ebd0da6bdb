//! Where textures that are painted on a material lie on the surfaces that wear it, and the regions of them in
//! which light is baked.
//!
//! All surfaces of a material share one square of texture coordinates. Those of the meshes serve if every point of
//! the surfaces has a place of its own there; else an atlas is made of them.

mod atlas;
mod cover;

use crate::scene::Scene;
use cover::Cover;
use relume_formats::{Place, Result};
use std::collections::BTreeMap;

/// Regions along each side of the square.
pub const REGIONS: u32 = 32;

/// Cells along each side of the square, by which surfaces are told to overlap: a thousandth of it.
const CELLS: u32 = 1024;
/// How many of the cells that are covered may be so twice: where charts touch.
const OVERLAPPING: f64 = 0.001;
/// What part of the square is covered at least: of less, regions and texels are wasted.
const COVERED: f64 = 0.01;
/// How far outside the square coordinates may be, for they are rounded.
const OUTSIDE: f32 = 1e-4;
/// How much of the surface may have no area in the square: slivers.
const WITHOUT_AREA: f64 = 0.001;

/// Texture coordinates of the corners of a triangle.
pub type Corners = [[f32; 2]; 3];

/// Texture coordinates of all surfaces that wear a material: within the unit square, (0, 0) the upper left corner
/// of a texture.
#[derive(Debug, Clone, PartialEq)]
pub struct Painting {
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Of each object that wears the material, by its number, those of all its triangles.
    objects: BTreeMap<usize, Vec<Corners>>,
}

impl Painting {
    /// The coordinates that the meshes have of what wears `material` in `scene`.
    ///
    /// # Errors
    /// Why they do not serve, as part of a sentence.
    pub fn of_meshes(scene: &Scene, material: usize) -> std::result::Result<Self, String> {
        let objects = wearing(scene, material);
        let corners = of_meshes(scene, &objects)?;
        Ok(Self { material, objects: objects.into_iter().zip(corners).collect() })
    }

    /// Those of an atlas. `goes_on` is told how many triangles have been laid out, now and then, and says whether to
    /// go on; `None` if it does not.
    ///
    /// # Errors
    /// `Invalid` with the remedy if none can be made.
    pub fn of_atlas(
        scene: &Scene,
        material: usize,
        goes_on: impl Fn(usize) -> bool + Sync,
    ) -> Result<Option<Self>> {
        let objects = wearing(scene, material);
        let meshes: Vec<_> = objects.iter().map(|number| &*scene.objects[*number].mesh).collect();
        let name = &scene.materials[material].name;
        let place = Place::file(&scene.file).part(format!("material `{name}`"));
        let corners = atlas::make(&meshes, &goes_on, &place)?;
        Ok(corners.map(|corners| Self { material, objects: objects.into_iter().zip(corners).collect() }))
    }

    /// Whether no object wears the material.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// Where a point of a triangle of object number `object` is, by the weights of its second and third corner;
    /// `None` if that wears another material.
    pub fn at(&self, object: usize, triangle: usize, barycentric: [f32; 2]) -> Option<[f32; 2]> {
        self.of_object(object)?.get(triangle).map(|corners| within(corners, barycentric))
    }

    /// Of all triangles of object number `object`; `None` if that wears another material.
    pub fn of_object(&self, object: usize) -> Option<&[Corners]> {
        self.objects.get(&object).map(Vec::as_slice)
    }

    /// Whether the middle of each of `side` × `side` cells of the square is on a surface, row by row.
    pub fn covered(&self, side: u32) -> Vec<bool> {
        let mut cover = Cover::new(side);
        self.objects.values().flatten().for_each(|corners| cover.add(corners));
        cover.counts.iter().map(|count| *count > 0).collect()
    }
}

/// Where a point of a triangle is, by the weights of its second and third corner.
pub fn within([a, b, c]: &Corners, [v, w]: [f32; 2]) -> [f32; 2] {
    std::array::from_fn(|k| (a[k] + (b[k] - a[k]) * v + (c[k] - a[k]) * w).clamp(0.0, 1.0))
}

/// The number of the region that `uv` is in, row by row.
pub fn region_of(uv: [f32; 2]) -> u32 {
    let [column, row] = uv.map(|x| ((x * REGIONS as f32) as u32).min(REGIONS - 1));
    row * REGIONS + column
}

/// Numbers of the objects that wear `material`.
fn wearing(scene: &Scene, material: usize) -> Vec<usize> {
    let worn = scene.objects.iter().enumerate().filter(|(_, object)| object.material == material);
    worn.map(|(number, _)| number).collect()
}

/// The coordinates that the meshes of `objects` have, or why they do not serve.
fn of_meshes(scene: &Scene, objects: &[usize]) -> std::result::Result<Vec<Vec<Corners>>, String> {
    let mut cover = Cover::new(CELLS);
    let (mut all, mut without_area) = (0.0, 0.0);
    let mut of_objects = Vec::new();
    for number in objects {
        let object = &scene.objects[*number];
        let (name, mesh) = (&object.name, &object.mesh);
        if mesh.uvs.is_empty() {
            return Err(format!("`{name}` has none"));
        }
        let mut triangles = Vec::with_capacity(mesh.triangles.len());
        for triangle in &mesh.triangles {
            let corners = triangle.map(|vertex| mesh.uvs[vertex as usize]);
            if !corners.as_flattened().iter().all(|x| (-OUTSIDE..=1.0 + OUTSIDE).contains(x)) {
                return Err(format!("those of `{name}` leave the square from 0 to 1"));
            }
            let area = area(triangle.map(|vertex| mesh.positions[vertex as usize]));
            all += area;
            without_area += if cover::signed_area(&corners) == 0.0 { area } else { 0.0 };
            cover.add(&corners);
            // Of the whole square: the first triangles of a mesh do not decide, and no mesh covers it for ever.
            if cover.twice() > OVERLAPPING {
                return Err(format!("those of `{name}` overlap with others"));
            }
            triangles.push(corners);
        }
        of_objects.push(triangles);
    }
    if cover.twice() > OVERLAPPING * cover.once() {
        return Err("some overlap with others".to_owned());
    }
    if cover.once() < COVERED && !objects.is_empty() {
        return Err("they take up less than a hundredth of the square from 0 to 1".to_owned());
    }
    if without_area > WITHOUT_AREA * all {
        return Err("they leave some surfaces without any texels".to_owned());
    }
    Ok(of_objects)
}

/// Square metres.
fn area(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| glam::DVec3::from(corner.map(f64::from)));
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests;
