use super::*;
use crate::state::{BlinnPhong, CookTorrance, Ggx, State, parse_toml, texel_of};
use image::{ImageBuffer, Luma, Rgb as Pixel, Rgba};
use std::fs;

const CLAY: Brdf = Brdf::BlinnPhong(BlinnPhong { kd: [0.1, 0.2, 0.3], ks: [0.4, 0.3, 0.2], shininess: 20.0 });
const GROOVES: Brdf =
    Brdf::CookTorrance(CookTorrance { kd: [0.1; 3], ks: [0.2; 3], fresnel: 0.5, roughness: 0.4 });
const METAL: Brdf = Brdf::Ggx(Ggx { base_color: [0.5; 3], metallic: 0.25, roughness: 0.5 });

/// A folder for states and their textures.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn exr(&self, name: &str, size: [usize; 2], value: impl Fn(usize, usize) -> Rgb + Sync) {
        exr::prelude::write_rgb_file(self.at(name), size[0], size[1], |x, y| value(x, y).into()).unwrap();
    }

    /// What `leaves` make of `brdf`, and what is warned of.
    fn paint(&self, brdf: &Brdf, leaves: &str) -> std::result::Result<(Paint, Vec<String>), String> {
        let place = Place::file(self.at("s.toml"));
        let state: State = parse_toml(&format!("[materials.a]\n{leaves}"), &place).unwrap();
        let canvas = Canvas { name: "a", brdf, sharpest: brdf.model().usual_sharpest() };
        let mut warnings = Vec::new();
        let plain = |text: String| text.replace(&format!("{}/", self.0.path().display()), "");
        let paint =
            canvas.paint(&state.materials["a"], &place, &mut warnings).map_err(|e| plain(e.to_string()))?;
        Ok((paint, warnings.into_iter().map(plain).collect()))
    }
}

#[test]
fn exact_files_hold_the_values_and_what_no_file_says_is_the_materials() {
    let folder = Folder::new();
    let kd = |x: usize, y: usize| [0.1 * x as f32, 0.2 * y as f32, 0.3];
    folder.exr("kd.exr", [3, 2], kd);
    let (paint, warnings) = folder.paint(&CLAY, "kd = 'kd.exr'\nshininess = 30").unwrap();
    assert!(paint.replaces_texture && warnings.is_empty());
    assert_eq!(paint.size, [3, 2]);
    for (index, texel) in paint.texels.iter().enumerate() {
        assert_eq!(*texel, [kd(index % 3, index / 3), [0.4, 0.3, 0.2], [30.0; 3]]);
    }
    let (paint, _) = folder.paint(&CLAY, "ks = 'kd.exr'\nkd = [0.0, 0.1, 0.2]").unwrap();
    assert!(!paint.replaces_texture);
    assert_eq!(paint.texels[5], [[0.0, 0.1, 0.2], [0.2, 0.2, 0.3], [20.0; 3]]);
}

/// Eight bits and sixteen of one grey, PNG and JPEG, for keys that are colours, even ones and exponents.
#[test]
fn pictures_are_decoded_as_keys_ask() {
    let folder = Folder::new();
    ImageBuffer::from_pixel(2, 2, Pixel([100u8, 50, 0])).save(folder.at("8.png")).unwrap();
    ImageBuffer::from_pixel(2, 2, Pixel([25_700u16, 12_850, 0])).save(folder.at("16.png")).unwrap();
    ImageBuffer::from_pixel(2, 2, Luma([51u8])).save(folder.at("grey.png")).unwrap();
    ImageBuffer::from_pixel(2, 2, Rgba([100u8, 50, 0, 0])).save(folder.at("clear.png")).unwrap();
    ImageBuffer::from_pixel(16, 16, Luma([204u8])).save(folder.at("grey.JPG")).unwrap();
    let first = |brdf, leaves: &str| folder.paint(brdf, leaves).unwrap().0.texels[0];
    let linear = [100, 50, 0].map(crate::basis::linear_from_srgb);
    for file in ["8.png", "16.png", "clear.png"] {
        assert_eq!(first(&CLAY, &format!("kd = '{file}'"))[0], linear, "{file}");
        assert_eq!(first(&CLAY, &format!("ks = '{file}'"))[1], linear, "{file}");
    }
    // A fifth and four fifths; exponents 200^0.2.
    let fifth = 0.2f32;
    assert_eq!(first(&METAL, "metallic = 'grey.png'")[1], [fifth; 3]);
    assert_eq!(first(&CLAY, "shininess = 'grey.png'")[2], [200f32.powf(fifth); 3]);
    let [jpeg, ..] = first(&METAL, "roughness = 'grey.JPG'")[2];
    assert!((jpeg - 0.8).abs() < 0.5 / 255.0, "flat JPEG blocks are exact to a step: {jpeg}");
}

#[test]
fn smooth_texels_of_pictures_are_raised_and_told() {
    let folder = Folder::new();
    let pixel = |x, y| Luma([if (x, y) == (1, 0) { 3u8 } else { 255 }]);
    ImageBuffer::from_fn(2, 3, pixel).save(folder.at("r.png")).unwrap();
    for (brdf, least) in [(METAL, 0.32), (GROOVES, 0.1)] {
        let (paint, warnings) = folder.paint(&brdf, "roughness = 'r.png'").unwrap();
        assert_eq!(warnings, [format!("r.png: raised 1 of 6 texels to roughness {least}, the least of `a`")]);
        let roughness: Vec<f32> = paint.texels.iter().map(|texel| texel[2][0]).collect();
        assert_eq!(roughness, [1.0, least, 1.0, 1.0, 1.0, 1.0]);
    }
}

/// A ramp is linear, so it stays itself between the outer centres of its texels; these have what is beyond.
#[test]
fn textures_of_different_sizes_become_one() {
    let folder = Folder::new();
    folder.exr("ramp.exr", [2, 1], |x, _| [0.2 + 0.4 * x as f32; 3]);
    folder.exr("tall.exr", [1, 8], |_, y| [0.05 * y as f32; 3]);
    folder.exr("s.exr", [8, 2], |x, _| [1.0 + x as f32; 3]);
    let (paint, _) = folder.paint(&CLAY, "kd = 'ramp.exr'\nks = 'tall.exr'\nshininess = 's.exr'").unwrap();
    assert_eq!(paint.size, [8, 8]);
    for (index, [kd, ks, shininess]) in paint.texels.iter().enumerate() {
        let (x, y) = ((index % 8) as f32, index / 8);
        let ramp = 0.2 + 0.4 * (2.0 * (x + 0.5) / 8.0 - 0.5).clamp(0.0, 1.0);
        assert!((kd[0] - ramp).abs() < 1e-6, "{} {ramp}", kd[0]);
        assert!((ks[1] - 0.05 * y as f32).abs() < 1e-6 && (shininess[2] - 1.0 - x).abs() < 1e-6);
    }
}

#[test]
fn mistakes_are_told_with_place_and_remedy() {
    let folder = Folder::new();
    folder.exr("nan.exr", [2, 2], |x, y| [if (x, y) == (1, 1) { f32::NAN } else { 0.1 }; 3]);
    folder.exr("bright.exr", [2, 2], |x, y| [if (x, y) == (0, 1) { 0.95 } else { 0.1 }; 3]);
    folder.exr("long.exr", [2049, 1], |_, _| [0.1; 3]);
    ImageBuffer::from_pixel(1, 2049, Luma([9u8])).save(folder.at("tall.png")).unwrap();
    ImageBuffer::from_pixel(64, 64, Luma([9u8])).save(folder.at("cut.png")).unwrap();
    let whole = fs::read(folder.at("cut.png")).unwrap();
    fs::write(folder.at("cut.png"), &whole[..whole.len() / 2]).unwrap();
    fs::write(folder.at("page.png"), "<!DOCTYPE html>").unwrap();
    fs::write(folder.at("page.exr"), "<!DOCTYPE html>").unwrap();
    fs::write(folder.at("kd.tif"), "").unwrap();
    fs::create_dir(folder.at("dir.png")).unwrap();
    for (leaves, expected) in [
        ("kd = 'nan.exr'", "nan.exr: texel (1, 1) of 2 × 2: is not finite; save numbers"),
        (
            "kd = 'bright.exr'",
            "s.toml: texel (0, 1) of 2 × 2: material `a`: kd + ks = 1.35 exceeds 1, more light than arrives; lower one of them",
        ),
        (
            "shininess = 'bright.exr'",
            "s.toml: texel (0, 0) of 2 × 2: material `a`: shininess 0.1 is outside 1..10000; for a material that varies it is 1..200, as bases follow no \
             sharper lobe; [vary] shininess_max lets transfer-images go up to 5000",
        ),
        ("kd = 'long.exr'", "long.exr: 2049 × 1 texels, 1 to 2048 a side are read; scale the picture down"),
        ("kd = 'tall.png'", "tall.png: too many texels, 1 to 2048 a side are read; scale the picture down"),
        ("kd = 'page.png'", "page.png: is neither PNG nor JPEG, though its name says so; save it again"),
        (
            "kd = 'kd.tif'",
            "kd.tif: not a texture this version reads; it reads .png, .jpg and .exr, convert it",
        ),
        ("kd = 'dir.png'", "dir.png: not a regular file but a folder; give a file"),
        ("kd = 'pag.png'", "s.toml: material `a`: no such file: `pag.png`; did you mean `page.png`?"),
        (
            "roughness = 'kd.tif'",
            "s.toml: material `a`: is \"blinn-phong\", which has kd, ks and shininess, not `roughness`",
        ),
    ] {
        assert_eq!(folder.paint(&CLAY, leaves).unwrap_err(), expected);
    }
    let begins = |leaves: &str| folder.paint(&CLAY, leaves).unwrap_err();
    assert!(begins("kd = 'cut.png'").starts_with("cut.png: broken picture ("));
    assert!(begins("kd = 'page.exr'").starts_with("page.exr: is no OpenEXR file"));
}

/// As many texels as a paint has without any texture.
#[test]
fn one_texel_is_a_material() {
    let folder = Folder::new();
    folder.exr("kd.exr", [1, 1], |_, _| [0.1, 0.2, 0.3]);
    assert_eq!(folder.paint(&CLAY, "kd = 'kd.exr'").unwrap().0.texels, [texel_of(&CLAY)]);
}
