//! How far the shadows of spheres are from those of the meshes: rays against the pixel basis, at some receivers, in some poses, under the held-out lights.

use super::rows::MAX_EXACT;
use crate::error::Result;
use crate::job::Job;
use crate::methods::Traced;
use crate::methods::sparse_transfer::{HeldOutLights, RADIANCES, STATES, exact_radiances, receivers as tracing_receivers};
use crate::trace::world::{World, take_ray_count};
use glam::Vec3A;
use rayon::prelude::*;
use relume_formats::Place;
use relume_formats::basis::cubemap::{self, FACES};
use relume_formats::basis::diffuse::{self, NODES};
use relume_formats::basis::haar::inverse_cube;
use relume_formats::basis::two_level::SIDE;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::evaluate::sphere_shadows::{Detail, Function, Levels, Receiver, Spheres, light, lobe, receivers};
use relume_formats::fast::sphere_shadows::Shading;
use relume_formats::kinds::{Environment, HaarTable, SphereSet, SphereShadows};
use relume_formats::state::{Rgb, ShapeState, State};
use relume_scenes::Scene;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Texels of the light.
const TEXELS: usize = FACES * SIDE * SIDE;
/// Receivers that are looked at.
const RECEIVERS: usize = 1024;
/// Poses that are looked at besides rest, if anything deforms.
const POSES: usize = 4;
/// Receivers that one thread takes at a time.
const CHUNK: usize = 16;

/// Relative L2 errors over the receivers, one for each pose and light; NaN where that shows nothing.
pub struct Measured {
    /// As the player shows it.
    pub shown: Vec<f64>,
    /// With all terms: what the spheres alone do.
    pub all_terms: Vec<f64>,
    /// What was compared.
    pub on: String,
    /// What tracing took.
    pub traced: Traced,
}

/// Measures `shadows` on `scene`, whose sphere sets are `sets`.
///
/// # Errors
/// If the user interrupts, or a clip leads beyond all numbers.
pub fn measure(scene: &Scene, shadows: &SphereShadows, sets: &[SphereSet], maps: &[Environment], job: &Job) -> Result<Measured> {
    let start = Instant::now();
    let lights = HeldOutLights::new(maps, SIDE);
    let poses = poses(scene)?;
    let vertices = shadows.rows.len();
    let some = receivers_looked_at(vertices);
    let stage = job.stage("measuring", (poses.len() * (some.len().div_ceil(CHUNK) + 2 * STATES)) as u64);
    let rays = AtomicU64::new(0);
    let (mut shown, mut all_terms) = (Vec::new(), Vec::new());
    let detail = Detail::of(&shadows.meta);
    let [kept, whole] = [detail.terms, None].map(|terms| lobes(shadows, terms));
    for pose in &poses {
        let truth = traced(pose, &some, &lights, |steps| {
            rays.fetch_add(take_ray_count(), Ordering::Relaxed);
            stage.advance(steps);
            stage.check().is_ok()
        });
        stage.check()?;
        let ours = shown_in(pose, &some, shadows, sets)?;
        for (errors, lobes, terms, levels) in
            [(&mut shown, &kept, detail.terms, detail.levels), (&mut all_terms, &whole, None, Levels::All)]
        {
            for state in 0..STATES {
                stage.check()?;
                errors.push(error(&ours.under(lobes, &light(planes(&lights, state), terms), levels), &truth, state));
                stage.advance(1);
            }
        }
    }
    let on = format!(
        "{STATES} held-out lights, the scene's maps turned, in {} poses, at {} vertices, against rays to the meshes",
        poses.len(),
        some.len()
    );
    Ok(Measured { shown, all_terms, on, traced: Traced { rays: rays.into_inner(), seconds: start.elapsed().as_secs_f64() } })
}

/// The vertices, of so many, that are looked at.
pub(super) fn receivers_looked_at(vertices: usize) -> Vec<usize> {
    (0..vertices).step_by(vertices.div_ceil(RECEIVERS).max(1)).collect()
}

/// The lobes of all rows with their `terms` of largest size.
pub(super) fn lobes(shadows: &SphereShadows, terms: Option<usize>) -> Vec<Function> {
    (0..shadows.normals.len()).map(|row| lobe(shadows.lobe(row).to_vec(), terms)).collect()
}

/// Bytes that measuring holds at most: the hierarchy, the lights four times over, weights of all texels for each row, and radiances.
pub fn predicted_bytes(scene: &Scene) -> u64 {
    let count = |of: fn(&relume_scenes::Mesh) -> usize| scene.objects.iter().map(|o| of(&o.mesh) as u64).sum::<u64>();
    let (triangles, vertices) = (count(|mesh| mesh.triangles.len()), count(|mesh| mesh.positions.len()));
    let rows = (NODES + MAX_EXACT) as u64;
    triangles * 600 + vertices * (POSES as u64 + 2) * 100 + (TEXELS * RADIANCES * 4 * 4) as u64 + rows * TEXELS as u64 * 4 * 9 + (64 << 20)
}

/// The scene at rest, and with all that deforms at moments between those that the spheres were fitted to.
pub(super) fn poses(scene: &Scene) -> Result<Vec<Scene>> {
    let moment = |k: usize| {
        let clip = |shape: &relume_formats::shape::DeformingMesh| {
            let clip = shape.clips.get(k % shape.clips.len().max(1))?;
            Some(ShapeState {
                clip: Some(clip.name.clone()),
                time_s: Some(clip.duration_s * (2 * k + 1) as f32 / (2 * (POSES + 1)) as f32),
            })
        };
        let shapes = scene.objects.iter().filter_map(|o| Some((o.name.clone(), clip(o.shape.as_deref()?)?)));
        State { shapes: shapes.collect::<BTreeMap<_, _>>(), ..State::default() }
    };
    let deforms = scene.objects.iter().any(|o| o.shape.is_some());
    let posed = (0..if deforms { POSES } else { 0 }).map(|k| Ok(scene.with_state(&moment(k), &Place::file(&scene.file))?));
    std::iter::once(Ok(scene.clone())).chain(posed).collect()
}

/// Radiance of a white surface at `some` vertices under all lights, row-major [receivers, [`RADIANCES`]], as rays to the centres of texels see the meshes.
/// `go_on` is told of each finished chunk and may end the work.
pub(super) fn traced(pose: &Scene, some: &[usize], lights: &HeldOutLights, go_on: impl Fn(u64) -> bool + Sync) -> Vec<[f32; RADIANCES]> {
    let world = World::new(pose);
    let receivers = tracing_receivers(pose);
    let chunk = |vertices: &[usize]| {
        let of = |vertex: &usize| {
            let receiver = &receivers[*vertex];
            let mut row = diffuse::lobe(receiver.normal.into());
            inverse_cube(&mut row, SIDE);
            for (texel, value) in row.iter_mut().enumerate() {
                let direction = centre(texel);
                // What of a texel is above the horizon while its centre is below is seen by its centre all the same, unless the surface is in the way.
                if *value != 0.0 && world.occluded(receiver.origin, direction, f32::INFINITY) {
                    *value = 0.0;
                }
            }
            exact_radiances(&[row], lights)
        };
        vertices.iter().map(of).collect::<Vec<_>>()
    };
    let chunks = some.par_chunks(CHUNK).map(|vertices| {
        let radiances = chunk(vertices);
        go_on(1).then_some(radiances)
    });
    chunks.collect::<Option<Vec<_>>>().unwrap_or_default().concat()
}

/// The direction of a texel's centre.
pub(super) fn centre(texel: usize) -> Vec3A {
    let (x, y) = (texel % SIDE, texel / SIDE % SIDE);
    cubemap::direction(texel / (SIDE * SIDE), SIDE, x as f64 + 0.5, y as f64 + 0.5).as_vec3a()
}

/// Receivers and spheres in a pose.
pub(super) struct Posed {
    pub(super) receivers: Vec<Receiver>,
    pub(super) spheres: Vec<Spheres>,
    pub(super) table: HaarTable,
}

/// What `shadows` and `sets` make of `pose`, at `some` of the vertices.
pub(super) fn shown_in(pose: &Scene, some: &[usize], shadows: &SphereShadows, sets: &[SphereSet]) -> Result<Posed> {
    let all = |of: fn(&relume_scenes::Mesh) -> &Vec<[f32; 3]>| pose.objects.iter().flat_map(move |o| of(&o.mesh).iter().copied());
    let (positions, normals): (Vec<_>, Vec<_>) = (all(|mesh| &mesh.positions).collect(), all(|mesh| &mesh.normals).collect());
    let receivers = receivers(shadows, sets, &positions, &normals);
    let with_spheres = pose.objects.iter().filter(|o| o.spheres.is_some());
    let follow = |(object, set): (&relume_scenes::Object, &SphereSet)| {
        let mut spheres = Spheres::at_rest(set);
        Follower::new(set).follow(&object.mesh.positions, &mut spheres.now)?;
        Ok(spheres)
    };
    let spheres = with_spheres.zip(sets).map(follow).collect::<Result<Vec<Spheres>>>()?;
    Ok(Posed { receivers: some.iter().map(|vertex| receivers[*vertex]).collect(), spheres, table: HaarTable::bake() })
}

impl Posed {
    /// Radiance at the receivers; light and lobes carry the terms that are kept.
    pub(super) fn under(&self, lobes: &[Function], light: &[Function; 3], levels: Levels) -> Vec<Rgb> {
        let mut radiance = vec![[0.0; 3]; self.receivers.len()];
        Shading::new(lobes, light, levels).radiance(&self.receivers, &self.spheres, &self.table, &mut radiance);
        radiance
    }
}

/// Haar coefficients of a held-out light.
fn planes(lights: &HeldOutLights, state: usize) -> [Vec<f32>; 3] {
    std::array::from_fn(|c| lights.coefficients.iter().skip(3 * state + c).step_by(RADIANCES).copied().collect())
}

/// Relative L2 error under a light, NaN if it shows nothing.
fn error(ours: &[Rgb], truth: &[[f32; RADIANCES]], state: usize) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for (ours, truth) in ours.iter().zip(truth) {
        for (ours, truth) in ours.iter().zip(&truth[3 * state..]) {
            off += (f64::from(*ours) - f64::from(*truth)).powi(2);
            norm += f64::from(*truth).powi(2);
        }
    }
    if norm > 0.0 { (off / norm).sqrt() } else { f64::NAN }
}
