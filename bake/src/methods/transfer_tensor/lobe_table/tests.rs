use super::*;
use crate::brdf::basis;
use crate::methods::transfer_tensor::{BASES, FACE_SIZE};
use crate::trace::sampler::PixelSampler;
use relume_formats::state::Model;
use std::f32::consts::TAU;

/// Points along a side of a texel, as many as visibility is found for.
const SIDE: usize = FINE / FACE_SIZE;

/// Directions in the texels of the light, with their solid angles: [texels, points].
pub fn points() -> Vec<Vec<(Vec3A, f32)>> {
    let n = FACE_SIZE;
    let of_face = solid_angles(FINE);
    let point = |texel: usize, k: usize| {
        let (row, x) = (texel / n, texel % n);
        let (face, x, y) = (row / n, x * SIDE + k % SIDE, row % n * SIDE + k / SIDE);
        let towards = direction(face, FINE, x as f64 + 0.5, y as f64 + 0.5).as_vec3a();
        (towards, of_face[y * FINE + x] as f32)
    };
    (0..FACES * n * n).map(|texel| (0..SIDE * SIDE).map(|k| point(texel, k)).collect()).collect()
}

/// Means of `functions` over points of a texel above the horizon, weighted with the cosine, and what arrives
/// at them of white light.
pub fn exact(
    functions: &Functions,
    points: &[(Vec3A, f32)],
    normal: Vec3A,
    outgoing: Vec3A,
) -> ([f32; MOST], f32) {
    let (mut sums, mut total) = ([0.0; MOST], 0.0);
    for (incoming, solid_angle) in points {
        let weight = incoming.dot(normal) * solid_angle;
        if weight > 0.0 {
            let values = functions.evaluate(&angles(*incoming, outgoing, normal));
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            total += weight;
        }
    }
    (if total > 0.0 { sums.map(|sum| sum / total) } else { sums }, total)
}

/// Some unit direction above `normal`, at most `most_deg` from it.
fn above(normal: Vec3A, most_deg: f32, [u, v]: [f32; 2]) -> Vec3A {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let cos = 1.0 - v * (1.0 - most_deg.to_radians().cos());
    let (sin, phi) = ((1.0 - cos * cos).sqrt(), TAU * u);
    normal * cos + (tangent * phi.cos() + bitangent * phi.sin()) * sin
}

/// What is reflected of white light from every texel, by the table and exactly: [functions, texels] of each.
fn reflected(
    (functions, table, discs): (&Functions, &LobeTable, &Discs),
    points: &[Vec<(Vec3A, f32)>],
    normal: Vec3A,
    outgoing: Vec3A,
) -> [Vec<f32>; 2] {
    let texels = points.len();
    let mut both = [vec![0.0; MOST * texels], vec![0.0; MOST * texels]];
    let mut lit = Vec::new();
    for (texel, points) in points.iter().enumerate() {
        let (means, arriving) = exact(functions, points, normal, outgoing);
        if arriving > 0.0 {
            lit.push(discs.lit((texel as u16, arriving), normal));
            (0..MOST).for_each(|k| both[1][k * texels + texel] = means[k] * arriving);
        }
    }
    table.add(in_frame(normal, outgoing), &lit, 1.0, &mut both[0], texels);
    both
}

fn norm(values: impl Iterator<Item = f32>) -> f64 {
    values.map(|x| f64::from(x).powi(2)).sum::<f64>().sqrt()
}

/// Lobes of all sharpnesses: what each reflects from every texel, as a norm over texels in parts of the
/// lobe's own, and what it reflects of a white sky. A texel is no disc and nodes are 2.8° apart, so that
/// lobes as sharp as they may be, 8° across, err by some per cent from texel to texel. Discs neither cover
/// the sky evenly nor twice: what a lobe reflects of it depends on where among texels it is, ever more as it
/// narrows towards the horizon, to 3° across at 70° and 1.4° at 80°, a tenth of a texel. In the mean over
/// places it stays.
#[test]
fn lobes_are_near_their_means_and_keep_their_energy() {
    let points = points();
    let discs = Discs::new(FACE_SIZE);
    let lobes = [
        Functions::BlinnPhong(1.0),
        Functions::BlinnPhong(20.0),
        Functions::BlinnPhong(200.0),
        Functions::Ggx(0.32),
        Functions::Ggx(0.7),
        Functions::CookTorrance(0.3, 0.1),
        Functions::CookTorrance(0.3, 0.5),
    ];
    let mut failed = false;
    for functions in lobes {
        let table = LobeTable::new(&functions, &discs);
        for (most_deg, bound, of_energy) in [(50.0, 0.03, 0.03), (85.0, 0.06, 0.2)] {
            let (mut mean, mut worst, mut worst_energy, mut mean_energy) = (0.0, 0.0f64, 0.0f64, 0.0);
            for number in 0..40 {
                let sample = PixelSampler::new(3, 7).sample(number);
                let normal = above(Vec3A::Z, 180.0, sample.pair(1));
                let outgoing = above(normal, most_deg, sample.pair(0));
                let [found, exact] = reflected((&functions, &table, &discs), &points, normal, outgoing);
                let off = norm(found.iter().zip(&exact).map(|(a, b)| a - b)) / norm(exact.iter().copied());
                let [a, b] = [found, exact].map(|all| all.iter().map(|x| f64::from(*x)).sum::<f64>());
                (mean, worst) = (mean + off / 40.0, worst.max(off));
                (mean_energy, worst_energy) =
                    (mean_energy + (a / b - 1.0) / 40.0, worst_energy.max((a / b - 1.0).abs()));
            }
            println!(
                "{functions:?} to {most_deg}°: mean {mean:.4}, worst {worst:.4}; energy {mean_energy:+.4}, \
                 worst {worst_energy:.4}"
            );
            failed |= mean > bound || worst_energy > of_energy || mean_energy.abs() > 0.1 * of_energy;
        }
    }
    assert!(!failed);
}

/// The functions of the bases of all models, which change their signs: errors in parts of all functions' norm.
#[test]
fn basis_functions_are_near_their_means() {
    let points = points();
    let discs = Discs::new(FACE_SIZE);
    for model in [Model::BlinnPhong, Model::Ggx, Model::CookTorrance] {
        let functions = Functions::of_basis(&basis::build(model, BASES, true).unwrap());
        let table = LobeTable::new(&functions, &discs);
        let mut mean = 0.0;
        for number in 0..20 {
            let sample = PixelSampler::new(3, 9).sample(number);
            let normal = above(Vec3A::Z, 180.0, sample.pair(1));
            let outgoing = above(normal, 80.0, sample.pair(0));
            let [found, exact] = reflected((&functions, &table, &discs), &points, normal, outgoing);
            mean += norm(found.iter().zip(&exact).map(|(a, b)| a - b)) / norm(exact.into_iter()) / 20.0;
        }
        println!("{model:?}: mean {mean:.4}");
        assert!(mean < 0.08, "{model:?}: {mean}");
    }
}

#[test]
fn places_of_azimuth_are_found_again() {
    for k in 0..=64 {
        let place = k as f32 / 64.0;
        let [cos, sin] = azimuth_at(place);
        assert!((cos * cos + sin * sin - 1.0).abs() < 1e-6);
        // Near the mirrored azimuth a cosine no longer tells places apart, nor need it.
        let off = azimuth_place(cos) / (AZIMUTHS - 1) as f32 - place;
        assert!(off.abs() < if k < 4 { 0.03 } else { 1e-3 }, "{place}: {off}");
    }
    assert_eq!((azimuth_place(1.0), azimuth_place(-1.0)), (0.0, (AZIMUTHS - 1) as f32));
}
