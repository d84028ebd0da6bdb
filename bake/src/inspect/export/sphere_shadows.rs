//! The receivers of sphere-shadows and their lobes as arrays.

use super::out::Out;
use relume_formats::Result;
use relume_formats::basis::diffuse::NODES;
use relume_formats::kinds::SphereShadows;
use relume_formats::kinds::sphere_shadows::{COEFFICIENTS, NO_ROW, ORDERED};
use serde_json::json;

/// `normals.npy` [rows, 3], `lobes.npy` [rows, 6144], `order.npy` [rows, 200], `rows.npy` [vertices], `meta.json`.
pub(super) fn export(shadows: &SphereShadows, out: &mut Out) -> Result<()> {
    let rows = shadows.normals.len();
    out.npy("normals.npy", &[rows, 3], shadows.normals.as_flattened().iter().copied())?;
    out.npy("lobes.npy", &[rows, COEFFICIENTS], shadows.lobes.iter().copied())?;
    out.npy("order.npy", &[rows, ORDERED], shadows.order.iter().copied())?;
    out.npy("rows.npy", &[shadows.rows.len()], shadows.rows.iter().copied())?;
    out.json(
        "meta.json",
        &json!({
            "normals": "normals.npy [rows, 3]: unit normals; the first grid_rows are the nodes of the grid, row face*64 + 8j + i at s = -1 + 2i/7, t = -1 + 2j/7",
            "lobes": "lobes.npy [rows, 6144]: of max(0, n.w)/pi integrated over the texels of a cube, faces +X -X +Y -Y +Z -Z (OpenGL); per face the orthonormal \
                      square Haar transform, index face*n*n + 4^l*m + j*2^l + i for level l (0 coarsest), type m (1: left minus right, 2: top minus bottom, 3: both), \
                      square (i, j); face*n*n is the scaling function",
            "order": "order.npy [rows, 200]: the coefficients of a row that matter most: the 6 scaling functions, then by size",
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
