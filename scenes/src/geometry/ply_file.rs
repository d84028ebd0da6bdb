//! PLY of Stanford, as text and binary of either byte order: the elements `vertex`, `face` and `tristrips`.
//! Others and unknown properties are passed over, whatever they hold.

use super::normals::Smoothing;
use super::ply_body::{Body, Record};
use super::ply_header::{self, Element, Encoding, Header};
use super::polygons::Polygons;
use super::text::words;
use super::{MAX_ELEMENTS, MeshBuilder, Part};
use crate::library::read_bytes;
use glam::DAffine3;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// The names that programs give to texture coordinates.
const UV_NAMES: [[&str; 2]; 4] =
    [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
/// The names that programs give to lists of vertices.
const LIST_NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Appends the geometry of `path`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let bytes = read_bytes(path)?;
    let header = ply_header::read(&bytes, &place)?;
    let PlyMesh { mut part, polygons, leftover, .. } = read(&header, &place)?;
    builder.notes.extend(header.note);
    builder.notes.extend(leftover);
    if header.elements.iter().any(|element| element.name == "face" && element.find("texcoord").is_some()) {
        builder.notes.push(
            "ignored the texture coordinates of faces (`texcoord`); those of vertices are read".to_owned(),
        );
    }
    let triangulation = polygons.triangulate(&part.positions);
    builder.notes.extend(triangulation.notes());
    part.triangles = triangulation.triangles;
    builder.append(&part, world_from_file, &place)
}

/// Reads the records by lines, after which more may stand than the header says. Text that has other lines is
/// read by words, if these are exactly those that the header asks for.
fn read<'a>(header: &Header<'_>, place: &'a Place) -> Result<PlyMesh<'a>> {
    let by_lines = read_body(header, place, &mut Body::new(header, false, place));
    if by_lines.is_ok() || header.encoding != Encoding::Ascii || has_line_per_record(header) {
        return by_lines;
    }
    let mut body = Body::new(header, true, place);
    read_body(header, place, &mut body).ok().filter(|_| body.is_read()).map_or(by_lines, Ok)
}

/// True if there are as many lines as records, so that a record that does not fit its line is broken.
fn has_line_per_record(header: &Header<'_>) -> bool {
    let records =
        header.elements.iter().filter(|element| !element.properties.is_empty()).map(|element| element.count);
    header.body.clone().filter(|(_, line)| words(line).next().is_some()).count() == records.sum::<usize>()
}

fn read_body<'a>(header: &Header<'_>, place: &'a Place, body: &mut Body<'_>) -> Result<PlyMesh<'a>> {
    let (vertices, part, polygons) = (check_header(header, place)?, Part::default(), Polygons::default());
    let mut mesh = PlyMesh { vertices, place, part, polygons, leftover: None };
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => mesh.read_vertices(element, body)?,
            "face" if list_of(element).is_some() => mesh.read_faces(element, body)?,
            "tristrips" if list_of(element).is_some() => mesh.read_strips(element, body)?,
            _ => body.read(element, &[], None, |_, _| Ok(()))?,
        }
    }
    mesh.leftover = body.leftover();
    Ok(mesh)
}

/// The number of vertices. Refuses files without a mesh.
fn check_header(header: &Header<'_>, place: &Place) -> Result<usize> {
    let find = |name: &str| header.elements.iter().find(|element| element.name == name);
    let has_list = |name: &&str| find(name).is_some_and(|element| list_of(element).is_some());
    let Some(vertex) =
        find("vertex").filter(|vertex| ["x", "y", "z"].iter().all(|axis| single(vertex, axis).is_some()))
    else {
        return Err(Error::invalid(place, "has no element `vertex` with x, y and z; export it again"));
    };
    if !["face", "tristrips"].iter().any(has_list) {
        return Err(Error::invalid(
            place,
            "has no element `face` or `tristrips` with a list `vertex_indices`; export it as a mesh",
        ));
    }
    Ok(vertex.count)
}

/// Where a property that is no list stands.
fn single(element: &Element, name: &str) -> Option<usize> {
    element.find(name).filter(|index| element.properties[*index].length.is_none())
}

/// Where the list of vertices stands.
fn list_of(element: &Element) -> Option<usize> {
    LIST_NAMES
        .iter()
        .find_map(|name| element.find(name))
        .filter(|index| element.properties[*index].length.is_some())
}

/// What has been read so far.
struct PlyMesh<'a> {
    /// How many there are, which may stand behind the faces.
    vertices: usize,
    part: Part,
    polygons: Polygons,
    /// What stands behind the data.
    leftover: Option<String>,
    place: &'a Place,
}

impl PlyMesh<'_> {
    fn read_vertices(&mut self, element: &Element, body: &mut Body<'_>) -> Result<()> {
        let pick =
            |names: &[&str]| names.iter().map(|name| single(element, name)).collect::<Option<Vec<_>>>();
        let normal = pick(&["nx", "ny", "nz"]);
        let uv = UV_NAMES.iter().find_map(|names| pick(names));
        let wanted = [
            pick(&["x", "y", "z"]).unwrap_or_default(),
            normal.clone().unwrap_or(Vec::new()),
            uv.clone().unwrap_or(Vec::new()),
        ];
        let wanted: Vec<Option<usize>> = wanted.concat().into_iter().map(Some).collect();
        let part = &mut self.part;
        body.read(element, &wanted, None, |_, Record { values, .. }| {
            let (position, rest) = values.split_at(3);
            part.positions.push([position[0], position[1], position[2]].map(|x| x as f32));
            if normal.is_some() {
                part.normals.push([rest[0], rest[1], rest[2]].map(|x| x as f32));
            }
            if uv.is_some()
                && let [.., u, v] = rest
            {
                // As in OBJ, v goes up from the image's last row.
                part.uvs.push([*u as f32, 1.0 - *v as f32]);
            }
            Ok(())
        })
    }

    fn read_faces(&mut self, element: &Element, body: &mut Body<'_>) -> Result<()> {
        let (vertices, place, polygons) = (self.vertices, self.place, &mut self.polygons);
        let mut corners = Vec::new();
        body.read(element, &[], list_of(element), |index, record| {
            corners.clear();
            for corner in &record.list {
                corners.push(
                    vertex_of(*corner, vertices)
                        .ok_or_else(|| stray("face", index, *corner, vertices, place))?,
                );
            }
            polygons.add(corners.iter().copied(), Smoothing::ByAngle, place)
        })
    }

    /// Triangle strips, each as long as no −1 ends it; repeated vertices join parts of a strip and are no
    /// triangles.
    fn read_strips(&mut self, element: &Element, body: &mut Body<'_>) -> Result<()> {
        let (vertices, place, polygons) = (self.vertices, self.place, &mut self.polygons);
        let ends = |corner: f64| corner == -1.0 || corner == f64::from(u32::MAX);
        body.read(element, &[], list_of(element), |index, record| {
            for strip in record.list.split(|corner| ends(*corner)) {
                let corner = |corner: &f64| {
                    vertex_of(*corner, vertices)
                        .ok_or_else(|| stray("strip", index, *corner, vertices, place))
                };
                let strip = strip.iter().map(corner).collect::<Result<Vec<u32>>>()?;
                for (number, corners) in strip.windows(3).enumerate() {
                    let [a, b, c] = [corners[0], corners[1], corners[2]];
                    if a != b && b != c && c != a {
                        let triangle = if number % 2 == 0 { [a, b, c] } else { [b, a, c] };
                        polygons.add(triangle, Smoothing::ByAngle, place)?;
                    }
                }
            }
            Ok(())
        })
    }
}

fn vertex_of(number: f64, vertices: usize) -> Option<u32> {
    (number >= 0.0 && number.fract() == 0.0 && number < vertices.min(MAX_ELEMENTS) as f64)
        .then_some(number as u32)
}

fn stray(what: &str, index: usize, corner: f64, vertices: usize, place: &Place) -> Error {
    Error::invalid(
        place,
        format!(
            "{what} {index} names vertex {corner} of {vertices}, which count from 0; mend or export the file again"
        ),
    )
}
