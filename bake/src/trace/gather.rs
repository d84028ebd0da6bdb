//! The paths of the method `transfer-images`: two reflections, with what each reflection needs to know left
//! open, and, where all are asked for, the later ones ([`super::later`]).
//!
//! A path does not depend on the materials that vary: directions at these come from a fixed mixture of lobes
//! and, at the surface that the eye sees, from a [guide](super::guide) that all states share.
//! So one set of paths serves every basis, every state and the reference alike, and noise is the same in all
//! of them.

use super::bounce::{Bounce, Chooser};
use super::guide::Guide;
use super::later::LaterVertex;
use super::lights::{LightSample, Lights};
use super::sampler::{PixelSampler, Sample};
use super::spot::Spot;
use super::tile_counts::TileCounts;
use super::world::{Owner, Surface, World};
use crate::brdf::angles;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::state::{Brdf, Film, Model};
use relume_scenes::{ALL_REFLECTIONS, Scene};
use std::ops::Range;
use std::sync::Arc;

/// Most reflections of a path, unless it is to have all.
pub const MAX_REFLECTIONS: u32 = 2;

/// Points on lights that the surface that the eye sees looks at for every path: highlights and soft shadows are
/// there, and a look is cheap beside all that follows on a path.
const POINTS: usize = 4;

/// The dimension pair that moves what the guide is asked for; later reflections count on from 7.
const GUIDE_PAIR: u32 = u32::MAX;

/// One path from the eye.
#[allow(
    clippy::large_enum_variant,
    reason = "lives on the stack for one sample; a box would allocate for every path"
)]
#[derive(Debug, Clone)]
pub enum GatherPath {
    /// The eye sees a light or the background: its radiance.
    Light(Vec3A),
    /// The eye sees a surface.
    Surface(EyeVertex),
}

impl GatherPath {
    /// True if what the eye sees emits light itself, whatever its materials.
    pub fn shows_light(&self) -> bool {
        match self {
            Self::Light(_) => true,
            Self::Surface(eye) => eye.emitted != Vec3A::ZERO,
        }
    }
}

/// The surface that the eye sees.
#[derive(Debug, Clone)]
pub struct EyeVertex {
    /// What BRDFs know of it.
    pub spot: Spot,
    /// World space.
    pub position: Vec3A,
    /// Unit shading normal, world space.
    pub normal: Vec3A,
    /// Radiance that it emits itself.
    pub emitted: Vec3A,
    /// Where the path goes on; `None` if below the surface.
    pub onward: Option<Onward>,
    /// Light that arrives directly: from points chosen on lights, and last [`EyeVertex::met`]. Weighed as
    /// [`Reflections`] are.
    pub direct: [Option<Reflection>; POINTS + 1],
    /// Light that arrives by way of another surface.
    pub indirect: Option<FirstVertex>,
}

impl EyeVertex {
    /// Of direct light, what going on from here met.
    pub fn met(&self) -> Option<&Reflection> {
        self.direct[POINTS].as_ref()
    }

    /// Light that it reflects to the eye, and that was reflected nowhere else, or once more. `brdf` gives the
    /// BRDF at a point of a surface, at some angles.
    pub fn early_light(&self, brdf: impl Fn(&Spot, &Angles) -> Vec3A) -> [Vec3A; 2] {
        let reflected = |spot: &Spot, reflections: &[Option<Reflection>]| -> Vec3A {
            reflections.iter().flatten().map(|r| r.light * brdf(spot, &r.angles)).sum()
        };
        let direct = reflected(&self.spot, &self.direct);
        let indirect = self.indirect.as_ref().map_or(Vec3A::ZERO, |first| {
            let light = reflected(&first.spot, &first.reflections);
            light * brdf(&self.spot, &first.eye_angles)
        });
        [direct, indirect]
    }

    /// Light that it reflects to the eye, and that was reflected twice or more before: at the surface before by
    /// `first`, and at all others by `before`.
    pub fn later_light(
        &self,
        brdf: impl Fn(&Spot, &Angles) -> Vec3A,
        first: impl Fn(&Spot, &Angles) -> Vec3A,
        before: impl Fn(&Spot, &Angles) -> Vec3A,
    ) -> Vec3A {
        let at_first = self.indirect.as_ref().filter(|vertex| !vertex.later.is_empty());
        at_first.map_or(Vec3A::ZERO, |vertex| {
            vertex.later_light(first, before) * brdf(&self.spot, &vertex.eye_angles)
        })
    }
}

/// The direction that a path goes on in, with the densities per steradian that it might have been found by.
#[derive(Debug, Clone, Copy)]
pub struct Onward {
    /// Where the path went through the film, that being the unit square.
    pub place: [f32; 2],
    /// Unit, world space.
    pub direction: Vec3A,
    /// That of all ways in which paths go on.
    pub density: f32,
    /// Those of the guide and of the lobes, which that one is mixed of.
    pub densities: [f32; 2],
    /// That of choosing points on the light that is met in this direction, if any is: of all that are chosen.
    pub of_light: f32,
}

/// Light that arrives at a surface, found in two ways: by choosing a point on a light, and by going on from
/// the surface. Both carry the balance heuristic's weights (Veach 1997), so their sum is the estimate.
pub type Reflections = [Option<Reflection>; 2];

/// Light about to be reflected: times the BRDF at these angles it is radiance.
#[derive(Debug, Clone, Copy)]
pub struct Reflection {
    /// Between the directions and the shading normal.
    pub angles: Angles,
    /// Radiance · cosine / density.
    pub light: Vec3A,
}

/// The surface before the one that the eye sees.
#[derive(Debug, Clone)]
pub struct FirstVertex {
    /// What BRDFs know of it.
    pub spot: Spot,
    /// At the surface that the eye sees.
    pub eye_angles: Angles,
    /// Light that this surface reflects towards the one that the eye sees, times cosine / density there.
    pub reflections: Reflections,
    /// Cosine / density at the surface that the eye sees.
    pub weight: f32,
    /// The surfaces before this one, the next one first; none unless all reflections are asked for.
    pub later: Vec<LaterVertex>,
}

/// Everything that traces the paths of one scene.
#[derive(Clone)]
pub struct Gather<'a> {
    /// The scene's surfaces.
    pub world: &'a World,
    /// The scene's lights.
    pub lights: &'a Lights,
    film: Film,
    size: [u32; 2],
    pub(super) mixtures: Vec<LobeMixture>,
    /// For each material: what it is, if it does not vary.
    pub(super) fixed: Vec<Option<Brdf>>,
    indirect: bool,
    /// For each material: where its later reflections are looked for, if they are at all.
    later: Option<Vec<LobeMixture>>,
    /// Where the eye's surface looks for light.
    guide: Option<Arc<Guide>>,
    /// How many paths pixels have, if some have more than others.
    counts: Option<Arc<TileCounts>>,
    seed: u64,
}

impl<'a> Gather<'a> {
    /// Prepares the paths of `scene` for a film of `size` pixels.
    pub fn new(
        scene: &Scene,
        world: &'a World,
        lights: &'a Lights,
        size: [u32; 2],
        reflections: u32,
        seed: u64,
    ) -> Self {
        let of = |(index, material): (usize, &relume_scenes::Material)| {
            (!scene.vary.materials.contains(&index)).then_some(material.brdf)
        };
        let fixed: Vec<Option<Brdf>> = scene.materials.iter().enumerate().map(of).collect();
        let mixtures_by = |varying: &dyn Fn(Model) -> LobeMixture| -> Vec<LobeMixture> {
            let of = |(fixed, material): (&Option<Brdf>, &relume_scenes::Material)| {
                let any = || varying(material.brdf.model());
                fixed.as_ref().map_or_else(any, LobeMixture::for_material)
            };
            fixed.iter().zip(&scene.materials).map(of).collect()
        };
        let of_any = |model: Model| LobeMixture::for_any_material(model, scene.vary.sharpest(model));
        let (mixtures, later) = (mixtures_by(&of_any), mixtures_by(&|_| LobeMixture::cosine()));
        Self {
            world,
            lights,
            film: scene.camera.film(size[0], size[1]),
            size,
            mixtures,
            fixed,
            indirect: reflections >= 2,
            later: (reflections == ALL_REFLECTIONS).then_some(later),
            guide: None,
            counts: None,
            seed,
        }
    }

    /// The same but for fourth and later reflections, which bakes look for as matt surfaces reflect; these find
    /// the highlights of materials that vary, too.
    #[must_use]
    pub fn with_later_highlights(&self) -> Self {
        Self { later: self.later.as_ref().map(|_| self.mixtures.clone()), ..self.clone() }
    }

    /// The same, but from what the eye sees some of the paths follow `guide`.
    #[must_use]
    pub fn guided_by(self, guide: impl Into<Arc<Guide>>) -> Self {
        Self { guide: Some(guide.into()), ..self }
    }

    /// The same, but of so many paths.
    #[must_use]
    pub fn counted_by(self, counts: TileCounts) -> Self {
        Self { counts: Some(Arc::new(counts)), ..self }
    }

    /// Paths by other random numbers.
    #[must_use]
    pub fn seeded(&self, seed: u64) -> Self {
        Self { seed, ..self.clone() }
    }

    /// How many paths pixels have, if some have more than others.
    pub fn counts(&self) -> Option<&TileCounts> {
        self.counts.as_deref()
    }

    /// How many paths pixel number `pixel` has, where `even` is what all have unless some have more.
    pub fn samples(&self, pixel: u32, even: u32) -> u32 {
        self.counts.as_ref().map_or(even, |counts| counts.of(pixel))
    }

    /// Traces the first `samples` paths of pixel number `pixel`, in order.
    pub fn pixel(&self, pixel: u32, samples: u32, each: impl FnMut(&GatherPath)) {
        self.some_of_pixel(pixel, 0..samples, each);
    }

    /// Traces these paths of pixel number `pixel`, in order.
    pub fn some_of_pixel(&self, pixel: u32, samples: Range<u32>, mut each: impl FnMut(&GatherPath)) {
        let sampler = PixelSampler::new(self.seed, pixel);
        let corner = [pixel % self.size[0], pixel / self.size[0]];
        for index in samples {
            let sample = sampler.sample(index);
            let within = sample.pair(0);
            each(&self.path(std::array::from_fn(|k| corner[k] as f32 + within[k]), &sample));
        }
    }

    /// Where the first `samples` paths of pixel number `pixel` begin: where in the pixel, in [0, 1)², and on what.
    pub fn seen(&self, pixel: u32, samples: u32, mut each: impl FnMut([f32; 2], &Spot)) {
        let sampler = PixelSampler::new(self.seed, pixel);
        let corner = [pixel % self.size[0], pixel / self.size[0]];
        for index in 0..samples {
            let within = sampler.sample(index).pair(0);
            let [x, y] = std::array::from_fn(|k| corner[k] as f32 + within[k]);
            let surface = self.world.intersect(self.film.eye_in_world, self.film.direction(x, y));
            if let Some(surface) = surface
                && let Owner::Material(material) = surface.owner
            {
                each(within, &surface.spot(material));
            }
        }
    }

    /// A path through any point of the film: the first two numbers of `sample` choose it.
    pub fn anywhere(&self, sample: &Sample) -> GatherPath {
        let within = sample.pair(0);
        self.path(std::array::from_fn(|k| within[k] * self.size[k] as f32), sample)
    }

    /// The path through a point of the film, in pixels.
    fn path(&self, at: [f32; 2], sample: &Sample) -> GatherPath {
        let direction = self.film.direction(at[0], at[1]);
        let Some(surface) = self.world.intersect(self.film.eye_in_world, direction) else {
            return GatherPath::Light(self.lights.background(direction));
        };
        match surface.owner {
            Owner::Light(_) => GatherPath::Light(self.lights.emitted(&surface)),
            Owner::Material(material) => GatherPath::Surface(self.eye_vertex(&surface, material, at, sample)),
        }
    }

    fn eye_vertex(&self, surface: &Surface, material: u32, at: [f32; 2], sample: &Sample) -> EyeVertex {
        let lobes = &self.mixtures[material as usize];
        let place = std::array::from_fn(|k| at[k] / self.size[k] as f32);
        let guide = self.guide.as_ref();
        let guide = guide.and_then(|g| g.at(place, sample.pair(GUIDE_PAIR), surface.shading_normal));
        let chooser = Chooser::guided(lobes, guide);
        let bounce = Bounce::sample(surface, chooser, sample.pair(1)[1], sample.pair(3));
        let hit = bounce.and_then(|b| self.world.intersect(surface.offset(), b.direction));
        let points = if self.lights.are_one_point() { 1 } else { POINTS };
        let seen = bounce.and_then(|b| self.light_seen(surface, &b, hit.as_ref(), points));
        let direct = std::array::from_fn(|number| {
            if number == POINTS {
                return seen.map(|(seen, _)| seen);
            }
            let point = (number < points).then(|| sample.part(number, points))?;
            self.light_sampled(surface, chooser, &point, [1, 2], points)
        });
        let onward = bounce.map(|Bounce { direction, density, densities, .. }| {
            let of_light = seen.map_or(0.0, |(_, of_light)| of_light);
            Onward { place, direction, density, densities, of_light }
        });
        let indirect = match (bounce, hit) {
            (Some(bounce), Some(first)) if self.indirect => self.first_vertex(&bounce, &first, sample),
            _ => None,
        };
        EyeVertex {
            spot: surface.spot(material),
            position: surface.position,
            normal: surface.shading_normal,
            emitted: self.lights.emitted(surface),
            onward,
            direct,
            indirect,
        }
    }

    fn first_vertex(&self, bounce: &Bounce, first: &Surface, sample: &Sample) -> Option<FirstVertex> {
        let Owner::Material(material) = first.owner else { return None };
        let chooser = Chooser::by(&self.mixtures[material as usize]);
        let sampled = self.light_sampled(first, chooser, sample, [4, 5], 1);
        let seen = Bounce::sample(first, chooser, sample.pair(4)[1], sample.pair(6))
            .and_then(|b| self.light_along(first, &b));
        let carried = |r: Reflection| Reflection { light: r.light * bounce.weight(), ..r };
        let reflections = [sampled.map(carried), seen.map(carried)];
        let later = self.later.as_ref().map(|later| self.later_vertices(later, first, material, sample));
        let is_lit = later.is_some() || reflections.iter().any(Option::is_some);
        is_lit.then(|| FirstVertex {
            spot: first.spot(material),
            eye_angles: bounce.angles,
            reflections,
            weight: bounce.weight(),
            later: later.unwrap_or_default(),
        })
    }

    /// Light from one of so many `points` chosen on lights: by the first number of one pair of `sample`, and by
    /// another pair.
    pub(super) fn light_sampled(
        &self,
        surface: &Surface,
        chooser: Chooser<'_>,
        sample: &Sample,
        [light, point]: [u32; 2],
        points: usize,
    ) -> Option<Reflection> {
        let (choice, point) = (sample.pair(light)[0], sample.pair(point));
        let LightSample { direction, weight, density, .. } =
            self.lights.sample_visible(self.world, surface, choice, point)?;
        let normal = surface.shading_normal;
        let points = points as f32;
        // Weight points · density / (points · density + chooser's), over so many points.
        let share = density.map_or(1.0 / points, |d| d / (points * d + chooser.density(surface, direction)));
        let angles = angles(direction, surface.outgoing, normal);
        Some(Reflection { angles, light: weight * (direction.dot(normal) * share) })
    }

    /// Light that a bounce met, `hit` being the first surface in its way; and the density per steradian with
    /// which all of so many `points` on lights are chosen there.
    pub(super) fn light_seen(
        &self,
        surface: &Surface,
        bounce: &Bounce,
        hit: Option<&Surface>,
        points: usize,
    ) -> Option<(Reflection, f32)> {
        let radiance = self.lights.met(bounce.direction, hit);
        if radiance == Vec3A::ZERO {
            return None;
        }
        let density = points as f32 * self.lights.density_of(surface, bounce.direction, hit);
        // Weight density / (density + light's) over density.
        let light = radiance * (bounce.cosine / (bounce.density + density));
        (light != Vec3A::ZERO).then_some((Reflection { angles: bounce.angles, light }, density))
    }

    /// Light that a bounce meets if nothing is in its way. Asks the few lights first: most bounces miss them
    /// and need no ray.
    fn light_along(&self, surface: &Surface, bounce: &Bounce) -> Option<Reflection> {
        let from = surface.offset();
        if self.lights.have_meshes() {
            let hit = self.world.intersect(from, bounce.direction);
            return self.light_seen(surface, bounce, hit.as_ref(), 1).map(|(seen, _)| seen);
        }
        let (radiance, density, distance) = self.lights.along(surface, bounce.direction)?;
        let light = radiance * (bounce.cosine / (bounce.density + density));
        let arrives = light != Vec3A::ZERO && !self.world.occluded(from, bounce.direction, distance);
        arrives.then_some(Reflection { angles: bounce.angles, light })
    }
}
