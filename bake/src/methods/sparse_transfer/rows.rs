//! Selected rows of the transfer matrix on their way from gather to packing.

use crate::trace::held_out_lights::{Exact, HeldOutLights, exact_radiances};
use relume_formats::basis::{approximate, haar};

/// Most terms that a row keeps until it is known how many are needed.
pub const MAX_TERMS: usize = 1024;

/// Rows and what they are to give. All have the same number of terms; those that a row lacks have value 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// Terms of a row.
    pub terms: usize,
    /// 1, or 3 for RGB.
    pub channels: usize,
    /// Row-major [rows, terms], most important first.
    pub indices: Vec<u16>,
    /// Row-major [rows, terms, channels].
    pub values: Vec<f32>,
    /// Radiance from the whole rows.
    pub exact: Vec<Exact>,
}

impl Rows {
    /// No rows yet.
    pub fn new(terms: usize, channels: usize) -> Self {
        Self { terms, channels, ..Self::default() }
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.exact.len()
    }

    /// Adds the most important terms of a row, given as one plane of Haar coefficients per channel, and its
    /// exact radiances. `weights` is what sizes of coefficients are multiplied by to tell how important they
    /// are.
    pub fn push(&mut self, planes: &[Vec<f32>], weights: &[f32], exact: Exact) {
        let size = |i: usize| planes.iter().map(|plane| plane[i] * plane[i]).sum::<f32>().sqrt();
        let sizes: Vec<f32> = (0..weights.len()).map(size).collect();
        let kept = approximate::largest(&sizes, self.terms, |index| weights[index]);
        for term in 0..self.terms {
            let index = kept.get(term).map(|(index, _)| *index as usize);
            self.indices.push(index.unwrap_or(0) as u16);
            self.values.extend(planes.iter().map(|plane| index.map_or(0.0, |i| plane[i])));
        }
        self.exact.push(exact);
    }

    /// Adds a row given by texels of a light of faces `face_size` wide, one plane per channel; see
    /// [`Rows::push`].
    pub fn push_texels(
        &mut self,
        mut planes: Vec<Vec<f32>>,
        weights: &[f32],
        lights: &HeldOutLights,
        face_size: usize,
    ) {
        let exact = exact_radiances(&planes, lights);
        planes.iter_mut().for_each(|plane| haar::forward_cube(plane, face_size));
        self.push(&planes, weights, exact);
    }

    /// Adds the rows of `other`, which have as many terms and channels.
    pub fn append(&mut self, mut other: Self) {
        self.indices.append(&mut other.indices);
        self.values.append(&mut other.values);
        self.exact.append(&mut other.exact);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_what_weighs_most() {
        let planes = vec![vec![1.0, -4.0, 0.0, 2.0], vec![0.0, 0.0, 0.0, 2.0]];
        let given = std::array::from_fn(|i| i as f32);
        let exact = Exact { given, seen: given.map(|radiance| radiance + 1.0) };
        let mut rows = Rows::new(2, 2);
        rows.push(&planes, &[1.0; 4], exact);
        rows.push(&planes, &[9.0, 1.0, 1.0, 1.0], exact);
        assert_eq!(
            (&rows.indices[..], &rows.values[..]),
            (&[1, 3, 0, 1][..], &[-4.0, 0.0, 2.0, 2.0, 1.0, 0.0, -4.0, 0.0][..])
        );
        let mut many = Rows::new(4, 2);
        many.push(&planes, &[1.0; 4], exact);
        assert_eq!(
            (many.indices[3], &many.values[6..]),
            (0, &[0.0, 0.0][..]),
            "coefficients that are 0 fill up"
        );
        let mut both = rows.clone();
        both.append(rows.clone());
        assert_eq!((both.count(), both.exact[0], &both.indices[4..]), (4, exact, &rows.indices[..]));
    }
}
