//! What each object could cast shadows by, and by how much each of these is wrong.

use super::surface::{Simplified, Surface};
use super::{By, put};
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::methods::sphere_shadows::errors::{all, poses, receivers_of, some_of, spheres_in};
use crate::methods::sphere_shadows::method::Asked;
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES, add};
use glam::Vec3;
use rayon::prelude::*;
use relume_formats::basis::cap::Bitmap;
use relume_formats::basis::cubemap::{self, FACES};
use relume_formats::basis::two_level::SIDE;
use relume_formats::evaluate::sphere_shadows::{CasterMeshes, Casters, Own, Receiver, Spheres};
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

impl CasterOption {
    /// Its error in the pose and under the light where that is largest.
    pub fn error(&self) -> f64 {
        self.squares.iter().copied().fold(0.0, f64::max).sqrt()
    }
}

/// Options of every object of `scene`, whose receivers are those of `shadows`, as they are `asked` for, the
/// cheapest first, those by spheres of `sets` among them where given: of the objects that have some, in their
/// order. No mesh is tried with more triangles than it takes to be wrong by a quarter of the error asked for.
///
/// # Errors
/// If a clip leads beyond all numbers, a sphere cannot follow, or the user interrupts.
pub fn options(
    scene: &Scene,
    shadows: &SphereShadows,
    maps: &[Environment],
    sets: Option<&[SphereSet]>,
    asked: Asked,
    job: &Job,
) -> Result<Vec<Vec<CasterOption>>> {
    let progress = job.progress("choosing casters", scene.objects.len() as u64);
    let looking = Looking::new(scene, shadows, maps)?;
    let wholes: Vec<Surface> = scene.objects.iter().map(Surface::new).collect();
    let norms = looking.norms(&wholes)?;
    let mut next_set = sets.unwrap_or_default().iter();
    let of_object = |(number, (object, surface)): (usize, (&Object, &Surface))| {
        let set = if object.spheres.is_some() { next_set.next() } else { None };
        let options = looking.options_of((number, surface), set, &norms, asked, &|| Ok(progress.check()?))?;
        progress.advance(1);
        Ok(options)
    };
    scene.objects.iter().zip(&wholes).enumerate().map(of_object).collect()
}

/// What options are looked at with.
struct Looking {
    poses: Vec<Scene>,
    /// Of each pose, which vertices they are, and how they stand there.
    receivers: Vec<Vec<(usize, Receiver)>>,
    lights: HeldOutLights,
    /// The objects, without rows, which say nothing of what is blocked; nothing casts.
    objects: SphereShadows,
    /// Directions of texels, with their solid angles over π.
    texels: Vec<(Vec3, f32)>,
}

impl Looking {
    fn new(scene: &Scene, shadows: &SphereShadows, maps: &[Environment]) -> Result<Self> {
        let poses = poses(scene)?;
        let vertices = shadows.meta.vertices() as usize;
        let some = some_of(vertices, RECEIVERS);
        let receivers = poses.iter().map(|pose| {
            let all = receivers_of(pose, shadows, &[]);
            let places: Vec<Vec3> = some.iter().map(|vertex| all[*vertex].position).collect();
            order(&places).into_iter().map(|k| (some[k as usize], all[some[k as usize]])).collect()
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
            objects: SphereShadows {
                meta: shadows.meta.clone(),
                rows: Vec::new(),
                normals: Vec::new(),
                lobes: Vec::new(),
                order: Vec::new(),
                casters: Vec::new(),
                caster_offsets: Vec::new(),
                caster_errors: Vec::new(),
            },
            texels,
        })
    }

    /// What of the view of each receiver of `pose` is blocked if object `number` casts `by` that, or by the
    /// spheres of `set`, and no other does.
    ///
    /// # Errors
    /// If a sphere cannot follow.
    fn blocked(
        &self,
        pose: usize,
        (number, by): (usize, &By),
        set: Option<&SphereSet>,
    ) -> Result<Vec<Bitmap>> {
        let mut alone = self.objects.clone();
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
        let mesh = &pose_now.objects[number].mesh;
        let spheres = set.map(|set| spheres_in(set, &mesh.positions)).transpose()?;
        let first = alone.meta.objects[number].first_vertex as usize;
        let placed = |(vertex, receiver): &(usize, Receiver)| {
            let is_own = receiver.object as usize == number;
            let cluster = set.filter(|_| is_own).and_then(|set| set.clusters.get(vertex - first));
            Receiver { own: cluster.map(|sphere| Own { set: 0, sphere: *sphere }), ..*receiver }
        };
        let receivers: Vec<Receiver> = self.receivers[pose].iter().map(placed).collect();
        Ok(bitmaps(
            &receivers,
            &Casters { spheres: spheres.into_iter().collect::<Vec<Spheres>>(), triangles },
        ))
    }

    /// Squared norm of the light at the receivers, that of suns too, in each pose, under each held-out light,
    /// with the whole meshes of all objects.
    fn norms(&self, wholes: &[Surface]) -> Result<Vec<f64>> {
        let of_pose = |pose: usize| {
            let mut blocked: Vec<Bitmap> = vec![[0; FACES * SIDE]; self.receivers[pose].len()];
            for (number, whole) in wholes.iter().enumerate() {
                let by = By::from(whole.whole());
                for (all, one) in blocked.iter_mut().zip(self.blocked(pose, (number, &by), None)?) {
                    all.iter_mut().zip(one).for_each(|(all, one)| *all |= one);
                }
            }
            let seen: Vec<Bitmap> = blocked.into_iter().map(|bitmap| bitmap.map(|row| !row)).collect();
            Ok(self.squares(pose, &seen, &vec![[0; FACES * SIDE]; seen.len()], &self.lights.whole))
        };
        Ok((0..self.poses.len()).map(of_pose).collect::<Result<Vec<_>>>()?.concat())
    }

    /// Squared norm, over the receivers of a pose, of the light from the texels that are in one of the
    /// bitmaps and not in the other, under each of `lights`.
    fn squares(&self, pose: usize, some: &[Bitmap], others: &[Bitmap], lights: &[f32]) -> Vec<f64> {
        let of = |(((_, receiver), one), other): ((&(usize, Receiver), &Bitmap), &Bitmap)| {
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
        (number, surface): (usize, &Surface),
        set: Option<&SphereSet>,
        norms: &[f64],
        asked: Asked,
        check: &dyn Fn() -> Result<()>,
    ) -> Result<Vec<CasterOption>> {
        let whole = By::from(surface.whole());
        let truth = (0..self.poses.len()).map(|pose| self.blocked(pose, (number, &whole), None));
        let truth = truth.collect::<Result<Vec<Vec<Bitmap>>>>()?;
        let squares = |by: By, set: Option<&SphereSet>| {
            let mut squares = Vec::with_capacity(norms.len());
            for (pose, truth) in truth.iter().enumerate() {
                check()?;
                let ours = self.blocked(pose, (number, &by), set)?;
                squares.extend(self.squares(pose, &ours, truth, &self.lights.texels));
            }
            // Where nothing shines there is no error.
            let relative = |(square, norm): (f64, &f64)| if *norm > 0.0 { square / norm } else { 0.0 };
            Ok::<_, BakeError>(CasterOption {
                by,
                squares: squares.into_iter().zip(norms).map(relative).collect(),
            })
        };
        let by_spheres = |set: &SphereSet| squares(By::Spheres(set.spheres.len() as u32), Some(set));
        let mut options = match (asked, set) {
            (Asked::Error(_), _) => vec![squares(By::Nothing, None)?],
            (Asked::Triangles(count), _) => return Ok(vec![squares(surface.about(count).into(), None)?]),
            (Asked::Spheres, Some(set)) => return Ok(vec![by_spheres(set)?]),
            (Asked::Spheres, None) => {
                return Ok(vec![squares(surface.about(MOST_TRIANGLES).into(), None)?]);
            }
        };
        for simplified in simplifications(surface) {
            let option = squares(simplified.into(), None)?;
            let worst = option.error();
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

#[cfg(test)]
mod tests {
    use super::super::super::rows;
    use super::*;
    use crate::job::ProgressMode;
    use crate::methods::environment_lit::environments;
    use crate::spheres::fit::{Settings, fit};
    use relume_formats::Place;

    /// A ball of one sphere over a plane, under an even sky.
    const BALL: &str = "[vary]\nlight = true\n[render]\nsize = [32, 24]\nreflections = 1\n\
        [camera]\nposition = [0.0, 2.0, 5.0]\ntarget = [0.0, 0.5, 0.0]\nfov_deg = 40.0\n\
        [materials.white]\nbrdf = 'blinn-phong'\nkd = [0.8, 0.8, 0.8]\n\
        [[object]]\nname = 'plane'\nshape = 'quad'\nsegments = 8\nmaterial = 'white'\ntransform = { scale = 4.0 }\n\
        [[object]]\nname = 'ball'\nshape = 'sphere'\nsubdivisions = 3\nmaterial = 'white'\nspheres = 1\n\
        transform = { translation = [0.0, 1.0, 0.0], scale = 0.4 }\n[environment]\n";

    /// Options of the objects of a scene, the second of which has spheres.
    fn options_in(text: &str, asked: Asked) -> Vec<Vec<CasterOption>> {
        let (folder, job) = (tempfile::tempdir().unwrap(), Job::new(ProgressMode::None));
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        let scene = relume_scenes::load(&path).unwrap();
        let settings = Settings { spheres: 1, seed: 0, iterations: 8, tight: 0.0 };
        let set =
            fit(&scene.objects[1].mesh, &[], "ball", &Place::file("test"), &settings, &job).unwrap().set;
        let maps = environments(&scene);
        options(&scene, &rows::bake(&scene), &maps, Some(&[set]), asked, &job).unwrap()
    }

    #[test]
    fn what_has_no_thickness_is_not_lost() {
        let disc = "[[object]]\nname = 'disc'\nshape = 'ring'\nheight = 1e-12\nmaterial = 'white'\n";
        let text = BALL.replace("[environment]", &format!("{disc}[environment]"));
        let best = |asked: Asked| {
            let option = options_in(&text, asked).pop().unwrap().pop().unwrap();
            (option.error(), option.by)
        };
        let (error, by) = best(Asked::Error(0.01));
        assert!(matches!(by, By::Mesh(_)) && error < 0.01 / 4.0, "{error}");
        let (error, by) = best(Asked::Triangles(1024));
        assert!(matches!(by, By::Mesh(_)) && error == 0.0, "{error}");
    }

    #[test]
    fn options_are_as_wrong_as_they_look() {
        let options = options_in(BALL, Asked::Error(1e-9));
        let error = CasterOption::error;
        let [plane, ball] = &options[..] else { panic!("two objects") };
        // The plane takes the sky's lower half from the ball, and so do two triangles of it.
        assert!(error(&plane[0]) > 0.05 && plane.iter().skip(1).all(|option| error(option) < 1e-3));
        let nothing = error(&ball[0]);
        let spheres = ball.iter().find(|option| matches!(option.by, By::Spheres(_))).unwrap();
        // The sphere is the ball to 1 %; what is on it does not lie in the dark.
        assert!(error(spheres) < 0.1 * nothing, "{} of {nothing}", error(spheres));
        let meshes: Vec<f64> =
            ball.iter().filter(|option| matches!(option.by, By::Mesh(_))).map(error).collect();
        // Few triangles are off by a part of the ball's own shading, and all of them by nothing.
        assert!(meshes[0] > 0.002 && meshes[7] < 1e-3 && meshes.last() == Some(&0.0), "{meshes:?}");
    }
}
