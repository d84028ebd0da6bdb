//! transfer-tensor: lights that no map has, slow turns, materials that change places, and what no light
//! reaches.

use crate::support::{expect_exit, radiance_in, relative_l2, write_scene};
use relume_bake::exr_file::write_exr;
use relume_formats::basis::hemisphere::TEXELS;
use relume_formats::container::Stored;
use relume_formats::kinds::TransferTensor;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Two equal balls on a floor, one to the left and one to the right of the camera's plane, and a small one inside
/// the right one.
const BALLS: &str = "
    [vary]
    light = true
    view = true
    materials = ['left', 'right']
    [render]
    size = [64, 40]
    reflections = 2
    [camera]
    position = [0.0, 1.0, 4.0]
    target = [0.0, 0.4, 0.0]
    fov_deg = 32.0
    [materials.left]
    brdf = 'ggx'
    base_color = [0.8, 0.5, 0.2]
    metallic = 1.0
    roughness = 0.4
    [materials.right]
    brdf = 'ggx'
    base_color = [0.1, 0.2, 0.7]
    metallic = 0.0
    roughness = 0.7
    [materials.floor]
    brdf = 'ggx'
    base_color = [0.6, 0.6, 0.6]
    metallic = 0.0
    roughness = 1.0
    [[object]]
    name = 'floor'
    shape = 'quad'
    segments = 12
    material = 'floor'
    transform = { scale = 4.0 }
    [[object]]
    name = 'left'
    shape = 'sphere'
    subdivisions = 3
    material = 'left'
    transform = { translation = [-0.6, 0.5, 0.0], scale = 0.5 }
    [[object]]
    name = 'right'
    shape = 'sphere'
    subdivisions = 3
    material = 'right'
    transform = { translation = [0.6, 0.5, 0.0], scale = 0.5 }
    [[object]]
    name = 'within'
    shape = 'sphere'
    subdivisions = 1
    material = 'floor'
    transform = { translation = [0.6, 0.5, 0.0], scale = 0.2 }
    [environment]
    file = 'blob.exr'
    others = ['texel.exr']
";
/// Of the ball within, the last of the scene.
const WITHIN: usize = 42;

struct Baked {
    folder: TempDir,
}

/// One bake for all that is looked at here.
#[test]
fn light_and_materials_at_their_ends() {
    let baked = Baked::new();
    no_light_is_black_and_one_texel_is_in_proportion(&baked);
    a_light_that_turns_over_an_edge_of_the_cube_makes_no_jump(&baked);
    materials_that_change_places_mirror_the_picture(&baked);
    a_vertex_inside_another_object_is_dark(&baked);
}

fn write_map(path: &Path, [width, height]: [usize; 2], texel: impl Fn(usize, usize) -> f32) {
    let plane: Vec<f32> = (0..width * height).map(|i| texel(i % width, i / width)).collect();
    write_exr(path, width, height, &[("R", &plane), ("G", &plane), ("B", &plane)]).unwrap();
}

impl Baked {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        // 60° wide, in the camera's plane and as wide on either side of it; and one texel alone, of 45°.
        let blob = |x: usize, y: usize| {
            let at = |k: usize, n: usize| (k as f32 + 0.5) / n as f32 - 0.5;
            0.2 + 4.0 * (-(2.0 * at(x, 128)).powi(2) / 0.03 - (at(y, 64) + 0.15).powi(2) / 0.03).exp()
        };
        write_map(&folder.path().join("blob.exr"), [128, 64], blob);
        let texel = |x: usize, y: usize| if (x, y) == (4, 1) { 50.0 } else { 0.0 };
        write_map(&folder.path().join("texel.exr"), [8, 4], texel);
        let scene = write_scene(folder.path(), BALLS).display().to_string();
        let bundle = folder.path().join("bundle").display().to_string();
        expect_exit("bake", &["run", &scene, "--quality", "draft", "-o", &bundle, "--progress", "none"], 0);
        Self { folder }
    }

    fn bundle(&self) -> PathBuf {
        self.folder.path().join("bundle")
    }

    /// The pictures of `states`, one a frame; every value is a number and none is below 0.
    fn pictures(&self, states: &[String]) -> Vec<Vec<[f32; 3]>> {
        let work = tempfile::tempdir().unwrap();
        let mut animation = format!("duration_s = {}.0\n", states.len());
        for (second, state) in states.iter().enumerate() {
            write!(animation, "[[key]]\nt_s = {second}.0\n{state}\n").unwrap();
        }
        let file = work.path().join("states.toml");
        std::fs::write(&file, animation).unwrap();
        let [file, pattern] = [file, work.path().join("%02d.exr")].map(|path| path.display().to_string());
        let (bundle, count) = (self.bundle().display().to_string(), states.len().to_string());
        let play = ["--headless", "--animation", &file, "--fps", "1", "--count", &count, "--exr", &pattern];
        expect_exit("player", &[&[&bundle[..]], &play[..]].concat(), 0);
        let picture = |frame: usize| {
            let pixels = radiance_in(&work.path().join(format!("{frame:02}.exr")));
            let sound = |value: &f32| value.is_finite() && *value >= 0.0;
            assert!(pixels.as_flattened().iter().all(sound), "{}", states[frame]);
            pixels
        };
        (0..states.len()).map(picture).collect()
    }
}

/// Nothing shines where nothing is lit; and a map of one texel, which is lit nowhere else, gives twice the light
/// for twice the gain.
fn no_light_is_black_and_one_texel_is_in_proportion(baked: &Baked) {
    let light =
        |map: &str, gain: f32| format!("environment = {{ map = '{map}', gain = [{gain}, {gain}, {gain}] }}");
    let states =
        [light("blob.exr", 0.0), light("texel.exr", 0.0), light("texel.exr", 1.0), light("texel.exr", 2.0)];
    let pictures = baked.pictures(&states);
    assert!(pictures[..2].concat().iter().all(|pixel| *pixel == [0.0; 3]));
    let twice: Vec<[f32; 3]> = pictures[2].iter().map(|pixel| pixel.map(|value| 2.0 * value)).collect();
    assert!(pictures[2].as_flattened().iter().any(|value| *value > 0.1));
    assert!(relative_l2(&pictures[3], &twice) < 1e-5, "{}", relative_l2(&pictures[3], &twice));
}

/// A light that turns over an edge of the cube by quarter degrees changes the picture by as much in each step: no
/// step is twice the mean one.
fn a_light_that_turns_over_an_edge_of_the_cube_makes_no_jump(baked: &Baked) {
    let states: Vec<String> = (0..33)
        .map(|k| format!("environment = {{ map = 'blob.exr', rotation_deg = {} }}", 41.0 + 0.25 * k as f32))
        .collect();
    let pictures = baked.pictures(&states);
    let steps: Vec<f64> = pictures.windows(2).map(|pair| relative_l2(&pair[1], &pair[0])).collect();
    let (mean, largest) =
        (steps.iter().sum::<f64>() / steps.len() as f64, steps.iter().copied().fold(0.0, f64::max));
    println!("steps: mean {mean:.5}, largest {largest:.5}");
    assert!(mean > 1e-3 && largest < 2.0 * mean, "mean {mean}, largest {largest}");
}

/// Two materials that change places, under light that is the same from either side: the picture is mirrored, but
/// for what the rays of a draft differ by from vertex to vertex.
fn materials_that_change_places_mirror_the_picture(baked: &Baked) {
    let state = |left: &str, right: &str| {
        format!("environment = {{ map = 'blob.exr' }}\nmaterials.left = {left}\nmaterials.right = {right}")
    };
    let metal = "{ base_color = [0.9, 0.6, 0.3], metallic = 1.0, roughness = 0.35 }";
    let paint = "{ base_color = [0.1, 0.5, 0.2], metallic = 0.0, roughness = 0.5 }";
    let pictures = baked.pictures(&[state(metal, paint), state(paint, metal)]);
    let mirrored: Vec<[f32; 3]> = pictures[0].chunks(64).flat_map(|row| row.iter().rev().copied()).collect();
    let found = relative_l2(&pictures[1], &mirrored);
    println!("mirrored: {found:.4}, not mirrored {:.4}", relative_l2(&pictures[1], &pictures[0]));
    assert!(found < 0.02, "{found}");
    assert!(relative_l2(&pictures[1], &pictures[0]) > 0.05, "they differ");
}

/// What lies inside a closed ball receives nothing, and sees nothing.
fn a_vertex_inside_another_object_is_dark(baked: &Baked) {
    let transfer = TransferTensor::read_file(&baked.bundle().join("transfer-tensor.relume")).unwrap();
    let (meta, once) = (&transfer.meta, transfer.once.as_ref().unwrap());
    let within = meta.vertices as usize - WITHIN..meta.vertices as usize;
    for vertex in within {
        for (block, terms) in transfer.blocks.iter().zip(&meta.blocks) {
            let lit = (0..*terms as usize).any(|term| block.value(meta, term, vertex, 0) != 0.0);
            assert!(!lit, "vertex {vertex}");
        }
        assert!(transfer.seen[vertex * TEXELS..][..TEXELS].iter().all(|seen| *seen == 0), "vertex {vertex}");
        let of_vertex = meta.sources.len() * meta.ranks[0] as usize;
        let shares = &once.shares[vertex * of_vertex..][..of_vertex];
        assert!(shares.iter().all(|share| *share == 0), "vertex {vertex}");
    }
}
