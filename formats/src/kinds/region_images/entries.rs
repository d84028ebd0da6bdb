//! Haar coefficients that are not 0, place by place: a sparse matrix of places × rows.
//!
//! A *place* is one coefficient of one tile: tile · [`CELLS`] + its index ([`crate::basis::haar`]). What is stored of
//! a [`Part`] are the numbers of entries of its places, tile by tile; then for each entry how far its row is beyond
//! that of the entry before at the place, or beyond −1, less 1; and then its number of steps, 0, −1, 1, −2, 2 … as 0,
//! 1, 2, 3, 4 …

use super::planes::CELLS;

/// Places of a tile that are coarse: its image of 8 × 8 averages.
const COARSE: usize = 64;

/// Which places of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The first 64.
    Coarse,
    /// The others.
    Fine,
}

/// The coefficients of all rows of a basis of the eye.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Entries {
    /// Where the entries of each place start, and the end of the last.
    pub starts: Vec<u32>,
    /// Row of each entry, increasing at each place.
    pub rows: Vec<u16>,
    /// Steps of each entry; not 0.
    pub steps: Vec<i16>,
}

impl Part {
    /// Both, in the order of a file.
    pub const ALL: [Self; 2] = [Self::Coarse, Self::Fine];

    /// As sections call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coarse => "coarse",
            Self::Fine => "fine",
        }
    }

    /// The one that sections call so.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|part| part.name() == name)
    }

    fn places(self) -> std::ops::Range<usize> {
        match self {
            Self::Coarse => 0..COARSE,
            Self::Fine => COARSE..CELLS,
        }
    }
}

impl Entries {
    /// No entries at all, of so many tiles.
    pub fn empty(tiles: usize) -> Self {
        Self { starts: vec![0; tiles * CELLS + 1], rows: Vec::new(), steps: Vec::new() }
    }

    /// Those of the places of every tile, [tiles · [`CELLS`]], each (row, steps) in order of rows.
    pub fn of_places(places: &[Vec<(u16, i16)>]) -> Self {
        let mut starts = vec![0];
        let mut end = 0;
        starts.extend(places.iter().map(|place| {
            end += place.len() as u32;
            end
        }));
        let (rows, steps) = places.iter().flatten().copied().unzip();
        Self { starts, rows, steps }
    }

    /// The (row, steps) of a place.
    pub fn at(&self, place: usize) -> impl Iterator<Item = (u16, i16)> {
        let range = match self.starts.get(place..place + 2) {
            Some([start, end]) => *start as usize..*end as usize,
            _ => 0..0,
        };
        let rows = self.rows.get(range.clone()).unwrap_or_default();
        rows.iter().copied().zip(self.steps.get(range).unwrap_or_default().iter().copied())
    }

    /// Number of places.
    pub fn places(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The entries of several, none of which has any at a place where another does.
    pub fn joined(parts: &[Self]) -> Self {
        let places = parts.iter().map(Self::places).max().unwrap_or(0);
        let of_place = |place: usize| parts.iter().flat_map(|part| part.at(place)).collect::<Vec<_>>();
        Self::of_places(&(0..places).map(of_place).collect::<Vec<_>>())
    }

    /// What is stored of a part.
    pub fn encode(&self, part: Part) -> Vec<u16> {
        let tiles = self.places() / CELLS;
        let places = || (0..tiles).flat_map(|tile| part.places().map(move |place| tile * CELLS + place));
        let mut stored: Vec<u16> = places().map(|place| self.at(place).count() as u16).collect();
        for place in places() {
            let mut next = 0;
            for (row, _) in self.at(place) {
                stored.push(row - next);
                next = row + 1;
            }
        }
        stored.extend(places().flat_map(|place| self.at(place)).map(|(_, steps)| folded(steps)));
        stored
    }

    /// The inverse of [`Entries::encode`], for so many tiles and rows; `None` if `stored` is none of those.
    pub fn decode(stored: &[u16], part: Part, tiles: usize, rows: usize) -> Option<Self> {
        let (counts, rest) = stored.split_at_checked(tiles * part.places().len())?;
        let all: usize = counts.iter().map(|count| usize::from(*count)).sum();
        let (beyond, steps) = rest.split_at_checked(all)?;
        if steps.len() != all {
            return None;
        }
        let mut entries = Self { starts: Vec::new(), rows: Vec::with_capacity(all), steps: Vec::new() };
        let mut counts = counts.iter();
        for place in 0..tiles * CELLS {
            entries.starts.push(entries.rows.len() as u32);
            if !part.places().contains(&(place % CELLS)) {
                continue;
            }
            let mut next = 0;
            for _ in 0..*counts.next()? {
                let row = next + usize::from(*beyond.get(entries.rows.len())?);
                if row >= rows {
                    return None;
                }
                entries.rows.push(row as u16);
                next = row + 1;
            }
        }
        entries.starts.push(entries.rows.len() as u32);
        entries.steps = steps.iter().map(|stored| unfolded(*stored)).collect();
        (!entries.steps.contains(&0)).then_some(entries)
    }
}

/// 0, −1, 1, −2, 2 … as 0, 1, 2, 3, 4 …
fn folded(value: i16) -> u16 {
    ((value << 1) ^ (value >> 15)) as u16
}

fn unfolded(stored: u16) -> i16 {
    (stored >> 1) as i16 ^ -((stored & 1) as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Entries {
        let place = |place: usize| {
            let rows = (0..40u16).filter(|row| (usize::from(*row) * 7 + place * 13).is_multiple_of(11));
            rows.map(|row| (row, (place as i16 % 90 - 45) * 2 + 1)).collect()
        };
        Entries::of_places(&(0..2 * CELLS).map(place).collect::<Vec<_>>())
    }

    #[test]
    fn parts_come_back_and_make_the_whole() {
        let all = some();
        let parts = Part::ALL.map(|part| Entries::decode(&all.encode(part), part, 2, 40).unwrap());
        assert!(parts.iter().all(|part| part.places() == all.places() && *part != all));
        assert_eq!(Entries::joined(&parts), all);
        let none = Entries::empty(3);
        assert_eq!(Entries::decode(&none.encode(Part::Fine), Part::Fine, 3, 1), Some(none));
    }

    #[test]
    fn numbers_of_no_matrix_are_refused() {
        let stored = some().encode(Part::Coarse);
        let decode = |stored: &[u16], tiles, rows| Entries::decode(stored, Part::Coarse, tiles, rows);
        assert!(decode(&stored, 2, 39).is_none() && decode(&stored, 3, 40).is_none());
        assert!(decode(&stored[1..], 2, 40).is_none() && decode(&[], 2, 40).is_none());
        let mut zero = stored.clone();
        *zero.last_mut().unwrap() = 0;
        assert!(decode(&zero, 2, 40).is_none());
        let mut many = stored;
        many[0] = u16::MAX;
        assert!(decode(&many, 2, 40).is_none());
    }
}
