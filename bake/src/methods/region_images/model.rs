//! What paths show by what the method makes of materials, part by part.

use super::layout::Layout;
use super::project::{Reflector, Reflectors, values};
use super::weights::Weights;
use crate::brdf;
use crate::trace::gather::{EyeVertex, FirstVertex, GatherPath, Reflection};
use crate::trace::spot::Spot;
use glam::Vec3A;
use relume_formats::evaluate::region_images::{OnBases, Worn, at_fragments, before_eye, coefficients_at};
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::region_images::{Head, Source};
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use relume_scenes::painting::region_of;
use std::collections::HashMap;

/// What is approximated beside BRDFs, which are so by bases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    /// Painted surfaces that the eye sees are the mean of their pixel's taps.
    pub taps: bool,
    /// Those before are the means of their regions.
    pub regions: bool,
    /// And these means are what components keep of them.
    pub components: bool,
    /// Pairs of glossy bases are dropped (thesis eq. 4-36).
    pub dropped: bool,
}

impl Parts {
    /// Bases alone.
    pub const NONE: Self = Self { taps: false, regions: false, components: false, dropped: false };
    /// As bakes are.
    pub const BAKED: Self = Self { taps: true, regions: true, components: true, dropped: false };
}

/// A bake, as paths see it.
pub struct Model<'a> {
    /// The basis of its materials.
    pub basis: &'a BrdfBasis,
    /// What channels are of.
    pub layout: &'a Layout,
    /// What regions count.
    pub weights: &'a Weights,
    /// How materials reflect.
    pub reflectors: Reflectors,
    /// The number in the file of every fragment.
    pub numbers: HashMap<(u32, u16), usize>,
}

/// What materials of a state are to it.
pub struct State<'a> {
    worn: Vec<Worn<'a>>,
    /// Coefficients of each class at the surface before the eye's, by region of painted ones.
    before: Vec<OnBases>,
    /// Those of painted ones as components have them, by group, region by region.
    of_components: Vec<Vec<Rgb>>,
    /// Of each fragment of the file at the eye.
    pub at_eye: Vec<Vec<Rgb>>,
}

impl Model<'_> {
    /// The materials that vary in `scene`, which is this one in a state, as `head` has them.
    pub fn state<'b>(&self, scene: &'b Scene, head: &Head) -> Option<State<'b>> {
        let bases = self.basis.bases();
        let worn = worn(scene);
        let before: Vec<OnBases> = before_eye(head, self.basis, &worn)?;
        let of_components = self.weights.groups.iter().map(|group| {
            group.seen_through(|region| {
                before[usize::from(group.material)].of(region, group.basis.into(), bases)
            })
        });
        let of_components = of_components.collect();
        Some(State { at_eye: at_fragments(head, self.basis, &worn)?, of_components, before, worn })
    }

    /// What a path of a pixel shows.
    pub fn light(&self, path: &GatherPath, pixel: u32, state: &State<'_>, parts: Parts) -> Vec3A {
        match path {
            GatherPath::Light(radiance) => *radiance,
            GatherPath::Surface(eye) => eye.emitted + self.reflected(eye, pixel, state, parts),
        }
    }

    fn reflected(&self, eye: &EyeVertex, pixel: u32, state: &State<'_>, parts: Parts) -> Vec3A {
        let reflector = self.reflectors.of(&eye.spot);
        let class = match reflector {
            Reflector::Fixed(brdf) => {
                let [direct, _] = eye.early_light(|spot, angles| brdf::evaluate(&brdf, spot.albedo, angles));
                let Some(first) = &eye.indirect else { return direct };
                let reflectance = brdf::evaluate(&brdf, eye.spot.albedo, &first.eye_angles);
                return direct + self.sent_on(first, 0, state, parts) * reflectance;
            }
            Reflector::Whole(class) | Reflector::Painted(class) => class,
        };
        let number = self.numbers.get(&(pixel, class as u16)).filter(|_| parts.taps);
        let coefficients = match (number, &state.worn[class]) {
            (Some(number), _) => state.at_eye[*number].clone(),
            (None, Worn::Whole(brdf)) => self.basis.coefficients_of(brdf).unwrap_or_default(),
            (None, Worn::Painted(_)) => self.exact(state, class, &eye.spot),
        };
        let seen = |e: usize, value: f32| {
            let light = coefficients.get(e).map_or(Vec3A::ZERO, |c| Vec3A::from(*c)) * value;
            if e == 0 { light * reflector.albedo(&eye.spot) } else { light }
        };
        let [bases, indirect] = self.layout.bases;
        let direct = |Reflection { angles, light }: &Reflection| {
            let values = values(self.basis, angles, bases);
            *light * (0..bases).map(|e| seen(e, values[e])).sum::<Vec3A>()
        };
        let mut sum: Vec3A = eye.direct.iter().flatten().map(direct).sum();
        if let Some(first) = &eye.indirect {
            let values = values(self.basis, &first.eye_angles, indirect);
            let before = |e: usize| seen(e, values[e]) * self.sent_on(first, e, state, parts);
            sum += (0..indirect).map(before).sum::<Vec3A>();
        }
        sum
    }

    /// What the surface before the eye's sends on to a basis of the eye.
    fn sent_on(&self, first: &FirstVertex, eye: usize, state: &State<'_>, parts: Parts) -> Vec3A {
        let (spot, reflector) = (&first.spot, self.reflectors.of(&first.spot));
        let class = match reflector {
            Reflector::Fixed(brdf) => {
                let sent = |r: &Reflection| r.light * brdf::evaluate(&brdf, spot.albedo, &r.angles);
                return first.reflections.iter().flatten().map(sent).sum();
            }
            Reflector::Whole(class) | Reflector::Painted(class) => class,
        };
        let coefficients = self.before(eye, class, spot, state, parts);
        let indirect = if parts.dropped && eye > 0 { 1 } else { self.layout.bases[1] };
        let sent = |Reflection { angles, light }: &Reflection| {
            let values = values(self.basis, angles, indirect);
            let of = |basis: usize| {
                let reflected =
                    coefficients.get(basis).map_or(Vec3A::ZERO, |c| Vec3A::from(*c)) * values[basis];
                if basis == 0 { reflected * reflector.albedo(spot) } else { reflected }
            };
            *light * (0..indirect).map(of).sum::<Vec3A>()
        };
        first.reflections.iter().flatten().map(sent).sum()
    }

    /// Coefficients of a class at a spot before the eye's.
    fn before(&self, eye: usize, class: usize, spot: &Spot, state: &State<'_>, parts: Parts) -> Vec<Rgb> {
        let (bases, region) = (self.basis.bases(), region_of(spot.uv) as usize);
        let of_component = |basis: usize| {
            let source = Source::Painted { material: class as u16, basis: basis as u16 };
            self.weights.group(eye, source).map_or([0.0; 3], |group| state.of_components[group][region])
        };
        match state.worn[class] {
            Worn::Painted(_) if !parts.regions => self.exact(state, class, spot),
            Worn::Painted(_) if parts.components => (0..self.layout.bases[1]).map(of_component).collect(),
            Worn::Painted(_) => {
                (0..bases).map(|basis| state.before[class].of(region, basis, bases)).collect()
            }
            Worn::Whole(_) => (0..bases).map(|basis| state.before[class].of(0, basis, bases)).collect(),
        }
    }

    /// Coefficients of the texel that a spot is on.
    fn exact(&self, state: &State<'_>, class: usize, spot: &Spot) -> Vec<Rgb> {
        match state.worn[class] {
            Worn::Whole(brdf) => self.basis.coefficients_of(brdf),
            Worn::Painted(paint) => coefficients_at(self.basis, &paint.brdf, &paint.at(spot.uv)),
        }
        .unwrap_or_default()
    }
}

/// The number in the file of every fragment.
pub fn numbers(head: &Head) -> HashMap<(u32, u16), usize> {
    let fragments = &head.fragments;
    fragments.pixel.iter().copied().zip(fragments.class.iter().copied()).zip(0..).collect()
}

/// How the materials of a scene that vary are in it.
pub fn worn(scene: &Scene) -> Vec<Worn<'_>> {
    let of = |index: &usize| {
        let material = &scene.materials[*index];
        material.paint.as_deref().map_or(Worn::Whole(&material.brdf), Worn::Painted)
    };
    scene.vary.materials.iter().map(of).collect()
}
