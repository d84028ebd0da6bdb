//! Kind `shape`, version 0: one [`DeformingMesh`], a mesh that clips move; what it means stands in [`crate::shape`].
//!
//! | section           | type | shape         | content |
//! |-------------------|------|---------------|---------|
//! | `nodes`           | u8   | record        | the forest of nodes: parent, transform at rest |
//! | `joints`          | u8   | record        | node and inverse bind matrix of each |
//! | `clips`           | u8   | record        | name, duration and tracks of each; a track says how many keys it has |
//! | `positions`       | f32  | [vertices, 3] | before morphing and skinning |
//! | `joint-indices`   | u32  | [vertices, 4] | the joints that a vertex follows |
//! | `joint-weights`   | f32  | [vertices, 4] | and their shares: at least 0, sum 1 |
//! | `target-weights`  | f32  | [targets]     | of the morph targets, at rest |
//! | `target-sizes`    | u32  | [targets]     | how many vertices each of them moves |
//! | `target-vertices` | u32  | [moved]       | which, target after target, increasing in each |
//! | `target-deltas`   | f32  | [moved, 3]    | and how far |
//! | `key-times`       | f32  | [keys]        | seconds, clip after clip, track after track |
//! | `key-values`      | f32  | [values]      | of the keys, in the same order, as [`crate::shape::Track::values`] has them |
//!
//! Records hold matrices in f64, for every factor of a long chain of nodes counts. Triangles are those of the object in kind `scene`, and so are normals.

mod records;

use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::{Error, Result};
use crate::shape::{
    DeformingMesh, Influences, MAX_CLIP_KEYS, MAX_JOINTS, MAX_MORPHED, MAX_VERTICES, MorphTarget,
};
use records::{ClipRecord, JointRecord, NodeRecord};

impl Stored for DeformingMesh {
    const KIND: Kind = Kind::Shape;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let vertices = self.positions.len() as u64;
        out.record("nodes", &self.nodes.iter().map(NodeRecord::of).collect::<Vec<_>>())?;
        out.record("joints", &self.joints.iter().map(JointRecord::of).collect::<Vec<_>>())?;
        out.record("clips", &self.clips.iter().map(ClipRecord::of).collect::<Vec<_>>())?;
        out.f32s("positions", &[vertices, 3], self.positions.as_flattened())?;
        let (joints, weights): (Vec<_>, Vec<_>) =
            self.influences.iter().map(|i| (i.joints, i.weights)).unzip();
        out.u32s("joint-indices", &[vertices, 4], joints.as_flattened())?;
        out.f32s("joint-weights", &[vertices, 4], weights.as_flattened())?;
        encode_targets(&self.morph_targets, out)?;
        let tracks = || self.clips.iter().flat_map(|clip| &clip.tracks);
        let times_s: Vec<f32> = tracks().flat_map(|track| track.times_s.iter().copied()).collect();
        let values: Vec<f32> = tracks().flat_map(|track| track.values.iter().copied()).collect();
        out.f32s("key-times", &[times_s.len() as u64], &times_s)?;
        out.f32s("key-values", &[values.len() as u64], &values)
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let nodes: Vec<NodeRecord> = sections.take("nodes")?.record()?;
        let joints: Vec<JointRecord> = sections.take("joints")?.record()?;
        let clips: Vec<ClipRecord> = sections.take("clips")?.record()?;
        let positions: Vec<[f32; 3]> = f32_rows(&sections.take("positions")?, None, MAX_VERTICES)?;
        let influences = decode_influences(sections, positions.len())?;
        let morph_targets = decode_targets(sections)?;
        let (times_s, values) = decode_keys(sections)?;
        let mesh = Self {
            positions,
            influences,
            joints: joints.into_iter().map(JointRecord::joint).collect(),
            nodes: nodes.into_iter().map(NodeRecord::node).collect(),
            morph_targets,
            clips: records::clips(clips, &times_s, &values, &sections.place)?,
        };
        match mesh.fault() {
            None => Ok(mesh),
            Some(fault) => {
                Err(Error::invalid(&sections.place, format!("{fault}; the file is damaged, bake it again")))
            }
        }
    }
}

fn encode_targets(targets: &[MorphTarget], out: &mut Writer) -> Result<()> {
    let count = targets.len() as u64;
    let weights: Vec<f32> = targets.iter().map(|target| target.rest_weight).collect();
    let sizes: Vec<u32> = targets.iter().map(|target| target.vertices.len() as u32).collect();
    let vertices: Vec<u32> = targets.iter().flat_map(|target| target.vertices.iter().copied()).collect();
    let deltas: Vec<[f32; 3]> = targets.iter().flat_map(|target| target.deltas.iter().copied()).collect();
    out.f32s("target-weights", &[count], &weights)?;
    out.u32s("target-sizes", &[count], &sizes)?;
    out.u32s("target-vertices", &[vertices.len() as u64], &vertices)?;
    out.f32s("target-deltas", &[deltas.len() as u64, 3], deltas.as_flattened())
}

fn decode_influences(sections: &mut Sections<'_>, vertices: usize) -> Result<Vec<Influences>> {
    let section = sections.take("joint-indices")?;
    section.expect_shape(&[vertices as u64, 4])?;
    let joints = section.u32s()?;
    let weights: Vec<[f32; 4]> = f32_rows(&sections.take("joint-weights")?, Some(vertices), MAX_VERTICES)?;
    Ok(joints
        .as_chunks()
        .0
        .iter()
        .zip(weights)
        .map(|(joints, weights)| Influences { joints: *joints, weights })
        .collect())
}

fn decode_targets(sections: &mut Sections<'_>) -> Result<Vec<MorphTarget>> {
    let section = sections.take("target-weights")?;
    let weights = section.f32s()?;
    expect_list(&section, None, MAX_JOINTS)?;
    let section = sections.take("target-sizes")?;
    expect_list(&section, Some(weights.len()), MAX_JOINTS)?;
    let (sizes, sizes_section) = (section.u32s()?, section);
    let section = sections.take("target-vertices")?;
    expect_list(&section, None, MAX_MORPHED)?;
    let vertices = section.u32s()?;
    let deltas: Vec<[f32; 3]> =
        f32_rows(&sections.take("target-deltas")?, Some(vertices.len()), MAX_MORPHED)?;
    if sizes.iter().map(|size| u64::from(*size)).sum::<u64>() != vertices.len() as u64 {
        return Err(
            sizes_section.invalid(format!("does not sum to the {} vertices that are moved", vertices.len()))
        );
    }
    let mut start = 0;
    let mut target = |(rest_weight, size): (f32, u32)| {
        let range = start..start + size as usize;
        start = range.end;
        let of = |range| {
            Some((vertices.get(std::ops::Range::clone(&range))?.to_vec(), deltas.get(range)?.to_vec()))
        };
        let (vertices, deltas) = of(range).unwrap_or_default();
        MorphTarget { rest_weight, vertices, deltas }
    };
    Ok(weights.into_iter().zip(sizes).map(&mut target).collect())
}

/// Times and values of all keys.
fn decode_keys(sections: &mut Sections<'_>) -> Result<(Vec<f32>, Vec<f32>)> {
    let section = sections.take("key-times")?;
    expect_list(&section, None, MAX_CLIP_KEYS)?;
    let times_s = section.f32s()?;
    let section = sections.take("key-values")?;
    // A rotation with tangents has the most numbers.
    expect_list(&section, None, 12 * MAX_CLIP_KEYS)?;
    Ok((times_s, section.f32s()?))
}

/// Fails unless the section has one dimension: `count` where that is known, else at most `most`.
fn expect_list(section: &Section, count: Option<usize>, most: usize) -> Result<()> {
    expect_rows(section, section.length()?, count, most)
}

fn expect_rows(section: &Section, rows: u64, count: Option<usize>, most: usize) -> Result<()> {
    match count {
        Some(count) if rows != count as u64 => {
            Err(section.invalid(format!("has {rows} rows, expected {count}")))
        }
        _ if rows > most as u64 => {
            Err(section.invalid(format!("has {rows} rows, at most {most} are allowed")))
        }
        _ => Ok(()),
    }
}

/// Rows of `N` numbers, checked like [`expect_list`]; whether they are finite is for
/// [`DeformingMesh::validate`] to say.
fn f32_rows<const N: usize>(section: &Section, count: Option<usize>, most: usize) -> Result<Vec<[f32; N]>> {
    match section.info.shape[..] {
        [rows, columns] if columns == N as u64 => expect_rows(section, rows, count, most)?,
        _ => return Err(section.invalid(format!("has shape {:?}, expected rows of {N}", section.info.shape))),
    }
    Ok(section.f32s()?.as_chunks().0.to_vec())
}
