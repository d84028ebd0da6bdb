//! How render pipelines of meshes and maps are made.

use super::targets::DEPTH;
use crate::gpu::Gpu;
use wgpu::{
    ColorTargetState, CompareFunction, RenderPipeline, VertexAttribute, VertexBufferLayout, VertexFormat,
    VertexStepMode,
};

/// The attributes of a vertex buffer, from number `location` on, that has nothing else.
pub(super) fn vertices(location: u32, formats: &[VertexFormat]) -> Vec<VertexAttribute> {
    let mut offset = 0;
    let attribute = |(shader_location, format): (u32, &VertexFormat)| {
        let attribute = VertexAttribute { format: *format, offset, shader_location };
        offset += format.size();
        attribute
    };
    (location..).zip(formats).map(attribute).collect()
}

/// The buffer of such attributes.
pub(super) fn buffer(attributes: &[VertexAttribute]) -> Option<VertexBufferLayout<'_>> {
    let array_stride = attributes.iter().map(|attribute| attribute.format.size()).sum();
    Some(VertexBufferLayout { array_stride, step_mode: VertexStepMode::Vertex, attributes })
}

/// A pipeline of entry points of `shader`, drawing on depth too, and on depth alone if no fragments are shaded
/// or none have a colour. Its bindings follow from what it uses.
pub(super) fn new(
    gpu: &Gpu,
    shader: &str,
    (vertex, fragment): (&'static str, Option<&'static str>),
    buffers: &[Option<VertexBufferLayout<'_>>],
    targets: &[Option<ColorTargetState>],
    compare: CompareFunction,
) -> RenderPipeline {
    let label = fragment.unwrap_or(vertex);
    let module = gpu.shader(label, shader);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: fragment.map(|entry_point| wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
