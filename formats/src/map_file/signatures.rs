//! What a file is that is not what its name says, by its first bytes.

/// How many bytes are looked at.
pub(super) const LENGTH: usize = 64;

const SIGNATURES: [(&[u8], &str); 14] = [
    (&[0x76, 0x2f, 0x31, 0x01], "an OpenEXR picture; end its name in .exr"),
    (b"#?R", "a Radiance picture; end its name in .hdr"),
    (b"\x89PNG", "a PNG picture, which has no range for light; convert the picture that it was made from"),
    (
        &[0xff, 0xd8, 0xff],
        "a JPEG picture, which has no range for light; convert the picture that it was made from",
    ),
    (b"GIF8", "a GIF picture, which has no range for light; convert the picture that it was made from"),
    (b"II*\0", "a TIFF picture; convert it to .exr"),
    (b"MM\0*", "a TIFF picture; convert it to .exr"),
    (b"PF\n", "a portable float map; convert it to .exr"),
    (b"DDS ", "a DDS texture; convert it to .exr"),
    (&[0xab, b'K', b'T', b'X'], "a KTX texture; convert it to .exr"),
    (b"PK\x03\x04", "a ZIP archive; unpack it"),
    (&[0x1f, 0x8b], "a gzip archive; unpack it"),
    (b"version https://git-lfs", "a Git LFS pointer; fetch the file by `git lfs pull`"),
    (b"<", "a web page; download the file itself"),
];

/// What a file that begins with `start` seems to be, and the remedy.
pub(super) fn seems(start: &[u8]) -> &'static str {
    let text = start.trim_ascii_start();
    match SIGNATURES.iter().find(|(signature, _)| start.starts_with(signature) || text.starts_with(signature))
    {
        Some((_, what)) => what,
        None if start.is_empty() => "empty; fetch or save it again",
        None if start.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace()) => {
            "a text; save the picture again"
        }
        None => "of no kind that is known here; save the picture again",
    }
}
