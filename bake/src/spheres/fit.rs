//! From a mesh to a sphere set.

use super::ball::Ball;
use super::cluster::Problem;
use super::measure::measure;
use super::members::members;
use super::motion::Motion;
use super::pieces::Pieces;
use super::search::Search;
use super::solid::Solid;
use super::sphere::Sphere;
use super::start::start;
use super::triangle_tree::TriangleTree;
use crate::error::{BakeError, Result};
use crate::job::{Job, Progress};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use relume_formats::Place;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::Meta;
use relume_scenes::Mesh;
use std::sync::Arc;

/// Most spheres of a fit.
pub const MAX_SPHERES: usize = 4096;
/// Iterations unless told otherwise.
pub const DEFAULT_ITERATIONS: u32 = 200;

/// Searches side by side, of which the best one's set is kept. A constant, so that the result does not depend
/// on the number of threads.
const SEARCHES: u64 = 2;
/// Above this many spheres one search does as well, and keeps all threads busy.
const MANY_SPHERES: usize = 128;
/// Pieces of the surface at the start, per sphere and at least.
const PIECES: (usize, usize) = (60, 2000);
/// Iterations from one refinement of the pieces to the next.
const REFINE: u32 = 8;
/// Smallest piece that is split, in parts of the diagonal.
const SMALLEST_PIECE: f64 = 0.003;
/// What a change may lose at the start, in parts of the mean volume outside of a sphere, and when losses end,
/// in parts of all iterations.
const LOSS: (f64, f64) = (1.0, 0.75);
/// Within this of a sphere, in parts of the diagonal, a point counts as covered.
pub const COVERED: f64 = 1e-5;

/// What can be asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Number of spheres, 1 to [`MAX_SPHERES`].
    pub spheres: usize,
    /// Of all random numbers.
    pub seed: u64,
    /// Rounds of the search.
    pub iterations: u32,
    /// How far outside every sphere a point of the solid may lie, in parts of the bounding box's diagonal; 0
    /// covers everything.
    pub tight: f64,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The set.
    pub set: SphereSet,
    /// What was mended or is not as it should be, one line each.
    pub notes: Vec<String>,
}

/// Covers the solid that `mesh` bounds with spheres that have as little volume outside it as the search
/// finds. `name` is the mesh's name in the file. `poses` are places of the mesh's vertices when it moves:
/// then the mean over these and rest is what is kept small.
///
/// # Errors
/// If the mesh encloses no volume, the number of spheres is out of range, or the user interrupts.
pub fn fit(
    mesh: &Mesh,
    poses: &[Vec<[f32; 3]>],
    name: &str,
    place: &Place,
    settings: &Settings,
    job: &Job,
) -> Result<Fit> {
    if !(1..=MAX_SPHERES).contains(&settings.spheres) {
        let reason = format!("{} spheres are asked for; 1 to {MAX_SPHERES} can be fitted", settings.spheres);
        return Err(BakeError::invalid(place, reason));
    }
    let solid = Solid::of(mesh, place)?;
    let motion = Motion::new(&solid, poses);
    let searches = if settings.spheres > MANY_SPHERES { 1 } else { SEARCHES };
    let progress = job.progress("spheres", u64::from(settings.iterations) * searches);
    let run = |k: u64| {
        search(&solid, &motion, settings, settings.seed.wrapping_mul(SEARCHES).wrapping_add(k), &progress)
    };
    let found = (0..searches).into_par_iter().map(run).collect::<Result<Vec<Found<'_>>>>()?;
    let best = found.into_iter().min_by(|a, b| a.search.lowest().total_cmp(&b.search.lowest()));
    let Some(Found { search, mut history }) = best else {
        return Err(BakeError::invalid(place, "holds nothing to cover"));
    };
    let (spheres, balls) = finished(&search, &solid);
    let outside: f64 = balls.iter().map(|b| b.outside(&solid.boundary).volume).sum();
    // Rounding to single precision adds a hair.
    let last = if motion.poses() == 0 { outside } else { search.lowest() };
    history.iter_mut().for_each(|e| *e = e.max(last));
    history.push(last);
    let slack = search.problem.slack;
    let members = members(mesh, &solid, &search.problem.pieces, &spheres, &balls);
    let meta = Meta {
        mesh: name.to_owned(),
        vertices: mesh.positions.len() as u32,
        triangles: mesh.triangles.len() as u32,
        seed: settings.seed,
        iterations: settings.iterations,
        tight: settings.tight as f32,
        poses: motion.poses() as u32,
        solid: solid.kind,
        diagonal: solid.diagonal as f32,
        volume: solid.volume,
        outside_volume: outside,
        quality: measure(&solid, &balls, COVERED * solid.diagonal),
    };
    let mut notes = solid.notes.clone();
    if motion.poses() < poses.len() {
        notes.push("its solid is not bounded by the mesh alone, so the spheres are fitted at rest, without a look at its clips".to_owned());
    }
    if slack == 0.0 && meta.quality.coverage_surface.min(meta.quality.coverage_volume) < 1.0 {
        notes.push(format!(
            "a gap of {:.1e} of the diagonal is left",
            meta.quality.largest_gap / solid.diagonal
        ));
    }
    let set = SphereSet {
        meta,
        spheres: balls.iter().map(|b| b.centre.as_vec3().extend(b.radius as f32).to_array()).collect(),
        points: members.points,
        point_vertices: members.vertices,
        point_weights: members.weights,
        clusters: members.spheres,
        history: history.iter().map(|e| (e / solid.volume) as f32).collect(),
    };
    Ok(Fit { set, notes })
}

/// E/V(T) of spheres for the solid that `mesh` bounds.
///
/// # Errors
/// If the mesh encloses no volume.
pub fn relative_outside(mesh: &Mesh, spheres: &[[f32; 4]], place: &Place) -> Result<f64> {
    let solid = Solid::of(mesh, place)?;
    let ball = |[x, y, z, r]: &[f32; 4]| Ball::new(Vec3::new(*x, *y, *z).as_dvec3(), f64::from(*r));
    let outside: f64 = spheres.iter().map(|s| ball(s).outside(&solid.boundary).volume).sum();
    Ok(outside / solid.volume)
}

/// A search that has ended, and the volume outside after each of its iterations.
struct Found<'a> {
    search: Search<'a>,
    history: Vec<f64>,
}

fn search<'a>(
    solid: &'a Solid,
    motion: &'a Motion,
    settings: &Settings,
    seed: u64,
    progress: &Progress,
) -> Result<Found<'a>> {
    let area: f64 = solid.surface.planes.iter().map(|(_, area)| area).sum();
    let wanted = (PIECES.0 * settings.spheres).max(PIECES.1);
    let size = (4.0 * area / wanted as f64).sqrt();
    let pieces = Pieces::new(&solid.surface, size);
    let problem = Problem { solid: &solid.boundary, pieces, slack: settings.tight * solid.diagonal, motion };
    let spheres = start(&problem, settings.spheres, seed);
    let mut search = Search::new(problem, spheres, seed);
    let mut history = Vec::new();
    let smallest = SMALLEST_PIECE * solid.diagonal;
    for iteration in 0..settings.iterations {
        progress.check()?;
        let share = f64::from(iteration) / f64::from(settings.iterations);
        if iteration % REFINE == REFINE - 1 {
            search.refine(size * (smallest / size).min(1.0).powf(share));
        }
        search.round(LOSS.0 * (1.0 - share / LOSS.1).max(0.0).powi(2));
        history.push(search.lowest());
        progress.advance(1);
    }
    for _ in 0..2 {
        search.refine(smallest);
    }
    Ok(Found { search, history })
}

/// The best spheres and their balls in single precision: rounded so that they still cover their pieces.
/// Spheres that found nothing to cover stand within the solid, where they add no volume outside.
fn finished(search: &Search<'_>, solid: &Solid) -> (Vec<Sphere>, Vec<Ball>) {
    let problem = &search.problem;
    let whole = |s: &Sphere| s.with_cluster(problem.pieces.merged(&s.cluster, |_, _| true));
    let spheres: Vec<Sphere> = search.best().iter().map(whole).collect();
    let spare = spare_balls(&spheres, solid);
    let mut spare = spare.iter().cycle();
    let mut round = |s: &Sphere| {
        if s.cluster.is_empty() {
            return spare.next().copied().unwrap_or(s.ball);
        }
        let centre = s.ball.centre.as_vec3().as_dvec3();
        let needed =
            problem.sphere(centre, Arc::clone(&s.cluster), &problem.pieces.positions(&s.cluster)).ball.radius;
        // A tight fit may leave nothing of a sphere that covers a point; a sphere has a size.
        let least = f64::from(f32::EPSILON) * solid.diagonal;
        Ball::new(centre, f64::from(((needed * (1.0 + 1e-7)) as f32).next_up()).max(least))
    };
    let balls = spheres.iter().map(&mut round).collect();
    (spheres, balls)
}

/// Balls within the solid, largest first, around the centres of spheres and beneath triangles.
fn spare_balls(spheres: &[Sphere], solid: &Solid) -> Vec<Ball> {
    if spheres.iter().all(|s| !s.cluster.is_empty()) {
        return Vec::new();
    }
    let mesh = &solid.boundary;
    let beneath = |t: usize| beneath(mesh, t, solid.diagonal);
    let step = mesh.triangles.len().div_ceil(256).max(1);
    let centres = spheres
        .iter()
        .map(|s| s.ball.centre)
        .filter(|c| mesh.encloses(*c))
        .chain((0..mesh.triangles.len()).step_by(step).filter_map(beneath));
    let ball = |c: DVec3| {
        let centre = c.as_vec3().as_dvec3();
        Ball::new(centre, f64::from((0.999 * mesh.distance(centre)) as f32))
    };
    let mut balls: Vec<Ball> =
        centres.map(ball).filter(|b| b.radius > 0.0 && mesh.encloses(b.centre)).collect();
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    balls
}

/// A point of the solid beneath a triangle.
fn beneath(mesh: &TriangleTree, triangle: usize, diagonal: f64) -> Option<DVec3> {
    let centre = mesh.corners(triangle).iter().sum::<DVec3>() / 3.0;
    let depth = |k: i32| centre - mesh.planes[triangle].0 * diagonal * 0.1 * 0.5_f64.powi(k);
    (0..16).map(depth).find(|p| mesh.encloses(*p))
}
