//! The diffuse lobe ρ̃ = max(0, n·ω)/π · dω of a normal n (sphere shadows §2, eq. 2) over the texels of a
//! cube of 32 × 32 a face, and the grid of normals between which lobes are blended (§4.1: 6 × 8 × 8).
//!
//! **Texels.** A texel's value is the integral of max(0, n·ω)/π over it, by Lambert's formula for the polygon
//! that the horizon leaves of it; so a white sky without blockers gives 1 to rounding, whatever the normal.
//!
//! **Grid.** Node (i, j) of `face` is the unit vector through the place s = −1 + 2i/7, t = −1 + 2j/7 of
//! [`super::cubemap`], i, j in 0..8, and has index face·64 + j·8 + i. The nodes on edges belong to both
//! faces, so blends go over edges without a jump. A normal n that meets the cube at p lies in a cell with
//! corners p_k; the bilinear weights w_k have Σ w_k p_k = p. With weights w_k·|p_k|/|p| on the lobes of the
//! unit nodes p_k/|p_k| the blend is exactly n·ω wherever all four lobes are positive. Where ω is below the
//! horizon of some node it is too large: 1.8 % of the lobe's norm in the mean over normals, 3.8 % at worst,
//! and at most 2 % of the light of a white sky.

use super::cubemap::{FACES, direction, place_of};
use super::haar::forward_cube;
use super::two_level::SIDE;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Nodes along a side of a face.
pub const GRID: usize = 8;
/// Nodes of the grid.
pub const NODES: usize = FACES * GRID * GRID;

/// Haar coefficients, [6·32·32], of the lobe of a unit normal.
pub fn lobe(normal: Vec3) -> Vec<f32> {
    let mut texels = texels(normal);
    forward_cube(&mut texels, SIDE);
    texels
}

/// The integral of max(0, n·ω)/π over each texel, [6·32·32].
fn texels(normal: Vec3) -> Vec<f32> {
    static TEXELS: LazyLock<Vec<Texel>> =
        LazyLock::new(|| (0..FACES * SIDE * SIDE).map(Texel::new).collect());
    let normal = normal.as_dvec3();
    TEXELS.iter().map(|texel| (texel.irradiance(normal) / PI) as f32).collect()
}

/// What of a texel is the same for all normals.
struct Texel {
    corners: [DVec3; 4],
    /// The irradiance from the whole texel is that vector times the normal.
    vector: DVec3,
}

impl Texel {
    fn new(i: usize) -> Self {
        let (face, x, y) = (i / (SIDE * SIDE), i % SIDE, i / SIDE % SIDE);
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
            .map(|(x, y)| direction(face, SIDE, x as f64, y as f64));
        Self { corners, vector: light_vector(&corners) }
    }

    /// ∫ max(0, n·ω) dω.
    fn irradiance(&self, normal: DVec3) -> f64 {
        match self.corners.iter().filter(|corner| corner.dot(normal) >= 0.0).count() {
            0 => 0.0,
            4 => self.vector.dot(normal).abs(),
            _ => light_vector(&above(&self.corners, normal)).dot(normal).abs(),
        }
    }
}

/// What of a convex polygon lies above the horizon.
fn above(corners: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let heights: Vec<f64> = corners.iter().map(|c| c.dot(normal)).collect();
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (k, (corner, height)) in corners.iter().zip(&heights).enumerate() {
        let next = (k + 1) % corners.len();
        if *height >= 0.0 {
            kept.push(*corner);
        }
        if height * heights[next] < 0.0 {
            kept.push((*corner * heights[next] - corners[next] * *height) / (heights[next] - height));
        }
    }
    kept
}

/// The vector whose product with n is ± ∫ n·ω dω over a polygon above the horizon, given by vectors to its
/// corners in either sense (Lambert 1760): half the sum over its edges of the angle that they span times the
/// normal of their plane.
fn light_vector(corners: &[DVec3]) -> DVec3 {
    let edge = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
        let cross = from.cross(to);
        cross.length().atan2(from.dot(to)) * cross.normalize_or_zero()
    };
    0.5 * (0..corners.len()).map(edge).sum::<DVec3>()
}

/// The unit normal of a node, `index` below [`NODES`].
pub fn grid_normal(index: usize) -> Vec3 {
    let last = GRID - 1;
    direction(index / (GRID * GRID), last, (index % GRID) as f64, (index / GRID % GRID) as f64).as_vec3()
}

/// The nodes about a normal of any length but 0, and their weights. The null vector gets those of a node.
pub fn blend(normal: Vec3) -> [(u32, f32); 4] {
    let (face, place) = place_of(normal);
    let [s, t] = place.map(|c| if c.is_finite() { c } else { 0.0 });
    let cell = |c: f32| {
        let at = (c + 1.0) * 0.5 * (GRID - 1) as f32;
        let first = (at as usize).min(GRID - 2);
        (first, at - first as f32)
    };
    let ((i, fs), (j, ft)) = (cell(s), cell(t));
    let node = |i: usize, j: usize, weight: f32| {
        let [x, y] = [i, j].map(|k| 2.0 * k as f32 / (GRID - 1) as f32 - 1.0);
        let longer = ((1.0 + x * x + y * y) / (1.0 + s * s + t * t)).sqrt();
        (((face * GRID + j) * GRID + i) as u32, weight * longer)
    };
    let (gs, gt) = (1.0 - fs, 1.0 - ft);
    [node(i, j, gs * gt), node(i + 1, j, fs * gt), node(i, j + 1, gs * ft), node(i + 1, j + 1, fs * ft)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::haar::inverse_cube;

    /// Reproducible unit vectors, evenly spread.
    fn normals(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |k| {
            let (z, phi) = (1.0 - 2.0 * (k as f32 + 0.5) / count as f32, 2.399_963_2 * k as f32);
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        })
    }

    fn blended(normal: Vec3, of: impl Fn(usize) -> Vec<f32>) -> Vec<f32> {
        let lobes = blend(normal).map(|(node, weight)| (of(node as usize), weight));
        (0..lobes[0].0.len()).map(|i| lobes.iter().map(|(lobe, weight)| lobe[i] * weight).sum()).collect()
    }

    #[test]
    fn a_white_sky_gives_one() {
        for normal in normals(50).chain([
            Vec3::X,
            Vec3::NEG_Y,
            Vec3::ONE.normalize(),
            Vec3::new(1.0, 1.0, 0.0).normalize(),
        ]) {
            let sum: f64 = texels(normal).iter().map(|x| f64::from(*x)).sum();
            // 6144 values of at most 1e-3 rounded once, and a normal whose length is off by a rounding.
            assert!((sum - 1.0).abs() < 3e-7, "{normal}: {sum}");
            let scaling: f64 = lobe(normal).iter().step_by(SIDE * SIDE).map(|c| f64::from(*c)).sum();
            assert!((scaling * SIDE as f64 - 1.0).abs() < 1e-6, "{normal}: {scaling}");
        }
    }

    #[test]
    fn texels_are_sums_over_many_points() {
        let points = 64;
        for normal in normals(3) {
            let values = texels(normal);
            for i in (0..values.len()).step_by(7) {
                let (face, x, y) = (i / 1024, i % 32, i / 32 % 32);
                let point = |k: usize| {
                    let place = |texel: usize, k: usize| texel as f64 + (k as f64 + 0.5) / points as f64;
                    let (x, y) = (place(x, k % points), place(y, k / points));
                    let [s, t] = [x, y].map(|c| c / 16.0 - 1.0);
                    let solid_angle = (1.0 + s * s + t * t).powf(-1.5) / (16.0 * points as f64).powi(2);
                    direction(face, SIDE, x, y).dot(normal.as_dvec3()).max(0.0) * solid_angle / PI
                };
                let sum: f64 = (0..points * points).map(point).sum();
                // The midpoint rule's error, of the second order in 1/64 of a texel, most at the horizon;
                // texels are up to 1.2e-3.
                assert!(
                    (sum - f64::from(values[i])).abs() < 2e-8,
                    "texel {i} about {normal}: {sum} {}",
                    values[i]
                );
            }
        }
    }

    #[test]
    fn nodes_are_their_own_blend_and_their_places_are_shared() {
        for node in 0..NODES {
            let normal = grid_normal(node);
            let found = blend(normal);
            // On an edge the same vector is a node of the other face too.
            let sum = found.iter().fold(Vec3::ZERO, |sum, (k, w)| sum + grid_normal(*k as usize) * *w);
            assert!(sum.distance(normal) < 1e-6);
            let (nearest, weight) = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            assert!(
                (weight - 1.0).abs() < 1e-5 && grid_normal(nearest as usize).distance(normal) < 1e-6,
                "{node} {found:?}"
            );
        }
        let finite =
            blend(Vec3::ZERO).iter().all(|(node, weight)| (*node as usize) < NODES && weight.is_finite());
        assert!(finite, "the null vector");
    }

    #[test]
    fn a_blend_is_the_lobe_where_all_its_lobes_are_positive() {
        for normal in normals(40) {
            let (exact, ours) = (texels(normal), blended(normal, |node| texels(grid_normal(node))));
            let nodes = blend(normal).map(|(node, _)| grid_normal(node as usize).as_dvec3());
            let mut compared = 0;
            for i in 0..exact.len() {
                let (face, x, y) = (i / 1024, i % 32, i / 32 % 32);
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)]
                    .map(|(dx, dy)| direction(face, SIDE, (x + dx) as f64, (y + dy) as f64));
                if nodes.iter().all(|node| corners.iter().all(|corner| corner.dot(*node) > 0.0)) {
                    compared += 1;
                    assert!((exact[i] - ours[i]).abs() < 1e-9, "{normal} {i}: {} {}", exact[i], ours[i]);
                }
                assert!(ours[i] > exact[i] - 1e-9, "nowhere too small");
            }
            assert!(compared > 2_000, "{compared}");
        }
    }

    /// Over 300 normals: 1.8 % of the lobe's norm in the mean, 3.8 % at worst; under a white sky 2 % too
    /// bright at worst, in the middle of a face's middle cell, whose corners are √(1 + 2/49) away where it is
    /// 1.
    #[test]
    fn blends_are_near_the_lobe() {
        let nodes: Vec<Vec<f32>> = (0..NODES).map(|node| texels(grid_normal(node))).collect();
        let error = |normal: Vec3| {
            let (exact, ours) = (texels(normal), blended(normal, |node| nodes[node].clone()));
            let square = |x: f32| f64::from(x).powi(2);
            let (off, norm) = exact
                .iter()
                .zip(&ours)
                .fold((0.0, 0.0), |(off, norm), (e, o)| (off + square(e - o), norm + square(*e)));
            (off / norm).sqrt()
        };
        let errors: Vec<f64> = normals(300).map(error).collect();
        let (mean, worst) =
            (errors.iter().sum::<f64>() / 300.0, errors.iter().fold(0.0f64, |a, b| a.max(*b)));
        println!("relative L2 error of a blend: mean {mean:.5}, worst {worst:.5}");
        assert!(mean < 0.02 && worst < 0.042);
        let bright =
            normals(10_000).fold(0.0f32, |most, normal| most.max(blend(normal).iter().map(|(_, w)| w).sum()));
        println!("white sky: at most {bright:.5}");
        assert!(bright < (51.0f32 / 49.0).sqrt() + 1e-5);
    }

    #[test]
    fn blends_go_over_edges_without_a_jump() {
        for (inside, along) in [
            (Vec3::new(1.0, 1.0, 0.37), Vec3::X),
            (Vec3::new(-0.2, 1.0, -1.0), Vec3::Z),
            (Vec3::new(-1.0, 0.81, 1.0), Vec3::X),
        ] {
            let [one, other] =
                [-1e-5, 1e-5].map(|step| blended(inside + along * step, |node| lobe(grid_normal(node))));
            assert_ne!(
                blend(inside - along * 1e-5)[0].0 / 64,
                blend(inside + along * 1e-5)[0].0 / 64,
                "two faces"
            );
            let step = one.iter().zip(&other).fold(0.0f32, |most, (a, b)| most.max((a - b).abs()));
            assert!(step < 1e-6, "{step}");
        }
    }

    #[test]
    fn the_inverse_transform_gives_the_texels() {
        let normal = Vec3::new(0.3, -0.8, 0.52).normalize();
        let mut back = lobe(normal);
        inverse_cube(&mut back, SIDE);
        assert!(back.iter().zip(texels(normal)).all(|(a, b)| (a - b).abs() < 1e-8));
    }
}
