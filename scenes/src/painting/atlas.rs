//! Texture coordinates for surfaces that have none that serve.

use super::{CELLS, Corners};
use crate::scene::Mesh;
use relume_formats::{Error, Place, Result};
use uvunwrap::{Atlas, Density, MeshInput, Options, OutputMesh, Progress, Stage};

/// Texels around charts at [`CELLS`] a side. A region is 32 of them.
const PADDING: u32 = 2;

/// The coordinates of all triangles of `meshes`, within one square; `None` if one of the calls of `goes_on`, which are
/// told how many are laid out, says no.
///
/// # Errors
/// `Invalid` if the library finds none.
pub(super) fn make(
    meshes: &[&Mesh],
    goes_on: &(impl Fn(usize) -> bool + Sync),
    place: &Place,
) -> Result<Option<Vec<Vec<Corners>>>> {
    let indices: Vec<&[u32]> = meshes.iter().map(|mesh| mesh.triangles.as_flattened()).collect();
    let inputs: Vec<MeshInput<'_>> =
        meshes.iter().zip(indices).map(|(mesh, indices)| MeshInput::new(&mesh.positions, indices)).collect();
    let options =
        Options { density: Density::Auto { page_size: CELLS }, padding: PADDING, ..Options::default() };
    let all = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let report = |Progress { stage, done, .. }: Progress| {
        goes_on(match stage {
            Stage::Segmenting => 0,
            Stage::Parameterizing => done,
            _ => all,
        })
    };
    let atlas = match uvunwrap::generate_with_progress(&inputs, &options, report) {
        Ok(atlas) => atlas,
        Err(uvunwrap::Error::Cancelled) => return Ok(None),
        Err(error) => return Err(refuse(place, &format!("no atlas can be made of what wears it ({error})"))),
    };
    if atlas.page_count != 1 {
        return Err(refuse(place, "what wears it falls into too many pieces for an atlas"));
    }
    Ok(Some(atlas.meshes.iter().map(|mesh| corners(mesh, &atlas)).collect()))
}

fn refuse(place: &Place, reason: &str) -> Error {
    Error::invalid(place, format!("{reason}; give its meshes texture coordinates that do not overlap"))
}

/// Coordinates of the triangles of a mesh, both axes to one scale.
fn corners(mesh: &OutputMesh, atlas: &Atlas) -> Vec<Corners> {
    let larger = atlas.width.max(atlas.height) as f32;
    let [u, v] = [atlas.width, atlas.height].map(|side| side as f32 / larger);
    let at = |index: u32| {
        let uv = mesh.vertices.get(index as usize).map_or([0.0; 2], |vertex| vertex.uv);
        [uv[0] * u, uv[1] * v]
    };
    mesh.indices.as_chunks::<3>().0.iter().map(|triangle| triangle.map(at)).collect()
}
