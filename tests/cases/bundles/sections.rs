//! Whole sections changed at once: each such change is refused by every reader, or stands here as one that makes another legal bundle.

use super::raw_file::{RawFile, RawSection};
use super::{SOUND, Sound, gpu_there, verdict};

/// What is done to every value of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    Times(f32),
    Reverse,
}

const CHANGES: [Change; 6] =
    [Change::Times(-1.0), Change::Times(0.0), Change::Times(10.0), Change::Times(1000.0), Change::Times(1e20), Change::Reverse];

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
        (3, &[a, b]) => half::f16::from_f32(half::f16::from_le_bytes([a, b]).to_f32() * factor).to_le_bytes().to_vec(),
        (5, &[a]) => (((a as i8) as f32 * factor) as i8).to_le_bytes().to_vec(),
        (6, &[a, b]) => ((f32::from(i16::from_le_bytes([a, b])) * factor) as i16).to_le_bytes().to_vec(),
        (_, &[a, b]) => (u16::from_le_bytes([a, b])).wrapping_mul(factor as i64 as u16).to_le_bytes().to_vec(),
        (_, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d])).wrapping_mul(factor as i64 as u32).to_le_bytes().to_vec(),
        _ => value.to_vec(),
    }
}

#[test]
fn explore() {
    for sound in SOUND.iter().map(Sound::copy) {
        for (path, file) in &sound.files {
            let t = std::time::Instant::now();
            let mut n = 0;
            for (at, section) in file.sections.iter().enumerate().filter(|(_, section)| section.element != 0) {
                for change in CHANGES {
                    let Some(changed) = change.of(section) else { continue };
                    sound.change(path, |file| file.sections[at] = changed);
                    n += 1;
                    if relume_bake::inspect::verify(&sound.out()).is_ok() {
                        println!("ACCEPTED {} {} {change:?}", path.file_name().unwrap().display(), section.name);
                    }
                }
            }
            sound.mend(path);
            println!("{} {n} {:?}", path.display(), t.elapsed());
        }
    }
}
