//! How surfaces look, given what is known of their vertices.

use super::DIFFUSE;
use wgpu::{BindingResource, Buffer, TextureView};

/// What draws surfaces.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    /// WGSL that imports `surface`, with entry points `corner` and `surface`. Its corners have place, texture
    /// coordinates and normal at locations 0, 1 and 2.
    pub(crate) shader: &'static str,
    /// What it takes of each vertex besides, from location 3 on: buffers of so many times four floats.
    pub(crate) vertices: Vec<(Buffer, usize)>,
    /// What it takes of all, by number of the binding in group 0.
    pub(crate) bound: Vec<(u32, Bound)>,
    /// By material what it takes of it, by number of the binding in group 1.
    pub(crate) of_materials: Vec<Vec<(u32, Bound)>>,
}

/// What a shader takes.
#[derive(Debug, Clone)]
pub(crate) enum Bound {
    /// A buffer, all of it.
    Buffer(Buffer),
    /// A texture.
    Texture(TextureView),
}

impl Bound {
    pub(crate) fn resource(&self) -> BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(view) => BindingResource::TextureView(view),
        }
    }
}

impl Surface {
    /// Surfaces that reflect alike in all directions: `radiance` is by vertex what white ones would show of all light
    /// but the suns, W/(sr·m²) before the gain, four floats of which the last is unused.
    pub(crate) fn diffuse(radiance: &Buffer) -> Self {
        let vertices = vec![(radiance.clone(), 1)];
        Self { shader: DIFFUSE, vertices, bound: Vec::new(), of_materials: Vec::new() }
    }
}
