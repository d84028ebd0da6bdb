//! Small shapes that deform, made from a seed.

use super::samples::Random;
use glam::{DAffine3, DVec3};
use relume_formats::shape::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, MorphTarget, Node, Property, Track, Transform,
};

fn vector<const N: usize>(random: &mut Random) -> [f32; N] {
    [(); N].map(|()| random.signed())
}

fn map(random: &mut Random) -> DAffine3 {
    let [x, y, z] = vector(random).map(f64::from);
    DAffine3::from_axis_angle(DVec3::Y, x) * DAffine3::from_translation(DVec3::new(x, y, z / 3.0))
}

/// A node of every kind: one that clips move, one fixed, and their children.
fn nodes(random: &mut Random) -> Vec<Node> {
    let mut parts = |parent| Node {
        parent,
        rest: Transform::Parts {
            translation: vector(random),
            rotation: [0.6, 0.0, random.signed(), 0.8],
            scale: [1.0, 2.0, -0.5],
        },
    };
    let (first, second) = (parts(None), parts(Some(0)));
    vec![
        first,
        second,
        Node { parent: Some(1), rest: Transform::Fixed(map(random)) },
        Node { parent: None, rest: Transform::Fixed(DAffine3::IDENTITY) },
    ]
}

fn influences(random: &mut Random, joints: usize) -> Influences {
    let share = random.unit();
    let weights = [1.0 - share, share, 0.0, 0.0];
    // What has no weight may name anything.
    Influences { joints: [random.below(joints) as u32, random.below(joints) as u32, u32::MAX, 77], weights }
}

fn track(random: &mut Random, property: Property, interpolation: Interpolation, keys: usize) -> Track {
    let count = keys * property.components() * interpolation.values_per_key();
    let values = (0..count).map(|_| random.signed() + 0.01).collect();
    Track {
        property,
        interpolation,
        times_s: (0..keys).map(|k| k as f32 * 0.5 + 0.4 * random.unit()).collect(),
        values,
    }
}

/// Three clips: of every property and interpolation, of one key, and of none.
fn clips(random: &mut Random) -> Vec<Clip> {
    use Interpolation::{CubicSpline, Linear, Step};
    let mut track = |property, interpolation, keys| track(random, property, interpolation, keys);
    let tracks = vec![
        track(Property::Rotation(0), CubicSpline, 3),
        track(Property::Translation(1), Linear, 4),
        track(Property::Scale(1), Step, 2),
        track(Property::MorphWeight(1), CubicSpline, 2),
    ];
    let still = track(Property::Rotation(1), Linear, 1);
    vec![
        Clip { name: "Läufer".to_owned(), duration_s: 2.5, tracks },
        Clip { name: "still".to_owned(), duration_s: 1.0, tracks: vec![still] },
        Clip { name: String::new(), duration_s: 0.0, tracks: Vec::new() },
    ]
}

/// With `vertices` vertices, four joints and three morph targets, one of which moves nothing.
pub fn shape(seed: u64, vertices: usize) -> DeformingMesh {
    let random = &mut Random(seed);
    let mut target = |vertices: Vec<u32>| MorphTarget {
        rest_weight: random.signed(),
        deltas: vertices.iter().map(|_| vector(random)).collect(),
        vertices,
    };
    let vertex_numbers = || 0..vertices as u32;
    let morph_targets = vec![
        target(vertex_numbers().step_by(2).collect()),
        target(Vec::new()),
        target(vertex_numbers().skip(1).collect()),
    ];
    DeformingMesh {
        positions: (0..vertices).map(|_| vector(random)).collect(),
        influences: (0..vertices).map(|_| influences(random, 4)).collect(),
        joints: (0..4).map(|node| Joint { node, node_from_mesh: map(random) }).collect(),
        nodes: nodes(random),
        morph_targets,
        clips: clips(random),
    }
}
