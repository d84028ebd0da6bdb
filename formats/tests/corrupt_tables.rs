//! Tables whose content is not the table that their kind stands for.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::refusal;
use relume_formats::Error;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::{HaarTable, VisibilityTable};

fn assert_refused(change: impl Fn(&mut RawSection), expected: &str) {
    let folder = tempfile::tempdir().unwrap();
    let sound = RawFile::parse(&HaarTable::bake().write_file(&folder.path().join("a.relume")).unwrap());
    // Put together by hand: halves in planes, in a file of kind 5.
    let mut section = RawSection::new("coefficients", 3, &[16, 65_536], 1, &sound.sections[0].raw());
    assert_eq!((&section.shape, section.element), (&sound.sections[0].shape, sound.sections[0].element));
    change(&mut section);
    let error = refusal(Kind::HaarTable, &RawFile::new(5, vec![section]).bytes());
    let message = error.to_string();
    assert!(
        matches!(error, Error::Invalid { .. })
            && message.contains(expected)
            && message.contains("section `coefficients`"),
        "{message}"
    );
}

#[test]
fn other_shapes_and_types_are_refused() {
    assert_refused(|s| s.shape = vec![65_536, 16], "has shape [65536, 16], expected [16, 65536]");
    assert_refused(|s| s.element = 1, "holds u16, expected f16");
    assert_refused(
        |s| (s.shape, s.raw_bytes) = (vec![16, 65_535], 2 * 16 * 65_535),
        "cannot be decompressed",
    );
}

#[test]
fn a_single_other_value_is_refused() {
    // The scaling coefficient of bitmap 1 is 0.25, half 0x3400; of bitmap 0 it is 0, not -0.
    for (coefficient, bitmap, bits) in
        [(0, 1, 0x3401u16), (0, 0, 0x8000), (15, 65_535, 0x3C00), (7, 300, 0x7E00)]
    {
        let change = |section: &mut RawSection| {
            let (mut raw, at) = (section.raw(), 2 * (coefficient * 65_536 + bitmap));
            raw[at..at + 2].copy_from_slice(&bits.to_le_bytes());
            section.set_raw(&raw);
        };
        assert_refused(change, &format!("coefficient {coefficient} of bitmap {bitmap} is wrong"));
    }
}

fn assert_visibility_refused(change: impl Fn(&mut RawSection), expected: &str) {
    let folder = tempfile::tempdir().unwrap();
    let sound = RawFile::parse(&VisibilityTable::bake().write_file(&folder.path().join("a.relume")).unwrap());
    // Put together by hand: bytes, in a file of kind 10.
    let mut section = RawSection::new("rings", 0, &[136, 6144], 0, &sound.sections[0].raw());
    assert_eq!((&section.shape, section.element), (&sound.sections[0].shape, sound.sections[0].element));
    change(&mut section);
    let error = refusal(Kind::VisibilityTable, &RawFile::new(10, vec![section]).bytes());
    let message = error.to_string();
    assert!(
        matches!(error, Error::Invalid { .. })
            && message.contains(expected)
            && message.contains("section `rings`"),
        "{message}"
    );
}

#[test]
fn visibility_of_other_shapes_and_types_is_refused() {
    assert_visibility_refused(|s| s.shape = vec![6144, 136], "has shape [6144, 136], expected [136, 6144]");
    assert_visibility_refused(|s| s.element = 5, "holds i8, expected u8");
    assert_visibility_refused(
        |s| (s.shape, s.raw_bytes) = (vec![136, 6143], 136 * 6143),
        "cannot be decompressed",
    );
}

#[test]
fn a_single_other_texel_is_refused() {
    // The first direction is the corner of +X, which its own texel is in ring 0 of and all of -X beyond the
    // last.
    for (direction, texel, ring) in [(0, 0, 1), (0, 1024, 31), (0, 1024, 33), (135, 6143, 0), (77, 3000, 255)]
    {
        let change = |section: &mut RawSection| {
            let mut raw = section.raw();
            assert_ne!(raw[direction * 6144 + texel], ring);
            raw[direction * 6144 + texel] = ring;
            section.set_raw(&raw);
        };
        assert_visibility_refused(change, &format!("texel {texel} of stored direction {direction} is wrong"));
    }
}

#[test]
fn a_damaged_or_shortened_visibility_table_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = VisibilityTable::bake().write_file(&folder.path().join("a.relume")).unwrap();
    for at in (0..file.len()).step_by(997) {
        let mut damaged = file.clone();
        damaged[at] ^= 4;
        refusal(Kind::VisibilityTable, &damaged);
        refusal(Kind::VisibilityTable, &file[..at]);
    }
}
