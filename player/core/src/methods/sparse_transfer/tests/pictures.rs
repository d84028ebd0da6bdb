//! Pictures of which every pixel is known.

use super::*;
use relume_formats::basis::Filter;
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::state::{BlinnPhong, Brdf, Film as FilmPlane};

/// A camera so close to the middle of the grid that it sees nothing else.
pub(super) fn close_up() -> Camera {
    Camera { position: [0.1, 0.05, 0.5], target: [0.1, 0.05, 0.0], fov_deg: 60.0, exposure_ev: 0.0 }
}

#[test]
fn a_surface_shows_radiance_times_albedo() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::of(sparse::scene([5, 4]), sparse::maps(), None, sparse::even_transfer(20, 16, 0.25));
    let mut method = load_all(&gpu, &bundle);
    let gain = [3.0, 1.0, 2.0];
    draw(&gpu, &mut method, &Look { camera: close_up(), ..look(&bundle, &environment("even", 40.0, gain)) });
    // The even light is exact in halves; its cube and the sum over six means are off by some units in the
    // last place.
    let expected: Rgb = std::array::from_fn(|k| 0.25 * [2.0, 1.0, 0.5][k] * gain[k] * sparse::ALBEDO[k]);
    for pixel in film(&gpu, &method) {
        assert!(
            pixel.iter().zip(expected).all(|(ours, theirs)| (ours - theirs).abs() <= 2e-6 * theirs),
            "{pixel:?} is not {expected:?}"
        );
    }
    // From behind it hides the sky, and no light is known there.
    let behind = Camera { position: [0.1, 0.05, -0.5], ..close_up() };
    draw(&gpu, &mut method, &Look { camera: behind, ..look(&bundle, &environment("even", 40.0, gain)) });
    assert!(film(&gpu, &method).iter().all(|pixel| *pixel == [0.0; 3]));
}

/// A sheet with a face to each side, of which neither is nearer: the one that faces the eye is seen, wherever
/// the eye is and whichever is drawn first.
#[test]
fn of_two_faces_at_one_place_the_front_one_is_seen() {
    let Some(gpu) = gpu() else { return };
    for back_first in [false, true] {
        let mut scene = sparse::scene([5, 4]);
        scene.positions.extend_from_within(..);
        scene.normals.extend([[0.0, 0.0, -1.0]; 20]);
        let back: Vec<[u32; 3]> = scene.triangles.iter().map(|[a, b, c]| [a + 20, c + 20, b + 20]).collect();
        scene.triangles.extend(back);
        if back_first {
            scene.triangles.reverse();
        }
        scene.meta.objects[0].triangles *= 2;
        let bundle = Bundle::of(scene, sparse::maps(), None, sparse::even_transfer(40, 16, 0.25));
        let mut method = load_all(&gpu, &bundle);
        let close = close_up();
        for eye in [close.position, [0.1, 0.05, -0.5], [0.5, 0.3, 0.2], [-0.4, 0.2, -0.15]] {
            let camera = Camera { position: eye, ..close };
            draw(&gpu, &mut method, &Look { camera, ..look(&bundle, &environment("even", 0.0, [1.0; 3])) });
            let dark = film(&gpu, &method).iter().filter(|pixel| **pixel == [0.0; 3]).count();
            assert_eq!(dark, 0, "from {eye:?}, back first: {back_first}");
        }
    }
}

/// What `seen` makes of the direction of each sample, averaged by pixel.
pub(super) fn averaged(
    [width, height]: [u32; 2],
    plane: &FilmPlane,
    seen: impl Fn([f32; 3]) -> Rgb,
) -> Vec<Rgb> {
    let pixel = |index: u32| {
        let samples = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        let direction =
            |[x, y]: [f32; 2]| plane.direction((index % width) as f32 + x, (index / width) as f32 + y);
        let colours = samples.map(|sample| seen(direction(sample).to_array()));
        std::array::from_fn(|k| colours.iter().map(|colour| colour[k]).sum::<f32>() / 4.0)
    };
    (0..width * height).map(pixel).collect()
}

#[test]
fn behind_everything_stands_the_map() {
    let Some(gpu) = gpu() else { return };
    let bundle = Bundle::write(16, false);
    let mut method = load_all(&gpu, &bundle);
    let mut brightest: f32 = 0.0;
    for (map, rotation_deg, gain, towards, fov_deg) in [
        ("noise", 0.0, [1.0; 3], [0.0, 0.0, 1.0], 40.0),
        ("noise", 33.3, [0.5, 2.0, 0.0], [5.0, 2.0, 1.0], 100.0),
        ("sun", 180.0, [1.0; 3], [3.0, 8.0, 0.1], 120.0),
        ("sun", -90.0, [1.0; 3], [-4.0, -7.0, 1.0], 60.0),
        ("black", 0.0, [1.0; 3], [0.0, 9.0, 0.0], 90.0),
    ] {
        // So far away that the grid falls between samples.
        let position = [0.0, 0.0, 1e4];
        let target = std::array::from_fn(|k| position[k] + towards[k]);
        let camera = Camera { position, target, fov_deg, exposure_ev: 0.0 };
        draw(&gpu, &mut method, &Look { camera, ..look(&bundle, &environment(map, rotation_deg, gain)) });
        let (sin, cos) = rotation_deg.to_radians().sin_cos();
        let sky = |[x, y, z]: [f32; 3]| {
            let (x, z) = (cos * x - sin * z, cos * z + sin * x);
            let uv = [
                0.5 + x.atan2(-z) / std::f32::consts::TAU,
                (x * x + z * z).sqrt().atan2(y) / std::f32::consts::PI,
            ];
            let radiance = bundle.map(map).sample(uv);
            std::array::from_fn(|k| radiance[k] * gain[k])
        };
        let expected = averaged(sparse::SIZE, &camera.film(sparse::SIZE[0], sparse::SIZE[1]), sky);
        // Directions differ by some 1e-6 rad, a 20,000th of a texel of the finer map, and radiance by so much
        // of the step between two texels.
        let bound = 5e-5
            * bundle.map(map).texels.iter().flatten().fold(0.0, |m: f32, v| m.max(*v))
            * gain.into_iter().fold(0.0, f32::max);
        let film = film(&gpu, &method);
        for (ours, theirs) in film.iter().flatten().zip(expected.iter().flatten()) {
            assert!(
                (ours - theirs).abs() <= bound,
                "{map} {rotation_deg} towards {towards:?}: {ours} is not {theirs}"
            );
        }
        brightest = film.iter().flatten().fold(brightest, |m, v| m.max(*v));
    }
    assert!(brightest > 1e3, "the sun was in the picture: {brightest}");
}

#[test]
fn a_film_of_several_bands_is_one_picture() {
    let Some(gpu) = gpu() else { return };
    // So wide a band has 512 rows.
    let mut bundle =
        Bundle::of(sparse::scene([2, 2]), sparse::maps(), None, sparse::even_transfer(4, 1, 1.0));
    let size = [2048, 520];
    bundle.scene.meta.size = size;
    let mut method = load_all(&gpu, &bundle);
    assert_eq!(method.film().unwrap().bands.len(), 2);
    let camera =
        Camera { position: [0.0, 0.0, 1e4], target: [0.3, 0.1, 1e4 + 1.0], fov_deg: 40.0, exposure_ev: 0.0 };
    draw(&gpu, &mut method, &Look { camera, ..look(&bundle, &environment("noise", 0.0, [1.0; 3])) });
    let sky = |[x, y, z]: [f32; 3]| {
        let uv = [
            0.5 + x.atan2(-z) / std::f32::consts::TAU,
            (x * x + z * z).sqrt().atan2(y) / std::f32::consts::PI,
        ];
        bundle.map("noise").sample(uv)
    };
    expect_near(
        &film(&gpu, &method),
        &averaged(size, &camera.film(size[0], size[1]), sky),
        5e-5,
        "two bands",
    );
}

#[test]
fn silhouettes_are_antialiased() {
    let Some(gpu) = gpu() else { return };
    let mut scene = sparse::scene([2, 2]);
    scene.meta.environment = Some(environment("black", 0.0, [1.0; 3]));
    // Turned, so that no edge runs along the pixels.
    let (sin, cos) = 0.3_f32.sin_cos();
    scene
        .positions
        .iter_mut()
        .for_each(|[x, y, _]| (*x, *y) = (0.6 * (cos * *x - sin * *y), 0.6 * (sin * *x + cos * *y)));
    let bundle = Bundle::of(scene, sparse::maps(), None, sparse::even_transfer(4, 1, 1.0));
    let mut method = load_all(&gpu, &bundle);
    draw(&gpu, &mut method, &look(&bundle, &environment("even", 0.0, [1.0; 3])));
    let sky = film(&gpu, &method)[0];
    assert!((sky[0] - 2.0).abs() < 1e-5);
    // Of a pixel at a silhouette one, two or three samples of four are on the square, whose red is 0.8 times
    // the sky's.
    let mut counts = [0; 5];
    for pixel in film(&gpu, &method) {
        let samples = (2.0 - pixel[0]) / (2.0 - 1.6) * 4.0;
        assert!((samples - samples.round()).abs() < 1e-3, "{pixel:?}");
        counts[samples.round() as usize] += 1;
    }
    assert!(counts.iter().all(|count| *count >= 3) && counts[4] > 60, "{counts:?}");
    // The square's share of the picture: its area over that of the film at its distance.
    let plane = bundle.scene.meta.camera.film(sparse::SIZE[0], sparse::SIZE[1]).axes();
    let share = (1.2 / 3.0_f32).powi(2) / (4.0 * plane[1].length() * plane[2].length());
    let covered =
        counts.iter().enumerate().map(|(k, count)| k as f32 * *count as f32).sum::<f32>() / 4.0 / 600.0;
    // Along a perimeter of some 60 samples, an area is known to a fraction of that many samples.
    assert!((covered - share).abs() < 20.0 / 2400.0, "{covered} where {share} was expected");
}

#[test]
fn what_is_nearer_hides_what_is_farther() {
    let Some(gpu) = gpu() else { return };
    // Two squares, the nearer one smaller, and drawn first or last.
    for nearer_first in [true, false] {
        let mut scene = sparse::scene([2, 2]);
        let [near, far] = [(0.2, 0.5), (1.5, 0.0)].map(|(size, z)| {
            scene.positions.iter().map(move |p| [size * p[0], size * p[1], z]).collect::<Vec<_>>()
        });
        let objects = if nearer_first { [near, far] } else { [far, near] };
        scene.positions = objects.concat();
        scene.normals = vec![[0.0, 0.0, 1.0]; 8];
        let second: Vec<_> = scene.triangles.iter().map(|t| t.map(|i| i + 4)).collect();
        scene.triangles.extend(second);
        let dark = BlinnPhong { kd: [0.0; 3], ks: [0.0; 3], shininess: 1.0 };
        let mut black = scene.meta.materials[0].clone();
        (black.name, black.brdf) = ("black".to_owned(), Brdf::BlinnPhong(dark));
        scene.meta.materials.push(black);
        let mut other = scene.meta.objects[0].clone();
        other.name = "other".to_owned();
        scene.meta.objects.push(other);
        scene.meta.objects[usize::from(!nearer_first)].material = scene.meta.materials.len() as u32 - 1;
        let bundle = Bundle::of(scene, sparse::maps(), None, sparse::even_transfer(8, 1, 1.0));
        let mut method = load_all(&gpu, &bundle);
        draw(&gpu, &mut method, &look(&bundle, &environment("even", 0.0, [1.0; 3])));
        let film = film(&gpu, &method);
        let [width, height] = sparse::SIZE;
        assert_eq!(film[(height / 2 * width + width / 2) as usize], [0.0; 3], "the nearer square is black");
        assert!(
            (film[(width / 2) as usize][0] - 1.6).abs() < 1e-5,
            "beside it is the farther one: {:?}",
            film[(width / 2) as usize]
        );
    }
}

#[test]
fn textures_colour_surfaces_and_cut_holes() {
    let Some(gpu) = gpu() else { return };
    textures_are_those_of_the_cpu(&gpu, Filter::Linear);
    textures_are_those_of_the_cpu(&gpu, Filter::Nearest);
}

fn textures_are_those_of_the_cpu(gpu: &Gpu, filter: Filter) {
    let scene = sparse::scene([4, 4]);
    let textures = sparse::textures(&scene, filter);
    let bundle = Bundle::of(scene, sparse::maps(), Some(&textures), sparse::even_transfer(16, 4, 1.0));
    let mut method = load_all(gpu, &bundle);
    let camera = close_up();
    draw(gpu, &mut method, &Look { camera, ..look(&bundle, &environment("even", 0.0, [1.0; 3])) });
    let MaterialTexture { texture, alpha_cutoff, .. } = &textures.textures[0];
    let (mut holes, even) = (std::cell::Cell::new(0), [2.0, 1.0, 0.5]);
    let seen = |direction: [f32; 3]| {
        let reach = -camera.position[2] / direction[2];
        let [x, y] = [0, 1].map(|k| camera.position[k] + reach * direction[k]);
        let [r, g, b, alpha] = texture.sample([x + 0.3, 0.4 - y]);
        if alpha < alpha_cutoff.unwrap() {
            holes.set(holes.get() + 1);
            return even;
        }
        std::array::from_fn(|k| even[k] * sparse::ALBEDO[k] * [r, g, b][k])
    };
    let expected = averaged(sparse::SIZE, &camera.film(sparse::SIZE[0], sparse::SIZE[1]), seen);
    // Alpha at the very edge of a hole may fall to either side.
    let differ = |(ours, theirs): &(Rgb, &Rgb)| ours.iter().zip(*theirs).any(|(a, b)| (a - b).abs() > 1e-4);
    let differing = film(gpu, &method).into_iter().zip(&expected).filter(differ).count();
    assert!(differing <= 3, "{filter:?}: {differing} pixels differ");
    assert!((100..2000).contains(holes.get_mut()), "{holes:?}");
}
