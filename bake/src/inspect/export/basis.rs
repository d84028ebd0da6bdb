//! A BRDF basis as arrays: the basis functions on the angle grid, coefficients of the samples that the basis was made from, and the finer table of
//! coefficients that look-ups interpolate in.

use super::out::Out;
use relume_formats::Result;
use relume_formats::basis::brdf_grid::{self, NODES, PHI_NODES, THETA_NODES};
use relume_formats::kinds::BrdfBasis;
use serde_json::json;

/// `basis.npy` [bases, θi, θo, φ] in sr⁻¹, `parameters.npy` [samples, 3], `coefficients.npy` [samples, bases], `exponents.npy` [nodes],
/// `exponent_coefficients.npy` [nodes, bases], `brdf.json`.
pub(super) fn export(basis: &BrdfBasis, out: &mut Out) -> Result<()> {
    let bases = basis.bases();
    out.npy("basis.npy", &[bases, THETA_NODES, THETA_NODES, PHI_NODES], on_grid(basis))?;
    let rows = || basis.shininess.iter().zip(basis.coefficients.chunks_exact(bases)).filter(|(s, _)| s.fract() == 0.0);
    let samples = 1 + rows().count();
    let glossy = rows().flat_map(|(s, _)| [0.0, 1.0, *s]);
    out.npy("parameters.npy", &[samples, 3], [1.0f32, 0.0, 1.0].into_iter().chain(glossy))?;
    let diffuse = (0..bases).map(|b| if b == 0 { 1.0 } else { 0.0 });
    out.npy("coefficients.npy", &[samples, bases], diffuse.chain(rows().flat_map(|(_, row)| row.iter().copied())))?;
    let nodes = basis.shininess.len();
    out.npy("exponents.npy", &[nodes], basis.shininess.iter().copied())?;
    out.npy("exponent_coefficients.npy", &[nodes, bases], basis.coefficients.iter().copied())?;
    out.json("brdf.json", &metadata(basis, samples))
}

/// Row-major [bases, grid nodes].
fn on_grid(basis: &BrdfBasis) -> Vec<f32> {
    let mut grid = vec![0.0; basis.bases() * NODES];
    let mut values = vec![0.0; basis.bases()];
    for node in 0..NODES {
        let (i, o, p) = (node / (THETA_NODES * PHI_NODES), node / PHI_NODES % THETA_NODES, node % PHI_NODES);
        basis.evaluate(brdf_grid::cos_half_angle(i, o, p) as f32, &mut values);
        for (plane, value) in grid.chunks_exact_mut(NODES).zip(&values) {
            if let Some(cell) = plane.get_mut(node) {
                *cell = *value;
            }
        }
    }
    grid
}

fn metadata(basis: &BrdfBasis, samples: usize) -> serde_json::Value {
    let theta: Vec<f64> = (0..THETA_NODES).map(brdf_grid::theta).collect();
    let phi: Vec<f64> = (0..PHI_NODES).map(brdf_grid::phi).collect();
    json!({
        "model": "blinn-phong",
        "formula": "rho = kd/pi + ks*(s+2)/(2*pi)*cos(delta)^s, delta between the half vector and the normal, in 1/sr",
        "basis": {
            "file": "basis.npy",
            "shape": [basis.bases(), THETA_NODES, THETA_NODES, PHI_NODES],
            "meaning": "basis functions in 1/sr at (theta_i, theta_o, phi); basis 0 is 1/pi",
        },
        "axes": [
            { "name": "theta_i", "unit": "rad", "values": theta },
            { "name": "theta_o", "unit": "rad", "values": theta },
            { "name": "phi", "unit": "rad", "meaning": "azimuth between the two directions", "values": phi },
        ],
        "parameters": {
            "file": "parameters.npy",
            "shape": [samples, 3],
            "columns": ["kd", "ks", "s"],
            "meaning": "row 0 is the diffuse sample, then the unit glossy lobe of every integer exponent: the samples that the basis was made from",
        },
        "coefficients": {
            "file": "coefficients.npy",
            "shape": [samples, basis.bases()],
            "meaning": "sample = sum over bases of coefficient * basis; linear in kd and ks, interpolated linearly in s",
        },
        "look_up": {
            "files": ["exponents.npy", "exponent_coefficients.npy"],
            "meaning": "coefficients of the unit glossy lobe at more exponents: what the player interpolates in",
        },
        "shared_diffuse": basis.meta.shared_diffuse,
        "errors": {
            "metric": "relative L2 of a sample over the angle grid",
            "at_integer_exponents": basis.meta.error_at_integers,
            "between_them": basis.meta.error_between,
        },
    })
}
