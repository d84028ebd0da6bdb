//! The hierarchy of a glTF scene: every node in the world, parents before children.

use crate::suggest::unknown_name;
use glam::{DAffine3, DMat4, Mat4};
use gltf::{Document, Node};
use relume_formats::shape::{self, Transform};
use relume_formats::{Error, Place, Result};

/// A node and the map from its space to the world.
pub(crate) type PlacedNode<'a> = (Node<'a>, DAffine3);

/// The nodes of a scene.
pub(crate) struct Placement<'a> {
    /// Those whose meshes and lights are wanted.
    pub wanted: Vec<PlacedNode<'a>>,
    /// The whole hierarchy at rest, joints included; the first is the placement of the file itself.
    pub(super) hierarchy: Vec<shape::Node>,
    /// The map from each node of the hierarchy to the world.
    pub(super) world_from_node: Vec<DAffine3>,
    /// For each node of the file its index in the hierarchy, if it is there.
    index_of: Vec<Option<u32>>,
}

impl<'a> Placement<'a> {
    /// The nodes of the default scene of `document`, of which only the subtree of the node called `wanted`, if given, is wanted.
    pub(super) fn new(document: &'a Document, wanted: Option<&str>, world_from_file: &DAffine3, place: &Place) -> Result<Self> {
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let scene = scene.ok_or_else(|| Error::invalid(place, "the file has no scene; export it with one"))?;
        let mut placement = Self {
            wanted: Vec::new(),
            hierarchy: vec![shape::Node { parent: None, rest: Transform::Fixed(*world_from_file) }],
            world_from_node: vec![*world_from_file],
            index_of: vec![None; document.nodes().len()],
        };
        let mut names = Vec::new();
        let mut stack: Vec<_> = scene.nodes().map(|node| (node, 0, wanted.is_none())).collect();
        stack.reverse();
        while let Some((node, parent, parent_inside)) = stack.pop() {
            let index = placement.add(&node, parent, place)?;
            names.extend(node.name());
            let inside = parent_inside || (wanted.is_some() && node.name() == wanted);
            let children: Vec<_> = node.children().map(|child| (child, index, inside)).collect();
            stack.extend(children.into_iter().rev());
            if inside {
                placement.wanted.push((node, placement.world_from_node[index as usize]));
            }
        }
        match wanted {
            Some(name) if placement.wanted.is_empty() => Err(Error::invalid(place, unknown_name("node", name, names))),
            _ => Ok(placement),
        }
    }

    /// The index in the hierarchy of the node that the file numbers `index`.
    pub(super) fn index_of(&self, index: usize) -> Option<u32> {
        self.index_of.get(index).copied().flatten()
    }

    /// How many nodes the file has, in the scene or not.
    pub(super) fn file_nodes(&self) -> usize {
        self.index_of.len()
    }

    /// Appends a node to the hierarchy; `parent` is there already.
    fn add(&mut self, node: &Node<'_>, parent: u32, place: &Place) -> Result<u32> {
        let index = self.hierarchy.len() as u32;
        // A node with two parents could be its own ancestor; glTF forbids both.
        if self.index_of.get_mut(node.index()).is_none_or(|known| known.replace(index).is_some()) {
            return Err(Error::invalid(place, format!("node {} has two parents; export the file again", node.index())));
        }
        let rest = rest_of(node);
        self.world_from_node.push(self.world_from_node[parent as usize] * rest.parent_from_node());
        self.hierarchy.push(shape::Node { parent: Some(parent), rest });
        Ok(index)
    }
}

fn rest_of(node: &Node<'_>) -> Transform {
    match node.transform() {
        gltf::scene::Transform::Matrix { matrix } => Transform::Fixed(affine(&matrix)),
        gltf::scene::Transform::Decomposed { translation, rotation, scale } => Transform::Parts { translation, rotation, scale },
    }
}

/// The map of a matrix by columns, whose last row glTF wants to be 0, 0, 0, 1.
pub(super) fn affine(columns: &[[f32; 4]; 4]) -> DAffine3 {
    let matrix: DMat4 = Mat4::from_cols_array_2d(columns).as_dmat4();
    DAffine3::from_mat4(matrix)
}
