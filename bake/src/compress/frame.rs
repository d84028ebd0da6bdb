//! Pieces of a log, shrunk by zstd.

use relume_formats::container::codec;
use relume_formats::{Error, Place, Result};

/// `raw` as a frame.
///
/// # Errors
/// If zstd cannot work, for want of memory.
pub fn shrink(raw: &[u8]) -> Result<Vec<u8>> {
    codec::compress(raw).map_err(|e| Error::output(&Place::file("work log"), e))
}

/// What `frame` holds; `None` if that is more than `most` bytes, or it is no frame.
pub fn grow(frame: &[u8], most: usize) -> Option<Vec<u8>> {
    codec::decompress(frame, most).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_and_nothing_else_does() {
        let raw: Vec<u8> = (0..5000u32).map(|i| ((i * i) >> 7) as u8).collect();
        let frame = shrink(&raw).unwrap();
        assert!(frame.len() < raw.len());
        assert_eq!(grow(&frame, raw.len()).as_ref(), Some(&raw));
        let refused = [grow(&frame, raw.len() - 1), grow(&frame[..frame.len() - 1], 5000), grow(b"no", 9)];
        assert!(refused.iter().all(Option::is_none));
        assert_eq!(grow(&shrink(&[]).unwrap(), 0), Some(Vec::new()));
    }
}
