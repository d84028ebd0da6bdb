//! What the fuzz targets share: files that get past every checksum, and what must hold of whatever a reader
//! makes of them.

#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/playing.rs"]
pub mod playing;
#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/raw_file.rs"]
pub mod raw_file;
pub mod recipe;

use relume_formats::container::{Reader, Sections, Stored, Writer};
use relume_formats::{Error, Place, Result};
use std::path::{Path, PathBuf};

/// The place that messages name.
pub fn place() -> Place {
    Place::file("fuzzed")
}

/// Reads a file of one kind from memory.
pub fn read<T: Stored>(file: &[u8]) -> Result<T> {
    let mut reader = Reader::new(file, file.len() as u64, place())?;
    reader.header().expect_kind(T::KIND, T::VERSION, reader.place())?;
    let mut next = || reader.next_section();
    let mut sections = Sections { place: place(), next: &mut next };
    let value = T::decode(&mut sections)?;
    sections.finish()?;
    Ok(value)
}

/// The file that holds `value`, which a reader has accepted or is to accept.
pub fn write<T: Stored>(value: &T) -> Vec<u8> {
    let mut writer = Writer::new(T::KIND, T::VERSION, place());
    value.encode(&mut writer).expect("what can be read can be written");
    writer.finish().expect("what can be read can be written")
}

/// Reads `data` as a file of one kind: the first byte says whether the rest is a file or a [`recipe`] of one.
/// What is accepted must survive `play`, and writing and reading again; what is refused must be refused in
/// one line.
pub fn read_and_play<T: Stored>(data: &[u8], play: impl Fn(&T)) {
    let Some((mode, data)) = data.split_first() else { return };
    let file = if mode & 1 == 0 { recipe::file(T::KIND, data) } else { data.to_vec() };
    match read::<T>(&file) {
        Ok(value) => {
            play(&value);
            let written = write(&value);
            let again: T = read(&written).expect("what was written can be read");
            assert_eq!(write(&again), written, "reading and writing again changes nothing");
        }
        Err(error) => check_refusal(&error),
    }
}

/// An error is one line that begins with the file.
pub fn check_refusal(error: &Error) {
    let message = error.to_string();
    assert!(message.starts_with("fuzzed: ") && !message.contains('\n'), "`{message}`");
}

/// A folder of this process, in memory where the system has a file system there.
pub fn folder(name: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    let folder = parent.join(format!("relume-fuzz-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    folder
}
