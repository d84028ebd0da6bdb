//! Meshes as binary little-endian PLY.

use std::fmt::Write as _;

/// What [`PlyMesh::comment`] says of meshes of a scene.
pub const WORLD_SPACE: &str = "metres, world space, right-handed, +Y up";

/// A triangle mesh.
pub struct PlyMesh<'a> {
    /// Units and space.
    pub comment: &'a str,
    pub positions: &'a [[f32; 3]],
    /// Unit normals, one for each position.
    pub normals: &'a [[f32; 3]],
    /// sRGB colours, one for each position, or none.
    pub colours: Option<&'a [[u8; 3]]>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: &'a [[u32; 3]],
    /// Names of integer properties of faces, and for every triangle their values.
    pub labels: Option<([&'static str; 2], &'a [[u32; 2]])>,
}

impl PlyMesh<'_> {
    /// The whole file.
    pub fn encode(&self) -> Vec<u8> {
        let mut file = self.header().into_bytes();
        for (index, (position, normal)) in self.positions.iter().zip(self.normals).enumerate() {
            position.iter().chain(normal).for_each(|v| file.extend(v.to_le_bytes()));
            file.extend(self.colours.and_then(|colours| colours.get(index)).into_iter().flatten());
        }
        for (index, triangle) in self.triangles.iter().enumerate() {
            file.push(3);
            let labels = self.labels.and_then(|(_, labels)| labels.get(index));
            triangle.iter().chain(labels.into_iter().flatten()).for_each(|v| file.extend(v.to_le_bytes()));
        }
        file
    }

    fn header(&self) -> String {
        let mut text = format!("ply\nformat binary_little_endian 1.0\ncomment {}\n", self.comment);
        let _ = writeln!(text, "element vertex {}", self.positions.len());
        ["x", "y", "z", "nx", "ny", "nz"].iter().for_each(|name| text += &format!("property float {name}\n"));
        let channels: &[&str] = if self.colours.is_some() { &["red", "green", "blue"] } else { &[] };
        channels.iter().for_each(|name| text += &format!("property uchar {name}\n"));
        // Indices fit the signed integers that readers expect: a section holds at most 2^25 of them.
        let _ =
            writeln!(text, "element face {}\nproperty list uchar int vertex_indices", self.triangles.len());
        self.labels
            .iter()
            .flat_map(|(names, _)| names)
            .for_each(|name| text += &format!("property int {name}\n"));
        text + "end_header\n"
    }
}
