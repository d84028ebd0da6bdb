//! Every checksum and invariant of a file, and what must agree between the files of a bundle.

use crate::methods::registered::{Bundled, Registered};
use relume_formats::bundle::{Maps, Objects, Scope, Settings, expect_name, expect_some_plays};
use relume_formats::container::{Header, Kind, Stored, expect_decoded, open};
use relume_formats::counts::counted;
use relume_formats::kinds::manifest::{FILE_NAME, FileEntry, Manifest, MethodEntry};
use relume_formats::kinds::{SphereSet, StoredScene, check_file};
use relume_formats::method::{Card, cards_of};
use relume_formats::state::Animation;
use relume_formats::{Place, Result};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Checks the `.relume` file or bundle folder at `path`; returns what was checked, a line for each file.
///
/// # Errors
/// The first thing found wrong, with file and section.
pub fn verify(path: &Path) -> Result<String> {
    if path.is_dir() { Bundle::open(path)?.verify() } else { Ok(sound(path, &check_file(path)?)) }
}

/// The line that says that a file was read whole.
fn sound(path: &Path, header: &Header) -> String {
    let (kind, sections) = (header.kind.name(), counted(header.sections.len(), "section", "sections"));
    format!("{}: {kind}, {sections}, every checksum and value checked\n", path.display())
}

/// A bundle being checked. Of large files only heads are kept.
struct Bundle<'a> {
    folder: &'a Path,
    manifest: Manifest,
    scene: StoredScene,
    lines: String,
}

impl<'a> Bundle<'a> {
    /// Files are there, are those listed, and decode to no more than is read.
    fn open(folder: &'a Path) -> Result<Self> {
        let manifest = Manifest::read(folder)?;
        let (mut decoded, mut stored) = (0u64, 0u64);
        let files: BTreeMap<&str, &FileEntry> =
            manifest.entries().map(|entry| (entry.file.as_str(), entry)).collect();
        for entry in files.into_values() {
            entry.expect_whole(folder)?;
            decoded += open(&folder.join(&entry.file))?.header().decoded_bytes();
            stored += entry.bytes;
        }
        expect_decoded(decoded, stored, &Place::file(folder))?;
        let path = folder.join(&manifest.scene_file.file);
        let mut bundle =
            Self { folder, scene: StoredScene::read_file(&path)?, manifest, lines: String::new() };
        expect_name(&bundle.scene.meta.name, &bundle.manifest.scene, &Place::file(&path))?;
        bundle.is_sound(&path)?;
        Ok(bundle)
    }

    fn verify(mut self) -> Result<String> {
        let animations = self.animations()?;
        let objects = self.sphere_sets()?;
        let mut scopes = Vec::new();
        let methods = self.manifest.methods.clone();
        let cards = cards_of(
            methods.iter().map(|method| method.name.as_str()),
            &Place::file(self.folder.join(FILE_NAME)),
        )?;
        for (method, card) in methods.iter().zip(cards) {
            scopes.push(self.method(method, card, &objects)?);
        }
        animations.iter().try_for_each(|(place, animation)| expect_some_plays(animation, &scopes, place))?;
        let files = self.manifest.entries().count();
        let _ = writeln!(
            self.lines,
            "{}: {files} files as the manifest lists them, and they agree with each other",
            self.folder.display()
        );
        Ok(self.lines)
    }

    /// Adds the line of a file that has been checked.
    fn is_sound(&mut self, path: &Path) -> Result<()> {
        self.lines += &sound(path, open(path)?.header());
        Ok(())
    }

    fn animations(&mut self) -> Result<Vec<(Place, Animation)>> {
        let mut animations = Vec::new();
        for (name, entry) in self.manifest.animations.clone() {
            let place = Place::file(self.folder.join(&entry.file));
            let animation = <Animation as Stored>::read_file(&place.file)?;
            expect_name(&animation.name, &name, &place)?;
            self.is_sound(&place.file)?;
            animations.push((place, animation));
        }
        Ok(animations)
    }

    fn sphere_sets(&mut self) -> Result<Objects> {
        let mut objects = Objects::new(&self.scene);
        for (object, entry) in self.manifest.sphere_sets.clone() {
            let place = Place::file(self.folder.join(&entry.file.file));
            let set = SphereSet::read_file(&place.file)?;
            objects.add_set(&set, &object, &self.scene, &place)?;
            self.manifest
                .methods
                .iter()
                .try_for_each(|method| self.settings(method).expect_set(&set, &object))?;
            self.is_sound(&place.file)?;
        }
        Ok(objects)
    }

    fn settings(&self, method: &MethodEntry) -> Settings {
        Settings::of(method, &self.manifest, &Place::file(self.folder.join(FILE_NAME)))
    }

    /// Checks the files of `method`; returns what it lets vary.
    fn method(&mut self, method: &MethodEntry, card: &'static Card, objects: &Objects) -> Result<Scope> {
        let place = Place::file(self.folder.join(FILE_NAME)).part(format!("method `{}`", method.name));
        card.expect_files(&method.files, &place)?;
        let path = |entry: &FileEntry| self.folder.join(&entry.file);
        let files = method.files.iter().filter_map(|(name, entry)| Some((Kind::find(name)?, path(entry))));
        let files: Vec<(Kind, PathBuf)> = files.collect();
        let settings = self.settings(method);
        let maps = match Registered::find(card.name) {
            Some(registered) => {
                (registered.verify)(&Bundled { scene: &self.scene, objects, settings: &settings }, &files)?
            }
            None => Maps::default(),
        };
        files.iter().try_for_each(|(_, path)| self.is_sound(path))?;
        Ok(Scope { scene: self.scene.meta.clone(), card, maps: maps.names().to_vec() })
    }
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
        assert!(
            message.contains("transfer-images.relume: section `image/0000`: checksum does not match"),
            "{message}"
        );
    }

    /// A manifest whose text is changed; hashes and lengths stay those of the files.
    fn edit_manifest(from: &'static str, to: &'static str) -> impl Fn(&Path) {
        move |folder| {
            let path = folder.join(FILE_NAME);
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains(from), "{text}");
            std::fs::write(&path, text.replace(from, to)).unwrap();
        }
    }

    #[test]
    fn a_manifest_that_contradicts_the_files_is_refused() {
        let cases: [(&str, &str, &[&str]); 5] = [
            (
                "\"scene\": \"test room\"",
                "\"scene\": \"other\"",
                &["scene.relume", "holds `test room`, the manifest lists `other`"],
            ),
            ("\"glow\"", "\"glimmer\"", &["animation-glow.relume", "the manifest lists `glimmer`"]),
            (
                "\"name\": \"transfer-images\"",
                "\"name\": \"magic\"",
                &["method `magic`", "unknown to this program"],
            ),
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
            (
                |b| b.scene.meta.size = [6, 1],
                &["transfer-images.relume: section `meta`", "film size [3, 2], the scene's is [6, 1]"],
            ),
            (|b| b.scene.meta.materials[2].varies = false, &["material `floor` does not vary in the scene"]),
            (
                |b| b.scene.meta.materials[2].name = "wall".to_owned(),
                &["material `floor` is not in the scene"],
            ),
            (
                |b| b.scene.meta.materials.iter_mut().for_each(|m| m.varies = true),
                &["varies in the scene, but there are no images of it"],
            ),
            (fewer_bases, &["3 bases, the BRDF basis has 2"]),
            (
                |b| Arc::make_mut(&mut b.images.head).pixel[0] = 99,
                &["section `fragments/pixel`", "outside the film"],
            ),
        ];
        for (change, expected) in cases {
            assert_refused(change, |_| (), expected);
        }
    }

    fn fewer_bases(bundle: &mut TestBundle) {
        bundle.basis.coefficients.truncate(6);
        bundle.basis.functions = relume_formats::kinds::brdf_basis::Functions::BlinnPhong {
            lobes: vec![0.0; relume_formats::basis::lobe_table::NODES],
        };
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
            (track(&["environment", "rotation_deg"], &[0.5], &[3.0]), "at 0.5 s: sets [environment]"),
            (
                track(&["camera", "fov_deg"], &[0.5], &[30.0]),
                "the camera's position, target or field of view",
            ),
            (track(&["camera", "exposure_ev"], &[0.5, 2.0], &[1.0, 50.0]), "at 2 s: camera: exposure_ev 50"),
            (track(&["materials", "../knot", "gloss"], &[0.5], &[3.0]), "unknown field `gloss`"),
            (track(&["lights", "lamp", "gain"], &[0.5], &[3.0]), "invalid type"),
        ];
        for (track, expected) in cases {
            assert_refused(with(track), |_| (), &["animation-glow.relume", expected]);
        }
        let curve = Track {
            values: TrackValues::Name(vec!["filmic".to_owned()]),
            ..track(&["view", "tonemap"], &[0.5], &[])
        };
        assert_refused(
            move |b| b.animation.tracks.push(curve.clone()),
            |_| (),
            &["animation-glow.relume", "unknown variant `filmic`"],
        );
        let shininess = track(&["materials", "../knot", "shininess"], &[0.0, 1.5], &[10.0, 300.0]);
        let change = |b: &mut TestBundle| b.animation.tracks[1] = shininess.clone();
        assert_refused(change, |_| (), &["at 1.5 s: material `../knot`: shininess 300"]);
        // kd alone stays below 1 at every key, kd + ks does not: ks is the scene's 0.25.
        let bright = |b: &mut TestBundle| {
            b.animation.tracks[0].values = TrackValues::Vector(vec![vec![0.5; 3], vec![0.875; 3]])
        };
        assert_refused(bright, |_| (), &["at 2 s: material `../knot`: kd + ks"]);
        let other = |b: &mut TestBundle| b.animation.tracks[1].leaf[1] = "white".to_owned();
        assert_refused(
            other,
            |_| (),
            &["material `white`", "only material `../knot`, material `floor` vary"],
        );
    }
}
