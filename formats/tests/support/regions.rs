//! Region images of any content.

use super::samples::{Random, images};
use half::f16;
use relume_formats::kinds::RegionImages;
use relume_formats::kinds::region_images::{
    COVER, Entries, Head, Meta, REGION_COUNT, Row, Source, TAPS, Tap,
};
use relume_formats::kinds::transfer_images::{Fragments, LARGEST_HALF};
use std::sync::Arc;

/// Of three editable materials, the first and the last of which are painted.
pub fn region_images(seed: u64, bases: usize, one_colour: bool, size: [u32; 2]) -> RegionImages {
    let random = &mut Random(seed ^ 3);
    let whole = images(seed, 3, bases, one_colour, size);
    let head = &whole.head;
    let indirect = 1 + random.below(bases);
    let meta = Meta {
        size,
        materials: head.meta.materials.clone(),
        painted: vec![true, false, true],
        bases: bases as u32,
        indirect_bases: indirect as u32,
        chromaticity: head.meta.chromaticity,
        samples: 64,
        seed,
        editable_fragments: head.meta.editable_fragments,
    };
    let row = |random: &mut Random| {
        let (material, basis) = (random.below(3) as u16, random.below(indirect) as u16);
        let source = match random.below(3) {
            0 => Source::Fixed,
            _ if material == 1 => Source::Whole { material, basis },
            _ => Source::Painted { material, basis },
        };
        Row { source, colour: [random.signed(), random.unit(), 1.0], step: 1e-3 + random.unit() }
    };
    let rows: Vec<Vec<Row>> =
        (0..indirect).map(|_| (0..random.below(6)).map(|_| row(random)).collect()).collect();
    let fragments =
        Fragments { pixel: head.pixel.clone(), class: head.class.clone(), coverage: head.coverage.clone() };
    let mut tap = |weight| Tap { place: [random.bits() as u16, random.bits() as u16], weight };
    let painted = fragments.class.iter().filter(|class| meta.is_painted(**class)).count();
    let taps: Vec<[Tap; TAPS]> =
        (0..painted).map(|i| std::array::from_fn(|k| tap(if k == 0 { 9 } else { (i * k) as u8 }))).collect();
    let painted_rows = rows.iter().flatten().filter(|row| row.is_painted()).count();
    let weights =
        (0..painted_rows).map(|_| (0..REGION_COUNT).map(|_| f16::from_f32(random.signed())).collect());
    let weights = weights.collect();
    let cover =
        (0..2).map(|m| (0..COVER * COVER).map(|i| (i / 7 + i / 9000 + m) % 3 > 0).collect()).collect();
    let mut head = Head { meta, rows, fragments, taps, cover, weights, scales: vec![0.5f32.powi(9); bases] };
    let direct: Vec<Vec<f16>> = (0..bases)
        .map(|basis| {
            let count = head.meta.channels(basis) * head.direct_fragments(basis);
            let mut halves: Vec<f16> = (0..count).map(|_| f16::from_f32(100.0 * random.signed())).collect();
            // The range is made use of.
            halves.iter_mut().take(1).for_each(|half| *half = f16::from_f32(LARGEST_HALF));
            halves
        })
        .collect();
    direct.iter().zip(&mut head.scales).filter(|(d, _)| d.is_empty()).for_each(|(_, scale)| *scale = 0.0);
    let places = head.planes().tiles * 1024;
    let entries = |rows: usize, random: &mut Random| {
        let place = |_| {
            let rows = (0..rows as u16).filter(|_| random.below(40) == 0).collect::<Vec<_>>();
            rows.into_iter().map(|row| (row, (random.bits() as i16) | 1)).collect()
        };
        Entries::of_places(&(0..places).map(place).collect::<Vec<_>>())
    };
    let indirect = (0..indirect).map(|basis| entries(head.rows[basis].len(), random)).collect();
    RegionImages { head: Arc::new(head), direct, indirect }
}
