//! Which material is seen through a pixel, and the line around it.

use relume_formats::kinds::transfer_images::Head;

/// No fragment at all.
const NOTHING: u16 = u16::MAX;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen<'a> {
    /// An editable material.
    Material(&'a str),
    /// Something that does not vary.
    Fixed,
    /// Nothing.
    Nothing,
}

/// The material of every pixel: of the editable ones that which covers most of it.
#[derive(Debug, Clone)]
pub struct Picker {
    size: [u32; 2],
    materials: Vec<String>,
    /// By pixel: index of the material, their number for what is fixed, or [`NOTHING`].
    class: Vec<u16>,
}

impl Picker {
    /// The materials that `head` tells of.
    pub fn new(head: &Head) -> Self {
        let [width, height] = head.meta.size;
        let fixed = head.meta.materials.len() as u16;
        let mut class = vec![NOTHING; width as usize * height as usize];
        let mut best = vec![half::f16::ZERO; class.len()];
        for ((pixel, of), coverage) in head.pixel.iter().zip(&head.class).zip(&head.coverage) {
            let (Some(class), Some(best)) = (class.get_mut(*pixel as usize), best.get_mut(*pixel as usize)) else { continue };
            let is_first_choice = *of != fixed && (*class >= fixed || *coverage > *best);
            if is_first_choice || *class == NOTHING {
                (*class, *best) = (*of, *coverage);
            }
        }
        Self { size: head.meta.size, materials: head.meta.materials.clone(), class }
    }

    /// Film size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What the pixel in column x and row y shows; outside the film nothing.
    pub fn at(&self, [x, y]: [u32; 2]) -> Seen<'_> {
        let inside = x < self.size[0] && y < self.size[1];
        let class = self.class.get(y as usize * self.size[0] as usize + x as usize).filter(|_| inside);
        match class.copied().unwrap_or(NOTHING) {
            NOTHING => Seen::Nothing,
            class => self.materials.get(usize::from(class)).map_or(Seen::Fixed, |name| Seen::Material(name)),
        }
    }

    /// By pixel: whether it lies outside the `material` but within `distance` pixels of it, diagonal steps included.
    pub fn outline(&self, material: &str, distance: usize) -> Vec<bool> {
        let index = self.materials.iter().position(|name| name == material);
        let inside: Vec<bool> = self.class.iter().map(|class| Some(usize::from(*class)) == index).collect();
        let width = self.size[0] as usize;
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
    fn the_editable_material_that_covers_most_is_seen() {
        let mut head = (*support::images(true).head).clone();
        // Uneven coverages, else every choice is as good as another.
        for (index, coverage) in head.coverage.iter_mut().enumerate() {
            *coverage = half::f16::from_f32(0.05 + (index * 37 % 100) as f32 / 110.0);
        }
        let picker = Picker::new(&head);
        let mut kinds = [0; 3];
        for pixel in 0..support::PIXELS as u32 {
            let fragments = || (0..head.pixel.len()).filter(|i| head.pixel[*i] == pixel);
            let editable = fragments().filter(|i| head.class[*i] < 2).max_by(|i, j| head.coverage[*i].total_cmp(&head.coverage[*j]));
            let expected = match (editable, fragments().next()) {
                (Some(index), _) => Seen::Material(&head.meta.materials[usize::from(head.class[index])]),
                (None, Some(_)) => Seen::Fixed,
                (None, None) => Seen::Nothing,
            };
            assert_eq!(picker.at([pixel % support::SIZE[0], pixel / support::SIZE[0]]), expected, "{pixel}");
            kinds[match expected {
                Seen::Material(_) => 0,
                Seen::Fixed => 1,
                Seen::Nothing => 2,
            }] += 1;
        }
        assert!(kinds.iter().all(|n| *n > 0), "{kinds:?}");
        for outside in [[support::SIZE[0], 0], [0, support::SIZE[1]], [u32::MAX; 2]] {
            assert_eq!(picker.at(outside), Seen::Nothing);
        }
    }

    #[test]
    fn the_outline_surrounds_the_material() {
        let picker = Picker::new(&support::images(true).head);
        let [width, height] = support::SIZE.map(|n| n as i64);
        let shows = |x: i64, y: i64| x >= 0 && y >= 0 && picker.at([x as u32, y as u32]) == Seen::Material("a");
        for distance in [0, 1, 3] {
            let outline = picker.outline("a", distance as usize);
            for (index, on_line) in outline.iter().enumerate() {
                let (x, y) = (index as i64 % width, index as i64 / width);
                let near = (-distance..=distance).any(|dy| (-distance..=distance).any(|dx| shows(x + dx, y + dy)));
                assert_eq!(*on_line, near && !shows(x, y), "{x} {y} {distance}");
            }
            assert_eq!(outline.len() as i64, width * height);
        }
        assert!(!picker.outline("no such material", 2).contains(&true));
    }
}
