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
//!
//! Bakes of all reflections have one more RGB image for each node of [`super::Later`] and each of the eye's
//! bases that it keeps; and for each of its lobes' nodes, for each function of each editable material, and each
//! of the eye's bases that these keep.

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
    /// Anywhere, and at least once more before: light after three reflections and more, at a node of
    /// [`super::Later`].
    Later {
        /// Index of the node.
        node: usize,
    },
    /// On an editable material, and at least once more before: what one of its glossy functions sends on that
    /// its albedo does not, at a node of the lobes of [`super::Later`].
    LaterLobe {
        /// Index of the material.
        material: usize,
        /// Index of the basis, from 1.
        basis: usize,
        /// Index of the node.
        node: usize,
    },
}

impl FirstReflection {
    /// Whether light was reflected more than twice.
    pub fn is_later(self) -> bool {
        matches!(self, Self::Later { .. } | Self::LaterLobe { .. })
    }
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
        let is_glossy = matches!(
            self.first,
            FirstReflection::Editable { basis: 1.., .. } | FirstReflection::LaterLobe { .. }
        );
        self.eye_basis == 0 && !is_glossy
    }
}

/// How many images light after three reflections and more has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LaterImages {
    /// Nodes of [`super::Later`].
    pub nodes: usize,
    /// The eye's bases that have an image at each node: the first ones, at least one.
    pub eye_bases: usize,
    /// Glossy functions of each editable material before that have images of their own: the first ones.
    pub lobes: usize,
    /// Nodes of these.
    pub lobe_nodes: usize,
    /// The eye's bases that have an image at each of them: the first ones.
    pub lobe_eye_bases: usize,
}

impl LaterImages {
    /// Images of editable fragments, in scenes of so many editable materials.
    pub fn count(&self, materials: usize) -> usize {
        self.nodes * self.eye_bases + materials * self.lobes * self.lobe_nodes * self.lobe_eye_bases
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
    /// Those of later reflections; none in bakes of one or two.
    later: LaterImages,
}

impl Layout {
    /// The layout for `materials` editable materials and `bases` bases; `one_colour` if all light has one
    /// chromaticity. With `later` it has images of all reflections.
    pub fn new(materials: usize, bases: usize, one_colour: bool, later: Option<LaterImages>) -> Self {
        use FirstReflection::{Editable, Fixed, Later, LaterLobe, None};
        let later = later.unwrap_or_default();
        let editable = |material| move |basis| Editable { material, basis };
        let lobe = |material| {
            let of = move |basis| move |node| LaterLobe { material, basis, node };
            (1..=later.lobes).flat_map(move |basis| (0..later.lobe_nodes).map(of(basis)))
        };
        let firsts: Vec<_> = [None, Fixed]
            .into_iter()
            .chain((0..materials).flat_map(|m| (0..bases).map(editable(m))))
            .chain((0..later.nodes).map(|node| Later { node }))
            .chain((0..materials).flat_map(lobe))
            .collect();
        let kept = |first: FirstReflection| kept_bases(first, bases, &later);
        let grey = |eye_basis: usize, first: FirstReflection| {
            one_colour && eye_basis > 0 && matches!(first, None | Editable { basis: 1.., .. })
        };
        let mut slots: Vec<Slot> = (0..bases)
            .flat_map(|eye_basis| firsts.iter().map(move |&first| (eye_basis, first)))
            .filter(|(eye_basis, first)| *eye_basis < kept(*first))
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
        Self { slots, materials, bases, later }
    }

    /// Number of possible first reflections.
    pub fn firsts(&self) -> usize {
        let LaterImages { nodes, lobes, lobe_nodes, .. } = self.later;
        2 + self.materials * (self.bases + lobes * lobe_nodes) + nodes
    }

    /// The eye's bases that have an image of this first reflection: the first ones, so many.
    pub fn eye_bases(&self, first: FirstReflection) -> usize {
        kept_bases(first, self.bases, &self.later)
    }

    /// A dense number for a first reflection, below [`Layout::firsts`].
    pub fn first_index(&self, first: FirstReflection) -> usize {
        match first {
            FirstReflection::None => 0,
            FirstReflection::Fixed => 1,
            FirstReflection::Editable { material, basis } => 2 + material * self.bases + basis,
            FirstReflection::Later { node } => 2 + self.materials * self.bases + node,
            FirstReflection::LaterLobe { material, basis, node } => {
                let LaterImages { nodes, lobes, lobe_nodes, .. } = self.later;
                let lobe = material * lobes + basis - 1;
                2 + self.materials * self.bases + nodes + lobe * lobe_nodes + node
            }
        }
    }

    /// Channels of all slots together.
    pub fn channels(&self) -> usize {
        self.slots.iter().map(Slot::channels).sum()
    }
}

/// Of `bases` the first ones at the eye that have an image of `first`.
fn kept_bases(first: FirstReflection, bases: usize, later: &LaterImages) -> usize {
    match first {
        FirstReflection::Later { .. } => later.eye_bases,
        FirstReflection::LaterLobe { .. } => later.lobe_eye_bases,
        _ => bases,
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
        assert_eq!(counts(&Layout::new(2, 6, true, None)), (29, 55, 14));
        assert_eq!(counts(&Layout::new(2, 6, false, None)), (84, 0, 14));
        for (e, g) in [(1, 1), (1, 5), (3, 8), (4, 2)] {
            assert_eq!(
                counts(&Layout::new(e, g + 1, true, None)),
                (2 + e + 2 * e * g + g, g + e * g * g, 2 + e + e * g)
            );
        }
    }

    #[test]
    fn later_reflections_add_rgb_images_for_each_node_and_basis() {
        let without = Layout::new(2, 6, true, None);
        for (eye_bases, lobes, lobe_eye_bases) in [(1, 0, 0), (4, 0, 0), (6, 1, 1), (4, 2, 2)] {
            let later = LaterImages { nodes: 6, eye_bases, lobes, lobe_nodes: 3, lobe_eye_bases };
            let with = Layout::new(2, 6, true, Some(later));
            let images = 6 * eye_bases + 2 * lobes * 3 * lobe_eye_bases;
            assert_eq!(later.count(2), images);
            assert_eq!(with.channels(), without.channels() + 3 * images);
            assert_eq!(counts(&with), (29 + images, 55, 14 + 6 + 2 * lobes * 3));
            let is_later = |slot: &&Slot| slot.first.is_later();
            assert_eq!(with.slots.iter().filter(is_later).count(), images);
            assert!(with.slots.iter().all(|s| s.eye_basis < with.eye_bases(s.first)));
            assert!(with.slots.iter().filter(is_later).all(|s| s.rgb));
            let indices: std::collections::BTreeSet<_> =
                with.slots.iter().map(|s| with.first_index(s.first)).collect();
            assert_eq!(indices, (0..with.firsts()).collect());
            let others: Vec<_> =
                with.slots.iter().filter(|s| !is_later(s)).map(|s| (s.eye_basis, s.first)).collect();
            assert_eq!(others, without.slots.iter().map(|s| (s.eye_basis, s.first)).collect::<Vec<_>>());
            assert!(with.slots.iter().all(|s| s.fixed.is_none_or(|f| s.eye_basis == 0 && f == s.first)));
        }
    }

    #[test]
    fn every_path_has_exactly_one_slot_and_fixed_ones_are_rgb() {
        let layout = Layout::new(3, 4, true, None);
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
