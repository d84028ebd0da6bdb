//! What each object could cast shadows by, and by how much each of these is wrong.

use super::surface::{Simplified, Surface};
use super::{By, put};
use crate::error::Result;
use crate::job::Job;
use crate::methods::sphere_shadows::errors::{all, poses, receivers_of, spheres_in};
use crate::methods::sphere_shadows::method::Asked;
use crate::methods::sphere_shadows::rows;
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES, add};
use glam::Vec3;
use rayon::prelude::*;
use relume_formats::basis::cap::Bitmap;
use relume_formats::basis::cubemap::{self, FACES};
use relume_formats::basis::two_level::SIDE;
use relume_formats::evaluate::sphere_shadows::{CasterMeshes, Casters, Receiver, Spheres};
use relume_formats::fast::sphere_shadows::{bitmaps, order};
use relume_formats::kinds::{Environment, SphereSet, SphereShadows};
use relume_scenes::{Object, Scene};

/// Receivers that are looked at.
const RECEIVERS: usize = 512;
/// Most triangles that an object casts by.
const MOST_TRIANGLES: usize = 8192;
/// Numbers of triangles that meshes are simplified to, in parts of the next power of 2.
const STEPS: [usize; 2] = [2, 3];

/// Something that an object could cast by.
pub struct CasterOption {
    /// What.
    pub by: By,
    /// Squared error, relative to the light of the whole scene, in each pose and under each held-out light,
    /// [poses, [`STATES`]].
    pub squares: Vec<f64>,
}

/// Options of every object as they are `asked` for, the cheapest first, those by spheres of `sets` among them where
/// given: of the objects that have some, in their order. No mesh is tried with more triangles than it takes to be
/// wrong by a quarter of the error asked for.
///
/// # Errors
/// If a clip leads beyond all numbers, a sphere cannot follow, or the user interrupts.
pub fn options(
    scene: &Scene,
    maps: &[Environment],
    sets: Option<&[SphereSet]>,
    asked: Asked,
    job: &Job,
) -> Result<Vec<Vec<CasterOption>>> {
    let progress = job.progress("choosing casters", scene.objects.len() as u64);
    let looking = Looking::new(scene, maps)?;
    let wholes: Vec<Surface> = scene.objects.iter().map(Surface::new).collect();
    let shadows = rows::bake(scene);
    let norms = looking.norms(&shadows, &wholes);
    let mut next_set = sets.unwrap_or_default().iter();
    let of_object = |(number, (object, surface)): (usize, (&Object, &Surface))| {
        progress.check()?;
        let set = if object.spheres.is_some() { next_set.next() } else { None };
        let options = looking.options_of(&shadows, (number, surface), set, &norms, asked)?;
        progress.advance(1);
        Ok(options)
    };
    scene.objects.iter().zip(&wholes).enumerate().map(of_object).collect()
}

/// What options are looked at with.
struct Looking {
    poses: Vec<Scene>,
    /// Of each pose.
    receivers: Vec<Vec<Receiver>>,
    lights: HeldOutLights,
    /// Directions of texels, with their solid angles over π.
    texels: Vec<(Vec3, f32)>,
}

impl Looking {
    fn new(scene: &Scene, maps: &[Environment]) -> Result<Self> {
        let poses = poses(scene)?;
        let shadows = rows::bake(scene);
        let vertices = shadows.meta.vertices() as usize;
        let some: Vec<usize> = (0..vertices).step_by(vertices.div_ceil(RECEIVERS).max(1)).collect();
        let receivers = poses.iter().map(|pose| {
            let all = receivers_of(pose, &shadows, &[]);
            let some: Vec<Receiver> = some.iter().map(|vertex| all[*vertex]).collect();
            let places: Vec<Vec3> = some.iter().map(|receiver| receiver.position).collect();
            order(&places).into_iter().map(|k| some[k as usize]).collect()
        });
        let solid_angles = cubemap::solid_angles(SIDE);
        let texel = |i: usize| {
            let at = |k: usize| (k % SIDE) as f64 + 0.5;
            let direction = cubemap::direction(i / (SIDE * SIDE), SIDE, at(i), at(i / SIDE)).as_vec3();
            (direction, (solid_angles[i % (SIDE * SIDE)] / std::f64::consts::PI) as f32)
        };
        let texels = (0..FACES * SIDE * SIDE).map(texel).collect();
        Ok(Self {
            receivers: receivers.collect(),
            poses,
            lights: HeldOutLights::new(maps, SIDE, false),
            texels,
        })
    }

    /// What of the view of each receiver of `pose` is blocked if object `number` casts `by` that, and no other
    /// does.
    fn blocked(
        &self,
        pose: usize,
        shadows: &SphereShadows,
        (number, by): (usize, &By),
        spheres: Option<Spheres>,
    ) -> Vec<Bitmap> {
        let mut alone =
            SphereShadows { lobes: Vec::new(), order: Vec::new(), rows: Vec::new(), ..shadows.clone() };
        let mut casts = vec![By::Nothing; alone.meta.objects.len()];
        casts[number] = by.clone();
        put(&mut alone, &casts);
        let mut triangles = Vec::new();
        let pose_now = &self.poses[pose];
        CasterMeshes::new(&alone, &all(&self.poses[0], |mesh| &mesh.positions)).place(
            &all(pose_now, |mesh| &mesh.positions),
            &all(pose_now, |mesh| &mesh.normals),
            &mut triangles,
        );
        bitmaps(&self.receivers[pose], &Casters { spheres: spheres.into_iter().collect(), triangles })
    }

    /// Squared norm of the light at the receivers, that of suns too, in each pose, under each held-out light, with the whole meshes of
    /// all objects.
    fn norms(&self, shadows: &SphereShadows, wholes: &[Surface]) -> Vec<f64> {
        let of_pose = |pose: usize| {
            let mut blocked: Vec<Bitmap> = vec![[0; FACES * SIDE]; self.receivers[pose].len()];
            for (number, whole) in wholes.iter().enumerate() {
                let by = By::Mesh(whole.whole());
                for (all, one) in blocked.iter_mut().zip(self.blocked(pose, shadows, (number, &by), None)) {
                    all.iter_mut().zip(one).for_each(|(all, one)| *all |= one);
                }
            }
            let seen: Vec<Bitmap> = blocked.into_iter().map(|bitmap| bitmap.map(|row| !row)).collect();
            self.squares(pose, &seen, &vec![[0; FACES * SIDE]; seen.len()], &self.lights.whole)
        };
        (0..self.poses.len()).flat_map(of_pose).collect()
    }

    /// Squared norm, over the receivers of a pose, of the light from the texels that are in one of the bitmaps and
    /// not in the other, under each of `lights`.
    fn squares(&self, pose: usize, some: &[Bitmap], others: &[Bitmap], lights: &[f32]) -> Vec<f64> {
        let of = |((receiver, one), other): ((&Receiver, &Bitmap), &Bitmap)| {
            let mut light = [0.0; RADIANCES];
            for (row, (one, other)) in one.iter().zip(other).enumerate() {
                let mut left = one ^ other;
                while left != 0 {
                    let x = left.trailing_zeros();
                    left &= left - 1;
                    let texel = row * SIDE + x as usize;
                    let (direction, weight) = self.texels[texel];
                    let sign = if one >> x & 1 == 1 { weight } else { -weight };
                    let value = sign * receiver.normal.dot(direction).max(0.0);
                    add(&mut light, &[value], &lights[texel * RADIANCES..][..RADIANCES]);
                }
            }
            light
        };
        let lights: Vec<[f32; RADIANCES]> =
            self.receivers[pose].par_iter().zip(some).zip(others).map(of).collect();
        let of_state = |state: usize| {
            let radiances = lights.iter().flat_map(|light| &light[3 * state..][..3]);
            radiances.map(|x| f64::from(*x).powi(2)).sum()
        };
        (0..STATES).map(of_state).collect()
    }

    fn options_of(
        &self,
        shadows: &SphereShadows,
        (number, surface): (usize, &Surface),
        set: Option<&SphereSet>,
        norms: &[f64],
        asked: Asked,
    ) -> Result<Vec<CasterOption>> {
        let whole = By::Mesh(surface.whole());
        let truth: Vec<Vec<Bitmap>> =
            (0..self.poses.len()).map(|pose| self.blocked(pose, shadows, (number, &whole), None)).collect();
        let squares = |by: By, set: Option<&SphereSet>| {
            let mut squares = Vec::with_capacity(norms.len());
            for (pose, truth) in truth.iter().enumerate() {
                let mesh = &self.poses[pose].objects[number].mesh;
                let spheres = set.map(|set| spheres_in(set, &mesh.positions)).transpose()?;
                let ours = self.blocked(pose, shadows, (number, &by), spheres);
                squares.extend(self.squares(pose, &ours, truth, &self.lights.texels));
            }
            // Where nothing shines there is no error.
            let relative = |(square, norm): (f64, &f64)| if *norm > 0.0 { square / norm } else { 0.0 };
            Ok::<_, crate::error::BakeError>(CasterOption {
                by,
                squares: squares.into_iter().zip(norms).map(relative).collect(),
            })
        };
        let by_spheres = |set: &SphereSet| squares(By::Spheres(set.spheres.len() as u32), Some(set));
        let mut options = match (asked, set) {
            (Asked::Error(_), _) => vec![squares(By::Nothing, None)?],
            (Asked::Triangles(count), _) => return Ok(vec![squares(By::Mesh(surface.about(count)), None)?]),
            (Asked::Spheres, Some(set)) => return Ok(vec![by_spheres(set)?]),
            (Asked::Spheres, None) => {
                return Ok(vec![squares(By::Mesh(surface.about(MOST_TRIANGLES)), None)?]);
            }
        };
        for simplified in simplifications(surface) {
            let option = squares(By::Mesh(simplified), None)?;
            let worst = option.squares.iter().copied().fold(0.0, f64::max).sqrt();
            options.push(option);
            if matches!(asked, Asked::Error(error) if worst < error / 4.0) {
                break;
            }
        }
        if let Some(set) = set {
            options.push(by_spheres(set)?);
        }
        options.sort_by(|a, b| a.by.cost().total_cmp(&b.by.cost()));
        Ok(options)
    }
}

/// What a surface may be simplified to, from few triangles to many.
fn simplifications(surface: &Surface) -> impl Iterator<Item = Simplified> {
    let flat = surface.flat();
    let all = flat.triangles.len();
    let counts = (3..)
        .flat_map(|power| STEPS.map(|step| step << power))
        .take_while(move |n| *n < all.min(MOST_TRIANGLES));
    let few = counts.map(|count| surface.simplified(count));
    few.chain((all <= MOST_TRIANGLES).then_some(flat))
}
