//! The light: environment maps, and the Haar coefficients of the one that shines.

use super::gpu_data;
use super::{ENVIRONMENT, HAAR};
use crate::gpu::{Gpu, Passes};
use half::f16;
use relume_formats::basis::cubemap::{FACES, subsamples};
use relume_formats::basis::suns::{Split, Sun, split};
use relume_formats::kinds::Environment;
use relume_formats::kinds::scene::EnvironmentLook;
use std::borrow::Cow;
use wgpu::BufferUsages;

/// Invocations that resample one texel of the cube, and those of a workgroup, as in the shader.
const TEAM: u32 = 16;
const WORKGROUP: u32 = 64;

/// An environment map on the GPU.
pub(crate) struct Map {
    /// Its name.
    pub(crate) name: String,
    /// Its texels.
    pub(crate) texels: wgpu::TextureView,
    /// The same without its suns.
    rest: wgpu::TextureView,
    suns: Vec<Sun>,
    width: u32,
    /// What a stored 1 is worth.
    unit: f32,
}

/// The light that shines.
pub(crate) struct Light {
    maps: Vec<Map>,
    face_size: u32,
    /// Of one cube, or of two.
    faces_of_all: u32,
    /// Index of the map and rotation that the coefficients are of.
    shines: Option<(usize, f32)>,
    uniform: wgpu::Buffer,
    coefficients: wgpu::Buffer,
    resample: wgpu::ComputePipeline,
    cube: wgpu::BindGroup,
    /// By map.
    texels: Vec<wgpu::BindGroup>,
    workgroups: [u32; 2],
    transform: wgpu::ComputePipeline,
    faces: wgpu::BindGroup,
}

impl Map {
    /// Uploads a map.
    pub(crate) fn new(gpu: &Gpu, environment: &Environment) -> Self {
        let (unit, halves) = environment.halves();
        let size = [environment.map.width, environment.map.height];
        let upload = |label, halves: &mut dyn Iterator<Item = [f16; 3]>| {
            let texels: Vec<[f16; 4]> = halves.map(|[r, g, b]| [r, g, b, f16::ZERO]).collect();
            gpu.texture(label, size, wgpu::TextureFormat::Rgba16Float, bytemuck::cast_slice(&texels))
        };
        let texels = upload("environment", &mut halves.as_chunks().0.iter().copied());
        let Split { rest, suns } = split(&environment.map);
        let rest = match rest {
            Cow::Borrowed(_) => texels.clone(),
            // What is left of a sun is the radiance of some other texel, so it is as exact.
            Cow::Owned(rest) => {
                let halves = |texel: &[f32; 3]| texel.map(|value| f16::from_f32(value / unit));
                upload("environment without suns", &mut rest.texels.iter().map(halves))
            }
        };
        Self { name: environment.name.clone(), texels, rest, suns, width: size[0], unit }
    }
}

/// What a pass over a map reads of it.
pub(super) fn halves_of(gpu: &Gpu, layout: &wgpu::BindGroupLayout, map: &Map) -> wgpu::BindGroup {
    gpu.bind(layout, [&map.texels, &map.rest].map(wgpu::BindingResource::TextureView))
}

/// Sets element `index` of a list, or the one after its last.
pub(super) fn put<T>(list: &mut Vec<T>, index: usize, value: T) {
    match list.get_mut(index) {
        Some(element) => *element = value,
        None => list.push(value),
    }
}

impl Light {
    /// The light of `maps` on faces of `face_size` texels a side: what they are without suns, and behind it, if
    /// `with_whole`, the whole maps. It must be set before it shines.
    pub(crate) fn new(gpu: &Gpu, maps: Vec<Map>, face_size: u32, with_whole: bool) -> Self {
        let faces_of_all = FACES as u32 * if with_whole { 2 } else { 1 };
        let texels = faces_of_all * face_size * face_size;
        let bytes = u64::from(texels) * size_of::<[f32; 4]>() as u64;
        let uniform_usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let uniform = gpu.buffer("environment", size_of::<gpu_data::Environment>() as u64, uniform_usage);
        let side = gpu.buffer("face size", size_of::<u32>() as u64, uniform_usage);
        gpu.write(&side, 0, bytemuck::bytes_of(&face_size));
        let cube = gpu.buffer("cube", bytes, BufferUsages::STORAGE);
        let coefficients = gpu.buffer("light", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let resample = gpu.compute_pipeline(ENVIRONMENT, "resample");
        let transform = gpu.compute_pipeline(HAAR, "transform");
        let map_layout = resample.get_bind_group_layout(1);
        Self {
            texels: maps.iter().map(|map| halves_of(gpu, &map_layout, map)).collect(),
            cube: gpu.bind(
                &resample.get_bind_group_layout(0),
                [uniform.as_entire_binding(), cube.as_entire_binding()],
            ),
            faces: gpu.bind(
                &transform.get_bind_group_layout(0),
                [&side, &cube, &coefficients].map(wgpu::Buffer::as_entire_binding),
            ),
            workgroups: gpu.workgroups(texels * TEAM, WORKGROUP),
            shines: None,
            maps,
            face_size,
            faces_of_all,
            uniform,
            coefficients,
            resample,
            transform,
        }
    }

    /// Adds a map, or puts it in the place of the one that has its name. Returns its index.
    pub(crate) fn add(&mut self, gpu: &Gpu, map: Map) -> usize {
        let texels = halves_of(gpu, &self.resample.get_bind_group_layout(1), &map);
        let index = self.maps.iter().position(|known| known.name == map.name).unwrap_or(self.maps.len());
        self.shines = self.shines.filter(|(shining, _)| *shining != index);
        put(&mut self.maps, index, map);
        put(&mut self.texels, index, texels);
        index
    }

    /// Makes it shine as `look` says, but for the gain, which is a factor on all that follows. Returns
    /// whether that is a change.
    pub(crate) fn set(&mut self, gpu: &Gpu, look: &EnvironmentLook) -> bool {
        let Some(index) = self.maps.iter().position(|map| map.name == look.map) else { return false };
        let Some(map) = self.maps.get(index).filter(|_| self.shines != Some((index, look.rotation_deg)))
        else {
            return false;
        };
        let (sin_rotation, cos_rotation) = look.rotation_deg.to_radians().sin_cos();
        let points = subsamples(map.width, self.face_size as usize);
        let environment = gpu_data::Environment {
            sin_rotation,
            cos_rotation,
            unit: map.unit,
            face_size: self.face_size,
            points,
        };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&environment));
        self.shines = Some((index, look.rotation_deg));
        true
    }

    /// Encodes the pass that brings the coefficients up to date.
    pub(crate) fn encode(&self, passes: &mut Passes<'_>) {
        let Some(texels) = self.texels.get(self.map()) else { return };
        let mut pass = passes.compute("light");
        pass.set_pipeline(&self.resample);
        pass.set_bind_group(0, &self.cube, &[]);
        pass.set_bind_group(1, texels, &[]);
        pass.dispatch_workgroups(self.workgroups[0], self.workgroups[1], 1);
        pass.set_pipeline(&self.transform);
        pass.set_bind_group(0, &self.faces, &[]);
        pass.dispatch_workgroups(self.faces_of_all, 1, 1);
    }

    /// All maps.
    pub(crate) fn maps(&self) -> &[Map] {
        &self.maps
    }

    /// Index of the map that shines.
    pub(crate) fn map(&self) -> usize {
        self.shines.map_or(0, |(index, _)| index)
    }

    /// The suns of the map that shines, each with the map's rotation, degrees.
    pub(crate) fn suns(&self) -> impl Iterator<Item = (Sun, f32)> {
        let shines = self.shines.and_then(|(index, rotation)| Some((self.maps.get(index)?, rotation)));
        shines
            .into_iter()
            .flat_map(|(map, rotation_deg)| map.suns.iter().map(move |sun| (*sun, rotation_deg)))
    }

    /// The struct `Environment` of the shaders.
    pub(crate) fn uniform(&self) -> &wgpu::Buffer {
        &self.uniform
    }

    /// Haar coefficients before the gain, [6·n·n] without suns, and of the whole if that is there, four floats
    /// each of which the last is unused.
    pub(crate) fn coefficients(&self) -> &wgpu::Buffer {
        &self.coefficients
    }
}
