//! Volumes of balls outside solids against closed forms, sampling and differences.

use super::ball::Ball;
use super::test_meshes::{cuboid, icosphere, l_shape, random, thin_plate, torus, tree};
use super::triangle_tree::TriangleTree;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

#[test]
fn a_ball_at_a_cube_has_the_closed_forms() {
    let cube = tree(cuboid(DVec3::ZERO, DVec3::splat(4.0)));
    let whole = 4.0 / 3.0 * PI;
    for (centre, outside) in [
        (DVec3::splat(2.0), 0.0),
        (DVec3::new(2.0, 2.0, 4.0), 0.5),
        (DVec3::new(2.0, 4.0, 4.0), 0.75),
        (DVec3::splat(4.0), 0.875),
        (DVec3::splat(0.0), 0.875),
        (DVec3::new(2.0, 2.0, 7.0), 1.0),
    ] {
        let got = Ball::new(centre, 1.0).outside(&cube).volume;
        assert!((got - outside * whole).abs() < 1e-12, "{centre}: {got} {}", outside * whole);
    }
    // A cap of height 0.7.
    let got = Ball::new(DVec3::new(2.0, 2.0, 3.7), 1.0).outside(&cube).volume;
    let cap = PI * 0.7_f64.powi(2) * (3.0 - 0.7) / 3.0;
    assert!((got - cap).abs() < 1e-12);
    // All of it inside the ball.
    let got = Ball::new(DVec3::splat(2.1), 100.0).outside(&cube).volume;
    assert!((got / (whole * 1e6 - 64.0) - 1.0).abs() < 1e-14);
}

#[test]
fn balls_at_a_torus_agree_with_sampling_and_differences() {
    let mesh = tree(torus(1.0, 0.35, 48, 24));
    let mut random = random(1);
    for _ in 0..200 {
        let centre = DVec3::new(random() * 3.0 - 1.5, random() - 0.5, random() * 3.0 - 1.5);
        let ball = Ball::new(centre, 0.05 + random());
        let outside = ball.outside(&mesh);
        let samples = 4_000;
        let mut hits = 0;
        let mut drawn = 0;
        while drawn < samples {
            let p = DVec3::new(random(), random(), random()) * 2.0 - 1.0;
            if p.length_squared() <= 1.0 {
                drawn += 1;
                hits += u32::from(!mesh.encloses(centre + p * ball.radius));
            }
        }
        let share = f64::from(hits) / f64::from(samples);
        let sigma = (share * (1.0 - share) / f64::from(samples)).sqrt();
        let exact = outside.volume / ball.volume();
        assert!((exact - share).abs() < 5.0 * sigma + 1e-4, "{ball:?}: {exact} {share}");
        let step = 1e-5;
        let difference =
            |a: Ball, b: Ball| (a.outside(&mesh).volume - b.outside(&mesh).volume) / (2.0 * step);
        let area = difference(Ball::new(centre, ball.radius + step), Ball::new(centre, ball.radius - step));
        assert!((area - outside.area).abs() < 1e-3, "{ball:?}: area {area} {}", outside.area);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = difference(
                Ball::new(centre + axis * step, ball.radius),
                Ball::new(centre - axis * step, ball.radius),
            );
            assert!(
                (slope - outside.gradient.dot(axis)).abs() < 1e-3,
                "{ball:?}: {axis} {slope} {}",
                outside.gradient
            );
        }
    }
}

/// Asserts that volumes are those of spheres a hair smaller and larger: that nothing jumps where a sphere
/// passes just through a vertex or touches. The volume's slope is at most the sphere's area, and the two
/// sides bracket it.
fn assert_steady(mesh: &TriangleTree, ball: Ball, what: &str) {
    let hair = 1e-7 * ball.radius.max(1e-3);
    let at = |radius: f64| Ball::new(ball.centre, radius).outside(mesh);
    let (less, got, more) = (at(ball.radius - hair), ball.outside(mesh), at(ball.radius + hair));
    // Solid angles below a millionth may count as none or all, and arcs of touching spheres end within the
    // square root of rounding, 1e-7 in radii, for each of the triangles around; the volume hangs on a third
    // of these.
    let slack = 1e-5 * ball.radius.powi(3) / 3.0;
    assert!(
        got.volume >= less.volume - slack && got.volume <= more.volume + slack,
        "{what}: {ball:?}: {} {} {}",
        less.volume,
        got.volume,
        more.volume
    );
    let slope = (more.volume - less.volume) / (2.0 * hair);
    let area = 4.0 * PI * ball.radius * ball.radius;
    let noise = slack / hair;
    assert!(
        slope <= area * (1.0 + 1e-5) + noise && slope >= -noise,
        "{what}: {ball:?}: slope {slope} of {area}"
    );
    // The area outside is steady too, up to a sphere that slides along a face.
    let (low, high) = (less.area.min(more.area), less.area.max(more.area));
    let wide = 1e-3 * area;
    assert!(
        got.area >= low - wide && got.area <= high + wide,
        "{what}: {ball:?}: areas {low} {} {high}",
        got.area
    );
    assert!(got.gradient.is_finite());
}

fn solids() -> Vec<TriangleTree> {
    [torus(1.0, 0.35, 24, 12), icosphere(2), l_shape(), thin_plate(), cuboid(DVec3::ZERO, DVec3::ONE)]
        .into_iter()
        .map(tree)
        .collect()
}

#[test]
fn spheres_through_one_vertex_are_steady() {
    let mut random = random(21);
    for mesh in solids() {
        for _ in 0..400 {
            let centre = DVec3::new(random(), random(), random()) * 3.0 - 1.5;
            let vertex = mesh.vertices[(random() * mesh.vertices.len() as f64) as usize];
            assert_steady(&mesh, Ball::new(centre, centre.distance(vertex)), "one vertex");
        }
    }
}

#[test]
fn spheres_through_two_to_four_vertices_are_steady() {
    let mut random = random(22);
    for mesh in solids() {
        for case in 0..600 {
            let mut pick = || mesh.vertices[(random() * mesh.vertices.len() as f64) as usize];
            let [a, b, c, d] = [pick(), pick(), pick(), pick()];
            let rows = DMat3::from_cols(b - a, c - a, d - a).transpose();
            let squares =
                DVec3::new((b - a).length_squared(), (c - a).length_squared(), (d - a).length_squared());
            let normal = (b - a).cross(c - a);
            let centre = match case % 3 {
                0 => a.midpoint(b),
                1 => {
                    a + (squares.x * (c - a).cross(normal) + squares.y * normal.cross(b - a))
                        / (2.0 * normal.length_squared())
                }
                _ => a + rows.inverse() * squares / 2.0,
            };
            if centre.is_finite() && centre.length() < 20.0 && centre.distance(a) > 1e-3 {
                assert_steady(&mesh, Ball::new(centre, centre.distance(a)), "several vertices");
            }
        }
    }
}

#[test]
fn spheres_through_a_triangle_s_own_vertices_are_steady() {
    for mesh in solids() {
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let normal = (b - a).cross(c - a);
            let flat = (b - a).length_squared() * (c - a).cross(normal)
                + (c - a).length_squared() * normal.cross(b - a);
            let centre = a + flat / (2.0 * normal.length_squared());
            for shift in [0.0, 0.2, -0.7] {
                let centre = centre + shift * normal.normalize();
                assert_steady(&mesh, Ball::new(centre, centre.distance(a)), "a triangle's circle");
            }
        }
    }
}

#[test]
fn spheres_about_vertices_and_points_of_edges_and_faces_are_steady() {
    for mesh in solids() {
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            for (centre, through) in [(a, b), (a.midpoint(b), a), (a.midpoint(b), c), ((a + b + c) / 3.0, a)]
            {
                assert_steady(&mesh, Ball::new(centre, centre.distance(through)), "on the surface");
                assert_steady(&mesh, Ball::new(centre, 0.1), "on the surface");
            }
        }
    }
}

#[test]
fn spheres_that_touch_edges_and_faces_are_steady() {
    for mesh in solids() {
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let normal = mesh.planes[t].0;
            for (point, away) in [
                ((a + b + c) / 3.0, normal),
                (a.midpoint(b), normal),
                (a, normal),
                (a.midpoint(b), (a + b + c).normalize_or_zero()),
            ] {
                for radius in [0.25, -0.25, 0.05, -0.05] {
                    let centre = point + away * radius;
                    assert_steady(&mesh, Ball::new(centre, centre.distance(point)), "touching");
                }
            }
        }
    }
}

#[test]
fn a_ball_that_just_holds_the_mesh_has_all_of_it() {
    let volume = |mesh: &TriangleTree| mesh.nodes[0].moment / 3.0;
    for mesh in solids() {
        for centre in [DVec3::ZERO, DVec3::splat(0.5), DVec3::new(0.3, -2.0, 0.1)] {
            let radius = mesh.vertices.iter().map(|v| v.distance(centre)).fold(0.0, f64::max);
            let ball = Ball::new(centre, radius);
            let outside = ball.outside(&mesh);
            assert!(
                (outside.volume - (ball.volume() - volume(&mesh))).abs() < 1e-11 * ball.volume(),
                "{ball:?} {outside:?}"
            );
            assert!(
                (outside.area / (4.0 * PI * radius * radius) - 1.0).abs() < 1e-9
                    && outside.gradient.length() < 1e-9
            );
        }
    }
    // The circumsphere of a cube, through all its vertices at once.
    let cube = tree(cuboid(-DVec3::ONE, DVec3::ONE));
    let ball = Ball::new(DVec3::ZERO, 3.0_f64.sqrt());
    assert!((ball.outside(&cube).volume - (ball.volume() - 8.0)).abs() < 1e-12);
    // Touches all faces from within; touches all edges.
    assert!(Ball::new(DVec3::ZERO, 1.0).outside(&cube).volume < 1e-12);
    let edges = 2.0_f64.sqrt();
    let cap = PI * (edges - 1.0).powi(2) * (3.0 * edges - (edges - 1.0)) / 3.0;
    assert!((Ball::new(DVec3::ZERO, edges).outside(&cube).volume - 6.0 * cap).abs() < 1e-12);
}
