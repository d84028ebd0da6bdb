//! Spheres as a triangle mesh, each in a colour that those it meets do not have.

use super::ply::PlyMesh;
use glam::Vec3;
use relume_scenes::icosphere;

/// Most triangles of the whole mesh, unless icosahedra have more.
const MOST_TRIANGLES: usize = 1 << 21;
/// Finest sphere: 1,280 triangles.
const MOST_SUBDIVISIONS: u32 = 3;
/// Number of colours.
const COLOURS: usize = 24;

/// The PLY file of `spheres`, each a centre and a radius; vertices of a sphere stand together.
pub(super) fn encode(spheres: &[[f32; 4]]) -> Vec<u8> {
    let (directions, triangles) = icosphere(subdivisions(spheres.len()));
    let directions: Vec<Vec3> = directions.iter().map(|d| d.as_vec3()).collect();
    let each = directions.len();
    let place = |[x, y, z, radius]: &[f32; 4]| {
        let (centre, radius) = (Vec3::new(*x, *y, *z), *radius);
        directions.iter().map(move |d| (centre + radius * d).to_array())
    };
    let of_sphere = |sphere: usize| triangles.iter().map(move |t| t.map(|v| v + (sphere * each) as u32));
    let mesh = PlyMesh {
        comment: "mesh units",
        positions: &spheres.iter().flat_map(place).collect::<Vec<_>>(),
        normals: &spheres.iter().flat_map(|_| directions.iter().map(Vec3::to_array)).collect::<Vec<_>>(),
        colours: Some(
            &colours(spheres)
                .into_iter()
                .flat_map(|colour| std::iter::repeat_n(colour, each))
                .collect::<Vec<_>>(),
        ),
        triangles: &(0..spheres.len()).flat_map(of_sphere).collect::<Vec<_>>(),
        labels: None,
    };
    mesh.encode()
}

/// How often icosahedra may be split so that so many are no more triangles than allowed.
fn subdivisions(spheres: usize) -> u32 {
    let fits = |level: &u32| spheres * (20 << (2 * level)) <= MOST_TRIANGLES;
    (1..=MOST_SUBDIVISIONS).take_while(fits).last().unwrap_or(0)
}

/// A colour for each sphere, the one that the fewest earlier spheres that it meets have.
fn colours(spheres: &[[f32; 4]]) -> Vec<[u8; 3]> {
    let mut chosen: Vec<usize> = Vec::with_capacity(spheres.len());
    for (at, sphere) in spheres.iter().enumerate() {
        let mut used = [0u32; COLOURS];
        for (other, colour) in spheres.iter().zip(&chosen) {
            if meet(sphere, other) {
                used[*colour] += 1;
            }
        }
        // Of equally rare ones another each time, so that spheres that only come near each other differ too.
        let rarest = (0..COLOURS).map(|k| (at + k) % COLOURS).min_by_key(|colour| used[*colour]);
        chosen.push(rarest.unwrap_or(0));
    }
    chosen.into_iter().map(colour).collect()
}

fn meet([ax, ay, az, a]: &[f32; 4], [bx, by, bz, b]: &[f32; 4]) -> bool {
    (ax - bx) * (ax - bx) + (ay - by) * (ay - by) + (az - bz) * (az - bz) < (a + b) * (a + b)
}

/// Hues a golden section apart, every other one darker.
fn colour(number: usize) -> [u8; 3] {
    let hue = 6.0 * (number as f32 * 0.618_034).fract();
    let value = if number.is_multiple_of(2) { 240.0 } else { 170.0 };
    [0.0, 4.0, 2.0].map(|offset: f32| {
        let distance = ((hue + offset) % 6.0 - 3.0).abs();
        (value * (0.3 + 0.7 * (distance - 1.0).clamp(0.0, 1.0))) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_palette_has_as_many_colours_as_it_says() {
        assert_eq!((0..COLOURS).map(colour).collect::<BTreeSet<_>>().len(), COLOURS);
        assert_eq!(colour(0), [240, 72, 72]);
    }

    /// In a grid where each sphere meets its 26 neighbours 13 of them came earlier: there is always a colour
    /// left.
    #[test]
    fn spheres_that_meet_differ() {
        let spheres: Vec<[f32; 4]> =
            (0..512).map(|i| [(i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32, 0.9]).collect();
        let colours = colours(&spheres);
        for (a, first) in spheres.iter().zip(&colours) {
            assert_eq!(
                spheres.iter().zip(&colours).filter(|(b, second)| meet(a, b) && first == *second).count(),
                1,
                "only itself"
            );
        }
    }

    #[test]
    fn many_spheres_are_coarser_ones() {
        for (spheres, level) in [(1, 3), (1638, 3), (1639, 2), (6554, 1), (26_215, 0), (65_536, 0)] {
            assert_eq!(subdivisions(spheres), level, "{spheres}");
        }
    }
}
