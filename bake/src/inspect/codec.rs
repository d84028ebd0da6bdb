//! What codecs are called.

use relume_formats::container::Codec;

/// The name of a codec in messages and JSON.
pub(super) fn codec_name(codec: Codec) -> &'static str {
    match codec {
        Codec::Zstd => "zstd",
        Codec::ZstdPlanes => "zstd-planes",
    }
}
