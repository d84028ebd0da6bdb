//! glTF 2.0, text and binary: nodes give the placement, primitives the geometry, skins and morph targets the
//! rest pose. Cameras are ignored.

use super::MeshBuilder;
use super::gltf_buffers::Buffers;
use super::gltf_instances::{MAX_INSTANCES, node_from_instances};
use super::gltf_json::{InstanceAccessors, Structure, parse};
use super::gltf_materials::material_names;
use super::gltf_nodes::Placement;
use super::gltf_primitives::{Tally, UvSource, part};
use super::gltf_skins::{RestPose, Skins};
use super::gltf_uris::read_uri;
use crate::library::read_bytes;
use glam::DAffine3;
use gltf::{Document, Material, Node, Primitive};
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// An opened file and the bytes that it refers to, but for its pictures.
pub(crate) struct GltfFile {
    /// Where it lies.
    pub path: PathBuf,
    /// Its structure, checked by the parser.
    pub document: Document,
    pub(super) buffers: Buffers,
    pub(super) instances: HashMap<usize, InstanceAccessors>,
    /// By material, that of primitives without one last; no two are alike.
    pub(super) material_names: Vec<String>,
}

/// A primitive, and what the node that carries it makes of it.
pub(super) struct Source<'a> {
    pub node: &'a Node<'a>,
    /// The map from the mesh to the node.
    pub node_from_mesh: DAffine3,
    pub primitive: Primitive<'a>,
    pub rest_pose: &'a RestPose,
    /// Where to look for it in messages.
    pub place: Place,
}

/// All that wears one material of a file.
pub(crate) struct MaterialPart {
    /// The number of the material, that of primitives without one last.
    pub number: usize,
    /// A mesh that wears it, and the primitive.
    first: [usize; 2],
    /// The material's name in the file, which no other has.
    pub name: String,
    /// With the texture coordinates that the base colour asks for, or else the emission.
    pub mesh: MeshBuilder,
    /// The same with the texture coordinates that the emission asks for, if those are others.
    pub glow_mesh: Option<MeshBuilder>,
}

impl GltfFile {
    /// Opens the file at `path`. Adds what is ignored to `warnings`.
    pub fn open(path: &Path, warnings: &mut Vec<String>) -> Result<Self> {
        let place = Place::file(path);
        let Structure { document, binary, instances, notes } = parse(&read_bytes(path)?, &place)?;
        warnings.extend(notes.into_iter().map(|note| format!("{place}: {note}")));
        let buffers = Buffers::load(&document, binary, path)?;
        Ok(Self {
            path: path.to_path_buf(),
            material_names: material_names(&document),
            document,
            buffers,
            instances,
        })
    }

    /// The nodes of the default scene, or of the subtree of the node called `node`. Adds what is mended to
    /// `warnings`.
    pub fn nodes(
        &self,
        node: Option<&str>,
        world_from_file: &DAffine3,
        warnings: &mut Vec<String>,
    ) -> Result<Placement<'_>> {
        Placement::new(&self.document, node, world_from_file, &Place::file(&self.path), warnings)
    }

    /// Appends the geometry of `nodes` at rest, whatever its materials; it takes the first set of texture
    /// coordinates along. Shows `watch` where each part comes from: its place in the file, and which vertex
    /// of the primitive each of its own is, where they differ.
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
        builder.notes.extend(tally.notes());
        if nodes.wanted.iter().all(|(node, _)| node.mesh().is_none()) {
            builder.notes.push("none of its nodes that were taken has a mesh".to_owned());
        }
        Ok(())
    }

    /// The geometry of `nodes` by material, in order of first use; `crease_deg` is as in [`MeshBuilder`].
    /// Adds what was ignored to `warnings`.
    pub fn parts_by_material(
        &self,
        nodes: &Placement<'_>,
        crease_deg: Option<f64>,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<MaterialPart>> {
        let (mut tally, mut parts, mut known) =
            (Tally::default(), Vec::<MaterialPart>::new(), HashMap::new());
        self.each_primitive(nodes, &mut tally, |source, tally| {
            let material = source.primitive.material();
            let number = material.index().unwrap_or(self.document.materials().len());
            let at = *known.entry(number).or_insert(parts.len());
            if at == parts.len() {
                let name = self.material_names.get(number).cloned().unwrap_or_default();
                let first = [source.node.mesh().map_or(0, |mesh| mesh.index()), source.primitive.index()];
                parts.push(MaterialPart {
                    number,
                    first,
                    name,
                    mesh: MeshBuilder::with_crease(crease_deg),
                    glow_mesh: None,
                });
            }
            let MaterialPart { mesh, glow_mesh, .. } = &mut parts[at];
            let uv_of = |info: Option<gltf::texture::Info<'_>>| info.map(|info| UvSource::of(&info));
            let base = uv_of(material.pbr_metallic_roughness().base_color_texture());
            let glow = uv_of(material.emissive_texture());
            if let (Some(base), Some(glow)) = (&base, &glow)
                && base != glow
            {
                let again = &mut Tally::default();
                append_part(
                    source,
                    glow,
                    &self.buffers,
                    glow_mesh.get_or_insert_with(|| MeshBuilder::with_crease(crease_deg)),
                    again,
                )?;
            }
            append_part(source, &base.or(glow).unwrap_or_default(), &self.buffers, mesh, tally)
        })?;
        let place = Place::file(&self.path);
        warnings.extend(tally.notes().into_iter().map(|note| format!("{place}: {note}")));
        parts.retain(|part| !part.mesh.is_empty());
        Ok(parts)
    }

    /// The material that `part` wears.
    pub fn material_of(&self, part: &MaterialPart) -> Option<Material<'_>> {
        let [mesh, primitive] = part.first;
        Some(self.document.meshes().nth(mesh)?.primitives().nth(primitive)?.material())
    }

    fn each_primitive(
        &self,
        nodes: &Placement<'_>,
        tally: &mut Tally,
        mut visit: impl FnMut(&Source<'_>, &mut Tally) -> Result<()>,
    ) -> Result<()> {
        let place = Place::file(&self.path);
        let (mut skins, mut instances) = (Skins::new(nodes, &self.buffers), 0usize);
        for (node, world_from_node) in &nodes.wanted {
            let Some(mesh) = node.mesh() else { continue };
            let all = node_from_instances(self, node, &place)?;
            instances += all.len();
            if self.instances.contains_key(&node.index()) && instances > MAX_INSTANCES {
                return Err(Error::invalid(
                    &place,
                    format!("more than {MAX_INSTANCES} instances of meshes; split the file"),
                ));
            }
            for node_from_mesh in all {
                let rest_pose = skins.rest_pose(node, &(*world_from_node * node_from_mesh), &place)?;
                for primitive in mesh.primitives() {
                    let place = place.part(format!("mesh {}, primitive {}", mesh.index(), primitive.index()));
                    visit(&Source { node, node_from_mesh, primitive, rest_pose: &rest_pose, place }, tally)?;
                }
            }
        }
        Ok(())
    }

    /// The encoded bytes of the picture numbered `index`.
    pub fn image_bytes(&self, index: usize, place: &Place) -> Result<Vec<u8>> {
        // The crate's own way to the source takes a missing type for a bug.
        let image = self.document.as_json().images.get(index);
        let view = image
            .and_then(|image| image.buffer_view)
            .and_then(|view| self.document.views().nth(view.value()));
        match (view, image.and_then(|image| image.uri.as_deref())) {
            (Some(view), _) => self.buffers.view(&view, place).map(<[u8]>::to_vec),
            (None, Some(uri)) => read_uri(uri, &self.path, place),
            (None, None) => {
                Err(Error::invalid(place, "has neither a buffer view nor a uri; export the file again"))
            }
        }
    }
}

fn append_part(
    source: &Source<'_>,
    uv_source: &UvSource,
    buffers: &Buffers,
    builder: &mut MeshBuilder,
    tally: &mut Tally,
) -> Result<()> {
    if let Some(read) = part(source, uv_source, buffers, builder, tally)? {
        builder.append(&read.part, &read.world_from_part, &source.place)?;
    }
    Ok(())
}
