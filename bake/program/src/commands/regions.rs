//! Pictures of the regions of materials that are painted: in the square of the textures, and as the camera sees
//! them.

use relume_bake::error::Result;
use relume_bake::inspected::out::file_name_part;
use relume_bake::trace::world::{Owner, World};
use relume_chart::picture;
use relume_formats::container::replace_file;
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use relume_scenes::painting::{Painting, REGIONS, region_of};
use std::path::{Path, PathBuf};

/// Side of the pictures of textures, pixels: a region is 32.
const SIDE: u32 = 1024;
/// Where there is no surface, and what surfaces that are not painted reflect.
const NOTHING: Rgb = [0.0; 3];
const UNPAINTED: f32 = 0.18;

/// Writes a picture for each of `paintings`, and one of the scene, into the folder `out`. Returns the files.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn export(scene: &Scene, paintings: &[Painting], out: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut write = |name: String, pixels: &[Rgb], size: [u32; 2]| -> Result<()> {
        files.push(out.join(name));
        Ok(replace_file(&files[files.len() - 1], &picture::alone(pixels, size, 0.0)?)?)
    };
    for painting in paintings {
        let name = file_name_part(&scene.materials[painting.material].name);
        // Names of files may be alike where those of materials are not.
        let file = format!("regions_{:03}_{name}.png", painting.material);
        write(file, &of_textures(painting), [SIDE; 2])?;
    }
    if !paintings.is_empty() {
        write("regions.png".to_owned(), &as_seen(scene, paintings), scene.size)?;
    }
    Ok(files)
}

fn of_textures(painting: &Painting) -> Vec<Rgb> {
    let middle = |pixel: u32| [pixel % SIDE, pixel / SIDE].map(|x| (x as f32 + 0.5) / SIDE as f32);
    let covered = painting.covered(SIDE);
    (0..).zip(covered).map(|(pixel, covered)| if covered { colour(middle(pixel)) } else { NOTHING }).collect()
}

/// Redder to the right, greener downwards, and darker where column and row are both even or both odd.
fn colour(uv: [f32; 2]) -> Rgb {
    let region = region_of(uv);
    let [column, row] = [region % REGIONS, region / REGIONS];
    let ramp = |n: u32| 0.05 + 0.9 * n as f32 / (REGIONS - 1) as f32;
    let light = if (column + row) % 2 == 0 { 0.6 } else { 1.0 };
    [ramp(column), ramp(row), 0.4].map(|channel| light * channel)
}

/// The scene, of every pixel the surface in its middle, as under a lamp beside the camera.
fn as_seen(scene: &Scene, paintings: &[Painting]) -> Vec<Rgb> {
    let [width, height] = scene.size;
    let (world, film) = (World::painted(scene, paintings), scene.camera.film(width, height));
    let shown = |pixel: u32| {
        let direction = film.direction((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        let Some(surface) = world.intersect(film.eye_in_world, direction) else { return NOTHING };
        let is_painted = |painting: &Painting| surface.owner == Owner::Material(painting.material as u32);
        let own = if paintings.iter().any(is_painted) { colour(surface.uv) } else { [UNPAINTED; 3] };
        let cosine = surface.shading_normal.dot(surface.outgoing).max(0.0);
        own.map(|channel| channel * (0.3 + 0.7 * cosine))
    };
    (0..width * height).map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_bake::job::{Job, ProgressMode};
    use relume_bake::paintings::paintings;
    use std::collections::HashSet;

    /// A square that fills the left half of the film and is painted, another material right above, nothing below that.
    const SCENE: &str = "[vary]\nmaterials = ['paint']\npainted = ['paint']\n[render]\nsize = [128, 64]\n\
        [camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\nfov_deg = 53.1301\n\
        [materials.paint]\nbrdf = 'blinn-phong'\n[materials.other]\nbrdf = 'blinn-phong'\n\
        [[object]]\nname = 'a'\nmaterial = 'other'\nshape = 'quad'\n\
        transform = { rotation_deg = [90, 0, 0], translation = [0.5, 0.5, 0] }\n\
        [[object]]\nname = 'b'\nmaterial = 'paint'\nshape = 'quad'\n\
        transform = { rotation_deg = [90, 0, 0], translation = [-0.5, 0, 0] }\n";

    #[test]
    fn regions_are_shown_where_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.toml");
        std::fs::write(&file, SCENE).unwrap();
        let scene = relume_scenes::load(&file).unwrap();
        let paintings = paintings(&scene, &Job::new(ProgressMode::None)).unwrap();
        let files = export(&scene, &paintings, folder.path()).unwrap();
        let paint = format!("regions_{:03}_paint.png", scene.vary.painted[0]);
        assert_eq!(files, [paint.as_str(), "regions.png"].map(|name| folder.path().join(name)));
        assert!(files.iter().all(|file| std::fs::read(file).unwrap().starts_with(b"\x89PNG")));

        let textures = of_textures(&paintings[0]);
        let distinct: HashSet<_> = textures.iter().map(|c| c.map(f32::to_bits)).collect();
        assert_eq!(distinct.len(), (REGIONS * REGIONS) as usize, "the whole square is surface");
        let seen = as_seen(&scene, &paintings);
        let at = |x: usize, y: usize| seen[128 * y + x];
        // Two by two pixels of the film are a region, and shaded alike but for the cosine at the eye.
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let expected = textures[1024 * (16 * y + 8) + 16 * x + 8];
            let light = at(x, y)[2] / expected[2];
            assert!((0.7..=1.0001).contains(&light), "{x} {y}");
            assert!((0..3).all(|k| (at(x, y)[k] - light * expected[k]).abs() < 1e-5), "{x} {y}");
        }
        assert_eq!((at(100, 10)[0], at(100, 50)), (at(100, 10)[2], NOTHING));
        assert!(at(100, 10)[0] > 0.0);
    }
}
