//! The GPU objects of one bake: images, film, and the dispatches between them.

use super::SHADER;
use super::bands::{self, Band};
use super::gpu_data::Dispatch;
use super::storage::{Storage, padded};
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use relume_formats::bundle::Brdfs;
use relume_formats::container::Section;
use relume_formats::evaluate::transfer_images::coefficients;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::{Head, Layout};
use relume_formats::{Error as FormatError, Place};
use wgpu::BufferUsages;

/// Invocations of a workgroup, as in the shader.
const WORKGROUP: u32 = 64;

/// All that is needed to play a bake. Images may still be missing.
pub(super) struct Images {
    head: Head,
    layout: Layout,
    basis: BrdfBasis,
    place: Place,
    storage: Storage,
    /// By slot: whether its image is there.
    present: Vec<bool>,
    /// By chunk.
    halves: Vec<wgpu::Buffer>,
    coefficients: wgpu::Buffer,
    film: Film,
    pipeline: wgpu::ComputePipeline,
    dispatches: Vec<Work>,
}

/// One dispatch: a band × a chunk.
struct Work {
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Images {
    /// Makes room for the images that `head` announces.
    pub(super) fn new(gpu: &Gpu, head: Head, basis: BrdfBasis, place: Place) -> Result<Self> {
        let layout = head.layout();
        let storage = Storage::arrange(&head, &layout, gpu.binding_bytes).map_err(|bytes| {
            let reason = format!(
                "an image of {bytes} bytes, GPU {} binds at most {}; bake a smaller size",
                gpu.name, gpu.binding_bytes
            );
            FormatError::unsupported(&place, reason)
        })?;
        let bands = bands::cut(&head, gpu.binding_bytes);
        let table_bytes = ((layout.materials + 1) * layout.slots.len() * size_of::<[f32; 4]>()) as u64;
        let storage_usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let mut images = Self {
            present: vec![false; layout.slots.len()],
            halves: storage
                .chunks
                .iter()
                .map(|chunk| gpu.buffer("images", chunk.bytes, storage_usage))
                .collect(),
            coefficients: gpu.buffer("coefficients", table_bytes, storage_usage),
            film: Film::new(gpu, head.meta.size, bands.iter().map(|band| band.pixels.len())),
            pipeline: gpu.compute_pipeline(SHADER, "sum_slots"),
            dispatches: Vec::new(),
            head,
            layout,
            basis,
            place,
            storage,
        };
        images.dispatches = images.work(gpu, &bands);
        Ok(images)
    }

    /// The dispatches of a frame: band by band, every chunk in order, for later chunks add to what earlier
    /// ones left.
    fn work(&self, gpu: &Gpu, bands: &[Band]) -> Vec<Work> {
        let slots = gpu.storage("slots", &self.storage.slots);
        let layout = self.pipeline.get_bind_group_layout(0);
        let mut all = Vec::new();
        for (band, film) in bands.iter().zip(&self.film.bands) {
            let starts = gpu.storage("fragment starts", &band.starts);
            let fragments = gpu.storage("fragments", &band.fragments);
            for (index, (chunk, halves)) in self.storage.chunks.iter().zip(&self.halves).enumerate() {
                let dispatch = Dispatch {
                    pixels: band.pixels.len() as u32,
                    first_slot: chunk.slots.start as u32,
                    end_slot: chunk.slots.end as u32,
                    slots: self.layout.slots.len() as u32,
                    accumulate: u32::from(index > 0),
                };
                let uniform = gpu.buffer(
                    "dispatch",
                    size_of::<Dispatch>() as u64,
                    BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                );
                gpu.write(&uniform, 0, bytemuck::bytes_of(&dispatch));
                let buffers = [&uniform, &slots, &self.coefficients, halves, &starts, &fragments, film];
                let bindings = gpu.bind(&layout, buffers.map(wgpu::Buffer::as_entire_binding));
                all.push(Work { bindings, workgroups: gpu.workgroups(dispatch.pixels, WORKGROUP) });
            }
        }
        all
    }

    /// Writes the image in `section` into its place.
    pub(super) fn image_arrived(&mut self, gpu: &Gpu, section: &Section) -> Result<()> {
        let image = self.head.decode_image(&self.layout, section)?;
        let slot = &self.storage.slots[image.slot];
        let chunk = self.storage.chunks.iter().position(|chunk| chunk.slots.contains(&image.slot));
        if let Some(halves) = chunk.and_then(|chunk| self.halves.get(chunk)) {
            let planes = padded(&image.values, slot.fragments as usize);
            gpu.write(halves, 2 * u64::from(slot.offset), bytemuck::cast_slice(&planes));
        }
        self.present[image.slot] = true;
        Ok(())
    }

    /// Uploads the coefficients of `materials`, by name.
    pub(super) fn update(&self, gpu: &Gpu, materials: &Brdfs) -> Result<()> {
        let on_bases = |name: &String| {
            let missing = || {
                let reason = format!(
                    "edits material `{name}`, which the scene does not have, or not of this model; bake it again"
                );
                FormatError::invalid(&self.place, reason)
            };
            materials.get(name).and_then(|brdf| self.basis.coefficients_of(brdf)).ok_or_else(missing)
        };
        let on_bases =
            self.head.meta.materials.iter().map(on_bases).collect::<relume_formats::Result<Vec<_>>>()?;
        let mut table = coefficients(&self.head, &self.layout, &on_bases);
        for row in table.chunks_exact_mut(self.present.len()) {
            for (factor, _) in row.iter_mut().zip(&self.present).filter(|(_, present)| !**present) {
                *factor = [0.0; 3];
            }
        }
        let table: Vec<[f32; 4]> = table.iter().map(|c| [c[0], c[1], c[2], 0.0]).collect();
        gpu.queue.write_buffer(&self.coefficients, 0, bytemuck::cast_slice(&table));
        Ok(())
    }

    /// Encodes the pass that fills the film.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("sum slots");
        pass.set_pipeline(&self.pipeline);
        for work in &self.dispatches {
            pass.set_bind_group(0, &work.bindings, &[]);
            pass.dispatch_workgroups(work.workgroups[0], work.workgroups[1], 1);
        }
    }

    /// What each pixel shows, and everything else but the images.
    pub(super) fn head(&self) -> &Head {
        &self.head
    }

    /// Number of images, arrived or not.
    pub(super) fn count(&self) -> usize {
        self.present.len()
    }

    /// The film.
    pub(super) fn film(&self) -> &Film {
        &self.film
    }

    /// Slots whose images have not arrived.
    pub(super) fn missing(&self) -> Vec<usize> {
        self.present.iter().enumerate().filter(|(_, present)| !**present).map(|(slot, _)| slot).collect()
    }

    /// Bytes of images that a pass reads.
    pub(super) fn bytes_per_frame(&self) -> u64 {
        self.layout.slots.iter().map(|slot| 2 * (slot.channels() * self.head.fragments_of(slot)) as u64).sum()
    }
}
