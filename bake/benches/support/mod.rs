//! Large meshes and numbers without order, the same for every bench.

use glam::Vec3A;
use relume_scenes::Mesh;

/// Numbers from 0 to 1 without order.
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    /// A point of the cube from −1 to 1.
    pub fn point(&mut self) -> Vec3A {
        Vec3A::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// So many small triangles without order in the cube from −1 to 1.
pub fn soup(count: usize) -> Mesh {
    let mut random = Random(1);
    let corner = |random: &mut Random, middle: Vec3A| (middle + 0.01 * random.point()).to_array();
    let positions: Vec<[f32; 3]> = (0..count)
        .flat_map(|_| {
            let middle = random.point();
            [corner(&mut random, middle), corner(&mut random, middle), corner(&mut random, middle)]
        })
        .collect();
    mesh(positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// A height field of 2·`side`² triangles.
pub fn field(side: u32) -> Mesh {
    let height =
        |x: f32, z: f32| 0.1 * (9.0 * x).sin() * (7.0 * z).cos() + 0.01 * (90.0 * x + 60.0 * z).sin();
    let place = |k: u32| k as f32 / side as f32 * 2.0 - 1.0;
    let positions = (0..=side)
        .flat_map(|z| (0..=side).map(move |x| [place(x), height(place(x), place(z)), place(z)]))
        .collect();
    let at = |x: u32, z: u32| z * (side + 1) + x;
    let triangles = (0..side)
        .flat_map(|z| {
            (0..side).flat_map(move |x| {
                [[at(x, z), at(x, z + 1), at(x + 1, z)], [at(x + 1, z), at(x, z + 1), at(x + 1, z + 1)]]
            })
        })
        .collect();
    mesh(positions, triangles)
}

/// A mesh whose normals do not matter.
pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { normals: vec![[0.0, 1.0, 0.0]; positions.len()], uvs: Vec::new(), positions, triangles }
}
