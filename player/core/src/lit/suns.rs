//! Suns: a shadow map for each, of the very vertices that the picture is drawn from, fitted by the GPU to the box
//! around them and drawn anew only when the light turns or the shape changes.

use super::gpu_data;
use super::light::Light;
use super::mesh::{Mesh, Object};
use super::targets::DEPTH;
use super::{CAST, EXTENT, pipeline};
use crate::gpu::{Gpu, Passes};
use glam::Vec3;
use relume_formats::basis::suns::{MAX_SUNS, Sun};
use relume_formats::evaluate::suns::towards;
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, RenderPipeline, TextureView};

/// Texels along a side of a shadow map, as in the shader that fits them.
const SIDE: u32 = 2048;
/// Vertices of a workgroup that measures, as in the shader.
const WORKGROUP: u32 = 64;

/// The suns of the light that shines.
pub(super) struct Suns {
    /// How many shine.
    shining: usize,
    uniform: Buffer,
    extent: Extent,
    surface: RenderPipeline,
    /// As many layers as any light so far has had suns.
    layers: Vec<TextureView>,
    /// What surfaces are drawn with.
    pub(super) bindings: BindGroup,
    solid: RenderPipeline,
    cut: RenderPipeline,
    /// By sun: what either pipeline draws it with.
    casters: Vec<[BindGroup; 2]>,
    /// By material: what cuts holes into it.
    holes: Vec<Option<BindGroup>>,
    changed: bool,
}

/// What measures the box around the vertices, and what fits suns to it.
struct Extent([(wgpu::ComputePipeline, BindGroup, [u32; 2]); 2]);

impl Suns {
    /// None that shine yet, for surfaces of `mesh` that `surface` draws.
    pub(super) fn new(gpu: &Gpu, mesh: &Mesh, surface: &RenderPipeline) -> Self {
        let uniform_usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let fitted_usage = uniform_usage | BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let uniform = gpu.buffer("suns", size_of::<gpu_data::Suns>() as u64, fitted_usage);
        let [solid, cut] = [None, Some("cut")].map(|fragment| caster_pipeline(gpu, fragment));
        let caster = |number: u32| {
            let which = gpu.buffer("sun", size_of::<u32>() as u64, uniform_usage);
            gpu.write(&which, 0, bytemuck::bytes_of(&number));
            let solid_bindings = [&uniform, &which].map(Buffer::as_entire_binding);
            let cut_bindings = [&uniform, &which, &mesh.materials].map(Buffer::as_entire_binding);
            [
                gpu.bind(&solid.get_bind_group_layout(0), solid_bindings),
                gpu.bind(&cut.get_bind_group_layout(0), cut_bindings),
            ]
        };
        let hole = |(texture, cuts): (&TextureView, &bool)| {
            let texture = [BindingResource::TextureView(texture)];
            cuts.then(|| gpu.bind(&cut.get_bind_group_layout(1), texture))
        };
        let nothing = gpu.layers("no shadows", 1, 1, DEPTH).0;
        Self {
            shining: 0,
            extent: Extent::new(gpu, &mesh.positions, &uniform),
            bindings: bindings(gpu, surface, &uniform, &nothing),
            surface: surface.clone(),
            layers: Vec::new(),
            casters: (0..MAX_SUNS as u32).map(caster).collect(),
            holes: mesh.textures.iter().zip(&mesh.cuts).map(hole).collect(),
            uniform,
            solid,
            cut,
            changed: false,
        }
    }

    /// Lets the suns of `light` shine, as it stands.
    pub(super) fn set_light(&mut self, gpu: &Gpu, light: &Light) {
        let mut suns: gpu_data::Suns = bytemuck::Zeroable::zeroed();
        self.shining = 0;
        for (place, (sun, rotation_deg)) in suns.suns.iter_mut().zip(light.suns()) {
            *place = facing(&sun, rotation_deg);
            self.shining += 1;
        }
        suns.count = self.shining as u32;
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&suns));
        if self.shining > self.layers.len() {
            let (all, layers) = gpu.layers("shadows", SIDE, self.shining as u32, DEPTH);
            self.layers = layers;
            self.bindings = bindings(gpu, &self.surface, &self.uniform, &all);
        }
        self.changed = true;
    }

    /// Vertices move in the next frame.
    pub(super) fn vertices_move(&mut self) {
        self.changed = true;
    }

    /// Encodes the passes that draw the shadow maps, if anything has changed.
    pub(super) fn encode(&mut self, mesh: &Mesh, passes: &mut Passes<'_>) {
        if !std::mem::take(&mut self.changed) || self.shining == 0 {
            return;
        }
        self.extent.encode(passes);
        for (layer, [solid, cut]) in self.layers.iter().zip(&self.casters).take(self.shining) {
            let mut pass = passes.draw_depth("shadows", layer);
            for (slot, buffer) in (0..).zip([&mesh.positions, &mesh.uvs]) {
                pass.set_vertex_buffer(slot, buffer.slice(..));
            }
            pass.set_index_buffer(mesh.triangles.slice(..), wgpu::IndexFormat::Uint32);
            for Object { indices, material } in &mesh.objects {
                match self.holes.get(*material as usize) {
                    Some(Some(texture)) => {
                        pass.set_pipeline(&self.cut);
                        pass.set_bind_group(0, cut, &[]);
                        pass.set_bind_group(1, texture, &[]);
                    }
                    _ => {
                        pass.set_pipeline(&self.solid);
                        pass.set_bind_group(0, solid, &[]);
                    }
                }
                pass.draw_indexed(indices.clone(), 0, *material..*material + 1);
            }
        }
    }
}

impl Extent {
    /// Of vertices at `positions`; `suns` is what is fitted.
    fn new(gpu: &Gpu, positions: &Buffer, suns: &Buffer) -> Self {
        let keys = gpu.buffer("extent", 6 * size_of::<u32>() as u64, BufferUsages::STORAGE);
        let vertices = positions.size() / size_of::<[f32; 3]>() as u64;
        let pass = |entry, bound: [(u32, &Buffer); 2], workgroups| {
            let pipeline = gpu.compute_pipeline(EXTENT, entry);
            let bound = bound.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
            let bindings = gpu.bind_at(&pipeline.get_bind_group_layout(0), bound);
            (pipeline, bindings, workgroups)
        };
        Self([
            pass("measure", [(0, positions), (1, &keys)], gpu.workgroups(vertices as u32, WORKGROUP)),
            pass("fit", [(1, &keys), (2, suns)], [1, 1]),
        ])
    }

    fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("extent");
        for (pipeline, bindings, [x, y]) in &self.0 {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }
}

fn bindings(gpu: &Gpu, surface: &RenderPipeline, uniform: &Buffer, shadows: &TextureView) -> BindGroup {
    let resources = [uniform.as_entire_binding(), BindingResource::TextureView(shadows)];
    gpu.bind(&surface.get_bind_group_layout(2), resources)
}

/// Both sides cast shadows.
fn caster_pipeline(gpu: &Gpu, fragment: Option<&'static str>) -> RenderPipeline {
    let [position, uv] = [
        pipeline::vertices(0, &[wgpu::VertexFormat::Float32x3]),
        pipeline::vertices(1, &[wgpu::VertexFormat::Float32x2]),
    ];
    let buffers = [pipeline::buffer(&position), pipeline::buffer(&uv)];
    pipeline::new(gpu, CAST, ("caster", fragment), &buffers, &[], wgpu::CompareFunction::Greater)
}

/// `sun` and the axes of the box that is seen from it; how large that is the GPU finds.
fn facing(sun: &Sun, rotation_deg: f32) -> gpu_data::Sun {
    let towards = towards(sun, rotation_deg);
    let level = if towards.y.abs() > 0.999 { Vec3::X } else { Vec3::Y };
    let right = level.cross(towards).normalize();
    gpu_data::Sun {
        tangent: sun.radius.tan(),
        right: right.to_array(),
        up: towards.cross(right).to_array(),
        towards: towards.to_array(),
        irradiance: sun.irradiance,
        ..bytemuck::Zeroable::zeroed()
    }
}

#[cfg(test)]
mod tests;
