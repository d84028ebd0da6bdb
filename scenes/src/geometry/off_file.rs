//! Object File Format of Geomview, as text: OFF, and NOFF with normals, each also with colours (COFF, CNOFF), which are ignored.

use super::polygons::Triangulation;
use super::{MAX_ELEMENTS, MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use relume_formats::{Error, Place, Result};
use std::path::Path;
use std::str::{FromStr, SplitAsciiWhitespace};

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    let text = std::str::from_utf8(&bytes).map_err(|_| Error::unsupported(&place, "not text; save it as ASCII OFF"))?;
    let mut lines = Lines { lines: text.lines().enumerate(), line: 0, place: &place };
    let (has_normals, counts) = header(&mut lines)?;
    let counts = counts.map_or_else(|| lines.next("the numbers of vertices, faces and edges"), Ok)?;
    let [vertices, faces] = counts_of(counts, &lines)?;
    builder.expect_room(vertices, faces, &place)?;
    let (part, note) = body(&mut lines, vertices, faces, has_normals)?;
    builder.notes.extend(note);
    builder.append(&part, world_from_file, &place)
}

/// Lines with something on them, without comments.
struct Lines<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    line: usize,
    place: &'a Place,
}

impl<'a> Lines<'a> {
    /// The words of the next line; `what` is expected there.
    fn next(&mut self, what: &str) -> Result<SplitAsciiWhitespace<'a>> {
        for (index, line) in self.lines.by_ref() {
            self.line = index + 1;
            let line = line.split('#').next().unwrap_or_default();
            if !line.trim_ascii().is_empty() {
                return Ok(line.split_ascii_whitespace());
            }
        }
        Err(Error::invalid(self.place, format!("ends where {what} should be; fetch or export it again")))
    }

    fn refuse<T>(&self, reason: &str) -> Result<T> {
        Err(Error::invalid(&self.place.part(format!("line {}", self.line)), format!("{reason}; mend or export the file again")))
    }

    /// The next of `words` as a number.
    fn number<T: FromStr>(&self, words: &mut SplitAsciiWhitespace<'_>, what: &str) -> Result<T> {
        match words.next().map(str::parse) {
            Some(Ok(number)) => Ok(number),
            _ => self.refuse(&format!("{what} expected")),
        }
    }

    fn triple(&self, words: &mut SplitAsciiWhitespace<'_>, what: &str) -> Result<[f32; 3]> {
        Ok([self.number(words, what)?, self.number(words, what)?, self.number(words, what)?])
    }
}

/// Whether vertices have normals, and the rest of the keyword's line if it has more words.
fn header<'a>(lines: &mut Lines<'a>) -> Result<(bool, Option<SplitAsciiWhitespace<'a>>)> {
    let mut words = lines.next("the word OFF")?;
    let has_normals = match words.next() {
        Some("OFF" | "COFF") => false,
        Some("NOFF" | "CNOFF") => true,
        Some(word) if word.ends_with("OFF") => {
            let reason = format!("{word} is not read, OFF, COFF, NOFF and CNOFF are; save it as one of them");
            return Err(Error::unsupported(&lines.place.part(format!("line {}", lines.line)), reason));
        }
        _ => return lines.refuse("the word OFF expected"),
    };
    match words.clone().next() {
        Some("BINARY") => Err(Error::unsupported(lines.place, "binary OFF is not read; save it as ASCII OFF")),
        Some(_) => Ok((has_normals, Some(words))),
        None => Ok((has_normals, None)),
    }
}

fn counts_of(mut words: SplitAsciiWhitespace<'_>, lines: &Lines<'_>) -> Result<[usize; 2]> {
    Ok([lines.number(&mut words, "a number of vertices")?, lines.number(&mut words, "a number of faces")?])
}

/// Vertices and faces, a line each. Nothing is allocated ahead: the file itself, whose size is bounded, has to bring every line.
fn body(lines: &mut Lines<'_>, vertices: usize, faces: usize, has_normals: bool) -> Result<(Part, Option<String>)> {
    let (mut part, mut polygons) = (Part::default(), Triangulation::default());
    for index in 0..vertices {
        let mut words = lines.next(&format!("vertex {index} of {vertices}"))?;
        part.positions.push(lines.triple(&mut words, "a coordinate")?);
        if has_normals {
            part.normals.push(lines.triple(&mut words, "a component of a normal")?);
        }
    }
    let mut corners: Vec<u32> = Vec::new();
    for index in 0..faces {
        let mut words = lines.next(&format!("face {index} of {faces}"))?;
        let count: usize = lines.number(&mut words, "a number of corners")?;
        corners.clear();
        for _ in 0..count {
            corners.push(lines.number(&mut words, "a vertex index")?);
        }
        polygons.add(&corners);
        if polygons.triangles.len() > MAX_ELEMENTS {
            return lines.refuse(&format!("more than {MAX_ELEMENTS} triangles"));
        }
    }
    let note = polygons.note();
    part.triangles = polygons.triangles;
    Ok((part, note))
}
