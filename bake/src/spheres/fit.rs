//! Fitting a set of spheres to a mesh.

use super::ball::Ball;
use super::triangle_tree::TriangleTree;
use crate::error::{BakeError, Result};
use crate::job::Job;
use glam::{DVec3, Vec3};
use relume_formats::Place;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::{Meta, Protrusion, Quality, Solid};
use relume_scenes::Mesh;
use std::collections::HashMap;

/// Most spheres that are fitted.
pub const MAX_SPHERES: usize = 4096;
/// Most iterations unless told otherwise.
pub const DEFAULT_ITERATIONS: u32 = 200;

/// What to fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How many spheres, 1 to [`MAX_SPHERES`].
    pub spheres: usize,
    /// Of the random numbers.
    pub seed: u64,
    /// Most iterations.
    pub iterations: u32,
    /// How far outside every sphere a point of the solid may lie, in parts of the diagonal.
    pub tight: f64,
}

/// A fitted set.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The spheres and what they follow.
    pub set: SphereSet,
    /// What was mended or is not as it should be, one line each.
    pub notes: Vec<String>,
}

/// Fits spheres to the solid that `mesh` bounds. `name` is the mesh's name in the file; `place` the file, for messages.
///
/// # Errors
/// `Invalid` if the mesh encloses no volume; if the user asks to stop.
pub fn fit(mesh: &Mesh, name: &str, place: &Place, settings: &Settings, job: &Job) -> Result<Fit> {
    let tree = welded(mesh);
    let volume = volume(&tree, place)?;
    let (min, max) = tree.nodes.first().map_or((DVec3::ZERO, DVec3::ZERO), |root| (root.min, root.max));
    let centre = ((min + max) / 2.0).as_vec3();
    let farthest = tree.vertices.iter().map(|v| v.distance(centre.as_dvec3())).fold(0.0, f64::max);
    let sphere = centre.extend((farthest * (1.0 + 1e-6)) as f32).to_array();
    let spheres = vec![sphere; settings.spheres];
    let stage = job.stage("spheres", settings.iterations.into());
    let mut outside = 0.0;
    for _ in 0..settings.iterations {
        stage.check()?;
        outside = outside_volume(&tree, &spheres);
        stage.advance(1);
    }
    let vertices = mesh.positions.len() as u32;
    let protrusion = Protrusion { mean: 0.0, p95: 0.0, max: farthest };
    let quality =
        Quality { coverage_surface: 1.0, coverage_volume: 1.0, protrusion, largest_gap: 0.0, overlap: spheres.len() as f64 - 1.0 };
    let meta = Meta {
        mesh: name.to_owned(),
        vertices,
        triangles: mesh.triangles.len() as u32,
        seed: settings.seed,
        iterations: settings.iterations,
        tight: settings.tight as f32,
        solid: Solid::Closed,
        diagonal: max.distance(min) as f32,
        volume,
        outside_volume: outside,
        quality,
    };
    let set = SphereSet {
        meta,
        points: mesh.positions.clone(),
        point_vertices: (0..vertices).map(|v| [v; 3]).collect(),
        point_weights: vec![[1.0, 0.0, 0.0]; vertices as usize],
        clusters: (0..vertices).map(|v| v % settings.spheres as u32).collect(),
        history: vec![(outside / volume) as f32],
        spheres,
    };
    Ok(Fit { set, notes: Vec::new() })
}

/// E/V(T) of `spheres`, centre and radius, against the solid that `mesh` bounds.
///
/// # Errors
/// `Invalid` if the mesh encloses no volume.
pub fn relative_outside(mesh: &Mesh, spheres: &[[f32; 4]], place: &Place) -> Result<f64> {
    let tree = welded(mesh);
    Ok(outside_volume(&tree, spheres) / volume(&tree, place)?)
}

fn outside_volume(tree: &TriangleTree, spheres: &[[f32; 4]]) -> f64 {
    let ball = |[x, y, z, radius]: &[f32; 4]| Ball::new(Vec3::new(*x, *y, *z).as_dvec3(), f64::from(*radius));
    spheres.iter().map(|sphere| ball(sphere).outside(tree).volume).sum()
}

fn volume(tree: &TriangleTree, place: &Place) -> Result<f64> {
    let (volume, diagonal) = tree.nodes.first().map_or((0.0, 0.0), |root| (root.moment / 3.0, root.max.distance(root.min)));
    if volume > 1e-9 * diagonal.powi(3) {
        return Ok(volume);
    }
    Err(BakeError::invalid(place, "encloses no volume for spheres to cover; give the mesh an inside, its triangles facing outwards"))
}

fn welded(mesh: &Mesh) -> TriangleTree {
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut weld = |position: &[f32; 3]| {
        *known.entry(position.map(f32::to_bits)).or_insert_with(|| {
            vertices.push(Vec3::from(*position).as_dvec3());
            vertices.len() as u32 - 1
        })
    };
    let indices: Vec<u32> = mesh.positions.iter().map(&mut weld).collect();
    TriangleTree::new(vertices, mesh.triangles.iter().map(|t| t.map(|v| indices[v as usize])).collect())
}
