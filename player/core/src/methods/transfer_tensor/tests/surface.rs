//! Surfaces that shine, against the analytic formula at the very points that are seen.

use super::super::GLOSSY;
use super::super::dispatches::uniform;
use super::super::gpu_data::Mirror;
use super::super::shown::VISIBLE_WORDS;
use crate::gpu::{Gpu, Passes};
use crate::lit::{Bound, Light, Map, Mesh, Picture, Surface};
use crate::support::sparse;
use crate::testing::{gpu, read_radiance};
use glam::Vec3;
use relume_formats::basis::microfacet::{Facets, schlick};
use relume_formats::basis::suns::split;
use relume_formats::basis::{Angles, Filter, Texture, Wrap};
use relume_formats::bundle::Brdfs;
use relume_formats::evaluate::suns::towards;
use relume_formats::kinds::scene::{EnvironmentLook, StoredMaterial};
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::kinds::{StoredScene, Textures};
use relume_formats::state::{BlinnPhong, Brdf, Camera, CookTorrance, Ggx, Rgb};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use wgpu::{Buffer, BufferUsages};

const SIZE: [u32; 2] = [48, 40];
/// Vertices along the equator, and from pole to pole.
const GRID: [u32; 2] = [97, 49];
const GAIN: Rgb = [1.5, 1.0, 0.5];
/// Of the one texel of the texture, and what it is worth.
const TEXEL: [u8; 4] = [255, 128, 10, 255];

/// A ball of radius 1 about the origin, before a camera.
fn ball(brdf: Brdf) -> StoredScene {
    let mut scene = sparse::scene(GRID);
    for place in &mut scene.positions {
        let ((sin, cos), (sin_up, cos_up)) = ((PI * place[0]).sin_cos(), (FRAC_PI_2 * place[1]).sin_cos());
        *place = [sin * cos_up, sin_up, cos * cos_up];
    }
    scene.normals = scene.positions.clone();
    scene.meta.materials = vec![StoredMaterial {
        brdf,
        sharpest: brdf.model().usual_sharpest(),
        ..scene.meta.materials[0].clone()
    }];
    scene.meta.camera = camera();
    scene
}

fn camera() -> Camera {
    Camera { position: [0.4, 0.9, 4.0], target: [0.0; 3], fov_deg: 26.0, exposure_ev: 0.0 }
}

fn materials() -> [Brdf; 6] {
    let ks = [0.3, 0.5, 0.6];
    [
        Brdf::BlinnPhong(BlinnPhong { kd: [0.5, 0.3, 0.1], ks, shininess: 200.0 }),
        Brdf::BlinnPhong(BlinnPhong { kd: [0.0, 0.3, 0.1], ks, shininess: 9.0 }),
        Brdf::Ggx(Ggx { base_color: [0.9, 0.6, 0.3], metallic: 0.0, roughness: 0.32 }),
        Brdf::Ggx(Ggx { base_color: [0.9, 0.6, 0.3], metallic: 1.0, roughness: 0.6 }),
        Brdf::CookTorrance(CookTorrance { kd: [0.4, 0.3, 0.2], ks, fresnel: 0.2, roughness: 0.1 }),
        Brdf::CookTorrance(CookTorrance { kd: [0.4, 0.3, 0.2], ks, fresnel: 0.9, roughness: 0.5 }),
    ]
}

/// What is seen at a place of the film: a point, its interpolated unit normal, and the normal of its triangle.
struct Seen {
    point: Vec3,
    normal: Vec3,
    facing: Vec3,
    /// Of two values by vertex, interpolated.
    known: [Rgb; 2],
}

/// What a vertex knows of the light: something that no symmetry hides.
fn known(vertex: usize) -> [Rgb; 2] {
    let at = vertex as f32 * 0.001;
    [[1.0 + at.sin(), 0.5, at.cos() + 1.1], [0.3, 0.4 + 0.3 * (3.0 * at).sin(), 0.2]]
}

/// The nearest point of the ball along a ray (Möller and Trumbore 1997).
fn meet(scene: &StoredScene, eye: Vec3, direction: Vec3) -> Option<Seen> {
    let hit = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| Vec3::from(scene.positions[vertex as usize]));
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let (s, determinant) = (eye - a, ab.dot(p));
        let q = s.cross(ab);
        let [u, v, t] = [s.dot(p), direction.dot(q), ac.dot(q)].map(|x| x / determinant);
        (determinant > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((
            t,
            *triangle,
            [1.0 - u - v, u, v],
        ))
    };
    let (t, triangle, weights) = scene.triangles.iter().filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let corners = || triangle.into_iter().zip(weights);
    let place = |list: &[[f32; 3]]| corners().map(|(v, w)| w * Vec3::from(list[v as usize])).sum::<Vec3>();
    let [a, b, c] = triangle.map(|vertex| Vec3::from(scene.positions[vertex as usize]));
    Some(Seen {
        point: eye + t * direction,
        normal: place(&scene.normals).normalize(),
        facing: (b - a).cross(c - a).normalize(),
        known: [0, 1].map(|k| {
            let sum = corners().map(|(v, w)| w * Vec3::from(known(v as usize)[k]));
            sum.sum::<Vec3>().to_array()
        }),
    })
}

/// By pixel the mean over its four samples of what `shown` says of a point seen from the unit vector towards
/// the eye; `None` where a sample shows no ball, or something that `shown` cannot tell.
fn expected(scene: &StoredScene, shown: impl Fn(&Seen, Vec3) -> Option<Rgb>) -> Vec<Option<Rgb>> {
    let camera = camera();
    let (film, eye) = (camera.film(SIZE[0], SIZE[1]), Vec3::from(camera.position));
    let pixel = |index: u32| {
        let mut sum = Vec3::ZERO;
        for [x, y] in [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]] {
            let way = film.direction((index % SIZE[0]) as f32 + x, (index / SIZE[0]) as f32 + y);
            let seen = meet(scene, eye, Vec3::from(way.to_array()))?;
            let towards_eye = (eye - seen.point).normalize();
            sum += 0.25 * Vec3::from(GAIN) * Vec3::from(shown(&seen, towards_eye)?);
        }
        Some(sum.to_array())
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// The BRDF, sr⁻¹, as `relume_formats::state` defines it, with a diffuse part `colour` times as bright.
fn brdf_value(brdf: &Brdf, colour: Vec3, incoming: Vec3, outgoing: Vec3, normal: Vec3) -> Vec3 {
    let half = (incoming + outgoing).normalize();
    let angles = Angles {
        cos_half: half.dot(normal).clamp(0.0, 1.0),
        cos_difference: half.dot(outgoing).clamp(0.0, 1.0),
        cos_in: incoming.dot(normal).max(0.0),
        cos_out: outgoing.dot(normal).max(0.0),
    };
    let fresnel = |f0: Vec3| f0 + (Vec3::ONE - f0) * schlick(angles.cos_difference);
    match brdf {
        Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) => {
            let lobe = (shininess + 2.0) / TAU * angles.cos_half.powf(*shininess);
            Vec3::from(*kd) * colour * FRAC_1_PI + Vec3::from(*ks) * lobe
        }
        Brdf::Ggx(Ggx { base_color, metallic, roughness }) => {
            let base = Vec3::from(*base_color);
            let reflected = fresnel(Vec3::splat(0.04 * (1.0 - metallic)) + base * *metallic);
            let diffuse = (Vec3::ONE - reflected) * base * colour * (1.0 - metallic) * FRAC_1_PI;
            diffuse + reflected * Facets::Ggx.lobe(*roughness, &angles)
        }
        Brdf::CookTorrance(CookTorrance { kd, ks, fresnel: f0, roughness }) => {
            let lobe = Facets::CookTorrance.lobe(*roughness, &angles);
            Vec3::from(*kd) * colour * FRAC_1_PI + Vec3::from(*ks) * fresnel(Vec3::splat(*f0)) * lobe
        }
    }
}

/// Surfaces whose materials have no cones.
fn shining(gpu: &Gpu, scene: &StoredScene, radiance: Buffer, glossy: Buffer) -> Surface {
    let bytes = VISIBLE_WORDS as u64 * radiance.size();
    let visible = gpu.buffer("visible", bytes, BufferUsages::VERTEX);
    let mirror: Mirror = bytemuck::Zeroable::zeroed();
    let texel = |label| {
        let format = wgpu::TextureFormat::Rgba32Float;
        Bound::Texture(gpu.texture(label, [1, 1], format, bytemuck::bytes_of(&[0.0_f32; 4])))
    };
    let of_material = vec![(1, Bound::Buffer(uniform(gpu, "mirror", &mirror))), (2, texel("cones"))];
    Surface {
        shader: GLOSSY,
        vertices: vec![(radiance, 1), (glossy, 1), (visible, VISIBLE_WORDS)],
        bound: vec![(12, Bound::Buffer(uniform(gpu, "rotation", &[0.0_f32, 1.0]))), (13, texel("filtered"))],
        of_materials: vec![of_material; scene.meta.materials.len()],
    }
}

/// A picture of a scene, and its light.
struct Shown {
    light: Light,
    picture: Picture,
}

impl Shown {
    /// Before the map called `map`; vertices know `of_vertices`.
    fn new(
        gpu: &Gpu,
        scene: &StoredScene,
        textures: Option<&Textures>,
        map: &EnvironmentLook,
        (shines, of_vertices): (bool, impl Fn(usize) -> [Rgb; 2]),
    ) -> Self {
        let maps = sparse::maps().iter().map(|map| Map::new(gpu, map)).collect();
        let mut light = Light::new(gpu, maps, 4, false);
        light.set(gpu, map);
        let buffer = |which: usize| {
            let values = (0..scene.positions.len()).map(|vertex| {
                let [r, g, b] = of_vertices(vertex)[which];
                [r, g, b, 0.0]
            });
            let values: Vec<[f32; 4]> = values.collect();
            let bytes = size_of_val(&values[..]) as u64;
            let buffer = gpu.buffer("known", bytes, BufferUsages::VERTEX | BufferUsages::COPY_DST);
            gpu.write(&buffer, 0, bytemuck::cast_slice(&values));
            buffer
        };
        let (radiance, glossy) = (buffer(0), buffer(1));
        let surface =
            if shines { shining(gpu, scene, radiance, glossy) } else { Surface::diffuse(&radiance) };
        let mut picture = Picture::new(gpu, SIZE, Mesh::new(gpu, scene, textures), surface, &light);
        picture.set_suns(gpu, &light);
        Self { light, picture }
    }

    fn draw(&mut self, gpu: &Gpu) -> Vec<Rgb> {
        self.picture.set(gpu, &camera(), GAIN);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut passes = Passes::new(&mut encoder, None, 0);
        self.picture.encode(self.light.map(), &mut passes);
        passes.finish();
        gpu.queue.submit([encoder.finish()]);
        read_radiance(gpu, &self.picture.film().bands)
    }
}

fn map(name: &str, rotation_deg: f32) -> EnvironmentLook {
    EnvironmentLook { map: name.to_owned(), gain: [1.0; 3], rotation_deg }
}

/// Of the material number `index`, set while it plays.
fn with_material(shown: &mut Shown, gpu: &Gpu, scene: &StoredScene, brdf: Brdf) -> Vec<Rgb> {
    let mut brdfs = Brdfs::of(&scene.meta.materials);
    brdfs.set(&scene.meta.materials[0].name, brdf);
    shown.picture.set_materials(gpu, &brdfs);
    shown.draw(gpu)
}

/// Fails unless all pixels that are known are shown, within `bound` of themselves and of a hundredth of the
/// brightest; there must be at least so many.
#[track_caller]
fn expect_shown(ours: &[Rgb], theirs: &[Option<Rgb>], bound: f32, least: usize, what: &str) {
    let brightest = theirs.iter().flatten().flatten().fold(0.0_f32, |most, value| most.max(*value));
    let known = || ours.iter().zip(theirs).filter_map(|(ours, theirs)| Some((ours, theirs.as_ref()?)));
    assert!(known().count() >= least, "{what}: {} pixels are known", known().count());
    let mut largest = 0.0_f32;
    for (ours, theirs) in known() {
        for (ours, theirs) in ours.iter().zip(theirs) {
            let off = (ours - theirs).abs() / (theirs + 0.01 * brightest);
            largest = largest.max(off);
            assert!(off <= bound, "{what}: {ours} is not {theirs}");
        }
    }
    println!("{what}: {largest} off at most");
}

/// One light at a time: under a sun the whole BRDF, at every point that sees all of its disc.
#[test]
fn a_ball_under_a_sun_shows_the_analytic_brdf() {
    let Some(gpu) = gpu() else { return };
    let [first, ..] = materials();
    let scene = ball(first);
    let texture =
        Texture { size: [1; 2], wrap: [Wrap::Clamp; 2], filter: Filter::Nearest, texels: vec![TEXEL] };
    let colour = texture.sample([0.5; 2]);
    let textured = Textures {
        uvs: vec![[0.5; 2]; scene.positions.len()],
        textures: vec![MaterialTexture { material: 0, alpha_cutoff: None, texture }],
    };
    let sun_map = sparse::maps().into_iter().find(|map| map.name == "sun").unwrap();
    let sun = split(&sun_map.map).suns[0];
    for (textures, colour) in [(None, Vec3::ONE), (Some(&textured), Vec3::from_slice(&colour[..3]))] {
        for rotation_deg in [0.0, 70.0] {
            let mut shown =
                Shown::new(&gpu, &scene, textures, &map("sun", rotation_deg), (true, |_| [[0.0; 3]; 2]));
            for (number, brdf) in materials().into_iter().enumerate() {
                if colour != Vec3::ONE && matches!(brdf, Brdf::Ggx(ggx) if ggx.metallic > 0.0) {
                    // The one lobe that a texture would colour.
                    continue;
                }
                let ours = match number {
                    0 => shown.draw(&gpu),
                    _ => with_material(&mut shown, &gpu, &scene, brdf),
                };
                let way = towards(&sun, rotation_deg);
                let theirs = expected(&scene, |seen, towards_eye| {
                    // Where the disc is nowhere near the horizon.
                    let cosine = seen.normal.dot(way);
                    let value = brdf_value(&brdf, colour, way, towards_eye, seen.normal);
                    let received = cosine.max(0.0) * Vec3::from(sun.irradiance);
                    let whole = cosine > 0.2 && seen.facing.dot(way) > 0.15;
                    let hidden = cosine < -0.2 && seen.facing.dot(way) < -0.15;
                    (whole || hidden).then(|| (value * received).to_array())
                });
                // Normals of samples are off by some 1e-7, which the sharpest lobe takes to the power of 200, and the
                // shader's logarithm by as much again.
                expect_shown(&ours, &theirs, 2e-4, 400, &format!("{brdf:?} at {rotation_deg}°"));
            }
        }
    }
}

/// Without suns: what vertices know, of which the diffuse part is coloured.
#[test]
fn what_vertices_know_is_interpolated() {
    let Some(gpu) = gpu() else { return };
    for brdf in materials() {
        let scene = ball(brdf);
        let mut shown = Shown::new(&gpu, &scene, None, &map("black", 0.0), (true, known));
        let theirs = expected(&scene, |seen, _| {
            let [radiance, glossy] = seen.known.map(Vec3::from);
            Some((Vec3::from(brdf.diffuse_albedo()) * radiance + glossy).to_array())
        });
        // Interpolated in single precision, between vertices whose places on the film are rounded.
        expect_shown(&shown.draw(&gpu), &theirs, 5e-5, 700, &format!("{brdf:?}"));
    }
}

/// A material without highlight is the same picture by either shader, bit for bit.
#[test]
fn a_matte_material_is_matte_by_either_shader() {
    let Some(gpu) = gpu() else { return };
    let matte = Brdf::BlinnPhong(BlinnPhong { kd: [0.5, 0.3, 0.1], ks: [0.0; 3], shininess: 20.0 });
    let scene = ball(matte);
    let of_vertices = |vertex: usize| [known(vertex)[0], [0.0; 3]];
    let [glossy, diffuse] = [true, false]
        .map(|shines| Shown::new(&gpu, &scene, None, &map("sun", 0.0), (shines, of_vertices)).draw(&gpu));
    assert!(glossy == diffuse && glossy.iter().flatten().any(|value| *value > 0.0));
}
