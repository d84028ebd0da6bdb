//! A BRDF tensor as arrays: core, matrices, cones and their shares, and the samples.

use super::out::Out;
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::angles::{self, NODES};
use relume_formats::kinds::brdf_tensor::{Cone, Meta, Samples};
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
    /// Azimuthal order of each incoming profile.
    orders: Vec<u32>,
    /// Numbers a vertex has of each channel of light.
    columns: usize,
    cones: Vec<Cone>,
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
        columns: tensor.columns(),
        orders: tensor.orders,
        cones: tensor.cones,
        meta: tensor.meta,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let Details { samples, triangles, ranks: [a, b, c], orders, columns, cones, meta } = details;
    let between = match meta.model {
        Model::BlinnPhong => String::new(),
        Model::Ggx | Model::CookTorrance => format!(" in {triangles} triangles"),
    };
    let percent = |error: f64| format!("{:.4} %", 100.0 * error);
    let alone = [meta.materials, meta.outgoing, meta.incoming].map(percent);
    let orders: Vec<String> = orders.iter().map(u32::to_string).collect();
    vec![
        ("model", meta.model.name().to_owned()),
        ("samples", format!("{samples}{between}")),
        ("ranks", format!("{a} of materials, {b} of outgoing and {c} of incoming directions")),
        ("orders", format!("{}: {columns} columns of a vertex", orders.join(", "))),
        ("cones", format!("{} leave {} of the squared norm", cones.len(), percent(meta.residual))),
        ("error", format!("{} of it; by materials alone {}", percent(meta.whole), alone[0])),
        ("", format!("by outgoing directions {}, by incoming ones {}", alone[1], alone[2])),
    ]
}

/// `core.npy` D, `materials.npy` U^h, `outgoing.npy` U^ωo, `incoming.npy` U^ωi and `orders.npy`, `cones.npy` and
/// `shares.npy`, `even.npy`, `angles.npy` of the nodes, `exponents.npy` or `points.npy` and `triangles.npy`,
/// `tensor.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let tensor = &BrdfTensor::read_file(path)?;
    let ([a, b, c], samples) = (tensor.ranks, tensor.samples.count());
    out.npy("core.npy", &[a, b, c], tensor.core.iter().copied())?;
    out.npy("materials.npy", &[samples, a], tensor.materials.iter().copied())?;
    out.npy("outgoing.npy", &[NODES, b], tensor.outgoing.iter().copied())?;
    out.npy("incoming.npy", &[NODES, c], tensor.incoming.iter().copied())?;
    out.npy("orders.npy", &[c], tensor.orders.iter().copied())?;
    let cones = tensor.cones.iter().flat_map(|cone| [cone.width_deg, cone.tilt_deg, cone.side_deg]);
    out.npy("cones.npy", &[tensor.cones.len(), 3], cones)?;
    out.npy("shares.npy", &[samples, NODES, tensor.cones.len()], tensor.shares.iter().copied())?;
    out.npy("even.npy", &[NODES], tensor.even.iter().copied())?;
    out.npy("angles.npy", &[NODES], (0..NODES).map(|node| angles::theta(node).to_degrees() as f32))?;
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
        "formula": "f(h, o, i)*cos(i) = sum over t of shares[h,o,t]*G_t(o, i) + cos(i) * sum over a, b, c of core[a,b,c]*materials[h,a]*outgoing[o,b]*incoming[i,c]*cos(orders[c]*(azimuth of i - azimuth of o)), in 1/sr",
        "samples": samples,
        "angles": {
            "file": "angles.npy",
            "meaning": "degrees from the normal of the rows of outgoing, incoming and even and of the second axis of shares; linear between them",
        },
        "cones": {
            "file": "cones.npy",
            "columns": ["width_deg", "tilt_deg", "side_deg"],
            "meaning": "G_t: Gaussian of the angle of that standard deviation and of integral 1 over the sphere, about the mirror direction turned away from the normal by the tilt, and in halves by the side to both sides of that",
        },
        "shares": { "file": "shares.npy", "axes": ["samples", "angles", "cones"] },
        "even": { "file": "even.npy", "meaning": "what the diffuse lobe of a white surface reflects of a white sky" },
        "errors": {
            "metric": "squared norm of the harmonics of lobe times cosine, weighed by 1/(1 + band)^2, in parts of each lobe's, mean over samples",
            "left_by_cones": tensor.meta.residual,
            "materials_alone": tensor.meta.materials,
            "outgoing_alone": tensor.meta.outgoing,
            "incoming_alone": tensor.meta.incoming,
            "whole": tensor.meta.whole,
        },
    })
}
