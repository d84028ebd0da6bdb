//! Solids for tests.

use super::triangle_tree::TriangleTree;
use glam::DVec3;

/// A box from `min` to `max`.
pub fn cuboid(min: DVec3, max: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corner = |i: u32| {
        DVec3::new(
            [min.x, max.x][(i & 1) as usize],
            [min.y, max.y][(i >> 1 & 1) as usize],
            [min.z, max.z][(i >> 2) as usize],
        )
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// A torus about y.
pub fn torus(major: f64, minor: f64, around: u32, along: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for i in 0..around {
        for j in 0..along {
            let (a, b) = (
                std::f64::consts::TAU * f64::from(i) / f64::from(around),
                std::f64::consts::TAU * f64::from(j) / f64::from(along),
            );
            let r = major + minor * b.cos();
            vertices.push(DVec3::new(r * a.cos(), minor * b.sin(), -r * a.sin()));
        }
    }
    let at = |i: u32, j: u32| i % around * along + j % along;
    let quad = |i: u32, j: u32| {
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    let triangles = (0..around).flat_map(|i| (0..along).flat_map(move |j| quad(i, j))).collect();
    (vertices, triangles)
}

pub fn tree((vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>)) -> TriangleTree {
    TriangleTree::new(vertices, triangles)
}

/// A sphere of radius 1 from an icosahedron.
pub fn icosphere(subdivisions: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    relume_scenes::icosphere(subdivisions)
}

/// A plate of 2 × 0.02 × 2 at the origin.
pub fn thin_plate() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    cuboid(DVec3::new(-1.0, -0.01, -1.0), DVec3::new(1.0, 0.01, 1.0))
}

/// An L of volume 3, one thick.
pub fn l_shape() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let vertices = [0.0, 1.0].into_iter().flat_map(|z| outline.map(|[x, y]| DVec3::new(x, y, z))).collect();
    let caps = [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]];
    let walls = (0..6).flat_map(|i| [[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]]);
    let triangles =
        caps.iter().flat_map(|[a, b, c]| [[*a, *c, *b], [a + 6, b + 6, c + 6]]).chain(walls).collect();
    (vertices, triangles)
}

/// One mesh after the other.
pub fn joined(meshes: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (v, t) in meshes {
        let offset = vertices.len() as u32;
        vertices.extend(v);
        triangles.extend(t.iter().map(|t| t.map(|i| i + offset)));
    }
    (vertices, triangles)
}

/// Two unit cubes, the second moved.
pub fn two_cubes(offset: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    joined(&[cuboid(DVec3::ZERO, DVec3::ONE), cuboid(offset, offset + DVec3::ONE)])
}

/// The upper half of a unit sphere, without its base.
pub fn open_hemisphere(around: u32, up: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let angle = |i: u32, of: u32, whole: f64| whole * f64::from(i) / f64::from(of);
    let mut vertices = Vec::new();
    for j in 0..up {
        let (y, r) = angle(j, up, std::f64::consts::FRAC_PI_2).sin_cos();
        vertices.extend(
            (0..around)
                .map(|i| angle(i, around, std::f64::consts::TAU))
                .map(|a| DVec3::new(r * a.cos(), y, -r * a.sin())),
        );
    }
    vertices.push(DVec3::Y);
    let at = |i: u32, j: u32| if j == up { up * around } else { j * around + i % around };
    let quad = |i: u32, j: u32| {
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    let triangles =
        (0..up).flat_map(|j| (0..around).flat_map(move |i| quad(i, j))).filter(|t| t[1] != t[2]).collect();
    (vertices, triangles)
}

/// A unit cube with one triangle the wrong way round.
pub fn flipped_face_cube() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (vertices, mut triangles) = cuboid(DVec3::ZERO, DVec3::ONE);
    triangles[5].swap(1, 2);
    (vertices, triangles)
}

/// The same surface from behind.
pub fn inside_out((vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>)) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    (vertices, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect())
}

/// As a mesh comes from a file.
pub fn mesh((vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>)) -> relume_scenes::Mesh {
    let positions = vertices.iter().map(|v| v.as_vec3().to_array()).collect();
    relume_scenes::Mesh { positions, triangles, ..relume_scenes::Mesh::default() }
}

/// Random numbers in [0, 1) that are the same each time.
pub fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}
