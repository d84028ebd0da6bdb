//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};
use relume_formats::basis::suns::MAX_SUNS;
use relume_formats::state::{Brdf, Model};

/// How the environment stands.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Environment {
    pub(crate) sin_rotation: f32,
    pub(crate) cos_rotation: f32,
    /// What a stored 1 is worth.
    pub(crate) unit: f32,
    /// Texels along a side of the cube's faces.
    pub(crate) face_size: u32,
    /// Look-ups along a side of a texel of the cube.
    pub(crate) points: u32,
}

/// A band of the film as the camera sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct View {
    pub(crate) eye_in_world: [f32; 3],
    pub(crate) near: f32,
    pub(crate) forward: [f32; 3],
    pub(crate) band_middle: f32,
    pub(crate) right: [f32; 3],
    pub(crate) band_reach: f32,
    pub(crate) up: [f32; 3],
    pub(crate) first_row: f32,
    pub(crate) gain: [f32; 3],
    pub(crate) width: f32,
    pub(crate) height: f32,
    pub(crate) unused: [f32; 3],
}

/// A sun, and the box around the scene that its shadow map fills.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Sun {
    pub(crate) centre: [f32; 3],
    pub(crate) tangent: f32,
    pub(crate) right: [f32; 3],
    pub(crate) half_width: f32,
    pub(crate) up: [f32; 3],
    pub(crate) half_height: f32,
    pub(crate) towards: [f32; 3],
    pub(crate) half_depth: f32,
    pub(crate) irradiance: [f32; 3],
    pub(crate) unused: f32,
}

/// The suns that shine.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Suns {
    pub(crate) suns: [Sun; MAX_SUNS],
    pub(crate) count: u32,
    pub(crate) unused: [u32; 3],
}

/// What a mesh is drawn with.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Material {
    pub(crate) albedo: [f32; 3],
    pub(crate) alpha_cutoff: f32,
    pub(crate) wrap: [u32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) specular: [f32; 3],
    pub(crate) model: u32,
    pub(crate) f0: [f32; 3],
    pub(crate) sharpness: f32,
    pub(crate) levels: u32,
    pub(crate) nearest: u32,
    pub(crate) unused: [u32; 2],
}

impl Material {
    /// Makes it reflect as `brdf` does; its texture stays.
    pub(crate) fn set_brdf(&mut self, brdf: &Brdf) {
        self.albedo = brdf.diffuse_albedo();
        (self.specular, self.f0, self.sharpness) = match brdf {
            Brdf::BlinnPhong(brdf) => (brdf.ks, [1.0; 3], brdf.shininess),
            Brdf::Ggx(brdf) => ([1.0; 3], brdf.f0(), brdf.roughness),
            Brdf::CookTorrance(brdf) => (brdf.ks, [brdf.fresnel; 3], brdf.roughness),
        };
        // As `brdf.wgsl` numbers them.
        self.model = match brdf.model() {
            Model::BlinnPhong => 0,
            Model::Ggx => 1,
            Model::CookTorrance => 2,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::layout::{expect, layout_of};

    #[test]
    fn the_structs_have_the_shaders_layout() {
        let view = layout_of!(View { eye_in_world, near, forward, band_middle, right, band_reach, up, first_row, gain, width, height } unused);
        for shader in [super::super::ENVIRONMENT, super::super::DIFFUSE] {
            expect(shader, "View", &view);
        }
        let environment = layout_of!(Environment { sin_rotation, cos_rotation, unit, face_size, points });
        expect(super::super::ENVIRONMENT, "Environment", &environment);
        for shader in [super::super::CAST, super::super::DIFFUSE] {
            let sun = layout_of!(Sun { centre, tangent, right, half_width, up, half_height, towards, half_depth, irradiance } unused);
            expect(shader, "Sun", &sun);
            expect(shader, "Suns", &layout_of!(Suns { suns, count } unused));
        }
        let material = layout_of!(Material { albedo, alpha_cutoff, wrap, size, specular, model, f0, sharpness, levels, nearest } unused);
        for shader in [super::super::CAST, super::super::DIFFUSE] {
            expect(shader, "Material", &material);
        }
    }
}
