//! glTF 2.0, text and binary. Nodes give the placement; materials, cameras, lights, skins and morph targets of the file are ignored.

use super::builder::{area_vector, unit_or_zero};
use super::gltf_buffers::Buffers;
use super::{MAX_ELEMENTS, MeshBuilder, Part, read_bytes};
use crate::suggest::unknown_name;
use glam::{DAffine3, DMat4, Mat4};
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive};
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// What the nodes of a file came to.
#[derive(Default)]
struct Tally {
    primitives: usize,
    flat: usize,
    not_triangles: usize,
    posed: usize,
}

/// Appends the geometry of the default scene of `path`, or of the subtree of the node called `node`.
pub(super) fn append(builder: &mut MeshBuilder, path: &Path, node: Option<&str>, world_from_file: &DAffine3) -> Result<()> {
    let place = Place::file(path);
    let gltf = Gltf::from_slice(&read_bytes(path)?).map_err(|e| parse_error(&e, &place))?;
    let buffers = Buffers::load(&gltf.document, gltf.blob, path)?;
    let mut tally = Tally::default();
    for (node, world_from_node) in placed_nodes(&gltf.document, node, world_from_file, &place)? {
        let Some(mesh) = node.mesh() else { continue };
        tally.posed += usize::from(node.skin().is_some() || mesh.primitives().any(|p| p.morph_targets().len() > 0));
        for primitive in mesh.primitives() {
            let place = place.part(format!("mesh {}, primitive {}", mesh.index(), primitive.index()));
            tally.primitives += 1;
            match part(&primitive, &buffers, builder, &mut tally, &place)? {
                Some(part) => builder.append(&part, &world_from_node, &place)?,
                None => tally.not_triangles += 1,
            }
        }
    }
    builder.notes.extend(tally.notes());
    Ok(())
}

impl Tally {
    fn notes(&self) -> Vec<String> {
        let of = self.primitives;
        [
            (self.flat, format!("{} of {of} primitives have no normals; made flat ones", self.flat)),
            (self.not_triangles, format!("ignored {} of {of} primitives, which are points or lines", self.not_triangles)),
            (self.posed, format!("{} nodes have a skin or morph targets, which are ignored: their meshes are as stored", self.posed)),
        ]
        .into_iter()
        .filter_map(|(count, note)| (count > 0).then_some(note))
        .collect()
    }
}

fn parse_error(error: &gltf::Error, place: &Place) -> Error {
    let gltf::Error::Validation(faults) = error else {
        return Error::invalid(place, format!("not a glTF 2.0 file ({error}); export it again"));
    };
    let Some((at, fault)) = faults.first() else { return Error::invalid(place, "not valid glTF") };
    let place = place.part(at.to_string());
    match fault {
        gltf::json::validation::Error::Unsupported => {
            Error::unsupported(&place, "a required extension that is not supported; export without it")
        }
        _ => Error::invalid(&place, format!("not valid glTF ({fault}); export it again")),
    }
}

/// Every node of the scene, or of the named node's subtree, with its placement in the world, parents first.
fn placed_nodes<'a>(
    document: &'a Document,
    wanted: Option<&str>,
    world_from_file: &DAffine3,
    place: &Place,
) -> Result<Vec<(Node<'a>, DAffine3)>> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Error::invalid(place, "the file has no scene; export it with one"))?;
    let mut stack: Vec<_> = scene.nodes().map(|node| (node, *world_from_file, wanted.is_none())).collect();
    stack.reverse();
    let mut seen = vec![false; document.nodes().len()];
    let (mut placed, mut names) = (Vec::new(), Vec::new());
    while let Some((node, world_from_parent, parent_inside)) = stack.pop() {
        // A node with two parents could be its own ancestor; glTF forbids both.
        if seen.get_mut(node.index()).is_none_or(|seen| std::mem::replace(seen, true)) {
            return Err(Error::invalid(place, format!("node {} has two parents; export the file again", node.index())));
        }
        names.extend(node.name());
        let inside = parent_inside || (wanted.is_some() && node.name() == wanted);
        let world_from_node = world_from_parent * parent_from_node(&node);
        let children: Vec<_> = node.children().map(|child| (child, world_from_node, inside)).collect();
        stack.extend(children.into_iter().rev());
        if inside {
            placed.push((node, world_from_node));
        }
    }
    match wanted {
        Some(name) if placed.is_empty() => Err(Error::invalid(place, unknown_name("node", name, names))),
        _ => Ok(placed),
    }
}

fn parent_from_node(node: &Node<'_>) -> DAffine3 {
    let matrix: DMat4 = Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
    DAffine3::from_mat4(matrix)
}

/// The geometry of a primitive in its node's space; none if it is not made of triangles.
fn part(primitive: &Primitive<'_>, buffers: &Buffers, builder: &MeshBuilder, tally: &mut Tally, place: &Place) -> Result<Option<Part>> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(None);
    }
    let accessor = primitive.get(&gltf::Semantic::Positions).ok_or_else(|| Error::invalid(place, "has no positions"))?;
    builder.expect_room(accessor.count(), 0, place)?;
    let positions = buffers.vectors(&accessor, place)?;
    let corners = match primitive.indices() {
        Some(indices) => buffers.indices(&indices, place)?,
        None => (0..positions.len().min(MAX_ELEMENTS) as u32).collect(),
    };
    let triangles = triangles(primitive.mode(), &corners);
    let Some(normals) = primitive.get(&gltf::Semantic::Normals) else {
        tally.flat += 1;
        builder.expect_room(3 * triangles.len(), triangles.len(), place)?;
        return flat(&positions, &triangles, place).map(Some);
    };
    let normals = buffers.vectors(&normals, place)?;
    if normals.len() != positions.len() {
        return Err(Error::invalid(place, format!("{} positions but {} normals", positions.len(), normals.len())));
    }
    Ok(Some(Part { positions, normals, triangles }))
}

/// Lists, strips and fans as triangles (glTF 2.0 specification, section 3.7.2.1).
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let windows = || corners.windows(3).filter_map(|w| w.try_into().ok());
    match mode {
        Mode::TriangleStrip => {
            windows().enumerate().map(|(i, [a, b, c]): (_, [u32; 3])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] }).collect()
        }
        Mode::TriangleFan => match corners.split_first() {
            Some((first, rest)) => rest.windows(2).filter_map(|w| <[u32; 2]>::try_from(w).ok()).map(|[a, b]| [a, b, *first]).collect(),
            None => Vec::new(),
        },
        _ => corners.as_chunks().0.to_vec(),
    }
}

/// Flat shading needs corners of their own for every triangle.
fn flat(positions: &[[f32; 3]], triangles: &[[u32; 3]], place: &Place) -> Result<Part> {
    let mut part = Part::default();
    for (index, triangle) in triangles.iter().enumerate() {
        let corner = |k: usize| positions.get(triangle[k] as usize).copied();
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            return Err(Error::invalid(place, format!("triangle {index} names a vertex beyond {}; mend the mesh", positions.len())));
        };
        let first = part.positions.len() as u32;
        part.positions.extend([a, b, c]);
        part.normals.extend([unit_or_zero(area_vector([a, b, c])); 3]);
        part.triangles.push([first, first + 1, first + 2]);
    }
    Ok(part)
}
