//! Region images: what they are of, and their parts as arrays.

use crate::inspected::out::Out;
use crate::inspected::words::{grouped, list, many, pixels};
use crate::inspected::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::RegionImages;
use relume_formats::kinds::region_images::{Head, Source};
use relume_formats::state::Rgb;
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::RegionImages, describe, export };

#[derive(Serialize)]
struct Details {
    size: [u32; 2],
    materials: Vec<String>,
    painted: Vec<String>,
    bases: u32,
    indirect_bases: u32,
    chromaticity: Option<Rgb>,
    samples: u32,
    seed: u64,
    fragments: usize,
    /// By basis of the eye.
    rows: Vec<usize>,
    components: usize,
}

fn describe(path: &Path) -> Result<Described> {
    let details = Details::of(&RegionImages::open(path)?.read_first(Head::decode)?);
    Ok(Described { facts: details.facts(), details: Box::new(details) })
}

impl Details {
    fn of(head: &Head) -> Self {
        let meta = &head.meta;
        let painted = meta.materials.iter().zip(&meta.painted).filter(|(_, painted)| **painted);
        Self {
            size: meta.size,
            painted: painted.map(|(name, _)| name.clone()).collect(),
            materials: meta.materials.clone(),
            bases: meta.bases,
            indirect_bases: meta.indirect_bases,
            chromaticity: meta.chromaticity,
            samples: meta.samples,
            seed: meta.seed,
            fragments: head.fragments.pixel.len(),
            rows: head.rows.iter().map(Vec::len).collect(),
            components: head.weights.len(),
        }
    }

    fn facts(&self) -> Facts {
        let samples = many(self.samples as usize, "sample", "samples");
        vec![
            ("size", format!("{}, {samples} a pixel, seed {}", pixels(self.size), self.seed)),
            ("bases", format!("{}, {} of light between surfaces", self.bases, self.indirect_bases)),
            (
                "light",
                self.chromaticity
                    .map_or("of several colours".to_owned(), |c| format!("of one colour, {c:?}")),
            ),
            ("painted", list(self.painted.iter().cloned())),
            (
                "images",
                format!(
                    "{} of light between surfaces, {} of them components of regions",
                    self.rows.iter().sum::<usize>(),
                    self.components
                ),
            ),
            ("fragments", grouped(self.fragments as u64)),
        ]
    }
}

/// `fragments_*.npy`, `taps_*.npy`, `weights.npy` [painted rows, regions], of each basis of the eye the coefficients
/// that are kept as a sparse matrix, and `region-images.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let images = RegionImages::read_file(path)?;
    let head = &images.head;
    let fragments = &head.fragments;
    let count = fragments.pixel.len();
    out.npy("fragments_pixel.npy", &[count], fragments.pixel.iter().copied())?;
    out.npy("fragments_class.npy", &[count], fragments.class.iter().copied())?;
    out.npy("fragments_coverage.npy", &[count], fragments.coverage.iter().map(|c| c.to_f32()))?;
    let taps = head.taps.as_flattened();
    let shape = [head.taps.len(), taps.len() / head.taps.len().max(1)];
    out.npy("taps_uv.npy", &[shape[0], shape[1], 2], taps.iter().flat_map(|tap| tap.uv()))?;
    out.npy("taps_weight.npy", &shape, taps.iter().map(|tap| tap.weight))?;
    let regions = head.weights.first().map_or(0, Vec::len);
    out.npy(
        "weights.npy",
        &[head.weights.len(), regions],
        head.weights.iter().flatten().map(|w| w.to_f32()),
    )?;
    for (eye, halves) in images.direct.iter().enumerate() {
        let (channels, scale) = (head.meta.channels(eye), head.scales[eye]);
        let values = halves.iter().map(|half| half.to_f32() * scale);
        out.npy(&format!("direct_b{eye}.npy"), &[channels, head.direct_fragments(eye)], values)?;
    }
    for (eye, entries) in images.indirect.iter().enumerate() {
        out.npy(
            &format!("indirect_b{eye}_starts.npy"),
            &[entries.starts.len()],
            entries.starts.iter().copied(),
        )?;
        out.npy(&format!("indirect_b{eye}_rows.npy"), &[entries.rows.len()], entries.rows.iter().copied())?;
        out.npy(
            &format!("indirect_b{eye}_steps.npy"),
            &[entries.steps.len()],
            entries.steps.iter().copied(),
        )?;
    }
    let row = |row: &relume_formats::kinds::region_images::Row| {
        let source = match row.source {
            Source::Fixed => json!({ "on": "fixed" }),
            Source::Whole { material, basis } => {
                json!({ "on": "whole", "material": head.meta.materials.get(usize::from(material)), "basis": basis })
            }
            Source::Painted { material, basis } => {
                json!({ "on": "painted", "material": head.meta.materials.get(usize::from(material)), "basis": basis })
            }
        };
        json!({ "first": source, "colour": row.colour, "step": row.step })
    };
    let rows: Vec<Vec<serde_json::Value>> =
        head.rows.iter().map(|rows| rows.iter().map(row).collect()).collect();
    out.json(
        "region-images.json",
        &json!({
            "kind": "region-images",
            "meaning": "radiance of a fragment = sum over bases of the eye of its mean coefficient at its taps times (direct + coverage * \
                light between surfaces); that light is the sum over rows of colour * step * alpha * steps of every Haar coefficient at the \
                fragment's cell, alpha the coefficient of the material, or for painted ones the sum over regions of weights * mean coefficient",
            "unit": "W/(sr m^2) per unit coefficient, linear Rec. 709",
            "meta": Details::of(head),
            "rows": rows,
        }),
    )
}
