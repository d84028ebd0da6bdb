//! Painted materials, by both kinds of paths of references.

use crate::support::{command, job, write_scene};
use relume_bake::exr_file::write_exr;
use relume_bake::paintings::paintings;
use relume_bake::trace::reference::{self, Estimate, Paths, Settings};
use relume_formats::Place;
use relume_formats::state::State;
use relume_scenes::Scene;
use std::f32::consts::PI;
use std::path::Path;
use tempfile::TempDir;

const BOTH: [Paths; 2] = [Paths::Best, Paths::Gather];

/// A floor of two metres that fills the film, seen from above so that the right is +x and below is +z, under a
/// sun of irradiance 2 straight above it. Of the textures of a quad the upper left corner is at −x, −z.
const FLOOR: &str = "[vary]\nmaterials = ['m']\npainted = ['m']\n[render]\nsize = [16, 16]\nreflections = 1\n\
    [camera]\nposition = [0, 10, 0.0001]\ntarget = [0, 0, 0]\nfov_deg = 11.4\n\
    [materials.m]\nbrdf = 'blinn-phong'\nkd = [0.3, 0.3, 0.3]\nks = [0.1, 0.1, 0.1]\nshininess = 10\n\
    [[light]]\nname = 's'\nkind = 'directional'\nirradiance = [2, 2, 2]\ntransform = { rotation_deg = [-90, 0, 0] }\n\
    [[object]]\nname = 'floor'\nmaterial = 'm'\nshape = 'quad'\ntransform = { scale = 2 }\n";

/// A room of one painted and three plain sides under a lamp.
const CORNER: &str = "[vary]\nmaterials = ['m']\npainted = ['m']\n[render]\nsize = [12, 12]\n\
    [camera]\nposition = [0.4, 0.8, 2.2]\ntarget = [-0.1, 0.3, 0]\nfov_deg = 45\n\
    [materials.m]\nbrdf = 'blinn-phong'\nkd = [0.3, 0.3, 0.3]\nks = [0.1, 0.1, 0.1]\nshininess = 10\n\
    [materials.white]\nbrdf = 'blinn-phong'\nkd = [0.8, 0.8, 0.8]\n\
    [[light]]\nname = 'l'\nkind = 'area'\nradiance = [6, 6, 6]\n\
    transform = { translation = [0.3, 1.4, 0.3], rotation_deg = [-90, 0, 0], scale = 0.6 }\n\
    [[object]]\nname = 'floor'\nmaterial = 'white'\nshape = 'quad'\ntransform = { scale = 2 }\n\
    [[object]]\nname = 'wall'\nmaterial = 'm'\nshape = 'quad'\n\
    transform = { scale = 2, rotation_deg = [0, 0, -90], translation = [-0.6, 1, 0] }\n";

struct Workshop {
    folder: TempDir,
    scene: Scene,
}

impl Workshop {
    fn new(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let scene = relume_scenes::load(&write_scene(folder.path(), text)).unwrap();
        Self { folder, scene }
    }

    fn texture(&self, name: &str, size: [usize; 2], value: impl Fn(usize, usize) -> [f32; 3]) {
        write_texture(self.folder.path(), name, size, value);
    }

    fn state(&self, text: &str) -> Scene {
        let file = self.folder.path().join("s.toml");
        std::fs::write(&file, text).unwrap();
        self.scene.with_state(&State::read_file(&file).unwrap(), &Place::file(&file)).unwrap()
    }

    /// What states look like, of which gather paths serve all.
    fn render(&self, states: &[Scene], paths: Paths, samples: u32) -> Vec<Estimate> {
        let Scene { size, reflections, .. } = self.scene;
        let settings = Settings { size, samples, seed: 5, reflections, paths, target: None };
        let paintings = paintings(&self.scene, &job()).unwrap();
        reference::render(&self.scene, states, &paintings, &settings, &job()).unwrap()
    }
}

fn write_texture(folder: &Path, name: &str, size: [usize; 2], value: impl Fn(usize, usize) -> [f32; 3]) {
    let plane = |k: usize| -> Vec<f32> {
        (0..size[0] * size[1]).map(|i| value(i % size[0], i / size[0])[k]).collect()
    };
    let [r, g, b] = [0, 1, 2].map(plane);
    write_exr(&folder.join(name), size[0], size[1], &[("R", &r[..]), ("G", &g), ("B", &b)]).unwrap();
}

/// The same radiance to the bit: texels alike are interpolated without rounding, and the paths are the same.
#[test]
fn even_textures_are_the_numbers_that_they_hold() {
    for text in [FLOOR, CORNER] {
        let shop = Workshop::new(text);
        shop.texture("kd.exr", [3, 2], |_, _| [0.1, 0.5, 0.25]);
        shop.texture("s.exr", [1, 1], |_, _| [60.0; 3]);
        let states = [
            shop.state("[materials.m]\nkd = [0.1, 0.5, 0.25]\nks = [0.3, 0.3, 0.3]\nshininess = 60"),
            shop.state("[materials.m]\nkd = 'kd.exr'\nks = [0.3, 0.3, 0.3]\nshininess = 's.exr'"),
        ];
        for paths in BOTH {
            let [numbers, textures] = shop.render(&states, paths, 16).try_into().unwrap();
            assert!(numbers.radiance.iter().flatten().any(|x| *x > 0.0));
            assert_eq!(numbers, textures, "{paths:?}");
        }
    }
}

/// Radiance kd/π · E on either side, texels as far apart as pixels: rounding alone is left.
#[test]
fn each_half_of_a_floor_has_its_own_colour() {
    let shop = Workshop::new(FLOOR);
    let [left, right] = [[0.1f32, 0.5, 0.25], [0.7, 0.0, 0.9]];
    shop.texture("kd.exr", [16, 1], |x, _| if x < 8 { left } else { right });
    shop.texture("rows.exr", [1, 16], |_, y| if y < 8 { left } else { right });
    let states = [
        shop.state("[materials.m]\nkd = 'kd.exr'\nks = [0, 0, 0]"),
        shop.state("[materials.m]\nkd = 'rows.exr'\nks = [0, 0, 0]"),
    ];
    for paths in BOTH {
        for (image, by_rows) in shop.render(&states, paths, 4).iter().zip([false, true]) {
            for (index, radiance) in image.radiance.iter().enumerate() {
                let at = if by_rows { index / 16 } else { index % 16 };
                // Those in the middle see the transition.
                if (7..9).contains(&at) {
                    continue;
                }
                let kd = if at < 8 { left } else { right };
                for (radiance, kd) in radiance.iter().zip(kd) {
                    let expected = kd / PI * 2.0;
                    assert!(
                        (radiance - expected).abs() < 2e-5,
                        "{paths:?}, {by_rows}, {index}: {radiance} {expected}"
                    );
                }
            }
        }
    }
}

/// Straight from above and straight below the sun ks·(s+2)/2π · E is added, by the exponent of each channel.
#[test]
fn channels_have_exponents_of_their_own() {
    let shop = Workshop::new(&FLOOR.replace("fov_deg = 11.4", "fov_deg = 0.1").replace("[16, 16]", "[1, 1]"));
    let exponents = [4.0f32, 20.0, 150.0];
    shop.texture("s.exr", [2, 2], |_, _| exponents);
    let states =
        [shop.state("[materials.m]\nkd = [0.2, 0.2, 0.2]\nks = [0.5, 0.4, 0.3]\nshininess = 's.exr'")];
    for paths in BOTH {
        let radiance = shop.render(&states, paths, 4)[0].radiance[0];
        for (channel, (ks, exponent)) in [0.5, 0.4, 0.3].into_iter().zip(exponents).enumerate() {
            let expected = 2.0 * (0.2 / PI + ks * (exponent + 2.0) / (2.0 * PI));
            // Half vectors lie up to 0.05° off the normal.
            assert!((radiance[channel] / expected - 1.0).abs() < 1e-4, "{paths:?}: {radiance:?} {expected}");
        }
    }
}

/// A scene's texture multiplies the material's colour, and is replaced by a state's.
#[test]
fn textures_of_states_replace_those_of_scenes() {
    let folder = tempfile::tempdir().unwrap();
    // Grey 188 is linear 0.5029.
    let png = relume_chart::picture::alone(&[[0.5; 3]; 4], [2, 2], 0.0).unwrap();
    std::fs::write(folder.path().join("grey.png"), png).unwrap();
    let text = FLOOR.replace("shininess = 10\n", "shininess = 10\ntexture = 'grey.png'\n");
    let scene = relume_scenes::load(&write_scene(folder.path(), &text)).unwrap();
    let shop = Workshop { folder, scene };
    shop.texture("kd.exr", [2, 2], |_, _| [0.4, 0.6, 0.8]);
    shop.texture("ks.exr", [2, 2], |_, _| [0.0; 3]);
    let grey = shop.scene.materials[0].texture.as_ref().unwrap().sample([0.5; 2])[0];
    let states = [
        shop.state("[materials.m]\nkd = 'kd.exr'\nks = [0, 0, 0]"),
        shop.state("[materials.m]\nkd = [0.4, 0.6, 0.8]\nks = 'ks.exr'"),
    ];
    for paths in BOTH {
        for (image, factor) in shop.render(&states, paths, 4).iter().zip([1.0, grey]) {
            for (radiance, kd) in image.radiance[100].iter().zip([0.4, 0.6, 0.8]) {
                let expected = kd * factor / PI * 2.0;
                assert!((radiance - expected).abs() < 2e-5, "{paths:?}: {radiance} {expected}");
            }
        }
    }
}

/// A striped, partly shiny wall colours the floor: paths that follow the materials and paths that know none show
/// the same. Both means are off by their own noise, so the sum of squares over variances has as many degrees of
/// freedom as there are values; these are not independent, as channels share paths, nor quite normal, so twice as
/// much is granted, and no value is off by more than 6 σ.
#[test]
fn paths_of_both_kinds_agree_on_what_a_painted_wall_sends_on() {
    let shop = Workshop::new(CORNER);
    shop.texture("kd.exr", [4, 1], |x, _| if x % 2 == 0 { [0.6, 0.05, 0.05] } else { [0.05, 0.1, 0.6] });
    shop.texture("ks.exr", [1, 3], |_, y| [0.15 * y as f32; 3]);
    shop.texture("s.exr", [2, 2], |x, y| [5.0 + 20.0 * x as f32, 10.0, 10.0 + 60.0 * y as f32]);
    let states =
        [shop.state("[materials.m]\nkd = 'kd.exr'\nks = 'ks.exr'\nshininess = 's.exr'"), shop.scene.clone()];
    let [best, gather] = BOTH.map(|paths| shop.render(&states, paths, 1024));
    let (mut sum, mut count) = (0.0, 0.0);
    for (a, b) in [(&best[0], &gather[0]), (&best[1], &gather[1])] {
        let values = a.radiance.iter().flatten().zip(b.radiance.iter().flatten());
        let variances = a.variance.iter().flatten().zip(b.variance.iter().flatten());
        for ((a, b), variance) in values.zip(variances.map(|(a, b)| a + b)) {
            // Stratified samples may leave no spread at all.
            let squared = (a - b).powi(2) / (variance + 1e-10);
            assert!(squared < 36.0, "{a} {b} ± {}", variance.sqrt());
            (sum, count) = (sum + f64::from(squared), count + 1.0);
        }
    }
    assert!(sum < 2.0 * count, "{sum} of {count}");
    // The floor, in the lowest row, is no longer grey; kd of the wall is 0.33 in red and 0.08 in green.
    let [r, g, b] = [0, 1, 2].map(|k| best[0].radiance[12 * 11..].iter().map(|rgb| rgb[k]).sum::<f32>());
    assert!(r > 1.03 * g && b > 1.03 * g, "{r} {g} {b}");
}

/// As a user meets them: one line, exit code 2.
#[test]
fn mistakes_are_refused_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_scene(at, FLOOR);
    write_texture(at, "dark.exr", [2, 2], |_, _| [0.1; 3]);
    write_texture(at, "bright.exr", [2, 2], |x, _| [0.6 * x as f32 + 0.4; 3]);
    write_texture(at, "long.exr", [2049, 1], |_, _| [0.1; 3]);
    std::fs::write(at.join("broken.png"), b"\x89PNG\r\n\x1a\n and no more").unwrap();
    std::fs::write(at.join("kd.tif"), "").unwrap();
    let plain = FLOOR.replace("painted = ['m']\n", "");
    std::fs::write(at.join("plain.toml"), plain).unwrap();
    let reference = |scene: &str, state: &str| {
        std::fs::write(at.join("s.toml"), format!("[materials.m]\n{state}\n")).unwrap();
        let line = ["reference", scene, "--state", "s.toml", "--spp", "1", "-o", "a.exr"];
        let output = command("bake").args(line).current_dir(at).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for (state, part) in [
        ("kd = 'drk.exr'", "s.toml: line 2: material `m`: no such file: `drk.exr`; did you mean `dark.exr`?"),
        ("kd = 'bright.exr'", "texel (1, 0) of 2 × 2: material `m`: kd + ks = 1.1 exceeds 1"),
        ("kd = 'long.exr'", "long.exr: 2049 × 1 texels, 1 to 2048 a side are read; scale the picture down"),
        ("kd = 'broken.png'", "broken.png: broken picture ("),
        (
            "kd = 'kd.tif'",
            "kd.tif: not a texture this version reads; it reads .png, .jpg and .exr, convert it",
        ),
    ] {
        let (code, told) = reference("scene.toml", state);
        assert!(code == Some(2) && told.lines().count() == 1 && told.contains(part), "{code:?}: {told}");
    }
    let (code, told) = reference("plain.toml", "shininess = 'dark.exr'");
    let expected = "error: s.toml: line 2: material `m`: `dark.exr` is a texture for shininess, but the material is not painted; add `m` to [vary] \
                    painted in scene.toml, or write a number\n";
    assert_eq!((code, told.as_str()), (Some(2), expected));
    let (code, told) = reference("scene.toml", "kd = 'dark.exr'");
    assert!(code == Some(0) && at.join("a.exr").is_file(), "{told}");
}
