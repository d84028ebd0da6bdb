//! Coinciding triangles, rays that must not escape, and what is known of what they meet.

use super::*;
use crate::trace::sampler::PixelSampler;
use crate::trace::spans::TexelRays;
use crate::trace::spot::UNPAINTED;
use rayon::prelude::*;
use std::sync::Arc;

/// Many objects in one place, as files with thousands of equal nodes have them.
#[test]
fn triangles_that_coincide_make_no_deep_tree() {
    let mut scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
    scene.objects.truncate(1);
    let mesh = Arc::make_mut(&mut scene.objects[0].mesh);
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    *mesh = Mesh {
        positions: positions.to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 3],
        uvs: Vec::new(),
        triangles: vec![[0, 1, 2]; 100_000],
    };
    scene.lights.clear();
    let world = World::new(&scene);
    let hit = world.intersect(Vec3A::new(0.2, 0.2, 3.0), Vec3A::NEG_Z).unwrap();
    assert!(hit.position.distance(Vec3A::new(0.2, 0.2, 0.0)) < 1e-5 && hit.front);
    assert!(world.intersect(Vec3A::new(0.7, 0.7, 3.0), Vec3A::NEG_Z).is_none());
}

/// By triangles counted in another way than the hierarchy's, and nothing where nothing is painted.
#[test]
fn surfaces_know_where_textures_lie_on_them() {
    let scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
    let painted = scene.vary.materials[0];
    let painting = Painting::of_atlas(&scene, painted, |_| true).unwrap().unwrap();
    let (world, plain) = (World::painted(&scene, std::slice::from_ref(&painting)), World::new(&scene));
    let numbered = |object: usize| {
        (0..scene.objects[object].mesh.triangles.len()).map(move |triangle| (object, triangle))
    };
    let triangles: Vec<_> = (0..scene.objects.len()).flat_map(numbered).collect();
    let (mut met, mut others) = (0, 0);
    for index in 0..1024 {
        let film = scene.camera.film(32, 32);
        let (eye, direction) =
            (film.eye_in_world, film.direction((index % 32) as f32 + 0.5, (index / 32) as f32 + 0.5));
        let Some((meeting, surface)) = world.meet(eye, direction).zip(world.intersect(eye, direction)) else {
            continue;
        };
        let of_triangle =
            |(object, index): &(usize, usize)| painting.at(*object, *index, meeting.barycentric);
        let expected = triangles.get(meeting.triangle as usize).and_then(of_triangle);
        assert_eq!(expected.is_some(), meeting.owner == Owner::Material(painted as u32));
        *if expected.is_some() { &mut met } else { &mut others } += 1;
        assert_eq!(surface.uv, expected.unwrap_or(UNPAINTED));
        assert_eq!(plain.intersect(eye, direction).map(|surface| surface.uv), Some(UNPAINTED));
    }
    assert!(met > 20 && others > 20, "{met} {others}");
}

/// A ray in any direction from a hundredth of the longest side below a triangle.
fn from_inside(mesh: &Mesh, index: u32) -> (Vec3A, Vec3A) {
    let sample = PixelSampler::new(1, index >> 14).sample(index & ((1 << 14) - 1));
    let [[a, b], [c, _], [u, v]] = [sample.pair(0), sample.pair(1), sample.pair(2)];
    let count = mesh.triangles.len();
    let corners = mesh.triangles[((c * count as f32) as usize).min(count - 1)];
    let [p, q, r] = corners.map(|i| Vec3A::from(mesh.positions[i as usize]));
    let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
    // Away from the triangle's own edges, where a start below one face may lie on the next.
    let [a, b] = [a, b].map(|x| 0.01 / 3.0 + 0.99 * x);
    let normal = (q - p).cross(r - p).normalize();
    let depth = 0.01 * (q - p).length().max((r - p).length()).max((r - q).length());
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    let z = 1.0 - 2.0 * u;
    let ring = (1.0 - z * z).max(0.0).sqrt();
    (p + (q - p) * a + (r - p) * b - normal * depth, Vec3A::new(ring * cos, ring * sin, z))
}

/// From inside a closed mesh of a millimetre, a metre, a kilometre, with every kind of instructions: no ray
/// escapes, and no texel of a cube is free.
fn check_that_no_ray_escapes(rays: u32) {
    let mut scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
    let knot = scene.objects.iter().position(|object| object.name == "knot").unwrap();
    scene.objects = vec![scene.objects.swap_remove(knot)];
    scene.lights.clear();
    let mesh = scene.objects[0].mesh.clone();
    let rays_of_texels = TexelRays::centres(64);
    for scale in [1e-3, 1.0, 1e3] {
        scene.camera.position = [0.0, scale, 0.0];
        let place = |p: &[f32; 3]| ((Vec3A::from(*p) + Vec3A::new(3.0, -2.0, 1.0)) * scale).to_array();
        Arc::make_mut(&mut scene.objects[0].mesh).positions = mesh.positions.iter().map(place).collect();
        let World { mut hierarchy, units_per_metre, .. } = World::new(&scene);
        let mesh = &scene.objects[0].mesh;
        hierarchy.with_all_kernels(|hierarchy, kernel| {
            let escapes = |index: &u32| {
                let (origin, direction) = from_inside(mesh, *index);
                hierarchy.nearest(origin * units_per_metre, direction, |_, _| true).is_none()
            };
            assert_eq!((0..rays).into_par_iter().filter(escapes).count(), 0, "{kernel}, scale {scale}");
            let free = |index: u32| {
                let origin = from_inside(mesh, index).0 * units_per_metre;
                let mut texels = TexelSet::of(rays_of_texels.face_size(), |_| true);
                let eye = Eye { origin, horizon: None, rays: &rays_of_texels, within: None };
                hierarchy.see(eye, &mut texels, |_| false, |_, _| true);
                texels.count()
            };
            let free: usize = (0..rays / 10_000).into_par_iter().map(free).sum();
            assert_eq!(free, 0, "texels, {kernel}, scale {scale}");
        });
    }
}

#[test]
fn no_ray_escapes_by_any_kind_of_instructions() {
    check_that_no_ray_escapes(100_000);
}

#[test]
#[ignore = "some 900 million rays, minutes"]
fn none_of_many_rays_escapes_by_any_kind_of_instructions() {
    check_that_no_ray_escapes(100_000_000);
}
