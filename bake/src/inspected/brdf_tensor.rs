//! A BRDF tensor as arrays: core, matrices, shares of mirror terms, and the samples.

use super::out::Out;
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::basis::disc::{self, CELLS, RINGS};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::{Meta, Samples};
use relume_formats::state::Model;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::BrdfTensor, describe, export };

#[derive(Serialize)]
struct Details {
    samples: usize,
    triangles: usize,
    /// Columns of materials, outgoing and incoming directions.
    ranks: [usize; 3],
    /// Of mirror terms.
    widths_deg: Vec<f32>,
    #[serde(flatten)]
    meta: Meta,
}

fn describe(path: &Path) -> Result<Described> {
    let tensor = BrdfTensor::read_file(path)?;
    let triangles = match &tensor.samples {
        Samples::Line(_) => 0,
        Samples::Plane { triangles, .. } => triangles.len(),
    };
    let details = Details {
        samples: tensor.samples.count(),
        triangles,
        ranks: tensor.ranks,
        widths_deg: tensor.widths_deg,
        meta: tensor.meta,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(Details { samples, triangles, ranks: [a, b, c], widths_deg, meta }: &Details) -> Facts {
    let between = match meta.model {
        Model::BlinnPhong => String::new(),
        Model::Ggx | Model::CookTorrance => format!(" in {triangles} triangles"),
    };
    let percent = |error: f64| format!("{:.4} %", 100.0 * error);
    let alone = [meta.materials, meta.outgoing, meta.incoming].map(percent);
    let widths: Vec<String> = widths_deg.iter().map(|width| format!("{width}°")).collect();
    vec![
        ("model", meta.model.name().to_owned()),
        ("samples", format!("{samples}{between}")),
        ("ranks", format!("{a} of materials, {b} of outgoing and {c} of incoming directions")),
        (
            "mirror",
            format!("terms of {} leave {} of the squared norm", widths.join(", "), percent(meta.residual)),
        ),
        ("error", format!("{} of it; by materials alone {}", percent(meta.whole), alone[0])),
        ("", format!("by outgoing directions {}, by incoming ones {}", alone[1], alone[2])),
    ]
}

/// `core.npy` D, `materials.npy` U^h, `outgoing.npy` U^ωo, `incoming.npy` the diffuse lobe and U^ωi,
/// `mirror.npy`, `directions.npy` and `weights.npy` of the cells, `exponents.npy` or `points.npy` and
/// `triangles.npy`, `tensor.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let tensor = &BrdfTensor::read_file(path)?;
    let ([a, b, c], samples) = (tensor.ranks, tensor.samples.count());
    out.npy("core.npy", &[a, b, c], tensor.core.iter().copied())?;
    out.npy("materials.npy", &[samples, a], tensor.materials.iter().copied())?;
    out.npy("outgoing.npy", &[CELLS, b], tensor.outgoing.iter().copied())?;
    out.npy("incoming.npy", &[CELLS, 1 + c], tensor.incoming.iter().copied())?;
    out.npy("mirror.npy", &[samples, RINGS, tensor.widths_deg.len()], tensor.mirror.iter().copied())?;
    let directions = (0..CELLS).flat_map(|cell| disc::direction(cell).as_vec3().to_array());
    out.npy("directions.npy", &[CELLS, 3], directions)?;
    out.npy("weights.npy", &[CELLS], (0..CELLS).map(|cell| disc::weight(cell / disc::AZIMUTHS) as f32))?;
    match &tensor.samples {
        Samples::Line(exponents) => out.npy("exponents.npy", &[samples], exponents.iter().copied())?,
        Samples::Plane { points, triangles } => {
            out.npy("points.npy", &[samples, 2], points.as_flattened().iter().copied())?;
            out.npy("triangles.npy", &[triangles.len(), 3], triangles.as_flattened().iter().copied())?;
        }
    }
    out.json("tensor.json", &metadata(tensor))
}

fn metadata(tensor: &BrdfTensor) -> Value {
    let samples = match &tensor.samples {
        Samples::Line(_) => json!({ "exponents": "exponents.npy", "meaning": "between them linear" }),
        Samples::Plane { .. } => json!({
            "points": "points.npy",
            "triangles": "triangles.npy",
            "meaning": "reflectance at normal incidence, and roughness or slope; barycentric in reflectance and ln roughness",
        }),
    };
    json!({
        "model": tensor.meta.model,
        "formula": "f(h, o, i) = sum over a, b, c of core[a,b,c]*materials[h,a]*outgoing[o,b]*incoming[i,1+c], in 1/sr without the cosine, plus mirror terms",
        "samples": samples,
        "cells": {
            "directions": "directions.npy",
            "weights": "weights.npy",
            "meaning": "unit vectors about the normal +Z; weights are solid angle times cosine; columns are orthonormal with them",
        },
        "incoming": { "file": "incoming.npy", "meaning": "column 0 is the diffuse lobe, 1/pi" },
        "mirror": {
            "file": "mirror.npy",
            "shape": ["samples", "rings", "terms"],
            "radii": (0..RINGS).map(disc::radius).collect::<Vec<f64>>(),
            "widths_deg": tensor.widths_deg,
            "meaning": "share of the radiance, filtered by a Gaussian of that standard deviation about the mirror direction, that is reflected",
        },
        "errors": {
            "metric": "squared norm over directions with both cosines, in parts of each lobe's, mean over samples",
            "left_by_mirror_terms": tensor.meta.residual,
            "materials_alone": tensor.meta.materials,
            "outgoing_alone": tensor.meta.outgoing,
            "incoming_alone": tensor.meta.incoming,
            "whole": tensor.meta.whole,
        },
    })
}
