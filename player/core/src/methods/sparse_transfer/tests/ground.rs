//! Textures that are seen so small that a sample covers many texels, against brute force.

use super::*;
use relume_formats::basis::{Filter, Texture, Wrap};
use relume_formats::kinds::Textures;
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::state::Camera;

/// Film size.
const SIZE: [u32; 2] = [96, 72];
/// Samples along a side of a pixel of brute force.
const BRUTE: u32 = 64;
/// Half a side of the ground, metres; texture coordinates are metres, turned.
const REACH: f32 = 300.0;

/// A texture of `side` texels a side.
fn texture(side: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
    let texels = (0..side * side).map(|i| texel(i % side, i / side)).collect();
    Texture { size: [side; 2], wrap: [Wrap::Repeat; 2], filter: Filter::Linear, texels }
}

/// Two by two squares, black and white.
fn checks() -> Texture {
    texture(64, |x, y| if (x / 32 + y / 32).is_multiple_of(2) { [255; 4] } else { [0, 0, 0, 255] })
}

/// A pattern of every scale: a sum of four octaves of noise.
fn noise() -> Texture {
    // SplitMix64's finish.
    let random = |seed: u64| {
        let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    };
    let octave = |x: u32, y: u32, size: u32| {
        random(u64::from(((x / size) << 16) + ((y / size) << 8) + size).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    };
    texture(256, |x, y| {
        let value = [1, 4, 16, 64].map(|size| octave(x, y, size)).iter().sum::<f32>() / 4.0;
        [(255.0 * value) as u8, (200.0 * value) as u8, 90, 255]
    })
}

/// A ground with this texture, turned by `turn_deg`, to the horizon.
fn ground(texture: &Texture, alpha_cutoff: Option<f32>, turn_deg: f32) -> Bundle {
    let mut scene = sparse::scene([2, 2]);
    scene.meta.size = SIZE;
    let corners = [[-REACH, REACH], [REACH, REACH], [-REACH, -REACH], [REACH, -REACH]];
    for (position, [x, z]) in scene.positions.iter_mut().zip(corners) {
        *position = [x, 0.0, z];
    }
    scene.normals = vec![[0.0, 1.0, 0.0]; 4];
    scene.triangles = vec![[0, 1, 2], [1, 3, 2]];
    scene.meta.camera =
        Camera { position: [0.0, 1.0, 0.0], target: [0.0, 0.6, -1.0], fov_deg: 50.0, exposure_ev: 0.0 };
    let uvs = scene.positions.iter().map(|p| uv(turn_deg, [p[0], p[2]])).collect();
    let material = MaterialTexture { material: 0, alpha_cutoff, texture: texture.clone() };
    let textures = Textures { uvs, textures: vec![material] };
    Bundle::of(scene, sparse::maps(), Some(&textures), sparse::even_transfer(4, 4, 1.0))
}

fn uv(turn_deg: f32, [x, z]: [f32; 2]) -> [f32; 2] {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    [cos * x - sin * z, sin * x + cos * z]
}

/// What the GPU shows of the ground in an even light, as factors on that of white.
fn shown(gpu: &Gpu, bundle: &Bundle) -> Vec<Rgb> {
    let mut method = load_all(gpu, bundle);
    draw(gpu, &mut method, &look(bundle, &environment("even", 0.0, [1.0; 3])));
    let white: Rgb = std::array::from_fn(|k| [2.0, 1.0, 0.5][k] * sparse::ALBEDO[k]);
    film(gpu, &method).into_iter().map(|rgb| std::array::from_fn(|k| rgb[k] / white[k])).collect()
}

/// By pixel the mean of `seen` at many places of the ground, `None` where some of them are not on it.
fn brute_force<const N: usize>(
    camera: &Camera,
    seen: impl Fn([f32; 2]) -> [f32; N],
) -> Vec<Option<[f32; N]>> {
    let plane = camera.film(SIZE[0], SIZE[1]);
    let pixel = |index: u32| {
        let mut sum = [0.0; N];
        for sample in 0..BRUTE * BRUTE {
            let at = |of: u32, k: u32| of as f32 + (k as f32 + 0.5) / BRUTE as f32;
            let direction =
                plane.direction(at(index % SIZE[0], sample % BRUTE), at(index / SIZE[0], sample / BRUTE));
            let place = [0, 2].map(|k| -camera.position[1] * direction[k] / direction[1]);
            if direction[1] >= 0.0 || place.iter().any(|x| x.abs() > REACH) {
                return None;
            }
            let seen = seen(place);
            (0..N).for_each(|k| sum[k] += seen[k]);
        }
        Some(sum.map(|x| x / (BRUTE * BRUTE) as f32))
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// Root of the mean square of the differences, over pixels that show nothing but ground.
fn rms(ours: &[Rgb], theirs: &[Option<Rgb>]) -> f32 {
    let pairs = ours.iter().zip(theirs).filter_map(|(ours, theirs)| theirs.map(|theirs| (ours, theirs)));
    let squares: Vec<f32> =
        pairs.map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>() / 3.0).collect();
    (squares.iter().sum::<f32>() / squares.len() as f32).sqrt()
}

/// What four samples a pixel show of the texture as it is.
fn four_samples(camera: &Camera, seen: impl Fn([f32; 2]) -> Rgb) -> Vec<Rgb> {
    let place = |direction: [f32; 3]| [0, 2].map(|k| -camera.position[1] * direction[k] / direction[1]);
    pictures::averaged(SIZE, &camera.film(SIZE[0], SIZE[1]), |direction| seen(place(direction)))
}

#[test]
fn a_ground_to_the_horizon_is_the_mean_of_what_pixels_cover() {
    let Some(gpu) = gpu() else { return };
    let sharp = Texture { filter: Filter::Nearest, ..noise() };
    for (name, texture, turn_deg) in [
        ("checks", checks(), 0.0),
        ("checks", checks(), 33.0),
        ("noise", noise(), 70.0),
        ("sharp", sharp, 5.0),
    ] {
        let bundle = ground(&texture, None, turn_deg);
        let camera = bundle.scene.meta.camera;
        let seen = |place| {
            let [r, g, b, _] = texture.sample(uv(turn_deg, place));
            [r, g, b]
        };
        let expected = brute_force(&camera, seen);
        assert!(expected.iter().flatten().count() > 6000);
        let (ours, before) =
            (rms(&shown(&gpu, &bundle), &expected), rms(&four_samples(&camera, seen), &expected));
        // What is left are edges that are magnified, which have four samples as before, and that boxes are
        // not those of the pixels: a tenth. The mean over the longer axis both ways would leave a third.
        assert!(ours <= before / 5.0, "{name} turned by {turn_deg}: RMS {ours}, of four samples {before}");
    }
}

#[test]
fn holes_neither_close_nor_grow_far_away() {
    let Some(gpu) = gpu() else { return };
    // White squares, and holes that are black around them.
    let squares = texture(64, |x, y| if x < 40 && y < 40 { [255; 4] } else { [0; 4] });
    let turn_deg = 20.0;
    let bundle = ground(&squares, Some(0.5), turn_deg);
    let covers = |place| [f32::from(u8::from(squares.sample(uv(turn_deg, place))[3] >= 0.5))];
    let expected = brute_force(&bundle.scene.meta.camera, covers);
    let red: Vec<f32> = shown(&gpu, &bundle).into_iter().map(|pixel| pixel[0]).collect();
    // Of red, the sky behind the holes has more than the squares.
    let sky = 1.0 / sparse::ALBEDO[0];
    let width = SIZE[0] as usize;
    let (mut rows, mut sums) = (0.0, [0.0; 2]);
    for (row, pixels) in red.chunks(width).enumerate().take(45) {
        let Some(expected) = expected[row * width..][..width].iter().copied().collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        // Down to the last of these rows a sample covers more than a texel along its longer axis.
        assert!(pixels.iter().all(|red| *red >= 0.999), "row {row} has a dark fringe");
        let ours = pixels.iter().map(|red| (sky - red) / (sky - 1.0)).sum::<f32>() / width as f32;
        let theirs = expected.iter().map(|[covers]| covers).sum::<f32>() / width as f32;
        // 384 samples: five times their standard deviation.
        assert!((ours - theirs).abs() < 5.0 * 0.5 / 384.0_f32.sqrt(), "row {row}: {ours}, expected {theirs}");
        (rows, sums) = (rows + 1.0, [sums[0] + ours, sums[1] + theirs]);
    }
    assert!(rows > 30.0);
    assert!((sums[0] - sums[1]).abs() / rows < 0.02, "{sums:?} of {rows} rows");
}
