//! Small files of kind `sphere-shadows`, made from a seed.

use super::samples::Random;
use relume_formats::basis::diffuse::{NODES, grid_normal, lobe};
use relume_formats::kinds::SphereShadows;
use relume_formats::kinds::sphere_shadows::{COEFFICIENTS, Casts, Meta, NO_ROW, ShadowObject, order};

/// Objects of `vertices` each, of which the second deforms and the third casts by two triangles, if it has so
/// many vertices; `exact` rows beyond the grid.
pub fn sphere_shadows(seed: u64, vertices: &[u32], exact: usize) -> SphereShadows {
    let random = &mut Random(seed);
    let mut objects: Vec<ShadowObject> = Vec::new();
    for (number, vertices) in vertices.iter().enumerate() {
        let first_vertex = objects.last().map_or(0, |o| o.first_vertex + o.vertices);
        let name = format!("päper {number}");
        objects.push(ShadowObject {
            name,
            first_vertex,
            vertices: *vertices,
            sphere_set: number != 2,
            casts: match number {
                2 if *vertices >= 3 => Casts::Mesh { triangles: 2, closed: false },
                2 => Casts::Nothing,
                _ => Casts::Spheres,
            },
            deforms: number == 1,
        });
    }
    let mut row = |deforms: bool| {
        if deforms || exact == 0 || random.below(3) == 0 {
            NO_ROW
        } else {
            (NODES + random.below(exact)) as u32
        }
    };
    let rows = objects.iter().flat_map(|o| vec![o.deforms; o.vertices as usize]).map(&mut row).collect();
    let mut normals: Vec<[f32; 3]> = (0..NODES).map(|node| grid_normal(node).to_array()).collect();
    normals.extend((0..exact).map(|k| [(k as f32).cos(), 0.0, (k as f32).sin()]));
    let lobes: Vec<f32> = normals.iter().flat_map(|normal| lobe((*normal).into())).collect();
    let order = lobes.chunks_exact(COEFFICIENTS).flat_map(order).collect();
    let casting = objects.iter().filter(|object| matches!(object.casts, Casts::Mesh { .. }));
    let triangles =
        |o: &ShadowObject| [[0, 1, 2], [2, 1, 0]].map(|t| t.map(|vertex| o.first_vertex + vertex));
    let casters: Vec<[u32; 3]> = casting.flat_map(triangles).collect();
    SphereShadows {
        caster_errors: vec![0.01; casters.len()],
        caster_offsets: vec![[0.0, 1e-3, -1e-3]; casters.len()],
        casters,
        meta: Meta { face_size: 32, normal_grid: 8, terms: 200, second_level: true, objects },
        rows,
        normals,
        lobes,
        order,
    }
}
