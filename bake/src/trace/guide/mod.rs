//! Where light comes from that paths must find by themselves, by place on the film: from what the eye sees
//! they look there more often.
//!
//! The film is cut into tiles, and what is seen in one into six orientations. A cell knows from which
//! directions light came in some paths; of few paths it leans on the cell twice as wide. Learned of random
//! states of the materials, it serves all of them.

mod directions;
mod parts;
mod sphere;

use super::orientation::{ORIENTATIONS, orientation_of};
pub use directions::Directions;
use directions::{MeanSquares, Tally};
use glam::Vec3A;
use parts::Parts;
pub use parts::{Trial, Trials};
use rayon::prelude::*;

/// Finest tiles along a side of the film.
const TILES: usize = 32;

/// What light came from where at each place of the film.
pub struct FilmTally {
    /// Of the finest tiles by row, each by orientation.
    cells: Vec<Option<Tally>>,
}

impl Default for FilmTally {
    /// Without any light.
    fn default() -> Self {
        Self { cells: vec![None; TILES * TILES * ORIENTATIONS] }
    }
}

impl FilmTally {
    /// Adds the square of what arrived from `direction` at a surface of this unit normal, seen at `place`,
    /// the film being the unit square.
    pub fn add(&mut self, place: [f32; 2], normal: Vec3A, direction: Vec3A, square: f32) {
        self.cells[cell(place, normal, TILES)].get_or_insert_default().add(direction, square);
    }

    /// What the finest cells know, each by its number; of a cell that no path was in, what the one around it
    /// knows. `None` if no path was there either.
    fn known(&self) -> (Vec<MeanSquares>, Vec<Option<usize>>) {
        let mut wider_levels: Vec<Vec<Option<Tally>>> = Vec::new();
        let mut side = TILES / 2;
        while side > 0 {
            wider_levels.push(merged(wider_levels.last().unwrap_or(&self.cells), side));
            side /= 2;
        }
        let mut known: Vec<MeanSquares> = Vec::new();
        let mut numbers: Vec<Option<usize>> = vec![None; ORIENTATIONS];
        for (level, cells) in wider_levels.iter().rev().chain([&self.cells]).enumerate() {
            let around = |cell: usize| numbers[if level == 0 { cell } else { wider(cell, 1 << level) }];
            let learn = |cell: usize| {
                let before = around(cell).map(|number| &known[number]);
                cells[cell].as_ref().map(|seen| seen.mean_squares(before))
            };
            let learned: Vec<_> = (0..cells.len()).into_par_iter().map(learn).collect();
            let number = |(cell, learned): (usize, Option<MeanSquares>)| match learned {
                Some(squares) => {
                    known.push(squares);
                    Some(known.len() - 1)
                }
                None => around(cell),
            };
            numbers = learned.into_iter().enumerate().map(number).collect();
        }
        (known, numbers)
    }
}

/// Where paths look from each place of the film.
pub struct Guide {
    /// By number; `None` where no cell has it.
    directions: Vec<Option<Directions>>,
    /// As in [`FilmTally`], the numbers of directions; `None` where no path was.
    cells: Vec<Option<usize>>,
    parts: Parts,
}

impl Guide {
    /// From what was seen. As many paths follow it as `trials` of another one say is best; without any, half
    /// of them.
    pub fn new(seen: &FilmTally, trials: Option<&Trials>) -> Self {
        let (known, cells) = seen.known();
        let mut is_used = vec![false; known.len()];
        cells.iter().flatten().for_each(|number| is_used[*number] = true);
        let directions =
            known.par_iter().zip(is_used).map(|(squares, used)| used.then(|| Directions::new(squares)));
        let directions = directions.collect();
        Self { directions, cells, parts: trials.map_or_else(Parts::half, Trials::parts) }
    }

    /// Where a surface of this normal, seen at `place`, gets its light from, and how many of its paths look
    /// there. `shift`, in the unit square, moves the place by up to half a tile, so that over many samples no
    /// tile has a border.
    pub fn at(&self, place: [f32; 2], shift: [f32; 2], normal: Vec3A) -> Option<(&Directions, f32)> {
        let moved = |tiles: usize| std::array::from_fn(|k| place[k] + (shift[k] - 0.5) / tiles as f32);
        let part = self.parts.at(moved(parts::TILES), normal);
        let number = self.cells[cell(moved(TILES), normal, TILES)].filter(|_| part > 0.0)?;
        self.directions[number].as_ref().map(|directions| (directions, part))
    }
}

/// The cells of tiles twice as wide, `side` of them along a side.
fn merged(cells: &[Option<Tally>], side: usize) -> Vec<Option<Tally>> {
    let mut wide: Vec<Option<Tally>> = vec![None; side * side * ORIENTATIONS];
    for (number, seen) in cells.iter().enumerate() {
        if let Some(seen) = seen {
            wide[wider(number, 2 * side)].get_or_insert_default().merge(seen);
        }
    }
    wide
}

/// The cell twice as wide around cell `number` of tiles of which there are `side` along a side.
fn wider(number: usize, side: usize) -> usize {
    let (tile, orientation) = (number / ORIENTATIONS, number % ORIENTATIONS);
    let [x, y] = [tile % side, tile / side].map(|at| at / 2);
    (y * (side / 2) + x) * ORIENTATIONS + orientation
}

/// The cell of a place, which may be beyond the film, and of a normal.
fn cell(place: [f32; 2], normal: Vec3A, tiles: usize) -> usize {
    let [x, y] = place.map(|at| ((at * tiles as f32).max(0.0) as usize).min(tiles - 1));
    (y * tiles + x) * ORIENTATIONS + orientation_of(normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::gather::Onward;

    /// Light from the right on the left half of the film, from the left on the right half; nothing is seen of
    /// ceilings.
    fn crossed() -> FilmTally {
        let mut tally = FilmTally::default();
        for k in 0..1 << 18u32 {
            let place = [(k % 512) as f32 / 512.0, (k / 512) as f32 / 512.0];
            let from = if place[0] < 0.5 { Vec3A::X } else { Vec3A::NEG_X };
            tally.add(place, Vec3A::Y, from, 1.0);
            tally.add(place, Vec3A::Y, -from, 0.0);
        }
        tally
    }

    #[test]
    fn each_place_knows_its_light() {
        let guide = Guide::new(&crossed(), None);
        for (x, from) in [(0.1, Vec3A::X), (0.45, Vec3A::X), (0.55, Vec3A::NEG_X), (1.2, Vec3A::NEG_X)] {
            let (directions, part) = guide.at([x, 0.3], [0.5; 2], Vec3A::Y).unwrap();
            assert!(directions.density(from) > 100.0 * directions.density(-from) && part == 0.5, "{x}");
        }
        assert!(guide.at([0.1, 0.3], [0.5; 2], Vec3A::NEG_Y).is_none());
    }

    /// A tile that no path was in knows what the tiles around it do.
    #[test]
    fn tiles_lean_on_wider_ones() {
        let mut tally = FilmTally::default();
        tally.add([0.02, 0.02], Vec3A::Y, Vec3A::Z, 1.0);
        let guide = Guide::new(&tally, None);
        let (far, _) = guide.at([0.9, 0.9], [0.5; 2], Vec3A::Y).unwrap();
        assert!(far.density(Vec3A::Z) > 10.0);
    }

    /// Paths that find all their light where the guide looks should follow it; where it comes from elsewhere
    /// they should not.
    #[test]
    fn as_many_paths_follow_as_have_the_least_variance() {
        let mut trials = Trials::default();
        let onward =
            |place, densities| Onward { place, direction: Vec3A::X, density: 1.0, densities, of_light: 0.0 };
        let mut add = |place, moment, densities| {
            trials.add(Vec3A::Y, &Trial { moment, onward: &onward(place, densities) })
        };
        // What they find counts little beside the third cell for the film as a whole.
        add([0.1, 0.1], 1e-4, [10.0, 0.1]);
        add([0.9, 0.1], 1e-4, [0.0, 0.1]);
        // Of the choices, 1 / (2p + 0.1 (1 − p)) + 1 / (1 − p) is least for a half.
        add([0.1, 0.9], 1.0, [2.0, 0.1]);
        add([0.1, 0.9], 1.0, [0.0, 1.0]);
        let guide = Guide::new(&crossed(), Some(&trials));
        let part = |place| guide.at(place, [0.5; 2], Vec3A::Y).map_or(0.0, |(_, part)| part);
        // By itself the first would take the most that there is; the film as a whole holds it back.
        assert_eq!([part([0.1, 0.1]), part([0.9, 0.1]), part([0.1, 0.9])], [0.5, 0.0, 0.5]);
        // Where nothing was tried, what is best for the film.
        assert_eq!(part([0.9, 0.9]), 0.5);
    }
}
