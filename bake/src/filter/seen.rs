//! What the samples of a fragment tell of it beside what is stored.

use crate::brdf;
use crate::random_state::{all_as_sharp_as_they_get, all_in_random_state};
use crate::trace::gather::{EyeVertex, GatherPath};
use crate::trace::spot::Spot;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::state::Brdf;
use relume_scenes::Scene;
use std::f32::consts::FRAC_1_PI;

/// Random states in which fragments are looked at: enough that what shines or is dark in one shows in
/// another.
pub const STATES: usize = 4;
/// These, and one in which all that varies is as sharp as it gets: in its direct light stand highlights that
/// must not be blurred. What is told of noise is told of random states alone.
pub const LOOKS: usize = STATES + 1;
/// The first of these states; bakes are judged by others.
const FIRST_STATE: u32 = 0x6775_6964;
/// How often light was reflected: once, twice, more often.
pub const LAYERS: usize = 3;
/// Numbers that one [`Seen`] has.
pub const WORDS: usize = 14 + 2 * LAYERS * LOOKS;
/// The albedo that materials that vary have at third and later reflections.
const TYPICAL_ALBEDO: f32 = 0.5;

/// Light by how often it was reflected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Once.
    Direct,
    /// Twice.
    Indirect,
    /// Three times or more.
    Later,
}

/// How many looks the light of a layer has: later layers have no highlights.
pub const fn looks_of(layer: usize) -> usize {
    if layer == Layer::Direct as usize { LOOKS } else { STATES }
}

/// Mean over the channels of light, in each state that is looked at; 0 where none is, see [`looks_of`].
pub type StateLight = [f32; LOOKS];

/// Sums over the samples of a fragment; or over none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// Samples of each half that fell on a surface.
    pub samples: [f32; 2],
    /// World space.
    pub position: [f32; 3],
    /// Shading normals.
    pub normal: [f32; 3],
    /// What surfaces that do not vary reflect, and colours of textures.
    pub colour: [f32; 3],
    /// Light that surfaces emit, and that of lights: it has no noise but that of its edges.
    pub emitted: [f32; 3],
    /// Light in the states, by the half of the samples and by layer.
    pub guides: [[StateLight; LAYERS]; 2],
}

/// Which half sample number `number` of a pixel's `samples` is of, 0 or 1.
pub fn half_of(number: u32, samples: u32) -> usize {
    usize::from(2 * u64::from(number) >= u64::from(samples))
}

impl Seen {
    /// Makes all samples so far the first half, the other one having none.
    pub fn join_halves(&mut self) {
        let [first, second] = &mut self.guides;
        let sums = first.as_flattened_mut().iter_mut().zip(second.as_flattened());
        sums.for_each(|(sum, light)| *sum += light);
        *second = Default::default();
        self.samples = [self.samples[0] + self.samples[1], 0.0];
    }

    /// As numbers, and back by [`Seen::from_words`].
    pub fn words(&self) -> [f32; WORDS] {
        let mut words = [0.0; WORDS];
        let vectors = [self.position, self.normal, self.colour, self.emitted];
        let all = self
            .samples
            .iter()
            .chain(vectors.as_flattened())
            .chain(self.guides.as_flattened().as_flattened());
        words.iter_mut().zip(all).for_each(|(word, value)| *word = *value);
        words
    }

    /// The inverse of [`Seen::words`].
    pub fn from_words(words: &[f32; WORDS]) -> Self {
        let mut rest = words.iter().copied();
        let mut next = || rest.next().unwrap_or_default();
        let samples = std::array::from_fn(|_| next());
        let [position, normal, colour, emitted] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let guides = std::array::from_fn(|_| std::array::from_fn(|_| std::array::from_fn(|_| next())));
        Self { samples, position, normal, colour, emitted, guides }
    }
}

/// Looks at paths of one scene.
pub struct Watcher {
    /// By look, all materials.
    states: Vec<Vec<Brdf>>,
    /// For each material, whether it varies.
    varies: Vec<bool>,
}

impl Watcher {
    /// For `scene`.
    pub fn new(scene: &Scene) -> Self {
        Self {
            states: (0..STATES as u32)
                .map(|number| all_in_random_state(FIRST_STATE + number, scene))
                .chain([all_as_sharp_as_they_get(FIRST_STATE + STATES as u32, scene)])
                .collect(),
            varies: (0..scene.materials.len()).map(|m| scene.vary.materials.contains(&m)).collect(),
        }
    }

    /// The random states in which it looks at them: of each, all materials.
    pub fn states(&self) -> &[Vec<Brdf>] {
        &self.states[..STATES]
    }

    /// Adds a path to what is seen of its fragment, `half` of the samples being 0 or 1. Light that a surface
    /// of a material that varies emits is another fragment's; see [`Watcher::emitted`].
    pub fn add(&self, path: &GatherPath, half: usize, seen: &mut Seen) {
        let GatherPath::Surface(eye) = path else { return };
        seen.samples[half] += 1.0;
        add(&mut seen.position, eye.position);
        add(&mut seen.normal, eye.normal);
        add(&mut seen.colour, self.colour(eye));
        let lights = self.lights(eye);
        let all = seen.guides[half].as_flattened_mut().iter_mut().zip(lights.as_flattened());
        all.for_each(|(sum, light)| *sum += light);
    }

    /// Light in the states, mean over channels, by layer.
    pub fn lights(&self, eye: &EyeVertex) -> [StateLight; LAYERS] {
        let mut lights = [[0.0; LOOKS]; LAYERS];
        for (look, materials) in self.states.iter().enumerate() {
            let of_layers = self.light(eye, materials).into_iter().enumerate();
            for (layer, light) in of_layers.filter(|(layer, _)| look < looks_of(*layer)) {
                lights[layer][look] = (light.x + light.y + light.z) / 3.0;
            }
        }
        lights
    }

    /// What the eye sees emit.
    pub fn emitted(path: &GatherPath, seen: &mut Seen) {
        match path {
            GatherPath::Light(radiance) => add(&mut seen.emitted, *radiance),
            GatherPath::Surface(eye) => add(&mut seen.emitted, eye.emitted),
        }
    }

    /// What tells one surface from the next, but for light: two fixed materials may meet in one plane.
    fn colour(&self, eye: &EyeVertex) -> Vec3A {
        if self.varies[eye.spot.material as usize] {
            return eye.spot.albedo;
        }
        match self.states[0][eye.spot.material as usize] {
            Brdf::BlinnPhong(m) => Vec3A::from(m.kd) * eye.spot.albedo + Vec3A::from(m.ks),
            Brdf::CookTorrance(m) => Vec3A::from(m.kd) * eye.spot.albedo + Vec3A::from(m.ks),
            Brdf::Ggx(m) => Vec3A::from(m.base_color) * eye.spot.albedo,
        }
    }

    /// By layer, as if materials that vary were matt where fourth and later reflections come from. At the
    /// surface before the eye's bakes keep less of a lobe than is looked at here, so that there is less noise.
    fn light(&self, eye: &EyeVertex, materials: &[Brdf]) -> [Vec3A; LAYERS] {
        let brdf = |spot: &Spot, angles: &Angles| {
            brdf::evaluate(&materials[spot.material as usize], spot.albedo, angles)
        };
        let [direct, indirect] = eye.early_light(brdf);
        [direct, indirect, eye.later_light(brdf, brdf, matt_where_it_varies(&self.varies, brdf))]
    }
}

/// `brdf`, which takes a point of a surface and angles, but matt for materials that vary: as third and later
/// reflections are looked at.
pub fn matt_where_it_varies(
    varies: &[bool],
    brdf: impl Fn(&Spot, &Angles) -> Vec3A,
) -> impl Fn(&Spot, &Angles) -> Vec3A {
    move |spot, angles| {
        let typical = Vec3A::splat(TYPICAL_ALBEDO * FRAC_1_PI);
        if varies[spot.material as usize] { typical } else { brdf(spot, angles) }
    }
}

fn add(sum: &mut [f32; 3], value: Vec3A) {
    sum.iter_mut().zip(value.to_array()).for_each(|(sum, value)| *sum += value);
}
