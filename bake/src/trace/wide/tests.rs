//! Every kind of instructions against a test of all triangles one by one.

use super::*;
use obvhs::aabb::Aabb;
use obvhs::triangle::Triangle;

/// Numbers from −1 to 1 without order.
pub(in crate::trace) struct Random(pub u64);

impl Random {
    pub(in crate::trace) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    pub(in crate::trace) fn point(&mut self) -> Vec3A {
        Vec3A::new(self.next(), self.next(), self.next())
    }

    /// A unit vector; one of four is along an axis, and one within a plane of two.
    pub(in crate::trace) fn direction(&mut self) -> Vec3A {
        let mut way = self.point();
        let of_four = (self.next() + 1.0) as usize + 2 * (self.next() + 1.0) as usize;
        if of_four < 2 {
            way[(self.next() + 1.0) as usize] = -0.0;
        }
        if of_four == 0 {
            way = Vec3A::new(way.x, 0.0, if way.x == 0.0 { -1.0 } else { 0.0 });
        }
        way.try_normalize().unwrap_or(Vec3A::NEG_Y)
    }
}

struct Padded([Vec3A; 3]);

impl Boundable for Padded {
    fn aabb(&self) -> Aabb {
        let Aabb { min, max } = Triangle { v0: self.0[0], v1: self.0[1], v2: self.0[2] }.aabb();
        Aabb::new(min - 1e-4, max + 1e-4)
    }
}

pub(in crate::trace) fn wide(triangles: &[[Vec3A; 3]]) -> Wide {
    Wide::new(triangles, &triangles.iter().map(|t| Padded(*t)).collect::<Vec<_>>())
}

/// What no hierarchy and no lanes find: the number as given, and the hit.
fn nearest_of_all(
    triangles: &[[Vec3A; 3]],
    origin: Vec3A,
    direction: Vec3A,
    counts: impl Fn(u32) -> bool,
) -> Option<(u32, TriangleHit)> {
    let ray = ShearedRay::new(origin, direction);
    let hits = (0..).zip(triangles).filter(|(number, _)| counts(*number));
    let hits = hits.filter_map(|(number, triangle)| Some((number, ray.intersect(triangle, f32::INFINITY)?)));
    // Of equal ones the first.
    hits.min_by(|(_, a), (_, b)| a.t.total_cmp(&b.t))
}

/// Triangles without order; a grid whose edges and corners rays meet exactly, three times over; slivers.
pub(in crate::trace) fn scenes() -> Vec<Vec<[Vec3A; 3]>> {
    let mut random = Random(3);
    let soup = (0..700).map(|_| {
        let middle = random.point();
        std::array::from_fn(|_| middle + 0.2 * random.point())
    });
    let soup: Vec<_> = soup.collect();
    let mut grid = Vec::new();
    for cell in 0..3 * 64 {
        let at = |x: i32, z: i32| {
            let (x, z) = (cell % 8 + x, cell / 8 % 8 + z);
            Vec3A::new(x as f32 * 0.25 - 1.0, 0.0, z as f32 * 0.25 - 1.0)
        };
        grid.extend([[at(0, 0), at(0, 1), at(1, 0)], [at(1, 0), at(0, 1), at(1, 1)]]);
    }
    let mut slivers = Vec::new();
    for _ in 0..300 {
        let (a, b) = (random.point(), random.point());
        slivers.push([a, b, a + 1e-6 * random.point()]);
    }
    vec![Vec::new(), soup[..1].to_vec(), soup[..8].to_vec(), soup, grid, slivers]
}

/// Rays from anywhere anywhere, and ones aimed at corners and middles of edges.
fn rays(triangles: &[[Vec3A; 3]]) -> Vec<(Vec3A, Vec3A)> {
    let mut random = Random(5);
    let mut rays: Vec<_> = (0..3000).map(|_| (2.0 * random.point(), random.direction())).collect();
    for (number, triangle) in triangles.iter().enumerate().take(500) {
        let origin = if number % 2 == 0 { 2.0 * random.point() } else { triangle[0] + Vec3A::Y };
        for target in [triangle[0], 0.5 * (triangle[1] + triangle[2])] {
            rays.push((origin, (target - origin).normalize()));
        }
    }
    rays
}

impl Kernel {
    /// All that this processor can run.
    fn all() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        let own = {
            let (v3, v4) = (pulp::x86::V3::try_new(), pulp::x86::V4::try_new());
            v3.map(Self::V3).into_iter().chain(v4.map(Self::V4)).collect()
        };
        #[cfg(not(target_arch = "x86_64"))]
        let own = Vec::new();
        [own, vec![Self::Plain]].concat()
    }
}

impl Wide {
    /// Does something with each kind of instructions.
    pub fn with_all_kernels(&mut self, mut run: impl FnMut(&Self, &str)) {
        for kernel in Kernel::all() {
            self.kernel = kernel;
            run(self, &format!("{kernel:?}"));
        }
    }
}

/// Entries of plain numbers, without the bits that may differ.
fn check_order<L: Lanes>(simd: L, name: &str) {
    let mut random = Random(11);
    for mask in 0..1 << LANES {
        let distances = std::array::from_fn(|_| (100.0 * random.next()).max(0.0));
        let codes = std::array::from_fn(|lane| 1000 + lane as u32);
        let count = u32::count_ones(mask) as usize;
        let expected = Plain.packed(mask, &codes);
        let packed = simd.run(
            #[inline(always)]
            || simd.packed(mask, &codes),
        );
        assert_eq!(packed[..count], expected[..count], "{name}, {mask:b}");
        if count <= 4 {
            let expected = Plain.sorted(mask, distances, &codes);
            let sorted = simd.run(
                #[inline(always)]
                || simd.sorted(mask, simd.load(&distances), &codes),
            );
            // Where distances differ in their lowest bits only, by lane; Plain has the same by code.
            assert_eq!(sorted[..count], expected[..count], "{name}, {mask:b} {distances:?}");
            assert!(sorted[..count].is_sorted_by(|a, b| distance_of(*a) >= distance_of(*b)));
            for entry in &sorted[..count] {
                let exact = distances[(*entry as u32 - 1000) as usize];
                assert!(distance_of(*entry) <= exact && distance_of(*entry) >= 0.999_99 * exact);
            }
        }
    }
}

#[test]
fn every_kind_of_instructions_sorts_and_packs_alike() {
    for kernel in Kernel::all() {
        match kernel {
            Kernel::Plain => check_order(Plain, "plain"),
            #[cfg(target_arch = "x86_64")]
            Kernel::V3(simd) => check_order(simd, "AVX2"),
            #[cfg(target_arch = "x86_64")]
            Kernel::V4(simd) => check_order(simd, "AVX-512"),
        }
    }
}

#[test]
fn every_kind_of_instructions_finds_what_a_test_of_all_triangles_finds() {
    let (mut hits, mut ties) = (0, 0);
    for triangles in scenes() {
        let mut wide = wide(&triangles);
        let order = wide.order.clone();
        assert_eq!(order.len(), triangles.len());
        for kernel in Kernel::all() {
            wide.kernel = kernel;
            for (origin, direction) in rays(&triangles) {
                // As a material with holes has it: some triangles do not count.
                for leaves_out in [u32::MAX, 3] {
                    let counts = |given: u32| given % 4 != leaves_out;
                    let expected = nearest_of_all(&triangles, origin, direction, counts);
                    let found = wide.nearest(origin, direction, |at, _| counts(order[at as usize]));
                    if let Some(found) = found {
                        let given = triangles[order[found.number() as usize] as usize];
                        assert_eq!(wide.triangle(&found), given);
                    }
                    let found = found.map(|found| (order[found.number() as usize], found.hit));
                    assert_eq!(found, expected, "{kernel:?}, {origin} {direction}");
                    hits += usize::from(found.is_some());
                    let distances = match found {
                        Some((_, hit)) => [0.5 * hit.t, hit.t, hit.t.next_up(), f32::INFINITY],
                        None => [1e-3, 1.0, 1e3, f32::INFINITY],
                    };
                    for distance in distances {
                        let blocked =
                            wide.occluded(origin, direction, distance, |at, _| counts(order[at as usize]));
                        let expected = expected.is_some_and(|(_, hit)| hit.t < distance);
                        assert_eq!(blocked, expected, "{kernel:?}, {origin} {direction} {distance}");
                    }
                    let same = |(_, hit): &(u32, TriangleHit)| {
                        let ray = ShearedRay::new(origin, direction);
                        let all = triangles.iter().filter_map(|t| ray.intersect(t, f32::INFINITY));
                        all.filter(|other| other.t == hit.t).count() > 1
                    };
                    ties += usize::from(found.as_ref().is_some_and(same));
                }
            }
        }
    }
    assert!(hits > 5_000 && ties > 1_000, "{hits} hits, of them {ties} of several triangles at once");
}
