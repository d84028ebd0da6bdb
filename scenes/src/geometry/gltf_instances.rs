//! Instances of meshes by EXT_mesh_gpu_instancing: each is the mesh of a node in another place, in the space
//! of the node.

use super::MAX_ELEMENTS;
use super::gltf_file::GltfFile;
use super::gltf_json::InstanceAccessors;
use glam::{DAffine3, DQuat, DVec3};
use gltf::{Accessor, Node, Semantic};
use relume_formats::{Error, Place, Result};

/// Most instances in one file.
pub(super) const MAX_INSTANCES: usize = 1 << 20;

/// The maps from each instance of the mesh of `node` to the node; the identity alone where there are no
/// instances.
pub(super) fn node_from_instances(file: &GltfFile, node: &Node<'_>, place: &Place) -> Result<Vec<DAffine3>> {
    // The extension gives instances of what follows joints no meaning.
    let accessors = file.instances.get(&node.index()).filter(|_| node.skin().is_none());
    let Some(accessors) = accessors else { return Ok(vec![DAffine3::IDENTITY]) };
    let place = &place.part(format!("instances of node {}", node.index()));
    let InstanceAccessors { translation, rotation, scale } = *accessors;
    let [translation, rotation, scale] =
        [translation, rotation, scale].map(|number| number.map(|n| accessor(file, n, place)).transpose());
    let (translation, rotation, scale) = (translation?, rotation?, scale?);
    let counts: Vec<usize> =
        [&translation, &rotation, &scale].into_iter().flatten().map(Accessor::count).collect();
    let count = counts.first().copied().unwrap_or_default();
    if counts.iter().any(|other| *other != count) || count > MAX_INSTANCES {
        let reason = format!(
            "{counts:?} values, as many of each are needed and at most {MAX_INSTANCES}; export the file again"
        );
        return Err(Error::invalid(place, reason));
    }
    let positions = node
        .mesh()
        .into_iter()
        .flat_map(|mesh| mesh.primitives())
        .filter_map(|p| Some(p.get(&Semantic::Positions)?.count()));
    let vertices = positions.fold(0usize, usize::saturating_add);
    if count.saturating_mul(vertices) > MAX_ELEMENTS {
        let reason = format!(
            "{count} instances of {vertices} vertices, at most {MAX_ELEMENTS} vertices are read; split or simplify it"
        );
        return Err(Error::invalid(place, reason));
    }
    let vectors = |of: Option<Accessor<'_>>, value: f32| {
        of.map_or_else(|| Ok(vec![[value; 3]; count]), |a| file.buffers.exact_vectors(&a, place))
    };
    let (translation, scale) = (vectors(translation, 0.0)?, vectors(scale, 1.0)?);
    let still = || Ok(vec![[0.0, 0.0, 0.0, 1.0]; count]);
    let rotation = rotation.map_or_else(still, |a| file.buffers.quaternions(&a, place))?;
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let map = |((t, r), s): (([f32; 3], [f32; 4]), [f32; 3])| {
        let turn = DQuat::from_array(r.map(f64::from));
        let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
        DAffine3::from_scale_rotation_translation(vector(s), turn, vector(t))
    };
    Ok(translation.into_iter().zip(rotation).zip(scale).map(map).collect())
}

fn accessor<'a>(file: &'a GltfFile, number: usize, place: &Place) -> Result<Accessor<'a>> {
    let missing = || Error::invalid(place, format!("no accessor {number}; export the file again"));
    file.document.accessors().nth(number).ok_or_else(missing)
}
