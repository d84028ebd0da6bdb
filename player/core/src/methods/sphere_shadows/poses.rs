//! Shapes that deform, on the GPU: the passes that bring their vertices, shading normals and lobes to a pose, of
//! which the CPU tells where joints are and how much of each morph target is added.

use super::gpu_data::{Delta, Surrounded, Vertex};
use super::receivers::Moving;
use super::{POSE, TURN};
use crate::error::Result;
use crate::gpu::{Gpu, Passes};
use glam::DAffine3;
use relume_formats::shape::{DeformingMesh, Influences, Pose};
use relume_formats::{Error as FormatError, Place};
use wgpu::BufferUsages;

/// Vertices of a workgroup, as in the shaders.
const WORKGROUP: u32 = 64;
/// Rows of a map to world space.
type Map = [[f32; 4]; 3];

/// All shapes of a scene, and the passes that pose them.
pub(super) struct Poses {
    /// By shape, the first of its maps and of its weights.
    firsts: Vec<[u32; 2]>,
    maps: wgpu::Buffer,
    morphs: wgpu::Buffer,
    /// One after the other.
    passes: [(wgpu::ComputePipeline, wgpu::BindGroup); 2],
    workgroups: [u32; 2],
}

/// What the shaders read that no pose changes.
#[derive(Default)]
struct Tables {
    vertices: Vec<Vertex>,
    deltas: Vec<Delta>,
    surrounded: Vec<Surrounded>,
    triangles: Vec<[u32; 3]>,
    /// By shape, the first of its maps and of its weights.
    firsts: Vec<[u32; 2]>,
    /// Of all shapes.
    maps: u32,
    morphs: u32,
}

impl Poses {
    /// Of `shapes`, for the scene's positions, normals and lobes; nothing if there are none. `place` is that of the
    /// bundle's main file.
    ///
    /// # Errors
    /// If they are larger than the GPU can bind.
    pub(super) fn new(
        gpu: &Gpu,
        shapes: &[Moving],
        [positions, normals, lobes]: [&wgpu::Buffer; 3],
        place: &Place,
    ) -> Result<Option<Self>> {
        if shapes.is_empty() {
            return Ok(None);
        }
        let tables = Tables::new(gpu, shapes, place)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let maps = gpu.buffer("maps", u64::from(tables.maps) * size_of::<Map>() as u64, usage);
        let morphs = gpu.buffer("morphs", u64::from(tables.morphs) * size_of::<f32>() as u64, usage);
        let pass = |shader, entry, buffers: [&wgpu::Buffer; 5]| {
            let pipeline = gpu.compute_pipeline(shader, entry);
            let bindings =
                gpu.bind(&pipeline.get_bind_group_layout(0), buffers.map(wgpu::Buffer::as_entire_binding));
            (pipeline, bindings)
        };
        let vertices = gpu.storage("vertices", &tables.vertices);
        let deltas = gpu.storage("deltas", &tables.deltas);
        let surrounded = gpu.storage("surrounded", &tables.surrounded);
        let triangles = gpu.storage("triangles at vertices", &tables.triangles);
        let passes = [
            pass(POSE, "pose", [&vertices, &deltas, &morphs, &maps, positions]),
            pass(TURN, "turn", [&surrounded, &triangles, positions, normals, lobes]),
        ];
        let workgroups = gpu.workgroups(tables.vertices.len() as u32, WORKGROUP);
        Ok(Some(Self { firsts: tables.firsts, maps, morphs, passes, workgroups }))
    }

    /// Brings the shape of this number to `pose`, for what is submitted next.
    pub(super) fn set(&self, gpu: &Gpu, shape: usize, pose: &Pose) {
        let Some([map, morph]) = self.firsts.get(shape).map(|firsts| firsts.map(u64::from)) else { return };
        let maps: Vec<Map> = pose.world_from_mesh.iter().map(rows).collect();
        gpu.queue.write_buffer(&self.maps, map * size_of::<Map>() as u64, bytemuck::cast_slice(&maps));
        if !pose.morph_weights.is_empty() {
            let weights = bytemuck::cast_slice(&pose.morph_weights);
            gpu.queue.write_buffer(&self.morphs, morph * size_of::<f32>() as u64, weights);
        }
    }

    /// Encodes the passes.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("pose");
        let [x, y] = self.workgroups;
        for (pipeline, bindings) in &self.passes {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
    }
}

impl Tables {
    fn new(gpu: &Gpu, shapes: &[Moving], place: &Place) -> Result<Self> {
        let expect_bindable = |bytes: usize, what: &str, remedy: &str| {
            let (name, most) = (&gpu.name, gpu.binding_bytes);
            if bytes as u64 <= most {
                return Ok(());
            }
            let reason =
                format!("{bytes} bytes of {what}, GPU {name} binds at most {most}; bake with {remedy}");
            Err(FormatError::unsupported(place, reason))
        };
        let deltas = shapes.iter().flat_map(|shape| &shape.mesh.morph_targets);
        let deltas: usize = deltas.map(|target| target.vertices.len()).sum();
        expect_bindable(deltas * size_of::<Delta>(), "morph targets", "fewer morph targets")?;
        let mut tables = Self::default();
        for shape in shapes {
            tables.add(shape);
        }
        let coarser = "coarser meshes of what deforms";
        expect_bindable(size_of_val(&tables.vertices[..]), "vertices that deform", coarser)?;
        expect_bindable(size_of_val(&tables.triangles[..]), "triangles at vertices that deform", coarser)?;
        Ok(tables)
    }

    fn add(&mut self, shape: &Moving) {
        let first_vertex = shape.vertices.start as u32;
        self.add_vertices(&shape.mesh, first_vertex);
        let (surrounded, triangles) = shape.normals.by_vertex();
        let first = self.triangles.len() as u32;
        self.surrounded.extend(surrounded.into_iter().zip(first_vertex..).map(|(vertex, index)| {
            Surrounded {
                normal: vertex.normal,
                index,
                mean: vertex.mean,
                first: first + vertex.triangles.start,
                end: first + vertex.triangles.end,
                unused: [0; 3],
            }
        }));
        self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|vertex| first_vertex + vertex)));
        self.firsts.push([self.maps, self.morphs]);
        self.maps += shape.mesh.joints.len() as u32;
        self.morphs += shape.mesh.morph_targets.len() as u32;
    }

    fn add_vertices(&mut self, mesh: &DeformingMesh, first_vertex: u32) {
        // By vertex, and for each in the order of the targets.
        let mut moves: Vec<(u32, Delta)> = Vec::new();
        for (target, morph) in mesh.morph_targets.iter().zip(self.morphs..) {
            let deltas = target.vertices.iter().zip(&target.deltas);
            moves.extend(deltas.map(|(vertex, offset)| (*vertex, Delta { offset: *offset, morph })));
        }
        moves.sort_by_key(|(vertex, _)| *vertex);
        let first = self.deltas.len();
        let before = |vertex: u32| (first + moves.partition_point(|(other, _)| *other < vertex)) as u32;
        let vertices = mesh.positions.iter().zip(&mesh.influences).zip(0..);
        self.vertices.extend(vertices.map(|((position, influences), vertex)| {
            let (joints, weights) = in_order(influences, self.maps);
            Vertex {
                position: *position,
                index: first_vertex + vertex,
                joints,
                weights,
                first_delta: before(vertex),
                end_delta: before(vertex + 1),
                unused: [0; 2],
            }
        }));
        self.deltas.extend(moves.into_iter().map(|(_, delta)| delta));
    }
}

/// The joints with a weight, in their order, so that vertices with one position and the same influences, however
/// listed, stay together in single precision; numbered from `first` on.
fn in_order(influences: &Influences, first: u32) -> ([u32; 4], [f32; 4]) {
    let mut active: Vec<(u32, f32)> = influences.active().collect();
    active.sort_by_key(|(joint, _)| *joint);
    active.resize(4, (0, 0.0));
    let all: [(u32, f32); 4] = std::array::from_fn(|k| active[k]);
    (all.map(|(joint, _)| first + joint), all.map(|(_, weight)| weight))
}

fn rows(map: &DAffine3) -> Map {
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis, map.translation];
    std::array::from_fn(|row| columns.map(|column| column[row] as f32))
}
