//! Points on a mesh that emits light, more of them where a texture lets it emit more.
//!
//! Every triangle is cut into congruent cells, about as large as the texture's texels. A cell is chosen by
//! its area times the most it emits, a point within it evenly. Where a texture glows only between the points
//! that were looked at, no point is chosen: paths by lobes find that light all the same.

use super::world::rounding_of;
use glam::{Vec2, Vec3A};
use relume_scenes::{Glow, Material, Mesh, Texture};
use std::sync::Arc;

/// Most cells of one light.
const MAX_CELLS: u64 = 1 << 18;
/// Most cells along a side of a triangle.
const MAX_SIDE: u32 = 512;
/// Most points along a side of a cell at which its texture is looked at.
const MAX_POINTS: u32 = 4;

/// The triangles of a light, prepared for sampling.
pub(super) struct LightMesh {
    triangles: Vec<[Vec3A; 3]>,
    /// What lets how much through.
    glow: Option<Coat>,
    /// Where the surface has holes, and the least alpha where it has none.
    mask: Option<(Coat, f32)>,
    grids: Vec<Grid>,
    /// The most that each cell emits, as a share of the light's radiance.
    weights: Vec<f32>,
    /// Running sums of the cells' areas times their weights, m².
    sums: Vec<f64>,
}

/// How a triangle is cut.
struct Grid {
    /// Cells along a side.
    side: u32,
    /// Index of its first cell.
    first: u32,
}

/// A texture on the triangles.
struct Coat {
    texture: Arc<Texture>,
    /// By triangle.
    uvs: Vec<[Vec2; 3]>,
}

impl Coat {
    fn new(texture: &Arc<Texture>, uvs: &[[f32; 2]], mesh: &Mesh) -> Self {
        let uv = |vertex: u32| uvs.get(vertex as usize).copied().map_or(Vec2::ZERO, Vec2::from);
        Self { texture: texture.clone(), uvs: mesh.triangles.iter().map(|t| t.map(uv)).collect() }
    }

    fn sample(&self, triangle: u32, [v, w]: [f32; 2]) -> [f32; 4] {
        let [a, b, c] = self.uvs.get(triangle as usize).copied().unwrap_or_default();
        self.texture.sample((a * (1.0 - v - w) + b * v + c * w).to_array())
    }

    /// Texels along the longest side of a triangle.
    fn extent(&self, triangle: usize) -> f32 {
        let size = Vec2::from(self.texture.size.map(|n| n as f32));
        let [a, b, c] = self.uvs.get(triangle).copied().unwrap_or_default();
        [b - a, c - b, a - c].map(|side| (side * size).abs().max_element()).into_iter().fold(0.0, f32::max)
    }
}

/// A point of a light, chosen for sampling.
pub(super) struct Chosen {
    /// World space, just above the surface.
    pub point: Vec3A,
    /// Unit normal of its triangle.
    pub normal: Vec3A,
    /// m²: 1 over the density of the choice per m².
    pub area: f32,
    /// What is emitted there, as a share of the light's radiance.
    pub share: Vec3A,
}

impl LightMesh {
    /// Prepares `mesh`, which has at least one triangle and wears `material`.
    pub fn new(mesh: &Mesh, glow: Option<&Glow>, material: Option<&Material>) -> Self {
        let triangles: Vec<_> =
            mesh.triangles.iter().map(|t| t.map(|i| Vec3A::from(mesh.positions[i as usize]))).collect();
        let glow = glow.map(|glow| Coat::new(&glow.texture, &glow.uvs, mesh));
        let mask =
            material.and_then(|m| Some((Coat::new(m.texture.as_ref()?, &mesh.uvs, mesh), m.alpha_cutoff?)));
        let (grids, points) = grids(glow.as_ref(), triangles.len());
        let mut light = Self { triangles, glow, mask, grids, weights: Vec::new(), sums: Vec::new() };
        light.weigh(points);
        light
    }

    fn weigh(&mut self, points: u32) {
        let mut sum = 0.0;
        for (triangle, (grid, [a, b, c])) in (0..).zip(self.grids.iter().zip(&self.triangles)) {
            let cells = grid.side * grid.side;
            let area = 0.5 * f64::from((b - a).cross(c - a).length()) / f64::from(cells);
            for cell in 0..cells {
                let weight = self
                    .glow
                    .as_ref()
                    .map_or(1.0, |glow| most(glow, triangle, cell_corners(grid.side, cell), points));
                sum += area * f64::from(weight);
                self.weights.push(weight);
                self.sums.push(sum);
            }
        }
    }

    /// The area of a surface that emits the light's radiance evenly and as much as this one, or more, m².
    pub fn area(&self) -> f32 {
        self.sums.last().copied().unwrap_or(0.0) as f32
    }

    /// A point chosen by two numbers in [0, 1).
    pub fn sample(&self, [u, v]: [f32; 2]) -> Option<Chosen> {
        let total = self.sums.last().copied().filter(|total| *total > 0.0)?;
        let at = f64::from(u) * total;
        let cell = self.sums.partition_point(|sum| *sum <= at).min(self.sums.len() - 1);
        let before = if cell == 0 { 0.0 } else { self.sums[cell - 1] };
        // What chose the cell is evenly spread within its share and serves again.
        let u = ((at - before) / (self.sums[cell] - before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) as f32;
        let triangle = self.grids.partition_point(|grid| grid.first as usize <= cell).checked_sub(1)?;
        let grid = &self.grids[triangle];
        let [p, q, r] = cell_corners(grid.side, cell as u32 - grid.first);
        // Square root: evenly over the triangle (Turk 1990).
        let root = u.sqrt();
        let barycentric = p * (1.0 - root) + q * (root * (1.0 - v)) + r * (root * v);
        let [a, b, c] = self.triangles[triangle];
        let point = a * (1.0 - barycentric.x - barycentric.y) + b * barycentric.x + c * barycentric.y;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let share = self.share(triangle as u32, barycentric.to_array());
        Some(Chosen {
            point: point + normal * rounding_of(&[a, b, c]),
            normal,
            area: self.area_over(self.weights[cell]),
            share,
        })
    }

    /// What is emitted at a point of a triangle, as a share of the light's radiance.
    pub fn share(&self, triangle: u32, barycentric: [f32; 2]) -> Vec3A {
        if self.mask.as_ref().is_some_and(|(coat, cutoff)| coat.sample(triangle, barycentric)[3] < *cutoff) {
            return Vec3A::ZERO;
        }
        self.glow.as_ref().map_or(Vec3A::ONE, |glow| Vec3A::from_slice(&glow.sample(triangle, barycentric)))
    }

    /// 1 over the density per m² with which [`LightMesh::sample`] chooses a point of a triangle, m²; infinite
    /// where it chooses none.
    pub fn area_at(&self, triangle: u32, barycentric: [f32; 2]) -> f32 {
        let grid = &self.grids[triangle as usize];
        self.area_over(self.weights[(grid.first + cell_at(grid.side, barycentric)) as usize])
    }

    fn area_over(&self, weight: f32) -> f32 {
        self.area() / weight
    }
}

/// How every triangle is cut, and the points to look at along a side of a cell.
fn grids(glow: Option<&Coat>, triangles: usize) -> (Vec<Grid>, u32) {
    let extent = |triangle: usize| glow.map_or(1.0, |glow| glow.extent(triangle));
    let side =
        |triangle: usize, step: u32| ((extent(triangle) / step as f32).ceil() as u32).clamp(1, MAX_SIDE);
    let cells = |step: u32| (0..triangles).map(|t| u64::from(side(t, step)).pow(2)).sum::<u64>();
    let fits = |step: &u32| cells(*step) <= MAX_CELLS.max(triangles as u64);
    let step = (0..16).map(|k| 1 << k).find(fits).unwrap_or(1 << 16);
    let mut first = 0;
    let grid = |triangle| {
        let grid = Grid { side: side(triangle, step), first };
        first += grid.side * grid.side;
        grid
    };
    ((0..triangles).map(grid).collect(), step.min(MAX_POINTS))
}

/// The largest channel of a texture at some points of a cell.
fn most(glow: &Coat, triangle: u32, [p, q, r]: [Vec2; 3], points: u32) -> f32 {
    let centre = |cell: u32| cell_corners(points, cell).into_iter().sum::<Vec2>() / 3.0;
    let inner = (0..points * points).map(centre).map(|at| p * (1.0 - at.x - at.y) + q * at.x + r * at.y);
    let channels = |at: Vec2| glow.sample(triangle, at.to_array());
    inner.chain([p, q, r]).map(channels).fold(0.0, |most, [r, g, b, _]| most.max(r).max(g).max(b))
}

/// The corners of a cell, as weights of the second and third corner of its triangle. Row i, from the first
/// corner's side, has 2(side − i) − 1 cells.
fn cell_corners(side: u32, cell: u32) -> [Vec2; 3] {
    let left = side * side - cell;
    let rows_left = (left - 1).isqrt() + 1;
    let (row, at) = (side - rows_left, cell - (side * side - rows_left * rows_left));
    let (x, y) = (row as f32, (at / 2) as f32);
    let corners = if at % 2 == 0 {
        [[x, y], [x + 1.0, y], [x, y + 1.0]]
    } else {
        [[x + 1.0, y + 1.0], [x, y + 1.0], [x + 1.0, y]]
    };
    corners.map(|corner| Vec2::from(corner) / side as f32)
}

/// The cell of a triangle that a point lies in, the inverse of [`cell_corners`].
fn cell_at(side: u32, [v, w]: [f32; 2]) -> u32 {
    let n = side as f32;
    let row = ((v * n) as u32).min(side - 1);
    let column = ((w * n) as u32).min(side - 1 - row);
    let beyond = (v + w) * n - (row + column) as f32 > 1.0 && row + column + 1 < side;
    side * side - (side - row).pow(2) + 2 * column + u32::from(beyond)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_scenes::{Filter, Wrap};

    /// Two triangles of areas 2 and 0.5, apart and in different planes.
    fn two_triangles() -> Mesh {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 2.0, 0.0],
            [5.0, 0.0, 0.0],
            [5.0, 1.0, 0.0],
            [5.0, 0.0, 1.0],
        ];
        Mesh {
            normals: vec![[0.0, 0.0, 1.0]; 6],
            positions,
            uvs: Vec::new(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
        }
    }

    fn regular(n: usize) -> impl Iterator<Item = [f32; 2]> {
        (0..n * n).map(move |i| [(i % n) as f32 / n as f32, (i / n) as f32 / n as f32])
    }

    #[test]
    fn points_lie_evenly_on_all_triangles() {
        let light = LightMesh::new(&two_triangles(), None, None);
        assert!((light.area() - 2.5).abs() < 1e-6);
        let (n, mut mean, mut first) = (512, Vec3A::ZERO, 0);
        for numbers in regular(n) {
            let Chosen { point, normal, area, share } = light.sample(numbers).unwrap();
            let on_first = point.x < 4.0;
            assert_eq!((normal, area, share), (if on_first { Vec3A::Z } else { Vec3A::X }, 2.5, Vec3A::ONE));
            if on_first {
                assert!(point.x >= -1e-4 && point.y >= -1e-4 && point.x + point.y <= 2.0 + 1e-4);
                mean += point;
                first += 1;
            }
        }
        assert!((first as f32 / (n * n) as f32 - 0.8).abs() < 0.003, "{first}");
        // A regular grid of n² points: the mean is off by the order of 1/n.
        assert!(
            (mean / first as f32).distance(Vec3A::new(2.0 / 3.0, 2.0 / 3.0, 0.0)) < 0.01,
            "{}",
            mean / first as f32
        );
    }

    #[test]
    fn cells_fill_their_triangle_and_are_found_again() {
        for side in [1, 2, 3, 7, 64, 512] {
            let mut area = 0.0;
            for cell in 0..side * side {
                let corners = cell_corners(side, cell);
                let [p, q, r] = corners.map(Vec2::as_dvec2);
                area += 0.5 * (q - p).perp_dot(r - p).abs();
                let centre = corners.into_iter().sum::<Vec2>() / 3.0;
                assert_eq!(cell_at(side, centre.to_array()), cell, "{side}");
            }
            assert!((area - 0.5).abs() < 1e-4, "{side}: {area}");
            for outside in
                [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1e-7], [0.5, 0.5], [1e-8, 1.0], [0.0, 1.1]]
            {
                assert!(cell_at(side, outside) < side * side);
            }
        }
    }

    /// One glowing texel in 64: points lie on it and nowhere else, and estimate the light of the whole
    /// exactly.
    #[test]
    fn points_lie_where_the_texture_glows() {
        let mut texels = vec![[0, 0, 0, 255]; 64];
        texels[8 * 5 + 2] = [255, 0, 0, 255];
        let texture =
            Arc::new(Texture { size: [8, 8], wrap: [Wrap::Clamp; 2], filter: Filter::Nearest, texels });
        let mesh = Mesh {
            positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            uvs: Vec::new(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let light = LightMesh::new(&mesh, Some(&Glow { texture, uvs: uvs.into() }), None);
        let (n, mut emitted, mut lit) = (256, 0.0, 0);
        for numbers in regular(n) {
            let Chosen { point, area, share, .. } = light.sample(numbers).unwrap();
            emitted += f64::from(area * share.x);
            lit += usize::from(share.x > 0.0);
            let glows = (0.5..0.75).contains(&point.x) && (1.25..1.5).contains(&point.y);
            assert!(glows == (share.x == 1.0) && share.y == 0.0, "{point} {share}");
        }
        // A texel of 0.25 m by 0.25 m; cells at its edge are chosen as if they glowed whole.
        let emitted = emitted / (n * n) as f64;
        assert!((emitted - 0.0625).abs() < 1e-3 && lit > n * n / 8, "{emitted} {lit}");
    }
}
