//! All fragments of a film, and which are neighbours of which.

use super::seen::{LAYERS, LOOKS, Seen, StateLight};
use glam::Vec3A;

/// How far variances are averaged: two halves alone tell little of each.
const VARIANCE_RADIUS: i32 = 2;
/// No fragment.
const NONE: u32 = u32::MAX;

/// One class of surfaces seen through one pixel, means over its samples.
#[derive(Debug, Clone, Copy)]
pub struct Fragment {
    /// y·width + x.
    pub pixel: u32,
    /// Class of material.
    pub class: u16,
    /// Film samples that fell on surfaces.
    pub samples: f32,
    /// Their part of those of the pixel.
    pub coverage: f32,
    /// World space.
    pub position: Vec3A,
    /// Mean of unit normals, world space.
    pub normal: Vec3A,
    /// See [`Seen::colour`].
    pub colour: Vec3A,
    /// Light in the states, by half of the samples and by layer, in parts of the largest of a state.
    pub guides: [[StateLight; LAYERS]; 2],
    /// Whether both halves of the samples fell on it: else nothing tells its noise.
    pub has_halves: bool,
    /// Variance of one half's.
    pub variances: [StateLight; LAYERS],
}

impl Fragment {
    /// Both halves together.
    pub fn guide(&self, layer: usize) -> StateLight {
        let [a, b] = [0, 1].map(|half| &self.guides[half][layer]);
        std::array::from_fn(|state| 0.5 * (a[state] + b[state]))
    }
}

/// Where the fragments of one class are.
struct Places {
    /// Upper left pixel.
    from: [i32; 2],
    size: [i32; 2],
    /// Row by row.
    fragments: Vec<u32>,
}

impl Places {
    fn at(&self, x: i32, y: i32) -> Option<u32> {
        let [x, y] = [x - self.from[0], y - self.from[1]];
        let inside = (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y);
        inside.then(|| self.fragments[(y * self.size[0] + x) as usize]).filter(|f| *f != NONE)
    }
}

/// All fragments of surfaces.
pub struct Film {
    width: u32,
    fragments: Vec<Fragment>,
    /// By class.
    places: Vec<Places>,
}

impl Film {
    /// Of fragments with their pixels, which have so many `samples`, and classes; those in which no surface is
    /// seen are left out.
    pub fn new(
        width: u32,
        samples: impl Fn(u32) -> u32,
        seen: impl Iterator<Item = (u32, u16, Seen)>,
    ) -> Self {
        let is_surface = |(_, _, seen): &(u32, u16, Seen)| seen.samples[0] + seen.samples[1] > 0.0;
        let of = |(pixel, class, seen): (u32, u16, Seen)| fragment(pixel, class, &seen, samples(pixel));
        let mut fragments: Vec<Fragment> = seen.filter(is_surface).map(of).collect();
        fragments.sort_by_key(|f| (f.class, f.pixel));
        scale_guides(&mut fragments);
        let classes = fragments.last().map_or(0, |f| usize::from(f.class) + 1);
        let mut film = Self { width, fragments, places: Vec::new() };
        film.places = (0..classes).map(|class| film.places_of(class as u16)).collect();
        film.smooth_variances();
        film
    }

    /// All of them, by class and pixel.
    pub fn fragments(&self) -> &[Fragment] {
        &self.fragments
    }

    /// Number of classes.
    pub fn classes(&self) -> usize {
        self.places.len()
    }

    /// The number of the fragment of `class` at a pixel, which may be beyond the film.
    pub fn at(&self, class: usize, x: i32, y: i32) -> Option<u32> {
        self.places.get(class)?.at(x, y)
    }

    /// The number of the fragment of a class in a pixel, if a surface is seen there.
    pub fn number(&self, pixel: u32, class: u16) -> Option<u32> {
        self.at(usize::from(class), (pixel % self.width) as i32, (pixel / self.width) as i32)
    }

    /// Where a fragment is.
    pub fn pixel(&self, fragment: &Fragment) -> [i32; 2] {
        [(fragment.pixel % self.width) as i32, (fragment.pixel / self.width) as i32]
    }

    fn places_of(&self, class: u16) -> Places {
        let from = self.fragments.partition_point(|f| f.class < class);
        let to = self.fragments.partition_point(|f| f.class <= class);
        let pixels = self.fragments[from..to].iter().map(|f| self.pixel(f));
        let none = ([i32::MAX; 2], [i32::MIN; 2]);
        let (low, high) = pixels.fold(none, |(low, high), p| {
            (std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k] + 1)))
        });
        let size: [i32; 2] = if from == to { [0; 2] } else { std::array::from_fn(|k| high[k] - low[k]) };
        let mut fragments = vec![NONE; (size[0] * size[1]) as usize];
        for (number, fragment) in (from..to).zip(&self.fragments[from..to]) {
            let [x, y] = self.pixel(fragment);
            fragments[((y - low[1]) * size[0] + x - low[0]) as usize] = number as u32;
        }
        Places { from: low, size, fragments }
    }

    fn smooth_variances(&mut self) {
        let smooth: Vec<[StateLight; LAYERS]> =
            self.fragments.iter().map(|f| self.mean_variance(f)).collect();
        self.fragments.iter_mut().zip(smooth).for_each(|(f, smooth)| f.variances = smooth);
    }

    /// Weighed by samples: a fragment that has few says little, and that it has few makes it noisier.
    fn mean_variance(&self, fragment: &Fragment) -> [StateLight; LAYERS] {
        let ([x, y], class) = (self.pixel(fragment), usize::from(fragment.class));
        let (mut sums, mut weights) = ([[0.0; LOOKS]; LAYERS], 0.0);
        let side = -VARIANCE_RADIUS..=VARIANCE_RADIUS;
        for (dx, dy) in side.clone().flat_map(|dy| side.clone().map(move |dx| (dx, dy))) {
            let Some(other) = self.at(class, x + dx, y + dy) else { continue };
            let other = &self.fragments[other as usize];
            if !other.has_halves {
                continue;
            }
            let of_all = sums.as_flattened_mut().iter_mut().zip(other.variances.as_flattened());
            of_all.for_each(|(sum, variance)| *sum += variance * other.samples * other.samples);
            weights += other.samples;
        }
        let scale = if weights > 0.0 { 1.0 / (weights * fragment.samples) } else { 0.0 };
        sums.map(|states| states.map(|sum| sum * scale))
    }
}

fn fragment(pixel: u32, class: u16, seen: &Seen, all_samples: u32) -> Fragment {
    let samples = seen.samples[0] + seen.samples[1];
    let mean = |sum: [f32; 3]| Vec3A::from(sum) / samples;
    let half = |half: usize| {
        let scale = if seen.samples[half] > 0.0 { 1.0 / seen.samples[half] } else { 0.0 };
        seen.guides[half].map(|layer| layer.map(|sum| sum * scale))
    };
    let mut guides = [half(0), half(1)];
    // A half without samples knows nothing else than the other.
    for (empty, other) in [(0, 1), (1, 0)] {
        if seen.samples[empty] == 0.0 {
            guides[empty] = guides[other];
        }
    }
    Fragment {
        pixel,
        class,
        samples,
        coverage: samples / all_samples as f32,
        position: mean(seen.position),
        normal: mean(seen.normal),
        colour: mean(seen.colour),
        guides,
        has_halves: seen.samples[0] > 0.0 && seen.samples[1] > 0.0,
        variances: Default::default(),
    }
}

/// Makes the largest guide of each state 1, so that squares are numbers however bright the light is, and
/// tells what halves differ by.
fn scale_guides(fragments: &mut [Fragment]) {
    let mut largest = [0.0f32; LOOKS];
    for guide in fragments.iter().flat_map(|f| f.guides.as_flattened()) {
        largest.iter_mut().zip(guide).for_each(|(largest, value)| *largest = largest.max(*value));
    }
    let scales = largest.map(|l| if l > 0.0 && l.is_finite() { l } else { 1.0 });
    for fragment in fragments {
        for guide in fragment.guides.as_flattened_mut() {
            guide.iter_mut().zip(scales).for_each(|(value, scale)| *value /= scale);
        }
        let [a, b] = fragment.guides;
        fragment.variances = std::array::from_fn(|layer| {
            std::array::from_fn(|state| 0.5 * (a[layer][state] - b[layer][state]).powi(2))
        });
    }
}
