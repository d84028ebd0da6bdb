//! `manifest.json`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relume_formats::kinds::{Manifest, manifest};
use relume_formats_fuzz::folder;
use std::path::PathBuf;
use std::sync::LazyLock;

static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| folder("manifest"));

fuzz_target!(|data: &[u8]| {
    std::fs::write(FOLDER.join(manifest::FILE_NAME), data).expect("a temporary file");
    match Manifest::read(&FOLDER) {
        Ok(read) => {
            read.entries().for_each(|e| assert!(manifest::is_plain_name(&e.file)));
            read.method(None, &relume_formats::Place::file("manifest.json")).expect("a method");
            read.write(&FOLDER).expect("what can be read can be written");
            assert_eq!(Manifest::read(&FOLDER).expect("what was written can be read"), read);
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "`{error}`"),
    }
});
