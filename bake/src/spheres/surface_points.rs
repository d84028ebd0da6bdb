//! Points spread over a surface by area, the same each time.

use super::random::unit;
use super::triangle_tree::TriangleTree;

/// `count` random points, each in one of as many equal shares of the area: triangle and barycentric
/// coordinates. None if there is no area.
pub fn stratified(surface: &TriangleTree, count: u32) -> Vec<(usize, [f64; 3])> {
    let add = |sum: &mut f64, (_, area): &(_, f64)| {
        *sum += area;
        Some(*sum)
    };
    let ends: Vec<f64> = surface.planes.iter().scan(0.0, add).collect();
    let Some(total) = ends.last().copied().filter(|total| *total > 0.0) else { return Vec::new() };
    let point = |i: u32| {
        let at = (f64::from(i) + random(i, 0)) / f64::from(count) * total;
        let triangle = ends.partition_point(|end| *end <= at).min(ends.len() - 1);
        let (root, v) = (random(i, 1).sqrt(), random(i, 2));
        (triangle, [1.0 - root, root * (1.0 - v), root * v])
    };
    (0..count).map(point).collect()
}

/// A random number in [0, 1) for each pair.
pub fn random(point: u32, dimension: u32) -> f64 {
    unit(u64::from(dimension) << 32 | u64::from(point))
}
