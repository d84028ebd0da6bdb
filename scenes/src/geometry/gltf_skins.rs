//! Skins and morph weights of glTF nodes, and the rest pose they give to primitives.
//!
//! The rest pose is every node at its own transform and every morph target at its default weight. A mesh with
//! a skin follows its joints alone: the node that carries it counts for nothing (glTF 2.0, section 3.7.3.3).

use super::Part;
use super::builder::unit_or_zero;
use super::gltf_buffers::Buffers;
use super::gltf_nodes::{Placement, affine};
use crate::transform::{is_mirroring, normal_map};
use glam::{DAffine3, Vec3};
use gltf::{Node, Primitive, Semantic, Skin};
use relume_formats::shape::{Influences, Joint, MAX_JOINTS, morphed};
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;
use std::rc::Rc;

/// A skin, and where its joints are at rest.
pub(super) struct RestSkin {
    /// Of [`Placement::hierarchy`].
    pub joints: Vec<Joint>,
    /// For each joint the map from the mesh to the world.
    world_from_mesh: Vec<DAffine3>,
}

/// How the mesh of a node stands at rest.
pub(super) struct RestPose {
    world_from_node: DAffine3,
    /// The skin and its number in the file.
    pub skin: Option<(usize, Rc<RestSkin>)>,
    /// Of the first morph targets; the rest weigh nothing.
    pub morph_weights: Vec<f32>,
}

/// The skins met so far, each read once.
pub(super) struct Skins<'a> {
    pub placement: &'a Placement<'a>,
    pub buffers: &'a Buffers,
    known: HashMap<usize, Rc<RestSkin>>,
}

impl<'a> Skins<'a> {
    pub fn new(placement: &'a Placement<'a>, buffers: &'a Buffers) -> Self {
        Self { placement, buffers, known: HashMap::new() }
    }

    /// The rest pose of the mesh that `node` carries, if it stands at `world_from_node`.
    pub fn rest_pose(
        &mut self,
        node: &Node<'_>,
        world_from_node: &DAffine3,
        place: &Place,
    ) -> Result<RestPose> {
        let default_weights = node.mesh().and_then(|mesh| mesh.weights());
        let morph_weights = node.weights().or(default_weights).unwrap_or_default().to_vec();
        let skin = node.skin().map(|skin| Ok((skin.index(), self.skin(&skin, place)?))).transpose()?;
        Ok(RestPose { world_from_node: *world_from_node, skin, morph_weights })
    }

    fn skin(&mut self, skin: &Skin<'_>, place: &Place) -> Result<Rc<RestSkin>> {
        if let Some(known) = self.known.get(&skin.index()) {
            return Ok(Rc::clone(known));
        }
        let joints =
            joints(skin, self.placement, self.buffers, &place.part(format!("skin {}", skin.index())))?;
        let world_from_mesh = joints
            .iter()
            .map(|joint| self.placement.world_from_node[joint.node as usize] * joint.node_from_mesh)
            .collect();
        let read = Rc::new(RestSkin { joints, world_from_mesh });
        self.known.insert(skin.index(), Rc::clone(&read));
        Ok(read)
    }
}

fn joints(
    skin: &Skin<'_>,
    placement: &Placement<'_>,
    buffers: &Buffers,
    place: &Place,
) -> Result<Vec<Joint>> {
    let count = skin.joints().count();
    if !(1..=MAX_JOINTS).contains(&count) {
        return Err(Error::invalid(
            place,
            format!("{count} joints, 1 to {MAX_JOINTS} are allowed; mend the model"),
        ));
    }
    let matrices = match skin.inverse_bind_matrices() {
        Some(accessor) => buffers.matrices(&accessor, place)?.iter().map(affine).collect(),
        None => vec![DAffine3::IDENTITY; count],
    };
    if matrices.len() < count {
        let reason =
            format!("{count} joints but {} inverse bind matrices; export the file again", matrices.len());
        return Err(Error::invalid(place, reason));
    }
    let joint = |(node, node_from_mesh): (Node<'_>, DAffine3)| {
        let elsewhere = || {
            Error::invalid(
                place,
                format!("its joint, node {}, is not in the scene; export the file again", node.index()),
            )
        };
        Ok(Joint { node: placement.index_of(node.index()).ok_or_else(elsewhere)?, node_from_mesh })
    };
    skin.joints().zip(matrices).map(joint).collect()
}

/// What each vertex of `primitive` follows, of `joints` joints: the four of its first set, with weights
/// scaled to the sum 1. Also how many vertices had weights below 0, which count as 0, or none above, which
/// follow their first joint.
pub(super) fn influences(
    primitive: &Primitive<'_>,
    joints: usize,
    buffers: &Buffers,
    place: &Place,
) -> Result<(Vec<Influences>, usize)> {
    let (indices, weights) = (primitive.get(&Semantic::Joints(0)), primitive.get(&Semantic::Weights(0)));
    let Some((indices, weights)) = indices.zip(weights) else {
        return Err(Error::invalid(
            place,
            "its node has a skin, but it lacks JOINTS_0 or WEIGHTS_0; export the file again",
        ));
    };
    let (indices, weights) =
        (buffers.joint_indices(&indices, place)?, buffers.joint_weights(&weights, place)?);
    if indices.len() != weights.len() {
        let reason = format!(
            "joints for {} vertices but weights for {}; export the file again",
            indices.len(),
            weights.len()
        );
        return Err(Error::invalid(place, reason));
    }
    let mended = weights
        .iter()
        .filter(|of| of.iter().any(|weight| *weight < 0.0) || of.iter().all(|weight| *weight <= 0.0))
        .count();
    let vertices = indices.into_iter().zip(weights).enumerate();
    let influences = vertices.map(|(vertex, (joints_of, weights))| {
        influences_of(joints_of, weights, joints)
            .map_err(|reason| Error::invalid(place, format!("vertex {vertex} {reason}; mend the mesh")))
    });
    Ok((influences.collect::<Result<_>>()?, mended))
}

fn influences_of(
    mut indices: [u32; 4],
    given: [f32; 4],
    joints: usize,
) -> std::result::Result<Influences, String> {
    let mut weights = given.map(|weight| if weight < 0.0 { 0.0 } else { weight });
    if weights == [0.0; 4] {
        weights[0] = 1.0;
    }
    let sum: f32 = weights.iter().sum();
    if !sum.is_finite() {
        return Err(format!("has the joint weights {given:?}, which must be finite"));
    }
    for (index, weight) in indices.iter_mut().zip(weights) {
        // Without a weight a joint means nothing, and some programs leave anything there.
        if weight == 0.0 {
            *index = 0;
        }
        if *index as usize >= joints {
            return Err(format!("follows joint {index} of {joints}"));
        }
    }
    Ok(Influences { joints: indices, weights: weights.map(|weight| weight / sum) })
}

impl RestPose {
    /// Poses `part`, as `primitive` stores it, and returns the map from where it is then to the world, and
    /// how many vertices had weights to mend.
    pub fn apply(
        &self,
        part: &mut Part,
        primitive: &Primitive<'_>,
        buffers: &Buffers,
        place: &Place,
    ) -> Result<(DAffine3, usize)> {
        self.morph(part, primitive, buffers, place)?;
        let Some((_, skin)) = &self.skin else { return Ok((self.world_from_node, 0)) };
        let (influences, mended) = influences(primitive, skin.joints.len(), buffers, place)?;
        super::gltf_primitives::expect_count(
            influences.len(),
            part.positions.len(),
            "joints and weights",
            place,
        )?;
        skin.pose(part, &influences);
        Ok((DAffine3::IDENTITY, mended))
    }

    fn morph(
        &self,
        part: &mut Part,
        primitive: &Primitive<'_>,
        buffers: &Buffers,
        place: &Place,
    ) -> Result<()> {
        let targets =
            primitive.morph_targets().zip(&self.morph_weights).filter(|(_, weight)| **weight != 0.0);
        for (target, weight) in targets {
            for (values, deltas) in
                [(&mut part.positions, target.positions()), (&mut part.normals, target.normals())]
            {
                let Some(deltas) = deltas.filter(|_| !values.is_empty()) else { continue };
                let deltas = buffers.displacements(&deltas, values.len(), place)?;
                values
                    .iter_mut()
                    .zip(deltas)
                    .for_each(|(value, delta)| *value = morphed(*value, delta, *weight));
            }
        }
        Ok(())
    }
}

impl RestSkin {
    /// Takes `part` to the world. What joints mirror keeps its front.
    fn pose(&self, part: &mut Part, influences: &[Influences]) {
        let mut mirrored = Vec::with_capacity(influences.len());
        for (vertex, influences) in influences.iter().enumerate() {
            let world_from_mesh = influences.blend(&self.world_from_mesh);
            mirrored.push(is_mirroring(&world_from_mesh));
            if let Some(position) = part.positions.get_mut(vertex) {
                *position =
                    world_from_mesh.transform_point3(Vec3::from(*position).as_dvec3()).as_vec3().to_array();
            }
            if let Some(normal) = part.normals.get_mut(vertex) {
                *normal = unit_or_zero(normal_map(&world_from_mesh) * Vec3::from(*normal).as_dvec3());
            }
        }
        for [a, b, c] in &mut part.triangles {
            let corners =
                [*a, *b, *c].map(|vertex| mirrored.get(vertex as usize).copied().unwrap_or_default());
            if corners.into_iter().filter(|mirrored| *mirrored).count() >= 2 {
                std::mem::swap(b, c);
            }
        }
    }
}
