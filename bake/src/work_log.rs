//! Finished work on its way from gather to packing, kept in a log on disk.
//!
//! The log makes a bake resumable and keeps its memory small: records are appended as pieces of work finish, in any order; whatever a crash cuts off at
//! the end is dropped when the log is opened again. Nobody else works in its folder: see [`crate::unfinished::FolderLock`].
//!
//! ```text
//! 16 bytes   key of the bake (xxh3-128 of everything its pieces depend on)
//! record*    piece u32, payload length u32, xxh3-64 of both and the payload, payload
//! ```

use relume_formats::{Error, Place, Result};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;
use xxhash_rust::xxh3::Xxh3;

const KEY_BYTES: usize = 16;
const RECORD_HEADER: usize = 16;

/// The log of one bake.
pub struct WorkLog {
    place: Place,
    inner: Mutex<Inner>,
}

struct Inner {
    file: File,
    end: u64,
    /// Where each piece's payload stands, and its length.
    pieces: BTreeMap<u32, Entry>,
}

/// Where the payload of a piece stands.
#[derive(Debug, Clone, Copy)]
struct Entry {
    at: u64,
    bytes: u32,
    checksum: u64,
}

impl WorkLog {
    /// Starts an empty log at `path`.
    pub fn create(path: &Path, key: u128) -> Result<Self> {
        let place = Place::file(path);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(|e| Error::output(&place, e))?;
        file.set_len(0).map_err(|e| Error::output(&place, e))?;
        file.write_all(&key.to_le_bytes()).map_err(|e| Error::output(&place, e))?;
        Ok(Self { place, inner: Mutex::new(Inner { file, end: KEY_BYTES as u64, pieces: BTreeMap::new() }) })
    }

    /// Opens the log at `path` again; `None` if it belongs to another bake.
    pub fn reopen(path: &Path, key: u128) -> Result<Option<Self>> {
        let place = Place::file(path);
        let mut file =
            OpenOptions::new().read(true).write(true).open(path).map_err(|e| Error::output(&place, e))?;
        let scan = scan(&mut file, key).map_err(|e| Error::output(&place, e))?;
        Ok(scan.map(|(pieces, end)| Self { place, inner: Mutex::new(Inner { file, end, pieces }) }))
    }

    /// The log at `path` for reading alone; `None` if nothing can be read there, or it belongs to another bake.
    pub fn read_only(path: &Path, key: u128) -> Option<Self> {
        if !path.is_file() {
            return None;
        }
        let mut file = File::open(path).ok()?;
        let (pieces, end) = scan(&mut file, key).ok()??;
        Some(Self { place: Place::file(path), inner: Mutex::new(Inner { file, end, pieces }) })
    }

    /// Adds the pieces of the log at `from` to those of the log at `path`, which is made if it is not there.
    ///
    /// # Errors
    /// If one of them cannot be read or written, or `path` is the log of another bake.
    pub fn absorb(path: &Path, from: &Path) -> Result<()> {
        let place = Place::file(from);
        let mut key = [0; KEY_BYTES];
        File::open(from).and_then(|mut file| file.read_exact(&mut key)).map_err(|e| Error::io(&place, e))?;
        let key = u128::from_le_bytes(key);
        let other = || Error::invalid(&place, "is of another bake; bake that part again with --force");
        let theirs = Self::reopen(from, key)?.ok_or_else(other)?;
        let ours = if Self::exists(path) {
            Self::reopen(path, key)?.ok_or_else(other)?
        } else {
            Self::create(path, key)?
        };
        let known = ours.finished();
        let new = theirs.finished().into_iter().filter(|piece| known.binary_search(piece).is_err());
        new.into_iter().try_for_each(|piece| ours.append(piece, &theirs.read(piece)?))
    }

    /// Whether a log worth going on with stands at `path`; one that was cut before its key ended holds
    /// nothing.
    pub fn exists(path: &Path) -> bool {
        std::fs::metadata(path).is_ok_and(|m| m.len() >= KEY_BYTES as u64)
    }

    /// Whether a log with at least one piece that is whole stands at `path`.
    pub fn holds_pieces(path: &Path) -> bool {
        let first = || -> io::Result<bool> {
            let mut file = File::open(path)?;
            let mut start = [0; KEY_BYTES + RECORD_HEADER];
            file.read_exact(&mut start)?;
            let [.., a, b, c, d, _, _, _, _, _, _, _, _] = start;
            Ok(file.metadata()?.len() >= start.len() as u64 + u64::from(u32::from_le_bytes([a, b, c, d])))
        };
        path.is_file() && first().unwrap_or(false)
    }

    /// Pieces that are in the log, in order.
    pub fn finished(&self) -> Vec<u32> {
        self.lock().pieces.keys().copied().collect()
    }

    /// Whether all of so many `pieces` are in the log.
    pub fn has_all(&self, pieces: u32) -> bool {
        self.lock().pieces.range(..pieces).count() == pieces as usize
    }

    /// Appends a piece.
    pub fn append(&self, piece: u32, payload: &[u8]) -> Result<()> {
        let mut record = Vec::with_capacity(RECORD_HEADER + payload.len());
        record.extend(piece.to_le_bytes());
        record.extend((payload.len() as u32).to_le_bytes());
        let checksum = checksum(piece, payload);
        record.extend(checksum.to_le_bytes());
        record.extend(payload);
        let mut inner = self.lock();
        let end = inner.end;
        inner
            .file
            .seek(SeekFrom::Start(end))
            .and_then(|_| inner.file.write_all(&record))
            .map_err(|e| Error::output(&self.place, e))?;
        inner
            .pieces
            .insert(piece, Entry { at: end + RECORD_HEADER as u64, bytes: payload.len() as u32, checksum });
        inner.end = end + record.len() as u64;
        Ok(())
    }

    /// Reads a piece back.
    pub fn read(&self, piece: u32) -> Result<Vec<u8>> {
        let mut inner = self.lock();
        let damaged = || {
            Error::invalid(
                &self.place,
                format!("piece {piece} is missing or damaged; bake again with --force"),
            )
        };
        let Entry { at, bytes, checksum: expected } = *inner.pieces.get(&piece).ok_or_else(damaged)?;
        let mut payload = vec![0; bytes as usize];
        inner
            .file
            .seek(SeekFrom::Start(at))
            .and_then(|_| inner.file.read_exact(&mut payload))
            .map_err(|e| Error::output(&self.place, e))?;
        if checksum(piece, &payload) != expected {
            return Err(damaged());
        }
        Ok(payload)
    }

    /// An error about the content of the log.
    pub fn refuse(&self, reason: &str) -> Error {
        Error::invalid(&self.place, reason)
    }

    /// A poisoned lock means that another thread panicked between two writes of `Inner`, whose record is then
    /// simply not listed.
    fn lock(&self) -> std::sync::MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

fn checksum(piece: u32, payload: &[u8]) -> u64 {
    let mut hash = Xxh3::new();
    hash.update(&piece.to_le_bytes());
    hash.update(&(payload.len() as u32).to_le_bytes());
    hash.update(payload);
    hash.digest()
}

type Found = (BTreeMap<u32, Entry>, u64);

/// Lists the whole records of a log and where they end; `None` if the key differs.
fn scan(file: &mut File, key: u128) -> io::Result<Option<Found>> {
    let length = file.metadata()?.len();
    let mut input = io::BufReader::new(file);
    let mut found_key = [0; KEY_BYTES];
    if input.read_exact(&mut found_key).is_err() || found_key != key.to_le_bytes() {
        return Ok(None);
    }
    let (mut pieces, mut end) = (BTreeMap::new(), KEY_BYTES as u64);
    let mut header = [0; RECORD_HEADER];
    while input.read_exact(&mut header).is_ok() {
        let [a, b, c, d, e, f, g, h, sum @ ..] = header;
        let (piece, bytes) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
        let next = end + RECORD_HEADER as u64 + u64::from(bytes);
        if next > length {
            break;
        }
        let mut payload = vec![0; bytes as usize];
        input.read_exact(&mut payload)?;
        if checksum(piece, &payload) != u64::from_le_bytes(sum) {
            break;
        }
        pieces.insert(
            piece,
            Entry { at: end + RECORD_HEADER as u64, bytes, checksum: u64::from_le_bytes(sum) },
        );
        end = next;
    }
    Ok(Some((pieces, end)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(seed: u32) -> Vec<u8> {
        (0..seed * 5).map(|i| (i * 7 + seed) as u8).collect()
    }

    #[test]
    fn cut_anywhere_it_keeps_the_whole_records_and_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        let log = WorkLog::create(&path, 42).unwrap();
        for id in [5, 1, 9] {
            log.append(id, &piece(id)).unwrap();
        }
        drop(log);
        let whole = std::fs::read(&path).unwrap();
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert_eq!(
                WorkLog::holds_pieces(&path),
                length >= KEY_BYTES + RECORD_HEADER + piece(5).len(),
                "{length}"
            );
            let Some(log) = WorkLog::reopen(&path, 42).unwrap() else {
                assert!(length < KEY_BYTES);
                continue;
            };
            for id in log.finished() {
                assert_eq!(log.read(id).unwrap(), piece(id));
            }
            log.append(7, &piece(7)).unwrap();
            drop(log);
            let log = WorkLog::reopen(&path, 42).unwrap().unwrap();
            assert_eq!(log.read(7).unwrap(), piece(7), "cut at {length}");
        }
        assert!(WorkLog::reopen(&path, 43).unwrap().is_none(), "another bake's log");
    }
}
