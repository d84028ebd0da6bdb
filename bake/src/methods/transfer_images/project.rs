//! Projects paths on BRDF bases: sorts what each path carries by the materials it met, and weighs it with
//! every basis (thesis eq. 4-26, 4-27).

use super::later::{Nodes, lambert};
use crate::brdf;
use crate::filter::Watcher;
use crate::fragments::PixelRecords;
use crate::trace::gather::{EyeVertex, FirstVertex, GatherPath, Reflection};
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::MAX_BASES;
use relume_formats::kinds::transfer_images::{FirstReflection, Later, Layout};
use relume_formats::state::Brdf;

/// How paths of one scene fall into the slots of a layout.
pub struct Projector<'a> {
    basis: &'a BrdfBasis,
    layout: &'a Layout,
    /// For each material: its class if it varies, or its fixed parameters.
    materials: Vec<Reflector>,
    /// For (eye basis, first reflection): where the channels of the slot start in an editable fragment's
    /// record.
    channels: Vec<Channels>,
    /// Which channel of the light single-channel slots follow: the one where the chromaticity is 1.
    grey_channel: usize,
    /// How later reflections are baked, if they are.
    later: Option<Nodes<'a>>,
    watcher: &'a Watcher,
}

#[derive(Debug, Clone, Copy)]
enum Reflector {
    Editable(usize),
    Fixed(Brdf),
}

#[derive(Debug, Clone, Copy, Default)]
struct Channels {
    start: usize,
    rgb: bool,
}

/// Basis values at one reflection.
type Values = [f32; MAX_BASES];

impl<'a> Projector<'a> {
    /// Prepares the projection. `editable` lists the materials that vary in order of their class;
    /// `grey_channel` is the largest of the light's chromaticity; `later` is there if `layout` has later
    /// reflections.
    pub fn new(
        basis: &'a BrdfBasis,
        layout: &'a Layout,
        materials: &[Brdf],
        editable: &[usize],
        grey_channel: usize,
        later: Option<&'a Later>,
        watcher: &'a Watcher,
    ) -> Self {
        let class = |index: usize| editable.iter().position(|e| *e == index);
        let materials = materials
            .iter()
            .enumerate()
            .map(|(i, m)| class(i).map_or(Reflector::Fixed(*m), Reflector::Editable))
            .collect();
        let mut channels = vec![Channels::default(); layout.bases * layout.firsts()];
        let mut start = 0;
        for slot in &layout.slots {
            channels[slot.eye_basis * layout.firsts() + layout.first_index(slot.first)] =
                Channels { start, rgb: slot.rgb };
            start += slot.channels();
        }
        Self { basis, layout, materials, channels, grey_channel, later: later.map(Nodes::new), watcher }
    }

    /// Records with nothing in them.
    pub fn empty(&self) -> PixelRecords {
        PixelRecords::new(self.layout.materials, [self.layout.channels(), 3 * self.layout.firsts()])
    }

    /// Adds one path, of the first `half` of the samples or the second, 0 or 1.
    pub fn add(&self, path: &GatherPath, half: usize, records: &mut PixelRecords) {
        let fixed = self.layout.materials;
        // What a surface emits does not follow its material.
        Watcher::emitted(path, &mut records.of(fixed).seen);
        match path {
            GatherPath::Light(_) => records.of(fixed).count += 1,
            GatherPath::Surface(eye) => {
                let reflector = self.materials[eye.spot.material as usize];
                let class = if let Reflector::Editable(class) = reflector { class } else { fixed };
                let record = records.of(class);
                record.count += 1;
                self.watcher.add(path, half, &mut record.seen);
                match reflector {
                    Reflector::Editable(_) => self.add_editable(eye, &mut record.sums),
                    Reflector::Fixed(material) => self.add_fixed(eye, &material, &mut record.sums),
                }
            }
        }
    }

    fn add_editable(&self, eye: &EyeVertex, sums: &mut [f32]) {
        for direct in eye.direct.iter().flatten() {
            self.add_slots(
                sums,
                FirstReflection::None,
                direct.light,
                eye.spot.albedo,
                &self.values(&direct.angles),
            );
        }
        if let Some(first) = &eye.indirect {
            let at_eye = self.values(&first.eye_angles);
            self.each_first(first, |reflection, light| {
                self.add_slots(sums, reflection, light, eye.spot.albedo, &at_eye)
            });
        }
    }

    fn add_fixed(&self, eye: &EyeVertex, material: &Brdf, sums: &mut [f32]) {
        add_rgb(sums, 0, reflect(&eye.direct, eye.spot.albedo, material));
        if let Some(first) = &eye.indirect {
            let at_eye = brdf::evaluate(material, eye.spot.albedo, &first.eye_angles);
            self.each_first(first, |reflection, light| {
                add_rgb(sums, 3 * self.layout.first_index(reflection), light * at_eye)
            });
        }
    }

    /// Calls `each` with every first reflection that `first` stands for and the light it sends on.
    fn each_first(&self, first: &FirstVertex, mut each: impl FnMut(FirstReflection, Vec3A)) {
        match self.materials[first.spot.material as usize] {
            Reflector::Fixed(material) => {
                each(FirstReflection::Fixed, reflect(&first.reflections, first.spot.albedo, &material))
            }
            Reflector::Editable(material) => {
                let mut sums = [Vec3A::ZERO; MAX_BASES];
                for Reflection { angles, light } in first.reflections.iter().flatten() {
                    let values = self.values(angles);
                    sums.iter_mut()
                        .zip(&values[..self.layout.bases])
                        .for_each(|(sum, value)| *sum += *light * *value);
                }
                sums[0] *= first.spot.albedo;
                for (basis, light) in sums[..self.layout.bases].iter().enumerate() {
                    each(FirstReflection::Editable { material, basis }, *light);
                }
            }
        }
        if let Some((later, next)) = self.later.as_ref().zip(first.later.first()) {
            self.each_later(later, first, &next.next_angles, each);
        }
    }

    /// The same for what `first` sends on after more reflections, the first of which it sees at these `angles`;
    /// see [`FirstVertex::later_light`], which takes one state at a time.
    fn each_later(
        &self,
        later: &Nodes<'_>,
        first: &FirstVertex,
        angles: &Angles,
        mut each: impl FnMut(FirstReflection, Vec3A),
    ) {
        let arriving = self.arriving(&later.albedos, first);
        match self.materials[first.spot.material as usize] {
            Reflector::Fixed(material) => {
                let reflectance = brdf::evaluate(&material, first.spot.albedo, angles);
                for (node, light) in arriving.iter().enumerate() {
                    each(FirstReflection::Later { node }, *light * reflectance);
                }
            }
            Reflector::Editable(class) => {
                for (node, (light, albedos)) in arriving.iter().zip(&later.albedos).enumerate() {
                    each(FirstReflection::Later { node }, *light * lambert(Vec3A::splat(albedos[class])));
                }
                let values = self.values(angles);
                for (basis, value) in later.beyond_albedo(&values).enumerate() {
                    for (node, of_all) in later.of_lobes.iter().enumerate() {
                        let first = FirstReflection::LaterLobe { material: class, basis: 1 + basis, node };
                        each(first, arriving[*of_all] * value);
                    }
                }
            }
        }
    }

    /// What arrives at `first` after one reflection and more, at every node.
    fn arriving(&self, node_albedos: &[Vec<f32>], first: &FirstVertex) -> Vec<Vec3A> {
        let mut sums = vec![Vec3A::ZERO; node_albedos.len()];
        // What of the light goes on: by fixed surfaces, and by those that vary.
        let mut throughput = Vec3A::splat(first.weight);
        let mut shares = vec![1.0; node_albedos.len()];
        let mut before: Option<(Reflector, Vec3A)> = None;
        for vertex in &first.later {
            throughput *= vertex.weight;
            match before {
                None => {}
                Some((Reflector::Fixed(material), albedo)) => {
                    throughput *= brdf::evaluate(&material, albedo, &vertex.next_angles);
                }
                Some((Reflector::Editable(class), _)) => {
                    throughput *= lambert(Vec3A::ONE);
                    shares.iter_mut().zip(node_albedos).for_each(|(s, albedos)| *s *= albedos[class]);
                }
            }
            let (reflector, albedo) = (self.materials[vertex.spot.material as usize], vertex.spot.albedo);
            let (light, class) = match reflector {
                Reflector::Fixed(material) => (reflect(&vertex.reflections, albedo, &material), None),
                Reflector::Editable(class) => {
                    let light: Vec3A = vertex.reflections.iter().flatten().map(|r| r.light).sum();
                    (light * lambert(Vec3A::ONE), Some(class))
                }
            };
            let light = throughput * light;
            for ((sum, share), albedos) in sums.iter_mut().zip(&shares).zip(node_albedos) {
                *sum += light * (share * class.map_or(1.0, |class| albedos[class]));
            }
            before = Some((reflector, albedo));
        }
        sums
    }

    /// Adds `light`, weighed with every eye basis, to the slots of one first reflection. The eye's `albedo`
    /// acts on the diffuse basis, whose slots are all RGB.
    fn add_slots(
        &self,
        sums: &mut [f32],
        first: FirstReflection,
        light: Vec3A,
        albedo: Vec3A,
        at_eye: &Values,
    ) {
        let bases = self.layout.eye_bases(first);
        let (firsts, first) = (self.layout.firsts(), self.layout.first_index(first));
        for (eye_basis, value) in at_eye[..bases].iter().enumerate() {
            let channels = self.channels[eye_basis * firsts + first];
            if channels.rgb {
                let light = if eye_basis == 0 { light * albedo } else { light };
                add_rgb(sums, channels.start, light * *value);
            } else {
                sums[channels.start] += light[self.grey_channel] * value;
            }
        }
    }

    fn values(&self, angles: &Angles) -> Values {
        let mut values = [0.0; MAX_BASES];
        self.basis.evaluate(angles, &mut values[..self.layout.bases]);
        values
    }
}

fn reflect(reflections: &[Option<Reflection>], albedo: Vec3A, material: &Brdf) -> Vec3A {
    reflections.iter().flatten().map(|r| r.light * brdf::evaluate(material, albedo, &r.angles)).sum()
}

fn add_rgb(sums: &mut [f32], start: usize, light: Vec3A) {
    sums[start] += light.x;
    sums[start + 1] += light.y;
    sums[start + 2] += light.z;
}
