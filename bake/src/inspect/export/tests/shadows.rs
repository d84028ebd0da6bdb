//! An exported file of receivers and lobes, and what `info` and `verify` say of it.

use super::super::super::{info, verify};
use super::*;
use relume_formats::basis::diffuse::{NODES, grid_normal, lobe};
use relume_formats::kinds::SphereShadows;
use relume_formats::kinds::sphere_shadows::{Casts, Meta, NO_ROW, ShadowObject, order};

/// A plane of four vertices, which has a row of its own, and a fox of three.
fn shadows() -> SphereShadows {
    let object = |name: &str, first_vertex, vertices, fox| ShadowObject {
        name: name.to_owned(),
        first_vertex,
        vertices,
        sphere_set: fox,
        casts: if fox { Casts::Spheres } else { Casts::Mesh { triangles: 2, closed: false } },
        deforms: fox,
    };
    let normals: Vec<[f32; 3]> =
        (0..NODES).map(|node| grid_normal(node).to_array()).chain([[0.0, 1.0, 0.0]]).collect();
    let lobes: Vec<f32> = normals.iter().flat_map(|normal| lobe((*normal).into())).collect();
    SphereShadows {
        meta: Meta {
            face_size: 32,
            normal_grid: 8,
            terms: 200,
            second_level: true,
            objects: vec![object("plane", 0, 4, false), object("fox", 4, 3, true)],
        },
        rows: vec![384, 384, 384, 384, NO_ROW, NO_ROW, NO_ROW],
        order: lobes.chunks_exact(6144).flat_map(order).collect(),
        normals,
        lobes,
        casters: vec![[0, 1, 2], [0, 2, 3]],
        caster_offsets: vec![[0.0, 0.5, 0.25]; 2],
        caster_errors: vec![0.0, 0.125],
    }
}

#[test]
fn shadows_come_out_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (path, out) = (folder.path().join("sphere-shadows.relume"), folder.path().join("out"));
    let shadows = shadows();
    shadows.write_file(&path).unwrap();
    assert!(
        verify(&path).unwrap().ends_with("sphere-shadows, 8 sections, every checksum and value checked\n")
    );
    let text = info(&path, false).unwrap();
    for part in [
        "7, 4 of them with a lobe of their own normal",
        "385, 384 of them on the grid of normals",
        "plane (4 vertices, casts by 2 triangles of its open mesh), fox (3 vertices, casts by its spheres and deforms)",
    ] {
        assert!(text.contains(part), "`{part}` is not in `{text}`");
    }
    let details = &serde_json::from_str::<Value>(&info(&path, true).unwrap()).unwrap()["details"];
    assert_eq!(
        details["objects"][1],
        serde_json::json!({"name": "fox", "first_vertex": 4, "vertices": 3, "sphere_set": true, "casts": "Spheres", "deforms": true})
    );

    let files = export_file(&path, &out).unwrap();
    assert_eq!(
        names(&files, &out),
        [
            "normals.npy",
            "lobes.npy",
            "order.npy",
            "rows.npy",
            "casters.npy",
            "caster_offsets.npy",
            "caster_errors.npy",
            "meta.json"
        ]
    );
    assert_eq!(Npy::f32s(&files[0]), (vec![385, 3], shadows.normals.as_flattened().to_vec()));
    let (shape, lobes) = Npy::f32s(&files[1]);
    assert_eq!((shape, lobes == shadows.lobes), (vec![385, 6144], true));
    // A scaling coefficient is the sum over its face's texels by 32; without blockers a white sky gives 1.
    let light: f32 = (0..6).map(|face| 32.0 * lobes[384 * 6144 + face * 1024]).sum();
    assert!((light - 1.0).abs() < 1e-5, "{light}");
    let [order, rows] = [2, 3].map(|file| Npy::read(&files[file]));
    assert_eq!((order.shape, order.descr.as_str()), (vec![385, 200], "<u2"));
    assert_eq!(
        order.payload.as_chunks().0.iter().map(|v| u16::from_le_bytes(*v)).collect::<Vec<_>>(),
        shadows.order
    );
    assert_eq!((rows.shape, rows.descr.as_str()), (vec![7], "<u4"));
    assert_eq!(
        rows.payload.as_chunks().0.iter().map(|v| u32::from_le_bytes(*v)).collect::<Vec<_>>(),
        shadows.rows
    );
    assert_eq!(Npy::f32s(&files[5]), (vec![2, 3], shadows.caster_offsets.as_flattened().to_vec()));
    assert_eq!(Npy::f32s(&files[6]), (vec![2], shadows.caster_errors.clone()));
    let meta = json(&files[7]);
    assert_eq!(
        (&meta["objects"][0]["name"], &meta["no_row"], &meta["grid_rows"]),
        (&"plane".into(), &NO_ROW.into(), &384.into())
    );
}
