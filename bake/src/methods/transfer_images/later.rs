//! Light after three reflections and more: what is to be known of a scene before its images are made, found
//! on some paths of it.

use super::albedo_errors::share_of_lobes;
use super::held_out::{CHOICE_PATHS, CHOICE_PIXELS, some_pixels};
use super::settings::Settings;
use crate::brdf;
use crate::error::Result;
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::trace::gather::{FirstVertex, Gather, GatherPath};
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use relume_formats::basis::half_difference::HalfDifference;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::MAX_BASES;
use relume_formats::kinds::transfer_images::{Later, LaterImages};
use relume_scenes::{ALL_REFLECTIONS, Scene, Vary};
use std::f32::consts::FRAC_1_PI;

/// Most materials for which the numerator is of degree 2: with more, its nodes would be more than the images
/// of first reflections.
const MOST_OF_DEGREE_2: usize = 8;
/// Fewest bases of the eye that keep later reflections, and of all the part: light that has been about is
/// smooth, and the first functions tell all of it that shows.
const EYE_BASES: usize = 4;
const EYE_SHARE: usize = 2;
/// Most materials whose surfaces before the eye's keep lobes, the images of which grow by the square of their
/// number: 80 for four.
const MOST_WITH_LOBES: usize = 4;
/// Glossy functions of the surface before that are kept, and bases of the eye for each: more make nothing
/// better that albedos at all other surfaces leave.
const LOBES: u32 = 2;
const LOBE_EYE_BASES: u32 = 2;
/// Least that lobes change random states by in the median, relative L2: less is not worth a third of a file.
pub(super) const LEAST_LOBES: f64 = 0.005;
/// Paths of each of some pixels that tell how much they change, be those of the bake ever so few.
const LOBE_PATHS: u32 = 64;
/// A typical albedo: how much light counts that was reflected before.
const TYPICAL_ALBEDO: f64 = 0.5;

/// What `scene` needs for its later reflections; `None` if it is not asked for them, or there are none.
///
/// # Errors
/// If the job is interrupted.
pub fn later(
    scene: &Scene,
    gather: &Gather<'_>,
    settings: &Settings,
    basis: &BrdfBasis,
    job: &Job,
) -> Result<Option<Later>> {
    let Some(kept) = kept(scene, settings.bases) else { return Ok(None) };
    let pixels = some_pixels(CHOICE_PIXELS, settings.size);
    let progress = job.progress("light between materials", pixels.len() as u64);
    let found = pixels.par_iter().map(|pixel| {
        progress.check()?;
        let mut light = Exchange::new(scene.vary.materials.len());
        gather.pixel(*pixel, settings.samples.min(CHOICE_PATHS), |path| light.add_path(path, scene));
        progress.advance(1);
        Ok(light)
    });
    let found = found.collect::<std::result::Result<Vec<Exchange>, Interrupted>>()?;
    let mut all = Exchange::new(scene.vary.materials.len());
    found.iter().for_each(|light| all.add(light));
    drop(progress);
    if !all.is_lit {
        return Ok(None);
    }
    let later = Later { albedos: albedos(basis), textures: all.textures(), returns: all.returns(), ..kept };
    if later.lobes == 0 {
        return Ok(Some(later));
    }
    let changed = share_of_lobes(scene, gather, (basis, &later), LOBE_PATHS, &pixels, job)?;
    let is_needed = changed.is_some_and(|changed| changed.median >= LEAST_LOBES);
    Ok(Some(if is_needed { later } else { Later { lobes: 0, lobe_eye_bases: 0, ..later } }))
}

/// The images that later reflections of `scene` take, if it is asked for them and has any.
pub fn images(scene: &Scene, bases: usize) -> Option<LaterImages> {
    kept(scene, bases).map(|later| later.images())
}

/// What is kept of later reflections, nothing known yet of what they are.
fn kept(scene: &Scene, bases: usize) -> Option<Later> {
    let materials = scene.vary.materials.len();
    let kept = Later {
        degree: if materials <= MOST_OF_DEGREE_2 { 2 } else { 1 },
        eye_bases: 0,
        lobes: if may_have_lobes(scene) { LOBES } else { 0 },
        lobe_eye_bases: LOBE_EYE_BASES,
        albedos: vec![0.0; bases],
        textures: vec![[1.0; 3]; materials],
        returns: Vec::new(),
    };
    (scene.reflections == ALL_REFLECTIONS).then(|| on_bases(kept, bases))
}

/// Whether surfaces before the eye's may keep lobes. Of lobes sharper than usual a few functions leave ripples that
/// are worse than none.
pub(super) fn may_have_lobes(scene: &Scene) -> bool {
    let Vary { materials, shininess_max, roughness_min, .. } = &scene.vary;
    materials.len() <= MOST_WITH_LOBES && shininess_max.is_none() && roughness_min.is_none()
}

/// The same on other `bases`, all that each needs.
pub fn on_bases(later: Later, bases: usize) -> Later {
    let eye_bases = bases.div_ceil(EYE_SHARE).max(EYE_BASES).min(bases);
    let lobes = later.lobes.min(bases as u32 - 1);
    let eye_bases = eye_bases as u32;
    let lobe_eye_bases = if lobes > 0 { later.lobe_eye_bases.min(eye_bases) } else { 0 };
    Later {
        eye_bases,
        lobes,
        lobe_eye_bases,
        albedos: later.albedos.iter().take(bases).copied().collect(),
        ..later
    }
}

/// How paths meet later reflections that are baked.
pub struct Nodes<'a> {
    later: &'a Later,
    /// The albedo of every class at every node, [nodes, classes].
    pub albedos: Vec<Vec<f32>>,
    /// Which nodes are those of lobes.
    pub of_lobes: Vec<usize>,
}

impl<'a> Nodes<'a> {
    /// Those of `later`.
    pub fn new(later: &'a Later) -> Self {
        Self { later, albedos: later.node_albedos(), of_lobes: later.lobe_nodes() }
    }

    /// What every glossy function that the surface before keeps is there beyond its albedo, by the `values`
    /// of all functions, sr⁻¹.
    pub fn beyond_albedo(&self, values: &[f32]) -> impl Iterator<Item = f32> {
        beyond_albedo(self.later, values)
    }
}

/// See [`Nodes::beyond_albedo`].
pub fn beyond_albedo(later: &Later, values: &[f32]) -> impl Iterator<Item = f32> {
    let glossy = values.iter().zip(&later.albedos).skip(1).take(later.lobes as usize);
    glossy.map(|(value, albedo)| value - albedo * FRAC_1_PI)
}

/// The hemispherical-hemispherical reflectance of every basis function, in units of what a white Lambert
/// surface's comes to on the same pairs of directions.
pub fn albedos(basis: &BrdfBasis) -> Vec<f32> {
    let pairs = HalfDifference::new();
    let mut sums = vec![0.0; basis.bases()];
    let mut white = 0.0;
    let mut values = [0.0; MAX_BASES];
    for (angles, weight) in pairs.angles.iter().zip(&pairs.weight) {
        basis.evaluate(angles, &mut values[..sums.len()]);
        let weight = weight * weight;
        sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * f64::from(*value));
        white += weight * f64::from(FRAC_1_PI);
    }
    sums.iter().map(|sum| (sum / white) as f32).collect()
}

/// Light that goes from material to material, as paths find it.
struct Exchange {
    /// Arriving at each material, by channel.
    arriving: Vec<DVec3>,
    /// The same times the colour of its texture.
    coloured: Vec<DVec3>,
    /// Of what arrives at the row's material, what goes on to the column's, row-major.
    going_on: Vec<DVec3>,
    /// Whether any of it is light at all.
    is_lit: bool,
}

impl Exchange {
    fn new(materials: usize) -> Self {
        Self {
            arriving: vec![DVec3::ZERO; materials],
            coloured: vec![DVec3::ZERO; materials],
            going_on: vec![DVec3::ZERO; materials * materials],
            is_lit: false,
        }
    }

    fn add_path(&mut self, path: &GatherPath, scene: &Scene) {
        if let GatherPath::Surface(eye) = path
            && let Some(first) = &eye.indirect
        {
            self.add_surfaces(first, scene);
        }
    }

    /// Follows a path away from the eye. What comes back is what goes: reflectances are symmetric.
    fn add_surfaces(&mut self, first: &FirstVertex, scene: &Scene) {
        let materials = self.arriving.len();
        let mut weight = DVec3::ONE;
        // The last material that varies, and what of its light arrived since.
        let mut before: Option<usize> = None;
        let (mut material, mut albedo) = (first.spot.material, first.spot.albedo);
        let mut ahead = first.later.iter();
        loop {
            let here = scene.vary.place_of(material);
            if let Some(here) = here {
                if let Some(before) = before {
                    self.going_on[before * materials + here] += weight / TYPICAL_ALBEDO;
                }
                self.arriving[here] += weight;
                self.coloured[here] += weight * albedo.as_dvec3();
                before = Some(here);
            }
            let Some(next) = ahead.next() else { return };
            self.is_lit |= next.reflections.iter().any(Option::is_some);
            let reflectance = match here {
                Some(_) => DVec3::splat(TYPICAL_ALBEDO * f64::from(FRAC_1_PI)),
                None => {
                    let fixed = &scene.materials[material as usize].brdf;
                    brdf::evaluate(fixed, albedo, &next.next_angles).as_dvec3()
                }
            };
            weight *= reflectance * f64::from(next.weight);
            (material, albedo) = (next.spot.material, next.spot.albedo);
        }
    }

    fn add(&mut self, other: &Self) {
        let sum = |all: &mut [DVec3], more: &[DVec3]| all.iter_mut().zip(more).for_each(|(a, b)| *a += *b);
        sum(&mut self.arriving, &other.arriving);
        sum(&mut self.coloured, &other.coloured);
        sum(&mut self.going_on, &other.going_on);
        self.is_lit |= other.is_lit;
    }

    /// See [`Later::textures`].
    fn textures(&self) -> Vec<[f32; 3]> {
        let mean = |(coloured, arriving): (&DVec3, &DVec3)| {
            let share = |k: usize| if arriving[k] > 0.0 { coloured[k] / arriving[k] } else { 1.0 };
            std::array::from_fn(|k| share(k).clamp(0.0, 1.0) as f32)
        };
        self.coloured.iter().zip(&self.arriving).map(mean).collect()
    }

    /// See [`Later::returns`].
    fn returns(&self) -> Vec<f32> {
        let materials = self.arriving.len();
        let row = |channel: usize, row: usize| {
            let going_on = &self.going_on[row * materials..][..materials];
            // More than all that leaves is noise, or a fixed surface that gives more than it gets.
            let most =
                going_on.iter().map(|share| share[channel]).sum::<f64>().max(self.arriving[row][channel]);
            let share = move |share: &DVec3| if most > 0.0 { (share[channel] / most) as f32 } else { 0.0 };
            going_on.iter().map(share)
        };
        (0..3).flat_map(|channel| (0..materials).flat_map(move |i| row(channel, i))).collect()
    }
}

/// The BRDF of a Lambert surface of this albedo.
pub fn lambert(albedo: Vec3A) -> Vec3A {
    albedo * FRAC_1_PI
}
