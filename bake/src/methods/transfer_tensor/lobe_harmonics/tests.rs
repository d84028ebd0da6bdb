use super::*;
use crate::trace::sampler::PixelSampler;
use std::f32::consts::TAU;

/// Against sums over many directions in the world, for surfaces and outgoing directions of any turn. Nodes of
/// the outgoing angle are 2.8° apart: harmonics of the third band change by (3·0.05)²/8 = 0.3 % of themselves
/// between, and where the horizon cuts off a lobe of 8° what is left of it by up to (2.8/8)²/8 = 1.5 %.
#[test]
fn harmonics_are_those_of_the_lobe_in_the_world() {
    let turns = Turns::new().unwrap();
    let all = [
        Functions::BlinnPhong(200.0),
        Functions::BlinnPhong(3.0),
        Functions::Ggx(0.4),
        Functions::CookTorrance(0.2, 0.2),
    ];
    for functions in all {
        let table = LobeHarmonics::new(&functions);
        let mut worst = [0.0f64; 2];
        for number in 0..12 {
            let sample = PixelSampler::new(3, 7).sample(number);
            let [u, v] = sample.pair(0);
            let (sin, phi) = ((4.0 * v * (1.0 - v)).sqrt(), TAU * u);
            let normal = Vec3A::new(sin * phi.cos(), sin * phi.sin(), 1.0 - 2.0 * v);
            let (tangent, bitangent) = normal.any_orthonormal_pair();
            let [u, v] = sample.pair(1);
            let (cos, phi) = (0.1 + 0.9 * v, TAU * u);
            let outgoing =
                normal * cos + (tangent * phi.cos() + bitangent * phi.sin()) * (1.0 - cos * cos).sqrt();
            let towards = table.towards(in_frame(normal, outgoing));
            let turn = turns.to_world(normal);
            let mut exact = [[0.0f64; sh::COUNT]; MOST];
            let points = 1 << 16;
            for k in 0..points {
                let [u, cos] = PixelSampler::new(5, number).sample(k).pair(0);
                let phi = TAU * u;
                let incoming =
                    normal * cos + (tangent * phi.cos() + bitangent * phi.sin()) * (1.0 - cos * cos).sqrt();
                let values = functions.evaluate(&angles(incoming, outgoing, normal));
                let y = sh::evaluate(incoming.into());
                for (sums, value) in exact.iter_mut().zip(values) {
                    let weight = f64::from(value * cos * TAU) / f64::from(points);
                    sums.iter_mut().zip(y).for_each(|(sum, y)| *sum += weight * f64::from(y));
                }
            }
            // In parts of all functions: some are next to nothing, and change fast, near the normal.
            let (mut off, mut norm) = (0.0, 0.0);
            for (exact, towards) in exact.iter().zip(&towards).take(functions.count()) {
                let found = turned(&turn, towards);
                norm += exact.iter().map(|x| x * x).sum::<f64>();
                off += exact.iter().zip(found).map(|(a, b)| (a - f64::from(b)).powi(2)).sum::<f64>();
            }
            let worst = &mut worst[usize::from(cos < 0.5)];
            *worst = worst.max((off / norm).sqrt());
        }
        println!("{functions:?}: worst {worst:.5?}");
        assert!(worst[0] < 0.004 && worst[1] < 0.016, "{functions:?}: {worst:?}");
    }
}

#[test]
fn turns_give_the_same_function() {
    let turns = Turns::new().unwrap();
    let own: Harmonics = std::array::from_fn(|k| ((k * 7) % 5) as f32 - 1.5);
    for normal in [Vec3A::Z, Vec3A::new(0.36, 0.48, 0.8), Vec3A::new(-0.6, 0.0, -0.8)] {
        let world = turned(&turns.to_world(normal), &own);
        for direction in [Vec3A::X, Vec3A::new(0.0, 0.6, -0.8), Vec3A::new(0.48, -0.64, 0.6)] {
            let value = |harmonics: &Harmonics, at: Vec3A| -> f32 {
                sh::evaluate(at.into()).iter().zip(harmonics).map(|(y, c)| y * c).sum()
            };
            let [a, b] = [value(&world, direction), value(&own, in_frame(normal, direction))];
            assert!((a - b).abs() < 2e-5, "{normal} {direction}: {a} {b}");
        }
    }
}
