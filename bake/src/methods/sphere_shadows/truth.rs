//! What the shadows of spheres are judged by: what rays to the meshes see, at some receivers in each pose. A
//! log of it depends on no map; radiances follow from the bits and the normals.

use super::settings::{NAME, REVISION};
use crate::compress::frame::{grow, shrink};
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::scene_hash::{Part, hash_of};
use crate::stage::Stage;
use crate::trace::held_out_lights::{Exact, HeldOutLights, exact_radiances};
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::spans::{Eye, TexelRays, TexelSet};
use crate::trace::world::World;
use crate::work_log::WorkLog;
use glam::Vec3A;
use rayon::prelude::*;
use relume_formats::basis::cubemap::{self, FACES};
use relume_formats::basis::diffuse;
use relume_formats::basis::haar::inverse_cube;
use relume_formats::basis::two_level::SIDE;
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// Texels of the light.
pub(super) const TEXELS: usize = FACES * SIDE * SIDE;
/// Receivers that one thread takes at a time.
const CHUNK: usize = 16;

/// Radiance of a white surface at the receivers under all lights, of each pose.
pub type Truth = Vec<Vec<Exact>>;

/// What rays to the meshes of `scene` see from `some` vertices in all `poses`, a stage for each, under
/// `lights`; `None` if others make pieces of one.
///
/// # Errors
/// If a log cannot be written or read, or the user interrupts.
pub(super) fn traced(
    scene: &Scene,
    poses: &[Scene],
    some: &[usize],
    lights: &HeldOutLights,
    job: &Job,
    run: &dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>,
) -> Result<Option<Truth>> {
    let reads = hash_of(scene, &[Part::Geometry, Part::Shapes, Part::Textures]);
    let mut truth = Some(Vec::new());
    for (number, pose) in poses.iter().enumerate() {
        let key = xxh3_128(format!("{reads:032x} {number} {REVISION}").as_bytes());
        let preparing = job.step("preparing");
        let stage = Tracing { number, eyes: Eyes::new(pose), some, key };
        drop(preparing);
        // All poses are begun, for shares of a cluster have pieces of each.
        truth = match (run(&stage)?, truth) {
            (Some(log), Some(mut truth)) => {
                truth.push(stage.read(&log, lights, job)?);
                Some(truth)
            }
            _ => None,
        };
    }
    Ok(truth)
}

/// Tracing one pose, some receivers a piece.
struct Tracing<'a> {
    number: usize,
    eyes: Eyes,
    some: &'a [usize],
    key: u128,
}

impl Stage for Tracing<'_> {
    fn name(&self) -> String {
        format!("{NAME}-pose-{}", self.number)
    }

    fn label(&self) -> Option<&'static str> {
        Some("tracing")
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        self.some.len().div_ceil(CHUNK) as u32
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let seen = self
            .looked_at(number)
            .iter()
            .flat_map(|vertex| self.eyes.look(*vertex).to_bytes().collect::<Vec<u8>>());
        Ok(shrink(&seen.collect::<Vec<u8>>())?)
    }

    fn first_share(&self) -> u32 {
        self.number as u32 * self.pieces()
    }

    fn keeps_log(&self) -> bool {
        true
    }
}

impl Tracing<'_> {
    /// The vertices of a piece.
    fn looked_at(&self, piece: u32) -> &[usize] {
        let first = piece as usize * CHUNK;
        &self.some[first..(first + CHUNK).min(self.some.len())]
    }

    /// Radiances of all receivers, in their order.
    fn read(&self, log: &WorkLog, lights: &HeldOutLights, job: &Job) -> Result<Vec<Exact>> {
        let progress = job.progress("projecting", self.pieces().into());
        let of_piece = |piece: u32| {
            progress.check()?;
            let looked_at = self.looked_at(piece);
            let bytes = looked_at.len() * TEXELS / 8;
            let seen = grow(&log.read(piece)?, bytes).filter(|seen| seen.len() == bytes);
            let of_vertex = |(vertex, seen): (&usize, &[u8])| {
                Some(self.eyes.radiances(*vertex, &TexelSet::from_bytes(SIDE, seen)?, lights))
            };
            let of_all = |seen: Vec<u8>| {
                looked_at.iter().zip(seen.chunks_exact(TEXELS / 8)).map(of_vertex).collect::<Option<Vec<_>>>()
            };
            let radiances = seen.and_then(of_all);
            let radiances = radiances
                .ok_or_else(|| log.refuse("holds bits of other receivers; bake again with --force"))?;
            progress.advance(1);
            Ok::<_, BakeError>(radiances)
        };
        let pieces = (0..self.pieces()).into_par_iter().map(of_piece).collect::<Result<Vec<_>>>()?;
        Ok(pieces.concat())
    }
}

/// What looks from the vertices of a pose at the light.
pub(super) struct Eyes {
    world: World,
    receivers: Vec<Receiver>,
    rays: TexelRays,
}

impl Eyes {
    pub(super) fn new(pose: &Scene) -> Self {
        Self { world: World::new(pose), receivers: receivers(pose), rays: TexelRays::centres(SIDE) }
    }

    /// The texels that light `vertex` and whose centre is unblocked, as a ray sees the meshes.
    pub(super) fn look(&self, vertex: usize) -> TexelSet {
        let Receiver { origin, normal } = self.receivers[vertex];
        let row = row(normal);
        let mut seen = TexelSet::of(SIDE, |texel| row[texel] != 0.0);
        // What of a texel is above the horizon while its centre is below is seen by its centre all the same,
        // unless the surface is in the way: so there is no horizon.
        self.world.see(Eye { origin, horizon: None, rays: &self.rays, within: None }, &mut seen);
        seen
    }

    /// Radiance of a white surface at `vertex`, which sees the texels of `seen`, under all lights.
    pub(super) fn radiances(&self, vertex: usize, seen: &TexelSet, lights: &HeldOutLights) -> Exact {
        let mut row = row(self.receivers[vertex].normal);
        for (texel, value) in row.iter_mut().enumerate() {
            if !seen.has(texel / SIDE, texel % SIDE) {
                *value = 0.0;
            }
        }
        exact_radiances(&[row], lights)
    }
}

/// The diffuse lobe of a receiver whose `normal` this is, by texels.
fn row(normal: Vec3A) -> Vec<f32> {
    let mut row = diffuse::lobe(normal.into());
    inverse_cube(&mut row, SIDE);
    row
}

/// The direction of a texel's centre.
pub fn centre(texel: usize) -> Vec3A {
    let (x, y) = (texel % SIDE, texel / SIDE % SIDE);
    cubemap::direction(texel / (SIDE * SIDE), SIDE, x as f64 + 0.5, y as f64 + 0.5).as_vec3a()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::ProgressMode;
    use crate::methods::environment_lit::environments;
    use crate::stage::{Share, fill};

    #[test]
    fn radiances_of_a_log_are_those_that_rays_give_bit_for_bit() {
        let scene = relume_scenes::load(&relume_scenes::resolve("knot-twist").unwrap()).unwrap();
        let lights = HeldOutLights::new(&environments(&scene), SIDE, false);
        let (eyes, job) = (Eyes::new(&scene), Job::new(ProgressMode::None));
        // One piece and a half, on the knot and on the plane.
        let some: Vec<usize> = (0..eyes.receivers.len()).step_by(eyes.receivers.len() / 23).collect();
        let by_rays = |vertex: &usize| {
            let Receiver { origin, normal } = eyes.receivers[*vertex];
            let mut row = diffuse::lobe(normal.into());
            inverse_cube(&mut row, SIDE);
            for (texel, value) in row.iter_mut().enumerate() {
                if *value != 0.0 && eyes.world.occluded(origin, centre(texel), f32::INFINITY) {
                    *value = 0.0;
                }
            }
            exact_radiances(&[row], &lights)
        };
        let expected: Vec<_> = some.iter().map(by_rays).collect();
        let folder = tempfile::tempdir().unwrap();
        let log = WorkLog::create(&folder.path().join("log"), 0).unwrap();
        let stage = Tracing { number: 0, eyes: Eyes::new(&scene), some: &some, key: 0 };
        fill(&stage, &log, Share::WHOLE, &job).unwrap();
        let found = stage.read(&log, &lights, &job).unwrap();
        assert!(found == expected && expected.iter().any(|radiances| radiances.given[0] > 0.0));
        let fewer = Tracing { some: &some[1..], ..stage };
        assert!(fewer.read(&log, &lights, &job).unwrap_err().to_string().contains("other receivers"));
    }
}
