//! The triangles of glTF primitives.

use super::gltf_buffers::Buffers;
use super::gltf_file::Source;
use super::normals::Smoothing;
use super::{MAX_ELEMENTS, MeshBuilder, Part};
use glam::DAffine3;
use gltf::mesh::Mode;
use gltf::{Primitive, Semantic, texture};
use relume_formats::counts::{counted, one_or};
use relume_formats::{Error, Place, Result};

/// What was met while reading primitives.
#[derive(Default)]
pub(super) struct Tally {
    pub primitives: usize,
    pub flat: usize,
    pub not_triangles: usize,
    pub without_positions: usize,
    pub coloured: usize,
    /// With more than four joints per vertex.
    pub many_joints: usize,
    /// Vertices whose joint weights were mended.
    pub weights: usize,
}

impl Tally {
    /// One line for each thing that the mesh lacks or that is ignored.
    pub fn notes(&self) -> Vec<String> {
        let of = counted(self.primitives, "primitive", "primitives");
        let have = |count: usize| format!("{count} of {of} {}", one_or(count, "has", "have"));
        let points = one_or(self.not_triangles, "which is points or lines", "which are points or lines");
        let weights = counted(self.weights, "vertex", "vertices");
        [
            (self.flat, format!("{} no normals; made flat ones", have(self.flat))),
            (self.not_triangles, format!("ignored {} of {of}, {points}", self.not_triangles)),
            (
                self.without_positions,
                format!("ignored {} of {of}, without positions", self.without_positions),
            ),
            (self.coloured, format!("{} vertex colours, which are ignored", have(self.coloured))),
            (
                self.many_joints,
                format!("{} more than four joints per vertex; kept the first four", have(self.many_joints)),
            ),
            (self.weights, format!("mended the joint weights of {weights}, which were below 0 or all 0")),
        ]
        .into_iter()
        .filter_map(|(count, note)| (count > 0).then_some(note))
        .collect()
    }
}

/// Which texture coordinates a primitive takes along, and how they are moved.
#[derive(Default, PartialEq)]
pub(super) struct UvSource {
    set: u32,
    /// Offset, rotation in radians and scale.
    transform: Option<([f32; 2], f32, [f32; 2])>,
}

impl UvSource {
    /// Those that a texture asks for.
    pub fn of(info: &texture::Info<'_>) -> Self {
        let Some(transform) = info.texture_transform() else {
            return Self { set: info.tex_coord(), transform: None };
        };
        let moved = (transform.offset(), transform.rotation(), transform.scale());
        Self { set: transform.tex_coord().unwrap_or_else(|| info.tex_coord()), transform: Some(moved) }
    }

    /// KHR_texture_transform: scaled, then turned counter-clockwise as seen on the image, whose v goes down,
    /// then moved.
    fn moved(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let Some((offset, rotation, scale)) = self.transform else { return [u, v] };
        let (sin, cos) = rotation.sin_cos();
        let (u, v) = (u * scale[0], v * scale[1]);
        [cos * u + sin * v + offset[0], cos * v - sin * u + offset[1]]
    }
}

/// The geometry of a primitive.
pub(super) struct PrimitivePart {
    /// At rest.
    pub part: Part,
    /// The map from the part's space to the world.
    pub world_from_part: DAffine3,
    /// Which vertex of the primitive each of the part's is; none if they are the same.
    pub corners: Option<Vec<u32>>,
}

/// The geometry of a primitive; none if it is not made of triangles, or of nothing.
pub(super) fn part(
    source: &Source<'_>,
    uv_source: &UvSource,
    buffers: &Buffers,
    builder: &MeshBuilder,
    tally: &mut Tally,
) -> Result<Option<PrimitivePart>> {
    let (primitive, place) = (&source.primitive, &source.place);
    tally.primitives += 1;
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        tally.not_triangles += 1;
        return Ok(None);
    }
    if primitive.get(&Semantic::Positions).is_none() {
        tally.without_positions += 1;
        return Ok(None);
    }
    tally.coloured += usize::from(primitive.get(&Semantic::Colors(0)).is_some());
    tally.many_joints +=
        usize::from(source.rest_pose.skin.is_some() && primitive.get(&Semantic::Joints(1)).is_some());
    let mut part = stored(primitive, uv_source, buffers, builder, place)?;
    let (world_from_part, weights) = source.rest_pose.apply(&mut part, primitive, buffers, place)?;
    tally.weights += weights;
    if !part.normals.is_empty() {
        return Ok(Some(PrimitivePart { part, world_from_part, corners: None }));
    }
    tally.flat += usize::from(builder.leaves_shading_to_file());
    builder.expect_room(3 * part.triangles.len(), part.triangles.len(), place)?;
    Ok(Some(PrimitivePart {
        part: flat(&part, place)?,
        world_from_part,
        corners: Some(part.triangles.into_flattened()),
    }))
}

/// A primitive as the file holds it.
fn stored(
    primitive: &Primitive<'_>,
    uv_source: &UvSource,
    buffers: &Buffers,
    builder: &MeshBuilder,
    place: &Place,
) -> Result<Part> {
    let accessor =
        primitive.get(&Semantic::Positions).ok_or_else(|| Error::invalid(place, "has no positions"))?;
    builder.expect_room(accessor.count(), 0, place)?;
    let positions = buffers.vectors(&accessor, place)?;
    let corners = match primitive.indices() {
        Some(indices) => buffers.indices(&indices, place)?,
        None => (0..positions.len().min(MAX_ELEMENTS) as u32).collect(),
    };
    let mut part = Part { triangles: triangles(primitive.mode(), &corners), ..Part::default() };
    if let Some(uvs) = primitive.get(&Semantic::TexCoords(uv_source.set)) {
        part.uvs =
            buffers.texture_coordinates(&uvs, place)?.into_iter().map(|uv| uv_source.moved(uv)).collect();
        expect_count(part.uvs.len(), positions.len(), "texture coordinates", place)?;
    }
    if let Some(normals) = primitive.get(&Semantic::Normals) {
        part.normals = buffers.vectors(&normals, place)?;
        expect_count(part.normals.len(), positions.len(), "normals", place)?;
    }
    part.positions = positions;
    Ok(part)
}

pub(super) fn expect_count(count: usize, positions: usize, what: &str, place: &Place) -> Result<()> {
    if count == positions {
        return Ok(());
    }
    Err(Error::invalid(place, format!("{positions} positions but {count} {what}; export the file again")))
}

/// Lists, strips and fans as triangles (glTF 2.0 specification, section 3.7.2.1).
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let windows = || corners.windows(3).filter_map(|w| w.try_into().ok());
    match mode {
        Mode::TriangleStrip => windows()
            .enumerate()
            .map(|(i, [a, b, c]): (_, [u32; 3])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] })
            .collect(),
        Mode::TriangleFan => match corners.split_first() {
            Some((first, rest)) => rest
                .windows(2)
                .filter_map(|w| <[u32; 2]>::try_from(w).ok())
                .map(|[a, b]| [a, b, *first])
                .collect(),
            None => Vec::new(),
        },
        _ => corners.as_chunks().0.to_vec(),
    }
}

/// Flat shading, which glTF asks for where there are no normals, needs corners of their own for every
/// triangle.
fn flat(part: &Part, place: &Place) -> Result<Part> {
    let mut flat = Part::default();
    for (index, triangle) in part.triangles.iter().enumerate() {
        let corner = |k: usize| part.positions.get(triangle[k] as usize).copied();
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            let reason =
                format!("triangle {index} names a vertex beyond {}; mend the mesh", part.positions.len());
            return Err(Error::invalid(place, reason));
        };
        let first = flat.positions.len() as u32;
        flat.positions.extend([a, b, c]);
        flat.uvs.extend(triangle.iter().filter_map(|v| part.uvs.get(*v as usize)));
        flat.triangles.push([first, first + 1, first + 2]);
    }
    flat.smoothing = vec![Smoothing::Flat; flat.triangles.len()];
    Ok(flat)
}
