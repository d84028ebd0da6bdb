//! Volumes of balls outside solids against closed forms, sampling and differences.

use super::ball::Ball;
use super::test_meshes::{cuboid, torus, tree};
use glam::DVec3;
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
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
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
        let difference = |a: Ball, b: Ball| (a.outside(&mesh).volume - b.outside(&mesh).volume) / (2.0 * step);
        let area = difference(Ball::new(centre, ball.radius + step), Ball::new(centre, ball.radius - step));
        assert!((area - outside.area).abs() < 1e-3, "{ball:?}: area {area} {}", outside.area);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = difference(Ball::new(centre + axis * step, ball.radius), Ball::new(centre - axis * step, ball.radius));
            assert!((slope - outside.gradient.dot(axis)).abs() < 1e-3, "{ball:?}: {axis} {slope} {}", outside.gradient);
        }
    }
}
