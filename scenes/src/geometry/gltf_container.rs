//! From the bytes of a glTF file, text or binary, to its JSON and its binary chunk. What other programs get
//! slightly wrong around these is mended.

use relume_formats::{Error, Place, Result};

/// The JSON and the binary chunk.
pub(super) struct Chunks<'a> {
    pub json: &'a [u8],
    pub binary: Option<&'a [u8]>,
}

/// Finds the chunks of `bytes`.
pub(super) fn split<'a>(bytes: &'a [u8], place: &Place) -> Result<Chunks<'a>> {
    let Chunks { json, binary } = if bytes.starts_with(b"glTF") {
        split_binary(bytes, place)?
    } else {
        Chunks { json: bytes, binary: None }
    };
    if json.starts_with(&[0xFF, 0xFE]) || json.starts_with(&[0xFE, 0xFF]) {
        return Err(Error::invalid(place, "is UTF-16 text, but glTF is UTF-8; save it as UTF-8"));
    }
    let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    // Chunks are padded with blanks, but some programs write zeros.
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    Ok(Chunks { json: json.get(..end).unwrap_or_default(), binary })
}

fn split_binary<'a>(bytes: &'a [u8], place: &Place) -> Result<Chunks<'a>> {
    let refuse = |reason: String| {
        Error::invalid(place, format!("not a whole binary glTF 2.0 file ({reason}); export or copy it again"))
    };
    let word = |at: usize| little_endian(bytes, at).ok_or_else(|| refuse("its header is cut off".to_owned()));
    let (version, declared) = (word(4)?, word(8)? as usize);
    if version != 2 {
        return Err(Error::unsupported(
            place,
            format!("is binary glTF of version {version}, only 2 is read; convert it to glTF 2.0"),
        ));
    }
    if declared < 20 || declared > bytes.len() {
        return Err(refuse(format!("it declares {declared} bytes and has {}", bytes.len())));
    }
    // What comes after the declared end is not part of the file.
    let bytes = bytes.get(..declared).unwrap_or_default();
    let (kind, json, mut end) =
        chunk(bytes, 12).ok_or_else(|| refuse("its first chunk is cut off".to_owned()))?;
    if kind != *b"JSON" {
        return Err(refuse("its first chunk is not JSON".to_owned()));
    }
    while let Some(start) = next_chunk(bytes, end) {
        let (kind, content, after) =
            chunk(bytes, start).ok_or_else(|| refuse("a chunk is cut off".to_owned()))?;
        if kind == BINARY {
            return Ok(Chunks { json, binary: Some(content) });
        }
        end = after;
    }
    Ok(Chunks { json, binary: None })
}

const BINARY: [u8; 4] = *b"BIN\0";

/// The kind and content of the chunk at `start`, and where it ends.
fn chunk(bytes: &[u8], start: usize) -> Option<([u8; 4], &[u8], usize)> {
    let length = little_endian(bytes, start)? as usize;
    let kind = bytes.get(start + 4..start + 8)?.try_into().ok()?;
    let end = start.checked_add(8)?.checked_add(length)?;
    Some((kind, bytes.get(start + 8..end)?, end))
}

/// Where the chunk after `end` starts, if there is one. Lengths are multiples of four; where one is not, it
/// may leave out its padding or not.
fn next_chunk(bytes: &[u8], end: usize) -> Option<usize> {
    let padded = end.next_multiple_of(4);
    let is_binary = |start: &usize| bytes.get(start + 4..start + 8) == Some(BINARY.as_slice());
    let start = [end, padded].into_iter().find(is_binary).unwrap_or(padded);
    (start + 8 <= bytes.len()).then_some(start)
}

fn little_endian(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(&[u8], &[u8], usize)], declared: Option<u32>) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, content, padding) in chunks {
            body.extend((content.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*content);
            body.resize(body.len() + padding, 0);
        }
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(declared.unwrap_or(12 + body.len() as u32).to_le_bytes());
        bytes.extend(body);
        bytes
    }

    fn split_of(bytes: &[u8]) -> std::result::Result<(Vec<u8>, Option<Vec<u8>>), String> {
        let chunks = split(bytes, &Place::file("t.glb")).map_err(|e| e.to_string())?;
        Ok((chunks.json.to_vec(), chunks.binary.map(<[u8]>::to_vec)))
    }

    #[test]
    fn chunks_are_found_however_they_are_padded() {
        let (json, bin) = (b"{}".as_slice(), b"\x01\x02\x03".as_slice());
        let whole = Ok((json.to_vec(), Some(bin.to_vec())));
        assert_eq!(split_of(&glb(&[(b"JSON", b"{}\0\0", 0), (b"BIN\0", bin, 1)], None)), whole);
        assert_eq!(split_of(&glb(&[(b"JSON", json, 2), (b"BIN\0", bin, 1)], None)), whole);
        assert_eq!(split_of(&glb(&[(b"JSON", json, 0), (b"BIN\0", bin, 0)], None)), whole);
        assert_eq!(
            split_of(&glb(
                &[(b"JSON", b"\xEF\xBB\xBF{}\0\0\0", 0), (b"XTRA", b"abcd", 0), (b"BIN\0", bin, 0)],
                None
            )),
            whole
        );
        let mut trailing = glb(&[(b"JSON", b"{}  ", 0)], None);
        trailing.extend([7; 9]);
        assert_eq!(split_of(&trailing), Ok((b"{}  ".to_vec(), None)));
        assert_eq!(split_of(b"\xEF\xBB\xBF{}\0\0"), Ok((json.to_vec(), None)));
    }

    #[test]
    fn broken_containers_are_refused_in_words() {
        let sound = glb(&[(b"JSON", b"{}  ", 0), (b"BIN\0", b"abcd", 0)], None);
        for (bytes, part) in [
            (b"glTF".to_vec(), "its header is cut off"),
            (b"glTF\x01\0\0\0\x20\0\0\0".to_vec(), "is binary glTF of version 1, only 2 is read"),
            (glb(&[(b"JSON", b"{}  ", 0)], Some(11)), "declares 11 bytes and has 24"),
            (glb(&[(b"JSON", b"{}  ", 0)], Some(25)), "declares 25 bytes and has 24"),
            (glb(&[(b"BIN\0", b"{}  ", 0)], None), "its first chunk is not JSON"),
            (sound[..sound.len() - 2].to_vec(), "it declares 36 bytes and has 34"),
            (b"\xFF\xFE{\0}\0".to_vec(), "is UTF-16 text"),
        ] {
            let message = split_of(&bytes).unwrap_err();
            assert!(message.starts_with("t.glb: ") && message.contains(part), "{message}");
        }
        let mut cut = glb(&[(b"JSON", b"{}  ", 0), (b"BIN\0", b"abcd", 0)], None);
        cut[24] = 5;
        assert!(split_of(&cut).unwrap_err().contains("a chunk is cut off"));
    }
}
