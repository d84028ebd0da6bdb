//! Method `transfer-images` on the GPU: every pixel is a sum over its fragments of image × coefficient, in
//! one pass.
//!
//! Images arrive one by one, brightest first, and are written into their place; those still missing count as
//! nothing. A frame costs one small upload, the coefficients of the current materials, and one reading of all
//! images.

mod bands;
mod gpu_data;
mod images;
mod materials;
mod storage;

use super::{Method, Pieces, Playback, Setup};
use crate::controls::Look;
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu, Passes};
use crate::materials::MaterialMap;
use crate::stream::{Arrival, decode_all, decode_sections};
use images::Images;
use relume_formats::Error as FormatError;
use relume_formats::bundle::{Settings, expect_images};
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::transfer_images::{HEAD_SECTIONS, Head};
use relume_formats::kinds::{BrdfBasis, scene};

/// The method's line in the registry.
pub const METHOD: Method = Method {
    card: &relume_formats::method::TRANSFER_IMAGES,
    on_cpu: false,
    resizes: false,
    start: |_, setup| Ok(Box::new(TransferImages::new(setup)?)),
};

const SUM: &str = include_str!("sum.wgsl");
const MERGE: &str = include_str!("merge.wgsl");

/// What has arrived of a bake, on its way to and on the GPU.
struct TransferImages {
    scene: scene::Meta,
    settings: Settings,
    /// Sections that wait for those without which they cannot be decoded.
    pending: Vec<Section>,
    basis: Option<BrdfBasis>,
    images: Option<Images>,
}

impl TransferImages {
    /// Images are baked at one size: another one is refused.
    fn new(setup: Setup) -> Result<Self> {
        let (scene, settings) = (setup.scene.meta, setup.settings);
        expect_size(setup.size.unwrap_or(scene.size), scene.size)?;
        Ok(Self { scene, settings, pending: Vec::new(), basis: None, images: None })
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
        let Some(basis) = self.basis.take() else {
            return Err(FormatError::invalid(
                &place,
                "needs a BRDF basis before it; bake the whole bundle again",
            )
            .into());
        };
        expect_images(&head, &basis, &self.scene, &place)?;
        self.settings.expect_images(&head.meta)?;
        self.images = Some(Images::new(gpu, head, basis, place)?);
        Ok(())
    }
}

/// Fails unless the size that is `asked` for is that of the `baked` images.
fn expect_size(asked: [u32; 2], baked: [u32; 2]) -> Result<()> {
    if asked == baked {
        return Ok(());
    }
    let ([width, height], [w, h]) = (asked, baked);
    Err(Error::Request(format!(
        "this bundle was baked at {w}x{h}; ask for no other size, or bake with --size {width}x{height}"
    )))
}

impl Playback for TransferImages {
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        match arrival.kind {
            Kind::BrdfBasis => {
                self.pending.push(arrival.section);
                if arrival.last {
                    self.basis = Some(decode_all(std::mem::take(&mut self.pending))?);
                }
                Ok(())
            }
            Kind::TransferImages => self.images_arrived(gpu, arrival),
            _ => Err(METHOD.has_no_use_for(&arrival)),
        }
    }

    fn maps(&self) -> Option<Vec<String>> {
        Some(Vec::new())
    }

    fn pieces(&self) -> Pieces {
        let mut pieces = Pieces { what: "images", ..Pieces::default() };
        if let Some(images) = &self.images {
            (pieces.expected, pieces.missing, pieces.bytes_per_frame) =
                (images.count(), images.missing(), images.bytes_per_frame());
        }
        pieces
    }

    fn film(&self) -> Option<&Film> {
        self.images.as_ref().map(Images::film)
    }

    fn resize(&mut self, _: &Gpu, size: [u32; 2]) -> Result<()> {
        expect_size(size, self.scene.size)
    }

    fn materials(&self) -> Option<MaterialMap> {
        self.images.as_ref().map(|images| images.head().into())
    }

    fn update(&mut self, gpu: &Gpu, look: &Look) -> Result<()> {
        self.images.as_ref().map_or(Ok(()), |images| images.update(gpu, &look.materials))
    }

    fn encode(&mut self, passes: &mut Passes<'_>) {
        if let Some(images) = &self.images {
            images.encode(passes);
        }
    }
}

#[cfg(test)]
mod tests;
