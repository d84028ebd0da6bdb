//! Shapes that deform, from glTF: the vertices of the mesh that the file is at rest, and what moves each of
//! them.
//!
//! Everything of a scene comes in one list, whatever the number of nodes, meshes and skins: a vertex without
//! a skin follows its node as if that were its one joint. Triangles that are degenerate at rest are left out
//! for good, with the vertices that only they use.

use super::gltf_clips;
use super::gltf_file::{GltfFile, Source};
use super::gltf_nodes::Placement;
use super::gltf_skins::influences;
use super::{MeshBuilder, is_gltf};
use crate::scene::Mesh;
use glam::DAffine3;
use gltf::Semantic;
use relume_formats::shape::{DeformingMesh, Influences, Joint, MAX_MORPHED, MorphTarget};
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;
use std::path::Path;

/// A mesh that deforms, and its triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Deforming {
    /// The mesh at rest, the same that [`load_mesh`](crate::load_mesh) reads from the file.
    pub rest: Mesh,
    /// What moves each vertex of `rest`: vertex i of one is vertex i of the other.
    pub shape: DeformingMesh,
}

/// Reads the shape of a glTF file and all its clips, which may be none. Adds what was mended to `warnings`.
///
/// # Errors
/// Those of [`load_mesh`](crate::load_mesh); `Unsupported` for files other than glTF, `Invalid` for skins,
/// morph targets and animations that break the rules of glTF.
pub fn load_deforming(path: &Path, warnings: &mut Vec<String>) -> Result<Deforming> {
    load_placed(path, None, &DAffine3::IDENTITY, None, warnings)
}

/// [`load_deforming`] of the subtree of the node called `node`, if given, in the place where a scene has it,
/// with the crease angle that it gives.
pub(crate) fn load_placed(
    path: &Path,
    node: Option<&str>,
    world_from_file: &DAffine3,
    crease_deg: Option<f64>,
    warnings: &mut Vec<String>,
) -> Result<Deforming> {
    let place = Place::file(path);
    if !is_gltf(path) {
        return Err(Error::unsupported(
            &place,
            "only .gltf and .glb files hold shapes that deform; export it as one of them",
        ));
    }
    let file = GltfFile::open(path, warnings)?;
    let nodes = file.nodes(node, world_from_file, warnings)?;
    let mut builder = MeshBuilder::with_crease(crease_deg);
    let mut bindings = Bindings::new(&file, &nodes);
    file.append(&nodes, &mut builder, |source, corners| bindings.append(source, corners))?;
    let (rest, origins) = builder.finish_and_tell(&place, warnings)?;
    bindings.keep(&origins);
    let Bindings { mut shape, targets_of_node, .. } = bindings;
    shape.clips = gltf_clips::read(&file, &nodes, &targets_of_node, &place, warnings)?;
    shape.nodes = nodes.hierarchy;
    shape.validate(&place)?;
    Ok(Deforming { rest, shape })
}

/// What moves the vertices read so far.
struct Bindings<'a> {
    file: &'a GltfFile,
    nodes: &'a Placement<'a>,
    shape: DeformingMesh,
    /// The first joint of each skin, by its number in the file.
    first_joint: HashMap<usize, u32>,
    /// The morph targets of each node, by its number in the file.
    targets_of_node: HashMap<usize, Vec<u32>>,
    /// Positions in all morph targets.
    morphed: usize,
}

impl<'a> Bindings<'a> {
    fn new(file: &'a GltfFile, nodes: &'a Placement<'a>) -> Self {
        let shape = DeformingMesh::default();
        Self { file, nodes, shape, first_joint: HashMap::new(), targets_of_node: HashMap::new(), morphed: 0 }
    }

    /// Adds the vertices of a primitive; `corners` are as in [`GltfFile::append`].
    fn append(&mut self, source: &Source<'_>, corners: Option<&[u32]>) -> Result<()> {
        let (place, buffers) = (&source.place, &self.file.buffers);
        let accessor = source
            .primitive
            .get(&Semantic::Positions)
            .ok_or_else(|| Error::invalid(place, "has no positions"))?;
        let positions = buffers.vectors(&accessor, place)?;
        let influences = match &source.rest_pose.skin {
            Some((_, skin)) => influences(&source.primitive, skin.joints.len(), buffers, place)?.0,
            None => vec![Influences::rigid(0); positions.len()],
        };
        let offset = self.joint_offset(source)?;
        let shifted = |influences: &Influences| Influences {
            joints: influences.joints.map(|joint| joint + offset),
            ..*influences
        };
        let first_vertex = self.shape.positions.len() as u32;
        self.shape.positions.extend(gathered(&positions, corners));
        self.shape.influences.extend(gathered(&influences, corners).map(|influences| shifted(&influences)));
        self.append_targets(source, positions.len(), corners, first_vertex)
    }

    /// Where the joints that the primitive counts from 0 begin; the node itself is the only joint of a mesh
    /// without a skin.
    fn joint_offset(&mut self, source: &Source<'_>) -> Result<u32> {
        let next = self.shape.joints.len() as u32;
        let Some((index, skin)) = &source.rest_pose.skin else {
            let node = self.nodes.index_of(source.node.index()).unwrap_or_default();
            let joint = Joint { node, node_from_mesh: source.node_from_mesh };
            // The primitives of a mesh come one after the other.
            if self.shape.joints.last() == Some(&joint) {
                return Ok(next - 1);
            }
            self.shape.joints.push(joint);
            return Ok(next);
        };
        let offset = *self.first_joint.entry(*index).or_insert(next);
        if offset == next {
            self.shape.joints.extend_from_slice(&skin.joints);
        }
        Ok(offset)
    }

    /// Adds what the targets of a primitive of `vertices` vertices move to those of its node; vertices that
    /// stay are left out.
    fn append_targets(
        &mut self,
        source: &Source<'_>,
        vertices: usize,
        corners: Option<&[u32]>,
        first_vertex: u32,
    ) -> Result<()> {
        let targets = self.targets_of_node.entry(source.node.index()).or_default();
        for (k, target) in source.primitive.morph_targets().enumerate() {
            if k == targets.len() {
                let rest_weight = source.rest_pose.morph_weights.get(k).copied().unwrap_or_default();
                targets.push(self.shape.morph_targets.len() as u32);
                self.shape.morph_targets.push(MorphTarget {
                    rest_weight,
                    vertices: Vec::new(),
                    deltas: Vec::new(),
                });
            }
            let Some(deltas) = target.positions() else { continue };
            let deltas = self.file.buffers.displacements(&deltas, vertices, &source.place)?;
            let morph = &mut self.shape.morph_targets[targets[k] as usize];
            let before = morph.vertices.len();
            for (vertex, delta) in
                gathered(&deltas, corners).enumerate().filter(|(_, delta)| *delta != [0.0; 3])
            {
                morph.vertices.push(first_vertex + vertex as u32);
                morph.deltas.push(delta);
            }
            self.morphed += morph.vertices.len() - before;
            if self.morphed > MAX_MORPHED {
                let reason = format!(
                    "morph targets of more than {MAX_MORPHED} positions in one object; split or simplify it"
                );
                return Err(Error::invalid(&source.place, reason));
            }
        }
        Ok(())
    }

    /// Makes the vertices those of the mesh; `origins` says which of the ones read each of them is.
    fn keep(&mut self, origins: &[u32]) {
        self.shape.positions = gathered(&self.shape.positions, Some(origins)).collect();
        self.shape.influences = gathered(&self.shape.influences, Some(origins)).collect();
        let mut kept: Vec<(u32, u32)> = origins.iter().copied().zip(0..).collect();
        kept.sort_unstable();
        for target in &mut self.shape.morph_targets {
            let of_vertex = |vertex: u32| {
                kept[kept.partition_point(|(origin, _)| *origin < vertex)..]
                    .iter()
                    .take_while(move |(o, _)| *o == vertex)
            };
            let pairs = target.vertices.iter().zip(&target.deltas);
            let mut moved: Vec<(u32, [f32; 3])> =
                pairs.flat_map(|(vertex, delta)| of_vertex(*vertex).map(|(_, new)| (*new, *delta))).collect();
            moved.sort_unstable_by_key(|(vertex, _)| *vertex);
            (target.vertices, target.deltas) = moved.into_iter().unzip();
        }
    }
}

/// All `values`, or those at `corners`, which are sound indices by now.
fn gathered<T: Copy>(values: &[T], corners: Option<&[u32]>) -> impl Iterator<Item = T> {
    let count = corners.map_or(values.len(), <[u32]>::len);
    (0..count).filter_map(move |index| {
        values.get(corners.map_or(index, |corners| corners[index] as usize)).copied()
    })
}
