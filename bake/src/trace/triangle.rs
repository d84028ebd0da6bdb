//! A watertight ray-triangle test (Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection").
//!
//! The ray is sheared onto an axis; whether it passes an edge is then the sign of a difference of two
//! products of the edge's projected ends. Both triangles at the edge compute the very same products, and
//! rounding never turns the sign around, it can only make it zero. Zeros are decided again in double
//! precision, where the products are exact, and count as inside. So no ray slips between two neighbours.

use glam::{DVec2, Vec3A};

/// A ray prepared for triangle tests.
#[derive(Debug, Clone, Copy)]
pub struct ShearedRay {
    origin: Vec3A,
    /// Rows of the shear: the first two project on the plane across the ray, the third measures along it.
    across_x: Vec3A,
    across_y: Vec3A,
    along: Vec3A,
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric weights of the second and third vertex.
    pub barycentric: [f32; 2],
}

impl ShearedRay {
    /// Prepares the ray from `origin` along `direction`, which must not be zero.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let axis = direction.abs();
        let (x, y, z) = if axis.x >= axis.y && axis.x >= axis.z {
            (Vec3A::Y, Vec3A::Z, Vec3A::X)
        } else if axis.y >= axis.z {
            (Vec3A::Z, Vec3A::X, Vec3A::Y)
        } else {
            (Vec3A::X, Vec3A::Y, Vec3A::Z)
        };
        let along = z / direction.dot(z);
        Self { origin, across_x: x - direction.dot(x) * along, across_y: y - direction.dot(y) * along, along }
    }

    /// The axes across and along the ray, what the one along adds to those across, and its inverse length. All
    /// other parts of the shear are 0 or 1.
    #[inline]
    pub fn shear(&self) -> ([usize; 3], [f32; 2], f32) {
        let along = if self.along.x != 0.0 {
            0
        } else if self.along.y != 0.0 {
            1
        } else {
            2
        };
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        (axes, [self.across_x[along], self.across_y[along]], self.along[along])
    }

    /// The first point of the triangle with 0 < t < `t_max`, from either side.
    pub fn intersect(&self, [a, b, c]: &[Vec3A; 3], t_max: f32) -> Option<TriangleHit> {
        let (a, b, c) = (*a - self.origin, *b - self.origin, *c - self.origin);
        let (ax, ay) = (a.dot(self.across_x), a.dot(self.across_y));
        let (bx, by) = (b.dot(self.across_x), b.dot(self.across_y));
        let (cx, cy) = (c.dot(self.across_x), c.dot(self.across_y));
        let mut u = cx * by - cy * bx;
        let mut v = ax * cy - ay * cx;
        let mut w = bx * ay - by * ax;
        if u == 0.0 || v == 0.0 || w == 0.0 {
            let exact = |px, py, qx, qy| {
                DVec2::new(f64::from(px), f64::from(py)).perp_dot(DVec2::new(f64::from(qx), f64::from(qy)))
                    as f32
            };
            (u, v, w) = (exact(cx, cy, bx, by), exact(ax, ay, cx, cy), exact(bx, by, ax, ay));
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let scale = 1.0 / determinant;
        let t = (u * a.dot(self.along) + v * b.dot(self.along) + w * c.dot(self.along)) * scale;
        (t > 0.0 && t < t_max).then_some(TriangleHit { t, barycentric: [v * scale, w * scale] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3a;

    const TRIANGLE: [Vec3A; 3] = [vec3a(0.0, 0.0, 0.0), vec3a(2.0, 0.0, 0.0), vec3a(0.0, 2.0, 0.0)];

    #[test]
    fn hits_from_both_sides_with_barycentrics() {
        for (origin, direction) in
            [(vec3a(0.5, 1.0, 3.0), vec3a(0.0, 0.0, -1.5)), (vec3a(0.5, 1.0, -3.0), vec3a(0.0, 0.0, 1.5))]
        {
            let hit = ShearedRay::new(origin, direction).intersect(&TRIANGLE, f32::INFINITY).unwrap();
            assert!((hit.t - 2.0).abs() < 1e-6);
            assert!((hit.barycentric[0] - 0.25).abs() < 1e-6 && (hit.barycentric[1] - 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn misses_beside_behind_and_beyond() {
        let test = |o, d, t_max| ShearedRay::new(o, d).intersect(&TRIANGLE, t_max);
        assert!(test(vec3a(1.5, 1.5, 1.0), Vec3A::NEG_Z, f32::INFINITY).is_none());
        assert!(test(vec3a(0.5, 0.5, 1.0), Vec3A::Z, f32::INFINITY).is_none());
        assert!(test(vec3a(0.5, 0.5, 1.0), Vec3A::NEG_Z, 0.99).is_none());
        assert!(test(vec3a(0.5, 0.5, 1.0), Vec3A::X, f32::INFINITY).is_none(), "parallel");
    }

    #[test]
    fn edges_and_vertices_belong_to_somebody() {
        // Two triangles share the diagonal of a square; rays aimed exactly at it must hit at least one.
        let square = [
            [vec3a(0.1, 0.3, 0.0), vec3a(1.7, 0.2, 0.1), vec3a(1.9, 2.1, 0.3)],
            [vec3a(0.1, 0.3, 0.0), vec3a(1.9, 2.1, 0.3), vec3a(-0.2, 1.8, 0.2)],
        ];
        let eye = vec3a(0.7, -0.4, 5.0);
        for step in 0..100_000 {
            let target = square[0][0].lerp(square[0][2], step as f32 / 100_000.0);
            let ray = ShearedRay::new(eye, target - eye);
            assert!(square.iter().any(|t| ray.intersect(t, f32::INFINITY).is_some()), "step {step}");
        }
    }
}
