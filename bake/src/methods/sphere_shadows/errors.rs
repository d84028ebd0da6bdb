//! How far shadows are from those of the meshes: rays against the pixel basis, at some
//! receivers, in some poses, under the held-out lights.

use super::rows::MAX_EXACT;
use super::truth::{self, TEXELS, Truth};
use crate::error::Result;
use crate::job::Job;
use crate::stage::Stage;
use crate::trace::held_out_lights::{Exact, HeldOutLights, RADIANCES, STATES};
use crate::trace::receivers::places;
use crate::work_log::WorkLog;
use relume_formats::Place;
use relume_formats::basis::diffuse::NODES;
use relume_formats::basis::two_level::SIDE;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::evaluate::sphere_shadows::{
    CasterMeshes, Casters, Detail, Function, Levels, Receiver, Spheres, light, lobe,
    receivers as shading_receivers,
};
use relume_formats::fast::sphere_shadows::Shading;
use relume_formats::kinds::sphere_shadows::Casts;
use relume_formats::kinds::{Environment, HaarTable, SphereSet, SphereShadows};
use relume_formats::state::{Rgb, ShapeState, State};
use relume_scenes::Scene;
use std::collections::BTreeMap;

/// Receivers that are looked at.
const RECEIVERS: usize = 1024;
/// Poses that are looked at besides rest, if anything deforms.
const POSES: usize = 4;

/// Relative L2 errors over the receivers, one for each pose and light; NaN where that shows nothing.
pub struct Measured {
    /// As the player shows it.
    pub shown: Vec<f64>,
    /// With all terms: what spheres and simplified meshes alone do.
    pub all_terms: Vec<f64>,
    /// What was compared.
    pub on: String,
}

/// What a bake is measured on.
pub struct Measuring {
    lights: HeldOutLights,
    poses: Vec<Scene>,
    some: Vec<usize>,
}

impl Measuring {
    /// Lights made of `maps`, poses and receivers of `scene`.
    ///
    /// # Errors
    /// If a clip leads beyond all numbers.
    pub fn new(scene: &Scene, maps: &[Environment]) -> Result<Self> {
        let vertices: usize = scene.objects.iter().map(|object| object.mesh.positions.len()).sum();
        Ok(Self {
            lights: HeldOutLights::new(maps, SIDE, false),
            poses: poses(scene)?,
            some: receivers_looked_at(vertices),
        })
    }

    /// What rays to the meshes of `scene` see; `None` if others trace some of it.
    ///
    /// # Errors
    /// If a log cannot be written or read, or the user interrupts.
    pub fn traced(
        &self,
        scene: &Scene,
        job: &Job,
        run: &dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>,
    ) -> Result<Option<Truth>> {
        truth::traced(scene, &self.poses, &self.some, &self.lights, job, run)
    }

    /// Errors of `shadows` with the spheres of `sets` against `truth`.
    ///
    /// # Errors
    /// If the user interrupts, or a sphere cannot follow.
    pub fn errors(
        &self,
        shadows: &SphereShadows,
        sets: &[SphereSet],
        truth: &Truth,
        job: &Job,
    ) -> Result<Measured> {
        let Self { lights, poses, some } = self;
        let progress = job.progress("measuring", (poses.len() * 2 * STATES) as u64);
        let rest = &poses[0];
        let posed = poses.iter().map(|pose| shown_in((rest, pose), some, shadows, sets));
        let posed = posed.collect::<Result<Vec<Posed>>>()?;
        let errors = |terms: Option<usize>, levels: Levels| -> Result<Vec<f64>> {
            let lobes = lobes(shadows, terms);
            let mut errors = vec![f64::NAN; poses.len() * STATES];
            for state in 0..STATES {
                // Folding light into lobes takes longer than shading, and serves all poses.
                let shading = Shading::new(&lobes, &light(planes(lights, state), terms), levels);
                for (pose, (ours, truth)) in posed.iter().zip(truth).enumerate() {
                    progress.check()?;
                    errors[pose * STATES + state] = error(&ours.under(&shading), truth, state);
                    progress.advance(1);
                }
            }
            Ok(errors)
        };
        let detail = Detail::of(&shadows.meta);
        let (shown, all_terms) = (errors(detail.terms, detail.levels)?, errors(None, Levels::All)?);
        let on = format!(
            "{STATES} held-out lights, the scene's maps turned, in {} poses, at {} vertices, against rays to the meshes; shadow maps of suns are taken to be exact",
            poses.len(),
            some.len()
        );
        Ok(Measured { shown, all_terms, on })
    }
}

/// The vertices, of so many, that bakes are measured at.
pub(super) fn receivers_looked_at(vertices: usize) -> Vec<usize> {
    some_of(vertices, RECEIVERS)
}

/// About `count` of so many `vertices`, one of each group of neighbours in their order, and of every group
/// another: every 17th of a tube with rings of 17 would be on the same side of it.
pub(super) fn some_of(vertices: usize, count: usize) -> Vec<usize> {
    /// The golden ratio less 1, in parts of 2³²: its multiples fall evenly.
    const GOLDEN: u32 = 2_654_435_769;
    let group = vertices.div_ceil(count).max(1);
    let within = |k: usize| (((k as u64 * u64::from(GOLDEN)) & u64::from(u32::MAX)) * group as u64) >> 32;
    let of_group = |k: usize| k * group + within(k) as usize;
    (0..vertices.div_ceil(group)).map(of_group).filter(|vertex| *vertex < vertices).collect()
}

/// The lobes of all rows with their `terms` of largest size.
pub fn lobes(shadows: &SphereShadows, terms: Option<usize>) -> Vec<Function> {
    (0..shadows.normals.len()).map(|row| lobe(shadows.lobe(row).to_vec(), terms)).collect()
}

/// Bytes that measuring holds at most: the hierarchy, the lights four times over, weights of all texels for
/// each row, and radiances.
pub fn predicted_bytes(scene: &Scene) -> u64 {
    let count =
        |of: fn(&relume_scenes::Mesh) -> usize| scene.objects.iter().map(|o| of(&o.mesh) as u64).sum::<u64>();
    let (triangles, vertices) = (count(|mesh| mesh.triangles.len()), count(|mesh| mesh.positions.len()));
    let rows = (NODES + MAX_EXACT) as u64;
    triangles * 600
        + vertices * (POSES as u64 + 2) * 100
        + (TEXELS * RADIANCES * 4 * 4) as u64
        + rows * TEXELS as u64 * 4 * 9
        + (64 << 20)
}

/// The scene at rest, and with all that deforms at moments between those that the spheres were fitted to.
pub(super) fn poses(scene: &Scene) -> Result<Vec<Scene>> {
    let moment = |k: usize| {
        let clip = |shape: &relume_formats::shape::DeformingMesh| {
            let clip = shape.clips.get(k % shape.clips.len().max(1))?;
            Some(ShapeState {
                clip: Some(clip.name.clone()),
                time_s: Some(clip.duration_s * (2 * k + 1) as f32 / (2 * (POSES + 1)) as f32),
                ..ShapeState::default()
            })
        };
        let shapes = scene.objects.iter().filter_map(|o| Some((o.name.clone(), clip(o.shape.as_deref()?)?)));
        State { shapes: shapes.collect::<BTreeMap<_, _>>(), ..State::default() }
    };
    let deforms = scene.objects.iter().any(|o| o.shape.is_some());
    let posed = (0..if deforms { POSES } else { 0 })
        .map(|k| Ok(scene.with_state(&moment(k), &Place::file(&scene.file))?));
    std::iter::once(Ok(scene.clone())).chain(posed).collect()
}

/// Receivers and spheres in a pose.
pub struct Posed {
    /// What is shaded.
    pub receivers: Vec<Receiver>,
    /// What blocks their view.
    pub casters: Casters,
    /// Of the two-level transform.
    pub table: HaarTable,
}

/// What `shadows` and `sets`, those of the objects that cast by one, make of `pose` of what is at `rest`, at
/// `some` of the vertices.
///
/// # Errors
/// If a sphere cannot follow.
pub fn shown_in(
    (rest, pose): (&Scene, &Scene),
    some: &[usize],
    shadows: &SphereShadows,
    sets: &[SphereSet],
) -> Result<Posed> {
    let receivers = receivers_of(pose, shadows, sets);
    let casting = pose.objects.iter().zip(&shadows.meta.objects);
    let casting = casting.filter(|(_, object)| object.casts == Casts::Spheres);
    let follow = |((object, _), set): ((&relume_scenes::Object, _), &SphereSet)| {
        spheres_in(set, &object.mesh.positions)
    };
    let spheres = casting.zip(sets).map(follow).collect::<Result<Vec<Spheres>>>()?;
    let mut triangles = Vec::new();
    CasterMeshes::new(shadows, &all(rest, |mesh| &mesh.positions)).place(
        &all(pose, |mesh| &mesh.positions),
        &all(pose, |mesh| &mesh.normals),
        &mut triangles,
    );
    Ok(Posed {
        receivers: some.iter().map(|vertex| receivers[*vertex]).collect(),
        casters: Casters { spheres, triangles },
        table: HaarTable::bake(),
    })
}

/// Something of all vertices of `scene`.
pub(super) fn all(scene: &Scene, of: fn(&relume_scenes::Mesh) -> &Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    scene.objects.iter().flat_map(|o| of(&o.mesh).iter().copied()).collect()
}

/// The vertices of `pose` as receivers; `sets` are those of the objects that cast by spheres.
pub(super) fn receivers_of(pose: &Scene, shadows: &SphereShadows, sets: &[SphereSet]) -> Vec<Receiver> {
    let places: Vec<_> = pose.objects.iter().flat_map(|object| places(&object.mesh)).collect();
    shading_receivers(shadows, sets, &places, &all(pose, |mesh| &mesh.normals))
}

/// The spheres of `set` where their mesh has its vertices at `positions`.
///
/// # Errors
/// If one cannot follow.
pub(super) fn spheres_in(set: &SphereSet, positions: &[[f32; 3]]) -> Result<Spheres> {
    let mut spheres = Spheres::at_rest(set);
    Follower::new(set).follow(positions, &mut spheres.now)?;
    Ok(spheres)
}

impl Posed {
    /// Radiance at the receivers.
    pub fn under(&self, shading: &Shading) -> Vec<Rgb> {
        let mut radiance = vec![[0.0; 3]; self.receivers.len()];
        shading.radiance(&self.receivers, &self.casters, &self.table, &mut radiance);
        radiance
    }
}

/// Haar coefficients of a held-out light.
fn planes(lights: &HeldOutLights, state: usize) -> [Vec<f32>; 3] {
    std::array::from_fn(|c| {
        lights.coefficients.iter().skip(3 * state + c).step_by(RADIANCES).copied().collect()
    })
}

/// Error under a light, relative L2 of all that is seen, NaN if that is nothing.
fn error(ours: &[Rgb], truth: &[Exact], state: usize) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for (ours, truth) in ours.iter().zip(truth) {
        let truth = truth.given[3 * state..].iter().zip(&truth.seen[3 * state..]);
        for (ours, (given, seen)) in ours.iter().zip(truth) {
            off += (f64::from(*ours) - f64::from(*given)).powi(2);
            norm += f64::from(*seen).powi(2);
        }
    }
    if norm > 0.0 { (off / norm).sqrt() } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertices of tubes and grids repeat in rings and rows: some of every place in them are looked at.
    #[test]
    fn every_place_in_a_ring_is_looked_at() {
        for (ring, vertices) in [(17, 8_704), (9, 9_216), (65, 4_225), (20, 20_480)] {
            let some = some_of(vertices, 512);
            let at = |place: usize| some.iter().filter(|vertex| **vertex % ring == place).count();
            let (fair, found) = (some.len() / ring, (0..ring).map(at));
            assert!(some.len().abs_diff(512) <= 64 && some.is_sorted_by(|a, b| a < b));
            assert!(
                found.clone().all(|n| n >= fair / 2 && n <= 2 * fair + 2),
                "{:?}",
                found.collect::<Vec<_>>()
            );
        }
        assert_eq!(some_of(3, 512), [0, 1, 2]);
        assert!(some_of(0, 512).is_empty());
    }
}
