//! What is written comes back equal, twice the same bytes, laid out as documented; a failed write leaves
//! nothing behind.

use crate::support::raw_file::RawFile;
use crate::support::received::tensors;
use crate::support::tensors::tensor;
use crate::support::{regions, samples, scenes};
use half::f16;
use proptest::prelude::*;
use relume_formats::container::{CONTAINER_VERSION, Codec, Element, Kind, MAGIC, Reader, Stored, Writer};
use relume_formats::kinds::manifest::{FileEntry, MethodEntry, SphereSetEntry};
use relume_formats::kinds::{HaarTable, Manifest, TransferImages, VisibilityTable};
use relume_formats::state::Model;
use relume_formats::{Error, Place};
use ruzstd::decoding::FrameDecoder;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

fn assert_round_trip<T: Stored + PartialEq + Debug>(value: &T) {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("a.relume"), folder.path().join("b.relume"));
    let bytes = value.write_file(&first).unwrap();
    assert_eq!(std::fs::read(&first).unwrap(), bytes);
    let read = T::read_file(&first).unwrap();
    assert_eq!(&read, value);
    assert_eq!(read.write_file(&second).unwrap(), bytes, "reading and writing again changes nothing");
    // The same file, taken apart and put together by code that shares nothing with the container's.
    let by_hand = RawFile::parse(&bytes);
    assert_eq!(by_hand.bytes(), bytes);
    let mut reader = relume_formats::container::open(&first).unwrap();
    for section in &by_hand.sections {
        // And both decoders find the same in it.
        let (mut in_rust, in_c) = (
            vec![0; section.raw_bytes as usize],
            zstd::bulk::decompress(&section.stored, section.raw_bytes as usize).unwrap(),
        );
        let length = FrameDecoder::new().decode_all(&section.stored, &mut in_rust).unwrap();
        assert!(
            length == in_c.len() && in_rust == in_c,
            "libzstd and ruzstd differ in section `{}`",
            section.name
        );
        assert_eq!(section.raw(), reader.next_section().unwrap().unwrap().bytes, "{}", section.name);
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2, "no other file is left");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn scenes(seed: u64) {
        assert_round_trip(&scenes::scene(seed));
    }

    #[test]
    fn animations(seed: u64) {
        assert_round_trip(&scenes::animation(seed));
    }

    #[test]
    fn bases(seed: u64, bases in 2usize..6, smooth: bool) {
        assert_round_trip(&samples::basis(seed, bases, smooth));
    }

    #[test]
    fn microfacet_bases(seed: u64, bases in 2usize..=32, samples in 1usize..=64) {
        assert_round_trip(&samples::ggx_basis(seed, bases, samples));
        assert_round_trip(&samples::cook_torrance_basis(seed, bases, samples));
    }

    #[test]
    fn brdf_tensors(seed: u64, a in 1usize..5, b in 1usize..9, c in 1usize..9) {
        let model = [Model::BlinnPhong, Model::Ggx, Model::CookTorrance][seed as usize % 3];
        assert_round_trip(&tensor(seed, model, [a, b, c]));
    }

    #[test]
    fn transfer_tensors(seed: u64, vertices in 1usize..6, columns in 1usize..5, reflections in 1u32..4) {
        assert_round_trip(&tensors(seed, vertices, columns, &[1, 2], reflections));
    }

    #[test]
    fn transfer_images(seed: u64, materials in 1usize..4, bases in 2usize..5, one_colour: bool, width in 1u32..6, height in 1u32..6) {
        assert_round_trip(&samples::images(seed, materials, bases, one_colour, [width, height]));
        assert_round_trip(&samples::images_of_all(seed, materials, bases, one_colour, [width, height]));
    }

    #[test]
    fn region_images(seed: u64, bases in 2usize..5, one_colour: bool, width in 1u32..70, height in 1u32..6) {
        assert_round_trip(&regions::region_images(seed, bases, one_colour, [width, height]));
    }

    #[test]
    fn manifests(manifest in any_manifest()) {
        let folder = tempfile::tempdir().unwrap();
        manifest.write(folder.path()).unwrap();
        let text = std::fs::read(folder.path().join("manifest.json")).unwrap();
        let read = Manifest::read(folder.path()).unwrap();
        prop_assert_eq!(&read, &manifest);
        read.write(folder.path()).unwrap();
        prop_assert_eq!(std::fs::read(folder.path().join("manifest.json")).unwrap(), text);
    }

    #[test]
    fn every_element_type(words in prop::collection::vec(any::<u32>(), 0..300), columns in 1usize..5) {
        let words = &words[..words.len() / columns * columns];
        let shape = [(words.len() / columns) as u64, columns as u64];
        let floats: Vec<f32> = words.iter().map(|w| f32::from_bits(*w)).collect();
        let shorts: Vec<u16> = words.iter().map(|w| *w as u16).collect();
        let halves: Vec<f16> = shorts.iter().map(|w| f16::from_bits(*w)).collect();

        let mut writer = Writer::new(Kind::TransferImages, 7, Place::file("test"));
        writer.record("record", &(3u8, words)).unwrap();
        writer.u16s("u16", &shape, &shorts).unwrap();
        writer.u32s("u32", &shape, words).unwrap();
        writer.f16s("f16", &shape, &halves).unwrap();
        writer.f32s("f32", &shape, &floats).unwrap();
        let file = writer.finish().unwrap();

        let mut reader = Reader::new(&file[..], file.len() as u64, Place::file("test")).unwrap();
        prop_assert_eq!((reader.header().kind, reader.header().kind_version), (Kind::TransferImages, 7));
        let mut next = || reader.next_section().unwrap().unwrap();
        prop_assert_eq!(next().record::<(u8, Vec<u32>)>().unwrap(), (3, words.to_vec()));
        let section = next();
        section.expect_shape(&shape).unwrap();
        prop_assert_eq!(section.u16s().unwrap(), shorts);
        prop_assert_eq!(next().u32s().unwrap(), words);
        // Bit patterns, for NaN differs from itself.
        let bits: Vec<u16> = next().f16s().unwrap().iter().map(|v| v.to_bits()).collect();
        prop_assert_eq!(bits, words.iter().map(|w| *w as u16).collect::<Vec<_>>());
        let bits: Vec<u32> = next().f32s().unwrap().iter().map(|v| v.to_bits()).collect();
        prop_assert_eq!(bits, words);
        prop_assert!(reader.next_section().unwrap().is_none());
    }

    /// Files written by hand in every combination of element and codec, those included that no kind uses
    /// today.
    #[test]
    fn every_codec(raw in prop::collection::vec(any::<u8>(), 0..200)) {
        let elements = [Element::U8, Element::U16, Element::U32, Element::F16, Element::F32];
        for (number, element) in elements.into_iter().enumerate() {
            let raw = &raw[..raw.len() / 4 * 4];
            let shape = [raw.len() as u64 / element.bytes()];
            let sections = [Codec::Zstd, Codec::ZstdPlanes]
                .iter()
                .enumerate()
                .map(|(codec, _)| crate::support::raw_file::RawSection::new(&format!("s{codec}"), number as u32, &shape, codec as u32, raw))
                .collect();
            let file = RawFile::new(4, sections).bytes();
            let mut reader = Reader::new(&file[..], file.len() as u64, Place::file("test")).unwrap();
            for codec in [Codec::Zstd, Codec::ZstdPlanes] {
                let section = reader.next_section().unwrap().unwrap();
                prop_assert_eq!((section.info.element, section.info.codec), (element, codec));
                prop_assert_eq!(&section.bytes[..], raw);
            }
        }
    }
}

/// There is one table, so its bytes are always the same; they are few.
#[test]
fn the_haar_table() {
    assert_round_trip(&HaarTable::bake());
    let folder = tempfile::tempdir().unwrap();
    let bytes = HaarTable::bake().write_file(&folder.path().join("a.relume")).unwrap();
    assert!(bytes.len() < 16 << 10, "{} bytes", bytes.len());
}

/// One in 48 of its directions, a byte for each texel instead of 32 bits: less than a thousandth of what it
/// is in memory.
#[test]
fn the_visibility_table() {
    assert_round_trip(&VisibilityTable::bake());
    let folder = tempfile::tempdir().unwrap();
    let bytes = VisibilityTable::bake().write_file(&folder.path().join("a.relume")).unwrap();
    assert!(bytes.len() < 144 << 10, "{} bytes", bytes.len());
}

fn any_manifest() -> impl Strategy<Value = Manifest> {
    let entry = ("[a-z][a-z0-9_.-]{0,20}", 0..1u64 << 50, "[0-9a-f]{32}")
        .prop_map(|(file, bytes, hash)| FileEntry { file, bytes, hash });
    let value = prop_oneof![
        any::<bool>().prop_map(serde_json::Value::from),
        any::<i64>().prop_map(serde_json::Value::from),
        (-1e300..1e300f64).prop_map(serde_json::Value::from),
        r"\PC{0,12}".prop_map(serde_json::Value::from),
    ];
    let error = prop_oneof![0.0..2.0f64, 0.0..1e100f64];
    let files = prop::collection::vec((r"\PC{0,12}", entry.clone()), 0..3);
    let settings = prop::collection::btree_map("[a-z][a-z0-9_]{0,11}", value, 0..4);
    let errors = prop::collection::btree_map("[a-z][a-z0-9_]{0,11}", error, 0..4);
    let set = (entry.clone(), prop::collection::btree_map("seed|spheres|iterations", 0..u64::MAX, 0..3))
        .prop_map(|(file, settings)| SphereSetEntry {
            file,
            settings: settings.into_iter().map(|(k, v)| (k, v.into())).collect(),
        });
    let sphere_sets = prop::collection::btree_map(r"\PC{0,12}", set, 0..3);
    let method = (r"\PC{0,12}", "[0-9a-f]{32}", files, settings, errors, r"\PC{0,12}");
    let method = method.prop_map(|(name, reads, files, settings, errors, measured_on)| MethodEntry {
        name,
        reads,
        files,
        settings,
        errors,
        measured_on,
    });
    let animations = prop::collection::btree_map(r"\PC{0,12}", entry.clone(), 0..3);
    (r"\PC{0,12}", "[0-9a-f]{32}", entry, animations, sphere_sets, prop::collection::vec(method, 1..3))
        .prop_map(|(scene, scene_hash, scene_file, animations, sphere_sets, methods)| Manifest {
            version: 0,
            scene,
            scene_hash,
            scene_file,
            animations,
            sphere_sets,
            methods,
        })
        .prop_filter("every file and every method is listed once", |manifest| {
            manifest.validate(&Place::file("manifest.json")).is_ok()
        })
}

#[test]
fn a_manifest_with_an_error_that_is_no_number_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let entry = FileEntry::of("scene.relume", b"x");
    let errors = BTreeMap::from([("relative_l2".to_owned(), f64::NAN)]);
    let method = MethodEntry {
        name: "transfer-images".to_owned(),
        reads: "0".repeat(32),
        files: Vec::new(),
        settings: BTreeMap::new(),
        errors,
        measured_on: String::new(),
    };
    let manifest = Manifest {
        version: 0,
        scene: "a".to_owned(),
        scene_hash: "0".repeat(32),
        scene_file: entry,
        animations: BTreeMap::new(),
        sphere_sets: BTreeMap::new(),
        methods: vec![method],
    };
    // JSON has no NaN: it would be written as null, which nothing could read back.
    let message = manifest.write(folder.path()).unwrap_err().to_string();
    assert!(message.contains("manifest.json") && message.contains("relative_l2"), "{message}");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
}

/// Every field of the documented layout at its documented place.
#[test]
fn the_header_is_laid_out_as_documented() {
    let mut writer = Writer::new(Kind::BrdfBasis, 0x0102_0304, Place::file("test"));
    writer.u16s("first", &[2, 1], &[0x1234, 0x5678]).unwrap();
    writer.record("x/y", &1u64).unwrap();
    let file = writer.finish().unwrap();
    let u32_at = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    let u64_at = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap());

    assert_eq!(file[..8], [0x89, b'R', b'E', b'L', b'U', b'M', b'E', 0x0A]);
    assert_eq!(file[..8], MAGIC);
    assert_eq!((u32_at(8), u32_at(12), u32_at(16)), (CONTAINER_VERSION, 3, 0x0102_0304));
    // Count; then name, element, shape, codec, four numbers: of two sections with names of 5 and 3 characters
    // and 2 and 1 dimensions.
    let row = |name: usize, dimensions: usize| 8 + name + 4 + 8 + 8 * dimensions + 4 + 4 * 8;
    let table_bytes = 8 + row(5, 2) + row(3, 1);
    assert_eq!(u32_at(20) as usize, table_bytes);
    let mut covered = file[8..24].to_vec();
    covered.extend(&file[32..32 + table_bytes]);
    assert_eq!(u64_at(24), xxh3_64(&covered));

    assert_eq!((u64_at(32), u64_at(40)), (2, 5));
    assert_eq!(&file[48..53], b"first");
    assert_eq!(u32_at(53), 1, "u16");
    assert_eq!((u64_at(57), u64_at(65), u64_at(73)), (2, 2, 1), "two dimensions, 2 × 1");
    assert_eq!(u32_at(81), 1, "planes");
    let (offset, stored) = (u64_at(85) as usize, u64_at(93) as usize);
    assert_eq!((offset, u64_at(101)), (32 + table_bytes, 4));
    assert_eq!(u64_at(109), xxh3_64(&file[offset..offset + stored]));
    assert_eq!(
        zstd::bulk::decompress(&file[offset..offset + stored], 4).unwrap(),
        [0x34, 0x78, 0x12, 0x56],
        "low bytes, then high bytes"
    );

    let second = 117;
    assert_eq!((u64_at(second), &file[second + 8..second + 11]), (3, &b"x/y"[..]));
    assert_eq!(
        (u32_at(second + 11), u64_at(second + 15), u64_at(second + 23), u32_at(second + 31)),
        (0, 1, 8, 0)
    );
    assert_eq!(u64_at(second + 35) as usize, offset + stored, "contiguous");
    assert_eq!(u64_at(second + 35) + u64_at(second + 43), file.len() as u64, "to the end of the file");
}

#[test]
fn a_section_beyond_the_binding_limit_is_refused() {
    let values = vec![0u16; (64 << 20) + 1];
    let mut writer = Writer::new(Kind::Scene, 0, Place::file("big.relume"));
    let error = writer.u16s("huge", &[values.len() as u64], &values).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }));
    assert!(error.to_string().starts_with("big.relume: section `huge`: 134217730 bytes"), "{error}");
}

fn sample() -> TransferImages {
    samples::images(1, 2, 3, true, [9, 9])
}

fn assert_write_fails(path: &Path, folder: &Path) {
    let before = std::fs::read_dir(folder).unwrap().count();
    let error = sample().write_file(path).unwrap_err();
    assert!(matches!(error, Error::Output { .. }) && !error.is_bad_input(), "{error}");
    assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), before, "nothing is left behind");
}

#[test]
fn a_write_that_fails_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    assert_write_fails(&folder.path().join("missing/a.relume"), folder.path());

    std::fs::write(folder.path().join("file"), b"x").unwrap();
    assert_write_fails(&folder.path().join("file/a.relume"), folder.path());

    // Fails only when the whole file has been written under its temporary name.
    let taken = folder.path().join("folder.relume");
    std::fs::create_dir_all(taken.join("inside")).unwrap();
    assert_write_fails(&taken, folder.path());
}

/// A limit on file sizes stops a write half way, as a full disk would.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relume");
    std::fs::write(&path, b"old").unwrap();
    let output = std::process::Command::new("sh")
        .args([
            "-c",
            r#"trap "" XFSZ; ulimit -f 1; exec "$0" --ignored --exact round_trip::child_of_a_full_disk"#,
        ])
        .arg(std::env::current_exe().unwrap())
        .env("RELUME_TEST_FOLDER", folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "the child saw its write succeed, or left something");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("1 passed"), "the child's test is there: {said}");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
#[ignore = "run by the test above, under a limit on file sizes"]
fn child_of_a_full_disk() {
    let Some(folder) = std::env::var_os("RELUME_TEST_FOLDER") else { return };
    let folder = Path::new(&folder);
    assert_write_fails(&folder.join("a.relume"), folder);
}
