//! Which material is seen through a pixel, and the line around it.

use relume_playback::{MaterialMap, Seen};

/// The material of every pixel.
#[derive(Debug, Clone)]
pub struct Picker {
    map: MaterialMap,
}

impl Picker {
    /// The materials that `map` tells of.
    pub fn new(map: MaterialMap) -> Self {
        Self { map }
    }

    /// Film size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.map.size()
    }

    /// What the pixel in column x and row y shows; outside the film nothing.
    pub fn at(&self, pixel: [u32; 2]) -> Seen<'_> {
        self.map.at(pixel)
    }

    /// By pixel: whether it lies outside the `material` but within `distance` pixels of it, diagonal steps
    /// included.
    pub fn outline(&self, material: &str, distance: usize) -> Vec<bool> {
        let inside: Vec<bool> = self.map.pixels().map(|seen| seen == Seen::Material(material)).collect();
        let width = self.size()[0] as usize;
        let mut near = inside.clone();
        near.chunks_exact_mut(width).for_each(|row| grow(row, distance));
        for x in 0..width {
            let mut column: Vec<bool> = near.iter().skip(x).step_by(width).copied().collect();
            grow(&mut column, distance);
            for (place, value) in near.iter_mut().skip(x).step_by(width).zip(column) {
                *place = value;
            }
        }
        near.iter().zip(inside).map(|(near, inside)| *near && !inside).collect()
    }
}

/// Sets everything within `distance` of what is set.
fn grow(line: &mut [bool], distance: usize) {
    let reach = |order: &mut dyn Iterator<Item = (usize, bool)>, found: &mut Vec<usize>| {
        let mut last = None;
        for (step, (index, set)) in order.enumerate() {
            if set {
                last = Some(step);
            } else if last.is_some_and(|last| step - last <= distance) {
                found.push(index);
            }
        }
    };
    let mut found = Vec::new();
    reach(&mut line.iter().copied().enumerate(), &mut found);
    reach(&mut line.iter().copied().enumerate().rev(), &mut found);
    for index in found {
        if let Some(place) = line.get_mut(index) {
            *place = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support;

    #[test]
    fn the_outline_surrounds_the_material() {
        let picker = Picker::new((&*support::images(true).head).into());
        let [width, height] = support::SIZE.map(|n| n as i64);
        let shows =
            |x: i64, y: i64| x >= 0 && y >= 0 && picker.at([x as u32, y as u32]) == Seen::Material("a");
        for distance in [0, 1, 3] {
            let outline = picker.outline("a", distance as usize);
            for (index, on_line) in outline.iter().enumerate() {
                let (x, y) = (index as i64 % width, index as i64 / width);
                let near =
                    (-distance..=distance).any(|dy| (-distance..=distance).any(|dx| shows(x + dx, y + dy)));
                assert_eq!(*on_line, near && !shows(x, y), "{x} {y} {distance}");
            }
            assert_eq!(outline.len() as i64, width * height);
        }
        assert!(!picker.outline("no such material", 2).contains(&true));
    }
}
