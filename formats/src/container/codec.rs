//! The compression of sections: zstd (RFC 8878), by the C library or by one in Rust alone.

use std::io;

/// What compresses and decompresses.
#[cfg(feature = "zstd")]
use by_c as chosen;
#[cfg(all(feature = "pure-rust-zstd", not(feature = "zstd")))]
use in_rust as chosen;
#[cfg(not(any(feature = "zstd", feature = "pure-rust-zstd")))]
compile_error!("relume-formats needs a decoder: the feature `zstd` or `pure-rust-zstd`");

pub use chosen::{compress, decompress};

/// A frame for each of `raw`.
#[cfg(feature = "fast")]
pub fn compress_all(raw: &[Vec<u8>]) -> Vec<io::Result<Vec<u8>>> {
    crate::fast::on_all_cores(raw, |raw| compress(raw))
}

/// A frame for each of `raw`.
#[cfg(not(feature = "fast"))]
pub fn compress_all(raw: &[Vec<u8>]) -> Vec<io::Result<Vec<u8>>> {
    raw.iter().map(|raw| compress(raw)).collect()
}

/// The most that zstd makes of `raw` bytes, whatever they are: `ZSTD_COMPRESSBOUND` of zstd.h.
pub(super) fn most_stored_bytes(raw: u64) -> u64 {
    const BLOCK: u64 = 128 << 10;
    raw + (raw >> 8) + (BLOCK.saturating_sub(raw) >> 11)
}

/// libzstd.
#[cfg(feature = "zstd")]
mod by_c {
    use super::io;

    /// High enough to pay on smooth data, low enough that compressing is never the slow part of a bake.
    const LEVEL: i32 = 9;

    /// A frame that holds `raw`.
    pub fn compress(raw: &[u8]) -> io::Result<Vec<u8>> {
        zstd::bulk::compress(raw, LEVEL)
    }

    /// What the frame `stored` holds, at most `most` bytes.
    pub fn decompress(stored: &[u8], most: usize) -> io::Result<Vec<u8>> {
        zstd::bulk::decompress(stored, most)
    }
}

/// ruzstd.
#[cfg(any(all(feature = "pure-rust-zstd", not(feature = "zstd")), test))]
mod in_rust {
    use super::io;
    use crate::container::MAX_SECTION_BYTES;
    use ruzstd::decoding::FrameDecoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    /// A frame that holds `raw`, larger than one of libzstd.
    #[cfg_attr(feature = "zstd", allow(dead_code, reason = "only its decoder is tested against libzstd"))]
    pub fn compress(raw: &[u8]) -> io::Result<Vec<u8>> {
        Ok(compress_to_vec(raw, CompressionLevel::Fastest))
    }

    /// What the frame `stored` holds, at most `most` bytes.
    pub fn decompress(stored: &[u8], most: usize) -> io::Result<Vec<u8>> {
        let mut decoder = FrameDecoder::new();
        // A frame may look back over all of a section.
        decoder.set_max_window_size(MAX_SECTION_BYTES);
        let mut raw = vec![0; most];
        let length = decoder.decode_all(stored, &mut raw).map_err(io::Error::other)?;
        raw.truncate(length);
        Ok(raw)
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::{by_c, in_rust, most_stored_bytes};
    use zstd::zstd_safe::CParameter;

    /// Noise, runs, text-like repetitions at many distances, and smooth numbers: what every kind of block and
    /// of table is made of.
    fn samples() -> Vec<Vec<u8>> {
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 56) as u8
        };
        let mut samples = Vec::new();
        for length in
            [0, 1, 2, 31, 255, 256, 1000, 65_535, (128 << 10) - 1, 128 << 10, (128 << 10) + 1, 700_001]
        {
            samples.push(vec![7; length]);
            samples.push((0..length).map(|_| noise()).collect());
            samples.push((0..length).map(|_| noise() & noise() & noise()).collect());
            samples.push((0..length).flat_map(|i| (i as f32 * 1e-3).sin().to_le_bytes()).collect());
            let words: Vec<Vec<u8>> = (1..40).map(|n| (0..n).map(|_| noise()).collect()).collect();
            samples.push(
                (0..length / 20).flat_map(|_| words[usize::from(noise()) % words.len()].clone()).collect(),
            );
        }
        samples
    }

    #[test]
    fn both_decoders_give_the_same_bytes() {
        for raw in samples() {
            for level in [-5, 1, 3, 9, 19] {
                let stored = zstd::bulk::compress(&raw, level).unwrap();
                assert!(
                    by_c::decompress(&stored, raw.len()).unwrap() == raw,
                    "{} bytes, level {level}",
                    raw.len()
                );
                assert!(
                    in_rust::decompress(&stored, raw.len()).unwrap() == raw,
                    "{} bytes, level {level}",
                    raw.len()
                );
            }
            let stored = in_rust::compress(&raw).unwrap();
            assert!(
                by_c::decompress(&stored, raw.len()).unwrap() == raw
                    && stored.len() as u64 <= most_stored_bytes(raw.len() as u64)
            );
        }
    }

    #[test]
    fn a_frame_may_look_back_over_a_whole_section() {
        // Half of it noise, the other half the same again: the largest distance there can be.
        let mut state = 9u64;
        let mut noise = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            state
        };
        let half: Vec<u8> = (0..(64 << 20) / 8).flat_map(|_| noise().to_le_bytes()).collect();
        let raw = [half.clone(), half].concat();
        let mut far_seeing = zstd::bulk::Compressor::new(1).unwrap();
        far_seeing.set_parameter(CParameter::WindowLog(27)).unwrap();
        far_seeing.set_parameter(CParameter::EnableLongDistanceMatching(true)).unwrap();
        let stored = far_seeing.compress(&raw).unwrap();
        assert!(stored.len() < raw.len() * 3 / 5, "the other half was found: {}", stored.len());
        assert!(in_rust::decompress(&stored, raw.len()).unwrap() == raw);
    }

    #[test]
    fn both_decoders_refuse_the_same_damage() {
        let raw: Vec<u8> = (0..5000u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        let stored = by_c::compress(&raw).unwrap();
        for decompress in [by_c::decompress, in_rust::decompress] {
            assert!(decompress(&stored, raw.len() - 1).is_err(), "more than there is room for");
            assert!(decompress(&stored[..stored.len() - 3], raw.len()).is_err(), "cut short");
            assert!(decompress(b"no zstd", raw.len()).is_err());
        }
        for at in 0..stored.len() {
            let mut damaged = stored.clone();
            damaged[at] ^= 0x41;
            // What is still a frame is found by the checksums of sections; no decoder may panic, or give more
            // than there is room for.
            if let Ok(found) = in_rust::decompress(&damaged, raw.len()) {
                assert!(found.len() <= raw.len());
            }
        }
    }

    #[test]
    fn the_bound_is_that_of_libzstd() {
        for raw in [0, 1, 255, 256, 1 << 10, (128 << 10) - 1, 128 << 10, (128 << 10) + 1, 128 << 20] {
            assert_eq!(most_stored_bytes(raw), zstd::zstd_safe::compress_bound(raw as usize) as u64, "{raw}");
        }
    }
}
