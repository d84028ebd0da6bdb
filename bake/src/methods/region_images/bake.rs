//! From a scene to images: weights of regions, tiles of traced and projected pixels, packed.

use super::layout::Layout;
use super::pack::Packing;
use super::pilot::Pilot;
use super::project::Projector;
use super::settings::{NAME, REVISION, Settings, reads};
use super::weights::Weights;
use crate::error::Result;
use crate::filter::{Filter, Noise, Watcher};
use crate::fragments::{self, Filtered, PixelRecords, Records, pixels_of, tiles_of};
use crate::job::Job;
use crate::stage::Stage;
use crate::trace::gather::{Gather, GatherPath};
use crate::work_log::WorkLog;
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::manifest::content_hash;
use relume_formats::kinds::{BrdfBasis, RegionImages};
use relume_scenes::Scene;
use relume_scenes::painting::Painting;
use xxhash_rust::xxh3::xxh3_128;

/// What a bake is of.
#[derive(Clone, Copy)]
pub struct Baking<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where its paint lies.
    pub paintings: &'a [Painting],
    /// Its paths.
    pub gather: &'a Gather<'a>,
    /// The basis of its materials.
    pub basis: &'a BrdfBasis,
    /// The settings.
    pub settings: Settings,
}

/// What a bake has made.
pub struct Baked {
    /// As it is stored.
    pub images: RegionImages,
    /// What noise it has; `None` if it shows nothing.
    pub noise: Option<Noise>,
    /// What the regions count.
    pub weights: Weights,
    /// How far it is off.
    pub errors: super::held_out::Errors,
}

impl Baking<'_> {
    /// Bakes. `run` makes the pieces of a stage and gives the log that has them; what is `None` there ends the bake
    /// without images.
    ///
    /// # Errors
    /// If the log cannot be written or read, or the job is interrupted.
    pub fn bake(
        &self,
        job: &Job,
        run: impl Fn(&dyn Stage) -> Result<Option<WorkLog>>,
    ) -> Result<Option<Baked>> {
        let Self { scene, paintings, gather, basis, settings } = *self;
        let key = self.key();
        let Some(log) = run(&Pilot { scene, gather, basis, settings, key, job })? else { return Ok(None) };
        let weights = Weights::decode(&log.read(0)?);
        let layout = Layout::new(scene, &settings, &weights);
        let watcher = Watcher::new(scene);
        let projector = Projector::new(scene, basis, &layout, &weights, &watcher);
        let tiles = Tiles { settings, gather, projector, key };
        let Some(log) = run(&tiles)? else { return Ok(None) };
        let samples = |pixel: u32| gather.samples(pixel, settings.samples);
        let (channels, fixed) = (layout.channels(), layout.materials() as u16);
        let traced =
            Records { log: &log, tiles: tiles.pieces(), channels: &channels, fixed, samples: &samples };
        let filter = Filter::new(traced.film(settings.size[0], job)?, job)?;
        let noise = filter.noise();
        let packing = Packing { scene, paintings, gather, settings, layout: &layout, weights: &weights };
        let measuring =
            super::held_out::Measuring { scene, gather, basis, settings, layout: &layout, weights: &weights };
        let (noise, images, errors) = if settings.filter {
            let stage = Filtered::new(&traced, filter, tiles_of(settings.size), tiles.key, NAME);
            let Some(filtered) = run(&stage)? else { return Ok(None) };
            let filtered = Records { log: &filtered, ..traced };
            let images = packing.pack(&filtered, job)?;
            let errors = measuring.measure(&filtered, &images, job)?;
            (noise, images, errors)
        } else {
            let images = packing.pack(&traced, job)?;
            let errors = measuring.measure(&traced, &images, job)?;
            (noise.map(|noise| Noise { after: noise.before, ..noise }), images, errors)
        };
        Ok(Some(Baked { images, noise, weights, errors }))
    }

    /// Everything that is traced depends on it.
    fn key(&self) -> u128 {
        let functions: &[f32] = match &self.basis.functions {
            Functions::BlinnPhong { lobes } => lobes,
            Functions::Microfacet { weights, .. } => weights,
        };
        // What is traced is filtered or not.
        let settings = Settings { filter: false, ..self.settings };
        let (reads, functions) = (reads(self.scene), content_hash(bytemuck::cast_slice(functions)));
        xxh3_128(format!("{reads:032x} {settings:?} {REVISION} {functions}").as_bytes())
    }
}

/// Tracing and projecting, a tile a piece.
struct Tiles<'a> {
    settings: Settings,
    gather: &'a Gather<'a>,
    projector: Projector<'a>,
    key: u128,
}

impl Stage for Tiles<'_> {
    fn name(&self) -> String {
        NAME.to_owned()
    }

    fn label(&self) -> Option<&'static str> {
        Some("tracing")
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        let [columns, rows] = tiles_of(self.settings.size);
        columns * rows
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let Settings { size, samples, .. } = self.settings;
        let add = |path: &GatherPath, half: usize, records: &mut PixelRecords| {
            self.projector.add(path, half, records);
        };
        Ok(fragments::trace(pixels_of(number, size), samples, self.gather, self.projector.empty(), add)
            .encode())
    }
}
