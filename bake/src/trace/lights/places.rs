//! With what chance a light is chosen at a place: by what was seen to arrive there.
//!
//! Space is cut into cells, for each of six orientations of a surface, as finely as there are visits to learn
//! from. The chance of a light is in proportion to √E[f²], f being what one sample of it brought: of all
//! choices, this has the least variance. A cell of few visits leans on the one around it, and a part of the
//! chance goes to every light whatever was seen, so that none is ever out of the question.

use crate::trace::chances::{LEAST_SHARE, pick, running_share, share};
use crate::trace::environment::PatchChances;
use crate::trace::orientation::{ORIENTATIONS, orientation_of};
use glam::Vec3A;

/// Part of the chance that is given by power, and as much again evenly.
const UNSEEN: f64 = 0.003;
/// Fewest visits to a cell of its own, and of how many choices each is to look at one at least: so cells of
/// thousands of lights know something of most, and do not fill the memory.
const MIN_VISITS: usize = 16;
const CHOICES_A_VISIT: usize = 8;
/// By how many visits a cell leans on the one around it.
const LEANING: f64 = 8.0;
/// Cells of a cell along an edge, as a binary logarithm; and how often they are cut.
const CUT_LOG2: u32 = 2;
const LEVELS: u32 = 5;
const CHILDREN: usize = 1 << (3 * CUT_LOG2);
/// No such cell.
const NONE: u32 = u32::MAX;

/// What lights send, whoever sees it.
pub struct Powers {
    /// Of each light, and of the environment at the end if there is one: parts of the whole.
    lights: Vec<f64>,
    /// Of each patch of the environment: parts of it.
    patches: Vec<f64>,
    bands: usize,
}

impl Powers {
    /// From the power of each light and of the environment, and how the latter is divided into patches, band
    /// by band. `None` if all are 0.
    pub fn new(mut lights: Vec<f64>, environment: f64, patches: Vec<f64>, bands: usize) -> Option<Self> {
        if !patches.is_empty() {
            lights.push(environment);
        }
        let total: f64 = lights.iter().sum();
        lights.iter_mut().for_each(|power| *power /= total);
        (total > 0.0).then_some(Self { lights, patches, bands })
    }

    /// Whether there is anything to choose from.
    pub fn leave_a_choice(&self) -> bool {
        self.choices() > 1
    }

    /// How many lights there are, but for the environment.
    pub fn lights(&self) -> usize {
        self.lights.len() - usize::from(!self.patches.is_empty())
    }

    /// The part that a patch has of what the environment sends.
    pub fn patch(&self, patch: usize) -> f64 {
        self.patches[patch]
    }

    /// Lights and patches.
    fn choices(&self) -> usize {
        self.lights() + self.patches.len()
    }
}

/// What one sample of a light or patch brought at a place.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Number of the light, or behind all lights that of the patch.
    pub choice: u32,
    /// f², over the chance that this choice was looked at; for patches times the part of their power, as f is
    /// of a sample of the whole environment.
    pub square: f64,
}

/// What was seen at one place.
#[derive(Debug, Clone)]
pub struct Visit {
    /// World space.
    pub position: Vec3A,
    /// Unit, world space.
    pub normal: Vec3A,
    /// Only what brought light.
    pub found: Vec<Found>,
}

/// With what chance each light is chosen.
pub struct LightChances {
    /// Running sums, the environment last.
    lights: Vec<f32>,
    patches: Option<PatchChances>,
}

impl LightChances {
    /// From E[f²] of every light and patch.
    fn new(powers: &Powers, squares: &[f64]) -> Self {
        let weights: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
        let total: f64 = weights.iter().sum();
        let [seen, unseen] = if total > 0.0 { [1.0 - 2.0 * UNSEEN, UNSEEN] } else { [0.0, 0.5] };
        let even = 1.0 / powers.lights.len() as f64;
        let (of_lights, of_patches) = weights.split_at(powers.lights());
        let learned = |weight: f64| seen * weight / total.max(f64::MIN_POSITIVE);
        let patch = |(weight, part): (&f64, &f64)| {
            let power = powers.lights.last().copied().unwrap_or_default();
            learned(*weight) + unseen * (power + even) * part
        };
        let patches: Vec<f64> = of_patches.iter().zip(&powers.patches).map(patch).collect();
        // However many lights there are, none is out of the question.
        let light =
            |(weight, power): (&f64, &f64)| (learned(*weight) + unseen * (power + even)).max(LEAST_SHARE);
        let mut lights: Vec<f64> = of_lights.iter().zip(&powers.lights).map(light).collect();
        let patches = (!patches.is_empty()).then(|| {
            lights.push(patches.iter().sum());
            PatchChances::new(&patches, powers.bands)
        });
        Self { lights: running_share(&lights), patches }
    }

    /// The light that a number in [0, 1) chooses.
    pub fn pick(&self, choice: f32) -> usize {
        pick(&self.lights, choice).0
    }

    /// The chance of a light.
    pub fn of(&self, light: usize) -> f32 {
        share(&self.lights, light)
    }

    /// Of the environment, if there is one.
    pub fn patches(&self) -> Option<&PatchChances> {
        self.patches.as_ref()
    }
}

struct Cell {
    /// Numbers of the cells that it is cut into, [`NONE`] where it was hardly visited.
    children: Option<Box<[u32; CHILDREN]>>,
    chances: LightChances,
}

/// The chances of lights all over a scene.
pub struct Places {
    /// Of the cube that is cut up.
    corner: Vec3A,
    /// Finest cells a metre.
    per_metre: f32,
    /// Fewest visits to a cell.
    fewest: usize,
    /// The first is for all that was never visited.
    cells: Vec<Cell>,
    /// By orientation.
    roots: [u32; ORIENTATIONS],
}

impl Places {
    /// From what was seen.
    pub fn new(powers: &Powers, visits: &[Visit]) -> Self {
        let far = |start: f32, f: fn(Vec3A, Vec3A) -> Vec3A| {
            visits.iter().fold(Vec3A::splat(start), |most, visit| f(most, visit.position))
        };
        let (low, high) = (far(f32::INFINITY, Vec3A::min), far(f32::NEG_INFINITY, Vec3A::max));
        let side = (high - low).max_element().max(f32::MIN_POSITIVE);
        let mut places = Self {
            corner: low,
            per_metre: (1 << (CUT_LOG2 * LEVELS)) as f32 / side,
            fewest: MIN_VISITS.max(powers.choices() / CHOICES_A_VISIT),
            cells: Vec::new(),
            roots: [0; ORIENTATIONS],
        };
        let all: Vec<&Visit> = visits.iter().collect();
        let squares = mean_squares(powers, &all, &vec![0.0; powers.choices()]);
        places.cells.push(Cell { children: None, chances: LightChances::new(powers, &squares) });
        for orientation in 0..ORIENTATIONS {
            let of: Vec<&Visit> =
                all.iter().filter(|v| orientation_of(v.normal) == orientation).copied().collect();
            if of.len() >= places.fewest {
                places.roots[orientation] = places.grow(powers, &of, &squares, 0);
            }
        }
        places
    }

    /// Adds the cell of `visits` and all that it is cut into; `around` is what the one around it has learned.
    fn grow(&mut self, powers: &Powers, visits: &[&Visit], around: &[f64], level: u32) -> u32 {
        let squares = mean_squares(powers, visits, around);
        let number = self.cells.len() as u32;
        self.cells.push(Cell { children: None, chances: LightChances::new(powers, &squares) });
        if level < LEVELS && visits.len() >= 2 * self.fewest {
            let mut parts: Vec<Vec<&Visit>> = vec![Vec::new(); CHILDREN];
            for visit in visits {
                if let Some(at) = self.finest(visit.position) {
                    parts[child(at, level)].push(visit);
                }
            }
            let mut children = Box::new([NONE; CHILDREN]);
            for (child, part) in children.iter_mut().zip(&parts) {
                if part.len() >= self.fewest {
                    *child = self.grow(powers, part, &squares, level + 1);
                }
            }
            self.cells[number as usize].children = Some(children);
        }
        number
    }

    /// The chances at a place.
    pub fn at(&self, position: Vec3A, normal: Vec3A) -> &LightChances {
        let mut cell = &self.cells[self.roots[orientation_of(normal)] as usize];
        if let Some(at) = self.finest(position) {
            for level in 0..LEVELS {
                let Some(children) = &cell.children else { break };
                let Some(next) = self.cells.get(children[child(at, level)] as usize) else { break };
                cell = next;
            }
        }
        &cell.chances
    }

    /// The finest cell, one number an axis, at a position, if it lies within the cube.
    fn finest(&self, position: Vec3A) -> Option<[u32; 3]> {
        let most = (1 << (CUT_LOG2 * LEVELS)) as f32;
        let at = (position - self.corner) * self.per_metre;
        let inside = at.min_element() >= 0.0 && at.max_element() <= most;
        inside.then(|| at.min(Vec3A::splat(most - 1.0)).to_array().map(|a| a as u32))
    }
}

/// Which child of a cell of a level holds the finest cell `at`.
fn child(at: [u32; 3], level: u32) -> usize {
    let shift = CUT_LOG2 * (LEVELS - 1 - level);
    let digit = |a: u32| (a >> shift) as usize & ((1 << CUT_LOG2) - 1);
    at.into_iter().fold(0, |child, a| child << CUT_LOG2 | digit(a))
}

fn mean_squares(powers: &Powers, visits: &[&Visit], around: &[f64]) -> Vec<f64> {
    let mut squares: Vec<f64> = around.iter().map(|square| square * LEANING).collect();
    squares.resize(powers.choices(), 0.0);
    for found in visits.iter().flat_map(|visit| &visit.found) {
        squares[found.choice as usize] += found.square;
    }
    let visits = visits.len() as f64 + LEANING;
    squares.iter_mut().for_each(|square| *square /= visits);
    squares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lights of equal power, and an environment of half of all in four patches.
    fn powers() -> Powers {
        Powers::new(vec![1.0, 1.0], 2.0, vec![0.25; 4], 2).unwrap()
    }

    fn visit(position: Vec3A, found: &[(u32, f64)]) -> Visit {
        let found = found.iter().map(|(choice, square)| Found { choice: *choice, square: *square }).collect();
        Visit { position, normal: Vec3A::Y, found }
    }

    /// A floor of which each half sees one light.
    fn floor() -> Places {
        let at = |i: u32| Vec3A::new((i % 64) as f32 / 64.0, 0.0, (i / 64) as f32 / 64.0);
        let visits: Vec<Visit> =
            (0..4096).map(|i| visit(at(i), &[(u32::from(at(i).x >= 0.5), 9.0)])).collect();
        Places::new(&powers(), &visits)
    }

    #[test]
    fn lights_are_chosen_where_they_were_seen() {
        let places = floor();
        for (x, seen) in [(0.1, 0), (0.4, 0), (0.6, 1), (0.95, 1)] {
            let chances = places.at(Vec3A::new(x, 0.0, 0.3), Vec3A::Y);
            assert!(chances.of(seen) > 0.75, "{x}: {}", chances.of(seen));
            // Nothing is out of the question: by power and evenly.
            assert!(chances.of(1 - seen) >= UNSEEN as f32 * (0.25 + 1.0 / 3.0) - 1e-6);
            assert!((chances.of(2) - UNSEEN as f32 * (0.5 + 1.0 / 3.0)).abs() < 1e-6);
            assert!(((0..3).map(|light| chances.of(light)).sum::<f32>() - 1.0).abs() < 1e-6);
        }
    }

    /// Where no visit was, the whole scene counts: both lights alike.
    #[test]
    fn elsewhere_all_visits_count() {
        let places = floor();
        for (position, normal) in [(Vec3A::splat(9.0), Vec3A::Y), (Vec3A::splat(0.3), Vec3A::NEG_X)] {
            let chances = places.at(position, normal);
            assert!((chances.of(0) - chances.of(1)).abs() < 1e-6 && chances.of(0) > 0.45);
        }
    }

    /// Chances go by the root of the mean square, the least variance of one that is chosen; a light that is
    /// seen every hundredth time, but then a hundred times as bright, counts ten times as much.
    #[test]
    fn rare_light_counts_by_its_spread() {
        let visits: Vec<Visit> = (0..10_000)
            .map(|i| {
                let rare = (1, if i % 100 == 0 { 1e4 } else { 0.0 });
                visit(Vec3A::ZERO, &[(0, 1.0), rare])
            })
            .collect();
        let places = Places::new(&powers(), &visits);
        let chances = places.at(Vec3A::ZERO, Vec3A::Y);
        let learned = |light| f64::from(chances.of(light)) - UNSEEN * (0.25 + 1.0 / 3.0);
        assert!((learned(1) / learned(0) - 10.0).abs() < 0.1, "{} {}", learned(1), learned(0));
    }

    /// A hundred thousand lights alike, of which one was seen: the others keep a chance.
    #[test]
    fn no_light_is_out_of_the_question() {
        let lights = 100_000;
        let powers = Powers::new(vec![1.0; lights], 0.0, Vec::new(), 0).unwrap();
        let places = Places::new(&powers, &vec![visit(Vec3A::ZERO, &[(7, 1.0)]); 50]);
        let chances = places.at(Vec3A::ZERO, Vec3A::Y);
        assert!(chances.of(7) > 0.9 && (0..lights).all(|light| chances.of(light) > 0.0));
    }

    #[test]
    fn without_visits_power_and_number_decide() {
        let places = Places::new(&powers(), &[]);
        let chances = places.at(Vec3A::ONE, Vec3A::Z);
        for (light, power) in [(0, 0.25), (1, 0.25), (2, 0.5)] {
            assert!((f64::from(chances.of(light)) - 0.5 * (power + 1.0 / 3.0)).abs() < 1e-6);
        }
        assert!(Powers::new(vec![0.0], 0.0, Vec::new(), 0).is_none());
    }
}
