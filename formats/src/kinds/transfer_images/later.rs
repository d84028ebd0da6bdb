//! Light after three reflections or more, as a function of one albedo for each editable material and channel.
//!
//! The surface that the eye sees keeps its bases, and fixed surfaces reflect as they are. At every reflection
//! before, an editable material counts as a Lambert surface of its effective albedo α: what it reflects of
//! light from everywhere, by its coefficients a sum of that of the basis functions. Light L(α) that such
//! surfaces send back and forth is then a quotient of polynomials, as the radiosity equation is solved by
//! Cramer's rule: with Mᵢⱼ the share of what leaves material i that meets material j next, be it by way of
//! fixed surfaces,
//!
//! > L(α) ≈ p(α) / D(α), D(α) = det(1 − M·diag(α)),
//!
//! where p is the polynomial of least total degree through what was traced at some nodes. With degree 2 that
//! is exact where all editable surfaces meet a material in the same share, as in a convex closed room evenly
//! lit, and what is left after three reflections is so everywhere.
//!
//! Nodes are the combinations of 0, [`MAX_ALBEDO`] and half of it whose numbers (0, 1, 2) add up to at most
//! [`Later::degree`]: 1 + E or (E + 1)(E + 2)/2 for E materials.
//!
//! The surface before the one that the eye sees may keep its first glossy functions, too: what function bⱼ of
//! its material sends on beyond its albedo aⱼ, with bⱼ − aⱼ/π for the BRDF there, has images at nodes of degree
//! 1, and counts by its coefficient.

use super::LaterImages;
use crate::container::MAX_SECTIONS;
use crate::state::Rgb;
use serde::{Deserialize, Serialize};

/// Largest effective albedo: a room of it sends twenty times the light about, and one of 1 never ends. What
/// reflects more counts as this, so that no light is made of nothing.
pub const MAX_ALBEDO: f32 = 0.95;
/// Largest degree of the numerator. Of degree 2 it has all that is left after three reflections exactly.
pub const MAX_DEGREE: u32 = 2;
/// The nodes of one material, in their order.
const NODES: [f64; MAX_DEGREE as usize + 1] = [0.0, MAX_ALBEDO as f64, 0.5 * MAX_ALBEDO as f64];
/// How far a row of [`Later::returns`] may be above 1 in all.
const RETURNS_TOLERANCE: f32 = 1e-4;
/// Total degree of what lobes of the surface before are times D: that surface counts once already.
const LOBE_DEGREE: u32 = 1;
/// Largest size of what a node counts, and a node times the coefficient of a lobe: that of a coefficient, for
/// which [`super::MAX_SCALE`] is made. Rooms that hold so much light in so many materials are no rooms of a
/// scene.
const MAX_WEIGHT: f32 = 2e4;
/// Most slots of a file, each of which is a section of it.
const MAX_SLOTS: usize = MAX_SECTIONS - super::HEAD_SECTIONS;
/// Largest size of a basis function's albedo.
const MAX_BASIS_ALBEDO: f32 = 1e30;

/// What light after three reflections or more needs besides its images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Later {
    /// Total degree of the numerator, 1 or 2.
    pub degree: u32,
    /// Bases at the surface that the eye sees, the first ones, from 1 to all.
    pub eye_bases: u32,
    /// Glossy functions of the surface before that are kept, the first ones; 0 for none.
    pub lobes: u32,
    /// Bases at the surface that the eye sees for each of these; 0 for none.
    pub lobe_eye_bases: u32,
    /// What each basis function reflects of light from everywhere, its hemispherical-hemispherical
    /// reflectance: ∫∫ bₖ cos θᵢ cos θₒ dωᵢ dωₒ / π.
    pub albedos: Vec<f32>,
    /// Mean colour of each editable material's texture where light meets it; 1 without one.
    pub textures: Vec<Rgb>,
    /// M, row-major [3 channels, materials, materials].
    pub returns: Vec<f32>,
}

/// The nodes for `materials` materials, each the numbers of the materials' [`NODES`], the last material's
/// changing fastest.
fn nodes(materials: usize, degree: u32) -> Vec<Vec<u8>> {
    let mut all = vec![Vec::new()];
    for _ in 0..materials {
        let longer = |node: &Vec<u8>| {
            let left = degree as u8 - node.iter().sum::<u8>();
            let node = node.clone();
            (0..=left).map(move |last| [&node[..], &[last]].concat())
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// Number of nodes for `materials` materials.
pub fn node_count(materials: usize, degree: u32) -> usize {
    if degree < 2 { 1 + materials } else { (materials + 1) * (materials + 2) / 2 }
}

impl Later {
    /// How many images it has.
    pub fn images(&self) -> LaterImages {
        let materials = self.textures.len();
        LaterImages {
            nodes: node_count(materials, self.degree),
            eye_bases: self.eye_bases as usize,
            lobes: self.lobes as usize,
            lobe_nodes: if self.lobes > 0 { node_count(materials, LOBE_DEGREE) } else { 0 },
            lobe_eye_bases: self.lobe_eye_bases as usize,
        }
    }

    /// Which of all nodes are those of lobes.
    pub fn lobe_nodes(&self) -> Vec<usize> {
        let all = nodes(self.textures.len(), self.degree);
        let is_one =
            |(_, node): &(usize, Vec<u8>)| node.iter().map(|n| u32::from(*n)).sum::<u32>() <= LOBE_DEGREE;
        all.into_iter().enumerate().filter(is_one).map(|(number, _)| number).collect()
    }

    /// The albedo of every editable material at every node, [nodes, materials].
    pub fn node_albedos(&self) -> Vec<Vec<f32>> {
        let value = |number: &u8| NODES[usize::from(*number)] as f32;
        let nodes = nodes(self.textures.len(), self.degree);
        nodes.iter().map(|node| node.iter().map(value).collect()).collect()
    }

    /// The effective albedo, 0 to [`MAX_ALBEDO`], of every editable material by its coefficients
    /// ([`crate::kinds::BrdfBasis::coefficients_of`]).
    pub fn albedos_of(&self, on_bases: &[Vec<Rgb>]) -> Vec<Rgb> {
        let of_material = |(coefficients, texture): (&Vec<Rgb>, &Rgb)| {
            let mut terms = coefficients.iter().zip(&self.albedos).map(|(c, albedo)| c.map(|c| c * albedo));
            // The texture acts on the diffuse basis only.
            let diffuse = terms.next().unwrap_or_default();
            let diffuse = std::array::from_fn(|k| diffuse[k] * texture[k]);
            let sum = terms.fold(diffuse, |sum: Rgb, term| std::array::from_fn(|k| sum[k] + term[k]));
            sum.map(|albedo| albedo.clamp(0.0, MAX_ALBEDO))
        };
        on_bases.iter().zip(&self.textures).map(of_material).collect()
    }

    /// What the image of every node counts for materials of these `albedos`, by channel.
    pub fn weights(&self, albedos: &[Rgb]) -> Vec<Rgb> {
        self.weights_of(self.degree, albedos)
    }

    /// What the image of every node of lobes counts, times their coefficients ([`Later::of_lobe`]).
    pub fn lobe_weights(&self, albedos: &[Rgb]) -> Vec<Rgb> {
        self.weights_of(LOBE_DEGREE, albedos)
    }

    /// What the image of a lobe counts, by its coefficient and the node's weight.
    pub fn of_lobe(coefficient: Rgb, weight: Rgb) -> Rgb {
        std::array::from_fn(|k| (coefficient[k] * weight[k]).clamp(-MAX_WEIGHT, MAX_WEIGHT))
    }

    fn weights_of(&self, degree: u32, albedos: &[Rgb]) -> Vec<Rgb> {
        let nodes = nodes(albedos.len(), degree);
        let mut weights = vec![[0.0; 3]; nodes.len()];
        for channel in 0..3 {
            let at: Vec<f64> = albedos.iter().map(|albedo| f64::from(albedo[channel])).collect();
            let here = self.denominator(channel, &at);
            for (weight, node) in weights.iter_mut().zip(&nodes) {
                let there: Vec<f64> = node.iter().map(|number| NODES[usize::from(*number)]).collect();
                let share = self.denominator(channel, &there) / here;
                let counts = polynomial_weight(node, &nodes, &at) * share;
                let most = f64::from(MAX_WEIGHT);
                weight[channel] = counts.clamp(-most, most) as f32;
            }
        }
        weights
    }

    /// D(α) of a channel. It is above 0, for rows of M·diag(α) add up to less than 1.
    fn denominator(&self, channel: usize, albedos: &[f64]) -> f64 {
        let count = self.textures.len();
        let returns = self.returns.get(channel * count * count..).unwrap_or_default();
        // Materials that reflect nothing have a column of the unit matrix and leave the determinant as it is.
        let there: Vec<usize> = (0..count).filter(|material| albedos[*material] != 0.0).collect();
        let entry = |i: usize, j: usize| {
            let share = returns.get(i * count + j).copied().unwrap_or_default();
            f64::from(u8::from(i == j)) - f64::from(share) * albedos[j]
        };
        determinant(there.iter().map(|i| there.iter().map(|j| entry(*i, *j)).collect()).collect())
    }

    /// Slots of a file of so many materials and bases, at most 64 and 32.
    fn slots(&self, materials: usize, bases: usize) -> usize {
        let Self { degree, eye_bases, lobes, lobe_eye_bases, .. } = self;
        let of_lobes =
            materials * *lobes as usize * node_count(materials, LOBE_DEGREE) * *lobe_eye_bases as usize;
        bases * (2 + materials * bases) + node_count(materials, *degree) * *eye_bases as usize + of_lobes
    }

    /// What is wrong with it in a file of so many materials and bases.
    pub(super) fn fault(&self, materials: usize, bases: usize) -> Option<String> {
        let Self { degree, eye_bases, lobes, lobe_eye_bases, albedos, textures, returns } = self;
        if !(1..=MAX_DEGREE).contains(degree) || !(1..=bases).contains(&(*eye_bases as usize)) {
            return Some(format!(
                "later reflections of degree {degree} on {eye_bases} bases are out of range"
            ));
        }
        if *lobes as usize >= bases || lobe_eye_bases > eye_bases || (*lobes == 0) != (*lobe_eye_bases == 0) {
            return Some(format!(
                "later reflections on {lobes} lobes and {lobe_eye_bases} of {eye_bases} bases are out of range"
            ));
        }
        if self.slots(materials, bases) > MAX_SLOTS {
            return Some(format!("later reflections have more images than the {MAX_SLOTS} of a file"));
        }
        if albedos.len() != bases || textures.len() != materials || returns.len() != 3 * materials.pow(2) {
            return Some("later reflections are of other bases or materials".to_owned());
        }
        if !albedos.iter().all(|albedo| albedo.abs() <= MAX_BASIS_ALBEDO) {
            return Some("the albedo of a basis function is out of range".to_owned());
        }
        if !textures.as_flattened().iter().all(|share| (0.0..=1.0).contains(share)) {
            return Some("the mean of a texture is outside 0..1".to_owned());
        }
        let is_share = |row: &[f32]| {
            row.iter().all(|share| *share >= 0.0) && row.iter().sum::<f32>() <= 1.0 + RETURNS_TOLERANCE
        };
        (!returns.chunks_exact(materials.max(1)).all(is_share))
            .then(|| "more light returns to materials than left them".to_owned())
    }
}

/// What the value at `node` counts in the polynomial through all `nodes`, taken at `at`: Newton's
/// interpolation, whose divided differences are products over the materials.
fn polynomial_weight(node: &[u8], nodes: &[Vec<u8>], at: &[f64]) -> f64 {
    let factor = |above: u8, here: u8, x: f64| {
        let others = (0..=above).filter(|other| *other != here).map(usize::from);
        let difference: f64 = others.map(|m| NODES[usize::from(here)] - NODES[m]).product();
        let newton: f64 = NODES[..usize::from(above)].iter().map(|m| x - m).product();
        newton / difference
    };
    let is_above = |other: &&Vec<u8>| node.iter().zip(*other).all(|(here, above)| here <= above);
    let term = |above: &Vec<u8>| -> f64 {
        above.iter().zip(node).zip(at).map(|((above, here), x)| factor(*above, *here, *x)).product()
    };
    nodes.iter().filter(is_above).map(term).sum()
}

/// By Gauss's elimination with the largest pivot of each column.
fn determinant(mut rows: Vec<Vec<f64>>) -> f64 {
    let mut product = 1.0;
    for column in 0..rows.len() {
        let largest =
            (column..rows.len()).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()));
        let Some(pivot) = largest.filter(|row| rows[*row][column] != 0.0) else { return 0.0 };
        if pivot != column {
            rows.swap(pivot, column);
            product = -product;
        }
        let (above, below) = rows.split_at_mut(column + 1);
        let first = &above[column];
        product *= first[column];
        for row in below {
            let factor = row[column] / first[column];
            row.iter_mut().zip(first).skip(column).for_each(|(value, above)| *value -= factor * above);
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of materials without texture that send each other these shares in every channel, on one basis of
    /// albedo 1.
    fn later(degree: u32, returns: &[f32]) -> Later {
        let materials = returns.len().isqrt();
        Later {
            degree,
            eye_bases: 1,
            lobes: 1,
            lobe_eye_bases: 1,
            albedos: vec![1.0; 2],
            textures: vec![[1.0; 3]; materials],
            returns: returns.repeat(3),
        }
    }

    /// What the interpolation makes of a function of the albedos.
    fn interpolated(later: &Later, at: &[f32], function: impl Fn(&[f64]) -> f64) -> f64 {
        let albedos: Vec<Rgb> = at.iter().map(|albedo| [*albedo; 3]).collect();
        let nodes = later.node_albedos();
        assert_eq!(nodes.len(), node_count(at.len(), later.degree));
        let value = |node: &Vec<f32>| function(&node.iter().copied().map(f64::from).collect::<Vec<_>>());
        later.weights(&albedos).iter().zip(&nodes).map(|(w, node)| f64::from(w[1]) * value(node)).sum()
    }

    /// Without returns: every polynomial of the degree, and at the nodes anything.
    #[test]
    fn polynomials_of_the_degree_are_met() {
        let at = [0.31, 0.9, 0.05];
        let linear = |x: &[f64]| 0.3 + x[0] - 2.0 * x[1] + 0.7 * x[2];
        let square = |x: &[f64]| linear(x) + x[0] * x[1] - 3.0 * x[2] * x[2] + 0.2 * x[1] * x[2];
        let expected = at.map(f64::from);
        assert!((interpolated(&later(1, &[0.0; 9]), &at, linear) - linear(&expected)).abs() < 1e-6);
        assert!((interpolated(&later(2, &[0.0; 9]), &at, square) - square(&expected)).abs() < 1e-5);
        assert!((interpolated(&later(1, &[0.0; 9]), &at, square) - square(&expected)).abs() > 0.1);
        for degree in [1, 2] {
            let later = later(degree, &[0.3, 0.2, 0.1, 0.0, 0.5, 0.4, 0.9, 0.0, 0.1]);
            for (index, node) in later.node_albedos().iter().enumerate() {
                let albedos: Vec<Rgb> = node.iter().map(|albedo| [*albedo; 3]).collect();
                for (other, weight) in later.weights(&albedos).iter().enumerate() {
                    assert!((weight[0] - f32::from(u8::from(index == other))).abs() < 1e-6, "{weight:?}");
                }
            }
        }
    }

    /// Light that two materials send back and forth, summed reflection by reflection: exact where both meet
    /// either in the same share, up to a room that keeps all light but what its walls swallow. Elsewhere the
    /// numerator lacks a term of third degree, of the size of the determinant of the shares: with those of
    /// the demo, a fiftieth, where they are more even among themselves than with one another.
    #[test]
    fn rooms_of_even_light_are_met_whatever_their_albedos() {
        let sum = |m: [[f64; 2]; 2], x: &[f64]| {
            // What leaves each material after one reflection, and what the eye gets of each.
            let (mut leaves, eye) = ([x[0], 0.5 * x[1]], [0.7, 0.2]);
            let mut seen = 0.0;
            for _ in 0..2000 {
                leaves = [0, 1].map(|j| x[j] * (leaves[0] * m[0][j] + leaves[1] * m[1][j]));
                seen += leaves[0] * eye[0] + leaves[1] * eye[1];
            }
            seen
        };
        let rooms = [
            ([[0.3f32, 0.2], [0.3, 0.2]], 1e-4),
            ([[0.25, 0.75]; 2], 1e-4),
            ([[0.26, 0.41], [0.19, 0.36]], 0.05),
        ];
        for (m, bound) in rooms {
            let shares = m.map(|row| row.map(f64::from));
            for at in [[0.2, 0.9], [0.95, 0.95], [0.6, 0.0], [0.47, 0.33]] {
                let truth = sum(shares, &at.map(f64::from));
                let found = interpolated(&later(2, m.as_flattened()), &at, |x| sum(shares, x));
                assert!((found - truth).abs() <= bound * truth, "{m:?} {at:?}: {found}, {truth}");
            }
        }
    }

    #[test]
    fn albedos_are_those_of_the_bases_and_never_above_the_largest() {
        let mut later = later(2, &[0.0]);
        (later.albedos, later.textures) = (vec![1.0, 0.5], vec![[0.5, 1.0, 0.0]]);
        let albedos = later.albedos_of(&[vec![[0.2, 0.4, 0.8], [0.1, 0.2, -1.0]]]);
        assert!((albedos[0][0] - 0.15).abs() < 1e-6 && (albedos[0][1] - 0.5).abs() < 1e-6);
        assert_eq!(albedos[0][2], 0.0);
        assert_eq!(later.albedos_of(&[vec![[9.0; 3], [0.0; 3]]])[0], [MAX_ALBEDO, MAX_ALBEDO, 0.0]);
    }

    #[test]
    fn bases_and_degrees_that_are_not_there_are_faults() {
        let sound = later(2, &[0.5]);
        assert_eq!(sound.fault(1, 2), None);
        for (degree, eye_bases) in [(0, 1), (3, 1), (2, 0), (2, 3)] {
            assert!(
                Later { degree, eye_bases, ..sound.clone() }.fault(1, 2).is_some(),
                "{degree} {eye_bases}"
            );
        }
        for (lobes, lobe_eye_bases) in [(0, 1), (1, 0), (2, 1), (1, 2), (u32::MAX, 1)] {
            let later = Later { lobes, lobe_eye_bases, ..sound.clone() };
            assert!(later.fault(1, 2).is_some(), "{lobes} {lobe_eye_bases}");
        }
        assert_eq!(Later { lobes: 0, lobe_eye_bases: 0, ..sound.clone() }.fault(1, 2), None);
        // As many as a file may have of materials and bases, and more images than it may have sections.
        let all = Later {
            albedos: vec![0.0; 32],
            eye_bases: 32,
            lobes: 31,
            lobe_eye_bases: 32,
            ..later(2, &[0.0; 4096])
        };
        assert!(all.fault(64, 32).is_some_and(|fault| fault.contains("more images")));
        let some = Later { eye_bases: 1, lobes: 2, lobe_eye_bases: 1, ..all };
        assert_eq!(some.slots(8, 6), 6 * 50 + 45 + 8 * 2 * 9);
    }

    /// The nodes of lobes are some of all; a quotient of degree 1 is met by them whatever the albedos.
    #[test]
    fn lobes_have_nodes_of_degree_1() {
        let mut later = later(2, &[0.3, 0.2, 0.1, 0.0, 0.5, 0.4, 0.9, 0.0, 0.1]);
        let (all, some) = (later.node_albedos(), later.lobe_nodes());
        assert_eq!(some.len(), later.images().lobe_nodes);
        later.degree = 1;
        let ones = later.node_albedos();
        assert_eq!(some.iter().map(|node| all[*node].clone()).collect::<Vec<_>>(), ones);
        let at = [[0.31f32; 3], [0.9; 3], [0.05; 3]];
        let numerator = |x: &[f64]| 0.3 + x[0] - 2.0 * x[1] + 0.7 * x[2];
        let quotient = |x: &[f64]| numerator(x) / later.denominator(1, x);
        let wide = |x: &[f32]| x.iter().copied().map(f64::from).collect::<Vec<_>>();
        let found: f64 = later
            .lobe_weights(&at)
            .iter()
            .zip(&ones)
            .map(|(weight, node)| f64::from(weight[1]) * quotient(&wide(node)))
            .sum();
        assert!((found - quotient(&wide(&at.map(|a| a[1])))).abs() < 1e-5, "{found}");
        assert_eq!(Later::of_lobe([2.0, -1e9, 0.0], [0.5, 1e9, 1.0]), [1.0, -MAX_WEIGHT, 0.0]);
    }

    #[test]
    fn determinants_are_those_of_permutations_and_triangles() {
        assert_eq!(determinant(vec![vec![0.0, 1.0], vec![1.0, 0.0]]), -1.0);
        assert_eq!(determinant(vec![vec![2.0, 5.0, 1.0], vec![0.0, 3.0, 4.0], vec![0.0, 0.0, 0.5]]), 3.0);
        assert_eq!(determinant(vec![vec![1.0, 2.0], vec![2.0, 4.0]]), 0.0);
        assert_eq!(determinant(Vec::new()), 1.0);
    }
}
