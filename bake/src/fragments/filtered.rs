//! Takes the noise out of traced tiles, a tile a piece.

use super::records::{Record, Records};
use super::tiles::{SIDE, Tile, TileFragment};
use crate::error::Result;
use crate::filter::{Filter, LAYERS, Row};
use crate::stage::Stage;
use std::collections::HashMap;
use xxhash_rust::xxh3::xxh3_128;

/// Filtering tiles.
pub struct Filtered<'a> {
    traced: &'a Records<'a>,
    filter: Filter,
    /// Tiles along each side of the film.
    grid: [u32; 2],
    key: u128,
    method: &'static str,
}

impl<'a> Filtered<'a> {
    /// What was `traced` by a method, under this key.
    pub fn new(
        traced: &'a Records<'a>,
        filter: Filter,
        grid: [u32; 2],
        key: u128,
        method: &'static str,
    ) -> Self {
        Self { traced, filter, grid, key: xxh3_128(format!("{key:032x} filter").as_bytes()), method }
    }

    /// A tile and those around it, each with its number.
    fn around(&self, number: u32) -> Result<Vec<(u32, Tile)>> {
        let [columns, rows] = self.grid;
        let (column, row) = (number % columns, number / columns);
        let near = |at: u32, count: u32| at.saturating_sub(1)..(at + 2).min(count);
        let numbers = near(row, rows).flat_map(|row| near(column, columns).map(move |c| row * columns + c));
        numbers.map(|number| Ok((number, self.traced.tile(number)?))).collect()
    }

    /// What a fragment's samples add up to if each shows what `rows` say.
    fn filtered(
        &self,
        (fragment, record): &Record<'_>,
        rows: &[Row; LAYERS],
        records: &HashMap<u32, Record<'_>>,
    ) -> Vec<f32> {
        let mut values = vec![0.0; record.len()];
        for (row, channels) in rows.iter().zip(&self.traced.channels_of(fragment).layers) {
            for (number, weight) in row {
                let Some((other, sums)) = records.get(number) else { continue };
                let weight = weight * surface_samples(fragment) / surface_samples(other);
                for range in channels {
                    let all = values[range.clone()].iter_mut().zip(&sums[range.clone()]);
                    all.for_each(|(value, sum)| *value += weight * sum);
                }
            }
        }
        values
    }
}

impl Stage for Filtered<'_> {
    fn name(&self) -> String {
        format!("{}-filtered", self.method)
    }

    fn label(&self) -> Option<&'static str> {
        Some("filtering images")
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        self.grid[0] * self.grid[1]
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let tiles = self.around(number)?;
        let mut records = HashMap::new();
        for (_, tile) in &tiles {
            let known = self.traced.of(tile)?.into_iter();
            records.extend(known.filter_map(|r| Some((self.filter.number(r.0.pixel, r.0.class)?, r))));
        }
        let place = [number % self.grid[0] * SIDE, number / self.grid[0] * SIDE];
        let rows: HashMap<_, _> = self.filter.rows(place.map(|p| p as i32)).into_iter().collect();
        let own = tiles.iter().filter(|(of, _)| *of == number).map(|(_, tile)| tile);
        let mut filtered = Tile::default();
        for tile in own {
            for record in self.traced.of(tile)? {
                let number = self.filter.number(record.0.pixel, record.0.class);
                filtered.fragments.push(record.0);
                match number.and_then(|number| rows.get(&number)) {
                    Some(rows) => filtered.values.extend(self.filtered(&record, rows, &records)),
                    None => filtered.values.extend_from_slice(record.1),
                }
            }
        }
        Ok(filtered.encode())
    }
}

fn surface_samples(fragment: &TileFragment) -> f32 {
    fragment.seen.samples[0] + fragment.seen.samples[1]
}
