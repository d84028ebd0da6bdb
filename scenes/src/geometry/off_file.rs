//! Object File Format of Geomview, as text: OFF, and NOFF with normals, each also with colours (COFF, CNOFF), which are ignored.

use super::normals::Smoothing;
use super::polygons::Polygons;
use super::text::{Lines, number, quoted, unmarked, without_comment, words};
use super::{MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    let mut lines = Source { lines: Lines::new(unmarked(&bytes, &place)?), words: Vec::new(), line: 0, place: &place };
    let has_normals = lines.header()?;
    let [vertices, faces] = [lines.count("vertices")?, lines.count("faces")?];
    builder.expect_room(vertices, faces, &place)?;
    let (mut part, polygons) = lines.body(vertices, faces, has_normals)?;
    let triangulation = polygons.triangulate(&part.positions);
    builder.notes.extend(triangulation.notes());
    part.triangles = triangulation.triangles;
    builder.append(&part, world_from_file, &place)
}

/// The words of one line after the other, from the last to the first; lines without any are passed over.
struct Source<'a> {
    lines: Lines<'a>,
    words: Vec<&'a [u8]>,
    line: usize,
    place: &'a Place,
}

impl<'a> Source<'a> {
    /// Goes to the next line; `what` is expected there.
    fn next_line(&mut self, what: impl FnOnce() -> String) -> Result<()> {
        for (number, line) in self.lines.by_ref() {
            self.line = number;
            self.words.clear();
            self.words.extend(words(without_comment(line)));
            self.words.reverse();
            if !self.words.is_empty() {
                return Ok(());
            }
        }
        Err(Error::invalid(self.place, format!("ends where {} should be; fetch or export it again", what())))
    }

    fn here(&self) -> Place {
        self.place.part(format!("line {}", self.line))
    }

    fn refuse<T>(&self, reason: &str) -> Result<T> {
        Err(Error::invalid(&self.here(), format!("{reason}; mend or export the file again")))
    }

    /// The next word of the line as a number.
    fn number(&mut self, what: &str) -> Result<f64> {
        let Some(word) = self.words.pop() else { return self.refuse(&format!("{what} is missing")) };
        number(word).map_or_else(|| self.refuse(&format!("{what} expected, not {}", quoted(word))), Ok)
    }

    fn triple(&mut self, what: &str) -> Result<[f32; 3]> {
        Ok([self.number(what)? as f32, self.number(what)? as f32, self.number(what)? as f32])
    }

    /// Whether vertices have normals. The keyword may be missing, as Geomview allows, and the counts follow on its line or the next.
    fn header(&mut self) -> Result<bool> {
        self.next_line(|| "the word OFF".to_owned())?;
        let keyword = *self.words.last().unwrap_or(&b"".as_slice());
        let has_normals = match keyword {
            b"OFF" | b"COFF" => false,
            b"NOFF" | b"CNOFF" => true,
            _ if keyword.ends_with(b"OFF") => {
                let reason = format!("{} is not read, OFF, COFF, NOFF and CNOFF are; save it as one of them", quoted(keyword));
                return Err(Error::unsupported(&self.here(), reason));
            }
            _ if number(keyword).is_some() => return Ok(false),
            _ => return self.refuse(&format!("the word OFF expected, not {}", quoted(keyword))),
        };
        self.words.pop();
        match self.words.last().copied() {
            Some(b"BINARY") => Err(Error::unsupported(self.place, "binary OFF is not read; save it as ASCII OFF")),
            Some(_) => Ok(has_normals),
            None => self.next_line(|| "the numbers of vertices, faces and edges".to_owned()).map(|()| has_normals),
        }
    }

    fn count(&mut self, what: &str) -> Result<usize> {
        match self.number(&format!("the number of {what}"))? {
            count if count >= 0.0 && count.fract() == 0.0 => Ok(count as usize),
            count => self.refuse(&format!("{count} is no number of {what}")),
        }
    }

    /// Vertices and faces, a line each. Nothing is allocated ahead: the file itself, whose size is bounded, has to bring every line.
    fn body(&mut self, vertices: usize, faces: usize, has_normals: bool) -> Result<(Part, Polygons)> {
        let (mut part, mut polygons) = (Part::default(), Polygons::default());
        for index in 0..vertices {
            self.next_line(|| format!("vertex {index} of {vertices}"))?;
            part.positions.push(self.triple("a coordinate")?);
            if has_normals {
                part.normals.push(self.triple("a component of a normal")?);
            }
        }
        let mut corners: Vec<u32> = Vec::new();
        for index in 0..faces {
            self.next_line(|| format!("face {index} of {faces}"))?;
            let count = self.count("corners")?;
            corners.clear();
            for _ in 0..count {
                match self.number("a vertex index")? {
                    vertex if vertex >= 0.0 && vertex.fract() == 0.0 && vertex < vertices as f64 => corners.push(vertex as u32),
                    vertex => return self.refuse(&format!("face {index} names vertex {vertex} of {vertices}, which count from 0")),
                }
            }
            polygons.add(corners.iter().copied(), Smoothing::ByAngle, self.place)?;
        }
        Ok((part, polygons))
    }
}
