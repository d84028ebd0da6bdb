//! Suns: a shadow map for each, of the very vertices that the picture is drawn from, fitted to the box around
//! the scene and drawn anew only when the light turns or the shape changes.

use super::gpu_data;
use super::light::Light;
use super::mesh::{Mesh, Object};
use super::targets::DEPTH;
use super::{CAST, pipeline};
use crate::gpu::{Gpu, Passes};
use glam::Vec3;
use relume_formats::basis::suns::{MAX_SUNS, Sun};
use relume_formats::evaluate::suns::towards;
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, RenderPipeline, TextureView};

/// Texels along a side of a shadow map.
const SIDE: u32 = 2048;

/// A box along the axes of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    centre: Vec3,
    /// Half its size.
    reach: Vec3,
}

/// The suns of the light that shines.
pub(super) struct Suns {
    bounds: Bounds,
    /// With the rotation of their map, degrees.
    shining: Vec<(Sun, f32)>,
    uniform: Buffer,
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

impl Bounds {
    /// The smallest around all `points`.
    pub(crate) fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let (low, high) = points
            .into_iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        if low.cmpgt(high).any() {
            return Self { centre: Vec3::ZERO, reach: Vec3::ZERO };
        }
        Self { centre: 0.5 * low + 0.5 * high, reach: 0.5 * high - 0.5 * low }
    }

    /// Half of its extent along a unit vector.
    fn along(&self, axis: Vec3) -> f32 {
        axis.abs().dot(self.reach)
    }

    /// `sun` with the box around this one that is seen from it; nothing of this box is beyond its edge.
    fn seen_from(&self, sun: &Sun, rotation_deg: f32) -> gpu_data::Sun {
        let towards = towards(sun, rotation_deg);
        let level = if towards.y.abs() > 0.999 { Vec3::X } else { Vec3::Y };
        let right = level.cross(towards).normalize();
        let up = towards.cross(right);
        // What filters the edge looks some texels beyond it. A scene without extent has a box all the same.
        let least = self.reach.max_element().max(f32::MIN_POSITIVE) * 1e-3;
        let margin = 1.0 + 8.0 / SIDE as f32;
        let half = |axis: Vec3| self.along(axis).max(least) * margin;
        gpu_data::Sun {
            centre: self.centre.to_array(),
            tangent: sun.radius.tan(),
            right: right.to_array(),
            half_width: half(right),
            up: up.to_array(),
            half_height: half(up),
            towards: towards.to_array(),
            half_depth: half(towards),
            irradiance: sun.irradiance,
            unused: 0.0,
        }
    }
}

impl Suns {
    /// None that shine yet, for surfaces of `mesh` that `surface` draws.
    pub(super) fn new(gpu: &Gpu, mesh: &Mesh, bounds: Bounds, surface: &RenderPipeline) -> Self {
        let uniform_usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let uniform = gpu.buffer("suns", size_of::<gpu_data::Suns>() as u64, uniform_usage);
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
            bounds,
            shining: Vec::with_capacity(MAX_SUNS),
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
        self.shining.clear();
        self.shining.extend(light.suns().take(MAX_SUNS));
        if self.shining.len() > self.layers.len() {
            let (all, layers) = gpu.layers("shadows", SIDE, self.shining.len() as u32, DEPTH);
            self.layers = layers;
            self.bindings = bindings(gpu, &self.surface, &self.uniform, &all);
        }
        self.fit(gpu);
    }

    /// The box around the scene is now `bounds`.
    pub(super) fn set_bounds(&mut self, gpu: &Gpu, bounds: Bounds) {
        self.bounds = bounds;
        self.fit(gpu);
    }

    fn fit(&mut self, gpu: &Gpu) {
        let mut suns = gpu_data::Suns { count: self.shining.len() as u32, ..bytemuck::Zeroable::zeroed() };
        for (place, (sun, rotation_deg)) in suns.suns.iter_mut().zip(&self.shining) {
            *place = self.bounds.seen_from(sun, *rotation_deg);
        }
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&suns));
        self.changed = true;
    }

    /// Encodes the passes that draw the shadow maps, if anything has changed.
    pub(super) fn encode(&mut self, mesh: &Mesh, passes: &mut Passes<'_>) {
        if !std::mem::take(&mut self.changed) {
            return;
        }
        for (layer, [solid, cut]) in self.layers.iter().zip(&self.casters).take(self.shining.len()) {
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

fn bindings(gpu: &Gpu, surface: &RenderPipeline, uniform: &Buffer, shadows: &TextureView) -> BindGroup {
    let resources = [uniform.as_entire_binding(), BindingResource::TextureView(shadows)];
    gpu.bind(&surface.get_bind_group_layout(2), resources)
}

/// Both sides cast shadows.
fn caster_pipeline(gpu: &Gpu, fragment: Option<&'static str>) -> RenderPipeline {
    let [position, uv] = [
        pipeline::vertices(0, wgpu::VertexFormat::Float32x3),
        pipeline::vertices(1, wgpu::VertexFormat::Float32x2),
    ];
    let buffers = [pipeline::buffer(&position), pipeline::buffer(&uv)];
    pipeline::new(gpu, CAST, ("caster", fragment), &buffers, &[], wgpu::CompareFunction::Greater)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_seen_from_a_sun_holds_all_corners() {
        let points = [Vec3::new(-1.0, 2.0, 5.0), Vec3::new(3.0, 2.5, 5.5), Vec3::new(0.0, 2.2, 9.0)];
        let bounds = Bounds::of(points);
        for direction in
            [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.48, -0.64), Vec3::new(0.0, 0.9999, 0.0141)]
        {
            let sun = Sun { direction: direction.normalize(), radius: 0.01, irradiance: [1.0; 3] };
            for rotation_deg in [0.0, 33.0, 270.0] {
                let seen = bounds.seen_from(&sun, rotation_deg);
                let axes = [seen.right, seen.up, seen.towards].map(Vec3::from);
                let right_handed = axes[0].cross(axes[1]).dot(axes[2]);
                assert!((right_handed - 1.0).abs() < 1e-5 && axes.iter().all(|a| a.is_normalized()));
                for corner in 0..8 {
                    let side = |k: u32| if corner >> k & 1 == 0 { -1.0 } else { 1.0 };
                    let way = bounds.reach * Vec3::new(side(0), side(1), side(2));
                    let half = [seen.half_width, seen.half_height, seen.half_depth];
                    assert!(axes.iter().zip(half).all(|(axis, half)| way.dot(*axis).abs() <= half));
                }
            }
        }
    }

    #[test]
    fn scenes_without_extent_have_a_box() {
        for bounds in [Bounds::of([]), Bounds::of([Vec3::splat(7.0)])] {
            let sun = Sun { direction: Vec3::Y, radius: 0.01, irradiance: [1.0; 3] };
            let seen = bounds.seen_from(&sun, 0.0);
            assert!([seen.half_width, seen.half_height, seen.half_depth].iter().all(|half| *half > 0.0));
        }
    }
}
