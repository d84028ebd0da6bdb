//! Object File Format of Geomview, as text: OFF, whose vertices may have normals (N), colours (C), which are
//! ignored, and texture coordinates (ST). Vertices have a line each, or flow over lines as they do in
//! Geomview; faces too, but where one has a colour it ends with its line.

use super::normals::Smoothing;
use super::polygons::Polygons;
use super::text::{Lines, number, quoted, unmarked, without_comment, words};
use super::{MAX_ELEMENTS, MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use relume_formats::counts::counted;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    let mut lines = Source {
        lines: Lines::new(unmarked(&bytes, &place)?),
        words: Vec::new(),
        line: 0,
        flows: false,
        place: &place,
    };
    let layout = lines.header()?;
    let [vertices, faces] = lines.counts()?;
    builder.expect_room(vertices, faces, &place)?;
    let (mut part, polygons) = lines.body(vertices, faces, &layout)?;
    let left = lines.word_counts().count();
    if left > 0 {
        builder.notes.push(format!("ignored {} after its last face", counted(left, "line", "lines")));
    }
    let triangulation = polygons.triangulate(&part.positions);
    builder.notes.extend(triangulation.notes());
    part.triangles = triangulation.triangles;
    builder.append(&part, world_from_file, &place)
}

/// What follows the position of a vertex, in this order.
#[derive(Default, PartialEq, Debug)]
struct Layout {
    normals: bool,
    colours: bool,
    uvs: bool,
}

impl Layout {
    /// What the letters before `OFF` say, each at most once; none if they say something else. Small letters
    /// have other meanings before a large `OFF`.
    fn called(prefix: &[u8]) -> Option<Self> {
        let (mut layout, mut rest) = (Self::default(), prefix);
        while !rest.is_empty() {
            let (flag, after) = match *rest {
                [b'N', ref after @ ..] => (&mut layout.normals, after),
                [b'C', ref after @ ..] => (&mut layout.colours, after),
                [b'S', b'T', ref after @ ..] => (&mut layout.uvs, after),
                _ => return None,
            };
            if std::mem::replace(flag, true) {
                return None;
            }
            rest = after;
        }
        Some(layout)
    }

    /// Numbers of a vertex whose colour has so many.
    fn numbers(&self, of_colour: usize) -> usize {
        3 + 3 * usize::from(self.normals) + of_colour * usize::from(self.colours) + 2 * usize::from(self.uvs)
    }
}

/// How faces stand on lines.
#[derive(Clone, Copy, PartialEq)]
enum Faces {
    /// One on each; what follows its corners is its colour.
    OnLines,
    /// Each begins a line, and some go on over further ones.
    OverLines,
    /// One after the other, wherever lines end.
    Flowing,
}

/// The words of one line after the other, from the last to the first; lines without any are passed over.
struct Source<'a> {
    lines: Lines<'a>,
    words: Vec<&'a [u8]>,
    line: usize,
    /// Whether the words of further lines follow those of this one.
    flows: bool,
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

    /// The next word as a number.
    fn number(&mut self, what: &str) -> Result<f64> {
        if self.flows && self.words.is_empty() {
            self.next_line(|| what.to_owned())?;
        }
        let Some(word) = self.words.pop() else { return self.refuse(&format!("{what} is missing")) };
        number(word).map_or_else(|| self.refuse(&format!("{what} expected, not {}", quoted(word))), Ok)
    }

    fn triple(&mut self, what: &str) -> Result<[f32; 3]> {
        Ok([self.number(what)? as f32, self.number(what)? as f32, self.number(what)? as f32])
    }

    /// What vertices have. The keyword may be missing, as Geomview allows, and the counts follow on its line,
    /// even without a blank, or the next.
    fn header(&mut self) -> Result<Layout> {
        self.next_line(|| "the word OFF".to_owned())?;
        let word = *self.words.last().unwrap_or(&b"".as_slice());
        if number(word).is_some() {
            return Ok(Layout::default());
        }
        let Some((keyword, count)) = split_keyword(word) else {
            return self.refuse(&format!("the word OFF expected, not {}", quoted(word)));
        };
        let prefix = &keyword[..keyword.len() - 3];
        let is_small = !keyword.ends_with(b"OFF");
        let Some(layout) =
            Layout::called(&if is_small { prefix.to_ascii_uppercase() } else { prefix.to_vec() })
        else {
            let reason = format!(
                "{} is not read, OFF with N, C and ST before it is; save it as one of them",
                quoted(keyword)
            );
            return Err(Error::unsupported(&self.here(), reason));
        };
        self.words.pop();
        self.words.extend((!count.is_empty()).then_some(count));
        match self.words.last() {
            Some(word) if word.eq_ignore_ascii_case(b"BINARY") => {
                Err(Error::unsupported(self.place, "binary OFF is not read; save it as ASCII OFF"))
            }
            Some(_) => Ok(layout),
            None => self.next_line(|| "the numbers of vertices, faces and edges".to_owned()).map(|()| layout),
        }
    }

    /// The numbers of vertices and faces; that of edges is passed over.
    fn counts(&mut self) -> Result<[usize; 2]> {
        let vertices = self.count("vertices")?;
        self.continue_counts(2)?;
        let faces = self.count("faces")?;
        self.continue_counts(1)?;
        self.words.pop();
        Ok([vertices, faces])
    }

    /// Goes to the next line, if this one has no more words and that one has at most so many, fewer than any
    /// vertex.
    fn continue_counts(&mut self, at_most: usize) -> Result<()> {
        let next = self.word_counts().next();
        if self.words.is_empty() && next.is_some_and(|words| words <= at_most) {
            self.next_line(|| "the numbers of vertices, faces and edges".to_owned())?;
        }
        Ok(())
    }

    /// How many words each of the lines to come has.
    fn word_counts(&self) -> impl Iterator<Item = usize> + use<'a> {
        self.lines.clone().map(|(_, line)| words(without_comment(line)).count()).filter(|count| *count > 0)
    }

    /// Whether vertices do not have a line each, but end with a line if they are read one after the other,
    /// and faces follow.
    fn vertices_flow(&self, vertices: usize, faces: usize, layout: &Layout) -> bool {
        let mut lines = self.word_counts();
        let by_line = (0..vertices).all(|_| lines.next().is_some_and(|words| words >= layout.numbers(3)));
        if by_line && (0..faces).all(|_| lines.next().is_some()) {
            return false;
        }
        let mut lines = self.word_counts();
        let mut left = (vertices * layout.numbers(4)).checked_sub(self.words.len());
        while let Some(1..) = left {
            left = left.zip(lines.next()).and_then(|(left, words)| left.checked_sub(words));
        }
        left.is_some() && (0..faces).all(|_| lines.next().is_some())
    }

    /// The way in which the lines to come are exactly so many faces. If it is none, a line each: then the
    /// first that is broken is told.
    fn layout_of_faces(&self, faces: usize) -> Faces {
        if self.has_line_per_face(faces) {
            return Faces::OnLines;
        }
        let fits = |layout: &Faces| self.are_faces(faces, *layout);
        [Faces::OverLines, Faces::Flowing].into_iter().find(fits).unwrap_or(Faces::OnLines)
    }

    fn lines_of_words(&self) -> impl Iterator<Item = Vec<&'a [u8]>> + use<'a> {
        self.lines
            .clone()
            .map(|(_, line)| words(without_comment(line)).collect::<Vec<_>>())
            .filter(|words| !words.is_empty())
    }

    fn has_line_per_face(&self, faces: usize) -> bool {
        let mut lines = self.lines_of_words();
        (0..faces).all(|_| {
            lines
                .next()
                .is_some_and(|words| corners_of(words[0]).is_some_and(|corners| corners < words.len()))
        })
    }

    /// Whether the rest of the file is so many faces, to its last word.
    fn are_faces(&self, faces: usize, layout: Faces) -> bool {
        let mut lines = self.lines_of_words();
        let mut left: Vec<&[u8]> = Vec::new();
        let mut take = |left: &mut Vec<&'a [u8]>| {
            if left.is_empty() {
                left.extend(lines.next().unwrap_or_default().into_iter().rev());
            }
            left.pop()
        };
        for _ in 0..faces {
            let Some(corners) = take(&mut left).and_then(corners_of) else { return false };
            let is_long = left.len() < corners;
            if !(0..corners).all(|_| take(&mut left).is_some_and(|word| number(word).is_some())) {
                return false;
            }
            // A colour may follow corners that all stand on one line.
            if layout == Faces::OverLines && !is_long {
                left.clear();
            } else if layout == Faces::OverLines && !left.is_empty() {
                return false;
            }
        }
        take(&mut left).is_none()
    }

    fn count(&mut self, what: &str) -> Result<usize> {
        match self.number(&format!("the number of {what}"))? {
            count if count >= 0.0 && count.fract() == 0.0 => Ok(count as usize),
            count => self.refuse(&format!("{count} is no number of {what}")),
        }
    }

    /// Vertices and faces. Nothing is allocated ahead: the file itself, whose size is bounded, has to bring
    /// every line.
    fn body(&mut self, vertices: usize, faces: usize, layout: &Layout) -> Result<(Part, Polygons)> {
        let (mut part, mut polygons) = (Part::default(), Polygons::default());
        self.flows = self.vertices_flow(vertices, faces, layout);
        for index in 0..vertices {
            if !self.flows {
                self.next_line(|| format!("vertex {index} of {vertices}"))?;
            }
            self.vertex(&mut part, layout)?;
        }
        let layout = self.layout_of_faces(faces);
        self.flows = layout != Faces::OnLines;
        let mut corners: Vec<u32> = Vec::new();
        for index in 0..faces {
            if layout != Faces::Flowing || self.words.is_empty() {
                self.next_line(|| format!("face {index} of {faces}"))?;
            }
            let count = self.count("corners")?;
            corners.clear();
            for _ in 0..count {
                match self.number("a vertex index")? {
                    vertex if vertex >= 0.0 && vertex.fract() == 0.0 && vertex < vertices as f64 => {
                        corners.push(vertex as u32)
                    }
                    vertex => {
                        return self.refuse(&format!(
                            "face {index} names vertex {vertex} of {vertices}, which count from 0"
                        ));
                    }
                }
            }
            polygons.add(corners.iter().copied(), Smoothing::ByAngle, self.place)?;
        }
        Ok((part, polygons))
    }

    fn vertex(&mut self, part: &mut Part, layout: &Layout) -> Result<()> {
        part.positions.push(self.triple("a coordinate")?);
        if layout.normals {
            part.normals.push(self.triple("a component of a normal")?);
        }
        // Colours are of four numbers; on lines of their own they may be of three, or missing where nothing
        // follows them.
        if layout.colours && (self.flows || layout.uvs) {
            let numbers = if !self.flows && self.words.len() == 5 { 3 } else { 4 };
            (0..numbers).try_for_each(|_| self.number("a component of a colour").map(drop))?;
        }
        if layout.uvs {
            let [u, v] = [self.number("a texture coordinate")?, self.number("a texture coordinate")?];
            // As in OBJ, v goes up from the image's last row.
            part.uvs.push([u as f32, 1.0 - v as f32]);
        }
        Ok(())
    }
}

/// The number of corners with which a face begins.
fn corners_of(word: &[u8]) -> Option<usize> {
    number(word)
        .filter(|count| *count >= 0.0 && count.fract() == 0.0 && *count < MAX_ELEMENTS as f64)
        .map(|count| count as usize)
}

/// The keyword, which ends in `OFF` of any case, and the number that is written on to it, if any.
fn split_keyword(word: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = 3 + word.windows(3).position(|letters| letters.eq_ignore_ascii_case(b"OFF"))?;
    let (keyword, rest) = word.split_at(end);
    (rest.is_empty() || number(rest).is_some()).then_some((keyword, rest))
}
