//! Where the light of a mesh's vertices is received.
//!
//! A vertex on a rim, where the surface of its mesh ends, often lies in the plane of another surface: the foot
//! of a wall, the corner of a room, a box on the ground. It sees that surface edge-on, as if it were not there,
//! while every point beside it that the vertex speaks for has half its view taken. So such vertices receive
//! light a little within their surface. All others receive it where they are.

use glam::Vec3;

/// How far within, in parts of the way to the middle of the opposite edge of a triangle.
const SHARE: f32 = 1.0 / 64.0;

/// The vertices of a mesh that lie on a rim: on an edge of one triangle alone. Along a hard edge and a seam of
/// texture coordinates a mesh has its vertices twice, so these are rims, too.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rims {
    /// For each vertex the two others of the first triangle at it, or itself twice if it is on no rim.
    beside: Vec<[u32; 2]>,
}

impl Rims {
    /// Of `triangles` among so many `vertices`. What they name beyond these is left out.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut beside: Vec<[u32; 2]> = (0..vertices as u32).map(|vertex| [vertex; 2]).collect();
        let known = || triangles.iter().filter(|triangle| triangle.iter().all(|v| (*v as usize) < vertices));
        let edges = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]].map(|[p, q]| [p.min(q), p.max(q)]);
        let mut edges: Vec<[u32; 2]> = known().flat_map(edges).collect();
        edges.sort_unstable();
        let mut on_rim = vec![false; vertices];
        for edge in edges.chunk_by(|a, b| a == b).filter(|uses| uses.len() == 1).flatten() {
            edge.iter().for_each(|vertex| on_rim[*vertex as usize] = true);
        }
        for [a, b, c] in known().rev() {
            for [vertex, others @ ..] in [[*a, *b, *c], [*b, *c, *a], [*c, *a, *b]] {
                if on_rim[vertex as usize] {
                    beside[vertex as usize] = others;
                }
            }
        }
        Self { beside }
    }

    /// For each vertex the two others between which it receives light, as [`Rims::received`] has it.
    pub fn beside(&self) -> &[[u32; 2]] {
        &self.beside
    }

    /// Where each vertex receives light with all of them at `positions`, in their space.
    pub fn received(&self, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let at = |vertex: u32| positions.get(vertex as usize).map(|position| Vec3::from(*position));
        let of = |(position, [p, q]): (&[f32; 3], &[u32; 2])| {
            let position = Vec3::from(*position);
            received_at(position, [*p, *q].map(|vertex| at(vertex).unwrap_or(position))).to_array()
        };
        positions.iter().zip(&self.beside).map(of).collect()
    }
}

/// Where a vertex at `position` receives light, with those beside it.
fn received_at(position: Vec3, [p, q]: [Vec3; 2]) -> Vec3 {
    position + 0.5 * SHARE * ((p - position) + (q - position))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four triangles around vertex 4, in the corners of a square.
    const FAN: [[u32; 3]; 4] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    const SQUARE: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];

    #[test]
    fn vertices_of_a_rim_receive_light_within_their_first_triangle_and_others_where_they_are() {
        let received = Rims::new(5, &FAN).received(&SQUARE);
        // A 64th of the way to the middle of the edge from 1 to 4.
        assert_eq!(received[0], [1.5 / 64.0, 0.5 / 64.0, 0.0]);
        assert_eq!(received[2], [2.0 - 0.5 / 64.0, 2.0 - 1.5 / 64.0, 0.0]);
        assert_eq!(received[4], SQUARE[4]);
        for [x, y, _] in &received[..4] {
            assert!([x, y].iter().all(|v| **v > 0.0 && **v < 2.0), "{received:?}");
        }
    }

    #[test]
    fn a_closed_mesh_has_no_rim_and_three_triangles_at_an_edge_are_none() {
        let tetrahedron = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        let alone = |vertices| (0..vertices).map(|vertex| [vertex; 2]).collect::<Vec<_>>();
        assert_eq!(Rims::new(4, &tetrahedron).beside(), alone(4));
        assert_eq!(Rims::new(4, &[tetrahedron[0]; 3]).beside(), alone(4));
        assert_eq!(Rims::new(0, &[]).beside(), alone(0));
    }

    #[test]
    fn what_is_not_there_is_left_out() {
        let rims = Rims::new(3, &[[0, 1, 7], [0, 1, 2]]);
        assert_eq!(rims.beside(), [[1, 2], [2, 0], [0, 1]]);
        assert_eq!(rims.received(&SQUARE[..1]), [SQUARE[0]], "as many as there are positions");
        assert_eq!(Rims::new(2, &[[0, 1, u32::MAX]]).received(&SQUARE[..2]), SQUARE[..2]);
    }
}
