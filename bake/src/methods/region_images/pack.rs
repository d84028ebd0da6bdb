//! From sums of fragments to stored images.

use super::cells::{Cells, coverage};
use super::layout::Layout;
use super::rows::rows_of;
use super::settings::Settings;
use super::taps::taps;
use super::weights::Weights;
use crate::compress::quantise::scale_for;
use crate::error::Result;
use crate::fragments::{Records, TileFragment};
use crate::job::Job;
use crate::trace::gather::Gather;
use half::f16;
use relume_formats::kinds::RegionImages;
use relume_formats::kinds::region_images::{COVER, Head, Meta, REGION_COUNT, Row};
use relume_formats::kinds::transfer_images::{Fragments, LARGEST_HALF, MAX_SCALE};
use relume_scenes::Scene;
use relume_scenes::painting::Painting;
use std::sync::Arc;

/// What part of the error that is asked for coefficients may make that are left out or rounded.
const ERROR_SHARE: f64 = 0.5;

/// What there is beside records.
pub struct Packing<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where its paint lies.
    pub paintings: &'a [Painting],
    /// Its paths.
    pub gather: &'a Gather<'a>,
    /// The settings of the bake.
    pub settings: Settings,
    /// What channels are of.
    pub layout: &'a Layout,
    /// What regions count.
    pub weights: &'a Weights,
}

impl Packing<'_> {
    /// Reads all `records` and packs them.
    ///
    /// # Errors
    /// If the log cannot be read, light is too bright to be stored, or the job is interrupted.
    pub fn pack(&self, records: &Records<'_>, job: &Job) -> Result<RegionImages> {
        let Self { scene, layout, settings, weights, .. } = *self;
        let Direct { fragments, editable, scales, halves } = self.direct(records, job)?;
        let meta = Meta {
            size: settings.size,
            materials: scene.varying_names().into_iter().map(str::to_owned).collect(),
            painted: layout.painted.clone(),
            bases: layout.bases[0] as u32,
            indirect_bases: layout.bases[1] as u32,
            chromaticity: layout.chromaticity,
            samples: settings.samples,
            seed: settings.seed,
            editable_fragments: editable as u32,
        };
        let painted: Vec<(u32, u16)> = fragments
            .pixel
            .iter()
            .copied()
            .zip(fragments.class.iter().copied())
            .filter(|(_, class)| meta.is_painted(*class))
            .collect();
        let taps = taps(scene, self.gather, settings.samples, &painted, job)?;
        let rows = rows_of(layout, weights);
        let mut head = Head {
            meta,
            rows: Vec::new(),
            fragments,
            taps,
            cover: self.cover(),
            weights: Vec::new(),
            scales,
        };
        let planes = head.planes();
        let cells = Cells {
            records,
            layout,
            rows: &rows,
            size: settings.size,
            fragments: &head.fragments,
            editable,
            planes: &planes,
        };
        let film = f64::from(settings.size[0]) * f64::from(settings.size[1]);
        let budget = weights.energy * film * (ERROR_SHARE * settings.max_error).powi(2);
        let step = cells.sizes(job)?.step_for(budget);
        let (steps, indirect): (Vec<Vec<f32>>, Vec<_>) = cells.entries(step, job)?.into_iter().unzip();
        let stored = |(rows, steps): (&Vec<super::rows::RowOf>, &Vec<f32>)| {
            rows.iter().zip(steps).map(|(row, step)| row.stored(layout, *step)).collect::<Vec<Row>>()
        };
        head.rows = rows.iter().zip(&steps).map(stored).collect();
        let played = |(group, component): (usize, usize)| {
            let weights = &weights.groups[group].played[component * REGION_COUNT..][..REGION_COUNT];
            weights.iter().map(|weight| f16::from_f32(*weight)).collect()
        };
        head.weights = rows.iter().flatten().filter_map(|row| row.component).map(played).collect();
        Ok(RegionImages { head: Arc::new(head), direct: halves, indirect })
    }

    /// By painted material, in the order of classes.
    fn cover(&self) -> Vec<Vec<bool>> {
        let vary = &self.scene.vary;
        let painted = vary.materials.iter().filter(|material| vary.painted.contains(material));
        let of = |material: &usize| {
            let painting = self.paintings.iter().find(|painting| painting.material == *material);
            painting.map_or_else(|| vec![false; COVER * COVER], |painting| painting.covered(COVER as u32))
        };
        painted.map(of).collect()
    }

    /// Fragments, and light without a reflection before.
    fn direct(&self, records: &Records<'_>, job: &Job) -> Result<Direct> {
        let layout = self.layout;
        let progress = job.progress("packing", u64::from(records.tiles));
        let mut all: Vec<(TileFragment, Vec<f32>)> = Vec::new();
        let direct = layout.bases[0];
        let ends = [&layout.editable[..direct], &layout.fixed[..1]]
            .map(|blocks| blocks.last().map_or(0, |block| block.start + block.colours));
        records.for_each_batch(
            &progress,
            |_| true,
            |found| {
                all.extend(found.iter().map(|(fragment, values)| {
                    let end = ends[usize::from(fragment.class == records.fixed)];
                    (*fragment, values[..end].to_vec())
                }));
            },
        )?;
        all.sort_by_key(|(f, _)| (f.class == records.fixed, f.pixel, f.class));
        let editable = all.partition_point(|(f, _)| f.class != records.fixed);
        let refuse = |reason: &str| Err(records.log.refuse(reason).into());
        let (mut scales, mut halves) = (Vec::new(), Vec::new());
        for block in &layout.editable[..direct] {
            let shown = if block.eye == 0 { &all[..] } else { &all[..editable] };
            let channel = |k: usize| shown.iter().map(move |(_, values)| values[block.start + k]);
            let values: Vec<f32> = (0..block.colours).flat_map(channel).collect();
            if values.iter().any(|value| !value.is_finite()) {
                return refuse(
                    "holds radiance that is not finite: light this bright overflows; lower the lights",
                );
            }
            let scale = scale_for(values.iter().fold(0.0, |m: f32, v| m.max(v.abs())));
            if scale > MAX_SCALE {
                let most = MAX_SCALE * LARGEST_HALF;
                let reason = format!(
                    "holds radiance above {most:e}, at which pictures could overflow; lower the lights"
                );
                return refuse(&reason);
            }
            let half = |value: &f32| if scale > 0.0 { f16::from_f32(value / scale) } else { f16::ZERO };
            halves.push(values.iter().map(half).collect());
            scales.push(scale);
        }
        let coverage = |(f, _): &(TileFragment, Vec<f32>)| coverage(f.count, (records.samples)(f.pixel));
        let fragments = Fragments {
            pixel: all.iter().map(|(f, _)| f.pixel).collect(),
            class: all.iter().map(|(f, _)| f.class).collect(),
            coverage: all.iter().map(coverage).collect(),
        };
        Ok(Direct { fragments, editable, scales, halves })
    }
}

/// Fragments in the order of the file, and their direct images.
struct Direct {
    fragments: Fragments,
    editable: usize,
    scales: Vec<f32>,
    halves: Vec<Vec<f16>>,
}
