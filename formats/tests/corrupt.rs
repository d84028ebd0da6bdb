//! Damaged, cut, forged and random containers are refused with an error that names the file, and nothing ever
//! panics.
//!
//! Forged files have valid checksums, so what refuses them is the check that is meant, not the checksum
//! before it.

use crate::support::raw_file::{RawFile, RawSection};
use crate::support::reading::{read_and_use, refusal};
use crate::support::regions;
use crate::support::samples::{self, Random};
use crate::support::scenes;
use crate::support::shapes::shape;
use crate::support::spheres::sphere_set;
use proptest::prelude::*;
use relume_formats::container::{Kind, Reader, Stored};
use relume_formats::kinds::HaarTable;
use relume_formats::{Error, Place};
use std::sync::LazyLock;
use xxhash_rust::xxh3::xxh3_64;

fn written(value: &impl Stored) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    value.write_file(&folder.path().join("a.relume")).unwrap()
}

/// Small sound files, of all models where that matters.
fn sound_files() -> [(Kind, Vec<u8>); 10] {
    // Made once: compressing the table takes long.
    static FILES: LazyLock<[(Kind, Vec<u8>); 10]> = LazyLock::new(|| {
        [
            (Kind::Scene, written(&scenes::scene(3))),
            (Kind::Animation, written(&scenes::animation(3))),
            (Kind::BrdfBasis, written(&samples::basis(3, 3, true))),
            (Kind::BrdfBasis, written(&samples::ggx_basis(3, 3, 2))),
            (Kind::BrdfBasis, written(&samples::cook_torrance_basis(3, 3, 2))),
            (Kind::TransferImages, written(&samples::images(3, 1, 2, true, [3, 2]))),
            (Kind::RegionImages, written(&regions::region_images(3, 2, true, [3, 2]))),
            (Kind::HaarTable, written(&HaarTable::bake())),
            (Kind::SphereSet, written(&sphere_set(3, 5, 9, 3, 0.5))),
            (Kind::Shape, written(&shape(3, 5))),
        ]
    });
    FILES.clone()
}

#[test]
fn every_flipped_bit_is_noticed() {
    for (kind, file) in sound_files() {
        let table_bytes = u32::from_le_bytes(file[20..24].try_into().unwrap()) as usize;
        let payload = 32 + table_bytes;
        for at in (0..payload).chain((payload..file.len()).step_by(7)) {
            for bit in [0, 3, 7] {
                let mut damaged = file.clone();
                damaged[at] ^= 1 << bit;
                let error = refusal(kind, &damaged);
                let checksum = error.to_string().contains("checksum does not match");
                // Magic, version and table length are looked at before the checksum that covers them.
                assert!(checksum || at < 12 || (20..24).contains(&at), "{} byte {at}: {error}", kind.name());
                assert!(
                    at < payload || error.to_string().contains("section `"),
                    "{} byte {at}: {error}",
                    kind.name()
                );
            }
        }
    }
}

#[test]
fn every_prefix_and_every_tail_is_refused() {
    for (kind, mut file) in sound_files() {
        for length in 0..file.len() {
            let error = refusal(kind, &file[..length]);
            assert!(matches!(error, Error::Invalid { .. }), "{} bytes of {}: {error}", length, kind.name());
        }
        file.push(0);
        let message = refusal(kind, &file).to_string();
        assert!(message.contains(&format!("but the file has {}", file.len())), "{message}");
    }
}

/// A stream that ends early although its announced length is right, as a broken download does.
#[test]
fn a_stream_that_ends_early_is_refused_where_it_ends() {
    let file = written(&scenes::scene(3));
    let mut reader =
        Reader::new(&file[..file.len() - 1], file.len() as u64, Place::file("stream.relume")).unwrap();
    let error = loop {
        match reader.next_section() {
            Ok(section) => assert!(section.is_some(), "the end was not noticed"),
            Err(error) => break error,
        }
    };
    assert_eq!(
        error.to_string(),
        "stream.relume: section `triangles`: the file ends early; it is cut short, bake it again"
    );
}

#[test]
fn other_versions_and_kinds_are_unsupported_by_name() {
    type Change = fn(&mut RawFile);
    let cases: [(Change, &str); 4] = [
        (|f| f.container_version = 1, "container version 1, this program reads version 0"),
        (|f| f.container_version = u32::MAX, "container version 4294967295, this program reads version 0"),
        (|f| f.kind_version = 9, "version 9, this program reads version 0"),
        (|f| f.kind = 77, "kind number 77 is unknown"),
    ];
    for (kind, file) in sound_files() {
        for (change, expected) in cases {
            let mut forged = RawFile::parse(&file);
            change(&mut forged);
            let error = refusal(kind, &forged.bytes());
            assert!(matches!(error, Error::Unsupported { .. }), "{error}");
            assert!(error.to_string().contains(expected), "{error}");
        }
        let other = if kind == Kind::Scene { Kind::BrdfBasis } else { Kind::Scene };
        let message = refusal(other, &file).to_string();
        assert!(
            message.contains(&format!("holds kind `{}`, expected `{}`", kind.name(), other.name())),
            "{message}"
        );
    }
}

/// Claims that would take all memory, or overflow, if anything were allocated before they are checked.
#[test]
fn oversized_claims_are_refused() {
    let cases: Vec<(&str, RawFile, &str)> = vec![
        (
            "a section of all addresses",
            claim(0, &[u64::MAX], u64::MAX),
            "at most 134217728 are allowed in a section",
        ),
        (
            "a section a byte too long",
            claim(0, &[(128 << 20) + 1], (128 << 20) + 1),
            "at most 134217728 are allowed in a section",
        ),
        ("a shape whose product wraps to 0", claim(4, &[1 << 33, 1 << 33], 0), "does not make 0 bytes"),
        ("a shape that says less", claim(2, &[3], 16), "[3] of u32 does not make 16 bytes"),
        ("nine dimensions", claim(0, &[1; 9], 1), "9 dimensions"),
        (
            "a stored length of all addresses",
            with(|f| f.sections[0].stored_bytes = u64::MAX),
            "stored as 18446744073709551615 bytes",
        ),
        ("a stored length beyond the file", with(|f| f.sections[1].stored_bytes += 50), "but the file has"),
        ("a table beyond the file", with(|f| f.table_bytes_error = 1 << 20), "does not fit"),
        ("a table of 4 GiB", with(|f| f.table_bytes_error = u32::MAX - 4096), "does not fit"),
        ("more sections than the table holds", with(|f| f.section_count = 3), "section table is malformed"),
        ("sections without number", with(|f| f.section_count = u64::MAX), "section table is malformed"),
        (
            "too many sections",
            RawFile::new(1, empty_sections((1 << 16) + 1)),
            "65537 sections, kind `scene` has at most 4",
        ),
        (
            "sections of more than 2 GiB together",
            RawFile::new(8, claims(17)),
            "decode to 2281701376, more than 2147483648 are not read",
        ),
        ("a name of all addresses", table_of(&[&u64::MAX.to_le_bytes()]), "section table is malformed"),
        (
            "dimensions without number",
            table_of(&[&1u64.to_le_bytes(), b"a", &0u32.to_le_bytes(), &(1u64 << 40).to_le_bytes()]),
            "section table is malformed",
        ),
    ];
    for (name, file, expected) in cases {
        assert_invalid(name, &file, expected);
    }
}

#[test]
fn tables_that_contradict_themselves_are_refused() {
    let cases: Vec<(&str, RawFile, &str)> = vec![
        ("a hole", with(|f| f.sections[1].offset_error = 1), "sections must be contiguous"),
        ("an overlap", with(|f| f.sections[1].offset_error = u64::MAX), "sections must be contiguous"),
        (
            "a first section in the header",
            with(|f| f.sections[0].offset_error = 0u64.wrapping_sub(40)),
            "sections must be contiguous",
        ),
        ("a name twice", with(|f| f.sections[1].name = "a".to_owned()), "the name occurs twice"),
        ("no name", with(|f| f.sections[0].name.clear()), "1 to 64 characters"),
        ("a long name", with(|f| f.sections[0].name = "n".repeat(65)), "1 to 64 characters"),
        ("a name in capitals", with(|f| f.sections[0].name = "A".to_owned()), "1 to 64 characters"),
        ("a name with a line break", with(|f| f.sections[0].name = "a\nb".to_owned()), "section `a\\nb`"),
        ("an unknown element", with(|f| f.sections[0].element = 7), "section table is malformed"),
        ("an unknown codec", with(|f| f.sections[0].codec = 2), "section table is malformed"),
        ("a table with more in it", with(|f| f.table_tail = vec![0]), "bytes left over"),
        ("fewer sections than the table holds", with(|f| f.section_count = 1), "bytes left over"),
    ];
    for (name, file, expected) in cases {
        assert_invalid(name, &file, expected);
    }
}

#[test]
fn payloads_that_are_not_what_they_claim_are_refused() {
    let zstd = |raw: &[u8]| zstd::bulk::compress(raw, 3).unwrap();
    let cases = [
        ("no zstd", vec![7; 9], "cannot be decompressed"),
        ("nothing at all", Vec::new(), "decompresses to 0 bytes, expected 4"),
        ("a megabyte", zstd(&[0; 1 << 20]), "cannot be decompressed"),
        ("a byte more", zstd(&[0; 5]), "cannot be decompressed"),
        ("a byte less", zstd(&[0; 3]), "decompresses to 3 bytes, expected 4"),
        ("half of it", zstd(&[1, 2, 3, 4])[..10].to_vec(), "cannot be decompressed"),
    ];
    for (name, stored, expected) in cases {
        let mut file = two_sections();
        file.sections[0].stored_bytes = stored.len() as u64;
        file.sections[0].stored = stored;
        let bytes = file.bytes();
        let mut reader = Reader::new(&bytes[..], bytes.len() as u64, Place::file("a.relume")).expect(name);
        let message = reader.next_section().unwrap_err().to_string();
        assert!(
            message.starts_with("a.relume: section `a`: ") && message.contains(expected),
            "{name}: {message}"
        );
    }
}

fn two_sections() -> RawFile {
    RawFile::new(
        1,
        vec![RawSection::new("a", 0, &[4], 0, &[1, 2, 3, 4]), RawSection::new("b", 1, &[1], 1, &[5, 6])],
    )
}

fn with(change: impl FnOnce(&mut RawFile)) -> RawFile {
    let mut file = two_sections();
    change(&mut file);
    file
}

fn claim(element: u32, shape: &[u64], raw_bytes: u64) -> RawFile {
    with(|f| {
        (f.sections[0].element, f.sections[0].shape, f.sections[0].raw_bytes) =
            (element, shape.to_vec(), raw_bytes)
    })
}

fn empty_sections(count: usize) -> Vec<RawSection> {
    let first = RawSection::new("s", 0, &[0], 0, &[]);
    (0..count).map(|i| RawSection { name: format!("s{i}"), ..first.clone() }).collect()
}

/// Sections of 128 MiB each, of nothing.
fn claims(count: usize) -> Vec<RawSection> {
    let longest = |section| RawSection { shape: vec![128 << 20], raw_bytes: 128 << 20, ..section };
    empty_sections(count).into_iter().map(longest).collect()
}

/// A table that says it has one row, which begins with `parts`.
fn table_of(parts: &[&[u8]]) -> RawFile {
    RawFile { section_count: 1, table_tail: parts.concat(), ..RawFile::new(1, Vec::new()) }
}

fn assert_invalid(name: &str, file: &RawFile, expected: &str) {
    let error = refusal(Kind::Scene, &file.bytes());
    assert!(
        matches!(error, Error::Invalid { .. }) && error.to_string().contains(expected),
        "{name}: {error}"
    );
}

/// Reads what may be sound or not: an error or a usable value, never a panic.
fn try_all_kinds(bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("any.relume");
    std::fs::write(&path, bytes).unwrap();
    for kind in Kind::ALL {
        let _ = read_and_use(kind, &path);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn garbage_never_panics(mut bytes in prop::collection::vec(any::<u8>(), 0..200), sound_start: bool) {
        if sound_start {
            bytes.splice(0..0, two_sections().bytes()[..12].iter().copied());
        }
        try_all_kinds(&bytes);
    }

    /// Bytes of the table changed, its checksum mended.
    #[test]
    fn forged_tables_never_panic(seed: u64, file in 0usize..8, changes in 1usize..6) {
        let (_, mut file) = sound_files()[file].clone();
        let random = &mut Random(seed);
        let payload = 32 + u32::from_le_bytes(file[20..24].try_into().unwrap()) as usize;
        for _ in 0..changes {
            let at = if random.below(4) == 0 { 12 + random.below(8) } else { 32 + random.below(payload - 32) };
            file[at] = [random.bits() as u8, 0, 1, 255][random.below(4)];
        }
        let checksum = xxh3_64(&[&file[8..24], &file[32..payload]].concat());
        file[24..32].copy_from_slice(&checksum.to_le_bytes());
        try_all_kinds(&file);
    }

    /// The content of a section changed, all checksums mended: this reaches the checks of every kind.
    #[test]
    fn forged_contents_never_panic(seed: u64, file in 0usize..8, changes in 1usize..4) {
        let (_, file) = sound_files()[file].clone();
        let random = &mut Random(seed);
        let mut file = RawFile::parse(&file);
        let at = random.below(file.sections.len());
        let section = &mut file.sections[at];
        let mut raw = section.raw();
        for _ in 0..changes.min(raw.len()) {
            let at = random.below(raw.len());
            raw[at] = [random.bits() as u8, raw[at] ^ 1, 0, 255][random.below(4)];
        }
        section.set_raw(&raw);
        try_all_kinds(&file.bytes());
    }
}
