//! Which light path each stored image holds, and how images share storage (thesis table 4-1).
//!
//! Light reaches the eye from the surface seen through the pixel, directly from a light or by way of one
//! *first* reflection elsewhere. With E editable materials and G glossy bases (bases = 1 + G), editable
//! fragments need
//!
//! * 2 + E + 2EG + G images in RGB: those whose path meets a diffuse basis or a fixed surface, for these
//!   carry colour;
//! * G + EG² images in a single channel, for glossy bases are grey, if all light has one colour.
//!
//! Fixed fragments need 2 + E + EG images in RGB. As no fragment is both, these share the slots of the first
//! RGB images: 29 RGB and 55 single-channel slots for E = 2, G = 5.

/// Where light was reflected before it reached the surface that the eye sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstReflection {
    /// Nowhere: direct light. For fixed fragments this includes light sources and background seen directly.
    None,
    /// On a fixed surface.
    Fixed,
    /// On an editable material wearing one basis.
    Editable {
        /// Index of the material.
        material: usize,
        /// Index of the basis.
        basis: usize,
    },
}

/// What one stored image means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slot {
    /// For editable fragments: the basis worn by the surface seen by the eye.
    pub eye_basis: usize,
    /// For editable fragments: the reflection before.
    pub first: FirstReflection,
    /// For fixed fragments: the reflection before; `None` if the slot holds no fixed fragments.
    pub fixed: Option<FirstReflection>,
    /// Three channels, or one.
    pub rgb: bool,
}

impl Slot {
    /// 3 or 1.
    pub fn channels(&self) -> usize {
        if self.rgb { 3 } else { 1 }
    }

    /// Whether nothing but light times reflectance of at least 0 adds up in it: every basis on the way is the
    /// diffuse one, or a fixed surface reflects as it is. Other basis functions may be negative, and so may
    /// what they make of light.
    pub fn is_positive(&self) -> bool {
        self.eye_basis == 0 && !matches!(self.first, FirstReflection::Editable { basis: 1.., .. })
    }
}

/// All slots of a bake.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// RGB slots first, then single-channel ones.
    pub slots: Vec<Slot>,
    /// Number of editable materials.
    pub materials: usize,
    /// Number of bases.
    pub bases: usize,
}

impl Layout {
    /// The layout for `materials` editable materials and `bases` bases; `one_colour` if all light has one
    /// chromaticity.
    pub fn new(materials: usize, bases: usize, one_colour: bool) -> Self {
        use FirstReflection::{Editable, Fixed, None};
        let editable = |material| move |basis| Editable { material, basis };
        let firsts: Vec<_> = [None, Fixed]
            .into_iter()
            .chain((0..materials).flat_map(|m| (0..bases).map(editable(m))))
            .collect();
        let grey = |eye_basis: usize, first: FirstReflection| {
            one_colour && eye_basis > 0 && matches!(first, None | Editable { basis: 1.., .. })
        };
        let mut slots: Vec<Slot> = (0..bases)
            .flat_map(|eye_basis| firsts.iter().map(move |&first| (eye_basis, first)))
            .map(|(eye_basis, first)| Slot {
                eye_basis,
                first,
                fixed: Option::None,
                rgb: !grey(eye_basis, first),
            })
            .collect();
        slots.sort_by_key(|slot| !slot.rgb);
        for (slot, &first) in slots.iter_mut().zip(&firsts) {
            slot.fixed = Some(first);
        }
        Self { slots, materials, bases }
    }

    /// Number of possible first reflections.
    pub fn firsts(&self) -> usize {
        2 + self.materials * self.bases
    }

    /// A dense number for a first reflection, below [`Layout::firsts`].
    pub fn first_index(&self, first: FirstReflection) -> usize {
        match first {
            FirstReflection::None => 0,
            FirstReflection::Fixed => 1,
            FirstReflection::Editable { material, basis } => 2 + material * self.bases + basis,
        }
    }

    /// Channels of all slots together.
    pub fn channels(&self) -> usize {
        self.slots.iter().map(Slot::channels).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(layout: &Layout) -> (usize, usize, usize) {
        let rgb = layout.slots.iter().filter(|s| s.rgb).count();
        let fixed = layout.slots.iter().filter(|s| s.fixed.is_some()).count();
        (rgb, layout.slots.len() - rgb, fixed)
    }

    #[test]
    fn counts_are_those_of_the_thesis() {
        assert_eq!(counts(&Layout::new(2, 6, true)), (29, 55, 14));
        assert_eq!(counts(&Layout::new(2, 6, false)), (84, 0, 14));
        for (e, g) in [(1, 1), (1, 5), (3, 8), (4, 2)] {
            assert_eq!(
                counts(&Layout::new(e, g + 1, true)),
                (2 + e + 2 * e * g + g, g + e * g * g, 2 + e + e * g)
            );
        }
    }

    #[test]
    fn every_path_has_exactly_one_slot_and_fixed_ones_are_rgb() {
        let layout = Layout::new(3, 4, true);
        let mut seen = std::collections::BTreeSet::new();
        for slot in &layout.slots {
            assert!(seen.insert((slot.eye_basis, layout.first_index(slot.first))));
            assert!(slot.rgb || slot.fixed.is_none());
        }
        assert_eq!(seen.len(), layout.bases * layout.firsts());
        let fixed: Vec<_> =
            layout.slots.iter().filter_map(|s| s.fixed).map(|f| layout.first_index(f)).collect();
        assert_eq!(fixed, (0..layout.firsts()).collect::<Vec<_>>());
        // Fixed fragments share the slots of the same first reflection, so both are positive or neither.
        assert!(
            layout
                .slots
                .iter()
                .all(|slot| slot.fixed.is_none_or(|fixed| slot.eye_basis == 0 && fixed == slot.first))
        );
        assert_eq!(layout.slots.iter().filter(|slot| slot.is_positive()).count(), 2 + 3);
    }
}
