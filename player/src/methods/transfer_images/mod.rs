//! Method `transfer-images` on the GPU: every pixel is a sum over its fragments of image × coefficient, in one pass.
//!
//! Images arrive one by one, brightest first, and are written into their place; those still missing count as nothing. A frame costs one
//! small upload, the coefficients of the current materials, and one reading of all images.

mod bands;
mod gpu_data;
mod images;
mod storage;

use crate::error::Result;
use crate::gpu::Gpu;
use crate::stream::Arrival;
pub use images::Images;
use relume_formats::container::{Kind, Section, Sections, Stored};
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::{HEAD_SECTIONS, Head};
use relume_formats::state::Brdf;
use relume_formats::{Error as FormatError, Place};
use std::collections::BTreeMap;

/// Name of the method in manifests and on the command line.
pub const NAME: &str = "transfer-images";

const SHADER: &str = include_str!("sum.wgsl");

/// What has arrived of a bake, on its way to and on the GPU.
#[derive(Default)]
pub struct TransferImages {
    /// Sections that wait for those without which they cannot be decoded.
    pending: Vec<Section>,
    basis: Option<BrdfBasis>,
    images: Option<Images>,
}

impl TransferImages {
    /// Takes the next section of one of the method's files.
    ///
    /// # Errors
    /// If the section is malformed, does not fit those before it, or is more than the GPU can bind.
    pub fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        match arrival.kind {
            Kind::BrdfBasis => {
                self.pending.push(arrival.section);
                if arrival.last {
                    self.basis = Some(decode_all(std::mem::take(&mut self.pending))?);
                }
                Ok(())
            }
            Kind::TransferImages => self.images_arrived(gpu, arrival),
            _ => {
                let reason = format!("method {NAME} has no use for kind `{}`; bake it again", arrival.kind.name());
                Err(FormatError::invalid(&arrival.section.place, reason).into())
            }
        }
    }

    fn images_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        if let Some(images) = &mut self.images {
            return images.image_arrived(gpu, &arrival.section);
        }
        let place = arrival.section.place.clone();
        self.pending.push(arrival.section);
        if self.pending.len() < HEAD_SECTIONS && !arrival.last {
            return Ok(());
        }
        let head: Head = decode_sections(&place, std::mem::take(&mut self.pending), Head::decode)?;
        let Some(basis) = self.basis.take().filter(|basis| basis.bases() == head.meta.bases as usize) else {
            let reason = format!("needs a BRDF basis of {} functions before it; bake the whole bundle again", head.meta.bases);
            return Err(FormatError::invalid(&place, reason).into());
        };
        self.images = Some(Images::new(gpu, head, basis, place)?);
        gpu.check()
    }

    /// The images, once it is known what they are.
    pub fn images(&self) -> Option<&Images> {
        self.images.as_ref()
    }

    /// Sets the materials for the passes encoded from now on; every editable material must be among them.
    pub fn update(&self, gpu: &Gpu, materials: &BTreeMap<String, Brdf>) -> Result<()> {
        self.images.as_ref().map_or(Ok(()), |images| images.update(gpu, materials))
    }

    /// Encodes the pass that fills the film.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder, timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>) {
        if let Some(images) = &self.images {
            images.encode(encoder, timestamps);
        }
    }
}

/// Decodes a small file from all of its sections.
pub fn decode_all<T: Stored>(sections: Vec<Section>) -> Result<T> {
    let place = sections.first().map_or_else(|| Place::file(""), |section| section.place.clone());
    decode_sections(&place, sections, T::decode)
}

fn decode_sections<T>(
    place: &Place,
    sections: Vec<Section>,
    decode: impl FnOnce(&mut Sections<'_>) -> relume_formats::Result<T>,
) -> Result<T> {
    let mut rest = sections.into_iter();
    let mut next = || Ok(rest.next());
    let mut sections = Sections { place: place.clone(), next: &mut next };
    let value = decode(&mut sections)?;
    sections.finish()?;
    Ok(value)
}

#[cfg(test)]
mod tests;
