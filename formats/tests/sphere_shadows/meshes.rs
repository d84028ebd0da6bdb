//! Triangles of meshes in the view of receivers.

use super::*;
use relume_formats::evaluate::sphere_shadows::{Sides, Triangle};

/// The surface of a ball, finely cut, as object 1 casts it.
pub fn ball(centre: Vec3, radius: f32, sides: [Sides; 2]) -> Vec<Triangle> {
    const RINGS: usize = 64;
    let point = |ring: usize, spoke: usize| {
        let (theta, phi) =
            (std::f32::consts::PI * ring as f32 / RINGS as f32, std::f32::consts::TAU * spoke as f32 / 128.0);
        centre + radius * Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let cells = (0..RINGS).flat_map(|ring| (0..128).map(move |spoke| (ring, spoke)));
    let halves = cells.flat_map(|(ring, spoke)| {
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, s)| point(ring + r, (spoke + s) % 128));
        [[a, b, c], [a, c, d]]
    });
    halves.map(|corners| triangle(corners, sides)).collect()
}

fn triangle(corners: [Vec3; 3], sides: [Sides; 2]) -> Triangle {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    Triangle {
        corners: corners.map(|corner| corner.to_array()),
        normal: (normal / normal.length()).to_array(),
        object: 1,
        sides,
    }
}

fn only_triangles(triangles: Vec<Triangle>) -> Casters {
    Casters { triangles, spheres: Vec::new() }
}

/// A side that never counts.
pub const NEVER: f32 = f32::INFINITY;

pub fn by(above: f32, below: f32) -> [Sides; 2] {
    [Sides { above, below }; 2]
}

/// Front faces, back faces and all of a closed mesh cover the same from outside, and what its sphere covers but
/// for its rim.
#[test]
fn a_closed_mesh_casts_the_same_by_either_side() {
    let mut random = Random(9);
    for scale in [1e-3, 1.0, 1e3] {
        for _ in 0..10 {
            let (centre, radius) = (scale * 2.0 * random.vector(), scale * (0.1 + 0.4 * random.next()));
            let receiver = loop {
                let position = scale * 2.0 * random.vector();
                if position.distance(centre) > 1.1 * radius {
                    break Receiver { normal: (centre - position).normalize(), ..up(position) };
                }
            };
            let of = |sides| blocked(&receiver, &only_triangles(ball(centre, radius, sides)));
            let [front, back, all] = [by(0.0, NEVER), by(NEVER, 0.0), by(0.0, 0.0)].map(of);
            assert!(front == back && back == all, "{centre} {radius} {receiver:?}");
            let sphere = |radius: f32| {
                let one = spheres(vec![centre.extend(radius).to_array()]);
                blocked(&receiver, &only_spheres(vec![one]))
            };
            // The ball of triangles has its corners on the sphere, and its faces at most 0.2 % within.
            let [within, around] = [0.998 * radius, 1.0001 * radius].map(sphere);
            for row in 0..192 {
                assert_eq!(within[row] & !all[row], 0, "row {row} of what is surely inside");
                assert_eq!(all[row] & !around[row], 0, "row {row} of what is surely outside");
            }
        }
    }
}

#[test]
fn who_is_blocked_by_meshes() {
    let error = 0.05;
    // As a closed mesh casts: on its own receivers by what faces them, on others by what turns away.
    let closed = [Sides { above: error, below: NEVER }, Sides { above: NEVER, below: 1e-6 }];
    let at = |position: Vec3, object: u32| Receiver { object, ..up(position) };
    let casters = only_triangles(ball(Vec3::ZERO, 1.0, closed));
    let inside = blocked(&at(Vec3::ZERO, 0), &casters);
    let is_above = |texel: &usize| {
        let at = |k: usize| (k % 32) as f64 + 0.5;
        cubemap::direction(texel / 1024, 32, at(*texel), at(texel / 32)).y > 0.0
    };
    let mut above = (0..TEXELS).filter(is_above);
    assert!(above.all(|texel| is_blocked(&inside, texel)), "inside of another object all is dark");
    assert_eq!(blocked(&at(Vec3::ZERO, 1), &casters), [0; 192], "inside of its own nothing is");
    let below = Vec3::new(0.3, -2.0, 0.2);
    assert_eq!(blocked(&at(below, 0), &casters), blocked(&at(below, 1), &casters), "outside both see it");
    assert_eq!(blocked(&at(Vec3::new(0.0, 1.01, 0.0), 1), &casters), [0; 192], "on top nothing is above");
    // A sheet blocks from both sides, but not who lies in it, and within its error not its own.
    let both = |height| Sides { above: height, below: height };
    let [a, b, c] = [Vec3::new(-9.0, 1.0, -9.0), Vec3::new(9.0, 1.0, -9.0), Vec3::new(0.0, 1.0, 9.0)];
    for corners in [[a, b, c], [a, c, b]] {
        let sheet = only_triangles(vec![triangle(corners, [both(error), both(1e-6)])]);
        let is_dark = |y: f32, normal: Vec3, object: u32| {
            let receiver = Receiver { normal, ..at(Vec3::new(0.1, y, 0.3), object) };
            blocked(&receiver, &sheet) != [0; 192]
        };
        for object in [0, 1] {
            assert!(is_dark(0.9, Vec3::Y, object) && is_dark(1.1, Vec3::NEG_Y, object), "from both sides");
            assert!(
                !is_dark(1.1, Vec3::Y, object) && !is_dark(0.9, Vec3::NEG_Y, object),
                "what is behind counts not"
            );
            assert!(!is_dark(1.0, Vec3::Y, object) && !is_dark(1.0, Vec3::NEG_Y, object), "in its plane");
        }
        assert!(
            is_dark(0.96, Vec3::Y, 0) && !is_dark(0.96, Vec3::Y, 1),
            "within the error of its own object"
        );
    }
    // A line has no plane.
    let line = triangle([Vec3::Y, 2.0 * Vec3::Y, 3.0 * Vec3::Y], [both(0.0), both(0.0)]);
    assert_eq!(blocked(&at(Vec3::ZERO, 0), &only_triangles(vec![line])), [0; 192]);
}
