//! The settings of the method on the chart: bases, which a frame pays for, and samples, which the bake pays
//! for.

use crate::sweep::{Bench, Sweep, Variant, read};
use half::f16;
use relume_bake::compress::quantise::scale_for;
use relume_bake::error::Result;
use relume_bake::methods::transfer_images::later::on_bases;
use relume_bake::methods::transfer_images::pack::sort_by_importance;
use relume_bake::methods::transfer_images::{Bases, METHOD, NAME, TransferImagesMethod, space_for};
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::{Head, Image, Layout, Meta, Slot, TransferImages};
use relume_scenes::Scene;
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The method's line among the sweeps.
pub const SWEEP: Sweep = Sweep { method: &METHOD, variants };

/// Film samples a pixel: those of the qualities by name.
const SAMPLES: [u32; 3] = [64, 256, 1024];
/// Bases, the diffuse one included; the last is baked.
const BASES: [usize; 6] = [2, 3, 4, 6, 10, 16];

fn variants(scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    let mut variants = Vec::new();
    let most = BASES[BASES.len() - 1];
    let space = space_for(scene, most)?;
    for samples in SAMPLES {
        let (size, bases) = (bench.size, Bases::Number(most));
        let method = TransferImagesMethod { size, samples, seed: 0, bases, filter: true, noise: None };
        let baked = bench.bake(scene, Box::new(method), &format!("{NAME}-{samples}"))?;
        let images: TransferImages = read(&baked.folder)?;
        for bases in BASES {
            let folder = if bases == most {
                baked.folder.clone()
            } else {
                let basis = space.basis(bases);
                let fewer = with_fewer_bases(&images, &basis);
                bench.cut(&baked.folder, &format!("{NAME}-{samples}-{bases}"), |cut| {
                    cut.set("bases", json!(bases));
                    cut.replace(&basis)?;
                    cut.replace(&fewer)
                })?
            };
            let settings =
                BTreeMap::from([("bases".to_owned(), json!(bases)), ("samples".to_owned(), json!(samples))]);
            let (series, label) = (format!("{samples} samples"), format!("{bases} bases"));
            variants.push(Variant {
                method: NAME,
                series,
                label,
                settings,
                folder,
                bake_seconds: baked.seconds,
            });
        }
    }
    Ok(variants)
}

/// What a bake of the same paths on the fewer bases of `basis` gives: bases are the beginnings of larger
/// ones, so every image that it has is there. Where an image holds both kinds of fragments, fewer bases bring
/// others together.
fn with_fewer_bases(images: &TransferImages, basis: &BrdfBasis) -> TransferImages {
    let old = &images.head;
    let meta = Meta { bases: basis.bases() as u32, ..old.meta.clone() };
    let later = old.later.clone().map(|later| on_bases(later, basis.bases()));
    let head = Head { meta, later, scales: Vec::new(), ..(**old).clone() };
    let [from, to] = [old.layout(), head.layout()];
    let find = |is: &dyn Fn(&Slot) -> bool| from.slots.iter().position(is);
    let (mut packed, mut scales, mut squares) = (Vec::new(), Vec::new(), Vec::new());
    for (number, slot) in to.slots.iter().enumerate() {
        let seen = find(&|s| s.eye_basis == slot.eye_basis && s.first == slot.first);
        let fixed = slot.fixed.and_then(|_| find(&|s| s.fixed == slot.fixed));
        let channels = (0..slot.channels()).flat_map(|c| {
            [part(images, &from, seen, c, false), part(images, &from, fixed, c, true)].concat()
        });
        let values: Vec<f32> = channels.collect();
        let scale = scale_for(values.iter().fold(0.0, |largest, value| largest.max(value.abs())));
        let half = |value: &f32| if scale > 0.0 { f16::from_f32(value / scale) } else { f16::ZERO };
        packed.push(Image { slot: number, values: values.iter().map(half).collect() });
        squares.push(values.iter().map(|value| f64::from(*value).powi(2)).sum());
        scales.push(scale);
    }
    sort_by_importance(&mut packed, &to, basis, |slot| squares[slot]);
    TransferImages { head: Arc::new(Head { scales, ..head }), images: packed }
}

/// Of one channel of a slot the editable fragments, or the fixed ones behind them, in radiance; nothing
/// without a slot.
fn part(
    images: &TransferImages,
    layout: &Layout,
    slot: Option<usize>,
    channel: usize,
    fixed: bool,
) -> Vec<f32> {
    let Some((slot, image)) =
        slot.and_then(|slot| Some((slot, images.images.iter().find(|image| image.slot == slot)?)))
    else {
        return Vec::new();
    };
    let fragments = images.head.fragments_of(&layout.slots[slot]);
    let channel = &image.values[channel * fragments..(channel + 1) * fragments];
    let (editable, behind) = channel.split_at(images.head.meta.editable_fragments as usize);
    (if fixed { behind } else { editable })
        .iter()
        .map(|half| half.to_f32() * images.head.scales[slot])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_bake::guided;
    use relume_bake::job::{Job, ProgressMode};
    use relume_bake::methods::transfer_images::{Settings, bake};
    use relume_bake::stage::{Share, Stage, fill};
    use relume_bake::trace::lights::Lights;
    use relume_bake::trace::world::World;
    use relume_bake::work_log::WorkLog;
    use relume_formats::kinds::transfer_images::codes::step_of;
    use relume_scenes::ALL_REFLECTIONS;

    /// Both bakes trace the same paths, and their bases agree to rounding, so all that may differ is the last
    /// bit of a half, or to which step a value was rounded.
    #[test]
    fn a_cut_bake_is_the_bake_with_fewer_bases() {
        for reflections in [2, ALL_REFLECTIONS] {
            expect_cut_bakes(reflections);
        }
    }

    fn expect_cut_bakes(reflections: u32) {
        let mut scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
        scene.reflections = reflections;
        let world = World::new(&scene);
        let lights = Lights::new(&scene, &world);
        let bake_with = |bases: usize| {
            let folder = tempfile::tempdir().unwrap();
            let basis = space_for(&scene, bases).unwrap().basis(bases);
            let settings = Settings { size: [24, 24], samples: 8, seed: 0, bases, filter: true };
            let job = Job::new(ProgressMode::None);
            let run = |stage: &dyn Stage| {
                let log = WorkLog::create(&folder.path().join(stage.name()), 0).unwrap();
                fill(stage, &log, Share::WHOLE, &job)?;
                Ok(Some(log))
            };
            let Settings { size, samples, seed, .. } = settings;
            let reflections = scene.reflections;
            let paths = guided::Settings { size, samples, reflections, seed, target: None };
            let gather = guided::gather(&scene, &world, &lights, &paths, &job).unwrap();
            (bake(&scene, &gather, &settings, &basis, &job, run).unwrap().unwrap().images, basis)
        };
        let (many, _) = bake_with(16);
        for bases in [2, 6] {
            let (few, basis) = bake_with(bases);
            let cut = with_fewer_bases(&many, &basis);
            assert_eq!((&cut.head.meta, &cut.head.later), (&few.head.meta, &few.head.later));
            assert_eq!(
                (&cut.head.pixel, &cut.head.class, &cut.head.coverage),
                (&few.head.pixel, &few.head.class, &few.head.coverage)
            );
            let layout = few.head.layout();
            for image in &few.images {
                let ours = cut.images.iter().find(|i| i.slot == image.slot).unwrap();
                assert_eq!(ours.values.len(), image.values.len(), "{:?}", layout.slots[image.slot]);
                let largest = 32_768.0 * few.head.scales[image.slot];
                let step =
                    |image: &Image, scale: f32| 2f32.powi(i32::from(step_of(&image.values)) - 24) * scale;
                let step =
                    step(ours, cut.head.scales[image.slot]).max(step(image, few.head.scales[image.slot]));
                for (a, b) in ours.values.iter().zip(&image.values) {
                    let [a, b] =
                        [a.to_f32() * cut.head.scales[image.slot], b.to_f32() * few.head.scales[image.slot]];
                    assert!(
                        (a - b).abs() <= 1e-3 * b.abs() + 1e-5 * largest + step,
                        "{bases} bases, {:?}: {a} {b}",
                        layout.slots[image.slot]
                    );
                }
            }
        }
    }
}
