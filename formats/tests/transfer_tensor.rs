//! Kind `transfer-tensor` and what it means.

use crate::support::raw_file::RawFile;
use crate::support::reading::refusal;
use crate::support::received::{sources, tensors};
use crate::support::samples::Random;
use crate::support::tensors::tensor;
use glam::Vec3;
use half::f16;
use relume_formats::Place;
use relume_formats::basis::{EquirectMap, haar, hemisphere, sh};
use relume_formats::bundle::expect_spaces;
use relume_formats::container::{Kind, Stored};
use relume_formats::evaluate::transfer_tensor::{
    Lights, Lobes, Parts, Received, cone_points, harmonic_weights, widths,
};
use relume_formats::kinds::brdf_tensor::Cone;
use relume_formats::kinds::scene::{EnvironmentLook, Meta, StoredMaterial, StoredObject};
use relume_formats::kinds::transfer_tensor::{FACE_SIZE, ONCE_FACE_SIZE, TWICE_FACE_SIZE, weights};
use relume_formats::kinds::{BrdfTensor, StoredScene, TransferTensor};
use relume_formats::state::{BlinnPhong, Brdf, Model};
use std::f32::consts::{FRAC_PI_2, PI};

fn grey(radiance: f32) -> EquirectMap {
    EquirectMap { width: 64, height: 32, texels: vec![[radiance, 0.5 * radiance, 0.0]; 64 * 32] }
}

fn look() -> EnvironmentLook {
    EnvironmentLook { map: String::new(), gain: [2.0, 1.0, 1.0], rotation_deg: 40.0 }
}

fn material() -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd: [0.5; 3], ks: [0.25, 0.5, 1.0], shininess: 20.0 })
}

/// Three vertices of one material that face up, and are seen from above.
fn scene() -> StoredScene {
    let mut meta = crate::support::scenes::scene(1).meta;
    let (name, brdf) = ("m".to_owned(), material());
    let sharpest = brdf.model().usual_sharpest();
    let stored = StoredMaterial { name, brdf, varies: true, textured: false, sharpest };
    meta = Meta {
        materials: vec![stored],
        objects: vec![StoredObject { name: "o".to_owned(), material: 0, triangles: 1 }],
        shapes: Vec::new(),
        ..meta
    };
    StoredScene {
        meta,
        positions: vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        normals: vec![[0.0, 1.0, 0.0]; 3],
        triangles: vec![[0, 1, 2]],
    }
}

/// What a space reflects of a light of radiance 1 from everywhere, towards `outgoing`: the residual by a sum over the
/// hemisphere, cones by the part of their points above it.
fn reflected(space: &BrdfTensor, lobes: &Lobes, outgoing: Vec3, channel: usize) -> f64 {
    let steps = 400;
    let mut sum = 0.0;
    for step in 0..steps * steps {
        let [down, around] = [step / steps, step % steps].map(|at| (at as f32 + 0.5) / steps as f32);
        let (sin, cos) = (FRAC_PI_2 * down).sin_cos();
        let phi = 2.0 * PI * around;
        let incoming = Vec3::new(sin * phi.cos(), sin * phi.sin(), cos);
        let solid_angle = FRAC_PI_2 * 2.0 * PI * sin / (steps * steps) as f32;
        sum += f64::from(space.residual(&lobes.profiles[channel], outgoing, incoming) * cos * solid_angle);
    }
    let shares = BrdfTensor::seen_from(&lobes.cones[channel], outgoing);
    for (cone, share) in space.cones.iter().zip(shares) {
        for direction in cone.directions(outgoing) {
            let points: Vec<Vec3> = cone_points(direction, cone.width_deg).map(|(point, _)| point).collect();
            let above = points.iter().filter(|point| point.z > 0.0).count() as f32;
            sum += f64::from(share / cone.count() as f32 * above / points.len() as f32);
        }
    }
    sum
}

/// A white sky over an open surface, once as direct light and once as what other surfaces reflect: what is shown is what the
/// space reflects of it, and the diffuse function all of it.
#[test]
fn a_white_sky_shows_what_a_space_reflects() {
    let mut space = tensor(5, Model::BlinnPhong, [2, 3, 4]);
    space.even.fill(0.75);
    space.shares.iter_mut().for_each(|share| *share *= 2.0);
    let (scene, lobes) = (scene(), Lobes::new(&space, &material()).unwrap());
    let weights = harmonic_weights(&space);
    let columns = space.columns();
    // ∫ column · cosine over the hemisphere: harmonic weights of light that is even.
    let even: Vec<f32> = (0..columns).map(|k| weights.iter().skip(k).step_by(columns).sum()).collect();
    assert!((even[0] - 1.0).abs() < 1e-4, "the diffuse function reflects all: {}", even[0]);
    let mut transfer = tensors(1, 3, columns, &[1], 1);
    transfer.seen.fill(255);
    let spaces = [space];
    let parts = Parts { scene: &scene, spaces: &spaces, bases: &[], transfer: &transfer };
    let lights = Lights::new(&grey(3.0), &look(), &widths(&spaces));
    let sky = [6.0, 1.5, 0.0];
    let dark = [0.0; 3];
    let mut harmonics = [[0.0; 3]; sh::COUNT];
    harmonics[0] = sky.map(|radiance| radiance / sh::evaluate(Vec3::Z)[0]);
    let none = Lights { gain: [0.0; 3], ..lights.clone() };
    let direct = even.iter().map(|value| sky.map(|radiance| value * radiance)).collect::<Vec<_>>().repeat(3);
    let cases = [
        (Received { direct, once: vec![[[0.0; 3]; 16]; 3], twice: vec![dark; 3] }, &lights),
        (
            Received { direct: vec![dark; 3 * columns], once: vec![[[0.0; 3]; 16]; 3], twice: vec![sky; 3] },
            &none,
        ),
        (Received { direct: vec![dark; 3 * columns], once: vec![harmonics; 3], twice: vec![dark; 3] }, &none),
    ];
    for eye in [[0.0, 5.0, 0.0], [3.0, 4.0, 1.0], [-4.0, 1.0, 2.0]] {
        // The frame of a vertex that faces up.
        let way = Vec3::from(eye).normalize();
        let (tangent, bitangent) = Vec3::Y.any_orthonormal_pair();
        let outgoing = Vec3::new(way.dot(tangent), way.dot(bitangent), way.y);
        for (number, (received, lights)) in cases.iter().enumerate() {
            let shown = parts.shown(received, lights, &[material()], eye).swap_remove(0);
            let mirrored = parts.mirrored(lights, &material(), Vec3::Y, way, &shown.seen);
            for c in 0..3 {
                assert!(
                    (shown.diffuse[c] - 0.75 * sky[c]).abs() < 1e-3 * sky[c] + 1e-6,
                    "{number} {shown:?}"
                );
                let expected = reflected(&parts.spaces[0], &lobes, outgoing, c) as f32 * sky[c];
                // Harmonics tell a cone all of its light, what is below the surface included, for light that is even there.
                let below =
                    if number == 2 { below(&parts.spaces[0], &lobes, outgoing, c) * sky[c] } else { 0.0 };
                let off = (shown.glossy[c] + mirrored[c] - (expected + below)).abs();
                assert!(
                    off < 4e-3 * sky[c] + 1e-5,
                    "{eye:?} {number} {c}: {} {expected} {below}",
                    shown.glossy[c]
                );
            }
        }
    }
}

/// What cones would reflect of what is below the surface.
fn below(space: &BrdfTensor, lobes: &Lobes, outgoing: Vec3, channel: usize) -> f32 {
    let shares = BrdfTensor::seen_from(&lobes.cones[channel], outgoing);
    let of_cone = |(cone, share): (&Cone, f32)| {
        let below = |direction: Vec3| {
            let points: Vec<Vec3> = cone_points(direction, cone.width_deg).map(|(point, _)| point).collect();
            points.iter().filter(|point| point.z <= 0.0).count() as f32 / points.len() as f32
        };
        share / cone.count() as f32 * cone.directions(outgoing).map(below).sum::<f32>()
    };
    space.cones.iter().zip(shares).map(of_cone).sum()
}

/// Direct light, and light reflected once and twice, added up a second time in double precision and another order.
#[test]
fn what_vertices_receive_is_the_sum_of_all_terms() {
    let transfer = tensors(7, 5, 4, &[2, 3], 3);
    let random = &mut Random(3);
    let mut plane = || (0..6 * FACE_SIZE * FACE_SIZE).map(|_| random.signed()).collect::<Vec<f32>>();
    let mut planes = || [plane(), plane(), plane()];
    let (rest, whole) = (planes(), planes());
    let lights = Lights { rest, whole, blurred: Vec::new(), rotation_deg: 0.0, gain: [1.0; 3] };
    let coefficients = vec![[0.3, 0.5, 0.7], [1.0, -0.2, 0.4]];
    let received = relume_formats::evaluate::transfer_tensor::received(&transfer, &lights, |_| {
        Some(coefficients.clone())
    });
    let of_sources = weights(&sources(), |_| Some(coefficients.clone()));
    assert_eq!(of_sources[1], coefficients[1]);
    assert_eq!(of_sources[3], [0.0, 1.0, 0.0]);
    for vertex in 0..5 {
        for c in 0..3 {
            let close = |found: f32, exact: f64| {
                assert!(
                    (f64::from(found) - exact).abs() < 1e-3 * (1.0 + exact.abs()),
                    "{vertex} {c}: {found} {exact}"
                );
            };
            for column in 0..4 {
                close(
                    received.direct[vertex * 4 + column][c],
                    direct(&transfer, &lights, [vertex, column, c]),
                );
            }
            for s in [0, 7, 15] {
                close(received.once[vertex][s][c], once(&transfer, &lights, &of_sources, [vertex, s, c]));
            }
            close(received.twice[vertex][c], twice(&transfer, &lights, &of_sources, [vertex, c]));
        }
    }
}

fn direct(transfer: &TransferTensor, lights: &Lights, [vertex, column, c]: [usize; 3]) -> f64 {
    let of_block = |(block, terms): (&relume_formats::kinds::transfer_tensor::Block, &u32)| -> f64 {
        let term = |term: usize| {
            let index = block.indices[term * 5 + vertex];
            let step = block.scales[vertex * 4 + column].to_f64() / 1024.0;
            step * f64::from(block.steps[(term * 5 + vertex) * 4 + column])
                * f64::from(lights.rest[c][index as usize])
        };
        (0..*terms as usize).map(term).sum()
    };
    transfer.blocks.iter().zip(&transfer.meta.blocks).map(of_block).sum()
}

/// Coefficient number `index` of a light of faces of `side` texels a side, by those texels' means.
fn coarse(light: &[f32], side: usize, index: usize) -> f64 {
    let face = index / (side * side);
    let mut texels: Vec<f64> = light[face * 4096..][..4096].iter().copied().map(f64::from).collect();
    haar::inverse(&mut texels, FACE_SIZE, &mut Vec::new());
    let square = FACE_SIZE / side;
    let mean = |texel: usize| -> f64 {
        let at =
            |k: usize| (texel / side * square + k / square) * FACE_SIZE + texel % side * square + k % square;
        (0..square * square).map(|k| texels[at(k)]).sum::<f64>() / (square * square) as f64
    };
    let mut means: Vec<f64> = (0..side * side).map(mean).collect();
    haar::forward(&mut means, side, &mut Vec::new());
    means[index % (side * side)]
}

fn once(transfer: &TransferTensor, lights: &Lights, weights: &[[f32; 3]], [vertex, s, c]: [usize; 3]) -> f64 {
    let (once, [m, n], sources) = (transfer.once.as_ref().unwrap(), [3, 2], weights.len());
    let cluster = usize::from(once.clusters[vertex]);
    let light: Vec<f64> = (0..384).map(|index| coarse(&lights.whole[c], ONCE_FACE_SIZE, index)).collect();
    let mut sum = 0.0;
    for (source, weight) in weights.iter().enumerate() {
        for j in 0..n {
            let row = &once.light[((cluster * sources + source) * n + j) * 384..][..384];
            let lit: f64 = row.iter().zip(&light).map(|(a, b)| a.to_f64() * b).sum();
            for i in 0..m {
                let share = f64::from(once.shares[(vertex * sources + source) * m + i]) / 127.0;
                let core = once.core[(((cluster * sources + source) * m + i) * n + j) * 16 + s].to_f64();
                sum += f64::from(weight[c]) * share * core * lit;
            }
        }
    }
    sum
}

fn twice(transfer: &TransferTensor, lights: &Lights, weights: &[[f32; 3]], [vertex, c]: [usize; 2]) -> f64 {
    let (twice, pairs) = (transfer.twice.as_ref().unwrap(), transfer.meta.pairs());
    // Of five sources, the fixed ones meet only themselves and the others.
    assert_eq!(pairs.len(), 2 * 5 + 3 * 3);
    let cluster = usize::from(transfer.once.as_ref().unwrap().clusters[vertex]);
    let light: Vec<f64> = (0..24).map(|index| coarse(&lights.whole[c], TWICE_FACE_SIZE, index)).collect();
    let mut sum = 0.0;
    for vector in 0..2 {
        let share = f64::from(twice.shares[vertex * 2 + vector]) / 127.0;
        for (l, light) in light.iter().enumerate() {
            for (number, [a, b]) in pairs.iter().enumerate() {
                let value = twice.vectors[((cluster * 2 + vector) * 24 + l) * pairs.len() + number].to_f64();
                sum += share * value * light * f64::from(weights[*a][c]) * f64::from(weights[*b][c]);
            }
        }
    }
    sum
}

/// BRDF tensors are tabulated for lobes no sharper than usual.
#[test]
fn materials_go_no_farther_than_the_tensors() {
    let (mut scene, meta) = (scene().meta, tensors(3, 4, 2, &[2], 3).meta);
    for (sharpest, expected) in
        [(201.0, "material `m` goes up to 201, the BRDF tensors before it to 200"), (200.0, "no BRDF tensor")]
    {
        scene.materials[0].sharpest = sharpest;
        let message = expect_spaces(&meta, &[], &[], &scene, &Place::file("t")).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

/// Beyond the edge of a light, of a table or of what there is.
#[test]
fn broken_tensors_are_refused() {
    let sound = tensors(3, 4, 2, &[2], 3);
    let refused = |broken: &dyn Fn(&mut TransferTensor), expected: &str| {
        let mut transfer = sound.clone();
        broken(&mut transfer);
        // Nothing is written that no reader would accept.
        let message = match transfer.to_bytes(Place::file("x")) {
            Err(refused) => refused.to_string(),
            Ok(bytes) => refusal(Kind::TransferTensor, &bytes).to_string(),
        };
        assert!(message.contains(expected), "`{message}` has no `{expected}`");
    };
    refused(
        &|t| t.blocks[0].indices[1] = 24_576,
        "section `index/0000`: an index is beyond the light's coefficients",
    );
    refused(
        &|t| t.blocks[0].scales[3] = f16::NEG_INFINITY,
        "section `scale/0000`: the values of element 3 reach",
    );
    refused(&|t| t.once.as_mut().unwrap().clusters[2] = 2, "vertex 2 is of a cluster that is not there");
    refused(
        &|t| t.once.as_mut().unwrap().core[0] = f16::NAN,
        "section `core`: element 0 is not a finite number",
    );
    refused(&|t| t.twice.as_mut().unwrap().vectors[1] = f16::INFINITY, "section `twice`: element 1 is not a");
    refused(&|t| t.meta.reflections = 4, "section `meta`: 4 reflections");
    refused(&|t| t.meta.unit = 0.0, "section `meta`: 2 columns in units of 0");
    let without_vectors = |t: &mut TransferTensor| (t.meta.vectors, t.twice) = (0, None);
    refused(&without_vectors, "do not go together");
    refused(&|t| t.meta.sources[2].basis = 1, "is no source of reflected light");
    let bytes = sound.to_bytes(Place::file("x")).unwrap();
    let raw = RawFile::parse(&bytes);
    let seen = raw.sections.iter().position(|section| section.name == "seen").unwrap();
    assert_eq!((seen, sound.seen.len()), (4, 4 * hemisphere::TEXELS), "behind the first block");
}
