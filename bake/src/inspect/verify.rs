//! Every checksum and invariant of a file, and what must agree between the files of a bundle.

mod sparse_transfer;
mod sphere_set;
mod sphere_shadows;

use crate::playable::{Played, expect_playable};
use relume_formats::container::{Kind, Stored, open};
use relume_formats::kinds::manifest::{self, FileEntry, Manifest, MethodEntry, content_hash};
use relume_formats::kinds::{
    BrdfBasis, Environment, HaarTable, SparseTransfer, SphereSet, SphereShadows, StoredScene, Textures, TransferImages, VisibilityTable,
};
use relume_formats::shape::DeformingMesh;
use relume_formats::state::Animation;
use relume_formats::{Error, Place, Result};
use std::fmt::Write as _;
use std::path::Path;

/// Checks the `.relume` file or bundle folder at `path`; returns what was checked, a line for each file.
///
/// # Errors
/// The first thing found wrong, with file and section.
pub fn verify(path: &Path) -> Result<String> {
    if path.is_dir() { verify_bundle(path) } else { verify_file(path) }
}

fn verify_file(path: &Path) -> Result<String> {
    match open(path)?.header().kind {
        Kind::Scene => drop(StoredScene::read_file(path)?),
        Kind::Animation => drop(<Animation as Stored>::read_file(path)?),
        Kind::BrdfBasis => drop(BrdfBasis::read_file(path)?),
        Kind::TransferImages => drop(TransferImages::read_file(path)?),
        Kind::HaarTable => drop(HaarTable::read_file(path)?),
        Kind::Environment => drop(Environment::read_file(path)?),
        Kind::Textures => drop(Textures::read_file(path)?),
        Kind::SparseTransfer => drop(SparseTransfer::read_file(path)?),
        Kind::SphereSet => sphere_set::verify(&SphereSet::read_file(path)?, &Place::file(path))?,
        Kind::Shape => drop(DeformingMesh::read_file(path)?),
        Kind::SphereShadows => drop(SphereShadows::read_file(path)?),
        Kind::VisibilityTable => drop(VisibilityTable::read_file(path)?),
    }
    sound(path)
}

/// The line that says that a file was read whole.
fn sound(path: &Path) -> Result<String> {
    let header = open(path)?.header().clone();
    let (kind, sections) = (header.kind.name(), header.sections.len());
    Ok(format!("{}: {kind}, {sections} sections, every checksum and value checked\n", path.display()))
}

fn verify_bundle(folder: &Path) -> Result<String> {
    let manifest = Manifest::read(folder)?;
    for entry in manifest.entries() {
        verify_entry(entry, folder)?;
    }
    let scene_path = folder.join(&manifest.scene_file.file);
    let scene = StoredScene::read_file(&scene_path)?;
    expect_name(&scene.meta.name, &manifest.scene, &scene_path)?;
    let mut checked = sound(&scene_path)?;
    let mut animations = Vec::new();
    for (name, entry) in &manifest.animations {
        let path = folder.join(&entry.file);
        let animation = <Animation as Stored>::read_file(&path)?;
        expect_name(&animation.name, name, &path)?;
        checked += &sound(&path)?;
        animations.push((Place::file(path), animation));
    }
    for (object, entry) in &manifest.sphere_sets {
        let path = folder.join(&entry.file.file);
        sphere_set::verify_object(&SphereSet::read_file(&path)?, object, &scene, &Place::file(&path))?;
        checked += &sound(&path)?;
    }
    let mut played: Vec<Played> = Vec::new();
    for method in &manifest.methods {
        let (lines, method) = verify_method(method, &manifest, &scene, folder)?;
        checked += &lines;
        played.push(method);
    }
    animations.iter().try_for_each(|(place, animation)| expect_playable(animation, &played, &scene.meta, place))?;
    let files = manifest.entries().count();
    let _ = writeln!(checked, "{}: {files} files as the manifest lists them, and they agree with each other", folder.display());
    Ok(checked)
}

fn expect_name(name: &str, listed: &str, path: &Path) -> Result<()> {
    if name == listed {
        return Ok(());
    }
    Err(Error::invalid(&Place::file(path), format!("holds `{name}`, the manifest lists `{listed}`; bake it again")))
}

/// Present, as long as listed, and with the listed hash.
fn verify_entry(entry: &FileEntry, folder: &Path) -> Result<()> {
    let place = Place::file(folder.join(&entry.file));
    let length = std::fs::metadata(&place.file).map(|m| m.len()).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => Error::invalid(&place, "is missing although the manifest lists it; bake it again"),
        _ => Error::io(&place, e),
    })?;
    if length != entry.bytes {
        return Err(Error::invalid(&place, format!("{length} bytes, the manifest lists {}; bake it again", entry.bytes)));
    }
    let bytes = std::fs::read(&place.file).map_err(|e| Error::io(&place, e))?;
    if content_hash(&bytes) != entry.hash {
        return Err(Error::invalid(&place, "its hash is not the one in the manifest; the file was changed, bake it again"));
    }
    Ok(())
}

fn verify_method(method: &MethodEntry, manifest: &Manifest, scene: &StoredScene, folder: &Path) -> Result<(String, Played)> {
    let place = Place::file(folder.join(manifest::FILE_NAME)).part(format!("method `{}`", method.name));
    match Kind::ALL.into_iter().find(|kind| kind.name() == method.name) {
        Some(kind @ Kind::TransferImages) => {
            Ok((verify_transfer_images(method, scene, folder, &place)?, Played { kind, maps: Vec::new() }))
        }
        Some(kind @ Kind::SparseTransfer) => {
            let (lines, maps) = sparse_transfer::verify(method, scene, folder, &place)?;
            Ok((lines, Played { kind, maps }))
        }
        Some(kind @ Kind::SphereShadows) => {
            let (lines, maps) = sphere_shadows::verify(method, manifest, scene, folder, &place)?;
            Ok((lines, Played { kind, maps }))
        }
        _ => Err(Error::unsupported(&place, "is unknown to this program; use a newer one")),
    }
}

/// The maps of a method that the environment lights: the scene's own is among them, and none is there twice.
fn expect_maps(maps: &[String], scene: &StoredScene, place: &Place) -> Result<()> {
    match &scene.meta.environment {
        Some(look) if maps.contains(&look.map) => {}
        Some(look) => {
            return Err(Error::invalid(place, format!("has no environment map `{}`, which the scene shows; bake it again", look.map)));
        }
        None => return Err(Error::invalid(place, "is lit by an environment, but the scene has none; bake it again")),
    }
    if let Some(twice) = maps.iter().enumerate().find(|(i, map)| maps[..*i].contains(map)) {
        return Err(Error::invalid(place, format!("two environment maps are called `{}`; bake it again", twice.1)));
    }
    Ok(())
}

fn verify_transfer_images(method: &MethodEntry, scene: &StoredScene, folder: &Path, place: &Place) -> Result<String> {
    // A player needs the basis before the first image.
    let expected = [Kind::BrdfBasis.name(), Kind::TransferImages.name()];
    let [(_, basis), (_, images)] = &method.files[..] else {
        return Err(Error::invalid(place, format!("has {} files, expected {}; bake it again", method.files.len(), expected.join(", "))));
    };
    if method.files.iter().map(|(kind, _)| kind).ne(expected) {
        return Err(Error::invalid(place, format!("its files are not {}, in this order; bake it again", expected.join(", "))));
    }
    let [basis_path, images_path] = [basis, images].map(|entry| Place::file(folder.join(&entry.file)));
    let basis = BrdfBasis::read_file(&basis_path.file)?;
    let images = TransferImages::read_file(&images_path.file)?;
    verify_images(&images, &basis, scene, &images_path)?;
    Ok(sound(&basis_path.file)? + &sound(&images_path.file)?)
}

/// Size, bases and materials agree with basis and scene.
fn verify_images(images: &TransferImages, basis: &BrdfBasis, scene: &StoredScene, place: &Place) -> Result<()> {
    let meta = &images.head.meta;
    let refuse = |reason: String| Err(Error::invalid(&place.part("section `meta`"), format!("{reason}; bake it again")));
    if meta.size != scene.meta.size {
        return refuse(format!("film size {:?}, the scene's is {:?}", meta.size, scene.meta.size));
    }
    if meta.bases as usize != basis.bases() {
        return refuse(format!("{} bases, the BRDF basis has {}", meta.bases, basis.bases()));
    }
    for name in &meta.materials {
        match scene.meta.materials.iter().find(|m| m.name == *name) {
            Some(material) if material.varies && material.brdf.model() != basis.functions.model() => {
                return refuse(format!("material `{name}` is of another model than the BRDF basis"));
            }
            Some(material) if material.varies => {}
            Some(_) => return refuse(format!("material `{name}` does not vary in the scene")),
            None => return refuse(format!("material `{name}` is not in the scene")),
        }
    }
    if let Some(left_out) = scene.meta.materials.iter().find(|m| m.varies && !meta.materials.contains(&m.name)) {
        return refuse(format!("material `{}` varies in the scene, but there are no images of it", left_out.name));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::test_bundle::TestBundle;
    use super::*;
    use relume_formats::state::{Track, TrackValues};
    use std::sync::Arc;

    /// What is said of a bundle after `change` to its parts, and `damage` to its files.
    fn verdict(change: impl Fn(&mut TestBundle), damage: impl Fn(&Path)) -> Result<String> {
        let folder = tempfile::tempdir().unwrap();
        let mut bundle = TestBundle::new();
        change(&mut bundle);
        bundle.write(folder.path());
        damage(folder.path());
        verify(folder.path())
    }

    fn assert_refused(change: impl Fn(&mut TestBundle), damage: impl Fn(&Path), expected: &[&str]) {
        let message = verdict(change, damage).unwrap_err().to_string();
        expected.iter().for_each(|part| assert!(message.contains(part), "`{part}` is not in `{message}`"));
    }

    #[test]
    fn a_sound_bundle_and_each_of_its_files_pass() {
        let folder = tempfile::tempdir().unwrap();
        TestBundle::new().write(folder.path());
        let text = verify(folder.path()).unwrap();
        assert_eq!(text.lines().count(), 5, "{text}");
        assert!(text.contains("transfer-images.relume: transfer-images, 29 sections"), "{text}");
        for name in ["scene", "animation-glow", "brdf-basis", "transfer-images"] {
            verify(&folder.path().join(format!("{name}.relume"))).unwrap();
        }
    }

    #[test]
    fn damage_to_any_file_is_found() {
        for name in ["scene.relume", "animation-glow.relume", "brdf-basis.relume", "transfer-images.relume"] {
            let edit = |change: fn(&mut Vec<u8>)| {
                move |folder: &Path| {
                    let mut bytes = std::fs::read(folder.join(name)).unwrap();
                    change(&mut bytes);
                    std::fs::write(folder.join(name), bytes).unwrap();
                }
            };
            let remove = |folder: &Path| std::fs::remove_file(folder.join(name)).unwrap();
            assert_refused(|_| (), remove, &[name, "is missing"]);
            assert_refused(|_| (), edit(|b| b.push(0)), &[name, "the manifest lists"]);
            assert_refused(|_| (), edit(|b| *b.last_mut().unwrap() ^= 1), &[name, "its hash is not"]);
        }
    }

    #[test]
    fn damage_to_a_single_file_names_the_section() {
        let folder = tempfile::tempdir().unwrap();
        TestBundle::new().write(folder.path());
        let path = folder.path().join("transfer-images.relume");
        let mut bytes = std::fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let message = verify(&path).unwrap_err().to_string();
        assert!(message.contains("transfer-images.relume: section `image/0000`: checksum does not match"), "{message}");
    }

    /// A manifest whose text is changed; hashes and lengths stay those of the files.
    fn edit_manifest(from: &'static str, to: &'static str) -> impl Fn(&Path) {
        move |folder| {
            let path = folder.join(manifest::FILE_NAME);
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains(from), "{text}");
            std::fs::write(&path, text.replace(from, to)).unwrap();
        }
    }

    #[test]
    fn a_manifest_that_contradicts_the_files_is_refused() {
        let cases: [(&str, &str, &[&str]); 5] = [
            ("\"scene\": \"test room\"", "\"scene\": \"other\"", &["scene.relume", "holds `test room`, the manifest lists `other`"]),
            ("\"glow\"", "\"glimmer\"", &["animation-glow.relume", "the manifest lists `glimmer`"]),
            ("\"name\": \"transfer-images\"", "\"name\": \"magic\"", &["method `magic`", "unknown to this program"]),
            (
                "          \"brdf-basis\",",
                "\"transfer-images\",",
                &["method `transfer-images`", "its files are not brdf-basis, transfer-images, in this order"],
            ),
            ("\"version\": 0", "\"version\": 1", &["manifest version 1"]),
        ];
        for (from, to, expected) in cases {
            assert_refused(|_| (), edit_manifest(from, to), expected);
        }
        // Both files are there, but each under the other's kind: a player would read the images first.
        let swap = |folder: &Path| {
            edit_manifest("          \"brdf-basis\",", "\"swapped\",")(folder);
            edit_manifest("          \"transfer-images\",", "\"brdf-basis\",")(folder);
            edit_manifest("\"swapped\"", "\"transfer-images\"")(folder);
        };
        assert_refused(|_| (), swap, &["its files are not brdf-basis, transfer-images, in this order"]);
    }

    #[test]
    fn files_that_do_not_fit_each_other_are_refused() {
        type Change = fn(&mut TestBundle);
        let cases: [(Change, &[&str]); 6] = [
            (|b| b.scene.meta.size = [6, 1], &["transfer-images.relume: section `meta`", "film size [3, 2], the scene's is [6, 1]"]),
            (|b| b.scene.meta.materials[2].varies = false, &["material `floor` does not vary in the scene"]),
            (|b| b.scene.meta.materials[2].name = "wall".to_owned(), &["material `floor` is not in the scene"]),
            (|b| b.scene.meta.materials.iter_mut().for_each(|m| m.varies = true), &["varies in the scene, but there are no images of it"]),
            (fewer_bases, &["3 bases, the BRDF basis has 2"]),
            (|b| Arc::make_mut(&mut b.images.head).pixel[0] = 99, &["section `fragments/pixel`", "outside the film"]),
        ];
        for (change, expected) in cases {
            assert_refused(change, |_| (), expected);
        }
    }

    fn fewer_bases(bundle: &mut TestBundle) {
        bundle.basis.coefficients.truncate(6);
        bundle.basis.functions =
            relume_formats::kinds::brdf_basis::Functions::BlinnPhong { lobes: vec![0.0; relume_formats::basis::lobe_table::NODES] };
    }

    #[test]
    fn animations_must_be_legal_at_every_key() {
        let track = |leaf: &[&str], times_s: &[f32], values: &[f32]| Track {
            leaf: leaf.iter().map(|n| (*n).to_owned()).collect(),
            times_s: times_s.to_vec(),
            values: TrackValues::Scalar(values.to_vec()),
        };
        let with = |track: Track| move |b: &mut TestBundle| b.animation.tracks.insert(0, track.clone());
        let cases = [
            (track(&["environment", "rotation_deg"], &[0.5], &[3.0]), "at 0 s: sets [environment]"),
            (track(&["camera", "fov_deg"], &[0.5], &[30.0]), "the camera's position, target or field of view"),
            (track(&["camera", "exposure_ev"], &[0.5, 2.0], &[1.0, 50.0]), "at 2 s: camera: exposure_ev 50"),
            (track(&["materials", "../knot", "gloss"], &[0.5], &[3.0]), "unknown field `gloss`"),
            (track(&["lights", "lamp", "gain"], &[0.5], &[3.0]), "invalid type"),
        ];
        for (track, expected) in cases {
            assert_refused(with(track), |_| (), &["animation-glow.relume", expected]);
        }
        let shininess = track(&["materials", "../knot", "shininess"], &[0.0, 1.5], &[10.0, 300.0]);
        let change = |b: &mut TestBundle| b.animation.tracks[1] = shininess.clone();
        assert_refused(change, |_| (), &["at 1.5 s: material `../knot`: shininess 300"]);
        // kd alone stays below 1 at every key, kd + ks does not: ks is the scene's 0.25.
        let bright = |b: &mut TestBundle| b.animation.tracks[0].values = TrackValues::Vector(vec![vec![0.5; 3], vec![0.875; 3]]);
        assert_refused(bright, |_| (), &["at 2 s: material `../knot`: kd + ks"]);
        let other = |b: &mut TestBundle| b.animation.tracks[1].leaf[1] = "white".to_owned();
        assert_refused(other, |_| (), &["material `white`", "only material `../knot`, material `floor` vary"]);
    }
}
