//! Points spread evenly over a mesh that emits light.

use super::world::rounding_of;
use glam::Vec3A;
use relume_scenes::Mesh;

/// The triangles of a light, prepared for sampling.
pub(super) struct LightMesh {
    triangles: Vec<[Vec3A; 3]>,
    /// Running sums of the triangles' areas, m².
    area_sums: Vec<f32>,
}

impl LightMesh {
    /// Prepares `mesh`, which has at least one triangle.
    pub fn new(mesh: &Mesh) -> Self {
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(|i| Vec3A::from(mesh.positions[i as usize]))).collect();
        let mut sum = 0.0f64;
        let mut running = |[a, b, c]: &[Vec3A; 3]| {
            sum += 0.5 * f64::from((*b - *a).cross(*c - *a).length());
            sum as f32
        };
        let area_sums = triangles.iter().map(&mut running).collect();
        Self { triangles, area_sums }
    }

    /// m².
    pub fn area(&self) -> f32 {
        self.area_sums.last().copied().unwrap_or(0.0)
    }

    /// A point, just above the surface, and the unit normal of its triangle, from two numbers in [0, 1).
    pub fn sample(&self, [u, v]: [f32; 2]) -> (Vec3A, Vec3A) {
        let at = u * self.area();
        let index = self.area_sums.partition_point(|sum| *sum <= at).min(self.triangles.len() - 1);
        let before = if index == 0 { 0.0 } else { self.area_sums[index - 1] };
        // What chose the triangle is evenly spread within its share and serves again.
        let u = ((at - before) / (self.area_sums[index] - before).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let [a, b, c] = self.triangles[index];
        // Square root: evenly over the triangle (Turk 1990).
        let root = u.sqrt();
        let point = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        (point + normal * rounding_of(&[a, b, c]), normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_evenly_on_all_triangles() {
        // Two triangles of areas 2 and 0.5, apart and in different planes.
        let positions = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 1.0]];
        let mesh = Mesh { normals: vec![[0.0, 0.0, 1.0]; 6], positions, uvs: Vec::new(), triangles: vec![[0, 1, 2], [3, 4, 5]] };
        let light = LightMesh::new(&mesh);
        assert!((light.area() - 2.5).abs() < 1e-6);
        let n = 512;
        let (mut mean, mut first) = (Vec3A::ZERO, 0);
        for i in 0..n * n {
            let (point, normal) = light.sample([(i % n) as f32 / n as f32, (i / n) as f32 / n as f32]);
            let on_first = point.x < 4.0;
            assert_eq!(normal, if on_first { Vec3A::Z } else { Vec3A::X });
            if on_first {
                assert!(point.x >= -1e-4 && point.y >= -1e-4 && point.x + point.y <= 2.0 + 1e-4);
                mean += point;
                first += 1;
            }
        }
        assert!((first as f32 / (n * n) as f32 - 0.8).abs() < 0.003, "{first}");
        // A regular grid of n² points: the mean is off by the order of 1/n.
        assert!((mean / first as f32).distance(Vec3A::new(2.0 / 3.0, 2.0 / 3.0, 0.0)) < 0.01, "{}", mean / first as f32);
    }
}
