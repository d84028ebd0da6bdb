//! The GPU objects of one bake: images, film, and the dispatches between them.

use super::bands::{self, Band};
use super::gpu_data::{Dispatch, Slot};
use super::storage::{self, Volume};
use super::{MERGE, SUM};
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use relume_formats::bundle::Brdfs;
use relume_formats::container::Section;
use relume_formats::evaluate::transfer_images::coefficients;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::{Head, Layout, Neighbours};
use relume_formats::{Error as FormatError, Place};
use wgpu::BufferUsages;

/// Invocations of a workgroup that merges.
const MERGING: u32 = 64;

/// All that is needed to play a bake. Images may still be missing.
pub(super) struct Images {
    head: Head,
    layout: Layout,
    neighbours: Neighbours,
    basis: BrdfBasis,
    place: Place,
    /// By slot: whether its image is there.
    present: Vec<bool>,
    coefficients: wgpu::Buffer,
    film: Film,
    sum: wgpu::ComputePipeline,
    merge: wgpu::ComputePipeline,
    work: Vec<Work>,
}

/// The GPU's side of a band.
struct Work {
    band: Band,
    slots: Vec<Slot>,
    halves: wgpu::Buffer,
    sum: Part,
    /// If there are pixels of several fragments.
    merge: Option<Part>,
}

/// One dispatch.
struct Part {
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Part {
    fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.dispatch_workgroups(self.workgroups[0], self.workgroups[1], 1);
    }
}

impl Images {
    /// Makes room for the images that `head` announces.
    pub(super) fn new(gpu: &Gpu, head: Head, basis: BrdfBasis, place: Place) -> Result<Self> {
        let layout = head.layout();
        let bands = bands::cut(&head, &Volume::new(&layout), gpu.binding_bytes).map_err(|bytes| {
            let reason = format!(
                "a pixel of {bytes} bytes in one piece, GPU {} binds at most {}; bake fewer materials that vary",
                gpu.name, gpu.binding_bytes
            );
            FormatError::unsupported(&place, reason)
        })?;
        let table_bytes = ((layout.materials + 1) * layout.slots.len() * size_of::<[f32; 4]>()) as u64;
        let storage_usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let mut images = Self {
            present: vec![false; layout.slots.len()],
            coefficients: gpu.buffer("coefficients", table_bytes, storage_usage),
            film: Film::new(gpu, head.meta.size, bands.iter().map(|band| band.pixels.len())),
            sum: gpu.compute_pipeline(SUM, "sum_slots"),
            merge: gpu.compute_pipeline(MERGE, "merge"),
            work: Vec::new(),
            neighbours: head.neighbours(),
            head,
            layout,
            basis,
            place,
        };
        images.work =
            bands.into_iter().zip(&images.film.bands).map(|(b, f)| images.work(gpu, b, f)).collect();
        Ok(images)
    }

    /// Makes room for a band, which goes onto `film`.
    fn work(&self, gpu: &Gpu, band: Band, film: &wgpu::Buffer) -> Work {
        let tiles = band.classes.len() as u32;
        let dispatch = Dispatch {
            tiles,
            fixed_class: self.layout.materials as u32,
            fixed_slots: self.layout.slots.iter().filter(|slot| slot.fixed.is_some()).count() as u32,
            slots: self.layout.slots.len() as u32,
        };
        let uniform = gpu.buffer(
            "dispatch",
            size_of::<Dispatch>() as u64,
            BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        );
        gpu.write(&uniform, 0, bytemuck::bytes_of(&dispatch));
        let bytes = Volume::new(&self.layout).bytes(band.editable_tiles.into(), tiles.into());
        // Of a band without any fragment nothing is read, but bindings hold one wide word at least.
        let halves = gpu.buffer("images", bytes.max(16), BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let places = storage::slots(&self.layout, &band);
        let slots = gpu.storage("slots", &places);
        let classes = gpu.storage("classes", &band.classes);
        let targets = gpu.storage("targets", &band.targets);
        let sums = band.shared.last().map_or(0, |pixel| u64::from(pixel.end)).max(1);
        let sums = gpu.buffer("shared sums", sums * Film::PIXEL_BYTES, BufferUsages::STORAGE);
        let buffers = [&uniform, &slots, &self.coefficients, &halves, &classes, &targets, film, &sums];
        let part = |pipeline: &wgpu::ComputePipeline, buffers: &[&wgpu::Buffer], workgroups| {
            let resources = buffers.iter().map(|buffer| buffer.as_entire_binding());
            Part { bindings: gpu.bind(&pipeline.get_bind_group_layout(0), resources), workgroups }
        };
        let sum = part(&self.sum, &buffers, gpu.workgroups(tiles, 1));
        let merge = (!band.shared.is_empty()).then(|| {
            let pixels = gpu.storage("shared pixels", &band.shared);
            let workgroups = gpu.workgroups(band.shared.len() as u32, MERGING);
            part(&self.merge, &[&pixels, &sums, film], workgroups)
        });
        Work { band, slots: places, halves, sum, merge }
    }

    /// Writes the image in `section` into its place.
    pub(super) fn image_arrived(&mut self, gpu: &Gpu, section: &Section) -> Result<()> {
        let image = self.head.decode_image(&self.layout, &self.neighbours, section)?;
        let meaning = &self.layout.slots[image.slot];
        let fragments = self.head.fragments_of(meaning);
        for Work { band, slots, halves, .. } in &self.work {
            let planes = storage::arranged(&image.values, fragments, band, meaning.fixed.is_some());
            gpu.write(halves, storage::offset_bytes(&slots[image.slot]), bytemuck::cast_slice(&planes));
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

    /// Encodes the pass that fills the film: the sum of every fragment, and then of every pixel that has
    /// several.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("sum slots");
        pass.set_pipeline(&self.sum);
        self.work.iter().for_each(|work| work.sum.encode(&mut pass));
        pass.set_pipeline(&self.merge);
        self.work.iter().filter_map(|work| work.merge.as_ref()).for_each(|merge| merge.encode(&mut pass));
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
        self.work.iter().map(|work| work.halves.size()).sum()
    }
}
