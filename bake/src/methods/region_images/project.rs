//! Projects paths on BRDF bases, and what painted surfaces send on by their regions' weights: what is never held is
//! an image of each region.

use super::layout::{Block, Layout};
use super::weights::Weights;
use crate::brdf;
use crate::filter::Watcher;
use crate::fragments::PixelRecords;
use crate::trace::gather::{EyeVertex, FirstVertex, GatherPath, Reflection};
use crate::trace::spot::Spot;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::MAX_BASES;
use relume_formats::state::Brdf;
use relume_scenes::Scene;
use relume_scenes::painting::region_of;

/// How paths of one scene fall into the channels of a layout.
pub struct Projector<'a> {
    basis: &'a BrdfBasis,
    layout: &'a Layout,
    weights: &'a Weights,
    reflectors: Reflectors,
    watcher: &'a Watcher,
}

/// By material, how it reflects.
pub struct Reflectors(Vec<Reflector>);

/// How a material reflects.
#[derive(Debug, Clone, Copy)]
pub enum Reflector {
    /// As it is in the scene.
    Fixed(Brdf),
    /// The same everywhere, by its coefficients; this is its class.
    Whole(usize),
    /// By those of each place.
    Painted(usize),
}

/// Basis values at one reflection.
pub type Values = [f32; MAX_BASES];

impl Reflectors {
    /// Those of `scene`.
    pub fn new(scene: &Scene) -> Self {
        let vary = &scene.vary;
        let of = |(index, material): (usize, &relume_scenes::Material)| match vary
            .materials
            .iter()
            .position(|varies| *varies == index)
        {
            None => Reflector::Fixed(material.brdf),
            Some(class) if vary.painted.contains(&index) => Reflector::Painted(class),
            Some(class) => Reflector::Whole(class),
        };
        Self(scene.materials.iter().enumerate().map(of).collect())
    }

    /// That of a material.
    pub fn of(&self, spot: &Spot) -> Reflector {
        self.0[spot.material as usize]
    }
}

impl Reflector {
    /// What the scene's texture multiplies the diffuse basis with: paint takes its place.
    pub fn albedo(&self, spot: &Spot) -> Vec3A {
        if matches!(self, Self::Painted(_)) { Vec3A::ONE } else { spot.albedo }
    }
}

impl<'a> Projector<'a> {
    /// Prepares the projection.
    pub fn new(
        scene: &Scene,
        basis: &'a BrdfBasis,
        layout: &'a Layout,
        weights: &'a Weights,
        watcher: &'a Watcher,
    ) -> Self {
        Self { basis, layout, weights, reflectors: Reflectors::new(scene), watcher }
    }

    /// Records with nothing in them.
    pub fn empty(&self) -> PixelRecords {
        PixelRecords::new(self.layout.materials(), self.layout.channels().map(|channels| channels.count))
    }

    /// Adds one path, of the first `half` of the samples or the second, 0 or 1.
    pub fn add(&self, path: &GatherPath, half: usize, records: &mut PixelRecords) {
        let fixed = self.layout.materials();
        Watcher::emitted(path, &mut records.of(fixed).seen);
        let eye = match path {
            GatherPath::Light(_) => return records.of(fixed).count += 1,
            GatherPath::Surface(eye) => eye,
        };
        let reflector = self.reflectors.of(&eye.spot);
        let class = match reflector {
            Reflector::Fixed(_) => fixed,
            Reflector::Whole(class) | Reflector::Painted(class) => class,
        };
        let record = records.of(class);
        record.count += 1;
        self.watcher.add(path, half, &mut record.seen);
        match reflector {
            Reflector::Fixed(material) => self.add_fixed(eye, &material, &mut record.sums),
            _ => self.add_editable(eye, reflector.albedo(&eye.spot), &mut record.sums),
        }
    }

    fn add_editable(&self, eye: &EyeVertex, albedo: Vec3A, sums: &mut [f32]) {
        let (direct, before) = self.layout.editable.split_at(self.layout.bases[0]);
        for Reflection { angles, light } in eye.direct.iter().flatten() {
            let values = self.values(angles, self.layout.bases[0]);
            for (block, value) in direct.iter().zip(&values) {
                self.add_light(block, seen_by(block.eye, *light, albedo) * *value, sums);
            }
        }
        if let Some(first) = &eye.indirect {
            let at_eye = self.values(&first.eye_angles, self.layout.bases[1]);
            self.add_before(before, first, |eye, light| seen_by(eye, light, albedo) * at_eye[eye], sums);
        }
    }

    fn add_fixed(&self, eye: &EyeVertex, material: &Brdf, sums: &mut [f32]) {
        let (direct, before) = self.layout.fixed.split_at(1);
        let light = reflect(&eye.direct, eye.spot.albedo, material);
        direct.iter().for_each(|block| self.add_light(block, light, sums));
        if let Some(first) = &eye.indirect {
            let at_eye = brdf::evaluate(material, eye.spot.albedo, &first.eye_angles);
            self.add_before(before, first, |_, light| light * at_eye, sums);
        }
    }

    /// Adds what `first` sends on to all `blocks` that are of it; `to_eye` gives what a basis of the eye makes of it.
    fn add_before(
        &self,
        blocks: &[Block],
        first: &FirstVertex,
        to_eye: impl Fn(usize, Vec3A) -> Vec3A,
        sums: &mut [f32],
    ) {
        let (spot, bases) = (&first.spot, self.layout.bases[1]);
        // Sources stand in their order for each basis of the eye: everything fixed, then class by class.
        let sources = 1 + self.layout.materials() * bases;
        let of_eyes = blocks.chunks_exact(sources);
        let reflector = self.reflectors.of(spot);
        let class = match reflector {
            Reflector::Fixed(material) => {
                let light = reflect(&first.reflections, spot.albedo, &material);
                return of_eyes.for_each(|of| self.add_light(&of[0], to_eye(of[0].eye, light), sums));
            }
            Reflector::Whole(class) | Reflector::Painted(class) => class,
        };
        let sent = self.sent_on(first, reflector.albedo(spot));
        let region = region_of(spot.uv) as usize;
        for of_eye in of_eyes {
            for (block, light) in of_eye[1 + class * bases..][..bases].iter().zip(&sent) {
                let light = to_eye(block.eye, *light);
                match block.group {
                    None => self.add_light(block, light, sums),
                    Some(group) => {
                        let weights = self.weights.groups[group].of_region(region);
                        self.add_weighed(block, light, weights, sums);
                    }
                }
            }
        }
    }

    /// What a surface sends on with every basis.
    fn sent_on(&self, first: &FirstVertex, albedo: Vec3A) -> [Vec3A; MAX_BASES] {
        let mut sums = [Vec3A::ZERO; MAX_BASES];
        for Reflection { angles, light } in first.reflections.iter().flatten() {
            let values = self.values(angles, self.layout.bases[1]);
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += *light * *value);
        }
        sums[0] *= albedo;
        sums
    }

    fn add_light(&self, block: &Block, light: Vec3A, sums: &mut [f32]) {
        match &mut sums[block.start..][..block.colours] {
            [grey] => *grey += light[self.layout.grey],
            channels => channels.iter_mut().zip(light.to_array()).for_each(|(sum, light)| *sum += light),
        }
    }

    fn add_weighed(&self, block: &Block, light: Vec3A, weights: &[f32], sums: &mut [f32]) {
        let sums = &mut sums[block.start..][..block.rows * block.colours];
        if block.colours == 1 {
            let light = light[self.layout.grey];
            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * light);
        } else {
            for (sums, weight) in sums.chunks_exact_mut(3).zip(weights) {
                sums.iter_mut().zip((light * *weight).to_array()).for_each(|(sum, light)| *sum += light);
            }
        }
    }

    fn values(&self, angles: &Angles, bases: usize) -> Values {
        values(self.basis, angles, bases)
    }
}

/// Values of the first `bases` functions of a basis.
pub fn values(basis: &BrdfBasis, angles: &Angles, bases: usize) -> Values {
    let mut values = [0.0; MAX_BASES];
    basis.evaluate(angles, &mut values[..bases]);
    values
}

/// What a basis of the eye gets of `light`: the texture of the scene colours the diffuse one.
fn seen_by(eye: usize, light: Vec3A, albedo: Vec3A) -> Vec3A {
    if eye == 0 { light * albedo } else { light }
}

fn reflect(reflections: &[Option<Reflection>], albedo: Vec3A, material: &Brdf) -> Vec3A {
    reflections.iter().flatten().map(|r| r.light * brdf::evaluate(material, albedo, &r.angles)).sum()
}
