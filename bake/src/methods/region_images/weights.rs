//! How much each region of a painted material counts in each component that is baked of it: the principal components
//! of what regions send to the eye (thesis §4.2.2).
//!
//! A group is a basis of the eye, a painted material and a basis there. What its regions send on is A, [regions, all
//! that is seen]; what they make of light in a state is cᵀA, c their coefficients. Baked is B = VᵀK^½·A, and played
//! αᵀB with α = VᵀK^−½·c: with K = E[c·cᵀ] over states, and V the first eigenvectors of K^½·A·Aᵀ·K^½, no other B of
//! as many rows is off by less in the mean over all states (Eckart and Young 1936), and every α has a mean square of 1.
//! The thesis takes the components of A as it is, as if coefficients of regions had nothing to do with each other: but
//! regions side by side are alike in most textures, and what many of them send on together shows most ([`super::covariance`]).

use relume_formats::kinds::region_images::{REGION_COUNT, Source};
use relume_formats::state::Rgb;

/// One group.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Group {
    /// Basis of the eye.
    pub eye: u16,
    /// Class of the painted material.
    pub material: u16,
    /// Basis that it wears.
    pub basis: u16,
    /// Row-major [regions, rank]: what light that a region sends on adds to each component.
    pub baked: Vec<f32>,
    /// Row-major [rank, regions]: what the coefficient of a region adds to the factor of each.
    pub played: Vec<f32>,
}

impl Group {
    /// Number of components.
    pub fn rank(&self) -> usize {
        self.baked.len() / REGION_COUNT
    }

    /// What light that a region sends on adds to each component.
    pub fn of_region(&self, region: usize) -> &[f32] {
        let rank = self.rank();
        &self.baked[region * rank..][..rank]
    }

    /// What the components make of coefficients of the regions, region by region.
    pub fn seen_through(&self, coefficient: impl Fn(usize) -> Rgb) -> Vec<Rgb> {
        let factor = |weights: &[f32]| {
            let terms =
                weights.iter().enumerate().map(|(region, weight)| coefficient(region).map(|c| c * weight));
            terms.fold([0.0; 3], |sum: Rgb, term| std::array::from_fn(|k| sum[k] + term[k]))
        };
        let factors: Vec<Rgb> = self.played.chunks_exact(REGION_COUNT).map(factor).collect();
        let seen = |region: usize| {
            let terms = self.of_region(region).iter().zip(&factors);
            terms.fold([0.0; 3], |sum: Rgb, (b, factor)| std::array::from_fn(|k| sum[k] + b * factor[k]))
        };
        (0..REGION_COUNT).map(seen).collect()
    }
}

/// All groups, by basis of the eye, material and basis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Weights {
    /// In their order.
    pub groups: Vec<Group>,
    /// Mean square of what a pixel shows over random states, a channel.
    pub energy: f64,
    /// Mean squares of the coefficients of materials, by basis.
    pub squares: Vec<f64>,
}

impl Weights {
    /// The group of a painted source, if it has one.
    pub fn group(&self, eye: usize, source: Source) -> Option<usize> {
        let Source::Painted { material, basis } = source else { return None };
        let key = (eye as u16, material, basis);
        self.groups.binary_search_by_key(&key, |group| (group.eye, group.material, group.basis)).ok()
    }

    /// As bytes for the log.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend((self.squares.len() as u32).to_le_bytes());
        std::iter::once(&self.energy).chain(&self.squares).for_each(|x| bytes.extend(x.to_le_bytes()));
        for group in &self.groups {
            let Group { eye, material, basis, .. } = *group;
            [eye, material, basis, group.rank() as u16].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            group.baked.iter().chain(&group.played).for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        bytes
    }

    /// The inverse of [`Weights::encode`], on bytes whose checksum was right.
    pub fn decode(bytes: &[u8]) -> Self {
        let mut rest = Reader(bytes);
        let count = u32::from_le_bytes(rest.next()) as usize;
        let energy = f64::from_le_bytes(rest.next());
        let squares = (0..count).map(|_| f64::from_le_bytes(rest.next())).collect();
        let mut groups = Vec::new();
        while !rest.0.is_empty() {
            let [eye, material, basis, rank] = std::array::from_fn(|_| u16::from_le_bytes(rest.next()));
            let mut floats =
                || (0..usize::from(rank) * REGION_COUNT).map(|_| f32::from_le_bytes(rest.next())).collect();
            let (baked, played) = (floats(), floats());
            groups.push(Group { eye, material, basis, baked, played });
        }
        Self { groups, energy, squares }
    }
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn next<const N: usize>(&mut self) -> [u8; N] {
        match self.0.split_first_chunk() {
            Some((next, rest)) => {
                self.0 = rest;
                *next
            }
            None => [0; N],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_come_back() {
        let group = |eye, rank: usize| {
            let some = |k: f32| (0..rank * REGION_COUNT).map(|i| i as f32 * 0.25 - k).collect::<Vec<_>>();
            Group { eye, material: 1, basis: 2, baked: some(3.0), played: some(7.0) }
        };
        let weights =
            Weights { groups: vec![group(0, 2), group(1, 0)], energy: 0.75, squares: vec![1.0, 0.2] };
        assert_eq!(Weights::decode(&weights.encode()), weights);
        assert_eq!(weights.group(1, Source::Painted { material: 1, basis: 2 }), Some(1));
        assert_eq!(weights.group(1, Source::Whole { material: 1, basis: 2 }), None);
    }
}
