//! The hierarchy of a glTF scene: every node in the world, parents before children.

use super::tidy_name;
use crate::numbering::{Names, listed};
use crate::suggest::unknown_name;
use glam::{DAffine3, DMat4, Mat4};
use gltf::{Document, Node};
use relume_formats::shape::{self, Transform};
use relume_formats::{Error, Place, Result};
use std::collections::HashSet;

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
    /// The nodes of the default scene of `document`, of which only the subtree of the node called `wanted`,
    /// if given, is wanted. Adds what is mended to `warnings`.
    pub(super) fn new(
        document: &'a Document,
        wanted: Option<&str>,
        world_from_file: &DAffine3,
        place: &Place,
        warnings: &mut Vec<String>,
    ) -> Result<Self> {
        let mut placement = Self {
            wanted: Vec::new(),
            hierarchy: vec![shape::Node { parent: None, rest: Transform::Fixed(*world_from_file) }],
            world_from_node: vec![*world_from_file],
            index_of: vec![None; document.nodes().len()],
        };
        let wanted = wanted.map(tidy_name);
        let mut names = NodeNames {
            wanted: wanted.as_deref(),
            names: Names::default(),
            all: Vec::new(),
            others: Vec::new(),
        };
        let mut stack: Vec<_> =
            roots(document, place, warnings).into_iter().map(|node| (node, 0, wanted.is_none())).collect();
        stack.reverse();
        while let Some((node, parent, parent_inside)) = stack.pop() {
            let index = placement.add(&node, parent, place)?;
            let inside = names.is_wanted(&node) || parent_inside;
            let children: Vec<_> = node.children().map(|child| (child, index, inside)).collect();
            stack.extend(children.into_iter().rev());
            if inside {
                placement.wanted.push((node, placement.world_from_node[index as usize]));
            }
        }
        let NodeNames { all, others, .. } = names;
        match wanted {
            Some(name) if placement.wanted.is_empty() => {
                Err(Error::invalid(place, unknown_name("node", &name, all.iter().map(String::as_str))))
            }
            Some(name) if !others.is_empty() => {
                let what = format!(
                    "{} nodes are called `{name}`; took the first, the others are {}",
                    others.len() + 1,
                    listed(&others)
                );
                warnings.push(format!("{place}: {what}"));
                Ok(placement)
            }
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
        if let Some(known) = self.index_of(node.index()) {
            let fault = self.fault(known, parent);
            return Err(Error::invalid(
                place,
                format!("node {} {fault}; export the file again", node.index()),
            ));
        }
        if let Some(slot) = self.index_of.get_mut(node.index()) {
            *slot = Some(index);
        }
        let rest = rest_of(node);
        self.world_from_node.push(self.world_from_node[parent as usize] * rest.parent_from_node());
        self.hierarchy.push(shape::Node { parent: Some(parent), rest });
        Ok(index)
    }

    /// What is wrong with a node that is in the hierarchy as `known` and should be below `parent` too.
    fn fault(&self, known: u32, parent: u32) -> &'static str {
        let parent_of = |index: u32| self.hierarchy.get(index as usize).and_then(|node| node.parent);
        if std::iter::successors(Some(parent), |index| parent_of(*index)).any(|ancestor| ancestor == known) {
            "is below itself"
        } else if parent_of(known) == Some(parent) {
            "is listed twice by its parent"
        } else if parent == 0 || parent_of(known) == Some(0) {
            "is both a root of the scene and below another node"
        } else {
            "has two parents"
        }
    }
}

/// The nodes without parents in the scene to show: the default one, or the first. A file without a scene, or
/// whose scene is empty, shows all its nodes.
fn roots<'a>(document: &'a Document, place: &Place, warnings: &mut Vec<String>) -> Vec<Node<'a>> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let mut known = HashSet::new();
    let (roots, again): (Vec<_>, Vec<_>) =
        scene.iter().flat_map(|scene| scene.nodes()).partition(|node| known.insert(node.index()));
    if let Some(node) = again.first() {
        warnings.push(format!("{place}: its scene lists node {} more than once; took it once", node.index()));
    }
    if !roots.is_empty() || document.nodes().len() == 0 {
        return roots;
    }
    if scene.is_some() {
        warnings.push(format!("{place}: its default scene is empty; took all nodes of the file"));
    }
    let children: HashSet<usize> =
        document.nodes().flat_map(|node| node.children()).map(|child| child.index()).collect();
    document.nodes().filter(|node| !children.contains(&node.index())).collect()
}

/// Which node is meant by a name: the first so called, or, by a number after its name, a later one.
struct NodeNames<'a> {
    wanted: Option<&'a str>,
    names: Names,
    all: Vec<String>,
    /// Names of further nodes that are called so.
    others: Vec<String>,
}

impl NodeNames<'_> {
    /// Whether `node`, the next in the order of the hierarchy, is the one.
    fn is_wanted(&mut self, node: &Node<'_>) -> bool {
        let Some((wanted, given)) = self.wanted.zip(node.name()) else { return false };
        let given = tidy_name(given);
        let name = self.names.take(&given);
        let found = name == wanted;
        if given == wanted && !found {
            self.others.push(name.clone());
        }
        self.all.push(name);
        found
    }
}

fn rest_of(node: &Node<'_>) -> Transform {
    match node.transform() {
        gltf::scene::Transform::Matrix { matrix } => Transform::Fixed(affine(&matrix)),
        gltf::scene::Transform::Decomposed { translation, rotation, scale } => {
            Transform::Parts { translation, rotation, scale }
        }
    }
}

/// The map of a matrix by columns, whose last row glTF wants to be 0, 0, 0, 1.
pub(super) fn affine(columns: &[[f32; 4]; 4]) -> DAffine3 {
    let matrix: DMat4 = Mat4::from_cols_array_2d(columns).as_dmat4();
    DAffine3::from_mat4(matrix)
}
