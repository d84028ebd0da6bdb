//! Sphere sets, receivers and shapes against the scene.

use super::refuse;
use crate::error::{Place, Result};
use crate::kinds::scene::StoredShape;
use crate::kinds::sphere_shadows::{NO_ROW, ShadowObject};
use crate::kinds::{SphereSet, SphereShadows, StoredScene};
use crate::shape::DeformingMesh;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// How far a normal of a row may be from that of its receiver, and a shape at rest from its object in parts
/// of the largest coordinate, for roundings.
const TOLERANCE: f32 = 1e-5;
/// Most pairs of spheres of one set, summed over the sets of a bundle: players keep which of them overlap.
pub const MAX_SPHERE_PAIRS: u64 = 1 << 27;

/// The vertices of each object of a scene, and the sphere sets so far.
#[derive(Debug, Clone)]
pub struct Objects {
    vertices: HashMap<String, Range<usize>>,
    sets: HashSet<String>,
    pairs: u64,
}

impl Objects {
    /// Those of `scene`. Objects follow each other, and use all of their vertices.
    pub fn new(scene: &StoredScene) -> Self {
        let mut first = 0;
        let range = |object: &crate::kinds::scene::StoredObject| {
            let end = first + object.triangles as usize;
            let indices = scene.triangles.get(first..end).unwrap_or_default().as_flattened();
            first = end;
            let (low, high) =
                indices.iter().fold((u32::MAX, 0), |(low, high), index| (low.min(*index), high.max(*index)));
            (object.name.clone(), if indices.is_empty() { 0..0 } else { low as usize..high as usize + 1 })
        };
        Self { vertices: scene.meta.objects.iter().map(range).collect(), sets: HashSet::new(), pairs: 0 }
    }

    /// Adds the sphere set at `place`, which the manifest lists for `object`.
    ///
    /// # Errors
    /// Unless its vertices are those of the object in `scene`, or if there are too many spheres.
    pub fn add_set(
        &mut self,
        set: &SphereSet,
        object: &str,
        scene: &StoredScene,
        place: &Place,
    ) -> Result<()> {
        if set.meta.mesh != object {
            return refuse(
                place,
                format!("holds the spheres of `{}`, the manifest lists `{object}`", set.meta.mesh),
            );
        }
        let Some(range) = self.vertices.get(object) else {
            return refuse(place, format!("object `{object}` is not in the scene"));
        };
        if set.points.get(..set.meta.vertices as usize) != scene.positions.get(range.clone()) {
            return refuse(place, format!("its vertices are not those of object `{object}` in the scene"));
        }
        self.sets.insert(object.to_owned());
        self.pairs += (set.spheres.len() as u64).pow(2);
        if self.pairs > MAX_SPHERE_PAIRS {
            return refuse(
                place,
                format!(
                    "its spheres and those before it make {} pairs, at most {MAX_SPHERE_PAIRS} are possible",
                    self.pairs
                ),
            );
        }
        Ok(())
    }

    /// Whether `object` has a sphere set.
    pub fn has_set(&self, object: &str) -> bool {
        self.sets.contains(object)
    }

    /// Fails unless the shape at `place`, that of the object of `stored`, rests where the object does and has
    /// the clips that `scene` lists.
    pub fn expect_shape(
        &self,
        shape: &DeformingMesh,
        stored: &StoredShape,
        scene: &StoredScene,
        place: &Place,
    ) -> Result<()> {
        let object = &stored.object;
        let clips = shape.clips.iter().map(|clip| (&clip.name, clip.duration_s));
        if !clips.eq(stored.clips.iter().map(|clip| (&clip.name, clip.duration_s))) {
            return refuse(
                place,
                format!("its clips are not those that the scene lists of object `{object}`"),
            );
        }
        let mut rest = Vec::new();
        shape.positions(&shape.rest_pose(), &mut rest);
        let here = self
            .vertices
            .get(object)
            .and_then(|range| scene.positions.get(range.clone()))
            .unwrap_or_default();
        if rest.len() != here.len() {
            return refuse(place, format!("{} vertices, object `{object}` has {}", rest.len(), here.len()));
        }
        let extent = here.as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
        let is_off = |(a, b): (&f32, &f32)| (a - b).abs() > TOLERANCE * extent;
        match rest.as_flattened().iter().zip(here.as_flattened()).position(is_off) {
            None => Ok(()),
            Some(at) => {
                refuse(place, format!("vertex {} does not rest where object `{object}` has it", at / 3))
            }
        }
    }
}

/// Fails unless the receivers at `place` are the vertices of `scene`, and their objects those of `scene` with
/// the sphere sets that came before them in `objects`. Exact rows have the normals of their vertices.
pub fn expect_receivers(
    shadows: &SphereShadows,
    scene: &StoredScene,
    objects: &Objects,
    place: &Place,
) -> Result<()> {
    if !shadows.meta.objects.iter().map(|o| &o.name).eq(scene.meta.objects.iter().map(|o| &o.name)) {
        return refuse(place, "its objects are not those of the scene, in their order");
    }
    let deforming: HashSet<&str> = scene.meta.shapes.iter().map(|shape| shape.object.as_str()).collect();
    for object in &shadows.meta.objects {
        let name = &object.name;
        if object.sphere_set != objects.sets.contains(name) {
            return refuse(
                place,
                format!("object `{name}` has a sphere set here or in the manifest, but not in both"),
            );
        }
        if object.deforms != deforming.contains(name.as_str()) {
            return refuse(place, format!("object `{name}` deforms here or in the scene, but not in both"));
        }
    }
    let own = |object: &ShadowObject| {
        object.first_vertex as usize..(object.first_vertex + object.vertices) as usize
    };
    if let Some(other) =
        shadows.meta.objects.iter().find(|object| objects.vertices.get(&object.name) != Some(&own(object)))
    {
        return refuse(place, format!("object `{}` has other vertices than in the scene", other.name));
    }
    let is_near =
        |row: &[f32; 3], normal: &[f32; 3]| row.iter().zip(normal).all(|(a, b)| (a - b).abs() <= TOLERANCE);
    let exact = shadows.rows.iter().zip(&scene.normals).enumerate().filter(|(_, (row, _))| **row != NO_ROW);
    let mut wrong = exact.filter(|(_, (row, normal))| {
        !shadows.normals.get(**row as usize).is_some_and(|n| is_near(n, normal))
    });
    wrong.next().map_or(Ok(()), |(vertex, _)| {
        refuse(place, format!("vertex {vertex} has a row of another normal than its own"))
    })
}
