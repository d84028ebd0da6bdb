//! Small scenes and animations, made from a seed.

use super::samples::Random;
use relume_formats::display::Tonemap;
use relume_formats::kinds::StoredScene;
use relume_formats::kinds::scene::{
    EnvironmentLook, Meta, StoredClip, StoredMaterial, StoredObject, StoredShape,
};
use relume_formats::state::{Animation, Brdf, Camera, Track, TrackValues};

fn point(random: &mut Random) -> [f32; 3] {
    [(); 3].map(|()| random.signed() * 10.0)
}

fn material(random: &mut Random, index: usize) -> StoredMaterial {
    let (varies, textured) = (random.below(2) == 0, random.below(2) == 0);
    let brdf = match random.below(3) {
        0 => Brdf::BlinnPhong(random.blinn_phong()),
        1 => Brdf::CookTorrance(random.cook_torrance()),
        _ => {
            let mut ggx = random.ggx();
            if varies && textured {
                ggx.metallic = 0.0;
            }
            Brdf::Ggx(ggx)
        }
    };
    let sharpest = brdf.model().usual_sharpest();
    StoredMaterial { name: format!("m{index}"), brdf, varies, textured, sharpest }
}

fn shape(object: &StoredObject) -> StoredShape {
    let clip = |(name, duration_s): (&str, f32)| StoredClip { name: name.to_owned(), duration_s };
    StoredShape { object: object.name.clone(), clips: [("", 0.0), ("Läufer", 1.5)].map(clip).to_vec() }
}

/// Of three vertices that differ.
fn triangle(random: &mut Random, vertices: usize) -> [u32; 3] {
    let first = random.below(vertices);
    let second = 1 + random.below(vertices - 2);
    let third = second + 1 + random.below(vertices - 1 - second);
    [first, first + second, first + third].map(|vertex| (vertex % vertices) as u32)
}

pub fn scene(seed: u64) -> StoredScene {
    let random = &mut Random(seed);
    let materials = 1 + random.below(3);
    let objects: Vec<_> = (0..random.below(4))
        .map(|i| StoredObject {
            name: format!("object {i}"),
            material: random.below(materials) as u32,
            triangles: random.below(5) as u32,
        })
        .collect();
    let triangles: u32 = objects.iter().map(|o| o.triangles).sum();
    let vertices = 3 + random.below(7);
    StoredScene {
        meta: Meta {
            name: "päper room".to_owned(),
            camera: Camera {
                position: point(random),
                target: [20.0, 0.0, 0.0],
                fov_deg: 40.0,
                exposure_ev: random.signed(),
            },
            tonemap: Tonemap::ALL[seed as usize % 3],
            size: [1 + random.below(500) as u32, 16_384],
            varies_light: seed.is_multiple_of(2),
            varies_view: seed.is_multiple_of(3),
            varies_shape: seed.is_multiple_of(2),
            environment: (seed % 5 > 1).then(|| EnvironmentLook {
                map: "sky.exr".to_owned(),
                gain: [1.0, random.unit(), 1e9],
                rotation_deg: random.signed() * 720.0,
            }),
            materials: (0..materials).map(|i| material(random, i)).collect(),
            shapes: objects.iter().filter(|_| seed.is_multiple_of(2)).map(shape).collect(),
            objects,
        },
        positions: (0..vertices).map(|_| point(random)).collect(),
        normals: (0..vertices).map(|i| [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.6, 0.8]][i % 3]).collect(),
        triangles: (0..triangles).map(|_| triangle(random, vertices)).collect(),
    }
}

pub fn animation(seed: u64) -> Animation {
    let random = &mut Random(seed);
    let mut times = |n: usize| -> Vec<f32> { (0..n).map(|i| i as f32 * 0.5 + 0.4 * random.unit()).collect() };
    let (kd_times, shininess_times, colour_times, roughness_times, name_times) =
        (times(3), times(2), times(2), times(1), times(1));
    let track =
        |leaf: [&str; 3], times_s, values| Track { leaf: leaf.map(str::to_owned).to_vec(), times_s, values };
    let tracks = vec![
        track(
            ["materials", "m0", "kd"],
            kd_times,
            TrackValues::Vector((0..3).map(|_| random.blinn_phong().kd.to_vec()).collect()),
        ),
        track(
            ["materials", "m0", "shininess"],
            shininess_times,
            TrackValues::Scalar((0..2).map(|_| random.unit() * 100.0).collect()),
        ),
        track(
            ["materials", "m1", "base_color"],
            colour_times,
            TrackValues::Vector((0..2).map(|_| random.ggx().base_color.to_vec()).collect()),
        ),
        track(
            ["materials", "m1", "roughness"],
            roughness_times,
            TrackValues::Scalar(vec![random.ggx().roughness]),
        ),
        track(["shapes", "fox", "clip"], name_times, TrackValues::Name(vec!["Walk".to_owned()])),
    ];
    Animation {
        name: "turn of colours".to_owned(),
        duration_s: 0.1 + random.unit(),
        looping: random.below(2) == 0,
        tracks,
    }
}
