//! PLY of Stanford, as text and binary of either byte order. Elements `vertex` and `face` are read, others and unknown properties skipped.

use super::polygons::Triangulation;
use super::{MAX_ELEMENTS, MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult};
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// The names that programs give to texture coordinates.
const UV_NAMES: [[&str; 2]; 4] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    let mut reader = Reader::new(bytes.as_slice());
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| parse_error(&e, &place))?;
    check_header(&header, &place)?;
    let (mut part, mut polygons) = (Part::default(), Triangulation::default());
    for element in header.elements.values() {
        let mut source = Source { reader: &mut reader, header: &header, element, place: &place };
        match element.name.as_str() {
            "vertex" => set_vertices(&mut part, &source.read()?, element),
            "face" => source.read::<Face>()?.iter().for_each(|face| polygons.add(&face.0)),
            _ => source.read::<Skipped>().map(drop)?,
        }
    }
    builder.notes.extend(polygons.note());
    part.triangles = polygons.triangles;
    builder.append(&part, world_from_file, &place)
}

/// Refuses what would keep the parser busy or fill the memory without a byte of the file behind it, and files without a mesh.
fn check_header(header: &Header, place: &Place) -> Result<()> {
    for element in header.elements.values() {
        if element.count > MAX_ELEMENTS {
            return Err(Error::invalid(
                place,
                format!("{} of `{}`, more than {MAX_ELEMENTS}; split or simplify it", element.count, element.name),
            ));
        }
    }
    let has = |name: &str, properties: &[&str]| {
        header.elements.get(name).is_some_and(|e| properties.iter().all(|property| e.properties.contains_key(*property)))
    };
    if !has("vertex", &["x", "y", "z"]) {
        return Err(Error::invalid(place, "has no element `vertex` with x, y and z; export it again"));
    }
    if !has("face", &["vertex_indices"]) && !has("face", &["vertex_index"]) {
        return Err(Error::invalid(place, "has no element `face` with a list `vertex_indices`; export it as a mesh"));
    }
    Ok(())
}

/// Where the parser is.
struct Source<'a, 'b> {
    reader: &'a mut Reader<&'b [u8]>,
    header: &'a Header,
    element: &'a ElementDef,
    place: &'a Place,
}

impl Source<'_, '_> {
    fn read<E: PropertyAccess>(&mut self) -> Result<Vec<E>> {
        let read = Parser::<E>::new().read_payload_for_element(self.reader, self.element, self.header);
        read.map_err(|e| parse_error(&e, self.place))
    }
}

/// The parser's messages run over many lines, quote the file and print their grammar: what goes wrong is on the first line and the last.
fn parse_error(error: &ParseError, place: &Place) -> Error {
    let message = error.to_string();
    let plain = |line: &str| line.split("Error: ParseError").next().unwrap_or_default().trim_matches([' ', '\t', '.']).to_owned();
    let first = message.lines().next().map(plain).unwrap_or_default();
    let last = message.lines().skip(1).last().map(plain).filter(|last| !last.is_empty());
    let last = last.map(|last| format!(": {last}")).unwrap_or_default();
    Error::invalid(place, format!("not a PLY file that can be read: {first}{last}; export it again"))
}

fn set_vertices(part: &mut Part, vertices: &[Vertex], element: &ElementDef) {
    let has = |names: &[&str]| names.iter().all(|name| element.properties.contains_key(*name));
    part.positions = vertices.iter().map(|v| v.position).collect();
    if has(&["nx", "ny", "nz"]) {
        part.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if UV_NAMES.iter().any(|names| has(names)) {
        // As in OBJ, v goes up from the image's last row.
        part.uvs = vertices.iter().map(|v| [v.uv[0], 1.0 - v.uv[1]]).collect();
    }
}

#[derive(Default)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            _ => match UV_NAMES.iter().find_map(|names| names.iter().position(|known| *known == name)) {
                Some(axis) => &mut self.uv[axis],
                None => return PropertyAccessResult::Ignored,
            },
        };
        let Some(value) = property.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        *target = value;
        PropertyAccessResult::Set
    }
}

/// Vertex indices around a polygon.
#[derive(Default)]
struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        let Some(corners) = property.to_u32_list() else { return PropertyAccessResult::UnsupportedType };
        self.0 = corners;
        PropertyAccessResult::Set
    }
}

/// An element that is passed over.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
