//! A BRDF basis as arrays: the basis functions on the angle grid, coefficients of the samples that the basis
//! was made from, and the finer table of coefficients that look-ups interpolate in.

use super::out::Out;
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::basis::brdf_grid::{self, NODES, PHI_NODES, THETA_NODES};
use relume_formats::basis::microfacet::Facets;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::{BasisError, Functions};
use relume_formats::state::{Model, SHININESS_MAX};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::BrdfBasis, describe, export };

#[derive(Serialize)]
struct Details {
    bases: usize,
    model: Model,
    nodes: usize,
    /// First and last exponent, roughness or slope.
    range: [f32; 2],
    shared_diffuse: bool,
    error_at_samples: BasisError,
    error_between: BasisError,
}

fn describe(path: &Path) -> Result<Described> {
    let basis = BrdfBasis::read_file(path)?;
    let details = Details {
        bases: basis.bases(),
        model: basis.functions.model(),
        nodes: basis.parameters.len(),
        range: [basis.parameters.first(), basis.parameters.last()].map(|s| s.copied().unwrap_or(f32::NAN)),
        shared_diffuse: basis.meta.shared_diffuse,
        error_at_samples: basis.meta.error_at_samples,
        error_between: basis.meta.error_between,
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let Details {
        bases,
        model,
        nodes,
        range: [first, last],
        shared_diffuse,
        error_at_samples,
        error_between,
    } = details;
    let lobes =
        if *shared_diffuse { "lobes use the diffuse one too" } else { "lobes leave the diffuse one alone" };
    let parameter = match model {
        Model::BlinnPhong => "exponent",
        Model::Ggx => "roughness",
        Model::CookTorrance => "slope",
    };
    vec![
        ("model", model.name().to_owned()),
        ("bases", format!("{bases}, {lobes}")),
        (parameter, format!("{nodes} nodes from {first} to {last}")),
        ("error", format!("{} at the samples", error(error_at_samples))),
        ("", format!("{} between them", error(error_between))),
    ]
}

fn error(error: &BasisError) -> String {
    format!("{:.4} % mean, {:.4} % worst at {}", error.mean * 100.0, error.worst * 100.0, error.worst_at)
}

/// The samples that a basis was made from, and what a model's parameters are called.
struct Samples {
    model: &'static str,
    formula: &'static str,
    diffuse: &'static str,
    /// Meaning of the columns of `parameters`.
    columns: &'static [&'static str],
    parameters: Vec<Vec<f32>>,
    coefficients: Vec<Vec<f32>>,
    meaning: &'static str,
    /// Start of the names of the look-up table's files.
    look_up: &'static str,
    /// Parts of a lobe with coefficients of their own.
    parts: usize,
}

/// `basis.npy` [bases, θi, θo, φ] in sr⁻¹, `parameters.npy` [samples, columns], `coefficients.npy` [samples,
/// bases], the look-up table (`exponents.npy` [nodes] and `exponent_coefficients.npy` [nodes, bases], or
/// `roughnesses.npy`, `slopes.npy` [nodes] and `roughness_coefficients.npy`, `slope_coefficients.npy` [nodes,
/// 2, bases]), `brdf.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let basis = &BrdfBasis::read_file(path)?;
    let bases = basis.bases();
    let samples = samples(basis);
    out.npy("basis.npy", &[bases, THETA_NODES, THETA_NODES, PHI_NODES], on_grid(basis))?;
    let rows = samples.parameters.len();
    out.npy("parameters.npy", &[rows, samples.columns.len()], samples.parameters.iter().flatten().copied())?;
    out.npy("coefficients.npy", &[rows, bases], samples.coefficients.iter().flatten().copied())?;
    let (nodes, [parameters, coefficients]) = (basis.parameters.len(), look_up_files(&samples));
    out.npy(&parameters, &[nodes], basis.parameters.iter().copied())?;
    let shape = if samples.parts == 1 { vec![nodes, bases] } else { vec![nodes, samples.parts, bases] };
    out.npy(&coefficients, &shape, basis.coefficients.iter().copied())?;
    out.json("brdf.json", &metadata(basis, &samples))
}

fn look_up_files(samples: &Samples) -> [String; 2] {
    let name = samples.look_up;
    let plural = if name.ends_with('s') { "es" } else { "s" };
    [format!("{name}{plural}.npy"), format!("{name}_coefficients.npy")]
}

fn samples(basis: &BrdfBasis) -> Samples {
    let diffuse: Vec<f32> = (0..basis.bases()).map(|b| if b == 0 { 1.0 } else { 0.0 }).collect();
    match &basis.functions {
        Functions::BlinnPhong { .. } => {
            let is_usual = basis.sharpest() <= SHININESS_MAX;
            let exponents =
                || basis.parameters.iter().copied().filter(move |s| !is_usual || s.fract() == 0.0);
            Samples {
                model: "blinn-phong",
                formula: "rho = kd/pi + ks*(s+2)/(2*pi)*cos(delta)^s, delta between the half vector and the normal, in 1/sr",
                diffuse: "1/pi",
                columns: &["kd", "ks", "s"],
                parameters: std::iter::once(vec![1.0, 0.0, 1.0])
                    .chain(exponents().map(|s| vec![0.0, 1.0, s]))
                    .collect(),
                coefficients: std::iter::once(diffuse)
                    .chain(exponents().map(|s| basis.lobe_coefficients(0, s)))
                    .collect(),
                meaning: if is_usual {
                    "row 0 is the diffuse sample, then the unit glossy lobe of every integer exponent: the samples that the basis was made \
                     from; linear in kd and ks, interpolated linearly in s"
                } else {
                    "row 0 is the diffuse lobe, then the unit glossy lobe of every exponent of exponents.npy; linear in kd and ks, \
                     interpolated linearly in s"
                },
                look_up: "exponent",
                parts: 1,
            }
        }
        Functions::Microfacet { facets: Facets::Ggx, roughness, .. } => {
            let (parameters, coefficients) = microfacet_samples(basis, diffuse, roughness);
            Samples {
                model: "ggx",
                formula: "rho = d*(1-w)/pi + f0*D*V*(1-w) + D*V*w, w = (1 - v.h)^5, alpha = roughness^2, D Trowbridge-Reitz, V Smith's \
                          height-correlated visibility, f0 = 0.04*(1-metallic) + base_color*metallic, \
                          d = (1-f0)*(1-metallic)*base_color, in 1/sr",
                diffuse: "(1-w)/pi",
                columns: &["d", "f0", "w_part", "roughness"],
                parameters,
                coefficients,
                meaning: "row 0 is the diffuse sample, then for every sampled roughness D*V*(1-w) and D*V*w: the samples that the basis was made \
                          from; a material is d times row 0, f0 times the former and the latter once, interpolated linearly in roughness",
                look_up: "roughness",
                parts: 2,
            }
        }
        Functions::Microfacet { facets: Facets::CookTorrance, roughness, .. } => {
            let (parameters, coefficients) = microfacet_samples(basis, diffuse, roughness);
            Samples {
                model: "cook-torrance",
                formula: "rho = kd/pi + ks*fresnel*D*V*(1-w) + ks*D*V*w, w = (1 - v.h)^5, D = exp(-tan(delta)^2/m^2)/(pi*m^2*cos(delta)^4) \
                          of the slope m called roughness, delta between the half vector and the normal, V = G/(4*(n.l)*(n.v)), \
                          G = min(1, 2*(n.h)*(n.v)/(v.h), 2*(n.h)*(n.l)/(v.h)), in 1/sr",
                diffuse: "1/pi",
                columns: &["kd", "ks_fresnel", "ks", "roughness"],
                parameters,
                coefficients,
                meaning: "row 0 is the diffuse sample, then for every sampled slope D*V*(1-w) and D*V*w: the samples that the basis was made \
                          from; a material is kd times row 0, ks*fresnel times the former and ks times the latter, interpolated linearly in roughness",
                look_up: "slope",
                parts: 2,
            }
        }
    }
}

/// The diffuse sample, whose coefficients are `diffuse`, then two parts of the lobe of each of `roughness`:
/// what multiplies the diffuse lobe and both parts, with the roughness, and the coefficients.
fn microfacet_samples(
    basis: &BrdfBasis,
    diffuse: Vec<f32>,
    roughness: &[f32],
) -> (Vec<Vec<f32>>, Vec<Vec<f32>>) {
    let parts = || roughness.iter().flat_map(|r| [(0, *r), (1, *r)]);
    let row = |(part, r): (usize, f32)| {
        if part == 0 { vec![0.0, 1.0, 0.0, r] } else { vec![0.0, 0.0, 1.0, r] }
    };
    let coefficients = parts().map(|(part, r)| basis.lobe_coefficients(part, r));
    (
        std::iter::once(vec![1.0, 0.0, 0.0, 1.0]).chain(parts().map(row)).collect(),
        std::iter::once(diffuse).chain(coefficients).collect(),
    )
}

/// Row-major [bases, grid nodes].
fn on_grid(basis: &BrdfBasis) -> Vec<f32> {
    let mut grid = vec![0.0; basis.bases() * NODES];
    let mut values = vec![0.0; basis.bases()];
    for node in 0..NODES {
        let (i, o, p) = (node / (THETA_NODES * PHI_NODES), node / PHI_NODES % THETA_NODES, node % PHI_NODES);
        basis.evaluate(&brdf_grid::angles(i, o, p), &mut values);
        for (plane, value) in grid.chunks_exact_mut(NODES).zip(&values) {
            if let Some(cell) = plane.get_mut(node) {
                *cell = *value;
            }
        }
    }
    grid
}

fn metadata(basis: &BrdfBasis, samples: &Samples) -> Value {
    let theta: Vec<f64> = (0..THETA_NODES).map(brdf_grid::theta).collect();
    let phi: Vec<f64> = (0..PHI_NODES).map(brdf_grid::phi).collect();
    json!({
        "model": samples.model,
        "formula": samples.formula,
        "basis": {
            "file": "basis.npy",
            "shape": [basis.bases(), THETA_NODES, THETA_NODES, PHI_NODES],
            "meaning": format!("basis functions in 1/sr at (theta_i, theta_o, phi); basis 0 is {}", samples.diffuse),
        },
        "axes": [
            { "name": "theta_i", "unit": "rad", "values": theta },
            { "name": "theta_o", "unit": "rad", "values": theta },
            { "name": "phi", "unit": "rad", "meaning": "azimuth between the two directions", "values": phi },
        ],
        "parameters": {
            "file": "parameters.npy",
            "shape": [samples.parameters.len(), samples.columns.len()],
            "columns": samples.columns,
            "meaning": samples.meaning,
        },
        "coefficients": {
            "file": "coefficients.npy",
            "shape": [samples.coefficients.len(), basis.bases()],
            "meaning": "sample = sum over bases of coefficient * basis",
        },
        "look_up": {
            "files": look_up_files(samples),
            "meaning": "coefficients of the unit lobe at more exponents, roughnesses or slopes: what the player interpolates in",
        },
        "shared_diffuse": basis.meta.shared_diffuse,
        "errors": {
            "metric": "relative L2 of a lobe over directions",
            "at_samples": basis.meta.error_at_samples,
            "between_them": basis.meta.error_between,
        },
    })
}
