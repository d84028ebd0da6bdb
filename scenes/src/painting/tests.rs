//! Every point of what wears a material has a place of its own.

use super::*;
use crate::scene::Mesh;
use crate::test_support::Scratch;

/// What wears the material `paint` in a scene, and why an atlas was made.
fn painting(scene: &Scene, paint: usize) -> (Painting, Option<String>) {
    match Painting::of_meshes(scene, paint) {
        Ok(painting) => (painting, None),
        Err(why) => (Painting::of_atlas(scene, paint, |_| true).unwrap().unwrap(), Some(why)),
    }
}

fn scene(objects: &str) -> (Scene, usize) {
    let text = format!(
        "[render]\nsize = [8, 8]\n[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_deg = 40\n\
         [materials.paint]\nbrdf = 'blinn-phong'\nkd = [0.5, 0.5, 0.5]\n[materials.other]\nbrdf = 'blinn-phong'\n{objects}"
    );
    let scratch = Scratch::scene(&text);
    scratch.write("bare.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
    let scene = scratch.load().unwrap();
    let paint = scene.materials.iter().position(|m| m.name == "paint").unwrap();
    (scene, paint)
}

fn object(name: &str, keys: &str) -> String {
    format!("[[object]]\nname = '{name}'\nmaterial = 'paint'\n{keys}\n")
}

/// All are within the square, none lies over another, and of the surface hardly anything has no area there, or
/// much less or more than its share.
fn expect_sound(painting: &Painting, is_atlas: bool, scene: &Scene) {
    let mut cover = Cover::new(CELLS);
    let mut areas = Vec::new();
    for (number, triangles) in &painting.objects {
        let mesh = &scene.objects[*number].mesh;
        assert_eq!(triangles.len(), mesh.triangles.len());
        for (corners, triangle) in triangles.iter().zip(&mesh.triangles) {
            assert!(
                corners.as_flattened().iter().all(|x| (-OUTSIDE..=1.0 + OUTSIDE).contains(x)),
                "{corners:?}"
            );
            cover.add(corners);
            let of_surface = area(triangle.map(|vertex| mesh.positions[vertex as usize]));
            areas.push((of_surface, cover::signed_area(corners).abs()));
        }
    }
    assert!(cover.twice() < 0.1 * OVERLAPPING * cover.once());
    let [all, in_square] = [areas.iter().map(|(a, _)| a).sum::<f64>(), areas.iter().map(|(_, a)| a).sum()];
    let uneven = |(of_surface, of_square): &&(f64, f64)| {
        let ratio = (of_square / in_square) / (of_surface / all);
        is_atlas && !(0.2..=5.0).contains(&ratio)
    };
    let uneven: f64 = areas.iter().filter(uneven).map(|(area, _)| area).sum();
    assert!(uneven < 0.01 * all, "{uneven} of {all}");
    // A tenth of the square at least, so that regions are worth their number.
    assert!(in_square > 0.1, "{in_square}");
}

#[test]
fn coordinates_of_meshes_serve_if_every_point_has_a_place_of_its_own() {
    for (objects, why) in [
        (object("floor", "shape = 'quad'"), None),
        (object("floor", "shape = 'quad'\nsegments = 40"), None),
        (object("ball", "shape = 'sphere'"), Some("those of `ball` leave the square from 0 to 1")),
        (object("bare", "file = 'bare.off'"), Some("`bare` has none")),
        (object("cube", "shape = 'box'"), Some("those of `cube` overlap with others")),
        (
            object("a", "shape = 'quad'")
                + &object("b", "shape = 'quad'\ntransform = { translation = [0, 1, 0] }"),
            Some("those of `b` overlap with others"),
        ),
        (object("tire", "shape = 'torus'"), Some("those of `tire` leave the square from 0 to 1")),
    ] {
        let (scene, paint) = scene(&objects);
        let (painting, because) = painting(&scene, paint);
        assert_eq!(because.as_deref(), why, "{objects}");
        expect_sound(&painting, because.is_some(), &scene);
    }
}

/// However small the places are that two surfaces share, and however small all of them are.
#[test]
fn small_coordinates_do_not_serve() {
    let of = |size: f32, apart: f32| {
        let (mut scene, paint) =
            scene(&(object("a", "file = 'bare.off'") + &object("b", "file = 'bare.off'")));
        for (number, object) in scene.objects.iter_mut().enumerate() {
            let from = apart * number as f32;
            let uvs =
                [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[u, v]| [from + size * u, size * v]);
            let mesh = Mesh { uvs: uvs.to_vec(), ..(*object.mesh).clone() };
            object.mesh = std::sync::Arc::new(mesh);
        }
        Painting::of_meshes(&scene, paint).map(|_| ())
    };
    assert_eq!(of(0.4, 0.5), Ok(()));
    let overlap = "some overlap with others";
    assert!([0.4, 0.12, 0.03].iter().all(|size| of(*size, 0.0).unwrap_err().contains("overlap with others")));
    assert_eq!(of(0.03, 0.01), Err(overlap.to_owned()));
    let small = "they take up less than a hundredth of the square from 0 to 1";
    assert_eq!((of(0.03, 0.5), of(1e-6, 0.0)), (Err(small.to_owned()), Err(small.to_owned())));
}

#[test]
fn an_atlas_is_given_up_if_nobody_waits_for_it() {
    let (scene, paint) = scene(&object("cube", "shape = 'box'"));
    assert_eq!(Painting::of_atlas(&scene, paint, |_| false).unwrap(), None);
    let (nobody, _) =
        (Painting::of_meshes(&Scene { objects: Vec::new(), ..scene.clone() }, paint).unwrap(), ());
    assert!(nobody.is_empty() && !nobody.covered(8).contains(&true));
}

#[test]
fn points_of_other_materials_are_nowhere_and_corners_where_they_are_said_to_be() {
    let other = "[[object]]\nname = 'wall'\nmaterial = 'other'\nshape = 'quad'\n";
    let (scene, paint) = scene(&(other.to_owned() + &object("floor", "shape = 'quad'")));
    let (painting, _) = painting(&scene, paint);
    assert_eq!(painting.at(0, 0, [0.2, 0.2]), None);
    assert_eq!(painting.at(1, 2, [0.2, 0.2]), None, "it has two triangles");
    let [a, b, c] = painting.objects[&1][0];
    assert_eq!([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|at| painting.at(1, 0, at).unwrap()), [a, b, c]);
    let middle = painting.at(1, 0, [1.0 / 3.0; 2]).unwrap();
    assert!((0..2).all(|k| (middle[k] - (a[k] + b[k] + c[k]) / 3.0).abs() < 1e-6));
    assert!(painting.covered(64).iter().all(|covered| *covered));
}

#[test]
fn regions_are_numbered_row_by_row() {
    let last = REGIONS - 1;
    for (uv, region) in [
        ([0.0, 0.0], 0),
        ([0.999 / REGIONS as f32, 0.0], 0),
        ([1.001 / REGIONS as f32, 0.0], 1),
        ([0.0, 0.5], REGIONS * REGIONS / 2),
        ([1.0, 1.0], last * REGIONS + last),
    ] {
        assert_eq!(region_of(uv), region, "{uv:?}");
    }
}

#[test]
fn an_atlas_is_the_same_at_any_number_of_threads() {
    let objects = object("knot", "shape = 'torus-knot'") + &object("cube", "shape = 'box'");
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (scene, paint) = scene(&objects);
        pool.install(|| painting(&scene, paint))
    };
    let one = with(1);
    assert!(one.1.is_some());
    assert_eq!(with(3), one);
}

/// Jittered grids, whose triangles share all their edges, cover every cell once, whichever way they are turned.
#[test]
fn triangles_that_share_edges_cover_every_cell_once() {
    const SIDE: u32 = 97;
    for seed in 0..20u32 {
        let count = 2 + seed as usize % 9;
        let jitter = |k: usize| {
            (((k as u32 + 977 * seed).wrapping_mul(2_654_435_761) >> 8) as f32 / 16_777_216.0 - 0.5) * 0.8
        };
        let point = |x: usize, y: usize| {
            let inner = |n: usize| n > 0 && n < count;
            let at = |n: usize, k: usize| (n as f32 + if inner(n) { jitter(k) } else { 0.0 }) / count as f32;
            [at(x, 2 * (y * (count + 1) + x)), at(y, 2 * (y * (count + 1) + x) + 1)]
        };
        let mut cover = Cover::new(SIDE);
        for (x, y) in (0..count).flat_map(|y| (0..count).map(move |x| (x, y))) {
            let [a, b, c, d] = [point(x, y), point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)];
            // Cut by the diagonal that leaves both triangles the right way round.
            let halves = match cover::signed_area(&[a, b, c]) > 0.0 && cover::signed_area(&[a, c, d]) > 0.0 {
                true => [[a, b, c], [c, a, d]],
                false => [[b, c, d], [d, a, b]],
            };
            halves.iter().for_each(|corners| cover.add(corners));
        }
        assert!(cover.counts.iter().all(|count| *count == 1), "{seed}");
    }
}
