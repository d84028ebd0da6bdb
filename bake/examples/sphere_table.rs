//! The table of docs/notes/SPHERE-SETS.md. It takes minutes and needs the assets (`make assets`); NAME leaves
//! only the meshes with it in their names:
//!
//! `cargo run --release --example sphere_table -- [NAME]`

use glam::DVec3;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, ProgressMode};
use relume_bake::spheres::fit::{DEFAULT_ITERATIONS, Settings, fit};
use relume_bake::spheres::triangle_tree;
use relume_formats::Place;
use relume_scenes::Mesh;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

#[path = "../src/spheres/test_meshes.rs"]
#[allow(dead_code, reason = "tests use the others")]
mod test_meshes;
use test_meshes::{flipped_face_cube, l_shape, mesh, open_hemisphere, thin_plate, torus, two_cubes};

/// Numbers of spheres.
const SPHERES: [usize; 4] = [16, 32, 64, 128];

/// A mesh of the pinned assets.
fn asset(file: &str) -> Result<Mesh> {
    Ok(relume_scenes::load_mesh(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(file),
        &mut Vec::new(),
    )?)
}

fn knot() -> Result<Mesh> {
    let scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot")?)?;
    let knot = scene.objects.iter().find(|object| object.name.contains("knot"));
    let knot = knot.ok_or_else(|| BakeError::invalid(&Place::file(&scene.file), "has no knot"))?;
    Ok((*knot.mesh).clone())
}

fn print(only: &str) -> Result<()> {
    let meshes = [
        ("bunny", asset("bunny.obj")?),
        ("armadillo", asset("armadillo.off")?),
        ("torus-knot", knot()?),
        ("torus", mesh(torus(1.0, 0.35, 48, 24))),
        ("thin-plate", mesh(thin_plate())),
        ("L-shape", mesh(l_shape())),
        ("two-cubes", mesh(two_cubes(DVec3::new(3.0, 0.5, 0.0)))),
        ("open-hemisphere", mesh(open_hemisphere(24, 8))),
        ("flipped-face", mesh(flipped_face_cube())),
    ];
    for (name, mesh) in meshes.iter().filter(|(name, _)| name.contains(only)) {
        for spheres in SPHERES {
            let start = Instant::now();
            let settings = Settings { spheres, seed: 0, iterations: DEFAULT_ITERATIONS, tight: 0.0 };
            let set = fit(mesh, &[], name, &Place::file(name), &settings, &Job::new(ProgressMode::None))?.set;
            let (e, quality) = (set.meta.relative_outside_volume(), set.meta.quality);
            let covered = quality.coverage_surface.min(quality.coverage_volume);
            println!(
                "| {name} | {} | {spheres} | {e:.4} | {:.1} | {:.0} % |",
                mesh.triangles.len(),
                start.elapsed().as_secs_f64(),
                100.0 * covered
            );
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let Err(error) = print(&std::env::args().nth(1).unwrap_or_default()) else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(error.exit_code())
}
