//! What all methods stand on, the ray tracer: leaks, specks, thin walls, degenerate and huge triangles,
//! scenes of any size and anywhere.

use crate::support::{mean_radiance, render, scaled, scene};
use glam::{Mat3A, Vec3A};
use rayon::prelude::*;
use relume_bake::trace::reference::Paths;
use relume_bake::trace::sampler::PixelSampler;
use relume_bake::trace::world::World;
use relume_formats::state::Camera;
use relume_scenes::Scene;
use std::sync::Arc;

const CLOSED_SHAPES: [&str; 6] = [
    "shape = 'torus-knot'",
    "shape = 'torus'",
    "shape = 'sphere'",
    "shape = 'box'",
    "shape = 'ring'",
    "shape = 'lathe'\nprofile = [[0, -0.5], [0.5, -0.3], [0.2, 0.2], [0, 0.5]]",
];

/// A scene of nothing but one shape.
fn lone_shape(shape: &str) -> Scene {
    scene(&format!(
        "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 30\n[materials.m]\nbrdf = 'blinn-phong'\nkd = [1, 1, 1]\n\
         [environment]\n[render]\nsize = [32, 32]\n[[object]]\nname = 'o'\nmaterial = 'm'\n{shape}\n"
    ))
}

/// The scene with its only mesh turned about an odd axis, scaled and moved.
fn transformed(scene: &Scene, scale: f32, offset: Vec3A) -> Scene {
    let turn = Mat3A::from_axis_angle(glam::Vec3::new(0.3, 0.8, -0.5).normalize(), 0.7);
    let mut scene = scene.clone();
    let mesh = Arc::make_mut(&mut scene.objects[0].mesh);
    for p in &mut mesh.positions {
        *p = (turn * Vec3A::from(*p) * scale + offset * scale).to_array();
    }
    for n in &mut mesh.normals {
        *n = (turn * Vec3A::from(*n)).to_array();
    }
    let place = |p: [f32; 3]| ((Vec3A::from(p) + offset) * scale).to_array();
    scene.camera.position = place(scene.camera.position);
    scene.camera.target = place(scene.camera.target);
    scene
}

/// From inside a closed mesh no ray escapes, in 10⁸: a leak in a visibility bake is a bright or dark speck.
#[test]
fn no_ray_escapes_from_inside() {
    const RAYS: u32 = 100_000_000;
    let variants =
        [(1.0, Vec3A::ZERO), (1e-3, Vec3A::new(3.0, -2.0, 1.0)), (1e3, Vec3A::new(-1.0, 4.0, 0.5))];
    let per_mesh = RAYS / (CLOSED_SHAPES.len() * variants.len()) as u32 + 1;
    for shape in CLOSED_SHAPES {
        let base = lone_shape(shape);
        for (scale, offset) in variants {
            let scene = transformed(&base, scale, offset);
            let escaped = escaping_rays(&scene, per_mesh);
            assert_eq!(escaped, 0, "{shape} at scale {scale}: of {per_mesh} rays");
        }
    }
}

/// Rays along the axes, with zeros of either sign, meet what is in their way: a sun straight overhead has
/// such directions.
#[test]
fn negative_zeros_are_zeros() {
    for shape in CLOSED_SHAPES {
        let scene = lone_shape(shape);
        let world = World::new(&scene);
        let mesh = &scene.objects[0].mesh;
        for axis in 0..3 {
            for signs in 0..8u32 {
                let direction = Vec3A::from_array(std::array::from_fn(|k| {
                    let value: f32 = if k == axis { 1.0 } else { 0.0 };
                    if signs >> k & 1 == 1 { -value } else { value }
                }));
                // Along the axis through the middle of a triangle that does not stand edge-on.
                let middle = |t: &[u32; 3]| {
                    t.iter().map(|i| Vec3A::from(mesh.positions[*i as usize])).sum::<Vec3A>() / 3.0
                };
                for triangle in mesh.triangles.iter().step_by(mesh.triangles.len() / 12) {
                    let [p, q, r] = triangle.map(|i| Vec3A::from(mesh.positions[i as usize]));
                    if (q - p).cross(r - p).normalize().dot(direction).abs() > 0.01 {
                        let origin = middle(triangle) - 10.0 * direction;
                        assert!(
                            world.intersect(origin, direction).is_some(),
                            "{shape}, from {origin} along {direction}"
                        );
                        assert!(
                            world.occluded(origin, direction, 20.0),
                            "{shape}, from {origin} along {direction}"
                        );
                    }
                }
            }
        }
    }
}

/// Shoots rays from just below random points of the surface in all directions; counts those that meet
/// nothing.
fn escaping_rays(scene: &Scene, rays: u32) -> u32 {
    let mesh = &scene.objects[0].mesh;
    let world = World::new(scene);
    let chunk = 1 << 14;
    let escapes = |start: u32| {
        let sampler = PixelSampler::new(1, start);
        let mut escaped = 0;
        for index in 0..chunk.min(rays - start) {
            let sample = sampler.sample(index);
            let [[a, b], [c, _], [u, v]] = [sample.pair(0), sample.pair(1), sample.pair(2)];
            let corners =
                mesh.triangles[((c * mesh.triangles.len() as f32) as usize).min(mesh.triangles.len() - 1)];
            let [p, q, r] = corners.map(|i| Vec3A::from(mesh.positions[i as usize]));
            let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            // Away from the triangle's own edges, where a start below one face may lie on the next.
            let [a, b] = [a, b].map(|x| 0.01 / 3.0 + 0.99 * x);
            let normal = (q - p).cross(r - p).normalize();
            // A hundredth of the longest side inwards: within every mesh here, and far above rounding.
            let depth = 0.01 * (q - p).length().max((r - p).length()).max((r - q).length());
            let origin = p + (q - p) * a + (r - p) * b - normal * depth;
            let z = 1.0 - 2.0 * u;
            let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
            let ring = (1.0 - z * z).max(0.0).sqrt();
            escaped += u32::from(world.intersect(origin, Vec3A::new(ring * cos, ring * sin, z)).is_none());
        }
        escaped
    };
    (0..rays.div_ceil(chunk)).into_par_iter().map(|i| escapes(i * chunk)).sum()
}

/// A ray that leaves a convex body from its surface meets nothing, at any scale from a millimetre to a
/// kilometre, near the origin or away from it: no self-shadow, and so no speck.
#[test]
fn no_self_shadow_at_any_scale() {
    for shape in ["shape = 'box'", "shape = 'sphere'"] {
        let base = lone_shape(shape);
        for scale in [1e-3, 1e-2, 1.0, 1e2, 1e3] {
            for offset in [Vec3A::ZERO, Vec3A::new(7.0, -3.0, 5.0)] {
                let scene = transformed(&base, scale, offset);
                let (rays, shadowed) = self_shadowing_rays(&scene, 500_000);
                assert!(rays > 100_000, "only {rays} rays hit the {shape}");
                assert_eq!(shadowed, 0, "{shape}, scale {scale}, offset {offset}: of {rays} rays");
            }
        }
    }
}

/// Looks at the body from the camera and leaves it again in random directions, half of them grazing. Counts
/// these rays, and those that meet something.
fn self_shadowing_rays(scene: &Scene, tries: u32) -> (u32, u32) {
    let world = World::new(scene);
    // Narrow enough for most rays to hit.
    let film = Camera { fov_deg: 10.0, ..scene.camera }.film(1, 1);
    let (mut rays, mut shadowed) = (0, 0);
    for index in 0..tries {
        let sample = PixelSampler::new(2, 0).sample(index);
        let [[x, y], [u, v], [grazing, _]] = [sample.pair(0), sample.pair(1), sample.pair(2)];
        let Some(surface) = world.intersect(film.eye_in_world, film.direction(x, y)) else { continue };
        let (tangent, bitangent) = surface.geometric_normal.any_orthonormal_pair();
        let cosine = if grazing < 0.5 { 1e-4 + 0.01 * u } else { u };
        let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let direction =
            (tangent * (cos * sine) + bitangent * (sin * sine) + surface.geometric_normal * cosine)
                .normalize();
        rays += 1;
        shadowed += u32::from(world.intersect(surface.offset(), direction).is_some());
        shadowed += u32::from(world.occluded(surface.offset(), direction, f32::INFINITY));
    }
    (rays, shadowed)
}

/// The same room a thousand times larger or smaller looks the same: light depends on angles alone.
#[test]
fn a_thousand_times_larger_or_smaller() {
    let base = crate::support::library_scene("cornell-knot");
    let image = |scale: f32| render(&scaled(&base, scale), [32, 32], 64, 2, Paths::Gather, 1).radiance;
    let metre = image(1.0);
    for scale in [1e-3, 1e3] {
        // The paths are the same; a handful of samples round to the other side of an edge.
        let error = crate::support::relative_l2(&image(scale), &metre);
        assert!(error < 2e-3, "scale {scale}: relative L2 {error}");
    }
}

/// Moving a scene far from the origin costs no accuracy: which light is chosen depends on the size of the
/// scene, not on where it stands.
#[test]
fn far_from_the_origin() {
    let image = |offset: f32| {
        let text = format!(
            "[camera]\nposition = [{x}, 1, 4]\ntarget = [{x}, 0.5, 0]\nfov_deg = 40\n[render]\nsize = [24, 24]\n[environment]\ngain = [0.05, 0.05, 0.05]\n\
             [materials.m]\nbrdf = 'blinn-phong'\n[[object]]\nname = 'floor'\nmaterial = 'm'\nshape = 'quad'\ntransform = {{ translation = [{x}, 0, 0], scale = 4 }}\n\
             [[light]]\nname = 'lamp'\nkind = 'area'\nradiance = [9, 9, 9]\ntransform = {{ translation = [{x}, 2, 0], rotation_deg = [-90, 0, 0], scale = 0.5 }}\n",
            x = offset
        );
        let image = render(&scene(&text), [24, 24], 64, 2, Paths::Gather, 1);
        image.variance.iter().flatten().map(|v| f64::from(*v)).sum::<f64>()
    };
    let (near, far) = (image(0.0), image(256.0));
    assert!(far < 1.5 * near, "variance {near} at the origin, {far} 256 m away");
}

/// Scenes at the edge of sense: nothing to see, no light, black light.
#[test]
fn nothing_to_see() {
    let dark = lone_shape("shape = 'sphere'");
    let mut away = dark.clone();
    away.camera.target = [0.0, 0.0, 20.0];
    assert!(
        render(&away, [8, 8], 4, 4, Paths::Best, 0)
            .radiance
            .iter()
            .flatten()
            .all(|r| (*r - 1.0).abs() < 1e-5),
        "only the sky"
    );
    let mut unlit = dark.clone();
    unlit.environment = None;
    assert!(render(&unlit, [8, 8], 4, 4, Paths::Gather, 0).radiance.iter().flatten().all(|r| *r == 0.0));
    let mut black = dark;
    if let Some(environment) = &mut black.environment {
        environment.gain = [0.0; 3];
    }
    assert!(render(&black, [8, 8], 4, 4, Paths::Best, 0).radiance.iter().flatten().all(|r| *r == 0.0));
}

/// Rays from the floor to a wall above it, `wall` the text of the object, 2 m × 2 m at 1 m: exactly those
/// that aim at it are stopped. Those that aim within 5 cm of its rim are not tried.
fn expect_wall_stops_what_aims_at_it(folder: &std::path::Path, wall: &str) {
    let text = format!(
        "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 30\n[materials.m]\nbrdf = 'blinn-phong'\n[environment]\n[render]\nsize = [8, 8]\n\
         [[object]]\nname = 'wall'\nmaterial = 'm'\n{wall}\n"
    );
    let scene = relume_scenes::load(&crate::support::write_scene(folder, &text)).unwrap();
    let world = World::new(&scene);
    let (mut stopped, mut passed) = (0, 0);
    for index in 0..200_000 {
        let sample = PixelSampler::new(3, 0).sample(index);
        let [[a, b], [c, d]] = [sample.pair(0), sample.pair(1)].map(|pair| pair.map(|u| 4.0 * u - 2.0));
        let ([from, to], rim) = ([Vec3A::new(a, 0.0, b), Vec3A::new(c, 1.0, d)], c.abs().max(d.abs()) - 1.0);
        if rim.abs() > 0.05 {
            let hit = world.occluded(from, (to - from).normalize(), f32::INFINITY);
            assert_eq!(hit, rim < 0.0, "{wall}: from {from} to {to}");
            stopped += u32::from(hit);
            passed += u32::from(!hit);
        }
    }
    assert!(stopped > 30_000 && passed > 30_000, "{stopped} {passed}");
}

/// Thin walls: down to no thickness at all, as boxes whose sides vanish and as sheets seen from either side,
/// none lets a ray through.
#[test]
fn walls_of_any_thinness_let_nothing_through() {
    let folder = tempfile::tempdir().unwrap();
    for thickness in ["1e-2", "1e-5", "1e-7", "1e-9"] {
        let place = format!("transform = {{ translation = [0, 1, 0], scale = [2, {thickness}, 2] }}");
        expect_wall_stops_what_aims_at_it(folder.path(), &format!("shape = 'box'\n{place}"));
    }
    for turn in [0, 180] {
        let place =
            format!("transform = {{ translation = [0, 1, 0], rotation_deg = [{turn}, 0, 0], scale = 2 }}");
        expect_wall_stops_what_aims_at_it(folder.path(), &format!("shape = 'quad'\n{place}"));
    }
}

/// A sheet of strips at y = 1, some a micrometre wide, as an OBJ file; `more` follows.
fn strips(more: &str) -> String {
    let xs = [-1.0, -0.5, -0.499_999, 0.0, 0.000_001, 0.000_002, 0.3, 0.999_999, 1.0f64];
    let vertices: String = xs.iter().map(|x| format!("v {x} 1 -1\nv {x} 1 1\n")).collect();
    let faces: String = (0..xs.len() - 1)
        .map(|k| format!("f {} {} {} {}\n", 2 * k + 1, 2 * k + 2, 2 * k + 4, 2 * k + 3))
        .collect();
    vertices + &faces + more
}

/// Degenerate triangles: slivers stop rays like any other triangle; those without an area are dropped with a
/// warning, and what is left is the mesh without them.
#[test]
fn slivers_stop_rays_and_triangles_without_area_are_dropped() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("strips.obj"), strips("")).unwrap();
    expect_wall_stops_what_aims_at_it(folder.path(), "file = 'strips.obj'");
    let mesh = |more: &str| {
        std::fs::write(folder.path().join("strips.obj"), strips(more)).unwrap();
        let scene = relume_scenes::load(&folder.path().join("scene.toml")).unwrap();
        (scene.objects[0].mesh.clone(), scene.warnings.join("\n"))
    };
    let (clean, none) = mesh("");
    // A line, a point, and a corner named twice.
    let (mended, warning) = mesh("f 1 3 7\nf 2 2 2\nf 1 2 1\n");
    assert_eq!(clean, mended);
    assert!(
        !none.contains("dropped") && warning.contains("dropped 3 degenerate of 19 triangles (zero area)"),
        "{none}{warning}"
    );
}

/// Huge triangles: a ball's shadow on a floor of two triangles. Right below a ball that is seen under sin α
/// the floor loses sin²α of a white sky. On a floor 4 km wide it does; on one of 4,000 km, where origins are
/// moved off the surface by more than the ball's height, the shadow is lost, and nothing else.
#[test]
fn huge_triangles_keep_what_is_not_small_beside_them() {
    for (width, expected) in [("4", 0.84), ("4e3", 0.84), ("4e6", 1.0)] {
        let text = format!(
            "[camera]\nposition = [0, 1, 4]\ntarget = [0, 0.5, 0]\nfov_deg = 40\n[render]\nsize = [8, 8]\n[environment]\n\
             [materials.m]\nbrdf = 'blinn-phong'\nkd = [1, 1, 1]\nks = [0, 0, 0]\n\
             [[object]]\nname = 'floor'\nmaterial = 'm'\nshape = 'quad'\ntransform = {{ scale = {width} }}\n\
             [[object]]\nname = 'ball'\nmaterial = 'm'\nshape = 'sphere'\nsubdivisions = 3\ntransform = {{ translation = [0, 1, 0], scale = 0.4 }}\n"
        );
        let (mean, error) =
            mean_radiance(&scene(&text), 1, 1 << 14, |_| (Vec3A::new(0.001, 0.3, 0.002), Vec3A::NEG_Y));
        // Flat triangles take 0.4 % off the ball's disc, 6e-4 of the sky.
        assert!((mean - expected).abs() < 4.0 * error + 1e-3, "{width} m: {mean} ± {error}");
    }
}
