//! From tiles of sums to stored images: orders fragments, finds each image's range, rounds, sorts images by
//! importance.

use super::rounding::round;
use crate::compress::quantise::scale_for;
use crate::error::Result;
use crate::fragments::{Records, TileFragment};
use crate::job::Job;
use half::f16;
use rayon::prelude::*;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::{
    FirstReflection, Head, Image, LARGEST_HALF, Later, Layout, MAX_SCALE, Meta, Slot, TransferImages,
};
use std::sync::Arc;

/// Sums over all fragments of one slot.
#[derive(Debug, Clone, Copy, Default)]
struct SlotSums {
    largest: f32,
    squares: f64,
    overflows: bool,
}

/// Reads all records, twice, and packs them, or those of the pixels in `only` alone, which are in order.
/// `meta.editable_fragments` is filled in here.
///
/// # Errors
/// If the log cannot be read or the job is interrupted.
pub(super) fn pack(
    traced: &Records<'_>,
    layout: &Layout,
    basis: &BrdfBasis,
    (mut meta, later): (Meta, Option<Later>),
    only: Option<&[u32]>,
    job: &Job,
) -> Result<TransferImages> {
    let log = traced.log;
    let progress = job.progress("packing", 2 * u64::from(traced.tiles));
    let channel_starts = channel_starts(layout);
    let wanted = |f: &TileFragment| only.is_none_or(|only| only.binary_search(&f.pixel).is_ok());

    // First reading: which fragments there are, and the range of each slot.
    let mut fragments = Vec::new();
    let mut sums = vec![SlotSums::default(); layout.slots.len()];
    traced.for_each_batch(&progress, wanted, |records| {
        fragments.extend(records.iter().map(|(fragment, _)| *fragment));
        // Slots apart, so that every sum has its order whatever the threads are.
        sums.par_iter_mut().zip(channel_starts.par_windows(2)).for_each(|(sums, start)| {
            // Fixed fragments have no values in the later slots.
            for value in records.iter().filter_map(|(_, record)| record.get(start[0]..start[1])).flatten() {
                sums.overflows |= !value.is_finite();
                sums.largest = sums.largest.max(value.abs());
                sums.squares += f64::from(*value).powi(2);
            }
        });
    })?;
    if sums.iter().any(|sums| sums.overflows) {
        return Err(log
            .refuse("holds radiance that is not finite: light this bright overflows; lower the lights")
            .into());
    }
    let mut scales: Vec<f32> = sums.iter().map(|s| scale_for(s.largest)).collect();
    if scales.iter().any(|scale| *scale > MAX_SCALE) {
        let most = MAX_SCALE * LARGEST_HALF;
        return Err(log
            .refuse(&format!(
                "holds radiance above {most:e}, at which pictures could overflow; lower the lights"
            ))
            .into());
    }
    let fixed_class = layout.materials as u16;
    fragments.sort_by_key(|f| (f.class == fixed_class, f.pixel, f.class));
    let editable = fragments.partition_point(|f| f.class != fixed_class);
    meta.editable_fragments = editable as u32;

    // Second reading: every value to its place.
    let count_of = |slot: &Slot| if slot.fixed.is_some() { fragments.len() } else { editable };
    let mut images: Vec<Vec<f16>> =
        layout.slots.iter().map(|s| vec![f16::ZERO; s.channels() * count_of(s)]).collect();
    traced.for_each_batch(&progress, wanted, |records| {
        let key = |f: &TileFragment| (f.class == fixed_class, f.pixel, f.class);
        let place = |fragment: &TileFragment| fragments.binary_search_by_key(&key(fragment), key).ok();
        let records: Vec<(usize, &[f32])> =
            records.iter().filter_map(|(fragment, record)| Some((place(fragment)?, *record))).collect();
        let slots = layout.slots.par_iter().zip(channel_starts.par_windows(2)).zip(&scales);
        images.par_iter_mut().zip(slots).filter(|(_, (_, scale))| **scale > 0.0).for_each(
            |(image, ((slot, start), scale))| {
                for (index, record) in &records {
                    for (channel, value) in record.get(start[0]..start[1]).into_iter().flatten().enumerate() {
                        image[channel * count_of(slot) + index] = f16::from_f32(value / scale);
                    }
                }
            },
        );
    })?;

    let mut images: Vec<Image> =
        images.into_iter().enumerate().map(|(slot, values)| Image { slot, values }).collect();
    round(&mut images, &mut scales, layout, &slot_weights(layout, &largest_squares(basis)));
    sort_by_importance(&mut images, layout, basis, |slot| sums[slot].squares);
    let head = Head {
        meta,
        later,
        pixel: fragments.iter().map(|f| f.pixel).collect(),
        class: fragments.iter().map(|f| f.class).collect(),
        // Fragments that only show what others emit have no samples of their own.
        coverage: fragments
            .iter()
            .map(|f| f16::from_f32(f.count as f32 / (traced.samples)(f.pixel) as f32).max(f16::from_bits(1)))
            .collect(),
        scales,
    };
    Ok(TransferImages { head: Arc::new(head), images })
}

/// Puts first what counts most in a typical material; `squares` gives the sum of a slot's squares.
pub fn sort_by_importance(
    images: &mut [Image],
    layout: &Layout,
    basis: &BrdfBasis,
    squares: impl Fn(usize) -> f64,
) {
    let importance: Vec<f64> = (0..)
        .zip(slot_weights(layout, &mean_squares(basis)))
        .map(|(number, weight)| squares(number) * weight)
        .collect();
    images.sort_by(|a, b| importance[b.slot].total_cmp(&importance[a.slot]).then(a.slot.cmp(&b.slot)));
}

/// Where the channels of each slot start within a fragment's record, and the end of the last.
fn channel_starts(layout: &Layout) -> Vec<usize> {
    let mut starts = vec![0];
    for slot in &layout.slots {
        starts.push(starts[starts.len() - 1] + slot.channels());
    }
    starts
}

/// Mean square of each basis' coefficient over the lobes: how much a basis counts in a typical material.
fn mean_squares(basis: &BrdfBasis) -> Vec<f64> {
    let nodes = basis.parameters.len() as f64;
    // All parts of a lobe count alike.
    squares(basis, |sum, square| sum + square / nodes)
}

/// The largest square of each basis' coefficient: how much a basis counts at most.
fn largest_squares(basis: &BrdfBasis) -> Vec<f64> {
    squares(basis, f64::max)
}

fn squares(basis: &BrdfBasis, join: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let mut joined = vec![0.0; basis.bases()];
    for row in basis.coefficients.chunks_exact(basis.bases()) {
        joined.iter_mut().zip(row).for_each(|(all, c)| *all = join(*all, f64::from(*c).powi(2)));
    }
    // The diffuse basis has a coefficient of its own.
    joined[0] += 1.0;
    joined
}

/// What the square of the values of each slot is multiplied with, from such `squares` of the bases'.
fn slot_weights(layout: &Layout, squares: &[f64]) -> Vec<f64> {
    layout.slots.iter().map(|slot| slot_weight(slot, squares)).collect()
}

fn slot_weight(slot: &Slot, weights: &[f64]) -> f64 {
    let first = |first: FirstReflection| match first {
        FirstReflection::Editable { basis, .. } | FirstReflection::LaterLobe { basis, .. } => weights[basis],
        FirstReflection::None | FirstReflection::Fixed | FirstReflection::Later { .. } => 1.0,
    };
    let editable = weights[slot.eye_basis] * first(slot.first);
    slot.fixed.map_or(editable, |fixed| editable.max(first(fixed)))
}
