//! Whole sections changed at once: each such change is refused by every reader, or stands here as one that
//! makes another legal bundle.

use super::raw_file::RawSection;
use super::{SOUND, Sound, gpu_there, verdict};
use relume_bake::inspect;
use relume_formats::kinds::Manifest;
use serde_json::json;

/// What is done to every value of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    Times(f32),
    Reverse,
}

const CHANGES: [Change; 6] = [
    Change::Times(-1.0),
    Change::Times(0.0),
    Change::Times(10.0),
    Change::Times(1000.0),
    Change::Times(1e20),
    Change::Reverse,
];

impl Change {
    /// `None` if it leaves the section as it is.
    fn of(self, section: &RawSection) -> Option<RawSection> {
        let (before, width) = (section.raw(), RawSection::width(section.element));
        let elements = before.chunks_exact(width);
        let raw: Vec<u8> = match self {
            Self::Reverse => elements.rev().flatten().copied().collect(),
            Self::Times(factor) => elements.flat_map(|value| times(section.element, value, factor)).collect(),
        };
        let mut changed = section.clone();
        changed.set_raw(&raw);
        (raw != before).then_some(changed)
    }
}

/// Floats as they are, whole numbers wrapped or at the end of their range.
fn times(element: u32, value: &[u8], factor: f32) -> Vec<u8> {
    match (element, value) {
        (4, &[a, b, c, d]) => (f32::from_le_bytes([a, b, c, d]) * factor).to_le_bytes().to_vec(),
        (3, &[a, b]) => {
            half::f16::from_f32(half::f16::from_le_bytes([a, b]).to_f32() * factor).to_le_bytes().to_vec()
        }
        (5, &[a]) => (((a as i8) as f32 * factor) as i8).to_le_bytes().to_vec(),
        (6, &[a, b]) => ((f32::from(i16::from_le_bytes([a, b])) * factor) as i16).to_le_bytes().to_vec(),
        (_, &[a, b]) => {
            (u16::from_le_bytes([a, b])).wrapping_mul(factor as i64 as u16).to_le_bytes().to_vec()
        }
        (_, &[a, b, c, d]) => {
            (u32::from_le_bytes([a, b, c, d])).wrapping_mul(factor as i64 as u32).to_le_bytes().to_vec()
        }
        _ => value.to_vec(),
    }
}

/// Whether a change makes another legal bundle: other meshes, other light, other transport or another motion,
/// which nothing in the bundle contradicts.
fn is_harmless(file: &str, section: &str, change: Change) -> bool {
    let is_times = |factors: &[f32]| factors.iter().any(|factor| change == Change::Times(*factor));
    let kind = section.split('/').next().unwrap_or_default();
    match (file.split(['-', '.']).next().unwrap_or_default(), kind) {
        // Where no sphere set and no receivers hang on them. Imported normals may point away.
        ("scene", "positions") => is_times(&[-1.0, 10.0, 1000.0]),
        ("scene", "normals") => is_times(&[-1.0]) || change == Change::Reverse,
        ("scene", "triangles") => change == Change::Reverse,
        // What glossy bases make of light is signed; fragments in another order are another picture.
        ("transfer", "image") => is_times(&[-1.0]) || change == Change::Reverse,
        ("environment", "texels") => is_times(&[0.0, 10.0]) || change == Change::Reverse,
        // Transfer is signed, its terms are in any order, and less than everything is no fault; more than 16
        // is.
        ("sparse", "index") => is_times(&[0.0]) || change == Change::Reverse,
        ("sparse", "scale") => is_times(&[0.0, 10.0, 1000.0]) || change == Change::Reverse,
        ("sparse", "value") => true,
        // Other triangles of the same object may cast, the other way around, before their vertices or behind them.
        ("sphere", "casters") => change == Change::Reverse,
        ("sphere", "caster_offsets") => true,
        // Triangles that leave the surface where it is have no errors, whatever these are multiplied by.
        ("sphere", "caster_errors") => true,
        // Nothing plays the history of a fit that looked at poses; it still never rises.
        ("spheres", "history") => is_times(&[0.0, 10.0, 1000.0, 1e20]),
        // Another motion; rotations are normalised, and no vertex gets beyond 10¹⁸ m.
        ("shape", "joint-indices") => is_times(&[0.0]) || change == Change::Reverse,
        ("shape", "joint-weights") => change == Change::Reverse,
        ("shape", "key-values") => change != Change::Times(0.0),
        _ => false,
    }
}

/// Every change of every section of every file; one in five goes to all readers, the player among them for
/// one in twenty.
#[test]
fn sections_changed_at_once_are_refused_or_known_to_be_harmless() {
    let (shown, mut count, mut refused) = (gpu_there(), 0, 0);
    for sound in SOUND.iter().map(Sound::copy) {
        for (path, file) in &sound.files {
            let name = path.file_name().unwrap().to_str().unwrap();
            for (at, section) in file.sections.iter().enumerate().filter(|(_, section)| section.element != 0)
            {
                for (change, changed) in
                    CHANGES.iter().filter_map(|change| Some((*change, change.of(section)?)))
                {
                    sound.change(path, |file| file.sections[at] = changed);
                    let what = format!("{change:?} of section `{}` of {name}", section.name);
                    let outcome = match count % 5 {
                        0 => verdict(&sound.out(), &what, shown && count % 20 == 0),
                        _ => inspect::verify(&sound.out()).map(drop).map_err(|error| error.to_string()),
                    };
                    assert!(
                        outcome.is_err() || is_harmless(name, &section.name, change),
                        "{what} is accepted"
                    );
                    count += 1;
                    refused += usize::from(outcome.is_err());
                }
            }
            sound.mend(path);
        }
    }
    assert!(refused * 2 > count, "{refused} of {count} changes were noticed");
}

/// The manifest after `change`, written whole.
fn with_manifest(sound: &Sound, change: impl FnOnce(&mut Manifest)) {
    let mut manifest = Manifest::read(&sound.out()).unwrap();
    change(&mut manifest);
    manifest.write(&sound.out()).unwrap();
}

#[test]
fn settings_that_contradict_the_files_are_refused_by_every_reader() {
    let [images, rows, shadows] = SOUND.each_ref().map(Sound::copy);
    let shown = gpu_there();
    for (sound, name, value, expected) in [
        (&images, "bases", json!(77), "method `transfer-images`: setting `bases` is 77, the file has 3"),
        (&images, "size", json!([9, 9]), "setting `size` is [9,9], the file has [6,5]"),
        (&images, "samples", json!(5), "setting `samples` is 5, the file has 4"),
        (&images, "seed", json!(6), "setting `seed` is 6, the file has 5"),
        (&rows, "terms", json!(21), "method `sparse-transfer`: setting `terms` is 21, the file has 20"),
        (&rows, "rays_per_texel", json!(2), "setting `rays_per_texel` is 2, the file has 1"),
        (
            &shadows,
            "objects",
            json!([["ball", 3], ["plane", null]]),
            "setting `objects` does not list the objects of the scene",
        ),
        (
            &shadows,
            "objects",
            json!([["plane", 3], ["ball", 3]]),
            "setting `objects` does not list the objects of the scene",
        ),
    ] {
        let whole = Manifest::read(&sound.out()).unwrap();
        with_manifest(sound, |manifest| drop(manifest.methods[0].settings.insert(name.to_owned(), value)));
        let message = verdict(&sound.out(), name, shown).unwrap_err();
        assert!(message.contains("manifest.json: ") && message.contains(expected), "{message}");
        whole.write(&sound.out()).unwrap();
    }
    for (name, value, expected) in [
        ("spheres", 2, "setting `spheres` is 2, the file has 3"),
        ("seed", 9, "setting `seed` is 9"),
        ("iterations", 1, "`iterations` is 1"),
    ] {
        let whole = Manifest::read(&shadows.out()).unwrap();
        with_manifest(&shadows, |manifest| {
            manifest.sphere_sets.get_mut("ball").unwrap().settings.insert(name.to_owned(), json!(value));
        });
        let message = verdict(&shadows.out(), name, shown).unwrap_err();
        assert!(message.contains("spheres of `ball`") && message.contains(expected), "{message}");
        whole.write(&shadows.out()).unwrap();
    }
}
