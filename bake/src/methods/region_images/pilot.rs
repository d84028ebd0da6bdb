//! Finds the weights of regions on some paths of a scene, before its images are made.
//!
//! A·Aᵀ of a group comes from two halves of each pixel's paths, as the mean of their products both ways: what noise
//! adds to a product of one half with itself, it does not add to that of two. Components whose share of what pixels
//! show in random states is too small to matter are left out, those of all groups alike, the least ones first; so the
//! pairs of glossy bases that the thesis drops (eq. 4-36) go where they may, and stay where they show.

use super::covariance::Covariance;
use super::layout::sources;
use super::project::{Reflector, Reflectors, values};
use super::settings::{NAME, Settings};
use super::weights::{Group, Weights};
use crate::brdf;
use crate::compress::linalg::{single_thread, symmetric_eigen};
use crate::error::Result;
use crate::filter::seen::half_of;
use crate::interrupted::Interrupted;
use crate::job::{Job, Progress};
use crate::methods::spread::spread;
use crate::random_state::{all_in_random_state, random_state};
use crate::stage::Stage;
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::reference::early_radiance_of;
use crate::trace::spot::Spot;
use glam::Vec3A;
use ndarray::Array2;
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::region_images::{REGION_COUNT, Source};
use relume_formats::state::Brdf;
use relume_scenes::Scene;
use relume_scenes::painting::region_of;

/// One path of so many is traced, and of how many pixels at least; and of each pixel as many as this, be those of the
/// bake ever so few, for a pair of regions is known by the products of two paths.
const SHARE: u64 = 16;
const LEAST_PIXELS: u64 = 16384;
const LEAST_PATHS: u32 = 128;
/// Pixels that are in memory at a time.
const BATCH: usize = 512;
/// Random states that tell how bright the film is, and materials that tell how large coefficients are.
const STATES: u32 = 8;
const MATERIALS: u32 = 64;
/// What part of the error that is asked for components may make that are left out.
const ERROR_SHARE: f64 = 0.3;
/// Most components of a group.
const MOST: usize = 256;
/// Another sequence of paths than that of bakes.
const SEED: u64 = 0x7265_6769_6f6e;

/// The stage that finds them, in one piece.
pub struct Pilot<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The paths of the bake.
    pub gather: &'a Gather<'a>,
    /// Its basis.
    pub basis: &'a BrdfBasis,
    /// Its settings.
    pub settings: Settings,
    /// A hash of all that it depends on.
    pub key: u128,
    /// What it is part of.
    pub job: &'a Job,
}

impl Stage for Pilot<'_> {
    fn name(&self) -> String {
        format!("{NAME}-weights")
    }

    fn label(&self) -> Option<&'static str> {
        None
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        1
    }

    fn piece(&self, _: u32) -> Result<Vec<u8>> {
        Ok(self.weights()?.encode())
    }
}

/// What a group is of: basis of the eye, class, basis there; and which of the painted materials the class is.
type Key = (usize, usize, usize, usize);

/// What a path adds to the products of its pixel.
struct Sent {
    /// Which of the painted materials, in their order, times [`REGION_COUNT`], and the region.
    place: u32,
    /// By half, basis of the eye and basis: a channel of the light in the mean.
    light: Vec<f32>,
}

/// What is seen in a pixel.
struct Pixel {
    /// In the order of places.
    sent: Vec<Sent>,
    /// Mean square over random states and channels.
    energy: f64,
}

impl Pilot<'_> {
    /// Number of bases of light that was reflected before.
    fn bases(&self) -> usize {
        self.settings.indirect_bases(self.scene.reflections)
    }

    /// The classes of painted materials.
    fn painted(&self) -> Vec<usize> {
        let vary = &self.scene.vary;
        (0..vary.materials.len()).filter(|class| vary.painted.contains(&vary.materials[*class])).collect()
    }

    fn weights(&self) -> Result<Weights> {
        let Settings { size, samples, .. } = self.settings;
        let film = u64::from(size[0]) * u64::from(size[1]);
        let paths = samples.max(LEAST_PATHS);
        let pixels = (film * u64::from(samples) / (SHARE * u64::from(paths))).max(LEAST_PIXELS).min(film);
        let pixels: Vec<u32> = spread(pixels as usize, film as usize).iter().map(|p| *p as u32).collect();
        let (painted, pairs) = (self.painted(), self.bases() * self.bases());
        let progress = self.job.progress("weighing regions", pixels.len() as u64);
        let mut products = vec![vec![0.0f64; REGION_COUNT * REGION_COUNT]; painted.len() * pairs];
        let mut energy = 0.0;
        for batch in pixels.chunks(BATCH) {
            let seen = self.trace(batch, paths, &painted, &progress)?;
            energy += seen.iter().map(|pixel| pixel.energy).sum::<f64>();
            let of_group = |(group, products): (usize, &mut Vec<f64>)| {
                let (material, pair) = (group / pairs.max(1), group % pairs.max(1));
                seen.iter().for_each(|pixel| pixel.add_to(products, material, pair, pairs));
            };
            products.par_iter_mut().enumerate().for_each(of_group);
        }
        let squares = self.squares();
        let scale = (paths as f64).powi(-2) * 4.0;
        let budget = energy * (ERROR_SHARE * self.settings.max_error).powi(2);
        let groups = self.groups(&painted, &products, scale, &squares, budget)?;
        Ok(Weights { groups, energy: energy / pixels.len() as f64, squares })
    }

    /// Mean squares of the coefficients of random materials, by basis.
    fn squares(&self) -> Vec<f64> {
        let mut squares = vec![0.0; self.settings.bases];
        let mut count = 0.0;
        for brdf in (0..MATERIALS).flat_map(|state| random_state(state, self.scene)) {
            for (square, c) in squares.iter_mut().zip(self.basis.coefficients_of(&brdf).iter().flatten()) {
                *square += c.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>() / 3.0;
            }
            count += 1.0;
        }
        squares.iter().map(|square| square / f64::max(count, 1.0)).collect()
    }

    fn trace(
        &self,
        pixels: &[u32],
        paths: u32,
        painted: &[usize],
        progress: &Progress,
    ) -> Result<Vec<Pixel>> {
        let gather = self.gather.seeded(self.settings.seed ^ SEED);
        let reflectors = Reflectors::new(self.scene);
        let states: Vec<Vec<Brdf>> = (0..STATES).map(|s| all_in_random_state(s, self.scene)).collect();
        let traced = pixels.par_iter().map(|pixel| {
            progress.check()?;
            let mut sums = PixelSums::new(painted.len(), 2 * self.bases() * self.bases());
            let mut shown = vec![Vec3A::ZERO; states.len()];
            let mut number = 0;
            gather.pixel(*pixel, paths, |path| {
                self.add(path, half_of(number, paths), &reflectors, painted, &mut sums);
                number += 1;
                // Lights and background are the same in all states, and of any brightness.
                if path.shows_light() {
                    return;
                }
                for (sum, materials) in shown.iter_mut().zip(&states) {
                    *sum += early_radiance_of(path, |spot: &Spot, angles: &Angles| {
                        brdf::evaluate(&materials[spot.material as usize], spot.albedo, angles)
                    });
                }
            });
            progress.advance(1);
            let mean = |sum: &Vec3A| f64::from((*sum / paths as f32).length_squared()) / 3.0;
            let energy = shown.iter().map(mean).sum::<f64>() / f64::from(STATES);
            Ok(Pixel { sent: sums.into_sent(), energy })
        });
        Ok(traced.collect::<std::result::Result<Vec<Pixel>, Interrupted>>()?)
    }

    fn add(
        &self,
        path: &GatherPath,
        half: usize,
        reflectors: &Reflectors,
        painted: &[usize],
        sums: &mut PixelSums,
    ) {
        let GatherPath::Surface(eye) = path else { return };
        let Some(first) = &eye.indirect else { return };
        let reflector = reflectors.of(&first.spot);
        let Reflector::Painted(class) = reflector else { return };
        let Some(material) = painted.iter().position(|painted| *painted == class) else { return };
        let bases = self.bases();
        let at_eye = values(self.basis, &first.eye_angles, bases);
        let eye_reflector = reflectors.of(&eye.spot);
        let albedo = eye_reflector.albedo(&eye.spot);
        let place = material * REGION_COUNT + region_of(first.spot.uv) as usize;
        let sent = &mut sums.of(place)[half * bases * bases..][..bases * bases];
        for reflection in first.reflections.iter().flatten() {
            let before = values(self.basis, &reflection.angles, bases);
            let mean = |light: Vec3A| (light.x + light.y + light.z) / 3.0;
            if let Reflector::Fixed(material) = eye_reflector {
                let light =
                    mean(reflection.light * brdf::evaluate(&material, eye.spot.albedo, &first.eye_angles));
                sent.iter_mut().zip(&before[..bases]).for_each(|(sum, value)| *sum += light * value);
                continue;
            }
            let (diffuse, glossy) = (mean(reflection.light * albedo), mean(reflection.light));
            for (e, sums) in sent.chunks_exact_mut(bases).enumerate() {
                let light = at_eye[e] * if e == 0 { diffuse } else { glossy };
                sums.iter_mut().zip(&before[..bases]).for_each(|(sum, value)| *sum += light * value);
            }
        }
    }

    /// The groups with the components that are kept; `products` are A·Aᵀ but for `scale`.
    fn groups(
        &self,
        painted: &[usize],
        products: &[Vec<f64>],
        scale: f64,
        squares: &[f64],
        budget: f64,
    ) -> Result<Vec<Group>> {
        let bases = self.bases();
        let all = sources(&vec![true; self.scene.vary.materials.len()], bases);
        let keys: Vec<Key> = (0..bases)
            .flat_map(|eye| all.iter().map(move |source| (eye, *source)))
            .filter_map(|(eye, source)| {
                let Source::Painted { material, basis } = source else { return None };
                let material = usize::from(material);
                let number = painted.iter().position(|painted| *painted == material)?;
                Some((eye, material, usize::from(basis), number))
            })
            .collect();
        let progress = self.job.progress("choosing components", keys.len() as u64);
        // Whatever comes from a region comes by the diffuse bases, too, whose products come first.
        let of_materials = products.chunks((bases * bases).max(1)).filter_map(<[_]>::first);
        let covariances: Vec<Covariance> = of_materials
            .map(|products| Covariance::new(touched(products)))
            .collect::<std::result::Result<_, _>>()?;
        let found = keys.par_iter().map(|&(eye, _, basis, number)| {
            progress.check()?;
            let products = &products[number * bases * bases + eye * bases + basis];
            let least = budget / squares[eye].max(f64::MIN_POSITIVE);
            let components = Components::new(products, scale * squares[basis], least, &covariances[number]);
            progress.advance(1);
            Ok(components)
        });
        let found: Vec<_> = found.collect::<std::result::Result<Vec<_>, Interrupted>>()?;
        let found: Vec<Components> = found.into_iter().collect::<std::result::Result<_, _>>()?;
        let errors = keys.iter().zip(&found).map(|(key, components)| {
            components.values.iter().map(|value| value * squares[key.0]).collect::<Vec<f64>>()
        });
        let ranks = ranks(&errors.collect::<Vec<_>>(), budget);
        let group = |((key, components), rank): ((&Key, &Components), usize)| {
            let &(eye, material, basis, number) = key;
            let (baked, played) = components.weights(rank, squares[basis].sqrt(), &covariances[number]);
            Group { eye: eye as u16, material: material as u16, basis: basis as u16, baked, played }
        };
        Ok(keys.iter().zip(&found).zip(ranks).map(group).collect())
    }
}

/// How many components each group keeps of those that make these `errors`, decreasing, if left out: the largest of
/// all, so that the others make no more than `budget`.
fn ranks(errors: &[Vec<f64>], budget: f64) -> Vec<usize> {
    let mut all: Vec<f64> = errors.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    let least = all.iter().find(|error| {
        sum += **error;
        sum > budget
    });
    let least = least.copied().unwrap_or(f64::INFINITY);
    errors.iter().map(|errors| errors.iter().take_while(|error| **error >= least).count().min(MOST)).collect()
}

/// The regions that anything comes from.
fn touched(products: &[f64]) -> Vec<usize> {
    (0..REGION_COUNT).filter(|i| products[i * REGION_COUNT + i] != 0.0).collect()
}

/// The components of a group.
struct Components {
    /// What each shows in the mean, decreasing: eigenvalues of K^½·A·Aᵀ·K^½ that are no noise. Those of noise alone
    /// are as often below 0 as above, and as far.
    values: Vec<f64>,
    /// As columns: its eigenvectors, the largest entry of each positive.
    vectors: Array2<f64>,
}

impl Components {
    /// Of the `products` of regions, but for `scale`. None if all of them show less than `least`.
    fn new(
        products: &[f64],
        scale: f64,
        least: f64,
        covariance: &Covariance,
    ) -> std::result::Result<Self, LinalgError> {
        let Covariance { regions, root, .. } = covariance;
        let count = regions.len();
        let at = |i: usize, j: usize| {
            let (i, j) = (regions[i.min(j)], regions[i.max(j)]);
            scale * products[i * REGION_COUNT + j]
        };
        let matrix = Array2::from_shape_fn([count; 2], |(i, j)| at(i, j));
        single_thread();
        let weighed = root.dot(&matrix).dot(root);
        let shown: f64 = weighed.diag().sum();
        if count == 0 || shown <= least {
            return Ok(Self { values: Vec::new(), vectors: Array2::zeros([count, 0]) });
        }
        let (mut values, mut vectors) = symmetric_eigen(&weighed)?;
        let noise = values.last().map_or(0.0, |least| (-least).max(0.0));
        values.retain(|value| *value > noise);
        for mut column in vectors.columns_mut() {
            let largest = column.iter().fold(0.0f64, |m, x| if x.abs() > m.abs() { *x } else { m });
            if largest < 0.0 {
                column.mapv_inplace(|x| -x);
            }
        }
        Ok(Self { values, vectors })
    }

    /// Those of the first `rank`: baked, [regions, rank], and played, [rank, regions]; `size` is the root of the mean
    /// square of coefficients.
    fn weights(&self, rank: usize, size: f64, covariance: &Covariance) -> (Vec<f32>, Vec<f32>) {
        let first = self.vectors.slice(ndarray::s![.., ..rank]);
        let (baking, playing) = (covariance.root.dot(&first) * size, covariance.inverse.dot(&first) / size);
        let (mut baked, mut played) = (vec![0.0; REGION_COUNT * rank], vec![0.0; rank * REGION_COUNT]);
        for (i, region) in covariance.regions.iter().enumerate() {
            for j in 0..rank {
                baked[region * rank + j] = baking[[i, j]] as f32;
                played[j * REGION_COUNT + region] = playing[[i, j]] as f32;
            }
        }
        (baked, played)
    }
}

/// What the paths of a pixel have brought from each place.
struct PixelSums {
    numbers: usize,
    /// By place: which of `met` it is, plus one.
    index: Vec<u32>,
    met: Vec<Sent>,
}

impl PixelSums {
    fn new(materials: usize, numbers: usize) -> Self {
        Self { numbers, index: vec![0; materials * REGION_COUNT], met: Vec::new() }
    }

    fn of(&mut self, place: usize) -> &mut [f32] {
        if self.index[place] == 0 {
            self.met.push(Sent { place: place as u32, light: vec![0.0; self.numbers] });
            self.index[place] = self.met.len() as u32;
        }
        &mut self.met[self.index[place] as usize - 1].light
    }

    fn into_sent(mut self) -> Vec<Sent> {
        self.met.sort_by_key(|sent| sent.place);
        self.met
    }
}

impl Pixel {
    /// Adds the products of a material's regions for a pair of bases, those that are not below the diagonal.
    fn add_to(&self, products: &mut [f64], material: usize, pair: usize, pairs: usize) {
        let of = |sent: &Sent| {
            (sent.place as usize / REGION_COUNT == material)
                .then(|| (sent.place as usize % REGION_COUNT, sent.light[pair], sent.light[pairs + pair]))
        };
        let sent: Vec<(usize, f32, f32)> = self.sent.iter().filter_map(of).collect();
        for (number, &(i, first, second)) in sent.iter().enumerate() {
            let row = &mut products[i * REGION_COUNT..][..REGION_COUNT];
            for &(j, other_first, other_second) in &sent[number..] {
                row[j] += f64::from(0.5 * (first * other_second + second * other_first));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_components_go_until_they_would_show() {
        let errors = [vec![9.0, 1.0, 0.5], vec![4.0, 0.25], vec![0.125]];
        assert_eq!(ranks(&errors, 0.0), [3, 2, 1]);
        assert_eq!(ranks(&errors, 0.4), [3, 1, 0]);
        assert_eq!(ranks(&errors, 1.0), [2, 1, 0]);
        assert_eq!(ranks(&errors, 100.0), [0, 0, 0]);
    }

    #[test]
    fn of_as_many_components_none_follow_random_states_better() {
        // Light of three regions, in three pixels: one of them sends all its light alone, two send the same.
        let sent = [[1.0, 0.0, 0.0], [0.0, 2.0, 2.0], [0.0, 1.0, 1.0f64]];
        let mut products = vec![0.0; REGION_COUNT * REGION_COUNT];
        for (i, j) in (0..3).flat_map(|i| (i..3).map(move |j| (i, j))) {
            products[i * REGION_COUNT + j] = sent.iter().map(|pixel| pixel[i] * pixel[j]).sum();
        }
        let covariance = Covariance::new(touched(&products)).unwrap();
        assert_eq!(covariance.regions, [0, 1, 2]);
        let components = Components::new(&products, 0.5, 0.0, &covariance).unwrap();
        assert!(components.values[1] > 1e-3, "{:?}", components.values);
        assert!(
            components.values.get(2).is_none_or(|value| *value < 1e-9),
            "two regions are never told apart"
        );
        let (baked, played) = components.weights(2, 0.5f64.sqrt(), &covariance);
        // Whatever the coefficients, both components together give each pixel what it shows.
        let c = |region: usize| 0.1 + region as f64;
        let alpha = |k: usize| (0..3).map(|i| f64::from(played[k * REGION_COUNT + i]) * c(i)).sum::<f64>();
        for pixel in sent {
            let shown: f64 = (0..3).map(|i| pixel[i] * c(i)).sum();
            let b = |k: usize| (0..3).map(|i| f64::from(baked[i * 2 + k]) * pixel[i]).sum::<f64>();
            let of_components = alpha(0) * b(0) + alpha(1) * b(1);
            // Weights are in single precision.
            assert!((of_components - shown).abs() < 1e-5, "{of_components} for {shown}");
        }
    }
}
