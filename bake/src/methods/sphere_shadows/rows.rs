//! The receivers of a scene and the lobes of their normals.

use rayon::prelude::*;
use relume_formats::basis::diffuse::{self, GRID, NODES, grid_normal};
use relume_formats::basis::two_level::SIDE;
use relume_formats::kinds::SphereShadows;
use relume_formats::kinds::sphere_shadows::{Casts, Meta, NO_ROW, ORDERED, ShadowObject, order};
use relume_scenes::{Object, Scene};
use std::collections::BTreeMap;

/// Most rows behind those of the grid. Each costs as much as a node of the grid when the light changes, so
/// these are few.
pub const MAX_EXACT: usize = 64;

/// The receivers of `scene`, which cast nothing yet. Objects that never turn and have few distinct normals, such as planes and boxes,
/// get exact rows: those with the fewest first, an object wholly or not at all, so that no neighbours are
/// shaded by different rules, and [`MAX_EXACT`] at most in all.
pub fn bake(scene: &Scene) -> SphereShadows {
    let exact = exact_rows(scene);
    let mut normals: Vec<[f32; 3]> = (0..NODES).map(|node| grid_normal(node).to_array()).collect();
    let mut first_vertex = 0;
    let mut meta = Meta {
        face_size: SIDE as u32,
        normal_grid: GRID as u32,
        terms: ORDERED as u32,
        second_level: true,
        objects: Vec::new(),
    };
    let mut rows = Vec::new();
    for (index, object) in scene.objects.iter().enumerate() {
        let mut known: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        let mut row = |normal: &[f32; 3]| {
            *known.entry(normal.map(f32::to_bits)).or_insert_with(|| {
                let row = normals.iter().skip(NODES).position(|n| n == normal).map(|at| NODES + at);
                row.unwrap_or_else(|| {
                    normals.push(*normal);
                    normals.len() - 1
                }) as u32
            })
        };
        let is_exact = exact.contains(&index);
        rows.extend(object.mesh.normals.iter().map(|normal| if is_exact { row(normal) } else { NO_ROW }));
        let vertices = object.mesh.positions.len() as u32;
        let (sphere_set, deforms) = (object.spheres.is_some(), object.shape.is_some());
        meta.objects.push(ShadowObject {
            name: object.name.clone(),
            first_vertex,
            vertices,
            sphere_set,
            casts: Casts::Nothing,
            deforms,
        });
        first_vertex += vertices;
    }
    let lobes: Vec<Vec<f32>> = normals.par_iter().map(|normal| diffuse::lobe((*normal).into())).collect();
    let order = lobes.par_iter().flat_map_iter(|lobe| order(lobe)).collect();
    let (casters, caster_offsets, caster_errors) = Default::default();
    SphereShadows {
        meta,
        rows,
        normals,
        lobes: lobes.concat(),
        order,
        casters,
        caster_offsets,
        caster_errors,
    }
}

/// The objects that get exact rows.
fn exact_rows(scene: &Scene) -> Vec<usize> {
    let mut few: Vec<(usize, usize)> = scene
        .objects
        .iter()
        .enumerate()
        .filter_map(|(index, object)| Some((distinct_normals(object)?, index)))
        .collect();
    few.sort_unstable();
    let mut room = MAX_EXACT;
    let fits = |(count, index): &(usize, usize)| {
        let left = room.checked_sub(*count)?;
        room = left;
        Some(*index)
    };
    few.iter().map_while(fits).collect()
}

/// How many normals a still object has; `None` for one that deforms.
fn distinct_normals(object: &Object) -> Option<usize> {
    let normals = object.mesh.normals.iter().map(|normal| normal.map(f32::to_bits));
    object.shape.is_none().then(|| normals.collect::<std::collections::BTreeSet<_>>().len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn planes_have_a_row_and_what_deforms_or_is_round_has_none() {
        let scene = relume_scenes::load(&relume_scenes::resolve("knot-twist").unwrap()).unwrap();
        let shadows = bake(&scene);
        let knot = scene.objects[0].mesh.positions.len();
        assert_eq!(shadows.normals[NODES..], [[0.0, 1.0, 0.0]]);
        assert!(
            shadows.rows[..knot].iter().all(|row| *row == NO_ROW)
                && shadows.rows[knot..].iter().all(|row| *row == NODES as u32)
        );
        assert_eq!(shadows.lobe(NODES), diffuse::lobe(glam::Vec3::Y));
        assert_eq!(shadows.terms(NODES), order(shadows.lobe(NODES)));
    }

    #[test]
    fn objects_share_rows_wholly_or_not_at_all_the_plainest_first() {
        let mut scene = relume_scenes::load(&relume_scenes::resolve("knot-twist").unwrap()).unwrap();
        let plane = scene.objects.remove(1);
        let turned = |count: usize| {
            let mut object = plane.clone();
            let normals = &mut Arc::make_mut(&mut object.mesh).normals;
            let normal =
                |k: usize| glam::Vec3::new(0.01 * (k % count) as f32, 1.0, 0.0).normalize().to_array();
            normals.iter_mut().enumerate().for_each(|(k, n)| *n = normal(k));
            object
        };
        scene.objects = vec![turned(MAX_EXACT - 2), turned(3), turned(2), turned(1)];
        let shadows = bake(&scene);
        let vertices = plane.mesh.positions.len();
        let has_rows: Vec<bool> =
            shadows.rows.chunks(vertices).map(|rows| rows.iter().all(|row| *row != NO_ROW)).collect();
        assert_eq!(has_rows, [false, true, true, true], "1 + 2 + 3 fit, and {} more do not", MAX_EXACT - 2);
        assert!(shadows.rows[..vertices].iter().all(|row| *row == NO_ROW));
        assert_eq!(shadows.normals.len(), NODES + 3, "normals of several objects are stored once");
    }
}
