//! The receivers of sphere-shadows and their lobes.

use crate::inspected::out::Out;
use crate::inspected::words::{grouped, list, many};
use crate::inspected::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::basis::diffuse::NODES;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::SphereShadows;
use relume_formats::kinds::sphere_shadows::{COEFFICIENTS, Casts, NO_ROW, ORDERED, ShadowObject};
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::SphereShadows, describe, export };

#[derive(Serialize)]
struct Details {
    receivers: usize,
    /// Of them, those with a lobe of their own normal.
    exact_receivers: usize,
    /// Terms kept of the light and of each lobe.
    terms: u32,
    /// Whether the sum over terms of the light uses the second level of visibility.
    second_level: bool,
    rows: usize,
    /// Of them, the nodes of the grid of normals.
    grid_rows: usize,
    objects: Vec<ShadowObject>,
}

fn describe(path: &Path) -> Result<Described> {
    let shadows = SphereShadows::read_file(path)?;
    let details = Details {
        receivers: shadows.rows.len(),
        exact_receivers: shadows.rows.iter().filter(|row| **row != NO_ROW).count(),
        terms: shadows.meta.terms,
        second_level: shadows.meta.second_level,
        rows: shadows.normals.len(),
        grid_rows: NODES,
        objects: shadows.meta.objects,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let Details { receivers, exact_receivers, terms, second_level, rows, grid_rows, objects } = details;
    let [receivers, exact] = [receivers, exact_receivers].map(|n| grouped(*n as u64));
    let levels = if *second_level { "two levels" } else { "one level" };
    vec![
        ("receivers", format!("{receivers}, {exact} of them with a lobe of their own normal")),
        ("lobes", format!("{rows}, {grid_rows} of them on the grid of normals")),
        ("shown with", format!("{terms} terms of the light and of each lobe, visibility by {levels}")),
        ("objects", list(objects.iter().map(object))),
    ]
}

fn object(object: &ShadowObject) -> String {
    let casts = match object.casts {
        Casts::Nothing => " only receives".to_owned(),
        Casts::Spheres => " casts by its spheres".to_owned(),
        Casts::Mesh { triangles, closed } => {
            let surface = if closed { "closed" } else { "open" };
            format!(" casts by {} of its {surface} mesh", many(triangles as usize, "triangle", "triangles"))
        }
    };
    let moves = if object.deforms { " and deforms" } else { "" };
    format!("{} ({},{casts}{moves})", object.name, many(object.vertices as usize, "vertex", "vertices"))
}

/// `normals.npy` [rows, 3], `lobes.npy` [rows, 6144], `order.npy` [rows, 200], `rows.npy` [vertices],
/// `casters.npy` and `caster_offsets.npy` [triangles, 3], `caster_errors.npy` [triangles], `meta.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let shadows = SphereShadows::read_file(path)?;
    let rows = shadows.normals.len();
    out.npy("normals.npy", &[rows, 3], shadows.normals.as_flattened().iter().copied())?;
    out.npy("lobes.npy", &[rows, COEFFICIENTS], shadows.lobes.iter().copied())?;
    out.npy("order.npy", &[rows, ORDERED], shadows.order.iter().copied())?;
    out.npy("rows.npy", &[shadows.rows.len()], shadows.rows.iter().copied())?;
    let triangles = shadows.casters.len();
    out.npy("casters.npy", &[triangles, 3], shadows.casters.as_flattened().iter().copied())?;
    out.npy("caster_offsets.npy", &[triangles, 3], shadows.caster_offsets.as_flattened().iter().copied())?;
    out.npy("caster_errors.npy", &[triangles], shadows.caster_errors.iter().copied())?;
    out.json(
        "meta.json",
        &json!({
            "normals": "normals.npy [rows, 3]: unit normals; the first grid_rows are the nodes of the grid, row face*64 + 8j + i at s = -1 + 2i/7, t = -1 + 2j/7",
            "lobes": "lobes.npy [rows, 6144]: of max(0, n.w)/pi integrated over the texels of a cube, faces +X -X +Y -Y +Z -Z (OpenGL); per face the orthonormal \
                      square Haar transform, index face*n*n + 4^l*m + j*2^l + i for level l (0 coarsest), type m (1: left minus right, 2: top minus bottom, 3: both), \
                      square (i, j); face*n*n is the scaling function",
            "order": "order.npy [rows, 200]: the coefficients of a row that matter most: the 6 scaling functions, then by size",
            "casters": "casters.npy [triangles, 3]: corners of the triangles that cast shadows, vertices of the scene; caster_offsets.npy [triangles, 3]: how far \
                        corners are before these along their normals, metres; caster_errors.npy [triangles]: how far vertices are from the surface there, metres",
            "rows": "rows.npy [vertices]: the row of each vertex; no_row where the grid's are blended",
            "no_row": NO_ROW,
            "grid_rows": NODES,
            "face_size": shadows.meta.face_size,
            "normal_grid": shadows.meta.normal_grid,
            "terms": shadows.meta.terms,
            "second_level": shadows.meta.second_level,
            "objects": shadows.meta.objects,
        }),
    )
}
