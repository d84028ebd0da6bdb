//! glTF 2.0, text and binary: nodes give the placement, primitives the geometry, skins and morph targets the rest pose. Cameras are ignored.

use super::MeshBuilder;
use super::gltf_buffers::{Buffers, read_uri};
use super::gltf_nodes::Placement;
use super::gltf_primitives::{Tally, UvSource, part};
use super::gltf_skins::{RestPose, Skins};
use crate::library::read_bytes;
use glam::DAffine3;
use gltf::json::validation::Checked;
use gltf::{Document, Gltf, Node, Primitive, Semantic};
use relume_formats::{Error, Place, Result};
use std::path::{Path, PathBuf};

/// An opened file and the bytes that it refers to, but for its pictures.
pub(crate) struct GltfFile {
    /// Where it lies.
    pub path: PathBuf,
    /// Its structure, checked by the parser.
    pub document: Document,
    pub(super) buffers: Buffers,
}

/// A primitive, and what the node that carries it makes of it.
pub(super) struct Source<'a> {
    pub node: &'a Node<'a>,
    pub primitive: Primitive<'a>,
    pub rest_pose: &'a RestPose,
    /// Where to look for it in messages.
    pub place: Place,
}

impl GltfFile {
    /// Opens the file at `path`.
    pub fn open(path: &Path) -> Result<Self> {
        let place = Place::file(path);
        let (document, blob) = parse(&read_bytes(path)?, &place)?;
        let buffers = Buffers::load(&document, blob, path)?;
        Ok(Self { path: path.to_path_buf(), document, buffers })
    }

    /// The nodes of the default scene, or of the subtree of the node called `node`.
    pub fn nodes(&self, node: Option<&str>, world_from_file: &DAffine3) -> Result<Placement<'_>> {
        Placement::new(&self.document, node, world_from_file, &Place::file(&self.path))
    }

    /// Appends the geometry of `nodes` at rest, whatever its materials; it takes the first set of texture coordinates along. Shows `watch` where each
    /// part comes from: its place in the file, and which vertex of the primitive each of its own is, where they differ.
    pub(super) fn append(
        &self,
        nodes: &Placement<'_>,
        builder: &mut MeshBuilder,
        mut watch: impl FnMut(&Source<'_>, Option<&[u32]>) -> Result<()>,
    ) -> Result<()> {
        let mut tally = Tally::default();
        self.each_primitive(nodes, &mut tally, |source, tally| {
            if let Some(read) = part(source, &UvSource::default(), &self.buffers, builder, tally)? {
                builder.append(&read.part, &read.world_from_part, &source.place)?;
                watch(source, read.corners.as_deref())?;
            }
            Ok(())
        })?;
        builder.notes.extend(tally.notes(false));
        Ok(())
    }

    /// The geometry of `nodes` by material name, in order of first use, with the texture coordinates that each material's base colour asks for.
    /// `crease_deg` is as in [`MeshBuilder`]. Adds what was ignored to `warnings`.
    pub fn meshes_by_material(
        &self,
        nodes: &Placement<'_>,
        crease_deg: Option<f64>,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<(String, MeshBuilder)>> {
        let (mut tally, mut meshes) = (Tally::default(), Vec::<(String, MeshBuilder)>::new());
        self.each_primitive(nodes, &mut tally, |source, tally| {
            let material = source.primitive.material();
            let texture = material.pbr_metallic_roughness().base_color_texture();
            let uv_source = texture.map(|info| UvSource::of(&info)).unwrap_or_default();
            let name = super::gltf_materials::name_of(&material);
            let index = meshes.iter().position(|(known, _)| *known == name).unwrap_or(meshes.len());
            let mut fresh = MeshBuilder::with_crease(crease_deg);
            let builder = meshes.get_mut(index).map_or(&mut fresh, |(_, builder)| builder);
            if let Some(read) = part(source, &uv_source, &self.buffers, builder, tally)? {
                builder.append(&read.part, &read.world_from_part, &source.place)?;
                if index == meshes.len() {
                    meshes.push((name, fresh));
                }
            }
            Ok(())
        })?;
        let place = Place::file(&self.path);
        warnings.extend(tally.notes(true).into_iter().map(|note| format!("{place}: {note}")));
        Ok(meshes)
    }

    fn each_primitive(
        &self,
        nodes: &Placement<'_>,
        tally: &mut Tally,
        mut visit: impl FnMut(&Source<'_>, &mut Tally) -> Result<()>,
    ) -> Result<()> {
        let place = Place::file(&self.path);
        let mut skins = Skins::new(nodes, &self.buffers);
        for (node, world_from_node) in &nodes.wanted {
            let Some(mesh) = node.mesh() else { continue };
            let rest_pose = skins.rest_pose(node, world_from_node, &place)?;
            for primitive in mesh.primitives() {
                let place = place.part(format!("mesh {}, primitive {}", mesh.index(), primitive.index()));
                visit(&Source { node, primitive, rest_pose: &rest_pose, place }, tally)?;
            }
        }
        Ok(())
    }

    /// The encoded bytes of the picture numbered `index`.
    pub fn image_bytes(&self, index: usize, place: &Place) -> Result<Vec<u8>> {
        // The crate's own way to the source takes a missing type for a bug.
        let image = self.document.as_json().images.get(index);
        let view = image.and_then(|image| image.buffer_view).and_then(|view| self.document.views().nth(view.value()));
        match (view, image.and_then(|image| image.uri.as_deref())) {
            (Some(view), _) => self.buffers.view(&view, place).map(<[u8]>::to_vec),
            (None, Some(uri)) => read_uri(uri, &self.path, place),
            (None, None) => Err(Error::invalid(place, "has neither a buffer view nor a uri; export the file again")),
        }
    }
}

/// The crate takes the header's own 12 bytes off the length that a GLB declares, however small that is.
fn expect_whole_header(bytes: &[u8], place: &Place) -> Result<()> {
    let length = bytes.strip_prefix(b"glTF").and_then(|rest| rest.get(4..8)?.try_into().ok()).map(u32::from_le_bytes);
    match length {
        Some(length @ ..12) => Err(Error::invalid(place, format!("not a glTF 2.0 file (declares {length} bytes); export it again"))),
        _ => Ok(()),
    }
}

/// The validated structure and the binary part. The crate's validation looks into the accessor of positions before it checks that there is one.
fn parse(bytes: &[u8], place: &Place) -> Result<(Document, Option<Vec<u8>>)> {
    expect_whole_header(bytes, place)?;
    let gltf = Gltf::from_slice_without_validation(bytes).map_err(|e| parse_error(&e, place))?;
    let json = gltf.document.into_json();
    let attributes = json.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|primitive| &primitive.attributes);
    let mut positions = attributes.filter_map(|attributes| attributes.get(&Checked::Valid(Semantic::Positions)));
    if let Some(stray) = positions.find(|index| index.value() >= json.accessors.len()) {
        let reason = format!("not valid glTF (POSITION is accessor {}, of {}); export it again", stray.value(), json.accessors.len());
        return Err(Error::invalid(place, reason));
    }
    Ok((Document::from_json(json).map_err(|e| parse_error(&e, place))?, gltf.blob))
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
