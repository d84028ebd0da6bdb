//! Sampling of directions from mixtures of a cosine lobe and Blinn-Phong lobes.
//!
//! A gather serves every basis at once, and bases have lobes of all widths; sampling any one of them would
//! leave the others to chance. A mixture of a cosine lobe and a few Blinn-Phong lobes spread over the
//! exponents comes near all of them, and as every sample is divided by the density of the whole mixture the
//! estimate is right for each.

use glam::Vec3A;
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Model, SHININESS_MAX};
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// A mixture: the cosine lobe takes what the Blinn-Phong lobes leave of the chance.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeMixture {
    /// Chance and exponent of each Blinn-Phong lobe.
    glossy: Vec<(f32, f32)>,
}

impl LobeMixture {
    /// For a matt surface.
    pub fn cosine() -> Self {
        Self { glossy: Vec::new() }
    }

    /// For a surface whose material may become anything within the space that bases span, lobes of `model` up
    /// to `sharpest`.
    ///
    /// Exponents are a factor of five apart at most; at most four times what the mixture sends is what any lobe
    /// asks for, or five and a half where there are sharper ones than usual.
    pub fn for_any_material(model: Model, sharpest: f32) -> Self {
        let mut exponents = vec![8.0, 40.0, SHININESS_MAX];
        let beyond = exponent_of(model, sharpest) / SHININESS_MAX;
        if sharpest != model.usual_sharpest() {
            let more = (beyond.ln() / 5f32.ln()).ceil().max(1.0);
            exponents.extend((1..=more as u32).map(|i| SHININESS_MAX * beyond.powf(i as f32 / more)));
        }
        let of_all = if exponents.len() > 3 { 0.75 } else { 0.6 };
        let chance = of_all / exponents.len() as f32;
        Self { glossy: exponents.into_iter().map(|exponent| (chance, exponent)).collect() }
    }

    /// For a surface that keeps its material. A share of cosine samples always stays, for it bounds every
    /// weight.
    pub fn for_material(material: &Brdf) -> Self {
        let sum = |k: [f32; 3]| k.iter().sum::<f32>();
        let (diffuse, glossy, sharpness) = match material {
            Brdf::BlinnPhong(BlinnPhong { kd, ks, shininess }) => (sum(*kd), sum(*ks), *shininess),
            Brdf::Ggx(material) => (sum(material.diffuse()), sum(material.f0()), material.roughness),
            Brdf::CookTorrance(CookTorrance { kd, ks, fresnel, roughness }) => {
                (sum(*kd), sum(*ks) * fresnel, *roughness)
            }
        };
        let exponent = exponent_of(material.model(), sharpness);
        let chance = if glossy > 0.0 { (glossy / (diffuse + glossy)).min(0.8) } else { 0.0 };
        Self { glossy: if chance > 0.0 { vec![(chance, exponent)] } else { Vec::new() } }
    }

    /// For a surface of which some light is reflected as by each of these materials: by all of them alike.
    pub fn for_materials(materials: &[Brdf]) -> Self {
        let part = 1.0 / materials.len() as f32;
        let lobes = |material: &Brdf| {
            Self::for_material(material)
                .glossy
                .into_iter()
                .map(|(chance, exponent)| (chance * part, exponent))
        };
        Self { glossy: materials.iter().flat_map(lobes).collect() }
    }

    /// A direction with its density per steradian. It may point below the surface, where it carries nothing.
    pub fn sample(&self, normal: Vec3A, outgoing: Vec3A, choice: f32, [u, v]: [f32; 2]) -> (Vec3A, f32) {
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let (sin_phi, cos_phi) = (TAU * u).sin_cos();
        let around = |cosine: f32| {
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            tangent * (sine * cos_phi) + bitangent * (sine * sin_phi) + normal * cosine
        };
        let mut below = 0.0;
        let chosen = self.glossy.iter().find(|(chance, _)| {
            below += chance;
            choice < below
        });
        let incoming = match chosen {
            Some((_, exponent)) => {
                // Half vectors of density (s+1)/2π · cosˢδ, mirrored.
                let half = around((1.0 - v).powf(1.0 / (exponent + 1.0)));
                half * (2.0 * half.dot(outgoing)) - outgoing
            }
            None => around((1.0 - v).sqrt()),
        };
        (incoming, self.density(normal, outgoing, incoming))
    }

    /// Density per steradian with which [`LobeMixture::sample`] chooses `incoming`.
    pub fn density(&self, normal: Vec3A, outgoing: Vec3A, incoming: Vec3A) -> f32 {
        let mut cosine_chance = 1.0;
        let half = (incoming + outgoing).normalize_or_zero();
        // Half vectors behind `outgoing` mirror it to below the surface; there the half vector of the two is
        // the negative of the sampled one.
        let cos_delta = half.dot(normal).abs();
        // |dω_half / dω_incoming| = 1 / (4 |ω_o·h|)
        let jacobian = 0.25 / half.dot(outgoing).abs().max(1e-6);
        let log_cos = cos_delta.ln();
        let mut density = 0.0;
        for (chance, exponent) in &self.glossy {
            cosine_chance -= chance;
            // cosˢδ, of which the logarithm is the same for all lobes.
            density += chance * (exponent + 1.0) / (2.0 * PI) * (exponent * log_cos).exp() * jacobian;
        }
        density + cosine_chance * incoming.dot(normal).max(0.0) * FRAC_1_PI
    }
}

/// The exponent of the Blinn-Phong lobe that is as wide near its peak as that of facets of slope α: s = 2/α² −
/// 2. GGX has longer tails; the cosine lobe covers them. Beckmann's facets have shorter ones.
fn exponent_of(model: Model, sharpness: f32) -> f32 {
    let slope = match model {
        Model::BlinnPhong => return sharpness,
        Model::Ggx => sharpness * sharpness,
        Model::CookTorrance => sharpness,
    };
    (2.0 / (slope * slope) - 2.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::state::Ggx;

    /// χ² over cells of direction: counts of samples against the density integrated over each cell.
    #[test]
    fn samples_follow_the_density() {
        let phong = Brdf::BlinnPhong(BlinnPhong { kd: [0.2; 3], ks: [0.6; 3], shininess: 20.0 });
        let metal = Brdf::Ggx(Ggx { base_color: [0.9; 3], metallic: 1.0, roughness: 0.5 });
        let grooves = CookTorrance { kd: [0.1; 3], ks: [0.9, 0.6, 0.3], fresnel: 0.7, roughness: 0.3 };
        for mixture in [
            LobeMixture::for_any_material(Model::BlinnPhong, 200.0),
            LobeMixture::for_any_material(Model::Ggx, 0.2),
            LobeMixture::for_material(&phong),
            LobeMixture::for_material(&metal),
            LobeMixture::for_material(&Brdf::CookTorrance(grooves)),
        ] {
            for tilt in [0.0f32, 0.7, 1.3] {
                chi_squared(&mixture, Vec3A::new(tilt.sin(), tilt.cos(), 0.0));
            }
        }
    }

    fn chi_squared(mixture: &LobeMixture, outgoing: Vec3A) {
        const ROWS: usize = 12;
        const COLUMNS: usize = 16;
        const N: usize = 1 << 20;
        let normal = Vec3A::Y;
        let mut counts = vec![0.0; ROWS * COLUMNS];
        let sampler = crate::trace::sampler::PixelSampler::new(3, 1);
        let mut random = 12345u64;
        for _ in 0..N {
            // Independent numbers: χ² assumes them, and a stratified sequence would only fit too well.
            let mut next = || {
                random =
                    random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (random >> 40) as f32 / 16_777_216.0
            };
            let (d, density) = mixture.sample(normal, outgoing, next(), [next(), next()]);
            assert!(density >= 0.0 && (d.length() - 1.0).abs() < 1e-4);
            let row = (((1.0 - d.y) * 0.5 * ROWS as f32) as usize).min(ROWS - 1);
            let column = (((d.z.atan2(d.x) / TAU + 0.5) * COLUMNS as f32) as usize).min(COLUMNS - 1);
            counts[row * COLUMNS + column] += 1.0;
        }
        let (mut statistic, mut cells) = (0.0, 0);
        // The upper hemisphere: what points below the surface carries nothing, and there the density has a
        // pole opposite to `outgoing`.
        for row in 0..ROWS / 2 {
            for column in 0..COLUMNS {
                let expected =
                    N as f64 * integrate_cell(mixture, outgoing, row, column, ROWS, COLUMNS, &sampler);
                if expected > 20.0 {
                    statistic += (counts[row * COLUMNS + column] - expected).powi(2) / expected;
                    cells += 1;
                }
            }
        }
        // χ² has mean k and variance 2k; the integral's own error adds a little.
        let bound = f64::from(cells) + 5.0 * (2.0 * f64::from(cells)).sqrt();
        assert!(statistic < bound, "χ² = {statistic} over {cells} cells, bound {bound}, outgoing {outgoing}");
    }

    fn integrate_cell(
        mixture: &LobeMixture,
        outgoing: Vec3A,
        row: usize,
        column: usize,
        rows: usize,
        columns: usize,
        sampler: &crate::trace::sampler::PixelSampler,
    ) -> f64 {
        const POINTS: u32 = 16_384;
        let mut sum = 0.0;
        for i in 0..POINTS {
            let [u, v] = sampler.sample(i).pair((row * columns + column) as u32);
            let y = 1.0 - 2.0 * (row as f32 + u) / rows as f32;
            let phi = TAU * ((column as f32 + v) / columns as f32 - 0.5);
            let r = (1.0 - y * y).max(0.0).sqrt();
            let d = Vec3A::new(r * phi.cos(), y, r * phi.sin());
            sum += f64::from(mixture.density(Vec3A::Y, outgoing, d));
        }
        sum / f64::from(POINTS) * 4.0 * std::f64::consts::PI / (rows * columns) as f64
    }
}
