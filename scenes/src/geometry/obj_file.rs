//! Wavefront OBJ: vertices, texture coordinates, normals, polygons and smoothing groups. All objects and
//! groups of a file are one mesh; names, materials and colours are passed over in silence, as the scene gives
//! materials; lines, points and free-form surfaces with a note.
//!
//! We read it ourselves: the libraries give up corners of their own for what one corner lacks, and take
//! polylines for polygons.

use super::normals::Smoothing;
use super::polygons::Polygons;
use super::text::{Lines, number, quoted, unmarked, without_comment, words};
use super::{MAX_ELEMENTS, MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use relume_formats::counts::counted;
use relume_formats::{Error, Place, Result};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// An index that a corner does not give.
const NONE: u32 = u32::MAX;
const TOO_MANY: &str = "more vertices or triangles than one object may have";
/// What the indices of a corner are of.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    let mut file = ObjFile::default();
    for (line, statement) in (Statements { lines: Lines::new(unmarked(&bytes, &place)?) }) {
        file.read(&statement, line).map_err(|reason| refusal(&place, line, &reason))?;
    }
    builder.notes.extend(file.notes());
    let part = file.into_part(builder, &place)?;
    builder.append(&part, world_from_file, &place)
}

fn refusal(place: &Place, line: usize, reason: &str) -> Error {
    Error::invalid(&place.part(format!("line {line}")), format!("{reason}; mend or export the file again"))
}

/// Lines without comments, joined where a backslash ends them, with the number of the first.
struct Statements<'a> {
    lines: Lines<'a>,
}

impl<'a> Iterator for Statements<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let (number, line) = self.lines.next()?;
        let line = without_comment(line);
        let Some(mut open) = line.trim_ascii_end().strip_suffix(b"\\") else {
            return Some((number, Cow::Borrowed(line)));
        };
        let mut joined = Vec::new();
        loop {
            joined.extend_from_slice(open);
            joined.push(b' ');
            let line = self.lines.next().map_or(&[][..], |(_, line)| without_comment(line));
            match line.trim_ascii_end().strip_suffix(b"\\") {
                Some(more) => open = more,
                None => {
                    joined.extend_from_slice(line);
                    return Some((number, Cow::Owned(joined)));
                }
            }
        }
    }
}

/// A polygon: where its corners end among all, its line in the file, and how it is shaded.
struct Face {
    end: u32,
    line: u32,
    smoothing: Smoothing,
}

/// What a file holds.
#[derive(Default)]
struct ObjFile {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// For each corner its position, texture coordinate and normal, or [`NONE`].
    corners: Vec<[u32; 3]>,
    faces: Vec<Face>,
    /// Of the faces that follow.
    smoothing: Smoothing,
    /// Statements of lines, and of points.
    ignored: [usize; 2],
    /// Statements that are not known, and the line of the first.
    unknown: (usize, usize),
}

impl ObjFile {
    /// Takes a statement in.
    fn read(&mut self, statement: &[u8], line: usize) -> std::result::Result<(), String> {
        let mut words = words(statement);
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            // Weights and colours may follow.
            b"v" => self.positions.push(numbers(&mut words, 3, "coordinate of a vertex")?),
            b"vn" => self.normals.push(numbers(&mut words, 3, "component of a normal")?),
            b"vt" => {
                let [u, v] = numbers(&mut words, 1, "texture coordinate")?;
                // OBJ's v goes up from the image's last row.
                self.uvs.push([u, 1.0 - v]);
            }
            b"f" | b"fo" => self.read_face(words, line)?,
            b"s" => self.smoothing = words.next().map_or(self.smoothing, smoothing_of),
            b"l" => self.ignored[0] += 1,
            b"p" => self.ignored[1] += 1,
            b"g" | b"o" | b"usemtl" | b"mtllib" | b"usemap" | b"maplib" | b"mg" | b"lod" | b"bevel"
            | b"c_interp" | b"d_interp" | b"shadow_obj" | b"trace_obj" | b"vp" => {}
            _ => {
                self.unknown.0 += 1;
                self.unknown.1 = if self.unknown.0 == 1 { line } else { self.unknown.1 };
            }
        }
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len(), self.faces.len()];
        if counts.into_iter().any(|count| count > MAX_ELEMENTS) { Err(TOO_MANY.to_owned()) } else { Ok(()) }
    }

    fn read_face<'w>(
        &mut self,
        words: impl Iterator<Item = &'w [u8]>,
        line: usize,
    ) -> std::result::Result<(), String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for word in words {
            let mut corner = [NONE; 3];
            let mut parts = word.split(|b| *b == b'/');
            for (kind, slot) in corner.iter_mut().enumerate() {
                match parts.next() {
                    None | Some(b"") if kind > 0 => {}
                    text => *slot = index(text.unwrap_or_default(), counts[kind], KINDS[kind])?,
                }
            }
            if parts.next().is_some() {
                return Err(format!(
                    "{} is no corner of a face, which has at most three numbers",
                    quoted(word)
                ));
            }
            self.corners.push(corner);
            if self.corners.len() > 3 * MAX_ELEMENTS {
                return Err(TOO_MANY.to_owned());
            }
        }
        self.faces.push(Face {
            end: self.corners.len() as u32,
            line: line as u32,
            smoothing: self.smoothing,
        });
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        let [lines, points] = self.ignored;
        let (unknown, first) = self.unknown;
        [
            (lines, format!("ignored {}, without a surface", counted(lines, "line", "lines"))),
            (
                points,
                format!(
                    "ignored {} of points, without a surface",
                    counted(points, "statement", "statements")
                ),
            ),
            (
                unknown,
                format!(
                    "ignored {} not read, such as free-form surfaces; the first is line {first}",
                    counted(unknown, "statement", "statements")
                ),
            ),
            (
                self.strays(),
                format!(
                    "{} texture coordinates or normals of which the file has none; read without them",
                    if self.strays() == 1 {
                        "1 corner of a face names".to_owned()
                    } else {
                        format!("{} corners of faces name", self.strays())
                    }
                ),
            ),
        ]
        .into_iter()
        .filter_map(|(count, note)| (count > 0).then_some(note))
        .collect()
    }

    /// Which of positions, texture coordinates and normals the file has none of, though corners may name
    /// some.
    fn absent(&self) -> [bool; 3] {
        [false, self.uvs.is_empty(), self.normals.is_empty()]
    }

    /// How many corners name what the file has none of at all. A number that is out of range among others is
    /// another thing, and a fault.
    fn strays(&self) -> usize {
        let absent = self.absent();
        self.corners
            .iter()
            .filter(|corner| corner.iter().zip(absent).any(|(index, absent)| absent && *index != NONE))
            .count()
    }

    /// The mesh, with one vertex for each set of indices that corners name, in the order of their first use.
    fn into_part(mut self, builder: &mut MeshBuilder, place: &Place) -> Result<Part> {
        let (mut part, mut polygons) = (Part::default(), Polygons::default());
        let absent = self.absent();
        for corner in &mut self.corners {
            *corner = std::array::from_fn(|kind| if absent[kind] { NONE } else { corner[kind] });
        }
        let (mut known, mut start) = (HashMap::new(), 0);
        for face in &self.faces {
            let corners = &self.corners[start..face.end as usize];
            start = face.end as usize;
            corners
                .iter()
                .try_for_each(|corner| self.check(corner))
                .map_err(|reason| refusal(place, face.line as usize, &reason))?;
            let vertices: Vec<u32> = corners
                .iter()
                .map(|corner| *known.entry(*corner).or_insert_with(|| self.push_vertex(*corner, &mut part)))
                .collect();
            polygons.add(vertices, face.smoothing, place)?;
        }
        if part.without_uv == part.positions.len() {
            (part.uvs, part.without_uv) = (Vec::new(), 0);
        }
        let triangulation = polygons.triangulate(&part.positions);
        builder.notes.extend(triangulation.notes());
        (part.triangles, part.smoothing) = (triangulation.triangles, triangulation.smoothing);
        Ok(part)
    }

    /// Indices that count from the front may name what comes later, so that they are checked in the end.
    fn check(&self, corner: &[u32; 3]) -> std::result::Result<(), String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for ((index, count), kind) in corner.iter().zip(counts).zip(KINDS) {
            if *index != NONE && *index as usize >= count {
                return Err(format!("names {kind} {}, of {count}", u64::from(*index) + 1));
            }
        }
        match self.positions.get(corner[0] as usize) {
            Some(at) if !at.iter().all(|x| x.is_finite()) => {
                Err(format!("names vertex {} at {at:?}, which is not finite", corner[0] + 1))
            }
            _ => Ok(()),
        }
    }

    fn push_vertex(&self, [position, uv, normal]: [u32; 3], part: &mut Part) -> u32 {
        part.positions.extend(self.positions.get(position as usize));
        part.normals.push(self.normals.get(normal as usize).copied().unwrap_or_default());
        let uv = self.uvs.get(uv as usize);
        part.without_uv += usize::from(uv.is_none());
        part.uvs.push(uv.copied().unwrap_or_default());
        part.positions.len() as u32 - 1
    }
}

/// The first numbers of a statement, at least `least`; 0 where the others are missing.
fn numbers<'w, const N: usize>(
    words: &mut impl Iterator<Item = &'w [u8]>,
    least: usize,
    what: &str,
) -> std::result::Result<[f32; N], String> {
    let mut values = [0.0; N];
    for (index, value) in values.iter_mut().enumerate() {
        match words.next() {
            Some(word) => {
                *value = number(word).ok_or_else(|| format!("{} is no {what}", quoted(word)))? as f32
            }
            None if index >= least => break,
            None => return Err(format!("a {what} is missing")),
        }
    }
    Ok(values)
}

/// Indices count from 1, or back from what was last.
fn index(text: &[u8], count: usize, kind: &str) -> std::result::Result<u32, String> {
    let value = std::str::from_utf8(text).ok().and_then(|text| text.parse::<i64>().ok());
    match value {
        None => Err(format!("{} is no number of a {kind}", quoted(text))),
        Some(0) => Err(format!("names {kind} 0, but they count from 1")),
        Some(value @ 1..) => Ok(u32::try_from(value - 1).unwrap_or(NONE - 1)),
        // What comes before may be none at all, which is seen in the end.
        Some(_) if count == 0 && kind != KINDS[0] => Ok(NONE - 1),
        Some(back) => usize::try_from(back + count as i64)
            .map(|index| index as u32)
            .map_err(|_| format!("names {kind} {back}, but only {count} come before")),
    }
}

/// `s 0` and `s off` turn smoothing off.
fn smoothing_of(word: &[u8]) -> Smoothing {
    match std::str::from_utf8(word).unwrap_or_default() {
        "off" | "0" => Smoothing::Flat,
        "on" => Smoothing::Group(1),
        group => group.parse().map_or(Smoothing::ByAngle, Smoothing::Group),
    }
}
