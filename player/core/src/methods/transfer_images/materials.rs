//! The material of every pixel: of the editable ones that which covers most of it.

use crate::materials::MaterialMap;
use half::f16;
use relume_formats::kinds::transfer_images::Head;

impl From<&Head> for MaterialMap {
    fn from(head: &Head) -> Self {
        let fixed = head.meta.materials.len() as u16;
        let mut map = Self::new(head.meta.size, head.meta.materials.clone());
        // By pixel: class and coverage of the fragment that counts so far.
        let mut best: Vec<Option<(u16, f16)>> =
            vec![None; head.meta.size[0] as usize * head.meta.size[1] as usize];
        for ((pixel, class), coverage) in head.pixel.iter().zip(&head.class).zip(&head.coverage) {
            let Some(best) = best.get_mut(*pixel as usize) else { continue };
            let is_first_choice = best
                .is_none_or(|(before, covered)| *class != fixed && (before >= fixed || *coverage > covered));
            if is_first_choice {
                *best = Some((*class, *coverage));
                map.set(*pixel as usize, *class);
            }
        }
        map
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seen;
    use crate::support;

    #[test]
    fn the_editable_material_that_covers_most_is_seen() {
        let mut head = (*support::images(true).head).clone();
        // Uneven coverages, else every choice is as good as another.
        for (index, coverage) in head.coverage.iter_mut().enumerate() {
            *coverage = f16::from_f32(0.05 + (index * 37 % 100) as f32 / 110.0);
        }
        let map = MaterialMap::from(&head);
        let mut kinds = [0; 3];
        for (pixel, seen) in (0..support::PIXELS as u32).zip(map.pixels()) {
            let fragments = || (0..head.pixel.len()).filter(|i| head.pixel[*i] == pixel);
            let editable = fragments()
                .filter(|i| head.class[*i] < 2)
                .max_by(|i, j| head.coverage[*i].total_cmp(&head.coverage[*j]));
            let expected = match (editable, fragments().next()) {
                (Some(index), _) => Seen::Material(&head.meta.materials[usize::from(head.class[index])]),
                (None, Some(_)) => Seen::Fixed,
                (None, None) => Seen::Nothing,
            };
            assert_eq!(seen, expected, "{pixel}");
            assert_eq!(map.at([pixel % support::SIZE[0], pixel / support::SIZE[0]]), expected, "{pixel}");
            kinds[match expected {
                Seen::Material(_) => 0,
                Seen::Fixed => 1,
                Seen::Nothing => 2,
            }] += 1;
        }
        assert!(kinds.iter().all(|n| *n > 0), "{kinds:?}");
        for outside in [[support::SIZE[0], 0], [0, support::SIZE[1]], [u32::MAX; 2]] {
            assert_eq!(map.at(outside), Seen::Nothing);
        }
    }
}
